//! Scalars of ensembles: a number with fused multiply-add, and arrays of such numbers (SIMD lanes).
//!
//! [`Fused`] is one number. Compilers turn loops over arrays of it into SIMD instructions, so no SIMD type is needed.
//! [`Lanes`] is such an array as a scalar of its own, with one trajectory in each lane; all code outside the inner
//! loops uses it.
//!
//! **Functions** of a [`Fused`] number, all that kernels call, are straight-line code that vectorises, with the same
//! bits on every processor. The table gives for each the nanoseconds per number in a loop over 64 numbers, those of the
//! system's library, on a core of an AMD EPYC with AVX-512 (`cargo bench --bench kernels functions`), and the largest
//! error found in 250 000 arguments, in units of the last place:
//!
//! ```text
//!       ours  library error         ours  library error         ours  library error
//! exp   0.40    2.4    1.1    asin  0.41    2.8    1.2    log2  0.67    2.4    0.8
//! ln    0.52    2.1    0.8    acos  0.41    3.0    1.2    log10 0.72    4.1    0.7
//! sin   0.61    7.6    0.9    atan  0.73    7.0    0.9    powf  2.6     8.1    0.8
//! cos   0.61    7.6    0.8    atan2 1.2     9.5    0.8    cbrt  0.84    9.6    0.5
//! tan   1.0     8.0    0.9    asinh 1.5    14.9    1.2    hypot 0.27    3.2    1.0
//! sinh  0.96    7.6    1.7    acosh 1.3     4.0    1.5    erf   1.1    12.5    1.7
//! cosh  0.47    3.7    1.4    atanh 1.2     5.2    1.1
//! tanh  0.73    6.7    1.4
//! ```
//!
//! The errors of sin, cos and tan are those for arguments up to 4·10⁵; beyond 2⁴⁰ these functions are NaN. Values of
//! exp below the normal numbers, 2·10⁻³⁰⁸, are 0.
//!
//! In single precision exp, ln, sin, cos, sinh, cosh and tanh have code of their own, with errors of 0.9, 0.8, 1.5,
//! 1.5, 1.7, 1.4 and 1.3, in a third of the time. The other functions are those of double precision, rounded.

use crate::number::functions::{self, single};
use crate::number::instructions::{InstructionSet, Work};
use crate::number::real::{Mask, Real, Scalar};
use std::cell::{Cell, RefCell};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number of one lane: [`Fused`], or a plain float.
pub trait Lane: Scalar + Default + PartialEq {
    /// Runs work over such numbers, with this instruction set if it fuses multiply-adds as the numbers do.
    #[doc(hidden)]
    fn run<W: Work>(set: InstructionSet, work: W) -> W::Done;
}

/// Neither infinite nor NaN.
#[inline(always)]
pub(crate) fn is_finite<S: Lane>(x: S) -> bool {
    let zero = x * S::default(); // or NaN
    zero.le(zero)
}

/// A float whose x·y + z is rounded once, with the same bits on every processor: fast where there is an instruction for
/// it, slow elsewhere.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(transparent)]
pub struct Fused<F>(pub F);

/// L numbers side by side.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))] // cache lines, and the widest registers
pub struct Lanes<S, const L: usize>(pub [S; L]);

/// What each lane becomes. A loop: of many lanes `array::from_fn` is a call, compiled for no instruction set.
#[inline(always)]
fn each<X: Copy, const L: usize>(first: X, of: impl Fn(usize) -> X) -> [X; L] {
    let mut all = [first; L];
    for (l, x) in all.iter_mut().enumerate() {
        *x = of(l);
    }
    all
}

/// The kernel of lanes of which lane i is the kernel `lane(i)`; `numbers` shows the numbers of a kernel in turn, and
/// `map` replaces them in the same order.
///
/// Kernels are made one by one, since the code that makes one, with every number an array, would want megabytes of
/// stack where hundreds of numbers depend on parameters and nothing is optimised.
pub(crate) fn side_by_side<S: Lane, K, R, const L: usize>(
    lane: impl Fn(usize) -> K,
    numbers: impl Fn(&K, &dyn Fn(&S) -> S),
    map: impl FnOnce(&K, &dyn Fn(&S) -> Lanes<S, L>) -> R,
) -> R {
    let all = RefCell::new(Vec::new());
    for i in 0..L {
        numbers(&lane(i), &|&number| {
            all.borrow_mut().push(number);
            number
        });
    }
    let (all, next) = (all.into_inner(), Cell::new(0));
    let of_each = all.len() / L;
    map(&lane(0), &|_| {
        let place = next.replace(next.get() + 1);
        Lanes(each(S::default(), |i| all[i * of_each + place]))
    })
}

/// The outcome of a comparison of [`Lanes`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Marks<const L: usize>(pub [bool; L]);

impl<S: Lane, const L: usize> Lanes<S, L> {
    /// The same with lane `to` like lane `from`.
    pub(crate) fn copied(mut self, from: usize, to: usize) -> Self {
        self.0[to] = self.0[from];
        self
    }
}

impl<const L: usize> Mask for Marks<L> {
    #[inline(always)]
    fn all(self) -> bool {
        self.0 == [true; L]
    }
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        Self(each(false, |i| self.0[i] & other.0[i]))
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        Self(each(false, |i| self.0[i] | other.0[i]))
    }
    #[inline(always)]
    fn not(self) -> Self {
        Self(each(false, |i| !self.0[i]))
    }
    fn lanes(self) -> impl Iterator<Item = bool> {
        self.0.into_iter()
    }
}

