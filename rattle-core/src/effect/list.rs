//! All effects of a scene, as a list in its type. `()` is the empty list; [`With`] adds an effect, and [`Superposed`]
//! the same over a scalar. The empty list has a force of size zero, so the compiler removes the force phase of a step.

use crate::effect::force::{Absent, Force};
use crate::effect::interval::{Inertia, Interval, Manner, Rule};
use crate::effect::moment::Moment;
use crate::effect::noise::Noise;
use crate::effect::one::{Acting, Effect};
use crate::effect::ornstein_uhlenbeck::OrnsteinUhlenbeck;
use crate::effect::swept::Swept;
use crate::error::{EffectMistake, Error};
use crate::kernel::series::Order;
use crate::number::lanes::{Lane, Lanes};
use crate::number::real::Real;
use std::fmt::Debug;
use std::marker::PhantomData;

/// All effects of a scene, as the scene is given them.
pub trait Effects<const D: usize> {
    /// The effects over the scalar `T`.
    type Forces<T: Real>: Forces<T, D>;
    /// The effects over the scalar `T`, with the parameters of this value.
    fn forces<T: Real>(&self) -> Self::Forces<T>;

    /// The list in L SIMD lanes, each with parameters of its own.
    type Swept<S: Lane, const L: usize>: Swept<S, L, D, Lane = Self::Forces<S>>;
    /// The list in lanes, lane i with the parameters of `lane(i)`.
    fn swept<'a, S: Lane, const L: usize>(lane: impl Fn(usize) -> &'a Self) -> Self::Swept<S, L>
    where
        Self: 'a;

    /// Checks the effects in a scene of this number of bodies.
    ///
    /// # Errors
    /// Those of [`Effect::check`], of the first effect that is wrong.
    fn check(&self, _bodies: usize) -> Result<(), Error> {
        Ok(())
    }
}

