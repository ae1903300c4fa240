//! The error of a finished simulation, estimated from other runs.
//!
//! ```text
//! E(h) = C hᵖ:   d₁ = |q(h) − q(rh)| = (rᵖ − 1) E(h),   d₂ = |q(rh) − q(sh)| = (sᵖ − rᵖ) E(h)
//! ```
//!
//! r is 2 and s is 4, or somewhat more where the number of steps is no multiple of 4. p is the observed order, that of
//! d₂/d₁, limited to 1 and the order of the method. So the estimate is right also where the method does not yet show
//! its order; where rounding dominates, it is at most d₁.
//!
//! A few steps cannot be made longer: there, the other run has steps half as long, and E(h) = |q(h) − q(h/2)|/(1 − 2⁻ᵖ)
//! with the order p of the method. So it is where a run with longer steps fails.
//!
//! Errors of adaptive methods are those of the tolerance, no power of it, or those of h where an inner step is a whole
//! one. The other run has both finer: steps half as long, and a hundredth of the tolerance. It is more exact whichever
//! decides.
//!
//! The other runs have the contacts, edges and halvings of the simulation. All begin and end at the same times:
//!
//! ```text
//! staggered      p(t + d(2h)) = p(t + d(h)) + (d(2h) − d(h)) f(q(t))      d the delay of the momenta
//! variable steps the last step is sh, and s is corrected until it ends at the time of the simulation
//! ```
//!
//! Source: L. F. Richardson, Phil. Trans. A 210 (1911) 307.

use crate::error::{Error, PriceMistake};
use crate::methods::able::view;
use crate::motion::failure::Failure;
use crate::motion::method::Method;
use crate::motion::state::State;
use crate::motion::stir::{self, random};
use crate::motion::system::System;
use crate::run::begin::bodies_at;
use crate::run::price::clock::Clock;
use crate::run::price::pricing::positive;
use crate::run::simulation::Simulation;
use std::fmt;
use std::iter::zip;

/// Corrections of the last of the variable steps: the density of steps changes little within one. Where it does change,
/// halvings follow.
const CORRECTIONS: u32 = 16;
/// Halvings of an interval: as many as double numbers have bits.
const HALVINGS: u32 = 53;
/// A variable step is at most so many times as long as the longest: their density follows the wanted one to a factor.
const LONGER: f64 = 3.0;
/// Fewer steps are not made longer: two or three of them say nothing of an order.
const FEW: u64 = 8;
/// The same steps from the same start lead to the same place, up to so many roundings.
const SAME: f64 = 1e6;
/// Two runs of more than a few steps agree better with each other than with a third if that is so many times as far
/// away: of chaotic motion all three are as far apart as it is large.
const CLEARLY: f64 = 2.0;

/// An estimated error, and the cost of the estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The largest error of position of any body, a length.
    pub position: f64,
    /// The error of the energy relative to that of the exact motion, in the unit of energy; of staggered methods, with
    /// momenta that the forces of the present positions bring to the time of these positions.
    pub energy: f64,
    /// The observed order; `None` if there was only one other run.
    pub order: Option<f64>,
    /// Steps of the other runs.
    pub steps: u64,
    /// Seconds that the other runs took.
    pub seconds: f64,
}

impl fmt::Display for Estimate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { position, energy, steps, seconds, .. } = self;
        write!(
            f,
            "error in position {position:.1e}, in energy {energy:.1e}; known after {steps} further steps, {seconds:.2e} s"
        )
    }
}

