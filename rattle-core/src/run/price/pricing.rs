//! The measurement: its settings, and series of step sizes for all methods.

use crate::effect::list::{Effects, Forces};
use crate::error::{Error, PriceMistake};
use crate::methods::rattle::Rattle;
use crate::motion::affected::Affected;
use crate::motion::bodies::Count;
use crate::motion::hold::Hold;
use crate::motion::state::State;
use crate::motion::stir::random;
use crate::number::vector::larger_or_nan;
use crate::run::boxed::BoxedSimulation;
use crate::run::price::beside::{Beside, ensemble};
use crate::run::price::candidate::Candidate;
use crate::run::price::chaos::Chaos;
use crate::run::price::clock::Clock;
use crate::run::price::ladder::{Pilot, Runner, Stop, averages_apart, distances, energies_apart};
use crate::run::price::moving::{Movable, Rung};
use crate::run::price::prices::{Average, Longer, Price, Prices, Quantity, Refused};
use crate::run::price::reference::{Reference, most, pilot};
use crate::run::price::set::{Observed, Set};
use crate::scene::Scene;
use std::iter::zip;

/// Seconds that measuring takes at most, if nothing is said.
const BUDGET: f64 = 1.0;
/// Rungs of a ladder: each has at least so many times as many steps as the one before, a number that the instants of
/// the reference allow (√2 times as many on average), or a tenth of its tolerance.
const RUNGS: usize = 48;
const FINER: f64 = 1.25;
/// Where an average is aimed at: so many times as many, at most, and somewhat more than its error lets expect.
const FARTHEST: f64 = 16.0;
const AMPLY: f64 = 1.1;
/// The pilot is as long as this part of the budget lets RATTLE run with its longest step: finer steps take a thousand
/// times as long.
const SHARE: f64 = 1e-3;
/// The same where an error is aimed at, and no step is finer than that needs.
const SHARE_OF_AIM: f64 = 1e-2;
/// Of the budget, what finding the pilot and the reference may take, and what is spent when those of a longer one are
/// found.
const FOR_REFERENCE: f64 = 0.35;
const FOR_LONGER: f64 = 0.5;
/// Where an error is aimed at, a ladder ends after so many rows that reach it, or so many in turn that cost more than
/// it must. With an adaptive method one more is to reach it, and none that is cheaper than the row before counts; nor
/// does a dear row count there that is not dearer than the row before.
const ENOUGH: usize = 2;
const DEARER: usize = 3;
/// There, a method may take a third of what is left: the next ones are cut short by what it finds.
const SHARERS_OF_AIM: usize = 3;
/// Of what is left of the budget, what averages of the reference may take; and to what part of the error that is aimed
/// at they are to be known.
const FOR_AVERAGES: f64 = 0.15;
const KNOWN: f64 = 0.02;
/// A row whose bodies are off by this part of their way says nothing.
const USELESS: f64 = 0.3;

impl<C: Hold<D>, E: Effects<D>, N: Count, const D: usize> Scene<C, E, N, D> {
    /// Measures what accuracy costs in computing time in this scene: runs every method with a series of step sizes on a
    /// pilot interval from `start`, for no longer than the [budget](Pricing::budget). `duration` is the length of the
    /// intended run, in the unit of time.
    ///
    /// ```
    /// # use rattle::{links::planar::Rod, potentials::planar::Gravity, BoxedSimulation, Scene, State};
    /// let pendulum = Scene::points(2).link(Rod { length: 1.0 }, [[0, 1]]).pin(0, [0.0; 2]).with(Gravity { g: 1.0 });
    /// let start = State::of([[0.0, 0.0], [1.0, 0.0]]);
    /// let height = |now: &BoxedSimulation<2>| now.positions().nth(1).unwrap().y;
    /// let prices = pendulum.price(&start, 10.0).budget(1.0).observe("height", height).measure()?;
    /// println!("{prices}");
    /// assert!(prices.rows.iter().all(|row| row.position.is_some())); // how far they get is the processor's
    /// # Ok::<(), rattle::Error>(())
    /// ```
    #[doc(alias = "work-precision diagram")]
    #[doc(alias = "benchmark")]
    pub fn price<'a>(&'a self, start: &'a State<D>, duration: f64) -> Pricing<'a, C, E, N, D> {
        let (allowance, observed) = (Allowance::default(), Vec::new());
        Pricing { scene: self, start, duration, allowance, observed, beside: None, progress: None }
    }
}

