//! Effects in the lanes of a sweep, each lane with parameters of its own.

use crate::number::lanes::Lane;

/// Effects on L lanes of one body each, every lane with parameters of its own; kept so that a loop over lanes reads
/// their numbers in the order in which they lie.
pub trait Swept<S: Lane, const D: usize>: Clone + Send + Sync {
    /// What acts in one lane.
    type Lane;

    /// What acts in this lane, by itself.
    fn lane(&self, lane: usize) -> Self::Lane;
    /// p + c f, with the force f on the body of this lane.
    fn kick(&self, lane: usize, q: &[S; D], c: S, p: [S; D]) -> [S; D];
    /// Has lane `to` obey what lane `from` does.
    fn copy(&mut self, from: usize, to: usize);
}
