//! Checkpoints in files: a run that is stopped, or killed, goes on bit for bit as if it had not been.
//!
//! ```
//! use rattle::prelude::*;
//! use rattle::checkpoint::Save;
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("run.rattle");
//! # let scene = Scene::point();
//! let begin = || scene.simulate(State::at([0.0]).moving([1.0]), Rattle::new(0.1));
//!
//! let mut simulation = begin()?;
//! simulation.run(1000)?;
//! simulation.save(&path)?;
//!
//! let mut again = begin()?; // by another program: the same scene, method and options; any start
//! again.restore(&path)?;
//! assert_eq!((again.steps(), again.state()), (1000, simulation.state()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! In long runs [`Saving`] does that every so many steps or seconds, and at the end:
//!
//! ```
//! # use rattle::prelude::*;
//! # use rattle::checkpoint::{Ended, Saving};
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("run.rattle");
//! # let scene = Scene::point();
//! let mut simulation = scene.simulate(State::at([0.0]).moving([1.0]), Rattle::new(0.1))?;
//! let saving = Saving::to(&path).every(10_000);
//! saving.restore(&mut simulation)?; // where the last run ended, if there was one
//! assert_eq!(saving.run_to(&mut simulation, 50_000)?, Ended::Done);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Killed and started again as often as may be, this ends with the same bits. See `examples/checkpoint.rs` for Ctrl-C.
//!
//! A file appears whole or not at all: it is written beside its place as `run.rattle.part`, synced and renamed, and
//! the folder synced. So a crash or a full disk leaves the last checkpoint as it was. One program writes a checkpoint at a
//! time.
//!
//! # The file
//!
//! ```text
//! 89 52 41 54 54 4c 45 0a    "\x89RATTLE\n"
//! version: u32               1
//! length of the fields: u64  in bytes
//! number of fields: u64
//! each field                 length of the name: u32, name (UTF-8), kind: u8, indices: u8, extent along each: u64, values
//!                            kind 0: f64, 1: u64, 2: bytes of UTF-8
//! CRC-32: u32                of all that stands before
//! ```
//!
//! Numbers are little-endian. Files of version 1 stay readable.

mod file;
mod saving;

pub use file::{decode, encode, read, write};
pub use rattle_core::motion::record::{Data, Field, Record};
pub use rattle_core::run::checkpoint::Checkpoint;
pub use saving::{Ended, Saving};

use crate::Error;
use std::io;
use std::path::{Path, PathBuf};

/// Simulations and ensembles to files and back.
pub trait Save: Checkpoint {
    /// Writes all that is needed to go on; an old file is replaced once the new one is whole.
    ///
    /// # Errors
    /// [`CheckpointError::Io`]; an old file, and what is saved, are as they were.
    fn save(&self, path: impl AsRef<Path>) -> Result<(), CheckpointError> {
        write(&self.checkpoint(), path)
    }

    /// Goes on from a file that was saved by the same scene and method, whatever the state was here.
    ///
    /// # Errors
    /// [`CheckpointError`] says what the file is instead; what was to go on is as it was.
    ///
    /// ```
    /// # use rattle::prelude::*;
    /// # use rattle::checkpoint::Save;
    /// # let folder = tempfile::tempdir()?;
    /// # let path = folder.path().join("run.rattle");
    /// let scene = |g: f64| Scene::point().with(rattle::potentials::planar::Gravity { g });
    /// let start = State::at([0.0, 1.0]);
    /// scene(9.81).simulate(start.clone(), Rattle::new(0.1))?.save(&path)?;
    /// let refused = scene(1.62).simulate(start, Rattle::new(0.1))?.restore(&path).unwrap_err();
    /// assert!(refused.to_string().contains("(effect 0): it was written by Gravity with -9.81, and here is Gravity with -1.62"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    fn restore(&mut self, path: impl AsRef<Path>) -> Result<(), CheckpointError> {
        let path = path.as_ref();
        let refused = |error| CheckpointError::Refused { path: path.into(), error };
        self.resume(&read(path)?).map_err(refused)
    }
}

impl<X: Checkpoint + ?Sized> Save for X {}

/// Why there is no going on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// The file can't be written or read.
    #[error("{}: {source}; the last checkpoint and the run are as they were", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The file is something else.
    #[error("{}: no checkpoint of rattle; one begins with \"\\x89RATTLE\\n\"", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
    },
    /// The file was written by a later version.
    #[error("{}: a checkpoint of version {version}, and versions up to 1 are known here; use a later rattle", path.display())]
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
        /// What shows it.
        what: &'static str,
    },
    /// The checkpoint is of another scene, method or ensemble.
    #[error("{}: {error}", path.display())]
    Refused {
        /// The file.
        path: PathBuf,
        /// Which part differs.
        error: Error,
    },
    /// A step could not be taken.
    #[error(transparent)]
    Step(Error),
}
