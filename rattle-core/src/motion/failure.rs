//! Why a step failed.

use crate::error::StepFailure;

/// Why a step failed, and for which body.
#[derive(Debug, Clone, PartialEq)]
pub struct Failure {
    /// Which body, counted from 0.
    pub body: usize,
    /// What stopped it.
    pub cause: StepFailure,
}
