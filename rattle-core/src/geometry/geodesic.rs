//! The distance between two points along a surface.

use crate::kernel::functions::{Constraint, ConstraintKernel};
use crate::kernel::geodesic::{Missed, Shot, shoot};
use crate::number::vector::{dot, largest};
use nalgebra::SVector;

/// A geodesic between two points a and b.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geodesic<const D: usize> {
    /// Its length d, in the unit of the coordinates.
    pub distance: f64,
    /// Its direction at a, a unit tangent vector: −∂d/∂a. Zero where a = b.
    pub from: SVector<f64, D>,
    /// Its direction at b, a unit tangent vector: ∂d/∂b. Zero where a = b.
    pub to: SVector<f64, D>,
}

/// The geodesic from a to b on the surface g = 0, by [shooting](crate::kernel::geodesic) from the chord, to rounding.
///
/// ```text
/// d = min ∫ |dq| over paths on g = 0 from a to b        ∂d/∂a = −from, ∂d/∂b = to (the first variation)
/// ```
///
/// It is the shortest one as long as b is nearer to a than the injectivity radius of the surface: the lesser of π/√K,
/// for the largest Gaussian curvature K, and half of the shortest geodesic loop. Beyond that the result is some
/// geodesic, or an error. Takes some hundred evaluations of ∇g and ∇²g.
///
/// ```
/// use rattle::curvature::geodesic_distance;
/// use rattle::nalgebra::Vector3;
/// use rattle::surfaces::Sphere;
///
/// let (a, b) = (2.0 * Vector3::x(), 2.0 * Vector3::z());
/// let way = geodesic_distance(&Sphere { r: 2.0 }, &a, &b)?;
/// assert!((way.distance - std::f64::consts::PI).abs() < 1e-13);
/// assert!((way.from - Vector3::z()).norm() < 1e-13);
/// assert!((way.to + Vector3::x()).norm() < 1e-13);
/// # Ok::<(), rattle::curvature::GeodesicError>(())
/// ```
///
/// # Errors
/// [`GeodesicError::NotOnSurface`] for a point off g = 0, [`GeodesicError::NotFound`] where no try ends at b.
#[doc(alias = "shortest path")]
#[doc(alias = "arc length")]
pub fn geodesic_distance<C: Constraint<D, 1>, const D: usize>(
    surface: &C,
    a: &SVector<f64, D>,
    b: &SVector<f64, D>,
) -> Result<Geodesic<D>, GeodesicError> {
    let kernel = surface.kernel::<f64>();
    let (a, b) = ((*a).into(), (*b).into());
    for (place, q) in [("a", &a), ("b", &b)] {
        let off = off(&kernel, q);
        if off > NEAR * largest(q).max(f64::MIN_POSITIVE) || off.is_nan() {
            return Err(GeodesicError::NotOnSurface { place, position: q.to_vec(), off });
        }
    }
    let chord = std::array::from_fn(|d| b[d] - a[d]);
    match shoot(&kernel, &a, &chord) {
        Ok(Shot { distance, from, to }) => Ok(Geodesic { distance, from: from.into(), to: to.into() }),
        Err(Missed { by, length, tries }) => {
            Err(GeodesicError::NotFound { chord: dot(&chord, &chord).sqrt(), length, by, tries })
        }
    }
}

/// How far a place may be off the surface, as part of its largest coordinate.
const NEAR: f64 = 1e-9;

/// |g|/|∇g|: about how far a place is off the surface.
fn off<K: ConstraintKernel<f64, D, 1>, const D: usize>(kernel: &K, q: &[f64; D]) -> f64 {
    let ([value], [gradient]) = kernel.value_and_jacobian(q);
    value.abs() / dot(&gradient, &gradient).sqrt()
}

/// Why no geodesic was found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GeodesicError {
    /// A point off the surface, or where the surface has no normal.
    #[error("{place} = {position:?} is off the surface by {off:.3e}")]
    NotOnSurface {
        /// `a` or `b`.
        place: &'static str,
        /// The point.
        position: Vec<f64>,
        /// |g|/|∇g| there.
        off: f64,
    },
    /// No try ends at b.
    #[error(
        "no geodesic found: the best of {tries} tries, of length {length:.3e}, misses the end of a chord of {chord:.3e} by \
         {by:.3e}; places may be farther apart than geodesics are unique, or on parts that are near through space alone; \
         try nearer ones"
    )]
    NotFound {
        /// The straight distance.
        chord: f64,
        /// The length of the best try.
        length: f64,
        /// Its distance from b at the end.
        by: f64,
        /// The number of tries.
        tries: usize,
    },
}
