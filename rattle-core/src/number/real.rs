//! The traits of numbers in which kernels, effects, systems and methods are generic.
//!
//! [`Real`] has the operations that generated kernels call. `f64` implements it; a block of SIMD lanes or a dual number
//! can too. Comparisons give a [`Mask`], and kernels and effects branch by selection, so that lanes can take different
//! branches in one instruction stream. Systems and methods move one trajectory: they are generic in a [`Scalar`], a
//! single number.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// The outcome of a comparison: `bool` for one number, one bit per lane for several.
pub trait Mask: Copy + Debug {
    /// True in every lane.
    fn all(self) -> bool;
    /// Lane-wise and.
    fn and(self, other: Self) -> Self;
    /// Lane-wise or.
    fn or(self, other: Self) -> Self;
    /// Lane-wise not.
    fn not(self) -> Self;
    /// The lanes in order; one for a plain scalar.
    fn lanes(self) -> impl Iterator<Item = bool>;
}

impl Mask for bool {
    #[inline(always)]
    fn all(self) -> bool {
        self
    }
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        self & other
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        self | other
    }
    #[inline(always)]
    fn not(self) -> Self {
        !self
    }
    #[inline(always)]
    fn lanes(self) -> impl Iterator<Item = bool> {
        std::iter::once(self)
    }
}

/// A function of the number in each lane.
#[inline(always)]
pub(crate) fn each_lane<T: Real>(x: T, function: impl Fn(f64) -> f64) -> T {
    T::from_lanes(|lane| function(x.lanes().nth(lane).unwrap_or(f64::NAN)))
}

/// A real number, or an array of them (lanes).
///
/// Arithmetic and `sqrt` round once (IEEE 754); the other functions are those of the scalar's own
/// library. Nothing here panics: outside its domain a function gives NaN.
pub trait Real:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Send
    + Sync
    + 'static
{
    /// The result of a comparison.
    type Mask: Mask;
    /// The distance from 1 to the next number; by default that of `f64`.
    const EPSILON: f64 = f64::EPSILON;

    /// The same number in every lane.
    fn from_f64(x: f64) -> Self;
    /// The number `lane(i)` in each lane i; `lane(0)` for a plain scalar.
    #[inline(always)]
    fn from_lanes(lane: impl Fn(usize) -> f64) -> Self {
        Self::from_f64(lane(0))
    }
    /// The numbers of the lanes in order; one for a plain scalar.
    fn lanes(self) -> impl Iterator<Item = f64>;

    /// `self < other`, false where either is NaN.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self ≤ other`, false where either is NaN.
    fn le(self, other: Self) -> Self::Mask;
    /// `a` where the mask is true, else `b`; the side not taken has no influence, NaN or not.
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;

    /// The vectors as vectors of `f64`, if `Self` is one; otherwise `None`.
    #[inline(always)]
    fn doubles<const D: usize>(_vectors: &[[Self; D]]) -> Option<&[[f64; D]]> {
        None
    }
    /// As [`doubles`](Self::doubles), mutable.
    #[inline(always)]
    fn doubles_mut<const D: usize>(_vectors: &mut [[Self; D]]) -> Option<&mut [[f64; D]]> {
        None
    }

    /// self · b + c, rounded after each operation, or once at the end by scalars with fused multiply-add.
    #[inline(always)]
    fn multiply_add(self, b: Self, c: Self) -> Self {
        self * b + c
    }

    /// |x|.
    fn abs(self) -> Self;
    /// −1, 0 or 1 by sign; 0 at both zeros, NaN for NaN.
    fn sign(self) -> Self;
    /// The largest integer that is not above x.
    fn floor(self) -> Self;
    /// √x.
    fn sqrt(self) -> Self;
    /// ∛x, odd.
    fn cbrt(self) -> Self;
    /// eˣ.
    fn exp(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// Logarithm to base 10.
    fn log10(self) -> Self;
    /// Logarithm to base 2.
    fn log2(self) -> Self;
    /// sin x.
    fn sin(self) -> Self;
    /// cos x.
    fn cos(self) -> Self;
    /// (sin x, cos x).
    fn sin_cos(self) -> (Self, Self);
    /// tan x.
    fn tan(self) -> Self;
    /// arcsin x.
    fn asin(self) -> Self;
    /// arccos x.
    fn acos(self) -> Self;
    /// arctan x.
    fn atan(self) -> Self;
    /// sinh x.
    fn sinh(self) -> Self;
    /// cosh x.
    fn cosh(self) -> Self;
    /// tanh x.
    fn tanh(self) -> Self;
    /// arsinh x.
    fn asinh(self) -> Self;
    /// arcosh x.
    fn acosh(self) -> Self;
    /// artanh x.
    fn atanh(self) -> Self;
    /// The error function (2/√π) ∫₀ˣ exp(−t²) dt.
    fn erf(self) -> Self;
    /// xʸ for a real exponent.
    fn powf(self, exponent: Self) -> Self;
    /// The angle of the point (x, y), where `self` is y.
    fn atan2(self, x: Self) -> Self;
    /// √(x² + y²) without overflow on the way.
    fn hypot(self, y: Self) -> Self;
    /// The smaller one; `self` on a tie.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(other.lt(self), other, self)
    }
    /// The larger one; `self` on a tie.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(self.lt(other), other, self)
    }
}

