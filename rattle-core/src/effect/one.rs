//! One effect: as a user names it, and over a scalar.

use crate::effect::force::Force;
use crate::effect::swept::Swept;
use crate::kernel::series::Order;
use crate::number::lanes::Lane;
use crate::number::real::Real;
use crate::number::vector::add_scaled;

/// What a scene takes in `with`. The kind ([`OnEach`](crate::effect::OnEach) or [`BetweenPairs`](crate::effect::BetweenPairs)) is found by inference:
/// every [`Potential`](crate::kernel::Potential) acts on each body, every [`PairPotential`](crate::kernel::PairPotential) between every two.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no effect on bodies with {D} coordinates",
    note = "an effect is made by `potential!` with {D} variables, by `pair_potential!`, or from a potential of several bodies by `.over(members)`"
)]
pub trait Effect<const D: usize, Kind> {
    /// The effect over the scalar `T`.
    type Acting<T: Real>: Acting<T, D>;
    /// The effect with this value's parameters.
    fn acting<T: Real>(&self) -> Self::Acting<T>;

    /// The effect in L lanes, each with parameters of its own.
    type Swept<S: Lane, const L: usize>: Swept<S, D, Lane = Self::Acting<S>>;
    /// Lane i with the parameters of `lane(i)`.
    fn swept<'a, S: Lane, const L: usize>(lane: impl Fn(usize) -> &'a Self) -> Self::Swept<S, L>
    where
        Self: 'a;

    /// The first member that names a body beyond the last one, and that body.
    fn stray(&self, _bodies: usize) -> Option<(usize, usize)> {
        None
    }
}

/// One effect over the scalar `T`.
pub trait Acting<T: Real, const D: usize>: Clone + Send + Sync + 'static {
    /// Adds −∇ᵢU to the force on every body i.
    fn add_forces(&self, positions: &[[T; D]], forces: &mut [[T; D]]);
    /// p − c ∇U, for a body that is the only one.
    #[inline(always)]
    fn kick(&self, q: &[T; D], c: T, p: [T; D]) -> [T; D] {
        let mut force = [Force::zero()];
        self.add_forces(&[*q], &mut force);
        add_scaled(&p, c, &force[0])
    }
    /// U.
    fn energy(&self, positions: &[[T; D]]) -> T;

    /// Blocks of products that a coefficient of the forces takes; none if they have no power series.
    fn series_blocks(&self, _bodies: usize) -> Option<usize> {
        None
    }
    /// Adds the next coefficient of −∇ᵢU along the motion, a power series in time, from that of the positions. Not called
    /// where there is none.
    fn add_series<const FIRST: bool>(
        &self,
        _positions: &[[T; D]],
        _forces: &mut [[T; D]],
        _order: &mut Order<'_, T, FIRST>,
    ) {
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