/// All effects of a scene over the scalar `T`: the sum of its [`Acting`] members.
pub trait Forces<T: Real, const D: usize>: Clone + Send + Sync + 'static {
    /// The force stored for each body: `[T; D]`, or [`Absent`].
    type Force: Force<T, D>;
    /// The [working memory](Acting::Room) of all effects.
    type Room: Clone + Debug + Send + Sync + 'static;
    /// The number of effects that are [flows](crate::effect::Flow) of momenta.
    const FLOWS: usize;
    /// Whether one of the flows does [work](crate::effect::Flow::WORKS).
    const WORKS: bool;
    /// The number of effects.
    const EFFECTS: usize;
    /// Whether one of the effects has a [memory](Acting::REMEMBERS).
    const REMEMBERS: bool;
    /// Whether one of the effects [looks](Acting::LOOKS) at the bodies before a run.
    const LOOKS: bool = false;
    /// Whether all flows are [pushes](Acting::PUSHES).
    const PUSHES: bool;
    /// Whether the force on each body is independent of the other bodies, see [`Acting::ON_EACH`].
    const ON_EACH: bool;
    /// Working memory for `bodies` bodies, made before the first step.
    fn room(&self, bodies: usize) -> Self::Room;

    /// The number of numbers in the memory of the effects, see [`Acting::marks`], in the order of the effects.
    fn marks(&self, _bodies: usize) -> usize {
        0
    }
    /// Writes the memory of the effects at the start of a run.
    ///
    /// # Errors
    /// That of the first effect that cannot act, with the name of its type.
    fn first_marks(
        &self,
        _during: &Interval<'_, T, D>,
        _marks: &mut [T],
    ) -> Result<(), (&'static str, EffectMistake)> {
        Ok(())
    }
    /// Checks that the effects can act on these bodies, at the start of a run.
    ///
    /// # Errors
    /// That of the first effect that cannot, with the name of its type.
    fn fits(&self, _during: &Interval<'_, T, D>) -> Result<(), (&'static str, EffectMistake)> {
        Ok(())
    }
    /// Lets flow number `number` update its memory, see [`Acting::take_note`].
    fn take_note(&self, _number: usize, _during: &Interval<'_, T, D>, _marks: &mut [T]) {}

    /// Whether forces at fixed positions change with time.
    fn changes_with_time(&self) -> bool;
    /// The properties of flow number `number`, counted from 0, and the name of its type.
    fn manner(&self, _number: usize) -> (Manner, &'static str) {
        (Manner { rule: Rule::Symmetric, feels: false, pushes: false }, "")
    }
    /// The [parameters](Acting::parameters) of flow number `number`.
    fn parameters(&self, _number: usize) -> Vec<f64> {
        Vec::new()
    }
    /// Writes the changes of the momenta by flow number `number`.
    fn flow(
        &self,
        _number: usize,
        _during: &Interval<'_, T, D>,
        _room: &mut Self::Room,
        changes: &mut [[T; D]],
    ) {
        changes.fill([T::from_f64(0.0); D]);
    }
    /// Flow number `number` as an [Ornstein–Uhlenbeck process](Acting::ornstein_uhlenbeck) in a time `h`, if it is one.
    fn ornstein_uhlenbeck(&self, _number: usize, _h: f64) -> Option<OrnsteinUhlenbeck> {
        None
    }
    /// The [matrix](Acting::linear) of a body of these masses by flow number `number`, if it has one.
    fn linear(
        &self,
        _number: usize,
        _h: f64,
        _body: usize,
        _inertia: &dyn Inertia<f64, D>,
    ) -> Option<[[f64; D]; D]> {
        None
    }
    /// The name of the type of the first effect that cannot act in the lanes of an ensemble: one that needs working
    /// memory or [remembers](Acting::REMEMBERS), or a force that depends on time.
    fn not_in_lanes(&self) -> Option<&'static str> {
        None
    }

    /// Sets the force on every body. Neither allocates nor panics.
    fn evaluate(&self, at: Moment<'_, T, D>, room: &mut Self::Room, forces: &mut [Self::Force]);
    /// Adds the force on every body.
    fn contribute(&self, at: Moment<'_, T, D>, room: &mut Self::Room, forces: &mut [[T; D]]);
    /// p + c f, with the force f on a body without others; see [`Acting::kick`].
    fn kick(&self, q: &[T; D], c: T, p: [T; D]) -> [T; D];
    /// Adds the force of effect number `number` alone, counted from 0, and returns the name of its type; `None` for a
    /// flow.
    fn contribute_alone(
        &self,
        _number: usize,
        _at: Moment<'_, T, D>,
        _room: &mut Self::Room,
        _forces: &mut [[T; D]],
    ) -> Option<&'static str> {
        None
    }
    /// U, summed over the effects. May allocate.
    fn energy(&self, at: Moment<'_, T, D>) -> T;
    /// Appends U of each effect that is not a flow, in the order of the scene. May allocate.
    fn energies(&self, _at: Moment<'_, T, D>, _to: &mut Vec<T>) {}
    /// The name of the type of the first effect whose U is not a number. May allocate.
    fn without_energy(&self, _at: Moment<'_, T, D>) -> Option<&'static str> {
        None
    }
    /// ∂U/∂t, summed over the effects. Neither allocates nor panics.
    fn power(&self, at: Moment<'_, T, D>) -> T;
    /// The name of the type of the first effect whose force on `body` is not finite, and that force. Allocates.
    fn culprit(&self, at: Moment<'_, T, D>, body: usize) -> Option<(&'static str, [T; D])>;

    /// The number of blocks of [products](crate::kernel::series) for a coefficient of all forces; `None` if one of them
    /// has no power series.
    fn series_blocks(&self, bodies: usize) -> Option<usize>;
    /// Adds the next coefficient of the power series of the forces in time, from that of the positions.
    fn contribute_series<const FIRST: bool>(
        &self,
        positions: &[[T; D]],
        forces: &mut [[T; D]],
        order: &mut Order<'_, T, FIRST>,
    );
}

/// The effects `E` and a further effect `P` of this [kind](Effect).
#[derive(Debug, Clone, Copy)]
pub struct With<E, P, Kind> {
    pub(crate) others: E,
    pub(crate) effect: P,
    /// What messages call it.
    pub(crate) name: &'static str,
    pub(crate) kind: PhantomData<Kind>,
}

impl<const D: usize> Effects<D> for () {
    type Forces<T: Real> = ();
    fn forces<T: Real>(&self) {}

    type Swept<S: Lane, const L: usize> = ();
    fn swept<'a, S: Lane, const L: usize>(_: impl Fn(usize) -> &'a Self) {}
}

impl<T: Real, const D: usize> Forces<T, D> for () {
    type Force = Absent;
    type Room = ();
    const FLOWS: usize = 0;
    const WORKS: bool = false;
    const EFFECTS: usize = 0;
    const REMEMBERS: bool = false;
    const PUSHES: bool = true;
    const ON_EACH: bool = true;
    fn room(&self, _: usize) {}

    #[inline(always)]
    fn changes_with_time(&self) -> bool {
        false
    }
    #[inline(always)]
    fn evaluate(&self, _: Moment<'_, T, D>, (): &mut (), _: &mut [Absent]) {}
    #[inline(always)]
    fn contribute(&self, _: Moment<'_, T, D>, (): &mut (), _: &mut [[T; D]]) {}
    #[inline(always)]
    fn kick(&self, _: &[T; D], _: T, p: [T; D]) -> [T; D] {
        p
    }
    fn energy(&self, _: Moment<'_, T, D>) -> T {
        T::from_f64(0.0)
    }
    #[inline(always)]
    fn power(&self, _: Moment<'_, T, D>) -> T {
        T::from_f64(0.0)
    }
    fn culprit(&self, _: Moment<'_, T, D>, _: usize) -> Option<(&'static str, [T; D])> {
        None
    }
    fn series_blocks(&self, _: usize) -> Option<usize> {
        Some(0)
    }
    #[inline(always)]
    fn contribute_series<const FIRST: bool>(
        &self,
        _: &[[T; D]],
        _: &mut [[T; D]],
        _: &mut Order<'_, T, FIRST>,
    ) {
    }
}

impl<E: Effects<D>, P: Effect<D, Kind>, Kind, const D: usize> Effects<D> for With<E, P, Kind> {
    type Forces<T: Real> = Superposed<<P as Effect<D, Kind>>::Acting<T>, E::Forces<T>>;

    fn forces<T: Real>(&self) -> Self::Forces<T> {
        Superposed { effect: self.effect.acting(), name: self.name, others: self.others.forces() }
    }

    type Swept<S: Lane, const L: usize> = Superposed<<P as Effect<D, Kind>>::Swept<S, L>, E::Swept<S, L>>;

    fn swept<'a, S: Lane, const L: usize>(lane: impl Fn(usize) -> &'a Self) -> Self::Swept<S, L>
    where
        Self: 'a,
    {
        let (effect, others) = (P::swept(|i| &lane(i).effect), E::swept(|i| &lane(i).others));
        Superposed { effect, name: lane(0).name, others }
    }

    fn check(&self, bodies: usize) -> Result<(), Error> {
        self.others.check(bodies)?;
        self.effect.check(self.name, bodies)
    }
}

/// The effects `F` and a further effect `A`, over a scalar: the sum of their forces.
#[derive(Debug, Clone)]
pub struct Superposed<A, F> {
    effect: A,
    name: &'static str,
    others: F,
}

impl<T: Real, A: Acting<T, D>, F: Forces<T, D>, const D: usize> Forces<T, D> for Superposed<A, F> {
    type Force = [T; D];
    type Room = (F::Room, A::Room);
    const FLOWS: usize = F::FLOWS + A::FLOWS as usize;
    const WORKS: bool = F::WORKS || (A::FLOWS && A::WORKS);
    const EFFECTS: usize = F::EFFECTS + 1;
    const REMEMBERS: bool = F::REMEMBERS || A::REMEMBERS;
    const LOOKS: bool = F::LOOKS || A::LOOKS;
    const PUSHES: bool = F::PUSHES && (A::PUSHES || !A::FLOWS);
    const ON_EACH: bool = F::ON_EACH && A::ON_EACH;
    fn room(&self, bodies: usize) -> Self::Room {
        (self.others.room(bodies), self.effect.room(bodies))
    }

    fn marks(&self, bodies: usize) -> usize {
        self.others.marks(bodies) + self.effect.marks(bodies)
    }
    fn first_marks(
        &self,
        during: &Interval<'_, T, D>,
        marks: &mut [T],
    ) -> Result<(), (&'static str, EffectMistake)> {
        let (others, own) = marks.split_at_mut(self.others.marks(during.at.positions.len()));
        self.others.first_marks(during, others)?;
        let noise = Noise { effect: F::FLOWS as u64, ..during.noise };
        self.effect.first_marks(&Interval { noise, ..*during }, own).map_err(|mistake| (self.name, mistake))
    }
    fn fits(&self, during: &Interval<'_, T, D>) -> Result<(), (&'static str, EffectMistake)> {
        self.others.fits(during)?;
        self.effect.fits(during).map_err(|mistake| (self.name, mistake))
    }
    fn take_note(&self, number: usize, during: &Interval<'_, T, D>, marks: &mut [T]) {
        let (others, own) = marks.split_at_mut(self.others.marks(during.at.positions.len()));
        if number < F::FLOWS {
            self.others.take_note(number, during, others);
        } else {
            self.effect.take_note(during, own);
        }
    }

    #[inline(always)]
    fn changes_with_time(&self) -> bool {
        self.others.changes_with_time() || self.effect.changes_with_time()
    }
    fn manner(&self, number: usize) -> (Manner, &'static str) {
        if number < F::FLOWS { self.others.manner(number) } else { (self.effect.manner(), self.name) }
    }
    fn parameters(&self, number: usize) -> Vec<f64> {
        if number < F::FLOWS { self.others.parameters(number) } else { self.effect.parameters() }
    }
    #[inline(always)]
    fn flow(
        &self,
        number: usize,
        during: &Interval<'_, T, D>,
        (others, own): &mut Self::Room,
        changes: &mut [[T; D]],
    ) {
        let (of_others, of_own) = match const { Self::REMEMBERS } {
            true => during.marks.split_at(self.others.marks(during.at.positions.len())),
            false => (during.marks, during.marks),
        };
        if number < F::FLOWS {
            self.others.flow(number, &Interval { marks: of_others, ..*during }, others, changes);
        } else {
            self.effect.flow(&Interval { marks: of_own, ..*during }, own, changes);
        }
    }
    fn ornstein_uhlenbeck(&self, number: usize, h: f64) -> Option<OrnsteinUhlenbeck> {
        if number < F::FLOWS {
            self.others.ornstein_uhlenbeck(number, h)
        } else {
            self.effect.ornstein_uhlenbeck(h)
        }
    }
    fn linear(
        &self,
        number: usize,
        h: f64,
        body: usize,
        inertia: &dyn Inertia<f64, D>,
    ) -> Option<[[f64; D]; D]> {
        if number < F::FLOWS {
            self.others.linear(number, h, body, inertia)
        } else {
            self.effect.linear(h, body, inertia)
        }
    }
    fn not_in_lanes(&self) -> Option<&'static str> {
        let timed = !A::FLOWS && self.effect.changes_with_time();
        match self.others.not_in_lanes() {
            None if size_of::<A::Room>() > 0 || A::REMEMBERS || timed => Some(self.name),
            other => other,
        }
    }
    #[inline(always)]
    fn evaluate(&self, at: Moment<'_, T, D>, room: &mut Self::Room, forces: &mut [[T; D]]) {
        if const { Self::ON_EACH } {
            // Each force is written once: who reads it next need not wait for several writes to be gathered.
            for (q, force) in at.positions.iter().zip(forces) {
                *force = self.kick(q, T::from_f64(1.0), Force::zero());
            }
            return;
        }
        forces.fill(Force::zero());
        self.contribute(at, room, forces);
    }
    #[inline(always)]
    fn contribute(&self, at: Moment<'_, T, D>, (others, own): &mut Self::Room, forces: &mut [[T; D]]) {
        self.others.contribute(at, others, forces);
        self.effect.add_forces(at, own, forces);
    }
    #[inline(always)]
    fn kick(&self, q: &[T; D], c: T, p: [T; D]) -> [T; D] {
        self.effect.kick(q, c, self.others.kick(q, c, p))
    }
    fn contribute_alone(
        &self,
        number: usize,
        at: Moment<'_, T, D>,
        (others, own): &mut Self::Room,
        forces: &mut [[T; D]],
    ) -> Option<&'static str> {
        if number < F::EFFECTS {
            return self.others.contribute_alone(number, at, others, forces);
        }
        self.effect.add_forces(at, own, forces);
        (!A::FLOWS).then_some(self.name)
    }
    fn energy(&self, at: Moment<'_, T, D>) -> T {
        self.others.energy(at) + self.effect.energy(at)
    }
    fn energies(&self, at: Moment<'_, T, D>, to: &mut Vec<T>) {
        self.others.energies(at, to);
        if !A::FLOWS {
            to.push(self.effect.energy(at));
        }
    }
    fn without_energy(&self, at: Moment<'_, T, D>) -> Option<&'static str> {
        self.others.without_energy(at).or_else(|| {
            let energy = self.effect.energy(at);
            energy.lanes().any(f64::is_nan).then_some(self.name)
        })
    }
    #[inline(always)]
    fn power(&self, at: Moment<'_, T, D>) -> T {
        self.others.power(at) + self.effect.power(at)
    }
    fn culprit(&self, at: Moment<'_, T, D>, body: usize) -> Option<(&'static str, [T; D])> {
        self.others.culprit(at, body).or_else(|| {
            let bodies = at.positions.len();
            let mut forces = vec![Force::zero(); bodies];
            self.effect.add_forces(at, &mut self.effect.room(bodies), &mut forces);
            let force = forces[body];
            let finite = force.iter().all(|f| f.lanes().all(f64::is_finite));
            (!finite).then_some((self.name, force))
        })
    }
    fn series_blocks(&self, bodies: usize) -> Option<usize> {
        Some(self.others.series_blocks(bodies)? + self.effect.series_blocks(bodies)?)
    }
    #[inline(always)]
    fn contribute_series<const FIRST: bool>(
        &self,
        positions: &[[T; D]],
        forces: &mut [[T; D]],
        order: &mut Order<'_, T, FIRST>,
    ) {
        self.others.contribute_series(positions, forces, order);
        self.effect.add_series(positions, forces, order);
    }
}

impl<S: Lane, const L: usize, const D: usize> Swept<S, L, D> for () {
    type Lane = ();

    #[inline(always)]
    fn lane(&self, _: usize) {}
    #[inline(always)]
    fn kick(&self, _: usize, _: &[S; D], _: S, p: [S; D]) -> [S; D] {
        p
    }
    fn copy(&mut self, _: usize, _: usize) {}
    fn series_blocks(&self) -> Option<usize> {
        Some(0)
    }
}

impl<S: Lane, A, F, const L: usize, const D: usize> Swept<S, L, D> for Superposed<A, F>
where
    A: Swept<S, L, D>,
    F: Swept<S, L, D>,
{
    type Lane = Superposed<A::Lane, F::Lane>;
    const FLOWS: usize = F::FLOWS + A::FLOWS;

    #[inline(always)]
    fn lane(&self, lane: usize) -> Self::Lane {
        Superposed { effect: self.effect.lane(lane), name: self.name, others: self.others.lane(lane) }
    }
    #[inline(always)]
    fn kick(&self, lane: usize, q: &[S; D], c: S, p: [S; D]) -> [S; D] {
        self.effect.kick(lane, q, c, self.others.kick(lane, q, c, p))
    }
    #[inline(always)]
    fn flow(&self, lane: usize, number: usize, during: &Interval<'_, S, D>, changes: &mut [[S; D]]) {
        if number < F::FLOWS {
            self.others.flow(lane, number, during, changes);
        } else {
            self.effect.flow(lane, number - F::FLOWS, during, changes);
        }
    }
    fn copy(&mut self, from: usize, to: usize) {
        self.effect.copy(from, to);
        self.others.copy(from, to);
    }
    fn series_blocks(&self) -> Option<usize> {
        Some(self.others.series_blocks()? + self.effect.series_blocks()?)
    }
    fn take_over(&mut self, lane: usize, others: &Self, from: usize) {
        self.effect.take_over(lane, &others.effect, from);
        self.others.take_over(lane, &others.others, from);
    }
    #[inline(always)]
    fn add_series<const FIRST: bool>(
        &self,
        q: &[Lanes<S, L>; D],
        force: &mut [Lanes<S, L>; D],
        order: &mut Order<'_, Lanes<S, L>, FIRST>,
    ) {
        self.others.add_series(q, force, order);
        self.effect.add_series(q, force, order);
    }
}