impl<Y: System<f64, D>, S: Method, const D: usize> Simulation<Y, S, D> {
    /// Estimates the error of the present positions, for a simulation that ran from `start` until now: its first state,
    /// or a [`state`](Self::state) on the way, from where errors are then counted.
    ///
    /// * Fixed steps: compared with runs with steps twice and four times as long, which together take three quarters of
    ///   the time of the simulation.
    /// * Fewer than 8 steps, and where a run with longer steps fails: compared with one run with steps half as long.
    /// * Adaptive methods: compared with one run with steps half as long, and a hundredth of the tolerance, which takes
    ///   some two to four times the time. Where that is below what rounding allows, the tolerance is the same.
    ///
    /// The other runs meet the same [contacts](Self::collide), [cross edges](Self::over_kinks) and
    /// [halve steps](Self::retry) as this one. Where motion is chaotic and the error has grown to the size of the
    /// motion, the estimate has that size.
    ///
    /// A start is not that of this simulation if its time is not so many steps ago; or if the other runs agree clearly
    /// better with each other than with this one, and the same steps from this start do not lead here. Another start
    /// that is off by less than the errors are is not seen.
    ///
    /// The start of a staggered method is one for its step size, as
    /// [`Scene::staggered`](crate::scene::Scene::staggered) makes it; those of the other runs are made from it.
    ///
    /// ```
    /// # use rattle::{nalgebra::Vector3, surfaces::Sphere, Rattle, Scene, State};
    /// let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 0.6, 0.8]);
    /// let mut simulation = Scene::on(Sphere { r: 1.0 }).simulate(start.clone(), Rattle::new(0.01))?;
    /// simulation.run(500)?;
    /// let estimate = simulation.estimate_error(&start)?;
    /// let (sin, cos) = 5_f64.sin_cos();
    /// let truth = (simulation.position() - Vector3::new(cos, 0.6 * sin, 0.8 * sin)).norm();
    /// assert!((estimate.position / truth - 1.0).abs() < 0.1, "{estimate}, in truth {truth:e}");
    /// # Ok::<(), rattle::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Price`] where no step was taken, steps or forces draw random numbers, or `start` is not one of this
    /// simulation; [`Error::Comparison`] where the last comparison fails; [`Error::BodyCount`] for a start with another
    /// number of bodies.
    #[doc(alias = "accuracy")]
    #[doc(alias = "convergence")]
    #[doc(alias = "Richardson extrapolation")]
    pub fn estimate_error(&self, start: &State<D>) -> Result<Estimate, Error> {
        self.estimate_error_by(start, &Clock::default())
    }

    /// As [`estimate_error`](Self::estimate_error), with seconds by this clock.
    ///
    /// # Errors
    /// As there.
    pub fn estimate_error_by(&self, start: &State<D>, clock: &Clock) -> Result<Estimate, Error> {
        if start.len() != self.bodies() {
            return Err(Error::BodyCount { scene: self.bodies(), state: start.len() });
        }
        let steps = self.steps_since(start)?;
        if let Some(effect) = random(&self.system).or(S::DRAWS.then(|| self.method.name())) {
            return Err(Error::Price(PriceMistake::Random { effect }));
        }
        let begun = clock.now();
        let halved = || self.by_shorter(start, steps, &self.method);
        let estimate = match self.method.with_tolerance_times(0.01) {
            Some(finer) => self.by_shorter(start, steps, &finer).or_else(|_| halved()),
            None if steps < FEW => halved(),
            None => self.by_longer(start, steps).or_else(|_| halved()),
        };
        let (estimate, other) = estimate?;
        if let Some(other) = other {
            self.expect_from(start, steps, &other)?;
        }
        Ok(Estimate { seconds: clock.now() - begun, ..estimate })
    }

    /// The error by runs with longer steps; with one of them if they agree clearly better with each other than with
    /// this one.
    fn by_longer(&self, start: &State<D>, steps: u64) -> Result<(Estimate, Option<Self>), Error> {
        let ((twice, r), (fourfold, s)) = (self.longer(start, steps, 2)?, self.longer(start, steps, 4)?);
        let (first, second) = (self.apart(&twice), twice.apart(&fourfold));
        let energy = (self.energy_at_once() - twice.energy_at_once()).abs();
        let most = f64::from(self.method.order().max(1));
        let order = (first > 0.0).then(|| observed_order(second / first, [r, s], most));
        let gain = r.powf(order.unwrap_or(most)) - 1.0;
        let position = (first / gain).max(self.rounding());
        let steps = twice.steps + fourfold.steps;
        let estimate = Estimate { position, energy: energy / gain, order, steps, seconds: 0.0 };
        Ok((estimate, (CLEARLY * second < first).then_some(twice)))
    }

