//! The interface between systems and methods: bodies, states, and the traits of both. Neither knows the other.

pub mod affected;
pub mod bodies;
pub mod capability;
pub(crate) mod course;
pub mod failure;
pub mod guarded;
pub mod guess;
pub mod hold;
pub mod identity;
pub mod iteration;
pub mod measured;
pub mod method;
pub mod need;
pub mod parts;
pub mod record;
pub(crate) mod rest;
pub mod start;
pub mod state;
pub(crate) mod sticking;
pub(crate) mod stir;
pub mod system;
pub mod table;
mod tables;
pub mod witness;

use crate::number::real::Scalar;

/// Functions that are compiled in this crate, see [`crate::instances`].
pub(crate) fn instances<T: Scalar, const D: usize>() -> impl Copy {
    [
        bodies::gathered::<T, D> as *const (),
        bodies::scatter::<T, D> as *const (),
        bodies::Body::<T, D>::positions as *const (),
        bodies::Body::<T, D>::momenta as *const (),
        failure::numbers::<T> as *const (),
    ]
}
