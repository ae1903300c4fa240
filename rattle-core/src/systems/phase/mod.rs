//! Bodies in phase space, under g(q, p) = 0 with an energy H(q, p).

pub(crate) mod fibre;
mod hold;
pub(crate) mod in_lanes;
mod kept;
pub(crate) mod landing;
pub(crate) mod noise;
pub(crate) mod point;
pub(crate) mod step;
mod system;

pub use kept::{InPhaseSpace, PhaseSpace, Unconstrained};
