//! The runtime of `rattle`.

pub mod kernel;
pub mod real;
