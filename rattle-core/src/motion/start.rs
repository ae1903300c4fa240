//! What every start is measured by.

use crate::error::StartFailure;

/// A start may lie this far off the surface, relative to its largest coordinate or to the size of the surface if that
/// is smaller, and its momentum this far off the tangent plane, as a sine: well above rounding, well below any error
/// of a method.
pub const START_TOLERANCE: f64 = 1e-10;

/// A start whose normal is known to no more digits than this is too near to a singular point.
pub(crate) const DIRECTION: f64 = 1e-5;

/// Newton steps after which a projection is given up.
pub(crate) const MAX_PROJECTION_STEPS: usize = 60;

/// Whether these numbers are finite.
pub(crate) fn finite<const D: usize>(quantity: &'static str, x: &[f64; D]) -> Result<(), StartFailure> {
    match x.iter().position(|x| !x.is_finite()) {
        Some(component) => Err(StartFailure::NotFinite { quantity, component, value: x[component] }),
        None => Ok(()),
    }
}

/// The length of a vector, be its square beyond the numbers or not.
pub(crate) fn length_of<'a>(vector: impl IntoIterator<Item = &'a f64>) -> f64 {
    vector.into_iter().fold(0.0, |length: f64, &x| length.hypot(x))
}

/// Whether steps can do with a gradient of this length, of which they take the square.
pub(crate) fn has_square(length: f64) -> bool {
    (f64::MIN_POSITIVE..=f64::MAX).contains(&(length * length))
}
