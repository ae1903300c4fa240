//! Simulations of a flow in time.

use crate::budget::Budget;
use crate::error::FlowError;
use crate::flow::{Flow, number};
use crate::method::{Method, StepInfo, Trouble};

/// So often a step that failed is halved.
const HALVINGS: u32 = 12;

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
    guess: Vec<f64>,
    rain: Vec<f64>,
    inflow: Vec<f64>,
    time: f64,
    step: f64,
    budget: Budget,
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
            guess: depth.clone(),
            depth,
            rain: vec![0.0; n],
            inflow: vec![0.0; n],
            time: 0.0,
            step,
            budget: Budget { start: volume, now: volume, ..Budget::default() },
            iterations: 0,
            steps: 0,
        })
    }

    /// Takes one time step.
    ///
    /// # Errors
    /// [`FlowError::NotConverged`], [`FlowError::Singular`], and [`FlowError::Given`] for rain and inflow; the state is
    /// then that of the last part of the step that succeeded.
    #[doc(alias = "integrate")]
    #[doc(alias = "advance")]
    pub fn step(&mut self) -> Result<StepInfo, FlowError> {
        let step = self.step;
        self.advance(step, HALVINGS)
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

    /// Runs until the time `end`, with steps whose error is at most `tolerance`, relative to the present volume.
    ///
    /// ```text
    /// e = Δt/(Δt + Δt₀) (h′ − h − Δt (h − h₀)/Δt₀)         Δt²/2 ∂²h/∂t², with h₀ and Δt₀ of the step before
    /// ```
    ///
    /// A step with Σ M |e| above the tolerance is repeated with a shorter step size. The first step has the length
    /// given at the start, and no step is longer than `longest`. Errors of steps add up: the final error is about the
    /// number of steps times the tolerance. Returns the number of rejected steps.
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
    /// Those of [`step`](Simulation::step), and [`FlowError::Number`] for a tolerance or a longest step that is not
    /// positive, and an end that is not finite.
    #[doc(alias = "adaptive")]
    #[doc(alias = "tolerance")]
    pub fn run_until(&mut self, end: f64, tolerance: f64, longest: f64) -> Result<usize, FlowError> {
        number("the end of the run", end, true, "a time")?;
        number("the tolerance", tolerance, tolerance > 0.0, "a positive number")?;
        if longest != f64::INFINITY {
            number("the longest step", longest, longest > 0.0, "a positive number")?;
        }
        let mut next = self.step.min(longest);
        let mut thrown = 0;
        while self.time < end {
            let left = end - self.time;
            // The last two steps are of one length: no tiny one at the end.
            let step = if left <= next { left } else { next.min(0.5 * left.max(next)) };
            let first = self.earlier_step == 0.0;
            let outcome = self.attempt(step)?;
            let error = match outcome {
                Ok(_) if first => 0.0,
                Ok(_) => self.error_of(step),
                Err(_) => f64::INFINITY,
            };
            let growth = (0.8 * (tolerance / error).sqrt()).clamp(0.25, 2.0);
            match outcome {
                Ok(info) if error <= tolerance => {
                    self.accept(step, &info);
                    next = (step * if first { 1.0 } else { growth }).min(longest);
                    if left == step {
                        self.time = end;
                    }
                }
                Err(trouble) if step <= self.step * 0.5_f64.powi(HALVINGS as i32) => {
                    return Err(self.error(step, trouble));
                }
                Ok(_) => {
                    self.method.undo();
                    (next, thrown) = (step * growth, thrown + 1);
                }
                Err(_) => (next, thrown) = (step * growth, thrown + 1),
            }
        }
        Ok(thrown)
    }

    /// Σ M |e| over the volume, of a step that leads to `guess`; see [`run_until`](Simulation::run_until).
    fn error_of(&self, step: f64) -> f64 {
        let (part, ratio) = (step / (step + self.earlier_step), step / self.earlier_step);
        let depths = self.guess.iter().zip(&self.depth).zip(&self.earlier).zip(self.flow.mesh.shares());
        let (mut sum, mut volume) = (0.0, f64::MIN_POSITIVE);
        for (((new, now), earlier), share) in depths {
            sum += share * part * (new - now - ratio * (now - earlier)).abs();
            volume += share * new;
        }
        sum / volume
    }

    fn advance(&mut self, step: f64, halvings: u32) -> Result<StepInfo, FlowError> {
        match self.attempt(step)? {
            Ok(info) => {
                self.accept(step, &info);
                Ok(info)
            }
            Err(_) if halvings > 0 => {
                let first = self.advance(0.5 * step, halvings - 1)?;
                let mut info = self.advance(0.5 * step, halvings - 1)?;
                info.iterations += first.iterations;
                info.booked.add(&first.booked);
                Ok(info)
            }
            Err(trouble) => Err(self.error(step, trouble)),
        }
    }

    /// Tries a step: what comes of it is in `guess`.
    fn attempt(&mut self, step: f64) -> Result<Result<StepInfo, Trouble>, FlowError> {
        self.flow.sources(self.time + step, &mut self.rain, &mut self.inflow)?;
        // Where the last step leads to if it goes on; not below zero.
        let ratio = if self.earlier_step > 0.0 { step / self.earlier_step } else { 0.0 };
        for ((guess, &now), &earlier) in self.guess.iter_mut().zip(&self.depth).zip(&self.earlier) {
            *guess = (now + ratio * (now - earlier)).max(0.0);
        }
        Ok(self.method.step(&self.flow, &self.depth, &mut self.guess, step, (&self.rain, &self.inflow)))
    }

    fn accept(&mut self, step: f64, info: &StepInfo) {
        std::mem::swap(&mut self.earlier, &mut self.depth);
        std::mem::swap(&mut self.depth, &mut self.guess);
        self.earlier_step = step;
        self.time += step;
        self.budget.add(&info.booked);
        self.budget.now = self.flow.mesh.volume_of(&self.depth);
        self.iterations += info.iterations;
        self.steps += 1;
    }

    fn error(&self, step: f64, trouble: Trouble) -> FlowError {
        let time = self.time;
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
        self.time
    }
    /// The volumes since the start.
    pub fn budget(&self) -> Budget {
        self.budget
    }
    /// The volume of the water.
    pub fn volume(&self) -> f64 {
        self.budget.now
    }
    /// The mean of |q| over the area.
    pub fn mean_flux(&self) -> f64 {
        self.method.mean_flux(&self.flow, &self.depth)
    }
    /// q in each triangle.
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
