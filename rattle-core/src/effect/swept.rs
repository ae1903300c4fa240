//! Effects in the lanes of a sweep, each lane with parameters of its own.

use crate::effect::interval::Interval;
use crate::kernel::series::Order;
use crate::number::lanes::{Lane, Lanes};

/// Effects on L lanes of one body each, every lane with parameters of its own; stored so that a loop over lanes reads
/// numbers in the order of memory.
pub trait Swept<S: Lane, const L: usize, const D: usize>: Clone + Send + Sync {
    /// The effects of one lane.
    type Lane;
    /// The number of effects that are [flows](crate::effect::Flow) of momenta.
    const FLOWS: usize = 0;

    /// The effects of this lane, by themselves.
    fn lane(&self, lane: usize) -> Self::Lane;
    /// p + c f, with the force f on the body of this lane.
    fn kick(&self, lane: usize, q: &[S; D], c: S, p: [S; D]) -> [S; D];
    /// Writes the change of the momentum of the body of this lane by flow number `number`, counted from 0.
    fn flow(&self, _lane: usize, _number: usize, _during: &Interval<'_, S, D>, changes: &mut [[S; D]]) {
        changes.fill([S::default(); D]);
    }
    /// Copies the parameters of lane `from` to lane `to`.
    fn copy(&mut self, from: usize, to: usize);

    /// The number of blocks of [products](crate::kernel::series) for a coefficient of the forces; `None` without a
    /// power series in lanes.
    fn series_blocks(&self) -> Option<usize> {
        None
    }
    /// Adds the next coefficient of the power series of the forces in time, from that of the positions. Not called
    /// without a power series.
    fn add_series<const FIRST: bool>(
        &self,
        _q: &[Lanes<S, L>; D],
        _force: &mut [Lanes<S, L>; D],
        _order: &mut Order<'_, Lanes<S, L>, FIRST>,
    ) {
    }
    /// Has a lane obey what a lane of others does. Not called without a power series.
    fn take_over(&mut self, _lane: usize, _others: &Self, _from: usize) {}
}

/// One effect in lanes, made of what acts in each of them.
pub trait OfLanes<A> {
    /// Lane i does what `lane(i)` does.
    fn of_lanes(lane: impl Fn(usize) -> A) -> Self;
}

impl<A, const L: usize> OfLanes<A> for [A; L] {
    fn of_lanes(lane: impl Fn(usize) -> A) -> Self {
        std::array::from_fn(lane)
    }
}
