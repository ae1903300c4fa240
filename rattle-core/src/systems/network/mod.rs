//! Constraints between bodies and their linear algebra.

pub(crate) mod algebra;
pub(crate) mod alike;
mod chain;
pub(crate) mod constraints;
pub(crate) mod dense;
pub(crate) mod dependence;
pub(crate) mod elimination;
mod factor;
pub(crate) mod few_in_lanes;
pub(crate) mod group;
mod hubs;
pub(crate) mod in_lanes;
mod late;
pub(crate) mod line;
pub(crate) mod mass;
mod order;
pub(crate) mod orthogonal;
pub(crate) mod pattern;
pub(crate) mod places;
pub(crate) mod rows;
pub(crate) mod series_in_lanes;
pub(crate) mod shape;
pub(crate) mod solver;
#[cfg(feature = "faer")]
mod supernodal;
#[cfg(test)]
mod tests;
pub(crate) mod tie;

pub use algebra::LinearAlgebra;
pub use constraints::Network;
pub use mass::Mass;
pub use solver::Report;
pub use tie::Tie;

/// Functions that are compiled in this crate, see [`crate::instances`].
pub(crate) fn instances<const D: usize>() -> impl Copy {
    [Network::<D>::shape as *const (), solver::Solver::<D>::respond as *const ()]
}
