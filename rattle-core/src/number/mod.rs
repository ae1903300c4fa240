//! Numbers: scalars, several of them side by side, and the instructions that move them. Knows nothing of mechanics.

pub mod clock;
mod functions;
pub mod instructions;
pub mod lanes;
pub(crate) mod linear;
pub(crate) mod philox;
pub mod real;
pub(crate) mod twofold;
pub(crate) mod vector;
pub(crate) mod vectors;
