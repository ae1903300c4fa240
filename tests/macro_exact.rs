//! The generated functions over other scalars: exact fractions, dual numbers, complex numbers.
//!
//! Over fractions every rounding vanishes, so for polynomials and rational functions the derivative of
//! the generated value (by dual numbers) must *equal* the generated derivative: the bound is zero.

use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle::kernel::*;
use rattle::prelude::*;
use rattle::real::Real;
use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A fraction; running out of 128 bits is a panic of the test, not a rounding.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Exact {
    above: i128,
    below: i128,
}

fn gcd(a: i128, b: i128) -> i128 {
    if b == 0 { a.abs() } else { gcd(b, a % b) }
}

impl Exact {
    fn new(above: i128, below: i128) -> Exact {
        let divisor = gcd(above, below) * below.signum();
        assert!(divisor != 0, "division by zero");
        Exact { above: above / divisor, below: below / divisor }
    }
    fn times(a: i128, b: i128) -> i128 {
        a.checked_mul(b).expect("the fraction fits into 128 bits")
    }
}
impl Add for Exact {
    type Output = Exact;
    fn add(self, o: Exact) -> Exact {
        let common = gcd(self.below, o.below);
        let (a, b) = (Exact::times(self.above, o.below / common), Exact::times(o.above, self.below / common));
        Exact::new(a.checked_add(b).expect("the sum fits"), Exact::times(self.below, o.below / common))
    }
}
impl Mul for Exact {
    type Output = Exact;
    fn mul(self, o: Exact) -> Exact {
        let (a, b) = (Exact::new(self.above, o.below), Exact::new(o.above, self.below));
        Exact::new(Exact::times(a.above, b.above), Exact::times(a.below, b.below))
    }
}
impl Div for Exact {
    type Output = Exact;
    #[allow(clippy::suspicious_arithmetic_impl, reason = "division is multiplication by the reciprocal")]
    fn div(self, o: Exact) -> Exact {
        self * Exact::new(o.below, o.above)
    }
}
impl Neg for Exact {
    type Output = Exact;
    fn neg(self) -> Exact {
        Exact { above: -self.above, ..self }
    }
}
impl Sub for Exact {
    type Output = Exact;
    fn sub(self, o: Exact) -> Exact {
        self + -o
    }
}

/// a + b ε with ε² = 0.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Dual<T> {
    a: T,
    b: T,
}
impl<T: Real> Add for Dual<T> {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Dual { a: self.a + o.a, b: self.b + o.b }
    }
}
impl<T: Real> Sub for Dual<T> {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Dual { a: self.a - o.a, b: self.b - o.b }
    }
}
impl<T: Real> Mul for Dual<T> {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Dual { a: self.a * o.a, b: self.a * o.b + self.b * o.a }
    }
}
impl<T: Real> Div for Dual<T> {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        Dual { a: self.a / o.a, b: (self.b * o.a - self.a * o.b) / (o.a * o.a) }
    }
}
impl<T: Real> Neg for Dual<T> {
    type Output = Self;
    fn neg(self) -> Self {
        Dual { a: -self.a, b: -self.b }
    }
}

/// For the complex step: f(x + i h) = f(x) + i h f′(x) + O(h²), without a difference.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Complex {
    re: f64,
    im: f64,
}
impl Add for Complex {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Complex { re: self.re + o.re, im: self.im + o.im }
    }
}
impl Sub for Complex {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Complex { re: self.re - o.re, im: self.im - o.im }
    }
}
impl Mul for Complex {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Complex { re: self.re * o.re - self.im * o.im, im: self.re * o.im + self.im * o.re }
    }
}
impl Div for Complex {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        let n = o.re * o.re + o.im * o.im;
        Complex { re: (self.re * o.re + self.im * o.im) / n, im: (self.im * o.re - self.re * o.im) / n }
    }
}
impl Neg for Complex {
    type Output = Self;
    fn neg(self) -> Self {
        Complex { re: -self.re, im: -self.im }
    }
}

macro_rules! absent {
    ($($name:ident)*) => { $(fn $name(self) -> Self { unreachable!("not in these tests") })* };
}
macro_rules! scalar {
    ([$($generics:tt)*] $type:ty, $from:expr, $less:expr, { $($function:item)* } absent $($name:ident)*) => {
        impl<$($generics)*> Real for $type {
            type Mask = bool;
            fn from_f64(x: f64) -> Self {
                let from: fn(f64) -> Self = $from;
                from(x)
            }
            fn lanes(self) -> impl Iterator<Item = f64> {
                std::iter::empty()
            }
            fn lt(self, other: Self) -> bool {
                let less: fn(Self, Self) -> bool = $less;
                less(self, other)
            }
            fn le(self, other: Self) -> bool {
                !other.lt(self)
            }
            fn select(mask: bool, a: Self, b: Self) -> Self {
                if mask { a } else { b }
            }
            fn sin_cos(self) -> (Self, Self) {
                (self.sin(), self.cos())
            }
            fn powf(self, _: Self) -> Self {
                unreachable!("not in these tests")
            }
            fn atan2(self, _: Self) -> Self {
                unreachable!("not in these tests")
            }
            fn hypot(self, _: Self) -> Self {
                unreachable!("not in these tests")
            }
            $($function)*
            absent!($($name)*);
        }
    };
}
scalar!([] Exact, |x| {
    let bits = 20; // enough for the numbers in these formulas
    let scaled = x * f64::from(1 << bits);
    assert_eq!(scaled.fract(), 0.0, "{x} is a fraction of few bits");
    Exact::new(scaled as i128, 1 << bits)
}, |a, b| (a - b).above < 0, {}
    absent abs sign floor sqrt cbrt exp ln log10 log2 sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh erf);
