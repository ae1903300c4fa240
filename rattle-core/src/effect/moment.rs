//! Time and positions: the input of an effect.

/// The positions of the bodies at one time.
#[derive(Debug, Clone, Copy)]
pub struct Moment<'a, T, const D: usize> {
    /// The time t.
    pub time: f64,
    /// The positions q of all bodies.
    pub positions: &'a [[T; D]],
}
