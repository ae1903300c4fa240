//! A flow in time.

use crate::budget::Budget;
use crate::error::FlowError;
use crate::flow::Flow;
use crate::method::{Method, StepInfo, Trouble};

/// So often a step that failed is halved.
const HALVINGS: u32 = 12;

/// A flow, where it stands, and the books.
///
/// A step that fails is made in two halves, these in halves again, up to a 4096th; if that fails, the state is the last
/// good one, and the error says where and when.
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
        if !(step.is_finite() && step > 0.0) {
            return Err(FlowError::TimeStep { found: step });
        }
        let volume = flow.mesh.volume(&depth);
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

    /// Goes on by one time step.
    ///
    /// # Errors
    /// [`FlowError::NotConverged`], [`FlowError::Singular`], and [`FlowError::Given`] for rain and inflow; the state is
    /// then that of the last part of the step that succeeded.
    pub fn step(&mut self) -> Result<StepInfo, FlowError> {
        let step = self.step;
        self.advance(step, HALVINGS)
    }

    /// Goes on by so many steps.
    ///
    /// # Errors
    /// Those of [`step`](Simulation::step).
    pub fn run(&mut self, steps: usize) -> Result<(), FlowError> {
        (0..steps).try_for_each(|_| self.step().map(drop))
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
        self.budget.now = self.flow.mesh.volume(&self.depth);
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
    /// All of Newton's iterations so far.
    pub fn iterations(&self) -> usize {
        self.iterations
    }
    /// All steps so far, halves counted one by one.
    pub fn steps(&self) -> usize {
        self.steps
    }
}
