//! The error of a finished simulation, estimated from other runs.
//!
//! ```text
//! E(h) = C hᵖ:   d₁ = |q(h) − q(2h)| = (ρ − 1) E(h),   d₂ = |q(2h) − q(4h)| = ρ d₁,   E(h) = d₁/(ρ − 1)
//! ```
//!
//! ρ is the observed ratio d₂/d₁, limited to 2 ≤ ρ ≤ 2ᵖ. So the estimate is right also where the method does not yet
//! show its order; where rounding dominates, it is d₁. Errors of adaptive methods are no power of the tolerance: these
//! methods are compared with a run at a hundredth of the tolerance.
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
use crate::motion::stir::random;
use crate::motion::system::System;
use crate::run::begin::bodies_at;
use crate::run::price::clock::Clock;
use crate::run::price::pricing::positive;
use crate::run::simulation::Simulation;
use std::fmt;
use std::iter::zip;

/// Corrections of the last of the variable steps: the density of steps changes little within one. Where it does change,
/// as many halvings follow as double numbers have digits.
const CORRECTIONS: u32 = 16;
const HALVINGS: u32 = 53;
/// A variable step is at most so many times as long as the longest: their density follows the wanted one to a factor.
const LONGER: f64 = 3.0;

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
    /// or a [`state`](Self::state) on the way, from where errors are then counted. Fixed-step
    /// methods are compared with runs with steps twice and four times as long, which together take three quarters of
    /// the time of the simulation; adaptive methods with one run at a hundredth of the tolerance. The other runs meet
    /// the same [contacts](Self::collide), [cross edges](Self::over_kinks) and [halve steps](Self::retry) as this one.
    /// Where motion is chaotic and the error has grown to the size of the motion, the estimate has that size.
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
    /// That of the first comparison run that fails; [`Error::Price`] where no step was taken, steps or forces draw
    /// random numbers, or `start` is not one from which so many steps lead to the present time; [`Error::BodyCount`]
    /// for a start with another number of bodies.
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
        if let Some(finer) = self.method.with_tolerance_times(0.01) {
            let exact = self.other(start, finer, steps)?;
            let energy = (self.energy() - exact.energy()).abs();
            let position = self.apart(&exact).max(self.rounding());
            return Ok(Estimate { position, energy, order: None, steps, seconds: clock.now() - begun });
        }
        let twice = self.coarser(start, steps, 2)?;
        let first = self.apart(&twice);
        let energy = (self.energy_at_once() - twice.energy_at_once()).abs();
        let most = 2_f64.powi(self.method.order() as i32);
        let (mut gain, mut others, mut order) = (most, twice.steps, None);
        if let Ok(fourfold) = self.coarser(start, steps, 4) {
            others += fourfold.steps;
            if first > 0.0 {
                gain = (twice.apart(&fourfold) / first).clamp(2.0, most);
                order = Some(gain.log2());
            }
        }
        let position = (first / (gain - 1.0)).max(self.rounding());
        Ok(Estimate {
            position,
            energy: energy / (gain - 1.0),
            order,
            steps: others,
            seconds: clock.now() - begun,
        })
    }

    /// By how much a position is rounded.
    fn rounding(&self) -> f64 {
        0.5 * f64::EPSILON * self.positions().map(|q| q.amax()).fold(0.0, f64::max)
    }

    /// How many steps were taken since this state.
    fn steps_since(&self, start: &State<D>) -> Result<u64, Error> {
        let steps = self.first.step.wrapping_add(self.steps).wrapping_sub(start.steps());
        let (h, now) = (self.step_size(), self.time());
        let (way, end) = (steps as f64 * h, start.time() + steps as f64 * h);
        let same = (end - now).abs() <= 1e-9 * way.abs() + 4.0 * f64::EPSILON * now.abs();
        if self.method.time_taken(self.memory.as_ref()).is_none() && !same {
            return Err(Error::Price(PriceMistake::OtherStart { start: start.time(), steps, end, now }));
        }
        positive("number of steps taken", steps as f64).map(|_| steps)
    }

    /// A run from this start to the same time, which is so many steps away, with steps so many times as long.
    fn coarser(&self, start: &State<D>, whole: u64, times: u64) -> Result<Self, Error> {
        if self.method.time_taken(self.memory.as_ref()).is_some() {
            let mut other =
                self.begin_again(start, self.method.with_step(self.step_size() * times as f64))?;
            other.land(self.time())?;
            return Ok(other);
        }
        let steps = (whole / times).max(1);
        let h = self.step_size() * whole as f64 / steps as f64;
        self.other(start, self.method.with_step(h), steps)
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
        simulation.halving = self.halving;
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