/// Settings of a measurement; made by [`Scene::price`].
#[must_use = "`.measure()` measures"]
pub struct Pricing<'a, C, E, N, const D: usize> {
    pub(super) scene: &'a Scene<C, E, N, D>,
    pub(super) start: &'a State<D>,
    pub(super) duration: f64,
    pub(super) allowance: Allowance,
    pub(super) observed: Vec<Observed<'a, D>>,
    pub(super) beside: Option<Beside<C, E, N, D>>,
    pub(super) progress: Option<Box<dyn FnMut(f64) + 'a>>,
}

/// For how long is measured, and by which clock.
#[derive(Debug, Clone)]
pub(super) struct Allowance {
    pub(super) budget: f64,
    pub(super) clock: Clock,
}

impl Default for Allowance {
    fn default() -> Self {
        Self { budget: BUDGET, clock: Clock::default() }
    }
}

impl<'a, C: Hold<D>, E: Effects<D>, N: Count, const D: usize> Pricing<'a, C, E, N, D> {
    /// Measures for at most `seconds`; by default 1. A step that takes longer is still finished.
    pub fn budget(mut self, seconds: f64) -> Self {
        self.allowance.budget = seconds;
        self
    }

    /// Also measures errors of the time average of `what`, a function of the state: how far the average over the steps
    /// of a run, by the trapezoidal rule as [`Mean::over_time`](crate::run::watch::mean::Mean::over_time) takes it, is
    /// off the exact average over the same time. So steps that are too few for the average count as an error of it.
    pub fn observe(
        mut self,
        name: impl Into<String>,
        what: impl Fn(&BoxedSimulation<D>) -> f64 + 'a,
    ) -> Self {
        self.observed.push((name.into(), Box::new(what)));
        self
    }

    /// Prices [ensembles](crate::run::ensemble::Ensemble) too: trajectories from `others` side by side with the one
    /// from the start, on one core, in [double](crate::run::ensemble::Double) precision and, by RATTLE, in single
    /// precision (on surfaces) and with compensated sums. Rows [in lanes](Candidate::InLanes) tell the error of the
    /// trajectory from the start and the cost of one of all trajectories.
    ///
    /// Averages of such a row are not told.
    ///
    /// ```
    /// # use rattle::{potentials::Gravity, surfaces::Torus, Scene, State};
    /// let scene = Scene::on(Torus { major: 1.0, minor: 0.3 }).with(Gravity { g: 1.0 });
    /// let start = |i: u32| State::at([1.3, 0.0, 0.0]).moving([0.0, 1.0, 0.01 * f64::from(i)]);
    /// let prices = scene.price(&start(0), 1.0).side_by_side((1..64).map(start)).budget(0.2).measure()?;
    /// for (digits, nanoseconds, method) in prices.digits_in_lanes() {
    ///     println!("{digits} digits: {nanoseconds:.0} ns a trajectory, by {method}");
    /// }
    /// # Ok::<(), rattle::Error>(())
    /// ```
    pub fn side_by_side(mut self, others: impl IntoIterator<Item = State<D>>) -> Self
    where
        C: 'static,
    {
        let starts = std::iter::once(self.start.clone()).chain(others).collect();
        self.beside = Some(Beside { starts, make: ensemble });
        self
    }

    /// Calls `tell` after every run with the fraction of the budget that is spent, from 0 to 1.
    pub fn progress(mut self, tell: impl FnMut(f64) + 'a) -> Self {
        self.progress = Some(Box::new(tell));
        self
    }