    /// The error by a run of this method with steps half as long; with that run if the error is beyond the tolerance.
    fn by_shorter(
        &self,
        start: &State<D>,
        steps: u64,
        method: &S,
    ) -> Result<(Estimate, Option<Self>), Error> {
        let h = 0.5 * self.step_size();
        let other = self.compared(start, method.with_step(h), 2 * steps)?;
        let order = self.method.order().min(if const { Y::FLOWS > 0 } { stir::ORDER } else { u32::MAX });
        let part = 1.0 - 0.5_f64.powf(f64::from(order.max(1)));
        let position = (self.apart(&other) / part).max(self.rounding());
        let energy = (self.energy_at_once() - other.energy_at_once()).abs() / part;
        let estimate = Estimate { position, energy, order: None, steps: other.steps, seconds: 0.0 };
        let is_fine = self.method.tolerance().is_some_and(|tolerance| position <= tolerance);
        Ok((estimate, (!is_fine).then_some(other)))
    }

    /// Refuses a start from which the same steps lead clearly nearer to the end of this other run than to here.
    fn expect_from(&self, start: &State<D>, steps: u64, other: &Self) -> Result<(), Error> {
        let again = self.other(start, self.method.clone(), steps)?;
        let (off, clearly) = (self.apart(&again), if steps < FEW { 1.0 } else { CLEARLY });
        if off > clearly * again.apart(other) && off > SAME * self.rounding() {
            return Err(Error::Price(PriceMistake::OtherMotion { off }));
        }
        Ok(())
    }

    /// By how much a position is rounded.
    fn rounding(&self) -> f64 {
        0.5 * f64::EPSILON * self.positions().map(|q| q.amax()).fold(0.0, f64::max)
    }

    /// How many steps were taken since this state.
    fn steps_since(&self, start: &State<D>) -> Result<u64, Error> {
        let steps = self.first.step.wrapping_add(self.steps).checked_sub(start.steps());
        let (late, steps) = (steps.is_none(), steps.unwrap_or(0));
        let (h, now) = (self.step_size(), self.time());
        let (way, end) = (steps as f64 * h, start.time() + steps as f64 * h);
        let same = (end - now).abs() <= 1e-9 * way.abs() + 4.0 * f64::EPSILON * now.abs();
        let behind = steps == 0 || (now - start.time()) / h > 0.0;
        let fits = if self.is_variable() { behind } else { same };
        if late || !fits {
            return Err(Error::Price(PriceMistake::OtherStart { start: start.time(), steps, end, now }));
        }
        positive("number of steps taken", steps as f64).map(|_| steps)
    }

    /// A run from this start to the same time with steps so many times as long, or somewhat longer, and how many times.
    fn longer(&self, start: &State<D>, whole: u64, times: u64) -> Result<(Self, f64), Error> {
        let steps = if self.is_variable() { whole } else { whole / times };
        let ratio = if self.is_variable() { times as f64 } else { whole as f64 / steps as f64 };
        let method = self.method.with_step(self.step_size() * ratio);
        self.compared(start, method, steps).map(|run| (run, ratio))
    }

    /// A run from this start to the same time by another method, in so many steps if they have one length.
    fn compared(&self, start: &State<D>, method: S, steps: u64) -> Result<Self, Error> {
        let (h, tolerance) = (method.step_size(), method.tolerance());
        let run = if self.is_variable() {
            self.begin_again(start, method).and_then(|mut other| other.land(self.time()).map(|()| other))
        } else {
            self.other(start, method, steps)
        };
        run.map_err(|error| Error::Comparison { h, tolerance, error: Box::new(error) })
    }

