//! Why a step cannot be taken in one piece.

use crate::error::Error;
use crate::motion::failure::Failure;

/// Why a step cannot be taken in one piece.
pub(in crate::run) enum Trouble {
    Refused(Error),
    Failed(Failure),
    NotReversed { body: usize, off: f64, tolerance: f64 },
}

impl Trouble {
    /// The error that tells of it, of a step that was halved so often.
    pub(in crate::run) fn told(self, step: u64, time: f64, halvings: u32) -> Error {
        match (self, halvings) {
            (Self::Refused(error), _) => error,
            (Self::Failed(Failure { body, cause }), 0) => Error::Step { step, time, body, cause },
            (Self::Failed(Failure { body, cause }), _) => {
                Error::Retried { step, time, body, halvings, cause }
            }
            (Self::NotReversed { body, off, tolerance }, _) => {
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
        Self::Failed(failure)
    }
}
