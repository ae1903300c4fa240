//! Readings of a simulation: time, positions and momenta, energies, residuals, multipliers.

use crate::effect::list::Forces;
use crate::motion::bodies::{Alone, Count};
use crate::motion::identity::Identity;
use crate::motion::method::Method;
use crate::motion::parts::BodiesOf;
use crate::motion::state::{Remembered, State};
use crate::motion::system::System;
use crate::number::clock::after_steps;
use crate::number::vector::larger_or_nan;
use crate::run::answers::{self, vectors};
use crate::run::simulation::Simulation;
use crate::run::watch::seen::{Page, write};
use crate::run::watch::sight::{Sight, Source};
use crate::systems::linked::kept::{Counts, Linked};
use nalgebra::SVector;

impl<Y: System<f64, D>, S: Method, const D: usize> Simulation<Y, S, D> {
    /// Steps taken so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The time: that of the start (by default 0) plus steps × step size or, where steps differ in length, plus their
    /// sum.
    pub fn time(&self) -> f64 {
        self.exact_time().0
    }

    /// The time and what rounding took from it: the same after any number of stops and starts on the way.
    fn exact_time(&self) -> (f64, f64) {
        if self.method.time_taken(self.memory.as_ref()).is_some() {
            return self.clock;
        }
        after_steps(self.clock, self.steps, self.method.step_size())
    }

    /// The time of the momenta: half a step later than [`Self::time`] with the staggered leapfrog, half a step earlier
    /// with SHAKE.
    pub fn momentum_time(&self) -> f64 {
        self.time() + self.method.momentum_delay()
    }

    /// The step size of the method.
    #[doc(alias = "dt")]
    #[doc(alias = "timestep")]
    pub fn step_size(&self) -> f64 {
        self.method.step_size()
    }

    /// The system: bodies, constraints and forces.
    pub fn system(&self) -> &Y {
        &self.system
    }

    /// The method.
    pub fn method(&self) -> &S {
        &self.method
    }

    /// The number of bodies.
    pub fn bodies(&self) -> usize {
        self.bodies.q.as_ref().len()
    }

