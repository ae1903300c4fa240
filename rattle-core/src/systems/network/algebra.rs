//! How multipliers are found.

/// How the multipliers of a component of linked bodies are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LinearAlgebra {
    /// An orthonormal basis where equations depend on each other, elimination otherwise. Of up to six equations that is
    /// asked in every step, of more at the start.
    #[default]
    Automatic,
    /// An orthonormal basis of the normals, by pivoted Gram–Schmidt: costs m² n operations for m equations between n
    /// coordinates, and does not mind equations that nearly or wholly depend on each other. For at most 1000 equations
    /// that are tied together: of 800 in a net a step takes a second.
    Orthogonal,
    /// Elimination on the pattern of the links: costs as many operations as there are links in chains and trees;
    /// equations must be independent.
    Elimination,
    /// Elimination, but the momentum equation by faer's supernodal Cholesky factorisation where its dense blocks pay:
    /// in nets of more than about 60 × 60 squares, in lattices of more than about 8 × 8 × 8 bodies. Steps that are
    /// solved by [`Simplified`](crate::motion::iteration::Simplified) or [`Broyden`](crate::motion::iteration::Broyden)
    /// take no other: then a lattice of 14 × 14 × 14 bodies takes a third of the time, a net of 160 × 160 squares four
    /// fifths. Last bits depend on the processor's instructions. Needs the feature `faer`.
    #[cfg(feature = "faer")]
    Supernodal,
}
