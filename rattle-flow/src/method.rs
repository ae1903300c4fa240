//! The contract of a method: one implicit step in time.

use crate::budget::Budget;
use crate::error::FlowError;
use crate::flow::Flow;

/// How a step ended.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StepInfo {
    /// Newton's iterations.
    pub iterations: usize,
    /// What the step did to the volume; `start` and `now` are 0.
    pub booked: Budget,
}

/// Why a step was not made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Trouble {
    /// Depth still changes by this, at this vertex.
    NotConverged {
        /// Iterations made.
        iterations: usize,
        /// The last change of depth.
        change: f64,
        /// Where it is largest.
        vertex: usize,
    },
    /// The solution of the linear equations is not a number at this vertex.
    Singular {
        /// The first such vertex.
        vertex: usize,
    },
}

/// One step of the implicit Euler method.
///
/// ```text
/// (h′ − h)/Δt + ∇·q(h′) = rain − infiltration(h′)
/// ```
pub trait Method: Send {
    /// Whether the method has all that a flow has; asked once, before the first step.
    ///
    /// # Errors
    /// [`FlowError::NotServed`].
    fn serves(&self, _flow: &Flow) -> Result<(), FlowError> {
        Ok(())
    }

    /// Makes `guess`, at first a guess of it, the depth after a step from `depth`. `rain` and `inflow` are volumes per
    /// time at the vertices. After an error `guess` is meaningless and the method as it was before the call.
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

    /// Goes back to before the last step, which is not wanted.
    fn undo(&mut self);

    /// |q| averaged over the area.
    fn mean_flux(&self, flow: &Flow, depth: &[f64]) -> f64;

    /// q in each triangle.
    fn flux(&self, flow: &Flow, depth: &[f64]) -> Vec<[f64; 2]>;
}
