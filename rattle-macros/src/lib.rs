//! Macros of `rattle`: mathematics in, native functions with their derivatives out.
//!
//! The work is done by `rattle-symbolic`; this crate only hands tokens over.

use proc_macro::TokenStream;
use rattle_symbolic::expand::{Macro, expand};

/// Equations g(q) = 0 that hold during the motion.
#[proc_macro]
pub fn constraint(input: TokenStream) -> TokenStream {
    expand(Macro::Constraint, input.into()).into()
}

/// A potential energy U(q).
#[proc_macro]
pub fn potential(input: TokenStream) -> TokenStream {
    expand(Macro::Potential, input.into()).into()
}

/// A potential energy U(r) of two bodies at distance r.
#[proc_macro]
pub fn pair_potential(input: TokenStream) -> TokenStream {
    expand(Macro::PairPotential, input.into()).into()
}

/// An energy H(q, p).
#[proc_macro]
pub fn hamiltonian(input: TokenStream) -> TokenStream {
    expand(Macro::Hamiltonian, input.into()).into()
}

/// Equations g(q, p) = 0 between coordinates and momenta.
#[proc_macro]
pub fn phase_constraint(input: TokenStream) -> TokenStream {
    expand(Macro::PhaseConstraint, input.into()).into()
}
