//! What a method asks of a system.

/// A system whose forces change with time, as messages name it.
pub(crate) const FORCES_CHANGE: &str = "bodies under forces that change with time";

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
    /// Momenta that are mass times velocity; constraints that do not move, and forces that do not change with time.
    Differences,
    /// The motion as a power series in time.
    Series,
}
