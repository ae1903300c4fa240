//! Complex numbers as a scalar of kernels: coefficients of power series by Cauchy's integral, without any recurrence.

#![allow(unreachable_pub, reason = "a module of several tests")]

use rattle::real::Real;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// x + iy. Comparisons are those of the real parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Complex(pub f64, pub f64);

const I: Complex = Complex(0.0, 1.0);

fn real(x: f64) -> Complex {
    Complex(x, 0.0)
}

impl Add for Complex {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        Self(self.0 + b.0, self.1 + b.1)
    }
}
impl Sub for Complex {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        Self(self.0 - b.0, self.1 - b.1)
    }
}
impl Mul for Complex {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        Self(self.0 * b.0 - self.1 * b.1, self.0 * b.1 + self.1 * b.0)
    }
}
impl Div for Complex {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        let square = b.0 * b.0 + b.1 * b.1;
        self * Self(b.0 / square, -b.1 / square)
    }
}
impl Neg for Complex {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl Real for Complex {
    type Mask = bool;

    fn from_f64(x: f64) -> Self {
        real(x)
    }
    fn lanes(self) -> impl Iterator<Item = f64> {
        std::iter::once(self.0)
    }
    fn lt(self, b: Self) -> bool {
        self.0 < b.0
    }
    fn le(self, b: Self) -> bool {
        self.0 <= b.0
    }
    fn select(mask: bool, a: Self, b: Self) -> Self {
        if mask { a } else { b }
    }
    fn abs(self) -> Self {
        self * self.sign()
    }
    fn sign(self) -> Self {
        real(Real::sign(self.0))
    }
    fn floor(self) -> Self {
        real(Real::floor(self.0))
    }
    fn sqrt(self) -> Self {
        (self.ln() * real(0.5)).exp()
    }
    fn cbrt(self) -> Self {
        if self.0 < 0.0 { -(-self).cbrt() } else { (self.ln() / real(3.0)).exp() }
    }
    fn exp(self) -> Self {
        let size = self.0.exp();
        Self(size * self.1.cos(), size * self.1.sin())
    }
    fn ln(self) -> Self {
        Self(self.0.hypot(self.1).ln(), self.1.atan2(self.0))
    }
    fn log10(self) -> Self {
        self.ln() / real(10_f64.ln())
    }
    fn log2(self) -> Self {
        self.ln() / real(2_f64.ln())
    }
    fn sin(self) -> Self {
        -I * (I * self).sinh()
    }
    fn cos(self) -> Self {
        (I * self).cosh()
    }
    fn sin_cos(self) -> (Self, Self) {
        (self.sin(), self.cos())
    }
    fn tan(self) -> Self {
        self.sin() / self.cos()
    }
    fn asin(self) -> Self {
        -I * (I * self).asinh()
    }
    fn acos(self) -> Self {
        real(std::f64::consts::FRAC_PI_2) - self.asin()
    }
    fn atan(self) -> Self {
        -I * (I * self).atanh()
    }
    fn sinh(self) -> Self {
        (self.exp() - (-self).exp()) * real(0.5)
    }
    fn cosh(self) -> Self {
        (self.exp() + (-self).exp()) * real(0.5)
    }
    fn tanh(self) -> Self {
        self.sinh() / self.cosh()
    }
    fn asinh(self) -> Self {
        (self + (self * self + real(1.0)).sqrt()).ln()
    }
    fn acosh(self) -> Self {
        (self + (self - real(1.0)).sqrt() * (self + real(1.0)).sqrt()).ln()
    }
    fn atanh(self) -> Self {
        ((real(1.0) + self).ln() - (real(1.0) - self).ln()) * real(0.5)
    }
    /// By its power series, for |z| of about 1.
    fn erf(self) -> Self {
        let (mut sum, mut power) = (self, self);
        for n in 1..60 {
            power = -power * self * self / real(f64::from(n));
            sum = sum + power / real(f64::from(2 * n + 1));
        }
        sum * real(std::f64::consts::FRAC_2_SQRT_PI)
    }
    fn powf(self, exponent: Self) -> Self {
        (exponent * self.ln()).exp()
    }
    fn atan2(self, x: Self) -> Self {
        -I * ((x + I * self) / self.hypot(x)).ln()
    }
    fn hypot(self, y: Self) -> Self {
        (self * self + y * y).sqrt()
    }
}

/// The coefficients f₀ … fₙ₋₁ of a function of t that is smooth for |t| ≤ `radius` and somewhat beyond, each times
/// radiusᵏ: (1/2π) ∫ f(radius·eⁱᵠ) e⁻ⁱᵏᵠ dφ.
pub fn cauchy<const D: usize>(n: usize, radius: f64, f: impl Fn(Complex) -> [Complex; D]) -> Vec<[f64; D]> {
    const POINTS: usize = 128;
    let mut found = vec![[0.0; D]; n];
    for point in 0..POINTS {
        let angle = |k: usize| std::f64::consts::TAU * ((point * k) % POINTS) as f64 / POINTS as f64;
        let values = f(Complex(radius * angle(1).cos(), radius * angle(1).sin()));
        for (k, coefficients) in found.iter_mut().enumerate() {
            for (coefficient, value) in coefficients.iter_mut().zip(values) {
                let turned = value * Complex(angle(k).cos(), -angle(k).sin());
                *coefficient += turned.0 / POINTS as f64;
            }
        }
    }
    found
}
