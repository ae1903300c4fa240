//! Bodies each on a surface of its own, g(q) = 0: one equation for one unknown number, λ, per body.
//!
//! Masses are 1. The code is generic in the scalar, so that several trajectories can be computed in lanes: by
//! [`Scene::lanes`](crate::scene::Scene::lanes), in tests, and for single lanes of an ensemble.
//! [Ensembles](crate::run::ensemble) and tiles of bodies normally have steps of their own.

mod around;
pub(crate) mod collocation;
mod crowd;
pub(crate) mod diagnosis;
pub(crate) mod equation;
mod hold;
pub(crate) mod in_lanes;
pub(crate) mod kept;
mod landing;
pub(crate) mod normal;
mod passage;
pub(crate) mod position;
mod room;
mod series;
mod sheets;
mod start;
pub(crate) mod step;
mod system;
mod tile;
pub(crate) mod tiles;

use crate::number::real::Real;

pub use kept::{Kept, OnSurface, OneByOne};
pub use normal::Normal;

/// Functions that are compiled in this crate, see [`crate::instances`].
pub(crate) fn instances<T: Real, const D: usize>() -> impl Copy {
    [
        position::Departure::<T, D>::land as *const (),
        position::Departure::<T, D>::look_again as *const (),
        position::Departure::<T, D>::land_instead as *const (),
        diagnosis::FailureAt::no_normal::<T, D> as *const (),
        sheets::check_walk::<T, D> as *const (),
    ]
}
