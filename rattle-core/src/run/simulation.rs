//! A scene under way.

use crate::effect::list::Field;
use crate::error::Error;
use crate::motion::bodies::{Bodies, Count, One};
use crate::motion::failure::Failure;
use crate::motion::method::Method;
use crate::motion::state::{Remembered, State};
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::clock::after_steps;
use crate::number::clock::later;
use crate::run::recorder::Recorder;
use crate::systems::linked::kept::{Counts, Linked};
use nalgebra::SVector;
use std::fmt;
use std::marker::PhantomData;

/// Parts of a step are counted by 32 bits.
pub(crate) const MOST_HALVINGS: u32 = 30;

/// A scene, its present state and the method that moves it on.
///
/// Made by [`crate::scene::Scene::simulate`]. A step neither allocates nor panics; if it fails, the simulation is
/// as it was before the step, bit for bit.
pub struct Simulation<Y: System<f64, D>, S: Method, const D: usize> {
    system: Y,
    method: S,
    pub(crate) bodies: Bodies<Y::Count, f64, Y::Kept, D>,
    /// Places and momenta before the step under way.
    before: Bodies<Y::Count, f64, (), D>,
    /// What the method remembers, and remembered before the step under way.
    memory: S::Memory<f64>,
    memory_before: S::Memory<f64>,
    steps: u64,
    /// The time of the start, or of now where steps differ in length, and what rounding took from it.
    clock: (f64, f64),
    start_energy: f64,
    /// How often a step that cannot be taken is halved.
    halvings: u32,
    /// If every step is to be taken back and compared.
    reversal: Option<Box<Reversal<Y, S, D>>>,
}

/// Why a step is not taken as it is.
enum Trouble {
    Failed(Failure),
    NotReversed { body: usize, off: f64, tolerance: f64 },
}

/// What it takes to take a step back and go on as if it had not been.
struct Reversal<Y: System<f64, D>, S: Method, const D: usize> {
    tolerance: f64,
    backwards: S,
    after: Bodies<Y::Count, f64, (), D>,
    /// That of a method that has not made a step.
    blank: S::Memory<f64>,
    memory: S::Memory<f64>,
}

impl<Y: System<f64, D>, S: Method, const D: usize> Simulation<Y, S, D> {
    pub(crate) fn new(
        system: Y,
        count: Y::Count,
        bodies: Bodies<Y::Count, f64, Y::Kept, D>,
        clock: (f64, f64),
        remembered: Option<&Remembered>,
        method: S,
    ) -> Self {
        let before = Bodies::new(count, (), |i| bodies.body(i), bodies.time);
        let mut memory = method.memory(&system, &bodies);
        if let Some(numbers) = remembered.and_then(|remembered| remembered.by(&method))
            && numbers.len() == memory.as_ref().len()
        {
            memory.as_mut().copy_from_slice(numbers);
        }
        let memory_before = memory.clone();
        let (steps, start_energy) = (0, 0.0);
        let mut simulation = Self {
            system,
            method,
            bodies,
            before,
            memory,
            memory_before,
            steps,
            clock,
            start_energy,
            halvings: 0,
            reversal: None,
        };
        simulation.start_energy = simulation.energy();
        simulation
    }

    /// The same simulation, in which a step that cannot be taken is taken in 2, 4, … 2^`halvings` equal parts, and that
    /// step alone; time goes on in whole steps. Without this no step is ever shortened: a run with parts is no longer the
    /// iteration of one map, and neither symplectic nor reversible there. A method that remembers starts anew before
    /// the parts and after them, which allocates. Staggered methods are not divided: their momenta belong to one step size.
    ///
    /// ```
    /// # use rattle::{Rattle, Scene, State};
    /// let free = Scene::point().simulate(State::at([0.0]).moving([1.0]), Rattle::new(0.1))?;
    /// let mut simulation = free.retry(6);
    /// # simulation.step()?;
    /// # Ok::<(), rattle::Error>(())
    /// ```
    #[must_use]
    pub fn retry(mut self, halvings: u32) -> Self {
        self.halve(halvings);
        self
    }

