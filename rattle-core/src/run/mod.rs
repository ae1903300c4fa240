//! Who goes on: a simulation, or an ensemble of them; and who watches.

mod begin;
pub mod bill;
pub mod boxed;
mod course;
pub mod ensemble;
mod readings;
pub mod simulation;
pub mod watch;
