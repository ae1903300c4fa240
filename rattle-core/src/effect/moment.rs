//! When and where: what an effect sees of the bodies.

/// The bodies at one moment.
#[derive(Debug, Clone, Copy)]
pub struct Moment<'a, T, const D: usize> {
    /// The time t.
    pub time: f64,
    /// The positions q of all bodies in turn.
    pub positions: &'a [[T; D]],
}
