//! Many independent trajectories, run and observed together.

use crate::effect::list::Effects;
use crate::error::{Error, RecordMistake, StartFailure};
use crate::motion::bodies::Count;
use crate::motion::hold::{Hold, Kind};
use crate::motion::method::{Method, check_tolerance};
use crate::motion::record::Record;
use crate::motion::state::State;
use crate::number::instructions::InstructionSet;
use crate::number::vectors::LANES;
use crate::run::bill::Bill;
use crate::run::ensemble::alone::Alone;
use crate::run::ensemble::apart::{NotInLanes, Plan, act_in_lanes};
use crate::run::ensemble::group::Group;
use crate::run::ensemble::grouping::{HowInLanes, goes_as};
use crate::run::ensemble::grouping_kinds::{InLanes, alike, apart};
use crate::run::ensemble::precision::{Double, Precision};
use crate::run::ensemble::side_by_side::STRETCH;
use crate::run::ensemble::watching::{AnyObserver, Watching};
use crate::run::reversal::has_way_back;
use crate::run::watch::observer::Observer;
use crate::run::watch::seen::Seen;
use crate::scene::Scene;
use rayon::prelude::*;
use std::fmt;

/// Many independent trajectories. Made by [`Scene::ensemble`](crate::scene::Scene::ensemble).
///
/// Work is spread over the threads of the current [rayon](https://docs.rs/rayon) pool: all cores, unless
/// `RAYON_NUM_THREADS` or a pool of your own says otherwise.
#[doc(alias = "batch")]
#[doc(alias = "SIMD")]
#[doc(alias = "rayon")]
#[doc(alias = "parallel")]
pub struct Ensemble<const D: usize> {
    pub(crate) groups: Vec<Box<dyn Group<D>>>,
    /// The number of the first trajectory of each group.
    first: Vec<usize>,
    pub(crate) len: usize,
    plan: Plan,
    /// Why steps cannot be taken back.
    no_way_back: Option<Error>,
    pub(super) h: f64,
    pub(crate) steps: u64,
    pub(crate) set: InstructionSet,
}

impl<C: Hold<D> + 'static, E: Effects<D>, N: Count, const D: usize> Scene<C, E, N, D> {
    /// An ensemble: one trajectory of this scene from each start, all by the same method; see [`Ensemble`].
    ///
    /// ```text
    /// let mut ensemble = scene.ensemble(starts, Rattle::new(0.01))?;
    /// ensemble.run(2000);
    /// ```
    ///
    /// # Errors
    /// [`Error::Trajectory`] with the number of the start that is refused, and the reason, as for
    /// [`simulate`](Self::simulate).
    pub fn ensemble<S: Method>(
        &self,
        starts: impl IntoIterator<Item = State<D>>,
        method: S,
    ) -> Result<Ensemble<D>, Error> {
        self.ensemble_in(Double, starts, method)
    }

    /// As [`ensemble`](Self::ensemble), with another [`Precision`] in lanes.
    ///
    /// # Errors
    /// As [`ensemble`](Self::ensemble).
    pub fn ensemble_in<P: Precision, S: Method>(
        &self,
        precision: P,
        starts: impl IntoIterator<Item = State<D>>,
        method: S,
    ) -> Result<Ensemble<D>, Error> {
        Ensemble::of(precision, self, starts, method, InstructionSet::widest())
    }
}

