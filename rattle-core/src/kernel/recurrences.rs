//! Recurrences of power series for the operations of the macro language.

use crate::kernel::block::{Block, WIDTH};
use crate::number::real::{Mask, Real};
use std::f64::consts::{FRAC_2_SQRT_PI, LOG2_E, LOG10_E};

/// Computes one coefficient of each operation of a function, from the coefficients of its operands and the lower
/// coefficients.
///
/// Methods take the coefficient k of their operands and return that of the result; `at` numbers the products that
/// belong to the operation, the same at each order. With t a′ for the series of k aₖ, all operations reduce to
/// products:
///
/// ```text
/// q = a/b      q b = a
/// y = √a       y y = a
/// y = exp a    t y′ = t a′ y            sin, cos, tan, sinh, cosh, tanh, erf: t y′ = t a′ w with the slope w = f′(a)
/// y = ln a     t y′ = t a′/a            log10, log2, asin, acos, atan, asinh, acosh, atanh, atan2: other quotients
/// y = aᶜ       t y′ = c (t a′/a) y      cbrt: c = 1/3;  c a series: t y′ = t (c ln a)′ y
/// ```
///
/// Values (k = 0) are those of the scalar's own functions. Signs and branches are those at t = 0; where one changes
/// just there, coefficients are NaN. They are NaN or infinite too where a function is not smooth: √0, ln 0.
#[derive(Debug)]
pub struct Recurrences<'a, T, const FIRST: bool> {
    /// k and 1/k.
    k: T,
    inverse: T,
    first: [&'a [Block<T>]; 2],
    sums: &'a [Block<T>],
    now: [&'a mut [Block<T>]; 2],
}

impl<'a, T: Real, const FIRST: bool> Recurrences<'a, T, FIRST> {
    #[inline(always)]
    pub(super) fn new(
        k: usize,
        first: [&'a [Block<T>]; 2],
        sums: &'a [Block<T>],
        now: [&'a mut [Block<T>]; 2],
    ) -> Self {
        Self { k: T::from_f64(k as f64), inverse: T::from_f64(1.0 / k as f64), first, sums, now }
    }

    /// Notes the coefficients of both factors of a product.
    #[inline(always)]
    pub(crate) fn note(&mut self, at: usize, left: T, right: T) {
        self.note_left(at, left);
        self.note_right(at, right);
    }
    #[inline(always)]
    fn note_left(&mut self, at: usize, left: T) {
        self.now[0][at / WIDTH].0[at % WIDTH] = left;
    }
    #[inline(always)]
    fn note_right(&mut self, at: usize, right: T) {
        self.now[1][at / WIDTH].0[at % WIDTH] = right;
    }
    /// Σ aⱼ bₖ₋ⱼ over 0 < j < k.
    #[inline(always)]
    pub(crate) fn sum(&self, at: usize) -> T {
        self.sums[at / WIDTH].0[at % WIDTH]
    }
    #[inline(always)]
    fn first_left(&self, at: usize) -> T {
        self.first[0][at / WIDTH].0[at % WIDTH]
    }
    #[inline(always)]
    fn first_right(&self, at: usize) -> T {
        self.first[1][at / WIDTH].0[at % WIDTH]
    }

    /// A constant.
    #[inline(always)]
    #[must_use]
    pub fn constant(&self, x: T) -> T {
        if FIRST { x } else { T::from_f64(0.0) }
    }
    /// a + x, for a constant x.
    #[inline(always)]
    #[must_use]
    pub fn shift(&self, a: T, x: T) -> T {
        if FIRST { a + x } else { a }
    }
    /// t a′
    #[inline(always)]
    fn rate(&self, a: T) -> T {
        if FIRST { T::from_f64(0.0) } else { self.k * a }
    }
    /// The series with this value and the rate t y′.
    #[inline(always)]
    fn with_rate(&self, rate: T, value: impl FnOnce() -> T) -> T {
        if FIRST { value() } else { rate * self.inverse }
    }
    /// The product of a rate, which has no coefficient 0, and a slope that is known one order later: see
    /// [`Self::slope`].
    #[inline(always)]
    fn by_slope(&mut self, at: usize, rate: T) -> T {
        self.note_left(at, rate);
        if FIRST { T::from_f64(0.0) } else { self.sum(at) + rate * self.first_right(at) }
    }
    #[inline(always)]
    fn slope(&mut self, at: usize, slope: T) {
        self.note_right(at, slope);
    }
    /// t y′ = rate·y
    #[inline(always)]
    fn growth(&mut self, at: usize, rate: T, value: impl FnOnce() -> T) -> T {
        let rate = self.by_slope(at, rate);
        let y = self.with_rate(rate, value);
        self.slope(at, y);
        y
    }

    /// a b. Faster where b is the factor that is known later.
    #[inline(always)]
    pub fn product(&mut self, at: usize, a: T, b: T) -> T {
        self.note(at, a, b);
        if FIRST { a * b } else { (self.sum(at) + a * self.first_right(at)) + self.first_left(at) * b }
    }
    /// a²
    #[inline(always)]
    pub fn square(&mut self, at: usize, a: T) -> T {
        self.note(at, a, a);
        if FIRST {
            a * a
        } else {
            let first = self.first_left(at);
            self.sum(at) + (first + first) * a
        }
    }
    /// a/b
    #[inline(always)]
    pub fn quotient(&mut self, at: usize, a: T, b: T) -> T {
        let quotient = if FIRST {
            a / b
        } else {
            let inverse = T::from_f64(1.0) / self.first_right(at);
            ((a - self.sum(at)) - self.first_left(at) * b) * inverse
        };
        self.note(at, quotient, b);
        quotient
    }
    /// 1/b
    #[inline(always)]
    pub fn reciprocal(&mut self, at: usize, b: T) -> T {
        let one = self.constant(T::from_f64(1.0));
        self.quotient(at, one, b)
    }
    /// √a
    #[inline(always)]
    pub fn sqrt(&mut self, at: usize, a: T) -> T {
        self.root(at, a, || a.sqrt())
    }
    #[inline(always)]
    fn root(&mut self, at: usize, a: T, value: impl FnOnce() -> T) -> T {
        let root =
            if FIRST { value() } else { (a - self.sum(at)) * (T::from_f64(0.5) / self.first_left(at)) };
        self.note(at, root, root);
        root
    }

    /// eᵃ
    #[inline(always)]
    pub fn exp(&mut self, at: usize, a: T) -> T {
        self.growth(at, self.rate(a), || a.exp())
    }
    /// ln a
    #[inline(always)]
    pub fn ln(&mut self, at: usize, a: T) -> T {
        let rate = self.quotient(at, self.rate(a), a);
        self.with_rate(rate, || a.ln())
    }
    /// Logarithm to base 10.
    #[inline(always)]
    pub fn log10(&mut self, at: usize, a: T) -> T {
        let rate = self.quotient(at, self.rate(a), a);
        self.with_rate(rate * T::from_f64(LOG10_E), || a.log10())
    }
    /// Logarithm to base 2.
    #[inline(always)]
    pub fn log2(&mut self, at: usize, a: T) -> T {
        let rate = self.quotient(at, self.rate(a), a);
        self.with_rate(rate * T::from_f64(LOG2_E), || a.log2())
    }
    /// aᶜ for a constant c.
    #[inline(always)]
    pub fn powf(&mut self, at: [usize; 2], a: T, c: T) -> T {
        let rate = self.quotient(at[0], self.rate(a), a);
        self.growth(at[1], c * rate, || a.powf(c))
    }
    /// aᵇ for an exponent that varies.
    #[inline(always)]
    pub fn power(&mut self, at: [usize; 3], a: T, b: T) -> T {
        let logarithm = self.ln(at[0], a);
        let exponent = self.product(at[1], b, logarithm);
        self.growth(at[2], self.rate(exponent), || a.powf(b))
    }
    /// ∛a
    #[inline(always)]
    pub fn cbrt(&mut self, at: [usize; 2], a: T) -> T {
        let rate = self.quotient(at[0], self.rate(a), a);
        self.growth(at[1], rate * T::from_f64(1.0 / 3.0), || a.cbrt())
    }

    /// sin a and cos a
    #[inline(always)]
    pub fn sin_cos(&mut self, at: [usize; 2], a: T) -> (T, T) {
        let rate = self.rate(a);
        let (sin, cos) = if FIRST { a.sin_cos() } else { (a, a) };
        let (up, down) = (self.by_slope(at[0], rate), self.by_slope(at[1], rate));
        let (sin, cos) = (self.with_rate(up, || sin), self.with_rate(-down, || cos));
        self.slope(at[0], cos);
        self.slope(at[1], sin);
        (sin, cos)
    }
    /// sinh a and cosh a
    #[inline(always)]
    pub fn sinh_cosh(&mut self, at: [usize; 2], a: T) -> (T, T) {
        let rate = self.rate(a);
        let (up, over) = (self.by_slope(at[0], rate), self.by_slope(at[1], rate));
        let (sinh, cosh) = (self.with_rate(up, || a.sinh()), self.with_rate(over, || a.cosh()));
        self.slope(at[0], cosh);
        self.slope(at[1], sinh);
        (sinh, cosh)
    }
    /// tan a
    #[inline(always)]
    pub fn tan(&mut self, at: [usize; 2], a: T) -> T {
        let rate = self.by_slope(at[0], self.rate(a));
        let tan = self.with_rate(rate, || a.tan());
        let square = self.square(at[1], tan);
        self.slope(at[0], self.shift(square, T::from_f64(1.0)));
        tan
    }
    /// tanh a
    #[inline(always)]
    pub fn tanh(&mut self, at: [usize; 2], a: T) -> T {
        let rate = self.by_slope(at[0], self.rate(a));
        let tanh = self.with_rate(rate, || a.tanh());
        let square = self.square(at[1], tanh);
        self.slope(at[0], self.shift(-square, T::from_f64(1.0)));
        tanh
    }
    /// The error function.
    #[inline(always)]
    pub fn erf(&mut self, at: [usize; 3], a: T) -> T {
        let square = self.square(at[0], a);
        let bell = self.exp(at[1], -square);
        let rate = self.by_slope(at[2], self.rate(a));
        self.slope(at[2], bell * T::from_f64(FRAC_2_SQRT_PI));
        self.with_rate(rate, || a.erf())
    }

    /// (1 − a)(1 + a)
    #[inline(always)]
    fn one_minus_square(&mut self, at: usize, a: T) -> T {
        let one = T::from_f64(1.0);
        self.product(at, self.shift(-a, one), self.shift(a, one))
    }
    #[inline(always)]
    fn one_plus_square(&mut self, at: usize, a: T) -> T {
        let square = self.square(at, a);
        self.shift(square, T::from_f64(1.0))
    }
    /// t a′/√d
    #[inline(always)]
    fn rate_over_root(&mut self, at: [usize; 2], a: T, d: T) -> T {
        let root = self.sqrt(at[0], d);
        self.quotient(at[1], self.rate(a), root)
    }
    /// arcsin a
    #[inline(always)]
    pub fn asin(&mut self, at: [usize; 3], a: T) -> T {
        let square = self.one_minus_square(at[0], a);
        let rate = self.rate_over_root([at[1], at[2]], a, square);
        self.with_rate(rate, || a.asin())
    }
    /// arccos a
    #[inline(always)]
    pub fn acos(&mut self, at: [usize; 3], a: T) -> T {
        let square = self.one_minus_square(at[0], a);
        let rate = self.rate_over_root([at[1], at[2]], a, square);
        self.with_rate(-rate, || a.acos())
    }
    /// arctan a
    #[inline(always)]
    pub fn atan(&mut self, at: [usize; 2], a: T) -> T {
        let square = self.one_plus_square(at[0], a);
        let rate = self.quotient(at[1], self.rate(a), square);
        self.with_rate(rate, || a.atan())
    }
    /// arsinh a
    #[inline(always)]
    pub fn asinh(&mut self, at: [usize; 3], a: T) -> T {
        let square = self.one_plus_square(at[0], a);
        let rate = self.rate_over_root([at[1], at[2]], a, square);
        self.with_rate(rate, || a.asinh())
    }
    /// arcosh a
    #[inline(always)]
    pub fn acosh(&mut self, at: [usize; 3], a: T) -> T {
        let square = self.one_minus_square(at[0], a);
        let rate = self.rate_over_root([at[1], at[2]], a, -square);
        self.with_rate(rate, || a.acosh())
    }
    /// artanh a
    #[inline(always)]
    pub fn atanh(&mut self, at: [usize; 2], a: T) -> T {
        let square = self.one_minus_square(at[0], a);
        let rate = self.quotient(at[1], self.rate(a), square);
        self.with_rate(rate, || a.atanh())
    }
    /// The angle of the point (x, y).
    #[inline(always)]
    pub fn atan2(&mut self, at: [usize; 5], y: T, x: T) -> T {
        let up = self.product(at[0], self.rate(y), x);
        let down = self.product(at[1], self.rate(x), y);
        let square = self.square(at[2], x) + self.square(at[3], y);
        let rate = self.quotient(at[4], up - down, square);
        self.with_rate(rate, || y.atan2(x))
    }
    /// √(a² + b²)
    #[inline(always)]
    pub fn hypot(&mut self, at: [usize; 3], a: T, b: T) -> T {
        let square = self.square(at[0], a) + self.square(at[1], b);
        self.root(at[2], square, || a.hypot(b))
    }

    /// 0 where a choice by a < b or a > b holds on, also if a = b stays so; NaN where it turns.
    #[inline(always)]
    fn tie(&self, at: usize, a: T, b: T) -> T {
        let (zero, nan) = (T::from_f64(0.0), T::from_f64(f64::NAN));
        let (first_a, first_b) = (self.first_left(at), self.first_right(at));
        let apart = first_a.lt(first_b).or(first_b.lt(first_a));
        T::select(apart.or(a.le(b).and(b.le(a))), zero, nan)
    }
    /// `then` where a < b at t = 0, else `other`.
    #[inline(always)]
    pub fn select_lt(&mut self, at: usize, a: T, b: T, then: T, other: T) -> T {
        self.note(at, a, b);
        if FIRST {
            return T::select(a.lt(b), then, other);
        }
        T::select(self.first_left(at).lt(self.first_right(at)), then, other) + self.tie(at, a, b)
    }
    /// `then` where a ≤ b at t = 0, else `other`.
    #[inline(always)]
    pub fn select_le(&mut self, at: usize, a: T, b: T, then: T, other: T) -> T {
        self.note(at, a, b);
        if FIRST {
            return T::select(a.le(b), then, other);
        }
        T::select(self.first_left(at).le(self.first_right(at)), then, other) + self.tie(at, a, b)
    }
    /// |a|
    #[inline(always)]
    pub fn abs(&mut self, at: usize, a: T) -> T {
        let zero = T::from_f64(0.0);
        self.select_lt(at, a, zero, -a, a)
    }
    /// −1, 0 or 1 by sign.
    #[inline(always)]
    pub fn sign(&mut self, at: usize, a: T) -> T {
        let zero = T::from_f64(0.0);
        self.note(at, a, zero);
        if FIRST { a.sign() } else { self.tie(at, a, zero) }
    }
    /// The largest integer that is not above a.
    #[inline(always)]
    pub fn floor(&mut self, at: usize, a: T) -> T {
        let zero = T::from_f64(0.0);
        if FIRST {
            self.note(at, a, a.floor());
            return a.floor();
        }
        self.note(at, a, zero);
        self.tie(at, a, zero)
    }
}
