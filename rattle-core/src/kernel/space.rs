//! The vector from one position to another, in open or in periodic space.

use crate::number::real::Real;
use std::array::from_fn;
use std::fmt::Debug;

/// A space, which defines the vector between two positions.
pub trait Space<const D: usize>: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// The vector a − b from b to a, or from the nearest image of b. Exchanging a and b changes only its sign, bit for
    /// bit.
    fn apart<T: Real>(&self, a: &[T; D], b: &[T; D]) -> [T; D];
    /// The periods along the coordinates; infinite where space is not periodic.
    fn periods(&self) -> [f64; D];
}

/// Open, infinite space.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Open;

impl<const D: usize> Space<D> for Open {
    #[inline(always)]
    fn apart<T: Real>(&self, a: &[T; D], b: &[T; D]) -> [T; D] {
        from_fn(|d| a[d] - b[d])
    }
    #[inline(always)]
    fn periods(&self) -> [f64; D] {
        [f64::INFINITY; D]
    }
}

/// Periodic space, with nearest images (minimum image convention). Positions are not wrapped: they may be any number of
/// periods away.
///
/// ```text
/// Δ = a − b − L round((a − b)/L)        along each coordinate
/// ```
#[doc(alias = "periodic boundary conditions")]
#[doc(alias = "minimum image")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Periodic<const D: usize> {
    periods: [f64; D],
    /// Zero where the period is infinite.
    steps: [f64; D],
    per_period: [f64; D],
}

impl<const D: usize> Periodic<D> {
    /// Space with these periods; `f64::INFINITY` where it is not periodic.
    #[must_use]
    pub fn new(periods: [f64; D]) -> Self {
        let steps = periods.map(|length| if length.is_finite() { length } else { 0.0 });
        Self { periods, steps, per_period: periods.map(f64::recip) }
    }
}

impl<const D: usize> Space<D> for Periodic<D> {
    #[inline(always)]
    fn apart<T: Real>(&self, a: &[T; D], b: &[T; D]) -> [T; D] {
        from_fn(|d| {
            let apart = a[d] - b[d];
            let periods = nearest_integer(apart * T::from_f64(self.per_period[d]));
            T::from_f64(-self.steps[d]).multiply_add(periods, apart)
        })
    }
    #[inline(always)]
    fn periods(&self) -> [f64; D] {
        self.periods
    }
}

/// To within half of one, as long as there are digits for it: a large number has none for parts of one.
#[inline(always)]
fn nearest_integer<T: Real>(x: T) -> T {
    let large = T::from_f64(1.5 / T::EPSILON);
    (x + large) - large
}
