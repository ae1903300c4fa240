//! Runs: simulations and ensembles, their observers, costs and checkpoints.

mod answers;
mod begin;
pub mod bill;
pub mod boxed;
pub mod checkpoint;
mod collide;
pub mod ensemble;
pub(crate) mod events;
mod fingerprint;
pub mod price;
mod readings;
mod retry;
mod reversal;
mod seldom;
pub mod simulation;
mod trouble;
pub mod watch;

/// Functions that are compiled in this crate, see [`crate::instances`].
pub(crate) fn instances<const D: usize>() -> impl Copy {
    [
        answers::places::<D> as *const (),
        checkpoint::read_places::<D> as *const (),
        checkpoint::write_places::<D> as *const (),
        events::Search::<D>::clone as *const (),
        fingerprint::moved::<D> as *const (),
    ]
}
