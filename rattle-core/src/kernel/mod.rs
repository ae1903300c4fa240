//! What a macro writes: functions of one place and their derivatives, and their power series. A kernel knows no body.

pub mod block;
pub mod counted;
pub mod functions;
pub(crate) mod kinks;
pub mod over;
pub mod recurrences;
pub mod series;

pub use functions::{
    Constraint, ConstraintKernel, Hamiltonian, HamiltonianKernel, PairKernel, PairPotential, PhaseConstraint,
    PhaseConstraintKernel, Potential, PotentialKernel,
};
pub use over::Over;
