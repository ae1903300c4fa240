//! The contract between systems and methods: neither knows the other, both know what stands here.

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
