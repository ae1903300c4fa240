//! Arithmetic on `[T; D]`, the form in which kernels see points and vectors. In loops: of many components
//! `array::from_fn` may become a call, compiled for no instruction set.

use crate::number::real::{Real, Scalar};

/// a·b, summed from the first component on.
#[inline(always)]
pub(crate) fn dot<T: Real, const D: usize>(a: &[T; D], b: &[T; D]) -> T {
    let mut sum = a[0] * b[0];
    for i in 1..D {
        sum = a[i].multiply_add(b[i], sum);
    }
    sum
}

/// a + c b.
#[inline(always)]
pub(crate) fn add_scaled<T: Real, const D: usize>(a: &[T; D], c: T, b: &[T; D]) -> [T; D] {
    let mut all = *a;
    for i in 0..D {
        all[i] = c.multiply_add(b[i], a[i]);
    }
    all
}

/// c a.
#[inline(always)]
pub(crate) fn scaled<T: Real, const D: usize>(c: T, a: &[T; D]) -> [T; D] {
    let mut all = *a;
    for i in 0..D {
        all[i] = c * a[i];
    }
    all
}

/// a + b.
#[inline(always)]
pub(crate) fn sum<T: Real, const D: usize>(a: &[T; D], b: &[T; D]) -> [T; D] {
    let mut all = *a;
    for i in 0..D {
        all[i] = a[i] + b[i];
    }
    all
}

/// maxᵢ |aᵢ|.
#[inline(always)]
pub(crate) fn largest<T: Real, const D: usize>(a: &[T; D]) -> T {
    let mut largest = a[0].abs();
    for component in &a[1..] {
        largest = largest.max(component.abs());
    }
    largest
}

/// The same, and no number where a component is none.
#[inline(always)]
pub(crate) fn extent<T: Scalar, const D: usize>(a: &[T; D]) -> f64 {
    if dot(a, a).to_f64().is_nan() { f64::NAN } else { largest(a).to_f64() }
}

/// The larger one, by one instruction: which, if one is no number, is not said.
#[inline(always)]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a < b { b } else { a }
}

/// The larger one; NaN if one is.
#[inline(always)]
pub(crate) fn larger_or_nan(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// maxᵢ |aᵢ|, by [`larger`].
#[inline(always)]
pub(crate) fn size<const D: usize>(a: &[f64; D]) -> f64 {
    let mut most = a[0].abs();
    for x in &a[1..] {
        most = larger(most, x.abs());
    }
    most
}

/// (fl(a + b), a + b − fl(a + b)) in every component: exact, whatever the sizes (Knuth 1969).
#[inline(always)]
pub(crate) fn two_sum<T: Real, const D: usize>(a: &[T; D], b: &[T; D]) -> ([T; D], [T; D]) {
    let (mut high, mut low) = (*a, *a);
    for i in 0..D {
        high[i] = a[i] + b[i];
        let b_part = high[i] - a[i];
        let a_part = high[i] - b_part;
        low[i] = (a[i] - a_part) + (b[i] - b_part);
    }
    (high, low)
}