    /// Measures by this clock instead of the machine's.
    pub fn clock(mut self, clock: Clock) -> Self {
        self.allowance.clock = clock;
        self
    }

    /// Runs the measurement.
    ///
    /// # Errors
    /// Those of [`Scene::simulate`]; that of a failed step, if every method failed; [`Error::Price`] for a duration or
    /// budget that is not positive, a budget too short for a reference, and random forces.
    pub fn measure(mut self) -> Result<Prices, Error> {
        let works = priced(self.scene, self.start, self.duration)?;
        let beside = self.beside.take();
        let set = Set { scene: self.scene, start: self.start, observed: &self.observed, beside, works };
        let mut tell = self.progress.take().unwrap_or_else(|| Box::new(|_| {}));
        measure(&set, self.duration, &self.allowance, None, &mut *tell).map(|measured| measured.prices)
    }
}

/// Refuses a start that cannot be simulated, and effects that are random; says whether something does
/// [work](Movable::works).
pub(super) fn priced<C: Hold<D>, E: Effects<D>, N: Count, const D: usize>(
    scene: &Scene<C, E, N, D>,
    start: &State<D>,
    duration: f64,
) -> Result<bool, Error> {
    positive("duration", duration)?;
    let system = scene.ready(start, &Rattle::new(duration))?;
    match random(&system) {
        Some(effect) => Err(Error::Price(PriceMistake::Random { effect })),
        None => Ok(E::Forces::<f64>::WORKS || system.moves_with_time()),
    }
}

pub(super) fn positive(what: &'static str, value: f64) -> Result<(), Error> {
    let fine = value > 0.0 && value.is_finite();
    if fine { Ok(()) } else { Err(Error::Price(PriceMistake::NotPositive { what, value })) }
}

/// Prices, and what they were measured against.
pub(super) struct Measured {
    pub(super) prices: Prices,
    pub(super) pilot: Pilot,
    pub(super) reference: Reference,
}

/// An error that is enough: ladders end where it is reached, or where it costs more than by another method.
#[derive(Debug, Clone, Copy)]
pub(super) struct Aim {
    pub(super) what: Quantity,
    pub(super) error: f64,
}

/// How far a ladder is to be climbed.
struct Climb<'a> {
    pilot: &'a Pilot,
    reference: &'a Reference,
    /// The error that is enough at the end of the whole run, if any is, and by what it is more than that on the pilot
    /// interval.
    aim: Option<(Aim, Longer)>,
    /// What the cheapest row costs that is exact enough.
    least: f64,
}

impl Climb<'_> {
    fn is_for_average(&self) -> bool {
        self.aim.is_some_and(|(aim, _)| aim.what.is_average())
    }

    /// How many times as many steps the rung after this row has. The error of an average falls like h², so one larger
    /// rung leads near to the aim.
    fn finer(&self, row: Option<&Price>) -> f64 {
        let Some(((aim, longer), row)) = self.aim.zip(row).filter(|_| self.is_for_average()) else {
            return FINER;
        };
        let error = longer.at_end(row, aim.what).unwrap_or(0.0);
        let finer = AMPLY * (error / aim.error).sqrt();
        if finer.is_nan() { FINER } else { finer.clamp(FINER, FARTHEST) }
    }

    fn is_enough(&self, row: &Price) -> bool {
        self.aim
            .is_some_and(|(aim, longer)| longer.at_end(row, aim.what).is_some_and(|error| error <= aim.error))
    }
}

/// The pilot, for how long it can be told, and its motion.
struct Exactly {
    pilot: Pilot,
    chaos: Chaos,
    reference: Reference,
}

