//! Recording into files: a thread of its own writes rows as they come, so memory does not grow with the length of the
//! run. (An archive of NumPy keeps some 300 bytes for each column of each 8 MiB of rows, until it ends.)
//!
//! ```
//! use rattle::prelude::*;
//! use rattle::record::{NpzParts, Stream};
//! use rattle::watch::{Columns, Recorder};
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("run.npz");
//! # let start = State::of([[0.0, 1.0], [0.0, 2.0]]).moving([1.0, 0.0]);
//! let mut simulation = Scene::points(2).simulate(start, Rattle::new(0.1))?;
//! let stream = Stream::to(NpzParts::create(&path)?);
//! let columns = Columns::new().positions().energies();
//! let mut recorder = Recorder::of(&columns, stream.sink());
//! simulation.observe(10_000, 10, &mut recorder)?;
//! recorder.finish()?;
//! assert_eq!(stream.finish()?, 1000);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The same for an ensemble: `ensemble.observe(steps, every, || Recorder::of(&columns, stream.sink())).finish()?`.
//! Blocks of rows then come in any order; each row has its step and trajectory.
//!
//! | writer | file | read by |
//! |---|---|---|
//! | [`NpzParts`] | `.npz`, each column in parts `q.000000`, `q.000001`, … | NumPy: `np.concatenate([f[k] for k in sorted(f) if k.rpartition(".")[0] == "q"])` |
//! | [`Csv`] | `.csv`, a line for each row and a column for each number | `pandas.read_csv(path, float_precision="round_trip")`, `np.loadtxt(path, delimiter=",", skiprows=1)`, spreadsheets |
//! | [`Xyz`] | extended XYZ, a frame for each row | OVITO, ASE |
//! | [`Vtu`] | `.vtu`, a file for each row, and `.pvd` with their times; the surface beside them | ParaView |
//! | `Parquet` (feature `parquet`) | `.parquet`, a column for each number | pandas, Polars, DuckDB |
//!
//! Where a writer fails (a full disk, a closed pipe), the run ends at the next block of rows with
//! [`Error::Recorder`](crate::Error::Recorder), in its state after the last step, and [`Stream::finish`] says how many
//! rows the writer had taken. An ensemble ends too, with all trajectories after the same step.
//!
//! A run that continues from a checkpoint records into files of its own: `create` empties a
//! file that is there, whose rows may go on beyond the checkpoint.

mod csv;
#[cfg(feature = "parquet")]
mod parquet;
mod stream;
mod vtu;

pub use csv::Csv;
#[cfg(feature = "parquet")]
pub use parquet::Parquet;
pub use stream::{Handed, NpzParts, Stream, StreamError, Writer, Xyz};
pub use vtu::Vtu;