    /// Whether steps have their own lengths.
    fn is_variable(&self) -> bool {
        self.method.time_taken(self.memory.as_ref()).is_some()
    }

    /// A run from this start by another method.
    fn other(&self, start: &State<D>, method: S, steps: u64) -> Result<Self, Error> {
        let mut simulation = self.begin_again(start, method)?;
        simulation.run(steps)?;
        Ok(simulation)
    }

    /// Another method at this start, with the same events and halvings.
    fn begin_again(&self, start: &State<D>, method: S) -> Result<Self, Error> {
        let mut bodies = bodies_at(&self.system, start);
        let (later, h) = (method.momentum_delay() - self.method.momentum_delay(), method.step_size());
        if later != 0.0 {
            let stopped = |Failure { body, cause }| Error::Step { step: 0, time: start.time, body, cause };
            self.system.settle(later, h, &mut bodies, &mut ()).map_err(stopped)?;
        }
        method.prepare(view(&method, &self.system)?, &mut bodies);
        let mut simulation = Self::new(self.system.clone(), bodies, start, method, self.first.trajectory)?;
        if simulation.is_variable() && h != self.step_size() {
            let Self { system, method, bodies, .. } = &simulation;
            let memory = method.memory_within(view(method, system)?, bodies, self.memory.as_ref());
            simulation.memory = memory;
        }
        simulation.halving = self.halving.clone();
        simulation.meet_what(self);
        Ok(simulation)
    }

    /// Goes on to this time by steps of their own length, of which the last is as much shorter as that takes.
    fn land(&mut self, time: f64) -> Result<(), Error> {
        let longest = self.step_size();
        let left = |now: &Self| (time - now.time()) / longest;
        while left(self) > LONGER {
            self.step()?;
        }
        let rounding = 4.0 * f64::EPSILON * (time / longest).abs().max(1.0);
        while left(self) > rounding {
            let before = self.clone();
            self.step()?;
            if left(self) >= -rounding {
                continue;
            }
            let (way, mut part, mut short, mut long) = (left(&before), 1.0, 0.0, 1.0);
            for number in 0..CORRECTIONS + HALVINGS {
                let fitting = part * way / (way - left(self));
                let is_between = number < CORRECTIONS && short < fitting && fitting < long;
                part = if is_between { fitting } else { 0.5 * (short + long) };
                *self = Self { method: before.method.with_step(part * longest), ..before.clone() };
                self.step()?;
                if left(self).abs() <= rounding {
                    break;
                }
                *(if left(self) > 0.0 { &mut short } else { &mut long }) = part;
            }
            break;
        }
        Ok(())
    }

    /// The energy with momenta at the time of the positions.
    fn energy_at_once(&self) -> f64 {
        let delay = self.method.momentum_delay();
        if delay == 0.0 {
            return self.energy();
        }
        let mut bodies = self.bodies.clone();
        self.system.evaluate_forces(&mut bodies);
        match self.system.settle(-delay, self.step_size(), &mut bodies, &mut ()) {
            Ok(()) => self.system.kinetic_energy(&bodies) + self.system.potential_energy(&bodies),
            Err(_) => f64::NAN,
        }
    }

    /// The largest distance of a body from where it is in the other simulation.
    fn apart(&self, other: &Self) -> f64 {
        zip(self.positions(), other.positions()).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
    }
}

/// The order p, from 1 to `most`, with (sᵖ − rᵖ)/(rᵖ − 1) = `ratio`.
fn observed_order(ratio: f64, [r, s]: [f64; 2], most: f64) -> f64 {
    let (mut low, mut high) = (1.0, most);
    for _ in 0..HALVINGS {
        let order = 0.5 * (low + high);
        let at = (s.powf(order) - r.powf(order)) / (r.powf(order) - 1.0);
        *(if at < ratio { &mut low } else { &mut high }) = order;
    }
    0.5 * (low + high)
}
