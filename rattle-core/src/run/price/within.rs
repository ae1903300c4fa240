//! A run with a given error: the method and step size that reach it in the least time, and the expected cost.

use crate::effect::list::Effects;
use crate::error::{Error, Limit, PriceMistake};
use crate::motion::bodies::Count;
use crate::motion::hold::Hold;
use crate::motion::state::State;
use crate::number::vector::larger_or_nan;
use crate::run::boxed::BoxedSimulation;
use crate::run::price::candidate::{Candidate, HALVINGS};
use crate::run::price::clock::Clock;
use crate::run::price::ladder::Runner;
use crate::run::price::moving::{Movable, Rung};
use crate::run::price::prices::{Offer, Price, Prices, Quantity, interpolate};
use crate::run::price::pricing::{Aim, Allowance, Measured, measure, positive, price, priced};
use crate::run::price::set::{Observed, Set};
use crate::run::price::show::figure;
#[cfg(doc)]
use crate::run::watch::mean::Mean;
use crate::scene::Scene;
use std::fmt;

/// Of the budget, what the ladders may take; the rest verifies.
const FOR_LADDERS: f64 = 0.75;
/// The step is chosen for this part of the wish.
const AIM: f64 = 0.9;
/// So many of the cheapest offers are verified, each with so many steps.
const OFFERS: usize = 4;
const TRIES: usize = 6;
/// An interval of so many half quartile distances holds nearly all repeats.
const NEARLY_ALL: f64 = 3.0;
/// No forecast is told to be surer than this.
const SUREST: f64 = 0.02;
/// Nor than this for parts of a run that the pilot did not see.
const SUREST_BEYOND: f64 = 0.15;
/// An order below this, of a method of order 8 or more, tells that something is not smooth.
const NOT_SMOOTH: f64 = 4.0;
/// So many of the shortest steps of a method tell that.
const SHORTEST: usize = 4;
/// An average that is off by this part of itself is off by rounding: by some hundred times what references are known
/// to.
const AT_ROUNDING: f64 = 1e-11;
/// A reference is exact if another one repeats it to this part of the way.
const EXACT: f64 = 1e-9;

impl<C: Hold<D>, E: Effects<D>, N: Count, const D: usize> Scene<C, E, N, D> {
    /// A run whose error is at most `error`: by default the error of position, a length, after each of its steps. It
    /// is measured at three instants or more in each longest step that RATTLE can take, at fewer where there are very
    /// many bodies; after steps in between it may be some percent larger. A run that is longer than what the budget
    /// lets measure has the error that is expected from its beginning, see [`Planned::error`].
    ///
    /// What acts for a much shorter time than the longest steps that are tried, such as a pulse in the middle of a run
    /// at rest, may be met by no method, and is then no part of any error.
    ///
    /// Method and step size are chosen by [measuring](Self::price); see [`price`](crate::run::price) for an example.
    #[doc(alias = "accuracy")]
    #[doc(alias = "tolerance")]
    #[doc(alias = "error control")]
    pub fn within(&self, error: f64) -> Within<'_, C, E, N, D> {
        let (what, observed) = (Quantity::Position, Vec::new());
        Within { scene: self, error, what, observed, allowance: Allowance::default(), progress: None }
    }
}

/// Settings of a run with a given error; made by [`Scene::within`].
#[must_use = "`.simulate(start, duration)` makes the simulation"]
pub struct Within<'a, C, E, N, const D: usize> {
    scene: &'a Scene<C, E, N, D>,
    error: f64,
    what: Quantity,
    observed: Vec<Observed<'a, D>>,
    allowance: Allowance,
    progress: Option<Box<dyn FnMut(f64) + 'a>>,
}

impl<'a, C: Hold<D>, E: Effects<D>, N: Count, const D: usize> Within<'a, C, E, N, D> {
    /// Limits the error of the energy instead, in its unit, after each step: what it has changed by or, where forces or
    /// constraints change with time or flows do work, how far it is off that of the exact motion; measured as
    /// above.
    pub fn in_energy(mut self) -> Self {
        self.what = Quantity::Energy;
        self
    }