    pub(crate) fn halve(&mut self, halvings: u32) {
        self.halvings = halvings.min(MOST_HALVINGS);
    }

    /// The same simulation, in which every step is taken back and must lead to where it came from, in every coordinate to
    /// `tolerance`, relative to the largest coordinate or momentum: else the step fails. What is symmetric reverses to rounding,
    /// 1e-14, unless a step found another root than the way back does. With [`retry`](Self::retry) it is then
    /// taken in parts, which are taken back as well. A step then costs two, and what is kept at its end is evaluated again.
    ///
    /// ```
    /// # use rattle::{Rattle, Scene, State};
    /// let free = Scene::point().simulate(State::at([0.0]).moving([1.0]), Rattle::new(0.1))?;
    /// let mut simulation = free.check_reversal(1e-13)?;
    /// # simulation.step()?;
    /// # Ok::<(), rattle::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Tolerance`] for one that is not positive and finite, [`Error::NeedsSymmetricMethod`] for a method that does not
    /// reverse, or only together with what it remembers.
    pub fn check_reversal(mut self, tolerance: f64) -> Result<Self, Error> {
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            return Err(Error::Tolerance(tolerance));
        }
        if !self.method.is_symmetric() {
            let (what, method) = ("a check of reversal", self.method.name());
            return Err(Error::NeedsSymmetricMethod { what, method });
        }
        let backwards = self.method.with_step(-self.method.step_size());
        let memory = backwards.memory(&self.system, &self.bodies);
        let (after, blank) = (self.before.clone(), memory.clone());
        self.reversal = Some(Box::new(Reversal { tolerance, backwards, after, blank, memory }));
        Ok(self)
    }

    /// Takes one step.
    ///
    /// # Errors
    /// [`Error::Step`] says why the step cannot be taken; the simulation is then unchanged.
    #[inline(always)]
    pub fn step(&mut self) -> Result<(), Error> {
        self.advance(&mut ())
    }

    /// Takes `steps` steps.
    ///
    /// # Errors
    /// At the first step that cannot be taken; the simulation is then as the steps before left it.
    pub fn run(&mut self, steps: u64) -> Result<(), Error> {
        for _ in 0..steps {
            self.advance(&mut ())?;
        }
        Ok(())
    }

    /// Takes `steps` steps and shows the simulation to `see` after each.
    ///
    /// ```text
    /// simulation.run_with(2000, |now| energies.push(now.energy()))?;
    /// ```
    ///
    /// # Errors
    /// As [`Self::run`]; `see` has been shown every step that was taken.
    pub fn run_with(&mut self, steps: u64, mut see: impl FnMut(&Self)) -> Result<(), Error> {
        for _ in 0..steps {
            self.advance(&mut ())?;
            see(self);
        }
        Ok(())
    }

    /// Takes `steps` steps and has `recorder` record each.
    ///
    /// # Errors
    /// As [`Self::run`]; the recorder has seen every step that was taken.
    pub fn run_recording<R: Recorder<Self>>(&mut self, steps: u64, recorder: &mut R) -> Result<(), Error> {
        for _ in 0..steps {
            self.advance(&mut Listening(recorder, PhantomData::<Self>))?;
            recorder.record(self);
        }
        Ok(())
    }

    #[inline(always)]
    fn advance(&mut self, witness: &mut impl Witness<f64>) -> Result<(), Error> {
        self.before.copy_from(&self.bodies);
        self.memory_before.as_mut().copy_from_slice(self.memory.as_ref());
        match self.method.step(&self.system, &mut self.bodies, self.memory.as_mut(), witness) {
            Ok(()) => {
                if let Some(taken) = self.method.time_taken(self.memory.as_ref()) {
                    self.clock = later(self.clock, (taken, 0.0));
                }
                if self.reversal.is_some()
                    && let Err(trouble) = self.take_back(1)
                {
                    self.take_in_parts(trouble, witness)?;
                }
            }
            Err(failure) => self.take_in_parts(Trouble::Failed(failure), witness)?,
        }
        self.steps += 1;
        if self.system.moves_with_time() {
            let time = self.time();
            self.system.set_time(&mut self.bodies, time);
        }
        Ok(())
    }

    /// Takes the step in trouble in parts, as often halved as is allowed.
    #[cold]
    #[inline(never)]
    fn take_in_parts(&mut self, trouble: Trouble, witness: &mut impl Witness<f64>) -> Result<(), Error> {
        let (clock, mut trouble) = (self.clock, trouble);
        self.put_back();
        let halvings = if self.method.momentum_delay() == 0.0 { self.halvings } else { 0 };
        for halved in 1..=halvings {
            let taken = self.parts(1 << halved, witness).map_err(Trouble::Failed);
            match taken.and_then(|()| self.take_back(1 << halved)) {
                Ok(()) => return Ok(()),
                Err(again) => trouble = again,
            }
            self.clock = clock;
            self.put_back();
        }
        let (step, time) = (self.steps + 1, self.time());
        Err(match (trouble, halvings) {
            (Trouble::Failed(Failure { body, cause }), 0) => Error::Step { step, time, body, cause },
            (Trouble::Failed(Failure { body, cause }), _) => {
                Error::Retried { step, time, body, halvings, cause }
            }
            (Trouble::NotReversed { body, off, tolerance }, _) => {
                Error::NotReversed { step, time, body, off, tolerance }
            }
        })
    }

    /// Takes a step in so many parts.
    fn parts(&mut self, parts: u32, witness: &mut impl Witness<f64>) -> Result<(), Failure> {
        let method = self.method.with_step(self.method.step_size() / f64::from(parts));
        let mut memory = method.memory(&self.system, &self.bodies);
        for _ in 0..parts {
            method.step(&self.system, &mut self.bodies, memory.as_mut(), witness)?;
            if let Some(taken) = method.time_taken(memory.as_ref()) {
                self.clock = later(self.clock, (taken, 0.0));
            }
        }
        self.memory = self.method.memory(&self.system, &self.bodies);
        Ok(())
    }

    /// Takes the step just made, in so many parts, back, compares, and makes it again, if that is asked for.
    #[cold]
    #[inline(never)]
    fn take_back(&mut self, parts: u32) -> Result<(), Trouble> {
        let Some(reversal) = &mut self.reversal else { return Ok(()) };
        reversal.after.copy_from(&self.bodies);
        reversal.memory.as_mut().copy_from_slice(reversal.blank.as_ref());
        let memory = reversal.memory.as_mut();
        let backwards = reversal.backwards.with_step(reversal.backwards.step_size() / f64::from(parts));
        let back =
            (0..parts).try_for_each(|_| backwards.step(&self.system, &mut self.bodies, memory, &mut ()));
        let (mut worst, mut body, mut size) = (0.0, 0, 0.0_f64);
        for i in 0..self.bodies.q.as_ref().len() {
            let (was, is) = (self.before.body(i), self.bodies.body(i));
            let off = larger(farthest(&was.q, &is.q), farthest(&was.p, &is.p));
            size = size.max(farthest(&was.q, &[0.0; D])).max(farthest(&was.p, &[0.0; D]));
            if off > worst || off.is_nan() {
                (worst, body) = (off, i);
            }
        }
        if back.is_ok() && worst <= reversal.tolerance * size {
            self.bodies.copy_from(&reversal.after);
            self.system.refresh(&mut self.bodies);
            return Ok(());
        }
        let off = if back.is_ok() { worst / size } else { f64::NAN };
        Err(Trouble::NotReversed { body, off, tolerance: reversal.tolerance })
    }

    /// Everything as it was before the step under way.
    fn put_back(&mut self) {
        self.bodies.copy_from(&self.before);
        self.memory.as_mut().copy_from_slice(self.memory_before.as_ref());
        self.system.refresh(&mut self.bodies);
    }

    /// Steps taken so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The time: that of the start, 0 if none was given, and steps times step size, or the sum of the steps where they
    /// differ in length.
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

    /// What is simulated.
    pub fn system(&self) -> &Y {
        &self.system
    }

    /// The method.
    pub fn method(&self) -> &S {
        &self.method
    }

    /// The number of bodies.
    pub fn len(&self) -> usize {
        self.bodies.q.as_ref().len()
    }

    /// Whether there is no body.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Positions of the bodies in turn.
    pub fn positions(&self) -> impl ExactSizeIterator<Item = SVector<f64, D>> + '_ {
        self.bodies.q.as_ref().iter().map(|&q| q.into())
    }

    /// Momenta p of the bodies in turn; with unit masses also velocities.
    pub fn momenta(&self) -> impl ExactSizeIterator<Item = SVector<f64, D>> + '_ {
        self.bodies.p.as_ref().iter().map(|&p| p.into())
    }

    /// Velocities M⁻¹p of the bodies in turn.
    pub fn velocities(&self) -> impl ExactSizeIterator<Item = SVector<f64, D>> + '_ {
        (0..self.len()).map(|i| self.system.velocity(&self.bodies, i).into())
    }

    /// The present state, from which a new simulation by the same method goes on bit for bit; steps, work and energy errors are then counted
    /// from there. (Linked bodies whose equations have come to depend on each other may choose another
    /// [linear algebra](crate::systems::network::solver::LinearAlgebra) at the new start, and round otherwise.)
    pub fn state(&self) -> State<D> {
        let bodies = (0..self.len()).map(|i| self.bodies.body(i)).collect();
        let (time, time_low) = self.exact_time();
        let remembered = Remembered::of(&self.method, self.memory.as_ref());
        State { bodies, time, time_low, remembered, surplus_momenta: None }
    }

    /// Kinetic energy K = pᵀM⁻¹p/2, summed over the bodies.
    pub fn kinetic_energy(&self) -> f64 {
        self.system.kinetic_energy(&self.bodies)
    }

    /// Potential energy U of all effects.
    pub fn potential_energy(&self) -> f64 {
        self.system.potential_energy(&self.bodies)
    }

    /// Energy H = K + U.
    pub fn energy(&self) -> f64 {
        self.kinetic_energy() + self.potential_energy()
    }

    /// Kinetic and potential energy of the same bodies at other places, with other momenta.
    pub(crate) fn energies_at(&self, positions: &[SVector<f64, D>], momenta: &[SVector<f64, D>]) -> [f64; 2] {
        let mut bodies = self.before.clone();
        let places = bodies.q.as_mut().iter_mut().zip(bodies.q_low.as_mut()).zip(positions);
        places.for_each(|((high, low), &q)| (*high, *low) = (q.into(), [0.0; D]));
        let ways = bodies.p.as_mut().iter_mut().zip(bodies.p_low.as_mut()).zip(momenta);
        ways.for_each(|((high, low), &p)| (*high, *low) = (p.into(), [0.0; D]));
        [self.system.kinetic_energy(&bodies), self.system.potential_energy(&bodies)]
    }

    /// Work that moving constraints have done on the bodies since the start, −∫ λᵀ ∂g/∂t dt, to the order of the
    /// method; 0 where none moves.
    pub fn work(&self) -> f64 {
        self.bodies.work
    }

    /// Energy now less energy at the start and less the [work](Self::work) done by moving constraints.
    pub fn energy_error(&self) -> f64 {
        self.energy() - self.start_energy - self.work()
    }

    /// g(q, t) of each equation, in the unit of g.
    pub fn residuals(&self) -> Vec<f64> {
        self.of_equations(|out| self.system.residuals(&self.bodies, out))
    }

    /// The largest |g(q, t)| of all equations, in the unit of g.
    pub fn constraint_residual(&self) -> f64 {
        largest(&self.residuals())
    }

    /// The largest |G(q)v + ∂g/∂t| of all equations, with v = M⁻¹p.
    pub fn cotangent_residual(&self) -> f64 {
        largest(&self.of_equations(|out| self.system.drift_rates(&self.bodies, out)))
    }

    /// Multipliers λ of the equations in turn (by link, then member, then equation), from the present state alone, such that g̈ = 0; of the order of the
    /// method. On a surface λ = −(vᵀ∇²g v + ∇g·f)/|∇g|².
    pub fn multipliers(&self) -> Vec<f64> {
        self.of_equations(|out| self.system.multipliers(&self.bodies, out))
    }

    /// The force Gᵀλ of all constraints on each body, in the unit of force, to the order of the method; on a pinned body
    /// the pull of its links, without the potentials that act on it.
    pub fn constraint_forces(&self) -> Vec<SVector<f64, D>> {
        let mut forces = vec![[0.0; D]; self.len()];
        self.system.constraint_forces(&self.bodies, &mut forces);
        forces.into_iter().map(Into::into).collect()
    }

    fn of_equations(&self, write: impl FnOnce(&mut [f64])) -> Vec<f64> {
        let mut numbers = vec![0.0; self.system.equations()];
        write(&mut numbers);
        numbers
    }
}