    /// Positions of the bodies in order, as an iterator: `.positions().nth(1)` is that of body 1.
    pub fn positions(&self) -> impl ExactSizeIterator<Item = SVector<f64, D>> + '_ {
        vectors(self.bodies.q.as_ref())
    }

    /// Momenta p of the bodies in order; with unit masses also velocities.
    pub fn momenta(&self) -> impl ExactSizeIterator<Item = SVector<f64, D>> + '_ {
        vectors(self.bodies.p.as_ref())
    }

    /// Velocities q̇ = M⁻¹p of the bodies in order; for a rigid body the nine entries of Q̇ = Q Ω̂, row by row.
    pub fn velocities(&self) -> impl ExactSizeIterator<Item = SVector<f64, D>> + '_ {
        (0..self.bodies()).map(|i| self.system.velocity(&self.bodies, i).into())
    }

    /// The memory of the method: numbers kept from step to step; empty for a one-step method.
    pub fn memory(&self) -> &[f64] {
        self.memory.as_ref()
    }

    /// The memory of the effects: numbers kept from step to step, such as the headings of
    /// [`SelfPropulsion`](crate::effect::SelfPropulsion), in the order of the effects. Empty where no effect has a
    /// memory.
    pub fn marks(&self) -> &[f64] {
        &self.bodies.marks
    }

    /// The present state, from which a new simulation with the same method continues bit for bit; steps, work and
    /// energy errors are then counted from there. (Linked bodies whose equations have become dependent may choose
    /// another [linear algebra](crate::systems::network::LinearAlgebra) at the new start, and then round differently;
    /// so do two dozen and more components that are alike, in their first steps. A
    /// [checkpoint](crate::run::checkpoint) continues them bit for bit too.)
    #[doc(alias = "restart")]
    #[doc(alias = "snapshot")]
    pub fn state(&self) -> State<D> {
        let (time, time_low) = self.exact_time();
        let numbers = [self.memory.as_ref(), &self.bodies.marks].concat();
        let remembered = (!numbers.is_empty()).then(|| Remembered {
            method: self.method.identity(),
            system: Identity::of_system(&self.system, &self.bodies),
            numbers: numbers.into(),
        });
        let (steps, number) = (self.first.step.wrapping_add(self.steps), self.number);
        State { bodies: self.bodies.all(), time, time_low, remembered, steps, number, other_momenta: None }
    }

    /// Kinetic energy K = pᵀM⁻¹p/2, summed over the bodies; in phase space all of the energy H(q, p).
    pub fn kinetic_energy(&self) -> f64 {
        self.system.kinetic_energy(&self.bodies)
    }

    /// The number of independent momenta: the number of coordinates of bodies that are not pinned, minus the number of
    /// independent equations (counted by the normals of the last step). Momenta that forces conserve, such as the total
    /// one, count as well.
    #[doc(alias = "degrees of freedom")]
    pub fn freedom(&self) -> usize {
        self.system.freedom(&self.bodies)
    }

    /// The temperature kT of the present momenta, an energy: 2K divided by the number of
    /// [independent momenta](Self::freedom).
    ///
    /// NaN where there are no independent momenta, and in phase space, which has no masses. K is here without the
    /// motion that moving links impose on bodies, which is not heat.
    #[doc(alias = "kT")]
    pub fn temperature(&self) -> f64 {
        answers::temperature(&self.system, &self.bodies)
    }

    /// Potential energy U of all effects.
    pub fn potential_energy(&self) -> f64 {
        self.system.potential_energy(&self.bodies)
    }

    /// U of each effect in the order of the scene, without [flows](crate::effect::Flow), which have none.
    pub fn effect_energies(&self) -> Vec<f64> {
        answers::effect_energies(&self.system, &self.bodies)
    }

    /// Energy H = K + U.
    #[doc(alias = "Hamiltonian")]
    #[doc(alias = "total energy")]
    pub fn energy(&self) -> f64 {
        self.kinetic_energy() + self.potential_energy()
    }

    /// The work done on the bodies since the start, an energy, by
    ///
    /// * moving constraints, −∫ λᵀ ∂g/∂t dt, and potentials that change with time, ∫ ∂U/∂t dt, to the order of the
    ///   method;
    /// * [flows](crate::effect::Flow) of momenta: drag, friction, heat, `force!`;
    /// * inelastic [impacts](Self::collide) (negative).
    ///
    /// A potential that jumps at an instant does work that is not booked: U has to be continuous in t. Where momenta
    /// are [half a step apart](Self::momentum_time), it is the work from their time at the start to their time now.
    ///
    /// ```
    /// use rattle::effect::LinearDrag;
    /// use rattle::prelude::*;
    ///
    /// let scene = Scene::point().with(LinearDrag::new(1.0)); // v = exp(−t)
    /// let mut simulation = scene.simulate(State::at([0.0]).moving([1.0]), Rattle::new(0.1))?;
    /// simulation.run(10)?;
    /// assert!((simulation.work() - 0.5 * ((-2.0_f64).exp() - 1.0)).abs() < 1e-15);
    /// # Ok::<(), rattle::Error>(())
    /// ```
    pub fn work(&self) -> f64 {
        self.bodies.work
    }

    /// The number of impacts and of crossings of edges since the start, see [`collide`](Self::collide) and
    /// [`over_kinks`](Self::over_kinks).
    pub fn events(&self) -> u64 {
        self.events.as_ref().map_or(0, |events| events.number)
    }

    /// The energy now minus the energy at the start minus the [work](Self::work) done: the energy error of the method,
    /// where nothing does work. Where something does, energy and work may be off by the same, which cancels here:
    /// [`estimate_error`](Self::estimate_error) compares energies with those of other runs.
    ///
    /// For an effect of your own that changes with time, the work is included if the effect implements
    /// [`power`](crate::effect::Acting::power). Where a potential jumps at an instant, U(q, t⁺) − U(q, t⁻) is part of
    /// this number, since no work is booked for it.
    pub fn energy_error(&self) -> f64 {
        self.energy() - self.start_energy - self.work()
    }

    /// The number of corrections in the solution of position equations since the start; `None` except for linked
    /// bodies, see [`counts`](Self::counts).
    pub fn corrections(&self) -> Option<u64> {
        self.system.corrections(&self.bodies)
    }

    /// g(q, t) of each equation, in the unit of g.
    pub fn residuals(&self) -> Vec<f64> {
        answers::residuals(&self.system, &self.bodies)
    }

    /// The largest |g(q, t)| of all equations, in the unit of g.
    pub fn constraint_residual(&self) -> f64 {
        largest(&self.residuals())
    }

    /// The largest |G(q)v + ∂g/∂t| of all equations, with v = M⁻¹p; in phase space the largest |{g, H}|.
    pub fn cotangent_residual(&self) -> f64 {
        largest(&answers::of_equations(&self.system, |out| self.system.drift_rates(&self.bodies, out)))
    }

    /// Multipliers λ of the equations (by link, then member, then equation), from g̈ = 0 at the present state; accurate
    /// to the order of the method. Where momenta are [half a step apart](Self::momentum_time), they are first brought
    /// to the time of the positions. On a surface λ = −(vᵀ∇²g v + ∇g·f)/|∇g|². Here f are potentials and driven
    /// potentials: what constraints answer to [flows](crate::effect::Flow), such as a `force!`, drag or a magnetic
    /// field, is not in λ.
    ///
    /// Of redundant equations they are those of least norm, each in the unit of a normal of length 1 in the metric of
    /// M⁻¹: how a load is divided among too many links depends on masses, not on how stiff links would be.
    pub fn multipliers(&self) -> Vec<f64> {
        self.at_one_time(&self.bodies, answers::multipliers)
    }

    /// The force Gᵀλ of all constraints on each body, in the unit of force, to the order of the method, without what
    /// they answer to flows (see [`multipliers`](Self::multipliers)): write a weight as a potential. For a pinned
    /// body it is the force of its links, without potentials that act on it.
    #[doc(alias = "reaction force")]
    #[doc(alias = "tension")]
    #[doc(alias = "stress")]
    pub fn constraint_forces(&self) -> Vec<SVector<f64, D>> {
        self.at_one_time(&self.bodies, answers::constraint_forces)
    }

    /// Writes the present state.
    pub(crate) fn look(&self, page: Page<'_, D>) {
        page.times[0] = self.time();
        write(self.bodies.q.as_ref(), page.positions);
        write(self.bodies.p.as_ref(), page.momenta);
    }
}

