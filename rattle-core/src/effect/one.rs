//! One effect: as the scene is given it, and over a scalar.

use crate::effect::force::Force;
use crate::effect::interval::{Inertia, Interval, Manner, Rule};
use crate::effect::moment::Moment;
use crate::effect::ornstein_uhlenbeck::OrnsteinUhlenbeck;
use crate::effect::swept::{OfLanes, Swept};
use crate::error::{EffectMistake, Error};
use crate::kernel::series::Order;
use crate::number::lanes::Lane;
use crate::number::real::Real;
use crate::number::vector::add_scaled;
use std::fmt::Debug;

/// An effect: the argument of `Scene::with`.
///
/// `Kind` says on which bodies the effect acts, and is inferred by the compiler: a
/// [`Potential`](crate::kernel::Potential) acts on each body ([`OnEach`](crate::effect::OnEach)), a
/// [`PairPotential`](crate::kernel::PairPotential) between every two bodies
/// ([`BetweenPairs`](crate::effect::BetweenPairs)) or those `within` a distance
/// ([`BetweenNear`](crate::effect::BetweenNear)), a potential `over` chosen bodies among these
/// ([`Among`](crate::effect::Among)); a potential that changes with time is [`Driven`](crate::effect::Driven). For an
/// effect of your own define a kind of its own, an empty struct.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no effect on bodies with {D} coordinates",
    note = "an effect is made by `potential!` with {D} variables, and perhaps the time `t`, by `force!` with {D} components, by `pair_potential!`, from a potential of several bodies by `.over(members)`, or is a `Flow<{D}>` of momenta or an `Effect` written by hand"
)]
#[doc(alias = "force")]
#[doc(alias = "interaction")]
pub trait Effect<const D: usize, Kind> {
    /// The effect over the scalar `T`.
    type Acting<T: Real>: Acting<T, D>;
    /// The effect over the scalar `T`, with the parameters of this value.
    fn acting<T: Real>(&self) -> Self::Acting<T>;

    /// The effect in L SIMD lanes, each with parameters of its own.
    type Swept<S: Lane, const L: usize>: Swept<S, L, D, Lane = Self::Acting<S>> + OfLanes<Self::Acting<S>>;
    /// The effect in lanes, lane i with the parameters of `lane(i)`.
    fn swept<'a, S: Lane, const L: usize>(lane: impl Fn(usize) -> &'a Self) -> Self::Swept<S, L>
    where
        Self: 'a,
    {
        OfLanes::of_lanes(|i| lane(i).acting::<S>())
    }

    /// Checks the effect in a scene of this number of bodies, before a run; `what` is the name of its type, for the
    /// error message.
    ///
    /// # Errors
    /// [`Error::Network`] for bodies that do not exist, [`Error::Pairs`] for a cut-off or a table that makes no sense,
    /// [`Error::Effect`] for any other parameter that makes no sense.
    fn check(&self, _what: &'static str, _bodies: usize) -> Result<(), Error> {
        Ok(())
    }
}