scalar!([T: Real] Dual<T>, |x| Dual { a: T::from_f64(x), b: T::from_f64(0.0) }, |a, b| {
    use rattle::real::Mask;
    a.a.lt(b.a).all()
}, {}
    absent abs sign floor sqrt cbrt exp ln log10 log2 sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh erf);
scalar!([] Complex, |x| Complex { re: x, im: 0.0 }, |a, b| a.re < b.re, {
    fn sqrt(self) -> Self {
        let root = self.re.sqrt(); // to first order in the tiny imaginary part, as all of these
        Complex { re: root, im: self.im / (2.0 * root) }
    }
    fn exp(self) -> Self {
        Complex { re: self.re.exp(), im: self.re.exp() * self.im }
    }
    fn ln(self) -> Self {
        Complex { re: self.re.ln(), im: self.im / self.re }
    }
    fn sin(self) -> Self {
        Complex { re: self.re.sin(), im: self.re.cos() * self.im }
    }
    fn cos(self) -> Self {
        Complex { re: self.re.cos(), im: -self.re.sin() * self.im }
    }
    fn tanh(self) -> Self {
        Complex { re: self.re.tanh(), im: self.im / self.re.cosh().powi(2) }
    }
} absent abs sign floor cbrt log10 log2 tan asin acos atan sinh cosh asinh acosh atanh erf);

constraint! {
    /// The Bernoulli lemniscate.
    pub struct Lemniscate { a, r }
    |x, y, z| { let f = (x^2 + y^2)^2 - a^2 * (x^2 - y^2); f^2 + z^2 - r^2 }
}
constraint! {
    /// A torus.
    pub struct Torus { major, minor }
    |x, y, z| (x^2 + y^2 + z^2 + major^2 - minor^2)^2 - 4 * major^2 * (x^2 + y^2)
}
constraint! {
    /// Clebsch's cubic.
    pub struct Clebsch {}
    |x, y, z| 81 * (x^3 + y^3 + z^3) - 189 * (x^2 * (y + z) + y^2 * (x + z) + z^2 * (x + y)) + 54 * x * y * z
        + 126 * (x * y + x * z + y * z) - 9 * (x^2 + y^2 + z^2) - 9 * (x + y + z) + 1
}
constraint! {
    /// A heart, of odd powers and fractions.
    pub struct Heart {}
    |x, y, z| (x^2 + 9/4 * y^2 + z^2 - 1)^3 - x^2 * z^3 - 9/80 * y^2 * z^3
}
constraint! {
    /// An ellipsoid.
    pub struct Ellipsoid { a, b, c }
    |x, y, z| (x / a)^2 + y^2 / b^2 + z * z / (c * c) - 1
}
constraint! {
    /// Quotients of everything.
    pub struct Rational { c }
    |x, y, z| 1 / (x^2 + c) - y / (x * z) + (y - c)^-3 * x^5 + x / y / z
}
constraint! {
    /// Branches and a product.
    pub struct Branches {}
    |x, y, z| if x < y { x^3 * y } else { z / x } + max(x * y, z^2) + product(i in 1..4, x - i * y)
}
constraint! {
    /// Orthogonal matrices.
    pub struct Orthogonal {}
    |m: [[f64; 2]; 2]| for i in 0..2, j in i..2 { sum(k in 0..2, m[k][i] * m[k][j]) - delta(i, j) }
}
constraint! {
    /// Analytic functions.
    pub struct Analytic { k }
    |x, y, z| [
        sin(k * x) * cos(y) + sin(y) * cos(z) + exp(-x^2 / 2) * tanh(z),
        (sqrt(x^2 + y^2) - k)^2 + ln(z^2 + 1) + (x^2 + z^2 + 1)^(3/2),
    ]
}