impl<F: Field<f64, D>, N: Count, S: Method, const D: usize> Simulation<Linked<F, N, D>, S, D> {
    /// What the position equations have cost since the start.
    pub fn counts(&self) -> Counts {
        self.system.counts(&self.bodies)
    }
}

/// The larger one; NaN if one is.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// The largest difference of a coordinate; NaN if one is.
fn farthest<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    a.iter().zip(b).fold(0.0, |most, (a, b)| larger((a - b).abs(), most))
}

/// The largest |x|; NaN if one is.
fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |largest, x| if x.abs() <= largest { largest } else { x.abs() })
}

impl<Y: System<f64, D, Count = One>, S: Method, const D: usize> Simulation<Y, S, D> {
    /// The particle's position.
    pub fn position(&self) -> SVector<f64, D> {
        self.bodies.q[0].into()
    }

    /// The particle's momentum; with unit mass also its velocity.
    pub fn momentum(&self) -> SVector<f64, D> {
        self.bodies.p[0].into()
    }

    /// Its velocity M⁻¹p.
    pub fn velocity(&self) -> SVector<f64, D> {
        self.system.velocity(&self.bodies, 0).into()
    }

    /// λ of M q̈ = −∇U + ∇g λ at the present state, of the first equation if there are more; NaN if there is none. See
    /// [`Self::multipliers`].
    pub fn multiplier(&self) -> f64 {
        self.multipliers().first().copied().unwrap_or(f64::NAN)
    }
}

