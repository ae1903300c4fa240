//! What links of a [component of few equations](super::dense) are evaluated at, and what they are there.

/// Bodies of such a component at most, with those that are pinned.
pub(crate) const PLACES: usize = 6;

/// Vectors of the bodies, and past them those of what is pinned.
pub(crate) type Places<const D: usize> = [[f64; D]; PLACES];

/// What is evaluated of one equation, read where it is: numbers that are written one by one, and soon read two at a
/// time, must go through the cache, which takes as long as 50 operations.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Evaluated<const D: usize> {
    /// g, or d²g/dt² along the velocities.
    pub(crate) value: f64,
    /// |∇²g v|².
    pub(crate) turn: f64,
    /// ∂g/∂q of each body.
    pub(crate) blocks: Places<D>,
}
