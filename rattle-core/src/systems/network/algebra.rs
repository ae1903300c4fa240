//! How multipliers are found.

/// How the multipliers of a component of linked bodies are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LinearAlgebra {
    /// An orthonormal basis for a few equations and where equations depend on each other, elimination otherwise.
    #[default]
    Automatic,
    /// An orthonormal basis of the normals, by pivoted Gram–Schmidt: costs m² n operations for m equations between n
    /// coordinates, and does not mind equations that nearly or wholly depend on each other.
    Orthogonal,
    /// Elimination on the pattern of the links: costs as many operations as there are links in chains and trees; equations
    /// must be independent.
    Elimination,
    /// Elimination, in which faer's supernodal Cholesky factorisation solves the momentum equation where its blocks are dense
    /// enough to pay: in nets from about 60 × 60 squares on, in lattices in space from 8 × 8 × 8 bodies on. With
    /// `.solved_by(Simplified)` or `Broyden` that factorisation is the only one of a step. Last bits depend on the
    /// processor's instruction set. Behind the feature `faer`.
    #[cfg(feature = "faer")]
    Supernodal,
}