impl Exactly {
    /// With a pilot on which RATTLE takes so many seconds.
    fn with(runner: &Runner<'_>, duration: f64, seconds: f64) -> Result<Self, Stop> {
        let mut pilot = pilot(runner, duration, seconds)?;
        let chaos = Chaos::look_for(runner, &pilot, duration);
        pilot.told = chaos.told(&pilot);
        let reference = Reference::find(runner, &pilot)?;
        Ok(Self { pilot, chaos, reference })
    }

    /// Whether a longer pilot would tell more about the whole run.
    fn is_too_short(&self, duration: f64) -> bool {
        self.pilot.length < duration && self.chaos.predictable.is_none()
    }
}

/// Finds the reference, and goes up every ladder; where an error is enough, from the methods of high order on, but from
/// the cheapest steps on for an average, since the rule that takes it is of order 2 by any method.
pub(super) fn measure(
    scene: &dyn Movable,
    duration: f64,
    allowance: &Allowance,
    aim: Option<Aim>,
    tell: &mut dyn FnMut(f64),
) -> Result<Measured, Error> {
    positive("budget", allowance.budget)?;
    let begun = allowance.clock.now();
    let until =
        |part: f64| Runner { scene, clock: &allowance.clock, deadline: begun + part * allowance.budget };
    let late = |stop| match stop {
        Stop::Failed(error) => error,
        Stop::Late => Error::Price(PriceMistake::Late { budget: allowance.budget }),
    };
    let mut found = Exactly::with(&until(FOR_REFERENCE), duration, SHARE * allowance.budget).map_err(late)?;
    if aim.is_some() && found.is_too_short(duration) {
        let longer = Exactly::with(&until(FOR_LONGER), duration, SHARE_OF_AIM * allowance.budget);
        found = longer.unwrap_or(found);
    }
    let Exactly { pilot, chaos, mut reference } = found;
    let enough = aim.filter(|aim| aim.what.is_average()).map_or(0.0, |aim| KNOWN * aim.error);
    let runner = until(1.0);
    let deadline = allowance.clock.now() + FOR_AVERAGES * runner.left();
    reference.refine_averages(&Runner { deadline, ..runner }, &pilot, enough);
    let mut tell = || tell(((allowance.clock.now() - begun) / allowance.budget).min(1.0));
    tell();

    let (mut rows, mut refused) = (Vec::new(), Vec::new());
    let (lyapunov_time, told) = (chaos.lyapunov_time, pilot.told == pilot.looks as usize);
    let longer = Longer { duration, pilot: pilot.length, lyapunov_time, told, works: scene.works() };
    let aim = aim.map(|aim| (aim, longer));
    let mut to_climb = Climb { pilot: &pilot, reference: &reference, aim, least: f64::INFINITY };
    let mut methods = Candidate::ALL.to_vec();
    if scene.trajectories() > 0 {
        methods.extend(Candidate::LANES);
    }
    let reversed = aim.is_some() && !to_climb.is_for_average();
    if reversed {
        methods.reverse();
    }
    let count = methods.len();
    for (number, method) in methods.into_iter().enumerate() {
        let sharers = (count - number).min(if aim.is_some() { SHARERS_OF_AIM } else { count });
        let share = runner.left() / sharers as f64;
        let own = Runner { deadline: allowance.clock.now() + share, ..runner };
        let (found, why) = climb(&own, &to_climb, method);
        let enough = found.iter().filter(|row| to_climb.is_enough(row));
        to_climb.least = enough.map(|row| row.seconds).fold(to_climb.least, f64::min);
        if found.is_empty() {
            refused.push(Refused { method, why });
        }
        if reversed {
            rows.splice(0..0, found);
        } else {
            rows.extend(found);
        }
        tell();
    }
    let mut prices = Prices {
        duration,
        pilot: pilot.length,
        reference: [reference.candidate, reference.second],
        reference_error: reference.error,
        reference_energy_error: scene.works().then_some(reference.energy_error),
        rounding: chaos.floor,
        way: reference.way,
        lyapunov_time: chaos.lyapunov_time,
        predictable: chaos.predictable,
        positions_until: pilot.told as f64 * pilot.stretch(),
        averages: named_averages(scene, &reference),
        rows,
        refused,
        seconds: allowance.clock.now() - begun,
    };
    prices.mark_front();
    Ok(Measured { prices, pilot, reference })
}

