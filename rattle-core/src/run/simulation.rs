//! Simulations: a scene in motion.

use crate::effect::noise::Noise;
use crate::error::{Error, StepFailure};
use crate::methods::able::view;
use crate::methods::brownian;
use crate::motion::bodies::{Bodies, Saved};
use crate::motion::course::{check, kink_ahead};
use crate::motion::failure::Failure;
use crate::motion::identity::Identity;
use crate::motion::method::Method;
use crate::motion::state::{Remembered, State};
use crate::motion::stir::{Chosen, draws, step};
use crate::motion::system::System;
use crate::motion::witness::{Hears, Witness};
use crate::number::clock::{later, steps_to};
use crate::run::events::Search;
use crate::run::trouble::Trouble;
use crate::run::watch::listening::{Held, Listening};
use crate::run::watch::observer::Observer;
use crate::run::watch::seen::Seen;
use std::fmt;

/// A step is halved no more often: at a wall, where no part passes however short, all tries together are 2¹⁷ parts.
pub(crate) const MOST_HALVINGS: u32 = 16;

/// A scene, its present state, and the method that moves it.
///
/// Made by [`Scene::simulate`](crate::scene::Scene::simulate). A step neither allocates nor panics; if it fails, the
/// simulation is as it was before the step, bit for bit.
#[doc(alias = "integrator")]
#[doc(alias = "solver")]
#[derive(Clone)]
pub struct Simulation<Y: System<f64, D>, S: Method, const D: usize> {
    pub(super) system: Y,
    pub(super) method: S,
    pub(crate) bodies: Bodies<Y::Count, f64, Y::Kept, D>,
    /// Places and momenta before the step under way.
    pub(super) before: Saved<Y::Count, f64, D>,
    /// What the method remembers, and remembered before the step under way.
    pub(super) memory: S::Memory<f64>,
    pub(super) memory_before: S::Memory<f64>,
    pub(super) steps: u64,
    /// Random numbers at the start, and the number of the trajectory if its start was given one.
    pub(super) first: Noise,
    pub(super) number: Option<u64>,
    /// The time of the start, or of now where steps differ in length, and what rounding took from it.
    pub(super) clock: (f64, f64),
    pub(super) start_energy: f64,
    /// If a step that cannot be taken is to be halved.
    pub(super) halving: Option<Halving<Y, S, D>>,
    /// If every step is to be taken back and compared.
    pub(super) reversal: Option<Box<Reversal<Y, S, D>>>,
    /// What is to happen inside steps.
    pub(super) events: Option<Box<Events<Y, S, D>>>,
    /// Whether there is reversal or are events, in one look for each step.
    pub(super) goes_again: bool,
}

/// How often a step that cannot be taken is halved, and what takes it in parts: compiled for those who ask for it.
#[derive(Clone)]
pub(super) struct Halving<Y: System<f64, D>, S: Method, const D: usize> {
    pub(super) most: u32,
    #[allow(clippy::type_complexity, reason = "said once")]
    pub(super) take: fn(&mut Simulation<Y, S, D>, u32, &mut dyn Hears<f64>) -> Result<(), Trouble>,
}

/// What it takes to take a step back and go on as if it had not been.
#[derive(Clone)]
pub(super) struct Reversal<Y: System<f64, D>, S: Method, const D: usize> {
    /// What takes a step in so many parts back: compiled for those who ask for it.
    pub(super) take: fn(&mut Simulation<Y, S, D>, u32) -> Result<(), Trouble>,
    pub(super) tolerance: f64,
    pub(super) backwards: S,
    pub(super) after: Saved<Y::Count, f64, D>,
    /// That of a method that has not made a step.
    pub(super) blank: S::Memory<f64>,
    pub(super) memory: S::Memory<f64>,
}

