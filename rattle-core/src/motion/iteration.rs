//! How the position equation g(q′) = 0 is solved for its multipliers: which matrix turns residuals into corrections.
//!
//! ```text
//! A ΔΛ = −g(q′)        A = G(q′) M⁻¹ G(q)ᵀ, exactly or nearly
//! ```
//!
//! | | A | ∇g at the guess | converges |
//! |---|---|---|---|
//! | [`Newton`] | exact; along a line also its change (Ostrowski), in networks taken anew where it contracts less than fourfold | yes | order 4 per two values; linearly, like h² |
//! | [`Symmetric`] | the symmetric part of the one at the guess | yes | linearly, like h²; like h where equations are coupled |
//! | [`Simplified`] | G(q) M⁻¹ G(q)ᵀ, known from the momenta | no | linearly, like h·κ·\|v\| |
//! | [`Broyden`] | the same, learning from every residual: along a line the secant method | no | superlinearly |
//!
//! All go on until corrections are at the rounding of the position, with no other tolerance, and end at the same
//! root: where a residual is not halved, or the root is not clearly the one that the motion leads to (normals that turn by
//! more than a half, a guess that is off by more than a small part of the path), the step is made again with [`Newton`]. So
//! they differ in last bits and in evaluations, `tests/iterations.rs` counts which.
//!
//! Sources: C. Broyden, Math. Comp. 19 (1965) 577; C. Kelley, *Iterative Methods for Linear and Nonlinear Equations* (1995),
//! 7.3, for its limited memory; E. Barth, K. Kuczera, B. Leimkuhler, R. Skeel, J. Comput. Chem. 16 (1995) 1192, for the symmetric part.

use std::fmt::Debug;

/// A way to solve position equations; see the [module](self).
pub trait Iteration: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// Which one.
    const KIND: Kind;
}

/// The ways there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Kind {
    /// [`Newton`].
    Newton,
    /// [`Symmetric`].
    Symmetric,
    /// [`Simplified`].
    Simplified,
    /// [`Broyden`].
    Broyden,
}

/// The exact derivative: fewest evaluations of g, the only one for steps that are long against the curvature, and in what was
/// timed (the lemniscate, a chain of 1000) as fast as any.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Newton;

/// The symmetric part of the derivative at the guess, which it is when h → 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Symmetric;

/// The matrix of the momentum equation, whose factor is known: no gradient but the one at the end of the step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Simplified;

/// The same matrix, corrected by what each residual tells about it: no gradient but the one at the end of the step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Broyden;

impl Iteration for Newton {
    const KIND: Kind = Kind::Newton;
}

impl Iteration for Symmetric {
    const KIND: Kind = Kind::Symmetric;
}

impl Iteration for Simplified {
    const KIND: Kind = Kind::Simplified;
}

impl Iteration for Broyden {
    const KIND: Kind = Kind::Broyden;
}
