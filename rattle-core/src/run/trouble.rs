//! Why a step cannot be taken in one piece.

use crate::error::Error;
use crate::motion::failure::Failure;

/// Why a step cannot be taken in one piece.
pub(in crate::run) enum Trouble {
    Refused(Error),
    /// This stopped it, after it was halved so often.
    Failed {
        failure: Failure,
        halvings: u32,
    },
    NotReversed {
        body: usize,
        off: f64,
        tolerance: f64,
    },
}

impl Trouble {
    /// The same of what was halved so often.
    pub(in crate::run) fn halved(mut self, times: u32) -> Self {
        if let Self::Failed { halvings, .. } = &mut self {
            *halvings = times;
        }
        self
    }

    /// The error that tells of it.
    pub(in crate::run) fn told(self, step: u64, time: f64) -> Error {
        match self {
            Self::Refused(error) => error,
            Self::Failed { failure: Failure { body, cause }, halvings: 0 } => {
                Error::Step { step, time, body, cause }
            }
            Self::Failed { failure: Failure { body, cause }, halvings } => {
                Error::Retried { step, time, body, halvings, cause }
            }
            Self::NotReversed { body, off, tolerance } => {
                Error::NotReversed { step, time, body, off, tolerance }
            }
        }
    }
}

impl From<Error> for Trouble {
    fn from(error: Error) -> Self {
        Self::Refused(error)
    }
}

impl From<Failure> for Trouble {
    fn from(failure: Failure) -> Self {
        Self::Failed { failure, halvings: 0 }
    }
}