/// What is looked for in each step, and the room to do so.
#[derive(Clone)]
pub(super) struct Events<Y: System<f64, D>, S: Method, const D: usize> {
    /// What takes a step apart: compiled for those who ask for it.
    #[allow(clippy::type_complexity, reason = "said once")]
    pub(super) meet:
        fn(&mut Simulation<Y, S, D>, Result<(), Failure>, &mut dyn Hears<f64>) -> Result<(), Error>,
    pub(super) search: Search<D>,
    /// How many there were.
    pub(super) number: u64,
    pub(super) start: Saved<Y::Count, f64, D>,
    pub(super) aside: [Saved<Y::Count, f64, D>; 4],
}

impl<Y: System<f64, D>, S: Method, const D: usize> Simulation<Y, S, D> {
    pub(crate) fn new(
        system: Y,
        mut bodies: Bodies<Y::Count, f64, Y::Kept, D>,
        start: &State<D>,
        method: S,
        trajectory: u64,
    ) -> Result<Self, Error> {
        let clock = (start.time, start.time_low);
        let number = start.number;
        let first = Noise { trajectory: number.unwrap_or(trajectory), step: start.steps, ..Noise::default() };
        let mut memory = method.memory(view(&method, &system)?, &bodies);
        if const { Y::REMEMBERS } {
            bodies.noise = first;
            let marks = system.first_marks(&bodies);
            bodies.marks = marks.map_err(|(effect, mistake)| Error::Effect { effect, mistake })?;
        }
        if let Some(Remembered { method: whose, system: of, numbers }) = &start.remembered
            && let Some(long) = numbers.len().checked_sub(bodies.marks.len())
            && of.is(&Identity::of_system(&system, &bodies))
        {
            let (of_method, of_effects) = numbers.split_at(long);
            bodies.marks.copy_from_slice(of_effects);
            if *whose == method.identity() && long == memory.as_ref().len() {
                memory.as_mut().copy_from_slice(of_method);
            }
        }
        let before = bodies.saved();
        let memory_before = memory.clone();
        let start_energy = system.kinetic_energy(&bodies) + system.potential_energy(&bodies);
        let (steps, halving, reversal, events) = (0, None, None, None);
        Ok(Self {
            system,
            method,
            bodies,
            before,
            memory,
            memory_before,
            steps,
            first,
            number,
            clock,
            start_energy,
            halving,
            reversal,
            events,
            goes_again: false,
        })
    }

    /// The same simulation, in which every step is checked for reversibility.
    ///
    /// After each step of size h the method takes a step of size −h from its end. The step fails if the position or
    /// momentum reached differs from that at its start, in any coordinate by more than `tolerance` times the largest
    /// coordinate or momentum. A symmetric method returns to about 1e-14, unless the step and the step back found
    /// different solutions of the position equation: the check detects such steps.
    ///
    /// A tolerance of 1e-13 suits most scenes. With [`retry`](Self::retry), a step that fails the check is taken in
    /// parts, which are taken back together. The check doubles the time of a step.
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
    /// [`Error::Tolerance`] for a tolerance that is not positive and finite, [`Error::NeedsSymmetricMethod`] for a
    /// method that is not symmetric, or only together with its memory.
    #[doc(alias = "time reversal")]
    #[doc(alias = "reversibility")]
    pub fn check_reversal(mut self, tolerance: f64) -> Result<Self, Error> {
        self.reverse(tolerance)?;
        Ok(self)
    }

    /// Takes one step.
    ///
    /// # Errors
    /// [`Error::Step`] says why the step cannot be taken; the simulation is then unchanged.
    #[doc(alias = "integrate")]
    #[inline(always)]
    pub fn step(&mut self) -> Result<(), Error> {
        self.take(1, &mut ())
    }

    /// Takes `steps` steps.
    ///
    /// # Errors
    /// At the first step that cannot be taken; the simulation is then in the state before this step.
    #[doc(alias = "integrate")]
    pub fn run(&mut self, steps: u64) -> Result<(), Error> {
        self.take(steps, &mut ())
    }

