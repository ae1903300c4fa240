//! How exactly a start must satisfy its constraints.

use crate::error::StartFailure;
use crate::kernel::rounding;

/// How far a start may be off its constraints, relatively: 1e-10.
///
/// ```text
/// position    |g|/|∇g| ≤ START_TOLERANCE · L      L: the largest coordinate, or the size of the surface if that is smaller
/// momentum    sin α ≤ START_TOLERANCE             α: the angle between the momentum and the tangent plane
/// ```
///
/// In phase space g may be that part of Σ|∂g/∂zᵢ||zᵢ|, over coordinates and momenta zᵢ; and {g, H} that part of its own
/// slopes times the largest coordinate and momentum on which it depends. Rounding is allowed in any case: 1000 ε of the
/// largest coordinate and momentum.
///
/// This is far above rounding (1e-16) and far below the error of any method. A start beyond the tolerance is refused;
/// [`Scene::project`](crate::scene::Scene::project) moves a state onto its constraints.
pub const START_TOLERANCE: f64 = 1e-10;

/// A start whose normal the rounding of coordinates turns by more than this is too near to a singular point.
pub(crate) const DIRECTION: f64 = 1e-5;

/// Newton steps after which a projection is given up.
pub(crate) const MAX_PROJECTION_STEPS: usize = 60;

/// From where gradients nearly vanish Newton's step leads far beyond. A step after which g would be so many times as
/// large is halved, so often at most, until g is no larger.
pub(crate) const RUNS_AWAY: f64 = 1e3;
pub(crate) const MAX_HALVINGS: i32 = 200;

/// Near the origin places have the rounding of where they came from, which may be some hundred steps away: they may be
/// off by this part of a step's way.
const OF_A_WAY: f64 = 1e-12;

/// How far a start may be off an equation: coordinates of this size, those along the normal of that size, a step's way,
/// and the distance to the next point without a normal, which is the size of the surface. More than that is rounding if
/// g says so, see [`rounding_of_g`](crate::kernel::rounding::rounding_of_g).
pub(crate) fn allowed([coordinates, along]: [f64; 2], way: f64, singular: f64) -> f64 {
    let of_size = rounding::allowed(START_TOLERANCE, [coordinates, along], singular);
    of_size.max(OF_A_WAY * way.min(singular))
}

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