    /// Limits the error of the time average of `what` over the run instead, a function of the state: how far its
    /// average over the steps, by the trapezoidal rule, is off the exact average over the same time. That rule is of
    /// order 2, so the planned run has short steps if the error is small. [`Mean::over_time`] takes the average
    /// of such a run:
    ///
    /// ```
    /// # use rattle::{prelude::*, surfaces::Sphere};
    /// let scene = Scene::on(Sphere { r: 1.0 });
    /// let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 0.6, 0.8]);
    /// let x = |now: &BoxedSimulation<3>| now.positions().next().unwrap().x;
    /// let mut planned = scene.within(1e-4).in_average("x", x).simulate(&start, 5.0)?;
    /// let mut mean = Mean::over_time(|now: &Sight<'_, 3>| now.positions[0].x);
    /// planned.simulation.observe(planned.steps, 1, &mut mean)?;
    /// assert!((mean.mean() - 5_f64.sin() / 5.0).abs() < 1e-4);
    /// # Ok::<(), rattle::Error>(())
    /// ```
    pub fn in_average(
        mut self,
        name: impl Into<String>,
        what: impl Fn(&BoxedSimulation<D>) -> f64 + 'a,
    ) -> Self {
        self.observed = vec![(name.into(), Box::new(what))];
        self.what = Quantity::Average(0);
        self
    }

    /// Measures for at most `seconds`; by default 1.
    pub fn budget(mut self, seconds: f64) -> Self {
        self.allowance.budget = seconds;
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

    /// Measures, and makes the simulation that reaches the error in the least time.
    ///
    /// # Errors
    /// [`PriceMistake::Unreachable`] in [`Error::Price`] where no method is that exact, with the smallest possible
    /// error and its reason; else as [`measure`](crate::run::price::Pricing::measure).
    pub fn simulate(mut self, start: &State<D>, duration: f64) -> Result<Planned<D>, Error> {
        positive("error wished for", self.error)?;
        positive("budget", self.allowance.budget)?; // parts of it are handed on
        let works = priced(self.scene, start, duration)?;
        let set = Set { scene: self.scene, start, observed: &self.observed, beside: None, works };
        let mut tell = self.progress.take().unwrap_or_else(|| Box::new(|_| {}));
        let Choice { rung, price, error, prices } =
            choose(&set, duration, self.error, self.what, &self.allowance, &mut *tell)?;
        let simulation =
            rung.candidate.simulation(self.scene, start.clone(), rung.h, rung.tolerance, HALVINGS)?;
        let pilots = (duration / prices.pilot).round();
        let surest = if pilots > 1.0 { SUREST_BEYOND } else { SUREST };
        Ok(Planned {
            simulation,
            method: price.method,
            h: price.h,
            tolerance: price.tolerance,
            steps: (pilots as u64).saturating_mul(price.steps),
            error,
            seconds: price.seconds * duration,
            spread: (NEARLY_ALL * price.spread).clamp(surest, 1.0),
            prices,
            clock: self.allowance.clock,
        })
    }
}

/// A simulation with a given error, before its run; `Display` shows method, step size and expected cost.
#[derive(Debug, Clone)]
pub struct Planned<const D: usize> {
    /// The simulation, at its start. Call [`run`](Self::run); or, to observe it, take [`steps`](Self::steps) steps of
    /// it yourself.
    pub simulation: BoxedSimulation<D>,
    /// The method that was chosen.
    pub method: Candidate,
    /// The step size.
    pub h: f64,
    /// The tolerance, of an adaptive method.
    pub tolerance: Option<f64>,
    /// Steps of the whole run.
    pub steps: u64,
    /// The expected error of the whole run: measured on the pilot interval, extrapolated to the whole run if that is
    /// longer, and then doubled, since errors do not grow steadily. A pilot that does not show what the motion goes
    /// through, by being shorter than a period, tells little of the rest: errors may be many times as large, and
    /// [`Prices::pilot`] says how long it was. A larger [budget](Within::budget) makes it longer.
    pub error: f64,
    /// Expected seconds of the whole run, on one core.
    pub seconds: f64,
    /// The relative uncertainty of `seconds`, if the rest of the run is like the pilot interval.
    pub spread: f64,
    /// The measurements, as far as they were needed.
    pub prices: Prices,
    clock: Clock,
}

/// The cost of a run; `Display` compares it with the expected cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spent {
    /// Seconds that the run took.
    pub seconds: f64,
    /// Expected seconds.
    pub expected: f64,
}

