//! Bodies each on a surface of its own, g(q) = 0: one equation for one unknown number, λ, per body.
//!
//! Masses are 1. [Ensembles](crate::run::ensemble) and tiles of bodies have steps of their own, in loops over lanes; a
//! single lane of an ensemble comes back here.

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
pub(crate) mod room;
pub(crate) mod series;
mod sheets;
mod start;
pub(crate) mod step;
mod system;
mod tile;
pub(crate) mod tiles;

use crate::number::real::Scalar;

pub use kept::{Kept, OnSurface, OneByOne};
pub use normal::Normal;

/// Functions that are compiled in this crate, see [`crate::instances`].
pub(crate) fn instances<T: Scalar, const D: usize>() -> impl Copy {
    [
        position::Departure::<T, D>::land as *const (),
        position::Departure::<T, D>::look_again as *const (),
        position::Departure::<T, D>::land_instead as *const (),
        diagnosis::FailureAt::no_normal::<T, D> as *const (),
        sheets::check_walk::<T, D> as *const (),
    ]
}
