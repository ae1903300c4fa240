//! How multipliers are found.

/// The linear algebra for the multipliers of a component (a group of equations coupled by bodies that they share).
#[doc(alias = "sparse")]
#[doc(alias = "solver")]
#[doc(alias = "LU")]
#[doc(alias = "QR")]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LinearAlgebra {
    /// [`Orthogonal`](Self::Orthogonal) where equations depend on each other, otherwise
    /// [`Elimination`](Self::Elimination). The choice is made in every step for up to six equations, and at the start
    /// for more.
    #[default]
    Automatic,
    /// An orthonormal basis of the normals, by pivoted Gram–Schmidt, for equations that may be nearly or exactly
    /// dependent. Costs m² n operations for m equations between n coordinates, for at most 1000 coupled equations: with
    /// 800 in a net a step takes a second.
    Orthogonal,
    /// Sparse elimination on the pattern of the links. In chains and trees the cost is proportional to the number of
    /// links. Equations must be independent.
    Elimination,
    /// As [`Elimination`](Self::Elimination), but with faer's supernodal Cholesky factorisation for the momentum
    /// equation. It pays in nets of more than about 60 × 60 squares, and in lattices of more than about 8 × 8 × 8
    /// bodies. Steps solved by [`Simplified`](crate::motion::iteration::Simplified) or
    /// [`Broyden`](crate::motion::iteration::Broyden) use no other factorisation: then a lattice of 14 × 14 × 14 bodies
    /// takes a third of the time, a net of 160 × 160 squares four fifths. Last bits of results depend on the
    /// instruction set of the processor. Needs the feature `faer`.
    #[cfg(feature = "faer")]
    Supernodal,
}