impl<const D: usize> Planned<D> {
    /// Takes the remaining steps of the run; returns what they cost, and what they were expected to cost.
    ///
    /// # Errors
    /// As [`Simulation::run`](crate::run::simulation::Simulation::run).
    pub fn run(&mut self) -> Result<Spent, Error> {
        let left = self.steps.saturating_sub(self.simulation.steps());
        let begun = self.clock.now();
        self.simulation.run(left)?;
        let expected = self.seconds * left as f64 / self.steps.max(1) as f64;
        Ok(Spent { seconds: self.clock.now() - begun, expected })
    }
}

impl<const D: usize> fmt::Display for Planned<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, h = {:.4e}", self.method, self.h)?;
        if let Some(tolerance) = self.tolerance {
            write!(f, ", tolerance {tolerance:.1e}")?;
        }
        write!(
            f,
            ": {} steps in {:.3e} s ± {:.0} % on one core, to an error of {:.1e}",
            self.steps,
            self.seconds,
            100.0 * self.spread,
            self.error
        )?;
        let Prices { pilot, duration, .. } = self.prices;
        if pilot < duration {
            let [pilot, duration] = [pilot, duration].map(|time| figure(time, 3));
            write!(f, ", as the first {pilot} of {duration} units of time let expect")?;
        }
        Ok(())
    }
}

impl fmt::Display for Spent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.expected > 0.0 {
            let off = 100.0 * (self.seconds / self.expected - 1.0);
            return write!(f, "{:.3e} s, {off:+.0} % of what was expected", self.seconds);
        }
        write!(f, "{:.3e} s, where no step was left", self.seconds)
    }
}

/// What was chosen.
struct Choice {
    rung: Rung,
    price: Price,
    error: f64,
    prices: Prices,
}

fn choose(
    scene: &dyn Movable,
    duration: f64,
    wish: f64,
    what: Quantity,
    allowance: &Allowance,
    tell: &mut dyn FnMut(f64),
) -> Result<Choice, Error> {
    let begun = allowance.clock.now();
    let ladders = Allowance { budget: FOR_LADDERS * allowance.budget, ..allowance.clone() };
    let aim = Aim { what, error: AIM * wish };
    let measured = measure(scene, duration, &ladders, Some(aim), &mut |part| tell(FOR_LADDERS * part));
    let measured = measured.map_err(|error| match error {
        Error::Price(PriceMistake::Late { .. }) => {
            Error::Price(PriceMistake::Late { budget: allowance.budget })
        }
        other => other,
    })?;
    let energy = measured.reference.path.size;
    let limits = Limits { seconds: allowance.budget, flows: scene.flows(), energy };
    let runner = Runner { scene, clock: &allowance.clock, deadline: begun + allowance.budget };
    let prices = &measured.prices;
    if prices.needs_positions(what) && lost(prices) || uncertain(prices, what).is_some_and(|by| by > wish) {
        return Err(unreachable(prices, wish, what, limits));
    }

    let mut offers: Vec<(Candidate, Offer)> = Vec::new();
    for method in Candidate::ALL {
        let rows = prices.of(method);
        let offer = rows
            .last()
            .and_then(|last| interpolate(&rows, what, AIM * wish / prices.longer().grown(last, what)));
        offers.extend(offer.map(|offer| (method, offer)));
    }
    offers.sort_by(|a, b| a.1.seconds.total_cmp(&b.1.seconds));
    let mut best = cheapest_row(prices, wish, what);
    for (number, (method, offer)) in offers.into_iter().enumerate() {
        let dearer = best.as_ref().is_some_and(|(_, price, _)| price.seconds <= offer.seconds);
        if number >= OFFERS && best.is_some() || dearer {
            break;
        }
        if let Some(found) = verify(&runner, &measured, method, offer, wish, what)
            && best.as_ref().is_none_or(|(_, price, _)| found.1.seconds < price.seconds)
        {
            best = Some(found);
        }
    }
    tell(1.0);
    let Some((rung, price, error)) = best else {
        return Err(unreachable(prices, wish, what, limits));
    };
    Ok(Choice { rung, price, error, prices: measured.prices })
}

