//! Who goes on: a simulation, or an ensemble of them; and who watches.

mod begin;
pub mod ensemble;
pub mod recorder;
pub mod shadow;
pub mod simulation;
pub mod trajectory;