impl<F: Forces<f64, D>, N: Count, S: Method, const D: usize> Simulation<Linked<F, N, D>, S, D> {
    /// The cost of the position equations since the start.
    pub fn counts(&self) -> Counts {
        self.system.counts(&self.bodies)
    }
}

impl<Y: System<f64, D>, S: Method, const D: usize> Simulation<Y, S, D> {
    /// The position of the only body; for many bodies see [`Self::positions`].
    pub fn position(&self) -> SVector<f64, D>
    where
        Y::Count: Alone,
    {
        self.bodies.q.as_ref()[0].into()
    }

    /// The momentum of the only body; with unit mass also its velocity.
    pub fn momentum(&self) -> SVector<f64, D>
    where
        Y::Count: Alone,
    {
        self.bodies.p.as_ref()[0].into()
    }

    /// The velocity q̇ = M⁻¹p of the only body; for a rigid body the nine entries of Q̇ = Q Ω̂, row by row.
    pub fn velocity(&self) -> SVector<f64, D>
    where
        Y::Count: Alone,
    {
        self.system.velocity(&self.bodies, 0).into()
    }

    /// λ in M q̈ = −∇U + ∇g λ at the present state: of the first equation if there are more, NaN if there is none. See
    /// [`Self::multipliers`].
    pub fn multiplier(&self) -> f64
    where
        Y::Count: Alone,
    {
        self.multipliers().first().copied().unwrap_or(f64::NAN)
    }
}

