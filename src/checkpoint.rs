//! Checkpoints in files: a run that was stopped or killed goes on from its last checkpoint, bit for bit as if it had
//! never stopped.
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
//! In long runs [`Saving`] writes checkpoints every so many steps or seconds, and at the end:
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
//! However often this program is killed and started again, it ends with the same bits. See `examples/checkpoint.rs` for
//! Ctrl-C.
//!
//! A file appears whole or not at all: it is written as `run.rattle.part` in the same folder, synced to disk and
//! renamed. So a crash or a full disk leaves the last checkpoint as it was. Only one program at a time may write a
//! checkpoint.
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
//!
//! All that writes and reads files is in the feature `checkpoint`. Without it there are the [`Record`]s that
//! [`Simulation::checkpoint`](crate::Simulation::checkpoint) makes, for programs that keep them in a form of their own.

#[cfg(feature = "checkpoint")]
mod error;
#[cfg(feature = "checkpoint")]
mod file;
#[cfg(feature = "checkpoint")]
mod save;
#[cfg(feature = "checkpoint")]
mod saving;

#[cfg(feature = "checkpoint")]
pub use error::CheckpointError;
#[cfg(feature = "checkpoint")]
pub use file::{decode, encode, read, write};
pub use rattle_core::motion::record::{Data, Field, Reading, Record};
pub use rattle_core::run::checkpoint::Checkpoint;
#[cfg(feature = "checkpoint")]
pub use save::Save;
#[cfg(feature = "checkpoint")]
pub use saving::{Ended, Saving};
