//! Numbers in rows that steps lead on, one of each lane: where they are, and what rounding took from that.

use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::number::vector::two_sum;
use crate::systems::network::in_lanes::{Numbers, Which, zeros};

/// Two kinds of numbers that move together, and what rounding took from both: what is kept from step to step.
pub(super) type State<const W: usize> = [Vec<Numbers<W>>; 4];

/// Numbers of one kind: where inner steps have led them, and what rounding took from that.
pub(super) struct Track<const W: usize> {
    pub(super) now: Vec<Numbers<W>>,
    pub(super) low: Vec<Numbers<W>>,
}

impl<const W: usize> Track<W> {
    /// So many numbers.
    pub(super) fn new(n: usize) -> Self {
        Self { now: vec![zeros(); n], low: vec![zeros(); n] }
    }

    /// Where this change leads number `c`, and what rounding takes from that.
    #[inline(always)]
    pub(super) fn arrive(&self, c: usize, by: &Numbers<W>, to: &mut Numbers<W>, low: &mut Numbers<W>) {
        arrive(by, [&self.now[c], &self.low[c]], to, low);
    }

    /// Has number `c` of these lanes be there.
    #[inline(always)]
    pub(super) fn take(&mut self, lanes: &Which<W>, c: usize, [to, low]: [&Numbers<W>; 2]) {
        choose(lanes, to, &mut self.now[c]);
        choose(lanes, low, &mut self.low[c]);
    }
}

/// Where two tracks are, as a [`State`].
pub(super) fn state<const W: usize>([a, b]: &mut [Track<W>; 2]) -> [&mut Vec<Numbers<W>>; 4] {
    [&mut a.now, &mut b.now, &mut a.low, &mut b.low]
}

/// Has a lane of two tracks be there.
pub(super) fn put<const W: usize>(tracks: &mut [Track<W>; 2], lane: usize, there: &[Vec<f64>; 4]) {
    for (now, there) in state(tracks).into_iter().zip(there) {
        now.iter_mut().zip(there).for_each(|(now, &there)| now.0[lane] = Fused(there));
    }
}

/// A number on its way as a sum of two.
#[inline(always)]
fn arrive<const W: usize>(
    by: &Numbers<W>,
    [from, low]: [&Numbers<W>; 2],
    sum: &mut Numbers<W>,
    rest: &mut Numbers<W>,
) {
    for l in 0..W {
        let ([high], [low]) = two_sum(&[from.0[l]], &[low.0[l] + by.0[l]]);
        (sum.0[l], rest.0[l]) = (high, low);
    }
}

/// Writes the numbers of some lanes.
#[inline(always)]
pub(super) fn choose<const W: usize>(lanes: &Which<W>, from: &Numbers<W>, to: &mut Numbers<W>) {
    for l in 0..W {
        to.0[l] = Real::select(lanes[l] != 0, from.0[l], to.0[l]);
    }
}
