//! How the position equation g(q′) = 0 is solved for its multipliers Λ. The iterations differ in the matrix A that
//! turns a residual into a correction.
//!
//! ```text
//! A ΔΛ = −g(q′)        A = G(q′) M⁻¹ G(q)ᵀ, exactly or nearly
//! ```
//!
//! | | A | ∇g at the guess | convergence |
//! |---|---|---|---|
//! | [`Newton`] | exact; on surfaces also its change (Ostrowski); in networks evaluated again where a correction is not a fourth of the one before | yes | on surfaces of order 4 per two values of g; in networks linear, with a factor of order h² |
//! | [`Symmetric`] | the symmetric part of A at the guess | yes | linear, with a factor of order h², or h where equations are coupled |
//! | [`Simplified`] | G(q) M⁻¹ G(q)ᵀ, known from the momenta | no | linear, with a factor of order h·κ·\|v\| |
//! | [`Broyden`] | that of `Simplified`, updated from every residual; on surfaces the secant method | no | superlinear |
//!
//! Every iteration ends when corrections are as small as the rounding of the position; there is no other tolerance. All
//! of them find the same root, so results differ only in their last bits and in the number of evaluations (counted in
//! `tests/iterations.rs`). The step is repeated with [`Newton`] where another iteration does not halve the residual, or
//! where its root may not be the one that continues the motion: where ∇g changes by more than half of itself during the
//! step, or the guess was wrong by more than a small part of the path.
//!
//! Sources: C. Broyden, Math. Comp. 19 (1965) 577; C. Kelley, *Iterative Methods for Linear and Nonlinear Equations*
//! (1995), 7.3, for Broyden's method with limited memory; E. Barth, K. Kuczera, B. Leimkuhler, R. Skeel, J. Comput.
//! Chem. 16 (1995) 1192, for the symmetric part.

use std::fmt::Debug;

/// An iteration for position equations; see the [module](self).
pub trait Iteration: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// Which iteration this is.
    const KIND: Kind;
}

/// The iterations.
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

/// Newton's method, with the exact derivative; the default.
///
/// It needs the fewest evaluations of g, and is the only iteration that works where steps are long compared with the
/// radius of curvature. On the lemniscate and on a chain of 1000 links no other iteration was faster.
#[doc(alias = "solver")]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Newton;

/// Iteration with the symmetric part of the derivative at the guess, which for h → 0 is the derivative itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Symmetric;

/// Iteration with G M⁻¹ Gᵀ at the start of the step, Newton's method simplified.
///
/// This matrix is that of the last momentum equation, so its factorisation is already known. A step evaluates the
/// gradient only at its end, but more values of g than with [`Newton`].
#[doc(alias = "modified Newton")]
#[doc(alias = "chord method")]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Simplified;

/// Broyden's method: it begins with the matrix of [`Simplified`], and improves the matrix from each residual.
///
/// A step evaluates the gradient only at its end. Use it where a gradient costs more than a value of g.
#[doc(alias = "quasi-Newton")]
#[doc(alias = "secant")]
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
