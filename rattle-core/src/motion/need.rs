//! What a method asks of a system.

/// What a method asks of a system.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Need {
    /// Drifts, forces and kicks, or rates of change and projection: every system has them.
    Verbs,
    /// A position equation along kept normals, which is solved as the method says.
    PositionEquation,
    /// Inner stages solved together.
    Stages,
    /// Momenta that are mass times velocity, and constraints that do not move.
    Differences,
    /// The motion as a power series in time.
    Series,
}
