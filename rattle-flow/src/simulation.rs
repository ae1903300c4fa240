//! Simulations of a flow in time.

use crate::budget::Budget;
use crate::clock::Clock;
use crate::error::FlowError;
use crate::flow::{Flow, number};
use crate::method::{Method, StepInfo, Trouble};
use crate::sources::Sources;

/// So often a step that failed is halved.
const HALVINGS: u32 = 12;

/// So often in a row a step that is chosen by its error may fail: the next one is a quarter of it.
const QUARTERS: u32 = HALVINGS / 2;

/// Steps that are chosen by their error get no shorter than this part of the first one, 2⁻⁴⁰.
const SHORTEST: f64 = 1.0 / (1_u64 << 40) as f64;
/// Rounding of depths is an error of steps of about 10⁻¹⁵.
const LEAST_TOLERANCE: f64 = 1e-12;
/// A part of a step is not shorter than this part of it: times to meet are rounded.
const LEAST_PART: f64 = 1e-9;

/// A flow, its present state, and its water budget.
///
/// A step that fails is divided into two halves, these into halves again, down to 1/4096 of the step. If that fails
/// too, the state is the last good one, and the error says where and when.
pub struct Simulation<M> {
    flow: Flow,
    method: M,
    depth: Vec<f64>,
    /// Depth one step before, and how long that step was.
    earlier: Vec<f64>,
    earlier_step: f64,
    /// What flowed to each vertex in that step, a volume: all but rain and inflow.
    flowed: Vec<f64>,
    guess: Vec<f64>,
    sources: Sources,
    clock: Clock,
    step: f64,
    budget: Budget,
    /// The most water that there was in a step, with what came in it.
    most: f64,
    iterations: usize,
    steps: usize,
}

impl<M: Method> Simulation<M> {
    pub(crate) fn new(flow: Flow, depth: Vec<f64>, step: f64, method: M) -> Result<Self, FlowError> {
        number("the time step", step, step > 0.0, "a positive number")?;
        let volume = flow.mesh.volume_of(&depth);
        let n = depth.len();
        Ok(Simulation {
            flow,
            method,
            earlier: depth.clone(),
            earlier_step: 0.0,
            flowed: vec![0.0; n],
            guess: depth.clone(),
            depth,
            sources: Sources::of(n),
            clock: Clock::default(),
            step,
            budget: Budget { start: volume, now: volume, ..Budget::default() },
            most: volume,
            iterations: 0,
            steps: 0,
        })
    }

    /// Takes one time step; in parts where a time to [meet](Flow::meet) is inside of it. Of steps of one length alone
    /// the time is their number times the length, rounded once.
    ///
    /// # Errors
    /// [`FlowError::NotConverged`], [`FlowError::Singular`], and [`FlowError::Given`] for rain and inflow; the state is
    /// then that of the last part of the step that succeeded.
    #[doc(alias = "integrate")]
    #[doc(alias = "advance")]
    pub fn step(&mut self) -> Result<StepInfo, FlowError> {
        let (mut left, mut info, least) = (self.step, StepInfo::default(), LEAST_PART * self.step);
        while let Some(time) = self.flow.next_meeting(self.time() + least) {
            let part = time - self.time();
            if part >= left - least {
                break;
            }
            info.add(&self.advance(part, HALVINGS)?);
            left -= part;
        }
        info.add(&self.advance(left, HALVINGS)?);
        Ok(info)
    }

    /// Takes `steps` time steps.
    ///
    /// # Errors
    /// Those of [`step`](Simulation::step).
    #[doc(alias = "integrate")]
    #[doc(alias = "advance")]
    pub fn run(&mut self, steps: usize) -> Result<(), FlowError> {
        (0..steps).try_for_each(|_| self.step().map(drop))
    }

