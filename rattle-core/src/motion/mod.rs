//! The interface between systems and methods: bodies, states, and the traits of both. Neither knows the other.

pub mod bodies;
pub mod capability;
pub mod failure;
pub mod guess;
pub mod hold;
pub mod identity;
pub mod iteration;
pub mod method;
pub mod need;
pub mod record;
pub(crate) mod rest;
pub mod start;
pub mod state;
pub(crate) mod stir;
pub mod system;
pub mod table;
mod tables;
pub mod witness;
