//! Effects of a sweep: lanes side by side, each with parameters of its own.

use crate::effect::{Acting, OnEach, Superposed};
use crate::kernel::Potential;
use crate::lanes::{Lane, Lanes, side_by_side};

/// Effects on L lanes of one body each, every lane with parameters of its own; kept so that a loop over lanes reads their
/// numbers in the order in which they lie.
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

impl<S: Lane, const D: usize> Swept<S, D> for () {
    type Lane = ();

    #[inline(always)]
    fn lane(&self, _: usize) {}
    #[inline(always)]
    fn kick(&self, _: usize, _: &[S; D], _: S, p: [S; D]) -> [S; D] {
        p
    }
    fn copy(&mut self, _: usize, _: usize) {}
}

impl<S: Lane, A: Swept<S, D>, F: Swept<S, D>, const D: usize> Swept<S, D> for Superposed<A, F> {
    type Lane = Superposed<A::Lane, F::Lane>;

    #[inline(always)]
    fn lane(&self, lane: usize) -> Self::Lane {
        Superposed { effect: self.effect.lane(lane), name: self.name, others: self.others.lane(lane) }
    }
    #[inline(always)]
    fn kick(&self, lane: usize, q: &[S; D], c: S, p: [S; D]) -> [S; D] {
        self.effect.kick(lane, q, c, self.others.kick(lane, q, c, p))
    }
    fn copy(&mut self, from: usize, to: usize) {
        self.effect.copy(from, to);
        self.others.copy(from, to);
    }
}

/// A potential on the body of each lane: the kernel whose numbers are lanes.
#[derive(Debug)]
pub struct OnEachLane<P: Potential<D>, S: Lane, const L: usize, const D: usize>(P::Kernel<Lanes<S, L>>);

impl<P: Potential<D>, S: Lane, const L: usize, const D: usize> OnEachLane<P, S, L, D> {
    pub(super) fn new<'a>(lane: impl Fn(usize) -> &'a P) -> Self
    where
        P: 'a,
    {
        Self(side_by_side(
            |i| lane(i).kernel::<S>(),
            |kernel, number| drop(P::map_kernel::<S, S>(kernel, number)),
            |kernel, number| P::map_kernel(kernel, number),
        ))
    }
}

impl<P: Potential<D>, S: Lane, const L: usize, const D: usize> Clone for OnEachLane<P, S, L, D> {
    #[inline(always)]
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<P: Potential<D>, S: Lane, const L: usize, const D: usize> Swept<S, D> for OnEachLane<P, S, L, D> {
    type Lane = OnEach<P::Kernel<S>>;

    #[inline(always)]
    fn lane(&self, lane: usize) -> Self::Lane {
        OnEach(P::map_kernel(&self.0, |number| number.0[lane]))
    }
    #[inline(always)]
    fn kick(&self, lane: usize, q: &[S; D], c: S, p: [S; D]) -> [S; D] {
        Swept::lane(self, lane).kick(q, c, p)
    }
    fn copy(&mut self, from: usize, to: usize) {
        self.0 = P::map_kernel(&self.0, |number| number.copied(from, to));
    }
}

/// One after the other: effects that hold more than numbers.
impl<S: Lane, A: Acting<S, D>, const L: usize, const D: usize> Swept<S, D> for [A; L] {
    type Lane = A;

    fn lane(&self, lane: usize) -> A {
        self[lane].clone()
    }
    #[inline(always)]
    fn kick(&self, lane: usize, q: &[S; D], c: S, p: [S; D]) -> [S; D] {
        self[lane].kick(q, c, p)
    }
    fn copy(&mut self, from: usize, to: usize) {
        self[to] = self[from].clone();
    }
}
