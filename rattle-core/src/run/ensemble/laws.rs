//! The constraint and forces of the trajectories of a block: with the same parameters for all, or with parameters for
//! each trajectory.

use crate::effect::interval::Interval;
use crate::effect::list::{Effects, Forces};
use crate::effect::swept::Swept;
use crate::kernel::functions::{Constraint, ConstraintKernel};
use crate::motion::bodies::One;
use crate::number::lanes::{Lane, Lanes, side_by_side};
use crate::systems::surface::kept::{OnSurface, OneByOne};
use std::borrow::Borrow;

/// What each lane obeys. Loops read a copy of their own: what is elsewhere may be, for all that a compiler knows, what
/// the loop writes.
pub(crate) trait Laws<S: Lane, const D: usize>: Clone + Send + Sync {
    type Constraint: ConstraintKernel<S, D, 1>;
    type Forces: Forces<S, D>;

    fn constraint(&self, lane: usize) -> impl Borrow<Self::Constraint>;
    fn effects(&self, lane: usize) -> impl Borrow<Self::Forces>;
    /// p + c f, with the force f on the body of this lane.
    fn kick(&self, lane: usize, q: &[S; D], c: S, p: [S; D]) -> [S; D];
    /// Writes the change of the momentum of the body of this lane by flow number `number`.
    fn flow(&self, lane: usize, number: usize, during: &Interval<'_, S, D>, changes: &mut [[S; D]]);
    /// Has lane `to` obey what lane `from` does.
    fn copy(&mut self, from: usize, to: usize);
}

/// The system of the body of one lane by itself.
pub(super) fn system_of<S: Lane, X: Laws<S, D>, const D: usize>(
    laws: &X,
    lane: usize,
) -> OnSurface<X::Constraint, X::Forces, One, OneByOne> {
    let (constraint, effects) = (laws.constraint(lane), laws.effects(lane));
    OnSurface::new(constraint.borrow().clone(), OneByOne, effects.borrow().clone(), One)
}

/// The same for all lanes.
#[derive(Clone)]
pub(crate) struct Same<K, F>(pub(crate) K, pub(crate) F);

impl<S: Lane, K: ConstraintKernel<S, D, 1>, F: Forces<S, D>, const D: usize> Laws<S, D> for Same<K, F> {
    type Constraint = K;
    type Forces = F;

    #[inline(always)]
    fn constraint(&self, _: usize) -> impl Borrow<K> {
        &self.0
    }
    #[inline(always)]
    fn effects(&self, _: usize) -> impl Borrow<F> {
        &self.1
    }
    #[inline(always)]
    fn kick(&self, _: usize, q: &[S; D], c: S, p: [S; D]) -> [S; D] {
        self.1.kick(q, c, p)
    }
    #[inline(always)]
    fn flow(&self, _: usize, number: usize, during: &Interval<'_, S, D>, changes: &mut [[S; D]]) {
        self.1.flow(number, during, &mut self.1.room(changes.len()), changes);
    }
    fn copy(&mut self, _: usize, _: usize) {}
}

/// Each lane its own, as structures of arrays: kernels whose numbers are lanes.
pub(crate) struct Each<C: Constraint<D, 1>, E: Effects<D>, S: Lane, const L: usize, const D: usize> {
    pub(super) constraint: C::Kernel<Lanes<S, L>>,
    pub(super) effects: E::Swept<S, L>,
}

impl<C: Constraint<D, 1>, E: Effects<D>, S: Lane, const L: usize, const D: usize> Each<C, E, S, L, D> {
    /// Lane i obeys `lane(i)`.
    pub(crate) fn new<'a>(lane: impl Fn(usize) -> (&'a C, &'a E)) -> Self
    where
        C: 'a,
        E: 'a,
    {
        let constraint = side_by_side(
            |i| lane(i).0.kernel::<S>(),
            |kernel, number| drop(C::map_kernel::<S, S>(kernel, number)),
            |kernel, number| C::map_kernel(kernel, number),
        );
        Self { constraint, effects: E::swept(|i| lane(i).1) }
    }
}

impl<C: Constraint<D, 1>, E: Effects<D>, S: Lane, const L: usize, const D: usize> Clone
    for Each<C, E, S, L, D>
{
    #[inline(always)]
    fn clone(&self) -> Self {
        Self { constraint: self.constraint.clone(), effects: self.effects.clone() }
    }
}

impl<C: Constraint<D, 1>, E: Effects<D>, S: Lane, const L: usize, const D: usize> Laws<S, D>
    for Each<C, E, S, L, D>
{
    type Constraint = C::Kernel<S>;
    type Forces = E::Forces<S>;

    #[inline(always)]
    fn constraint(&self, lane: usize) -> impl Borrow<C::Kernel<S>> {
        C::map_kernel(&self.constraint, |number| number.0[lane])
    }
    #[inline(always)]
    fn effects(&self, lane: usize) -> impl Borrow<E::Forces<S>> {
        self.effects.lane(lane)
    }
    #[inline(always)]
    fn kick(&self, lane: usize, q: &[S; D], c: S, p: [S; D]) -> [S; D] {
        self.effects.kick(lane, q, c, p)
    }
    #[inline(always)]
    fn flow(&self, lane: usize, number: usize, during: &Interval<'_, S, D>, changes: &mut [[S; D]]) {
        self.effects.flow(lane, number, during, changes);
    }
    fn copy(&mut self, from: usize, to: usize) {
        self.constraint = C::map_kernel(&self.constraint, |number| number.copied(from, to));
        self.effects.copy(from, to);
    }
}

/// The same effects on all lanes.
#[derive(Clone)]
pub(super) struct Alike<G>(pub(super) G);

impl<S: Lane, G: Forces<S, D>, const L: usize, const D: usize> Swept<S, L, D> for Alike<G> {
    type Lane = G;

    #[inline(always)]
    fn lane(&self, _: usize) -> G {
        self.0.clone()
    }
    #[inline(always)]
    fn kick(&self, _: usize, q: &[S; D], c: S, p: [S; D]) -> [S; D] {
        self.0.kick(q, c, p)
    }
    fn copy(&mut self, _: usize, _: usize) {}
}