    /// Runs until the time `end`, with steps whose error is at most `tolerance`. Where `end` is not after the present
    /// time nothing happens.
    ///
    /// ```text
    /// e = Δt/(Δt + Δt₀) (F − Δt F₀/Δt₀)     Δt²/2 ∂F/∂t, at most h + h′
    /// F = h′ − h − rain − inflow            what flowed in the step; F₀ and Δt₀ are of the step before
    /// error = (Σ M |e| + S) / W
    /// ```
    ///
    /// S says by how much the volume of rain and inflow may be off where they jump in the step: a bound for one jump,
    /// an estimate for several (a staircase looks like a straight line). W is the most water that
    /// there was so far in one step, with what came in it, and not less than what comes in a step of the first length.
    ///
    /// A step with an error above the tolerance is repeated with a shorter step size. The first step has the length
    /// given at the start, with S as its error, and no step is longer than `longest`. One that fails is divided by
    /// four until a step is made: down to 1/4096 of it, as by [`step`](Simulation::step), and of the first one. Errors
    /// of steps add up: the final error is about the number of steps times the tolerance. Returns the number of
    /// rejected steps.
    ///
    /// Rain and inflow are looked at at five instants of a step: beside its ends, within 10⁻⁹ of it or 8 roundings of
    /// the time, and at 11 %, 50 % and 89 % of it. **What begins and ends between two of them is missed**, in the
    /// budget too; on dry ground, where nothing else changes, steps get as long as allowed. Name such times by
    /// [`Flow::meet`], which makes jumps exact, or let `longest` be twice as long as the shortest shower, at most.
    ///
    /// ```
    /// use rattle_flow::dam_break;
    /// let mesh = dam_break::mesh(0.5)?;
    /// let depth = dam_break::depth(&mesh);
    /// let mut simulation = dam_break::flow(mesh).simulate(depth, 1e-3)?;
    /// simulation.run_until(10.0, 1e-3, 1.0)?;
    /// assert_eq!(simulation.time(), 10.0);
    /// assert!(simulation.budget().remainder().abs() < 1e-13);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`step`](Simulation::step); [`FlowError::TooExact`] where steps of 2⁻⁴⁰ of the first one are too long;
    /// and [`FlowError::Number`] for a tolerance below 10⁻¹², a longest step that is not positive, and an end that is
    /// not finite.
    #[doc(alias = "adaptive")]
    #[doc(alias = "tolerance")]
    pub fn run_until(&mut self, end: f64, tolerance: f64, longest: f64) -> Result<usize, FlowError> {
        number("the end of the run", end, true, "a time")?;
        number("the tolerance", tolerance, tolerance >= LEAST_TOLERANCE, "a number of at least 1e-12")?;
        if longest != f64::INFINITY {
            number("the longest step", longest, longest > 0.0, "a positive number")?;
        }
        let start = self.step.min(longest);
        let (mut next, mut thrown, mut failed) = (start, 0, 0);
        while self.time() < end {
            let goal = self.flow.next_meeting(self.time() + LEAST_PART * start);
            let goal = goal.map_or(end, |time| time.min(end));
            let left = goal - self.time();
            // The last two steps are of one length: no tiny one at the end.
            let step = if left <= next { left } else { next.min(0.5 * left.max(next)) };
            let first = self.earlier_step == 0.0;
            let outcome = self.attempt(step, true)?;
            let error = if outcome.is_ok() { self.error_of(step, start) } else { f64::INFINITY };
            let growth = (0.8 * (tolerance / error).sqrt()).clamp(0.25, 2.0);
            match outcome {
                Ok(info) if error <= tolerance => {
                    self.accept(step, &info);
                    failed = 0;
                    next = (step * if first { 1.0 } else { growth }).min(longest);
                    if left == step {
                        self.clock = Clock::at(goal);
                    }
                }
                Ok(_) => {
                    self.method.undo();
                    (next, thrown) = (step * growth, thrown + 1);
                    let time = self.time();
                    if next < self.step * SHORTEST || time + next == time {
                        return Err(FlowError::TooExact { time, step, error, tolerance });
                    }
                }
                Err(trouble) => {
                    (next, thrown, failed) = (step * growth, thrown + 1, failed + 1);
                    // Also of the first step: what has grown long is not given up before that was tried.
                    let is_short = step <= self.step * 0.25_f64.powi(QUARTERS as i32);
                    if failed > QUARTERS && is_short || next < self.step * SHORTEST {
                        return Err(self.error(step, trouble));
                    }
                }
            }
        }
        Ok(thrown)
    }

