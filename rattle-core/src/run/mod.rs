//! Runs: simulations and ensembles, their observers, costs and checkpoints.

mod begin;
pub mod bill;
pub mod boxed;
pub mod checkpoint;
mod collide;
mod course;
pub mod ensemble;
pub(crate) mod events;
mod fingerprint;
pub mod price;
mod readings;
mod seldom;
pub mod simulation;
mod trouble;
pub mod watch;
