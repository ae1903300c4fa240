//! The trait of methods: one implicit step in time.

use crate::budget::Budget;
use crate::error::FlowError;
use crate::flow::Flow;

/// The result of a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StepInfo {
    /// The number of Newton iterations.
    pub iterations: usize,
    /// The volumes of the step; `start` and `now` are 0.
    pub booked: Budget,
}

impl StepInfo {
    /// Adds those of the step that follows.
    pub(crate) fn add(&mut self, next: &StepInfo) {
        self.iterations += next.iterations;
        self.booked.add(&next.booked);
    }
}

/// Why a step failed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Trouble {
    /// The iteration did not converge.
    NotConverged {
        /// Iterations made.
        iterations: usize,
        /// The last change of depth.
        change: f64,
        /// Where it is largest.
        vertex: usize,
    },
    /// The solution of the linear equations is NaN.
    Singular {
        /// The first vertex where it is.
        vertex: usize,
    },
}

/// One step of the implicit Euler method.
///
/// ```text
/// (h′ − h)/Δt + ∇·q(h′) = rain − infiltration(h′)
/// ```
pub trait Method: Send {
    /// Checks, once before the first step, that the method supports all parts of the flow.
    ///
    /// # Errors
    /// [`FlowError::NotServed`].
    fn serves(&self, _flow: &Flow) -> Result<(), FlowError> {
        Ok(())
    }

    /// Computes the depth after a step from `depth`. `guess` holds a first guess of it, and then the result.
    /// `sources` are rain and inflow, volumes per time at the vertices, as means over the step. After an error
    /// `guess` is meaningless, and the method is in its state before the call.
    ///
    /// # Errors
    /// [`Trouble`], after which a shorter step may succeed.
    fn step(
        &mut self,
        flow: &Flow,
        depth: &[f64],
        guess: &mut [f64],
        step: f64,
        sources: (&[f64], &[f64]),
    ) -> Result<StepInfo, Trouble>;

    /// Undoes the last step.
    fn undo(&mut self);

    /// The mean of |q| over the area.
    fn mean_flux(&self, flow: &Flow, depth: &[f64]) -> f64;

    /// q in each triangle.
    fn flux(&self, flow: &Flow, depth: &[f64]) -> Vec<[f64; 2]>;
}