/// One effect over the scalar `T`: a force fᵢ(q, t) on every body i.
///
/// ```text
/// fᵢ = −∂U/∂qᵢ        in the unit of energy over that of the coordinates, D numbers for each body
/// ```
///
/// A force depends on positions and time. An effect that depends on momenta is a [`Flow`](crate::effect::Flow).
///
/// **Room.** The working memory of an effect, such as a list of near pairs, is its [`Room`](Self::Room): made before
/// the first step, kept by the system, and cloned with the simulation. It is not restored after failed steps, restarts
/// and observations, and may have been used at other positions. So forces must not depend on it, not even in the last
/// bit: it only saves work.
pub trait Acting<T: Real, const D: usize>: Clone + Send + Sync + 'static {
    /// The working memory of the effect; `()` for none.
    type Room: Clone + Debug + Send + Sync + 'static;
    /// Whether the effect is a [`Flow`](crate::effect::Flow) of momenta.
    const FLOWS: bool = false;
    /// Whether the effect, a flow, does work, as [`Flow::WORKS`](crate::effect::Flow::WORKS).
    const WORKS: bool = true;
    /// Working memory for `bodies` bodies. Everything must be allocated here.
    fn room(&self, bodies: usize) -> Self::Room;

    /// Whether forces at fixed positions, or the flow, change with time. Such forces are not computed in lanes, and
    /// have no power series.
    #[inline(always)]
    fn changes_with_time(&self) -> bool {
        false
    }

    /// Adds the force on every body. Neither allocates nor panics.
    fn add_forces(&self, at: Moment<'_, T, D>, room: &mut Self::Room, forces: &mut [[T; D]]);
    /// p + c f, with the force f on a body without others. Used in lanes, for effects without working memory that do
    /// not change with time.
    #[inline(always)]
    fn kick(&self, q: &[T; D], c: T, p: [T; D]) -> [T; D] {
        let mut force = [Force::zero()];
        self.add_forces(Moment { time: 0.0, positions: &[*q] }, &mut self.room(1), &mut force);
        add_scaled(&p, c, &force[0])
    }
    /// The potential energy U. Called by observations, not in a step; may allocate.
    fn energy(&self, at: Moment<'_, T, D>) -> T;
    /// The power ∂U/∂t of a potential that changes with time. Called in steps, if
    /// [`changes_with_time`](Self::changes_with_time); must neither allocate nor panic. 0 for forces without a
    /// potential.
    #[inline(always)]
    fn power(&self, _at: Moment<'_, T, D>) -> T {
        T::from_f64(0.0)
    }

    /// Whether the effect, a flow, keeps a memory from step to step.
    const REMEMBERS: bool = false;
    /// Whether the flow is a push: a change in proportion to h that does not depend on momenta, nor on chance but by
    /// its memory. Such a flow also acts in [Brownian motion](crate::methods::brownian::Brownian), which has no
    /// momenta.
    const PUSHES: bool = false;
    /// Whether the force on each body is independent of the other bodies, of the number of the body, and of time. It is
    /// asked for by [`kick`](Self::kick) then.
    const ON_EACH: bool = false;
    /// The number of numbers in the memory of the effect, in a scene of `bodies` bodies. The effect may depend on this
    /// memory: it is restored with the positions when a step fails, and is part of a
    /// [`State`](crate::motion::state::State).
    fn marks(&self, _bodies: usize) -> usize {
        0
    }
    /// Writes the memory at the start of a run; `marks` holds zeros before.
    ///
    /// # Errors
    /// Where the effect cannot act.
    fn first_marks(&self, _during: &Interval<'_, T, D>, _marks: &mut [T]) -> Result<(), EffectMistake> {
        Ok(())
    }
    /// Whether [`fits`](Self::fits) has anything to check.
    const LOOKS: bool = false;
    /// Checks that the effect can act on these bodies, at the start of a run.
    ///
    /// # Errors
    /// Why it cannot.
    fn fits(&self, _during: &Interval<'_, T, D>) -> Result<(), EffectMistake> {
        Ok(())
    }
    /// Updates the memory `marks`, which the interval does not hold here, as a time h passes at the present positions.
    /// Called before each flow that precedes a step, and after each flow that follows it; where flows that draw nothing
    /// act in parts of a step beside others that draw, for the whole step alone. Neither allocates nor panics.
    fn take_note(&self, _during: &Interval<'_, T, D>, _marks: &mut [T]) {}

    /// The properties of the flow. They belong to the type: a sweep takes those of one scene for those of all, so they
    /// must not depend on parameters.
    fn manner(&self) -> Manner {
        Manner { rule: Rule::Symmetric, feels: false, pushes: Self::PUSHES }
    }
    /// Parameters of the flow, as [`Flow::parameters`](crate::effect::Flow::parameters).
    fn parameters(&self) -> Vec<f64> {
        Vec::new()
    }
    /// Writes the changes of the momenta, as [`Flow::flow`](crate::effect::Flow::flow).
    fn flow(&self, _during: &Interval<'_, T, D>, _room: &mut Self::Room, changes: &mut [[T; D]]) {
        changes.fill([T::from_f64(0.0); D]);
    }

    /// The flow as an Ornstein–Uhlenbeck process, see
    /// [`Flow::ornstein_uhlenbeck`](crate::effect::Flow::ornstein_uhlenbeck).
    fn ornstein_uhlenbeck(&self, _h: f64) -> Option<OrnsteinUhlenbeck> {
        None
    }

    /// The matrix of a flow that is linear, see [`Flow::linear`](crate::effect::Flow::linear).
    fn linear(&self, _h: f64, _body: usize, _inertia: &dyn Inertia<f64, D>) -> Option<[[f64; D]; D]> {
        None
    }

    /// The number of blocks of [products](crate::kernel::series) for a coefficient of the forces; `None` without a
    /// power series.
    fn series_blocks(&self, _bodies: usize) -> Option<usize> {
        None
    }
    /// Adds the next coefficient of the power series of the forces in time, from that of the positions. Not called
    /// without a power series.
    fn add_series<const FIRST: bool>(
        &self,
        _positions: &[[T; D]],
        _forces: &mut [[T; D]],
        _order: &mut Order<'_, T, FIRST>,
    ) {
    }
}

/// One after the other: effects that hold more than numbers.
impl<S: Lane, A: Acting<S, D>, const L: usize, const D: usize> Swept<S, L, D> for [A; L] {
    type Lane = A;
    const FLOWS: usize = A::FLOWS as usize;

    fn lane(&self, lane: usize) -> A {
        self[lane].clone()
    }
    #[inline(always)]
    fn kick(&self, lane: usize, q: &[S; D], c: S, p: [S; D]) -> [S; D] {
        self[lane].kick(q, c, p)
    }
    #[inline(always)]
    fn flow(&self, lane: usize, _: usize, during: &Interval<'_, S, D>, changes: &mut [[S; D]]) {
        self[lane].flow(during, &mut self[lane].room(changes.len()), changes);
    }
    fn copy(&mut self, from: usize, to: usize) {
        self[to] = self[from].clone();
    }
}