impl<Y: System<f64, D>, S: Method, const D: usize> Simulation<Y, S, D> {
    /// Whether this is the present state, to the last bit.
    fn is_at(&self, sight: &Sight<'_, D>) -> bool {
        let (q, p) = (self.bodies.q.as_ref(), self.bodies.p.as_ref());
        sight.time == self.time()
            && vectors(q).eq(sight.positions.iter().copied())
            && vectors(p).eq(sight.momenta.iter().copied())
    }

    /// What a question has for an answer where momenta are at the time of positions.
    fn at_one_time<R>(
        &self,
        bodies: &BodiesOf<Y, f64, D>,
        question: impl FnOnce(&Y, &BodiesOf<Y, f64, D>) -> R,
    ) -> R {
        let apart = [self.method.momentum_delay(), self.method.step_size()];
        answers::at_one_time(&self.system, bodies, apart, question)
    }

    /// What a question has for an answer at the bodies that a sight shows.
    fn answer<R>(&self, sight: &Sight<'_, D>, question: impl FnOnce(&Y, &BodiesOf<Y, f64, D>) -> R) -> R {
        if self.is_at(sight) {
            return question(&self.system, &self.bodies);
        }
        question(&self.system, &answers::as_shown(&self.system, sight))
    }
}

/// What a sight shows as lists, without what rounding took.
fn show<const D: usize>(shown: &[SVector<f64, D>], list: &mut [[f64; D]], low: &mut [[f64; D]]) {
    for ((x, low), &shown) in list.iter_mut().zip(low).zip(shown) {
        (*x, *low) = (shown.into(), [0.0; D]);
    }
}

impl<Y: System<f64, D>, S: Method, const D: usize> Source<D> for Simulation<Y, S, D> {
    fn energies(&self, _: usize, sight: &Sight<'_, D>) -> [f64; 2] {
        if self.is_at(sight) {
            return answers::energies(&self.system, &self.bodies);
        }
        let Sight { time, positions, momenta, .. } = *sight;
        let mut bodies = self.before.clone();
        bodies.time = time;
        show(positions, bodies.q.as_mut(), bodies.q_low.as_mut());
        show(momenta, bodies.p.as_mut(), bodies.p_low.as_mut());
        answers::energies(&self.system, &bodies)
    }

    fn constraints(&self, _: usize, sight: &Sight<'_, D>) -> (Vec<f64>, Vec<SVector<f64, D>>) {
        self.answer(sight, |_, bodies| self.at_one_time(bodies, answers::constraints))
    }

    fn rates(&self, _: usize, sight: &Sight<'_, D>) -> [Vec<SVector<f64, D>>; 2] {
        self.answer(sight, |_, bodies| self.at_one_time(bodies, answers::rates))
    }

    fn effect_energies(&self, _: usize, sight: &Sight<'_, D>) -> Vec<f64> {
        self.answer(sight, answers::effect_energies)
    }

    fn residuals(&self, _: usize, sight: &Sight<'_, D>) -> Vec<f64> {
        self.answer(sight, answers::residuals)
    }

    fn temperature(&self, _: usize, sight: &Sight<'_, D>) -> f64 {
        self.answer(sight, answers::temperature)
    }

    fn corrections(&self) -> Option<u64> {
        self.corrections()
    }

    fn mass_product(&self, _: usize, body: usize, a: &[f64; D], b: &[f64; D]) -> f64 {
        answers::mass_product(&self.system, body, a, b)
    }

    fn step_size(&self) -> f64 {
        self.method.step_size()
    }
}

/// The largest |x|; NaN if one is.
fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |largest, x| larger_or_nan(largest, x.abs()))
}