/// Averages of the reference, and their uncertainty from means over parts.
fn named_averages(scene: &dyn Movable, reference: &Reference) -> Vec<Average> {
    let looks = &reference.path.observed;
    let parts: Vec<_> = looks.chunks(looks.len().div_ceil(8).max(1)).collect();
    let uncertainty = |i: usize| {
        let means: Vec<f64> = parts
            .iter()
            .map(|part| part.iter().map(|values| values[i]).sum::<f64>() / part.len() as f64)
            .collect();
        let n = means.len() as f64;
        let mean = means.iter().sum::<f64>() / n;
        (means.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (n * (n - 1.0)).max(1.0)).sqrt()
    };
    let named = zip(scene.names(), &reference.averages).enumerate();
    named.map(|(i, (name, &mean))| Average { name, mean, uncertainty: uncertainty(i) }).collect()
}

/// The rows of one method, and why it failed if it did.
fn climb(runner: &Runner<'_>, to_climb: &Climb<'_>, method: Candidate) -> (Vec<Price>, Option<Error>) {
    let Climb { pilot, reference, .. } = *to_climb;
    let (mut rows, mut why): (Vec<Price>, _) = (Vec::new(), None);
    let size = pilot.size;
    let mut steps = pilot.steps(method.reach() * pilot.longest);
    let (mut tolerance, mut seconds, mut stuck) = (size * 0.01, 0.0, 0);
    let (mut enough, mut dearer, mut before) = (0, 0, f64::NAN);
    for _ in 0..RUNGS {
        // Sampled once and timed once or more often: what the next rung will take at least.
        if 3.0 * seconds > runner.left() {
            break;
        }
        let rung = Rung { candidate: method, h: pilot.stretch() / steps as f64, tolerance };
        match price(runner, pilot, reference, steps, rung) {
            Ok((price, took)) => {
                seconds = took;
                let row = follow(price, rows.last(), runner, pilot, reference);
                let useless =
                    row.position.is_some_and(|error| error.is_nan() || error > USELESS * reference.way);
                stuck = if row.rounding { stuck + 1 } else { 0 };
                // With a large tolerance an adaptive method tries steps in vain, and may be cheaper with a smaller one.
                let falls = method.is_adaptive() && row.seconds < before;
                let rises = !method.is_adaptive() || row.seconds > before;
                let is_dearer = row.seconds > to_climb.least && rises;
                before = row.seconds;
                enough += usize::from(to_climb.is_enough(&row) && !falls);
                dearer = if is_dearer { dearer + 1 } else { 0 };
                if !useless || reference.way == 0.0 {
                    rows.push(row);
                }
            }
            Err(Stop::Late) => break,
            Err(Stop::Failed(error)) => {
                let hopeless = !matches!(error, Error::Step { .. });
                why = Some(error);
                if hopeless || (method.is_adaptive() && !rows.is_empty()) {
                    break;
                }
                if method.is_adaptive() {
                    steps = pilot.at_instants(2 * steps); // a whole step that leads too far fails whatever its tolerance
                    continue;
                }
            }
        }
        // Shorter steps improve an average long after positions are at their rounding; smaller tolerances do not.
        stuck = if to_climb.is_for_average() && !method.is_adaptive() { 0 } else { stuck };
        let later = usize::from(method.is_adaptive());
        if stuck == 2 || enough == ENOUGH + later || dearer == DEARER {
            break;
        }
        if method.is_adaptive() {
            tolerance *= 0.1;
            if tolerance < 1e-17 * size {
                break;
            }
        } else {
            steps = pilot.at_instants((steps as f64 * to_climb.finer(rows.last())).ceil() as u64);
        }
    }
    (rows, why)
}

