//! Why a run cannot be saved or restored.

use crate::Error;
use std::io;
use std::path::PathBuf;

/// Of the files that are written; earlier ones are read.
pub(super) const VERSION: u32 = 1;

/// Why a run cannot be saved or restored.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// The file can't be written or read.
    #[error("{}: {source}; no checkpoint was changed", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The error of the file system.
        source: io::Error,
    },
    /// The file is not a checkpoint.
    #[error("{}: no checkpoint of rattle; one begins with \"\\x89RATTLE\\n\"", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
    },
    /// The file was written by a later version.
    #[error("{}: a checkpoint of version {version}, and versions up to {VERSION} are known here; use a later rattle", path.display())]
    Version {
        /// The file.
        path: PathBuf,
        /// Its version.
        version: u32,
    },
    /// The end of the file is missing.
    #[error("{}: cut off: {has} bytes are there of {of}; take an earlier checkpoint", path.display())]
    Truncated {
        /// The file.
        path: PathBuf,
        /// How many bytes there are.
        has: u64,
        /// How many there should be.
        of: u64,
    },
    /// Bytes of the file have changed.
    #[error("{}: damaged: {what}; take an earlier checkpoint", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Which check failed.
        what: &'static str,
    },
    /// The checkpoint is of another scene, method or ensemble.
    #[error("{}: {error}", path.display())]
    Refused {
        /// The file.
        path: PathBuf,
        /// Which part differs.
        error: Box<Error>,
    },
    /// A step could not be taken.
    #[error(transparent)]
    Step(Box<Error>),
}

debug_as_display!(CheckpointError);