impl<const D: usize> Ensemble<D> {
    /// As [`Scene::ensemble`], with a chosen instruction set. If the processor lacks it, the baseline that every
    /// processor has is used.
    ///
    /// # Errors
    /// As [`Scene::ensemble`].
    pub fn of<P: Precision, C: Hold<D> + 'static, E: Effects<D>, N: Count, S: Method>(
        _precision: P,
        scene: &Scene<C, E, N, D>,
        starts: impl IntoIterator<Item = State<D>>,
        method: S,
        set: InstructionSet,
    ) -> Result<Self, Error> {
        let mut starts = starts.into_iter();
        let next = &mut || starts.next().map(|start| (scene, start));
        Self::assembled([P::MOST, P::SHORTEST], next, method, set, const { alike::<P, S, C, E, N, D>() })
    }

    /// A parameter sweep: one trajectory of each scene, each from its own start.
    ///
    /// The scenes have the same type and differ in parameters. A step takes as long as in an ensemble of one scene,
    /// since parameters are stored in lanes like positions. (Parameters of effects `.over(members)` are not, and take
    /// longer to read. Linked bodies take up to three times as long where masses differ, and always go in rows of 64.)
    ///
    /// ```text
    /// let scenes: Vec<_> = radii.map(|r| Scene::on(Lemniscate { a: 1.0, r })).collect();
    /// let mut ensemble = Ensemble::sweep(Double, scenes.iter().zip(starts), Rattle::new(0.01))?;
    /// ```
    ///
    /// # Errors
    /// As [`Scene::ensemble`].
    #[doc(alias = "parameter scan")]
    pub fn sweep<'a, P, C, E, N, S>(
        _precision: P,
        trajectories: impl IntoIterator<Item = (&'a Scene<C, E, N, D>, State<D>)>,
        method: S,
    ) -> Result<Self, Error>
    where
        P: Precision,
        C: Hold<D> + 'static,
        E: Effects<D> + 'static,
        N: Count + 'a,
        S: Method,
    {
        let (mut trajectories, set) = (trajectories.into_iter(), InstructionSet::widest());
        let next = &mut || trajectories.next();
        Self::assembled([P::MOST, P::SHORTEST], next, method, set, const { apart::<P, S, C, E, N, D>() })
    }

    /// Checks the starts that `next` gives until it gives none, and puts trajectories in lanes, a group after the
    /// other, where there are lanes for them.
    #[allow(clippy::type_complexity, reason = "said once")]
    fn assembled<'a, C: Hold<D> + 'a, E: Effects<D> + 'a, N: Count + 'a, S: Method>(
        limits: [f64; 2],
        next: &mut dyn FnMut() -> Option<(&'a Scene<C, E, N, D>, State<D>)>,
        method: S,
        set: InstructionSet,
        in_lanes: InLanes<C, E, N, D>,
    ) -> Result<Self, Error> {
        let set = if set.is_present() { set } else { InstructionSet::Portable };
        let h = method.step_size();
        // Others than those on surfaces are computed in double precision.
        let on_surfaces = const { matches!(C::KIND, Kind::Other) };
        let [most, shortest] = if on_surfaces { limits } else { [Double::MOST, Double::SHORTEST] };
        let mut lanes = HowInLanes::of(&method, shortest, set);
        let (groups, first, plan) = (Vec::new(), Vec::new(), Plan::default());
        let mut ensemble = Self { groups, first, len: 0, plan, no_way_back: None, h, steps: 0, set };
        loop {
            let (mut scenes, mut starts) = (Vec::with_capacity(LANES), Vec::with_capacity(LANES));
            let mut ready = Vec::with_capacity(LANES);
            while scenes.len() < LANES
                && let Some((scene, mut start)) = next()
            {
                let system = match (scene.ready(&start, &method), beyond(most, &start)) {
                    (Err(error), _) | (_, Some(error)) => return Err(ensemble.refused(scenes.len(), error)),
                    (Ok(system), None) => system,
                };
                if ensemble.no_way_back.is_none() {
                    ensemble.no_way_back = has_way_back(&method, &system).err();
                }
                for (body, bodies) in start.bodies.iter_mut().enumerate() {
                    if let Some(at) = scene.constraint.pin(body) {
                        (bodies.q, bodies.q_low) = (at, [0.0; D]);
                    }
                }
                ready.push(system);
                starts.push(start);
                scenes.push(scene);
            }
            if scenes.is_empty() {
                if ensemble.len == 0 {
                    method.check(0)?; // which is asked of each start otherwise
                }
                return Ok(ensemble);
            }
            let fits = !matches!(C::KIND, Kind::Other) || starts.iter().all(|start| start.len() == 1);
            let goes = const { matches!(C::KIND, Kind::Other) || goes_as::<C, S, D>(C::KIND) };
            let mut why = lanes.as_ref().err().copied();
            for scene in &scenes {
                why = why.or_else(|| act_in_lanes::<S, _, D>(&scene.effects.forces()));
            }
            why = why.or_else(|| (!goes).then(|| NotInLanes::Method(method.name())));
            if fits
                && why.is_none()
                && let Ok(lanes) = &mut lanes
            {
                lanes.first = ensemble.len;
                if let Some(groups) = in_lanes(&scenes, &starts, lanes) {
                    ensemble.plan.in_lanes += scenes.len();
                    groups.into_iter().for_each(|group| ensemble.push(group));
                    continue;
                }
            }
            ensemble.plan.leave(scenes.len(), why);
            for ((scene, system), start) in scenes.into_iter().zip(ready).zip(&starts) {
                let simulation = scene.begin(system, start, method.clone(), ensemble.len as u64);
                let simulation = simulation.map_err(|error| ensemble.refused(0, error))?;
                ensemble.push(Box::new(Alone::new(simulation)));
            }
        }
    }

    /// Puts a group after the others.
    #[inline(never)]
    pub(super) fn push(&mut self, group: Box<dyn Group<D>>) {
        self.first.push(self.len);
        self.len += group.len();
        self.groups.push(group);
    }

    /// The start of this number, counted from those that are in already, is refused.
    fn refused(&self, number: usize, error: Error) -> Error {
        Error::Trajectory { trajectory: self.len + number, error: Box::new(error) }
    }

    /// The same ensemble, in which a step that fails is repeated in 2, 4, … 2^`halvings` equal parts, as
    /// [`Simulation::retry`](crate::run::simulation::Simulation::retry) does.
    ///
    /// Only the failed step of the failed trajectory is divided; the other trajectories are unchanged, bit for bit. A
    /// divided step takes some microseconds.
    ///
    /// ```
    /// # use rattle::{Scene, State, Rattle};
    /// # let starts = (0..100).map(|i| State::at([0.0]).moving([f64::from(i)]));
    /// let mut ensemble = Scene::points::<1>(1).ensemble(starts, Rattle::new(0.5))?.retry(6);
    /// # ensemble.run(2);
    /// # Ok::<(), rattle::Error>(())
    /// ```
    #[must_use]
    pub fn retry(mut self, halvings: u32) -> Self {
        self.groups.iter_mut().for_each(|group| group.retry(halvings));
        self
    }

    /// The same ensemble, in which every step is checked for reversibility, as
    /// [`Simulation::check_reversal`](crate::run::simulation::Simulation::check_reversal) does.
    ///
    /// A trajectory whose step does not lead back fails, or takes it in parts if there is [`retry`](Self::retry). A
    /// hybrid Monte Carlo method rejects such a proposal.
    ///
    /// Lanes look less closely at a step than simulations do: what is taken might be refused on the way back. So all go
    /// by themselves from then on, on all cores, each in about 1 to 1.5 times the time of a checked simulation; those
    /// of a [`Single`](crate::run::ensemble::Single) ensemble in single precision, which meets no tolerance below 1e-6.
    ///
    /// ```
    /// # use rattle::{Scene, State, Rattle};
    /// # let starts = (0..100).map(|i| State::at([0.0]).moving([f64::from(i)]));
    /// let mut ensemble = Scene::points::<1>(1).ensemble(starts, Rattle::new(0.5))?.check_reversal(1e-13)?;
    /// # ensemble.run(2);
    /// # Ok::<(), rattle::Error>(())
    /// ```
    ///
    /// # Errors
    /// Those of a simulation.
    #[doc(alias = "reversibility")]
    pub fn check_reversal(mut self, tolerance: f64) -> Result<Self, Error> {
        check_tolerance(Some(tolerance))?;
        if let Some(error) = self.no_way_back {
            return Err(error);
        }
        self.groups.iter_mut().try_for_each(|group| group.check_reversal(tolerance))?;
        self.plan.take_back();
        Ok(self)
    }

    /// Takes `steps` steps of every trajectory that has not failed.
    #[inline(never)]
    pub fn run(&mut self, steps: u64) {
        match &mut self.groups[..] {
            [group] => group.run(steps, None), // without waking other threads
            groups => groups.par_iter_mut().for_each(|group| group.run(steps, None)),
        }
        self.steps = self.steps.saturating_add(steps);
    }

    /// Takes `steps` steps, and shows each trajectory to an observer after every `every` steps (0
    /// counts as 1).
    ///
    /// `observer` makes an observer for each group of trajectories that are computed together; these are joined in the
    /// order of the trajectories. It must make empty ones: what they hold already would count once for each group. To
    /// go on with an observer of an earlier run, [`join`](Observer::join) the new one to it. A trajectory that has
    /// failed is not shown again. Steps beyond the last multiple of `every` are taken and not shown. If an observer
    /// panics, groups of trajectories are left at different times.
    ///
    /// Where an observer fails, such as a recorder whose disk is full, the run ends within 8192 steps, with all
    /// trajectories at the same [`steps`](Self::steps). The recorder's `finish` says why, and the ensemble can be run
    /// further.
    ///
    /// **Cost.** To show a trajectory that is computed in lanes takes the time of one to two steps, plus the time of
    /// the observer. Under gravity on the lemniscate (3.5 ns a step on a Zen 4) the [`Mean`](crate::run::watch::Mean)
    /// of a height adds the time of 2.0 steps to each step where `every` is 1, of 0.2 steps where it is 10, and of 0.06
    /// steps where it is 100. The mean of the [energy](crate::run::watch::Sight::energy) takes the time of 1.5 more
    /// steps each time that it is shown. What is shown cannot be taken back. So some are written side by side, and
    /// before they are shown it is asked once whether each trajectory is on its own sheet of the surface.
    ///
    /// ```
    /// # use rattle::{Scene, State, Rattle, watch::{Mean, Sight}};
    /// # let starts = (0..100).map(|i| State::at([0.0]).moving([f64::from(i)]));
    /// # let mut ensemble = Scene::points::<1>(1).ensemble(starts, Rattle::new(0.5))?;
    /// let speed = ensemble.observe(1000, 10, || Mean::of(|now: &Sight<'_, 1>| now.momentum().norm()));
    /// assert_eq!((speed.number(), speed.mean()), (10_000, 49.5));
    /// # Ok::<(), rattle::Error>(())
    /// ```
    pub fn observe<O: Observer<D> + Send>(
        &mut self,
        steps: u64,
        every: u64,
        observer: impl Fn() -> O + Sync,
    ) -> O {
        let every = every.max(1);
        let mut observers: Vec<O> = Vec::new();
        observers.resize_with(self.groups.len(), &observer);
        self.run_watched(steps, every, observers.iter_mut().map(|observer| observer as _).collect());
        let mut all = observer();
        for observer in observers {
            all.join(observer);
        }
        all
    }

    /// The same with an observer for each group.
    #[inline(never)]
    pub(super) fn run_watched(
        &mut self,
        steps: u64,
        every: u64,
        observers: Vec<&mut (dyn AnyObserver<D> + Send)>,
    ) {
        let taken = self.steps;
        let start = |(group, observer): (&mut Box<dyn Group<D>>, _)| {
            let mut now = Seen::new(taken, group.len(), group.bodies(), |page| group.look(page));
            now.corrections = group.source().corrections();
            // A part of a group has as many pages as a whole one, since lanes are asked where they are once for all
            // pages.
            let numbers = now.numbers() / group.len().max(1) * group.moving().len();
            Watching::new(observer, now, numbers, every, steps / every)
        };
        let mut watching: Vec<_> = self.groups.par_iter_mut().zip(observers).map(start).collect();
        let mut left = steps;
        while left > 0 && watching.iter().all(|of| of.observer.failure().is_none()) {
            let moves = self.groups.iter().any(|group| group.moving().contains(&true));
            let part = if moves { left.min(UNWATCHED) } else { left };
            let groups = self.groups.par_iter_mut().zip(&self.first).zip(&mut watching);
            groups.for_each(|((group, &first), of)| of.run(group, first, part, every));
            self.steps = self.steps.saturating_add(part);
            left -= part;
        }
    }

    /// What a step of a trajectory costs on one thread, item by item.
    ///
    /// The bill is that of the first group of trajectories that has one still moving: a group in lanes, or one
    /// simulation. A copy of the group runs for some milliseconds, and its parts are timed one by one. The ensemble
    /// itself is unchanged.
    ///
    /// ```
    /// # use rattle::potentials::Gravity;
    /// # use rattle::{surfaces::Torus, Rattle, Scene, State};
    /// let scene = Scene::on(Torus { major: 1.0, minor: 0.25 }).with(Gravity { g: 1.0 });
    /// let start = State::at([1.25, 0.0, 0.0]).moving([0.0, 1.0, 0.0]);
    /// let mut ensemble = scene.ensemble(vec![start; 100], Rattle::new(0.01))?;
    /// ensemble.run(100);
    /// let bill = ensemble.bill()?;
    /// println!("{bill}");
    /// assert_eq!(bill.items[0].what, "force of `Gravity`");
    /// assert_eq!(ensemble.steps(), 100);
    /// # Ok::<(), rattle::Error>(())
    /// ```
    ///
    /// # Errors
    /// Those of the steps that are tried; where all trajectories have failed, the error of the first.
    #[inline(never)]
    pub fn bill(&self) -> Result<Bill, Error> {
        let moves = |group: &dyn Group<D>| group.moving().iter().take(group.len()).any(|&moves| moves);
        match (self.groups.iter().find(|group| moves(group.as_ref())), self.failures().next()) {
            (Some(group), _) => group.bill(),
            (None, Some((_, error))) => Err(error.clone()),
            (None, None) => Ok(Bill::nothing()),
        }
    }

    /// A record of everything needed to continue bit for bit; see [`checkpoint`](crate::run::checkpoint). For a failed
    /// trajectory the record holds the text of its error, not the [`Error`] itself.
    #[must_use]
    pub fn checkpoint(&self) -> Record {
        let mut record = Record::default();
        record.text("what", AN_ENSEMBLE);
        record.counts("steps", [self.steps]);
        record.counts("trajectories and groups", [self.len as u64, self.groups.len() as u64]);
        for (number, group) in self.groups.iter().enumerate() {
            record.within(&format!("group {number}"), |record| group.record(record));
        }
        record
    }

    /// Continues from a checkpoint of an ensemble of the same scenes and method. Where the checkpoint is refused, the
    /// ensemble is unchanged.
    ///
    /// # Errors
    /// [`Error::Record`] for a checkpoint of another run, with the first part that differs.
    #[doc(alias = "restart")]
    pub fn resume(&mut self, checkpoint: &Record) -> Result<(), Error> {
        let mut reading = checkpoint.read();
        reading.expect(AN_ENSEMBLE)?;
        let [steps] = reading.counted("steps")?;
        let there = reading.counted("trajectories and groups")?;
        let here = [self.len as u64, self.groups.len() as u64];
        if there != here {
            let told = |[len, groups]: [u64; 2]| format!("one of {len} trajectories in {groups} groups");
            let part = "ensemble".into();
            return Err(Error::Record(RecordMistake::Another { part, file: told(there), here: told(here) }));
        }
        let groups = self.groups.iter().enumerate().map(|(number, group)| {
            reading.within(&format!("group {number}"), |reading| group.recalled(reading))
        });
        (self.groups, self.steps) = (groups.collect::<Result<_, _>>()?, steps);
        Ok(())
    }

    /// How many trajectories there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The number of bodies of each trajectory, or of the first in a sweep over networks of several sizes; 0 where
    /// there is no trajectory.
    #[must_use]
    pub fn bodies(&self) -> usize {
        self.groups.first().map_or(0, |group| group.bodies())
    }

    /// Steps taken so far.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The step size of the method.
    #[must_use]
    pub fn step_size(&self) -> f64 {
        self.h
    }

    /// The present time of a trajectory. Times differ where those of the starts do; a failed trajectory stays at the
    /// time of its last step.
    ///
    /// # Panics
    /// If there is no trajectory of this number.
    #[must_use]
    #[track_caller]
    pub fn time(&self, trajectory: usize) -> f64 {
        self.state(trajectory).time()
    }

    /// The work done on the bodies of a trajectory since the start, an energy: by [flows](crate::effect::Flow) of
    /// momenta, moving constraints and potentials that change with time, see
    /// [`Simulation::work`](crate::run::simulation::Simulation::work). Of a failed trajectory, until then.
    ///
    /// # Panics
    /// If there is no trajectory of this number.
    #[must_use]
    #[track_caller]
    pub fn work(&self, trajectory: usize) -> f64 {
        assert!(trajectory < self.len, "trajectory {trajectory} of {}", self.len);
        let (group, own) = self.group(trajectory);
        group.work(own)
    }

    /// How trajectories are computed: how many in lanes, how many as simulations, and why those.
    #[must_use]
    pub fn plan(&self) -> Plan {
        self.plan
    }

    /// The instruction set used for trajectories in lanes.
    #[must_use]
    pub fn instruction_set(&self) -> InstructionSet {
        self.set
    }

    fn group(&self, trajectory: usize) -> (&dyn Group<D>, usize) {
        let group = self.first.partition_point(|&first| first <= trajectory) - 1;
        (&*self.groups[group], trajectory - self.first[group])
    }

    /// The present state of a trajectory; its last state, if it has failed.
    ///
    /// # Panics
    /// If there is no trajectory of this number.
    #[must_use]
    #[track_caller]
    #[inline(never)]
    pub fn state(&self, trajectory: usize) -> State<D> {
        assert!(trajectory < self.len, "trajectory {trajectory} of {}", self.len);
        let (group, own) = self.group(trajectory);
        group.state(own)
    }

    /// The states of all trajectories in order.
    pub fn states(&self) -> impl Iterator<Item = State<D>> + '_ {
        self.groups.iter().flat_map(|group| (0..group.len()).map(|own| group.state(own)))
    }

    /// Why a trajectory has failed; `None` while it has not.
    #[must_use]
    pub fn failure(&self, trajectory: usize) -> Option<&Error> {
        if trajectory >= self.len {
            return None;
        }
        let (group, own) = self.group(trajectory);
        group.failure(own)
    }

    /// The trajectories that have failed, by number, and why.
    pub fn failures(&self) -> impl Iterator<Item = (usize, &Error)> + '_ {
        let groups = self.groups.iter().zip(&self.first);
        groups.flat_map(|(group, &first)| {
            (0..group.len()).filter_map(move |own| group.failure(own).map(|error| (first + own, error)))
        })
    }
}

/// After so many steps it is asked whether observers can go on: seldom, since all threads wait for the last, and where
/// groups in lanes stop anyway.
const UNWATCHED: u64 = 8 * STRETCH;

/// What a checkpoint calls an ensemble.
const AN_ENSEMBLE: &str = "an ensemble";

/// What is wrong with a start of which a number is larger than there are numbers.
#[inline(never)]
pub(super) fn beyond<const D: usize>(most: f64, start: &State<D>) -> Option<Error> {
    start.bodies.iter().enumerate().find_map(|(body, place)| {
        [("position", place.q), ("momentum", place.p)].into_iter().find_map(|(quantity, numbers)| {
            let component = numbers.iter().position(|x| x.abs() > most)?;
            let cause = StartFailure::NotFinite { quantity, component, value: numbers[component] };
            Some(Error::Start { body, cause })
        })
    })
}

impl<const D: usize> fmt::Debug for Ensemble<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut debug = f.debug_struct("Ensemble");
        debug.field("trajectories", &self.len).field("step_size", &self.h).field("steps", &self.steps);
        debug.field("instruction_set", &self.set).finish_non_exhaustive()
    }
}