/// A single real number: comparisons are true or false, so that code may branch. Systems and methods are generic in it.
pub trait Scalar: Real<Mask = bool> {
    /// The nearest `f64`.
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self.lanes().next().unwrap_or(f64::NAN)
    }
}

impl<T: Real<Mask = bool>> Scalar for T {}

macro_rules! real_float {
    ($float:ident, $erf:path $(, $doubles:ident)?) => {
        impl Real for $float {
            type Mask = bool;
            const EPSILON: f64 = $float::EPSILON as f64;

            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                x as $float
            }
            #[inline(always)]
            fn lanes(self) -> impl Iterator<Item = f64> {
                std::iter::once(f64::from(self))
            }
            #[inline(always)]
            fn lt(self, other: Self) -> bool {
                self < other
            }
            #[inline(always)]
            fn le(self, other: Self) -> bool {
                self <= other
            }
            #[inline(always)]
            fn select(mask: bool, a: Self, b: Self) -> Self {
                if mask { a } else { b }
            }
            #[inline(always)]
            fn sign(self) -> Self {
                if self > 0.0 {
                    1.0
                } else if self < 0.0 {
                    -1.0
                } else {
                    self * 0.0 // 0 stays 0, NaN stays NaN
                }
            }
            $(real_float!(@$doubles);)?
            #[inline(always)]
            fn erf(self) -> Self {
                $erf(self)
            }
            real_float!(@inherent $float: abs floor sqrt cbrt exp ln log10 log2 sin cos tan asin acos atan
                sinh cosh tanh asinh acosh);
            #[inline(always)]
            fn atanh(self) -> Self {
                $float::atanh(self.abs()).copysign(self) // near −1 that of the standard library cancels
            }
            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                $float::sin_cos(self)
            }
            #[inline(always)]
            fn powf(self, exponent: Self) -> Self {
                $float::powf(self, exponent)
            }
            #[inline(always)]
            fn atan2(self, x: Self) -> Self {
                $float::atan2(self, x)
            }
            #[inline(always)]
            fn hypot(self, y: Self) -> Self {
                $float::hypot(self, y)
            }
        }
    };
    (@doubles) => {
        #[inline(always)]
        fn doubles<const D: usize>(vectors: &[[Self; D]]) -> Option<&[[f64; D]]> {
            Some(vectors)
        }
        #[inline(always)]
        fn doubles_mut<const D: usize>(vectors: &mut [[Self; D]]) -> Option<&mut [[f64; D]]> {
            Some(vectors)
        }
    };
    (@inherent $float:ident: $($name:ident)*) => {
        $(#[inline(always)]
        fn $name(self) -> Self {
            $float::$name(self)
        })*
    };
}

real_float!(f64, libm::erf, doubles);
real_float!(f32, libm::erff);