/// The error of a row at the end of the run, as far as another method confirms it: by itself the reference's own method
/// is as good as it converges, though it may converge to something else.
fn confirmed(prices: &Prices, row: &Price, what: Quantity) -> Option<f64> {
    let longer = prices.longer();
    let known = match what {
        _ if row.method != prices.reference[0] => 0.0,
        Quantity::Position => prices.reference_error,
        Quantity::Energy => prices.reference_energy_error.unwrap_or(0.0),
        Quantity::Average(_) => 0.0,
    };
    let known = if known > 0.0 { known * longer.grown(row, what) } else { 0.0 };
    Some(larger_or_nan(longer.at_end(row, what)?, known))
}

/// The cheapest row that meets the wish, which any other must beat.
fn cheapest_row(prices: &Prices, wish: f64, what: Quantity) -> Option<(Rung, Price, f64)> {
    let met = prices.rows.iter().filter_map(|row| {
        let error = confirmed(prices, row, what)?;
        let rung = Rung { candidate: row.method, h: row.h, tolerance: row.tolerance.unwrap_or(0.0) };
        (error <= wish).then(|| (rung, row.clone(), error))
    });
    met.min_by(|a, b| a.1.seconds.total_cmp(&b.1.seconds))
}

/// An offer run on the pilot interval, with shorter steps until the wish is met.
fn verify(
    runner: &Runner<'_>,
    measured: &Measured,
    method: Candidate,
    offer: Offer,
    wish: f64,
    what: Quantity,
) -> Option<(Rung, Price, f64)> {
    let Measured { prices, pilot, reference } = measured;
    let rows = prices.of(method);
    let known = rows[offer.row];
    let looks = pilot.looks;
    let tolerance = known.tolerance.map_or(0.0, |_| offer.fineness);
    let first = if known.tolerance.is_some() { known.steps / looks } else { pilot.steps(offer.fineness) };
    let (mut steps, mut tolerance) = (first.min(known.steps / looks), tolerance);
    for _ in 0..TRIES {
        let rung = Rung { candidate: method, h: pilot.stretch() / steps as f64, tolerance };
        let again = steps == known.steps / looks && known.tolerance.is_none_or(|t| t == tolerance);
        let price = if again { known.clone() } else { price(runner, pilot, reference, steps, rung).ok()?.0 };
        let error = confirmed(prices, &price, what)?;
        if error <= wish {
            return Some((rung, price, error));
        }
        if again {
            break;
        }
        match known.tolerance {
            Some(least) => tolerance = (tolerance * (0.8 * wish / error)).max(least),
            None => {
                // The rule that takes an average is of order 2.
                let order = if what.is_average() { method.order().min(2) } else { runner.order(method) };
                let more = (error / wish).powf(1.0 / f64::from(order));
                let more = ((steps as f64 * more).ceil() as u64).max(steps + 1);
                steps = pilot.at_instants(more).min(known.steps / looks);
            }
        }
    }
    None
}

/// Whether positions cannot be told to the end.
fn lost(prices: &Prices) -> bool {
    !prices.tells_positions() || prices.predictable.is_some_and(|time| time < prices.duration)
}

