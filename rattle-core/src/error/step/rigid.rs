//! Errors of steps: why a rigid body could not be turned.

use crate::error::numbers::{Digits, Passing};

/// Why a rigid body could not be turned.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RigidFailure {
    /// A rigid body turns so far within the step that no rotation fits.
    #[error(
        "the body turns too far within the step: h·|Ω| = {}; below 1 there always is a rotation, above in some \
         directions; {passing} (h = {h:.3e})", Digits(*turn, 3)
    )]
    TurnsTooFar {
        /// h·|Ω|.
        turn: f64,
        /// The step size: in a composition, that of the stage.
        h: f64,
        /// A step size that would work.
        passing: Passing,
    },
}