impl<Y: System<f64, D>, S: Method, const D: usize> Clone for Reversal<Y, S, D> {
    fn clone(&self) -> Self {
        let (after, blank, memory) = (self.after.clone(), self.blank.clone(), self.memory.clone());
        Self { tolerance: self.tolerance, backwards: self.backwards.clone(), after, blank, memory }
    }
}

impl<Y: System<f64, D>, S: Method, const D: usize> Clone for Simulation<Y, S, D> {
    fn clone(&self) -> Self {
        Self {
            system: self.system.clone(),
            method: self.method.clone(),
            bodies: self.bodies.clone(),
            before: self.before.clone(),
            memory: self.memory.clone(),
            memory_before: self.memory_before.clone(),
            reversal: self.reversal.clone(),
            ..*self
        }
    }
}

impl<Y: System<f64, D>, S: Method, const D: usize> fmt::Debug for Simulation<Y, S, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut debug = f.debug_struct("Simulation");
        debug.field("method", &self.method.name()).field("time", &self.time()).field("bodies", &self.bodies);
        debug.finish_non_exhaustive()
    }
}

/// Passes a step's multipliers on to a recorder.
struct Listening<'a, R, S>(&'a mut R, PhantomData<S>);

impl<R: Recorder<S>, S> Witness<f64> for Listening<'_, R, S> {
    #[inline(always)]
    fn position_multiplier(&mut self, equation: usize, lambda: f64) {
        self.0.position_multiplier(equation, lambda);
    }
    #[inline(always)]
    fn momentum_multiplier(&mut self, equation: usize, mu: f64) {
        self.0.momentum_multiplier(equation, mu);
    }
}