/// By how much an average is uncertain on principle: where motion is chaotic and positions are lost.
fn uncertain(prices: &Prices, what: Quantity) -> Option<f64> {
    let Quantity::Average(number) = what else { return None };
    if prices.tells_positions() {
        return None;
    }
    prices.averages.get(number).map(|average| average.uncertainty * (prices.pilot / prices.duration).sqrt())
}

/// What limits accuracy besides what was measured.
#[derive(Clone, Copy)]
struct Limits {
    /// The budget.
    seconds: f64,
    /// Whether flows act, which are of second order.
    flows: bool,
    /// The size of the energy, by which it is rounded.
    energy: f64,
}

impl Limits {
    /// That there was no time for shorter steps.
    fn of_time(self) -> Limit {
        let Self { seconds, flows, .. } = self;
        if flows { Limit::Flows { seconds } } else { Limit::Budget { seconds } }
    }
}

fn unreachable(prices: &Prices, wish: f64, what: Quantity, limits: Limits) -> Error {
    let rows = prices.rows.iter().filter_map(|row| Some((confirmed(prices, row, what)?, row)));
    let best = rows.min_by(|a, b| a.0.total_cmp(&b.0));
    let (best, row) = best.map_or((f64::NAN, None), |(error, row)| (error, Some(row)));
    let chaos = prices.lyapunov_time.zip(prices.predictable);
    let limit = match (chaos, uncertain(prices, what)) {
        (Some((lyapunov_time, predictable)), _) if prices.needs_positions(what) && lost(prices) => {
            Limit::Chaos { lyapunov_time, predictable }
        }
        (_, Some(uncertainty)) => Limit::Statistics { uncertainty },
        _ if let Quantity::Average(number) = what => {
            let size = prices.averages.get(number).map_or(0.0, |average| average.mean.abs());
            if best <= AT_ROUNDING * size { Limit::Rounding } else { limits.of_time() }
        }
        _ => limit(prices, row, best, what, limits),
    };
    let method = row.map_or_else(|| "no method".into(), |row| row.method.to_string());
    let what = match what {
        Quantity::Position => "in position".into(),
        Quantity::Energy => "in energy".into(),
        Quantity::Average(number) => format!("in the average of {}", prices.averages[number].name),
    };
    Error::Price(PriceMistake::Unreachable { wish, what, best, method, limit })
}

/// What limits motion that can be predicted.
fn limit(prices: &Prices, best: Option<&Price>, error: f64, what: Quantity, limits: Limits) -> Limit {
    let known = prices.reference_error.max(prices.rounding);
    let rounding = match prices.lyapunov_time.zip(prices.predictable) {
        Some((lyapunov_time, predictable)) if prices.needs_positions(what) => {
            Limit::Chaos { lyapunov_time, predictable }
        }
        _ => Limit::Rounding,
    };
    let rounded = match what {
        Quantity::Energy => {
            larger_or_nan(prices.reference_energy_error.unwrap_or(0.0), f64::EPSILON * limits.energy)
        }
        _ => known,
    };
    if best.is_some_and(|row| row.rounding) {
        return rounding;
    }
    match order(prices) {
        Some(order) if order < NOT_SMOOTH && !limits.flows => Limit::Kink { order },
        // A reference that is not exact had no time to become so.
        _ if error <= 100.0 * rounded && known <= prices.rounding.max(EXACT * prices.way) => rounding,
        _ => limits.of_time(),
    }
}

/// The order that methods of order 8 and more show with their shortest steps: the median.
fn order(prices: &Prices) -> Option<f64> {
    let high = Candidate::ALL.into_iter().filter(|method| method.order() >= 8 && !method.is_adaptive());
    let mut orders: Vec<f64> = high
        .flat_map(|method| {
            let rows = prices.of(method);
            let smooth = rows.into_iter().rev().filter(|row| !row.rounding).take(SHORTEST);
            smooth.filter_map(|row| row.order).collect::<Vec<_>>()
        })
        .collect();
    orders.sort_by(f64::total_cmp);
    (orders.len() >= SHORTEST).then(|| orders[orders.len() / 2])
}