macro_rules! operators {
    ($($operator:ident $method:ident)*) => {$(
        impl<F: $operator<Output = F>> $operator for Fused<F> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }
        impl<S: Lane, const L: usize> $operator for Lanes<S, L> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(each(S::default(), |i| self.0[i].$method(other.0[i])))
            }
        }
    )*};
}
operators!(Add add Sub sub Mul mul Div div);

impl<F: Neg<Output = F>> Neg for Fused<F> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl<S: Lane, const L: usize> Neg for Lanes<S, L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(each(S::default(), |i| -self.0[i]))
    }
}

/// Functions of one number, by name.
macro_rules! each_function {
    ($do:ident $($with:tt)*) => {
        $do!($($with)* abs sign floor sqrt cbrt exp ln log10 log2 sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh erf);
    };
}

/// Those of a [`Fused`] number: instructions of the processor, and functions of a module.
macro_rules! of_the_float {
    ($functions:ident: abs sign floor sqrt $($name:ident)*) => {
        of_the_float!(@its_own abs sign floor sqrt);
        $(#[inline(always)]
        fn $name(self) -> Self {
            Self($functions::$name(self.0))
        })*
    };
    (@its_own $($name:ident)*) => {
        $(#[inline(always)]
        fn $name(self) -> Self {
            Self(Real::$name(self.0))
        })*
    };
}

/// Functions of two numbers.
macro_rules! of_two_floats {
    ($functions:ident: $($name:ident)*) => {
        $(#[inline(always)]
        fn $name(self, other: Self) -> Self {
            Self($functions::$name(self.0, other.0))
        })*
    };
}

macro_rules! fused_float {
    ($float:ident, $functions:ident) => {
        impl Real for Fused<$float> {
            type Mask = bool;
            const EPSILON: f64 = $float::EPSILON as f64;
            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                Self(x as $float)
            }
            #[inline(always)]
            fn lanes(self) -> impl Iterator<Item = f64> {
                #[allow(clippy::useless_conversion, reason = "of doubles")]
                std::iter::once(f64::from(self.0))
            }
            #[inline(always)]
            fn lt(self, other: Self) -> bool {
                self.0 < other.0
            }
            #[inline(always)]
            fn le(self, other: Self) -> bool {
                self.0 <= other.0
            }
            #[inline(always)]
            fn select(mask: bool, a: Self, b: Self) -> Self {
                if mask { a } else { b }
            }
            #[inline(always)]
            fn multiply_add(self, b: Self, c: Self) -> Self {
                Self(self.0.mul_add(b.0, c.0))
            }
            each_function!(of_the_float $functions:);
            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                let (sine, cosine) = $functions::sin_cos(self.0);
                (Self(sine), Self(cosine))
            }
            of_two_floats!($functions: powf atan2 hypot);
        }

        impl Lane for Fused<$float> {
            #[inline(always)]
            fn run<W: Work>(set: InstructionSet, work: W) -> W::Done {
                set.run(work)
            }
        }

        impl Lane for $float {
            #[inline(always)]
            fn run<W: Work>(_: InstructionSet, work: W) -> W::Done {
                work.run() // not compiled for sets that fuse, where no plain numbers go
            }
        }
    };
}
fused_float!(f64, functions);
fused_float!(f32, single);

macro_rules! of_each_lane {
    ($($name:ident)*) => {
        $(#[inline(always)]
        fn $name(self) -> Self {
            Self(each(S::default(), |i| Real::$name(self.0[i])))
        })*
    };
}

impl<S: Lane, const L: usize> Real for Lanes<S, L> {
    type Mask = Marks<L>;
    const EPSILON: f64 = S::EPSILON;
    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        Self([S::from_f64(x); L])
    }
    #[inline(always)]
    fn from_lanes(lane: impl Fn(usize) -> f64) -> Self {
        Self(each(S::default(), |i| S::from_f64(lane(i))))
    }
    fn lanes(self) -> impl Iterator<Item = f64> {
        self.0.into_iter().map(S::to_f64)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Marks<L> {
        Marks(each(false, |i| self.0[i].lt(other.0[i])))
    }
    #[inline(always)]
    fn le(self, other: Self) -> Marks<L> {
        Marks(each(false, |i| self.0[i].le(other.0[i])))
    }
    #[inline(always)]
    fn select(mask: Marks<L>, a: Self, b: Self) -> Self {
        Self(each(S::default(), |i| S::select(mask.0[i], a.0[i], b.0[i])))
    }
    #[inline(always)]
    fn multiply_add(self, b: Self, c: Self) -> Self {
        Self(each(S::default(), |i| self.0[i].multiply_add(b.0[i], c.0[i])))
    }
    each_function!(of_each_lane);
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let mut both = (self, self);
        for l in 0..L {
            (both.0.0[l], both.1.0[l]) = self.0[l].sin_cos();
        }
        both
    }
    #[inline(always)]
    fn powf(self, exponent: Self) -> Self {
        Self(each(S::default(), |i| self.0[i].powf(exponent.0[i])))
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        Self(each(S::default(), |i| self.0[i].atan2(x.0[i])))
    }
    #[inline(always)]
    fn hypot(self, y: Self) -> Self {
        Self(each(S::default(), |i| self.0[i].hypot(y.0[i])))
    }
}
