//! Kernels: the functions that macros write, with their derivatives and power series. A kernel knows no body.

pub mod block;
pub mod counted;
pub mod cut_off;
pub mod driven;
pub mod force_law;
pub mod functions;
pub mod geodesic;
pub(crate) mod jacobi;
pub mod kinds;
pub(crate) mod kinks;
pub mod over;
pub mod recurrences;
pub(crate) mod rounding;
pub mod series;
pub mod space;
pub mod within;

pub use driven::{DrivenPotential, DrivenPotentialKernel};
pub use force_law::{ForceLaw, ForceLawKernel};
pub use functions::{
    Constraint, ConstraintKernel, Hamiltonian, HamiltonianKernel, PairKernel, PairPotential, PhaseConstraint,
    PhaseConstraintKernel, Potential, PotentialKernel,
};
pub use kinds::Kinds;
pub use over::Over;
pub use space::{Open, Periodic, Space};
pub use within::{Along, AlongGeodesics, Within};
