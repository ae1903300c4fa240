//! Mechanics with constraints.

extern crate self as rattle; // the macros write `::rattle`, also in here

pub mod surfaces;

pub use rattle_core::{kernel, real};
pub use rattle_macros::{constraint, hamiltonian, pair_potential, phase_constraint, potential};

/// What a program needs to say `use rattle::prelude::*;` for.
pub mod prelude {
    pub use crate::kernel::{
        Constraint, ConstraintKernel, Hamiltonian, HamiltonianKernel, PairKernel, PairPotential,
        PhaseConstraint, PhaseConstraintKernel, Potential, PotentialKernel,
    };
    pub use crate::real::Real;
    pub use crate::{constraint, hamiltonian, pair_potential, phase_constraint, potential};
}
