//! Numbers: scalars, arrays of scalars (lanes), and instruction sets. This part knows no mechanics.

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