    /// The error of a step that leads to `guess`; see [`run_until`](Simulation::run_until). Of the first one there is
    /// no other to compare with.
    fn error_of(&self, step: f64, start: f64) -> f64 {
        let mut sum = step * self.sources.unsure;
        if self.earlier_step > 0.0 {
            let (part, ratio) = (step / (step + self.earlier_step), step / self.earlier_step);
            let shares = self.flow.mesh.shares();
            for (i, flowed) in self.flowed.iter().enumerate() {
                let now = shares[i] * (self.guess[i] - self.depth[i]) - step * self.sources.at(i);
                let water = shares[i] * (self.guess[i] + self.depth[i]);
                sum += (part * (now - ratio * flowed)).abs().min(water);
            }
        }
        let comes = self.sources.sum();
        let water = self.most.max(self.budget.now + step * comes).max(start * comes);
        let error = sum / water.max(f64::MIN_POSITIVE);
        if error.is_nan() { f64::INFINITY } else { error }
    }

    fn advance(&mut self, step: f64, halvings: u32) -> Result<StepInfo, FlowError> {
        match self.attempt(step, false)? {
            Ok(info) => {
                self.accept(step, &info);
                Ok(info)
            }
            Err(_) if halvings > 0 => {
                let mut info = self.advance(0.5 * step, halvings - 1)?;
                info.add(&self.advance(0.5 * step, halvings - 1)?);
                Ok(info)
            }
            Err(trouble) => Err(self.error(step, trouble)),
        }
    }

    /// Tries a step: what comes of it is in `guess`. How unsure its sources are is found where that is asked for.
    fn attempt(&mut self, step: f64, unsure: bool) -> Result<Result<StepInfo, Trouble>, FlowError> {
        self.sources.take(&self.flow, self.clock.time(), step, unsure)?;
        // Where the last step leads to if it goes on; not below zero.
        let ratio = if self.earlier_step > 0.0 { step / self.earlier_step } else { 0.0 };
        for ((guess, &now), &earlier) in self.guess.iter_mut().zip(&self.depth).zip(&self.earlier) {
            *guess = (now + ratio * (now - earlier)).max(0.0);
        }
        let sources = (&self.sources.rain[..], &self.sources.inflow[..]);
        Ok(self.method.step(&self.flow, &self.depth, &mut self.guess, step, sources))
    }

    fn accept(&mut self, step: f64, info: &StepInfo) {
        let shares = self.flow.mesh.shares();
        for (i, flowed) in self.flowed.iter_mut().enumerate() {
            *flowed = shares[i] * (self.guess[i] - self.depth[i]) - step * self.sources.at(i);
        }
        self.most = self.most.max(self.budget.now + info.booked.rain + info.booked.inflow);
        std::mem::swap(&mut self.earlier, &mut self.depth);
        std::mem::swap(&mut self.depth, &mut self.guess);
        self.earlier_step = step;
        self.clock.advance(step);
        self.budget.add(&info.booked);
        self.budget.now = self.flow.mesh.volume_of(&self.depth);
        self.iterations += info.iterations;
        self.steps += 1;
    }

    fn error(&self, step: f64, trouble: Trouble) -> FlowError {
        let time = self.time();
        match trouble {
            Trouble::NotConverged { iterations, change, vertex } => {
                let [x, y] = self.flow.mesh.points()[vertex];
                FlowError::NotConverged { time, step, iterations, change, vertex, x, y }
            }
            Trouble::Singular { vertex } => {
                let [x, y] = self.flow.mesh.points()[vertex];
                FlowError::Singular { time, step, vertex, x, y }
            }
        }
    }

    /// The flow.
    pub fn flow(&self) -> &Flow {
        &self.flow
    }
    /// h at the vertices.
    pub fn depth(&self) -> &[f64] {
        &self.depth
    }
    /// The time.
    pub fn time(&self) -> f64 {
        self.clock.time()
    }
    /// The volumes since the start.
    pub fn budget(&self) -> Budget {
        self.budget
    }
    /// The volume of the water.
    pub fn volume(&self) -> f64 {
        self.budget.now
    }
    /// The mean of |q| over the area, of [`flux`](Simulation::flux).
    pub fn mean_flux(&self) -> f64 {
        self.method.mean_flux(&self.flow, &self.depth)
    }
    /// q in each triangle, area per time. In water at rest that is zero but for rounding, of which q has the root, by
    /// the conservative method: edges along which nothing flows, as to dry ground above a lake, have no part in it.
    pub fn flux(&self) -> Vec<[f64; 2]> {
        self.method.flux(&self.flow, &self.depth)
    }
    /// The number of Newton iterations so far.
    pub fn iterations(&self) -> usize {
        self.iterations
    }
    /// The number of steps so far; parts of divided steps count one by one.
    pub fn steps(&self) -> usize {
        self.steps
    }
}