fn check<const D: usize, const M: usize, C: Constraint<D, M>>(name: &str, constraint: &C) {
    let mut generator = StdRng::seed_from_u64(8);
    let mut checked = 0;
    for _ in 0..100 {
        let mut odd = || Exact::new(2 * generator.random_range(-8..8) + 1, 4); // never zero
        let q: [Exact; D] = std::array::from_fn(|_| odd());
        let v: [Exact; D] = std::array::from_fn(|_| odd());
        let weights: [Exact; M] = std::array::from_fn(|_| odd());
        if D >= 3
            && (0..D).any(|i| (0..i).any(|j| q[i] == q[j] || q[i] * q[j] == q[(i + 1) % D] * q[(i + 1) % D]))
        {
            continue; // ties of branches, and poles, have tests of their own
        }
        checked += 1;
        let plain = constraint.kernel::<Exact>();
        let dual = constraint.kernel::<Dual<Exact>>();
        let twice = constraint.kernel::<Dual<Dual<Exact>>>();
        let (value, jacobian) = plain.value_and_jacobian(&q);
        assert_eq!(value, plain.value(&q), "{name}");
        assert_eq!(jacobian, plain.jacobian(&q), "{name}");
        let (products, hessian) = (plain.hessian_vector(&q, &v), plain.hessian(&q));
        let zero = Exact::from_f64(0.0);
        for k in 0..D {
            let unit = |j: usize| if j == k { Exact::from_f64(1.0) } else { zero };
            let moved: [Dual<Exact>; D] = std::array::from_fn(|j| Dual { a: q[j], b: unit(j) });
            let by_k = dual.value(&moved);
            let rows = dual.jacobian(&moved);
            for i in 0..M {
                assert_eq!(by_k[i].b, jacobian[i][k], "{name}: ∂g{i}/∂q{k} at {q:?}");
                for j in 0..D {
                    assert_eq!(rows[i][j].b, hessian[i][k][j], "{name}: ∂²g{i}/∂q{k}∂q{j} at {q:?}");
                    assert_eq!(hessian[i][k][j], hessian[i][j][k]);
                }
            }
        }
        let along: [Dual<Exact>; D] = std::array::from_fn(|j| Dual { a: q[j], b: v[j] });
        let rows = dual.jacobian(&along);
        let both: [Dual<Dual<Exact>>; D] =
            std::array::from_fn(|j| Dual { a: along[j], b: Dual { a: v[j], b: zero } });
        let curve = twice.value(&both);
        let (g, speed, bend) = plain.jet(&q, &v);
        let weighted = plain.weighted_hessian_vector(&q, &weights, &v);
        let mut total = [zero; D];
        for i in 0..M {
            assert_eq!(rows[i].map(|entry| entry.b), products[i], "{name}: (∇²g v){i} at {q:?}");
            assert_eq!(
                [g[i], speed[i], bend[i]],
                [curve[i].a.a, curve[i].a.b, curve[i].b.b],
                "{name}: jet at {q:?}"
            );
            for j in 0..D {
                total[j] = total[j] + weights[i] * products[i][j];
            }
        }
        assert_eq!(weighted, total, "{name}: Σ λ ∇²g v at {q:?}");
    }
    assert!(checked >= 20, "{name}: {checked} points were checked");
}

#[test]
fn exact_for_polynomials_and_rational_functions() {
    check::<3, 1, _>("lemniscate", &Lemniscate { a: 1.0, r: 0.25 });
    check::<3, 1, _>("torus", &Torus { major: 1.5, minor: 0.5 });
    check::<3, 1, _>("clebsch", &Clebsch {});
    check::<3, 1, _>("heart", &Heart {});
    check::<3, 1, _>("ellipsoid", &Ellipsoid { a: 1.0, b: 3.0, c: 0.5 });
    check::<3, 1, _>("rational", &Rational { c: 2.0 });
    check::<3, 1, _>("branches", &Branches {});
    check::<4, 3, _>("orthogonal", &Orthogonal {});
}

/// The complex step has no rounding of its own, so the bound is that of the two formulas: each has a
/// few dozen operations of half an ulp, on numbers of order one.
#[test]
fn complex_step() {
    let analytic = Analytic { k: 1.25 };
    let (plain, complex) = (analytic.kernel::<f64>(), analytic.kernel::<Complex>());
    let mut generator = StdRng::seed_from_u64(9);
    let h = 1e-30;
    for _ in 0..1000 {
        let q: [f64; 3] = std::array::from_fn(|_| generator.random_range(0.25..1.5));
        let v: [f64; 3] = std::array::from_fn(|_| generator.random_range(-1.0..1.0));
        let step = |by: [f64; 3]| std::array::from_fn(|j| Complex { re: q[j], im: h * by[j] });
        let jacobian = plain.jacobian(&q);
        let products = plain.hessian_vector(&q, &v);
        let along = complex.jacobian(&step(v));
        for k in 0..3 {
            let by_k = complex.value(&step(std::array::from_fn(|j| if j == k { 1.0 } else { 0.0 })));
            for i in 0..2 {
                let pairs = [(by_k[i].im / h, jacobian[i][k]), (along[i][k].im / h, products[i][k])];
                for (expected, found) in pairs {
                    let bound = 64.0 * f64::EPSILON * (8.0 + expected.abs());
                    assert!(
                        (expected - found).abs() <= bound,
                        "{i}, {k} at {q:?}: {found} is not {expected}"
                    );
                }
            }
        }
    }
}
