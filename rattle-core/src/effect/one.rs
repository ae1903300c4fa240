//! One effect: as a user names it, and over a scalar.

use crate::effect::force::Force;
use crate::effect::interval::{Interval, Manner, Rule};
use crate::effect::moment::Moment;
use crate::effect::swept::Swept;
use crate::error::{EffectMistake, Error};
use crate::kernel::series::Order;
use crate::number::lanes::Lane;
use crate::number::real::Real;
use crate::number::vector::add_scaled;
use std::fmt::Debug;

/// One effect as users name it: what a scene takes in `with`.
///
/// `Kind` says on which bodies it acts, and is found by inference: a [`Potential`](crate::kernel::Potential) acts on
/// each body ([`OnEach`](crate::effect::OnEach)), a [`PairPotential`](crate::kernel::PairPotential) between every two
/// ([`BetweenPairs`](crate::effect::BetweenPairs)) or those `within` a reach
/// ([`BetweenNear`](crate::effect::BetweenNear)), and a potential `over` chosen bodies among them
/// ([`Among`](crate::effect::Among)); a potential that changes with time is [`Driven`](crate::effect::Driven). An
/// effect written by hand is of a kind of its own.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no effect on bodies with {D} coordinates",
    note = "an effect is made by `potential!` with {D} variables, and perhaps the time `t`, by `force!` with {D} components, by `pair_potential!`, from a potential of several bodies by `.over(members)`, or is a `Flow<{D}>` of momenta or an `Effect` written by hand"
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

    /// Says what is wrong with the effect in a scene of so many bodies; `what` is the name of its type. Asked before a
    /// run.
    ///
    /// # Errors
    /// [`Error::Network`] for bodies that there are not, [`Error::Pairs`] for a cut-off or a table that makes no sense,
    /// [`Error::Effect`] for another parameter that makes none.
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
/// A force depends on positions and time. What depends on momenta is a flow of them: see [`Flow`](crate::effect::Flow).
///
/// **Room.** What an effect needs besides its parameters, such as a list of near pairs, is its [`Room`](Self::Room):
/// made before the first step, kept by the system, cloned with the simulation. Steps that fail, restarts and
/// observations leave it as it happens to be, and it may have been used at other positions. So forces must not depend
/// on it, not in the last bit: room saves work, and decides nothing.
pub trait Acting<T: Real, const D: usize>: Clone + Send + Sync + 'static {
    /// Room of the effect's own; `()` for none.
    type Room: Clone + Debug + Send + Sync + 'static;
    /// Whether the effect moves momenta by a [`Flow`](crate::effect::Flow). Such an effect goes in no lanes.
    const FLOWS: bool = false;
    /// Room for so many bodies. All that is allocated is allocated here.
    fn room(&self, bodies: usize) -> Self::Room;

    /// Whether forces at the same positions change with time. Such an effect goes in no lanes, and has no power series.
    #[inline(always)]
    fn changes_with_time(&self) -> bool {
        false
    }

    /// Adds the force on every body. Neither allocates nor panics.
    fn add_forces(&self, at: Moment<'_, T, D>, room: &mut Self::Room, forces: &mut [[T; D]]);
    /// p + c f, for a body that is the only one: the way in lanes, where an effect has no room and does not change with
    /// time.
    #[inline(always)]
    fn kick(&self, q: &[T; D], c: T, p: [T; D]) -> [T; D] {
        let mut force = [Force::zero()];
        self.add_forces(Moment { time: 0.0, positions: &[*q] }, &mut self.room(1), &mut force);
        add_scaled(&p, c, &force[0])
    }
    /// U. Called by observations, not in a step; may allocate.
    fn energy(&self, at: Moment<'_, T, D>) -> T;
    /// ∂U/∂t: the power that comes with a change of U itself. Asked in a step where [time](Self::changes_with_time)
    /// changes forces, which neither allocates nor panics; none for forces without U.
    #[inline(always)]
    fn power(&self, _at: Moment<'_, T, D>) -> T {
        T::from_f64(0.0)
    }

    /// Whether the effect, which is a flow, remembers anything from step to step.
    const REMEMBERS: bool = false;
    /// Whether the flow is a push, in proportion to h and the same for all momenta: such a flow acts where there are
    /// [no momenta](crate::methods::brownian::Brownian) too.
    const PUSHES: bool = false;
    /// Whether the force on each of several bodies is that on a body which is the only one.
    const ON_EACH: bool = false;
    /// How many numbers the effect remembers from step to step in a scene of so many bodies. They decide what it does:
    /// they are put back with the places when a step fails, and a [`State`](crate::motion::state::State) takes them
    /// along.
    fn marks(&self, _bodies: usize) -> usize {
        0
    }
    /// Writes what is remembered at the start of a run; what is there are zeros.
    ///
    /// # Errors
    /// Where the effect cannot act.
    fn first_marks(&self, _during: &Interval<'_, T, D>, _marks: &mut [T]) -> Result<(), EffectMistake> {
        Ok(())
    }
    /// Changes what is remembered, which is also that of the interval, as a time h passes at the present places: asked
    /// once before each flow that comes before a step, and once after each that comes after it. Neither allocates nor
    /// panics.
    fn take_note(&self, _during: &Interval<'_, T, D>, _marks: &mut [T]) {}

    /// What a flow of momenta is like.
    fn manner(&self) -> Manner {
        Manner { rule: Rule::Symmetric, feels: false, pushes: Self::PUSHES }
    }
    /// Writes what the momenta change by, as [`Flow::flow`](crate::effect::Flow::flow) does.
    fn flow(&self, _during: &Interval<'_, T, D>, _room: &mut Self::Room, changes: &mut [[T; D]]) {
        changes.fill([T::from_f64(0.0); D]);
    }

    /// Blocks of products that a coefficient of the forces takes; none if they have no power series.
    fn series_blocks(&self, _bodies: usize) -> Option<usize> {
        None
    }
    /// Adds the next coefficient of the forces along the motion, a power series in time, from that of the positions.
    /// Not called where there is none.
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
