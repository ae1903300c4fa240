//! Bodies in phase space, under g(q, p) = 0 with an energy H(q, p).

mod fibre;
mod hold;
mod kept;
mod landing;
mod point;
mod step;
mod system;

pub use kept::{InPhaseSpace, PhaseSpace};
