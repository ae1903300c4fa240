//! Errors of steps: why a body could not be moved on its surface.

use crate::error::numbers::{Digits, History};

/// Why a body could not be moved on its surface.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceFailure {
    /// h·κ·|v| > 1: the surface curves away within one step, so the position equation has no solution that continues
    /// the motion.
    #[error(
        "step too long for the curvature: h·κ·|v| = {} must be below 1 (h = {h:.3e}, κ = {}, \
         |v| = {}); that needs |h| < {longest:.3e} here, and accurate runs stay below a fifth of it",
        Digits(*reach, 3), Digits(*curvature, 4), Digits(*speed, 4)
    )]
    StepTooLong {
        /// The step size: in a composition, that of the stage.
        h: f64,
        /// h·κ·|v|.
        reach: f64,
        /// Normal curvature κ along v.
        curvature: f64,
        /// |v|.
        speed: f64,
        /// 1/(κ·|v|), an upper limit of |h|; the curvature on the way may require less. Where v is noise that grows as
        /// 1/√h, in Brownian motion, 1/(h κ² v²).
        longest: f64,
    },
    /// h·κ·|v| is below 1, but numbers in its computation overflow or underflow.
    #[error(
        "products of curvature and speed are beyond the numbers: κ = {curvature:.1e}, |v| = {speed:.1e}, h·κ·|v| = {}; \
         choose units in which lengths and speeds are nearer to 1", Digits(*reach, 3)
    )]
    OutOfScale {
        /// h·κ·|v|.
        reach: f64,
        /// Normal curvature κ along v.
        curvature: f64,
        /// |v|.
        speed: f64,
    },
    /// The position equation was not solved to rounding.
    #[error(
        "projection onto the surface did not converge on a path of {path:.1e}: corrections {corrections}, floor \
         {floor:.1e}, |∇g| = {gradient:.3e}, h·κ·|v| = {}; try a smaller step", Digits(*reach, 3)
    )]
    NoConvergence {
        /// How far the body would have moved without the constraint. It is large where a force is too strong for the
        /// step.
        path: f64,
        /// The lengths of the corrections, in order.
        corrections: History,
        /// Corrections shorter than this count as converged.
        floor: f64,
        /// |∇g| at the start of the step.
        gradient: f64,
        /// h·κ·|v|.
        reach: f64,
    },
    /// The position equation has a solution, but maybe not the one that continues the motion: followed from h = 0, the
    /// root ends or turns too sharply.
    #[error(
        "the motion cannot be followed through this step: the solution found would move {correction:.3e} along the \
         normal on a path of {path:.3e}, normals at cosine {cosine:.3}, h·κ·|v| = {}; try a smaller step", Digits(*reach, 3)
    )]
    RootLost {
        /// Cosine of the angle between ∇g before and after.
        cosine: f64,
        /// How far the constraint would have moved the body.
        correction: f64,
        /// How far the body would have moved without the constraint.
        path: f64,
        /// h·κ·|v|.
        reach: f64,
    },
    /// A step has so much more, or less, of its way along the surface where it ends than where it began that its speed
    /// would jump: an edge lies between, sharp or round.
    #[error(
        "a step h = {h:.3e} would take the speed times {factor:.2} without a force: the surface turns by {angle:.0}° on its way; \
         try a smaller step"
    )]
    SpeedJump {
        /// The step size.
        h: f64,
        /// The speed after the step over that before it, as far as the surface decides it.
        factor: f64,
        /// The angle between the normals, in degrees.
        angle: f64,
    },
    /// Normals of successive stages turn by more than 60°: the step jumps over a bend.
    #[error(
        "the surface turns by more than 60° between two of the {stages} stages of a step h = {h:.3e}; try a smaller step"
    )]
    StagesTurnOver {
        /// The step size.
        h: f64,
        /// The number of stages.
        stages: usize,
    },
}