/// One row, as far as it can be told without the row before it; and how long one run takes.
pub(super) fn price(
    runner: &Runner<'_>,
    pilot: &Pilot,
    reference: &Reference,
    steps: u64,
    rung: Rung,
) -> Result<(Price, f64), Stop> {
    let path = runner.path(pilot, steps, rung)?;
    let timed = runner.time(pilot, steps, rung, path.seconds)?;
    // What interrupts a run makes it longer, never shorter.
    let (seconds, spread) =
        timed.map_or((path.seconds, 1.0), |(median, spread)| (median.min(path.seconds), spread));
    let mut distances = distances(&path, &reference.path, runner.scene.dimension());
    let mut energies = energies_apart(&path, &reference.path);
    if runner.scene.flows() {
        // Half of a flow before a step and half after it is the same by every method: what the reference is off by is
        // not seen in these differences.
        distances.iter_mut().for_each(|off| *off += reference.error);
        energies.iter_mut().for_each(|off| *off += reference.energy_error);
    }
    let lanes = rung.candidate.is_in_lanes();
    let energies = pilot.told(&energies);
    let (energy, energies) = if pilot.told == pilot.looks as usize && runner.scene.works() {
        (most(energies), energies)
    } else if energies.is_empty() {
        (most(&path.energy), &path.energy[..])
    } else {
        (larger_or_nan(most(energies), most(&path.energy)), energies)
    };
    let drift = |i| {
        let off = averages_apart(&path, &reference.path, i);
        [most(&off), growth(&off)]
    };
    let drifts = (0..path.averages.len()).map(drift).collect();
    let energy_growth = growth(energies);
    let averages = if lanes { vec![f64::NAN; reference.averages.len()] } else { path.averages.clone() };
    let known = zip(&reference.averages, &reference.averages_off);
    let off = |(a, (b, least)): (f64, (&f64, &f64))| larger_or_nan(*least, (a - b).abs());
    let price = Price {
        method: rung.candidate,
        h: rung.h,
        tolerance: rung.candidate.is_adaptive().then_some(rung.tolerance),
        position: (pilot.told > 0).then(|| most(pilot.told(&distances))),
        energy,
        averages: zip(averages, known).map(off).collect(),
        drifts,
        growth: [growth(pilot.told(&distances)), energy_growth],
        seconds: seconds / pilot.length / runner.trajectories(rung.candidate) as f64,
        spread,
        steps: steps * pilot.looks,
        corrections: path.iterations,
        order: None,
        rounding: false,
        front: false,
    };
    Ok((price, path.seconds.max(seconds)))
}

/// The exponent a of tᵃ between the middle and the end.
fn growth(errors: &[f64]) -> f64 {
    let (half, whole) = (most(&errors[..errors.len() / 2]), most(errors));
    if half > 0.0 { (whole / half).log2() } else { 1.0 }
}

/// The row with what the one before it tells: the order, and whether rounding decides.
fn follow(
    mut row: Price,
    before: Option<&Price>,
    runner: &Runner<'_>,
    pilot: &Pilot,
    reference: &Reference,
) -> Price {
    let Some(before) = before else { return row };
    let of = if pilot.told == pilot.looks as usize { Quantity::Position } else { Quantity::Energy };
    let (Some(long), Some(short)) = (before.error(of), row.error(of)) else { return row };
    let finer = before.fineness() / row.fineness();
    let gained = (long / short).ln() / finer.ln();
    if row.tolerance.is_none() && gained.is_finite() {
        row.order = Some(gained);
    }
    let size = reference.way.max(f64::MIN_POSITIVE);
    let expected = if row.tolerance.is_some() { 1.0 } else { f64::from(runner.order(row.method)) };
    let small = match of {
        Quantity::Position => short <= row.method.fine() * size,
        _ => short <= row.method.fine() * reference.path.kinetic.max(f64::MIN_POSITIVE),
    };
    row.rounding = small && gained < 0.4 * expected || short == 0.0;
    row
}