    /// Takes whole steps until the time is at least `time`; none if it is already.
    ///
    /// The run ends less than one step beyond `time`. A time that is a whole number of steps away, to a millionth of a
    /// step, is reached by that number of steps. With a negative step size the time runs backwards to `time`.
    ///
    /// ```
    /// # use rattle::{Rattle, Scene, State};
    /// let mut simulation = Scene::point().simulate(State::at([0.0]).moving([1.0]), Rattle::new(0.1))?;
    /// simulation.run_until(0.3)?; // 3 × 0.1 is a little more than 0.3
    /// assert_eq!(simulation.steps(), 3);
    /// simulation.run_until(0.31)?;
    /// assert_eq!((simulation.steps(), simulation.time()), (4, 0.4));
    /// # Ok::<(), rattle::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Self::run`]; [`Error::EndTime`] for a time that is not finite.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a number of steps, rounded up"
    )]
    #[doc(alias = "integrate")]
    #[doc(alias = "end time")]
    pub fn run_until(&mut self, time: f64) -> Result<(), Error> {
        if !time.is_finite() {
            return Err(Error::EndTime(time));
        }
        let h = self.method.step_size();
        if self.method.time_taken(self.memory.as_ref()).is_none() {
            return self.run(steps_to(time, self.time(), h) as u64);
        }
        while steps_to(time, self.time(), h) > 0.0 {
            self.step()?;
        }
        Ok(())
    }

    /// Takes steps as long as `go_on` returns true for the simulation, at most `steps`; returns how many were taken.
    ///
    /// ```
    /// # use rattle::{Rattle, Scene, State};
    /// let mut simulation = Scene::point().simulate(State::at([0.0]).moving([1.0]), Rattle::new(0.25))?;
    /// let steps = simulation.run_while(1_000_000, |now| now.position().x < 2.0)?;
    /// assert_eq!((steps, simulation.position().x), (8, 2.0));
    /// # Ok::<(), rattle::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Self::run`].
    pub fn run_while(&mut self, steps: u64, mut go_on: impl FnMut(&Self) -> bool) -> Result<u64, Error> {
        let begun = self.steps;
        while self.steps - begun < steps && go_on(self) {
            self.step()?;
        }
        Ok(self.steps - begun)
    }

    /// Takes `steps` steps and shows the simulation to the closure `see` after each.
    ///
    /// A closure can ask the simulation for everything, such as residuals and the [energy error](Self::energy_error).
    /// To watch every n-th step, or ensembles, use an [observer](Self::observe).
    ///
    /// ```text
    /// simulation.run_with(2000, |now| energies.push(now.energy()))?;
    /// ```
    ///
    /// # Errors
    /// As [`Self::run`]; `see` has been shown every step that was taken.
    pub fn run_with(&mut self, steps: u64, mut see: impl FnMut(&Self)) -> Result<(), Error> {
        for _ in 0..steps {
            self.step()?;
            see(self);
        }
        Ok(())
    }

    /// Takes `steps` steps and shows the simulation to `observer` after every `every` steps (0 counts as 1),
    /// see [`watch`](crate::run::watch). Steps beyond the last multiple of `every` are taken and not shown. Observers
    /// of multipliers receive those of every step. Positions and momenta are copied each time that the simulation is
    /// shown.
    ///
    /// ```
    /// # use rattle::{Rattle, Scene, State, watch::{Mean, Sight}};
    /// let mut simulation = Scene::point().simulate(State::at([0.0]).moving([1.0]), Rattle::new(0.5))?;
    /// let mut mean = Mean::of(|now: &Sight<'_, 1>| now.energy());
    /// simulation.observe(100, 10, &mut mean)?;
    /// assert_eq!((mean.number(), mean.mean()), (10, 0.5));
    /// # Ok::<(), rattle::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Self::run`]; the observer has then seen all steps before it that it was to see. [`Error::Recorder`] where
    /// an observer fails.
    pub fn observe<O: Observer<D> + ?Sized>(
        &mut self,
        steps: u64,
        every: u64,
        observer: &mut O,
    ) -> Result<(), Error> {
        let every = every.max(1);
        let mut before = Seen::new(self.steps, 1, self.bodies(), |page| self.look(page));
        before.corrections = self.corrections();
        let mut now = before.clone();
        // A step that is taken again in parts tells of those that stand.
        let mut held = (self.goes_again || self.halving.is_some()).then(Held::default);
        for _ in 0..steps / every {
            self.take_shown(every, Listening { observer, held: held.as_mut() }, &before)?;
            (now.steps, now.corrections) = (self.steps, self.corrections());
            self.look(now.page());
            observer.see(&before.sight(self), &now.sight(self));
            observer.failure().map_or(Ok(()), Err)?;
            std::mem::swap(&mut before, &mut now);
        }
        self.take(steps % every, &mut Listening { observer, held: held.as_mut() })
    }

    /// Takes so many steps from the last sight on, and shows each instant at which momenta jump.
    fn take_shown<O: Observer<D> + ?Sized>(
        &mut self,
        steps: u64,
        mut listening: Listening<'_, O, D>,
        last: &Seen<D>,
    ) -> Result<(), Error> {
        if self.events.is_none() || !listening.observer.sees_jumps() {
            return self.take(steps, &mut listening);
        }
        let mut from = last.clone();
        for _ in 0..steps {
            let (steps, time) = (self.steps, self.time());
            self.keep_jumps(Some(Vec::new()));
            let taken = self.take(1, &mut listening);
            let jumps = self.keep_jumps(None);
            taken?;
            for mut jump in jumps {
                jump.iter_mut().for_each(|seen| seen.date(steps, time));
                let [before, after] = jump;
                listening.observer.jump(&from.sight(self), &before.sight(self), &after.sight(self));
                from = after;
            }
        }
        Ok(())
    }

    /// Where jumps are kept from now on, if anywhere; those that were kept before.
    fn keep_jumps(&mut self, jumps: Option<Vec<[Seen<D>; 2]>>) -> Vec<[Seen<D>; 2]> {
        let kept = self.events.as_mut().map(|events| std::mem::replace(&mut events.search.jumps, jumps));
        kept.flatten().unwrap_or_default()
    }

    /// Takes so many steps. In one place for all who take steps: a step is much to compile.
    #[inline(never)]
    fn take(&mut self, steps: u64, witness: &mut impl Witness<f64>) -> Result<(), Error> {
        for _ in 0..steps {
            self.advance(witness)?;
            witness.taken();
        }
        Ok(())
    }

    #[inline(always)]
    fn advance(&mut self, witness: &mut impl Witness<f64>) -> Result<(), Error> {
        let system = view(&self.method, &self.system)?;
        self.system.put_aside(&self.bodies, &mut self.before);
        self.memory_before.as_mut().copy_from_slice(self.memory.as_ref());
        if const { Y::FLOWS > 0 || S::DRAWS } {
            self.bodies.noise = self.noise();
        }
        let stepped = step(
            Chosen::All,
            &self.method,
            system,
            &self.system,
            &mut self.bodies,
            self.memory.as_mut(),
            witness,
        );
        let taken = self.method.time_taken(self.memory.as_ref());
        let h = taken.unwrap_or(self.method.step_size());
        let look = |()| check::<S, _, _, D>(h, &self.system, &self.before, &mut self.bodies);
        match stepped.and_then(look) {
            Ok(()) => {
                if let Some(taken) = taken {
                    self.clock = later(self.clock, (taken, 0.0));
                }
                if self.goes_again {
                    self.go_again(Ok(()), witness)?;
                }
            }
            Err(failure) => self.go_again(Err(failure), witness)?,
        }
        self.steps += 1;
        if self.system.moves_with_time() {
            let time = self.time();
            self.system.set_time(&mut self.bodies, time);
        }
        Ok(())
    }

    /// The first random numbers of the next step.
    pub(super) fn noise(&self) -> Noise {
        Noise { step: self.first.step.wrapping_add(self.steps), ..self.first }
    }

    /// Takes the step just made apart where something happens inside it, back, or in parts.
    #[cold]
    #[inline(never)]
    fn go_again(&mut self, stepped: Result<(), Failure>, witness: &mut dyn Hears<f64>) -> Result<(), Error> {
        if let Some(meet) = self.events.as_ref().map(|events| events.meet) {
            return meet(self, stepped, witness);
        }
        match stepped.map_err(Trouble::from).and_then(|()| self.compare(1)) {
            Ok(()) => Ok(()),
            Err(trouble) => self.take_in_parts(trouble, witness),
        }
    }

    /// How often a step may be halved.
    pub(in crate::run) fn most_halvings(&self) -> u32 {
        let whole = self.method.momentum_delay() != 0.0 || self.method.undivided().is_some();
        match &self.halving {
            Some(halving) if !whole => halving.most,
            _ => 0,
        }
    }

    /// Takes the step in trouble in parts, as often halved as is allowed.
    fn take_in_parts(&mut self, mut trouble: Trouble, witness: &mut dyn Hears<f64>) -> Result<(), Error> {
        let clock = self.clock;
        self.put_back();
        let mut tried = 0;
        if let Some(Halving { take, .. }) = self.halving {
            for halved in 1..=self.most_halvings() {
                // Parts by themselves would draw other random numbers.
                if const { S::STIRS } && draws(&self.system) && self.method.finer(1 << halved).is_none() {
                    break;
                }
                tried = halved;
                let taken = take(self, 1 << halved, witness);
                match taken.and_then(|()| self.compare(1 << halved)) {
                    Ok(()) => return Ok(()),
                    Err(again) => trouble = again,
                }
                self.clock = clock;
                self.put_back();
            }
        }
        self.explain(&mut trouble);
        Err(trouble.halved(tried).told(self.steps + 1, self.time()))
    }

    /// Where bodies could not be moved for a reason that a kink can have, looks for one.
    pub(in crate::run) fn explain(&mut self, trouble: &mut Trouble) {
        if let Trouble::Failed { failure, .. } = trouble
            && failure.may_be_of_a_kink()
        {
            self.look_for_kinks(failure);
        }
    }

    /// Where the bodies could not be moved, and a constraint has a kink on their way, the failure is that.
    fn look_for_kinks(&mut self, failure: &mut Failure) {
        // On a kink, which is not beyond it, slopes are no numbers; and bodies may become faster on their way there.
        let on_it = usize::from(matches!(failure.cause, StepFailure::ConstraintNotFinite { .. }));
        for ahead in &[1.0, 1.25][..=on_it] {
            let h = ahead * self.method.step_size();
            if const { S::RENEWS }
                && let Some(renewal) = self.method.renewal()
            {
                self.bodies.noise = self.noise();
                brownian::coast(renewal, h, &self.system, &mut self.bodies);
            } else {
                self.system.coast(h, &mut self.bodies);
            }
            let kink = kink_ahead(&self.system, &self.before, &mut self.bodies);
            self.put_back();
            if let Some(kink) = kink {
                return *failure = kink;
            }
        }
    }

    /// Compares the step just made, in so many parts, with the way back, if that is asked for.
    #[inline(always)]
    pub(in crate::run) fn compare(&mut self, parts: u32) -> Result<(), Trouble> {
        match self.reversal.as_ref().map(|reversal| reversal.take) {
            Some(take) => take(self, parts),
            None => Ok(()),
        }
    }

    /// Everything as it was before the step under way.
    pub(in crate::run) fn put_back(&mut self) {
        self.system.put_back(&mut self.bodies, &self.before);
        self.memory.as_mut().copy_from_slice(self.memory_before.as_ref());
    }
}

impl<Y: System<f64, D>, S: Method, const D: usize> fmt::Debug for Simulation<Y, S, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut debug = f.debug_struct("Simulation");
        debug.field("method", &self.method.name()).field("time", &self.time()).field("bodies", &self.bodies);
        debug.finish_non_exhaustive()
    }
}
