//! Who goes on: a simulation, or an ensemble of them; and who watches.

mod begin;
pub mod bill;
pub mod boxed;
pub mod checkpoint;
mod collide;
mod course;
pub mod ensemble;
pub(crate) mod events;
<<<<<<< HEAD
mod fingerprint;
=======
pub mod price;
>>>>>>> 2933aeb (price: what accuracy costs in time in any scene; within chooses method and step; errors of finished runs estimated)
mod readings;
mod seldom;
pub mod simulation;
mod trouble;
pub mod watch;
