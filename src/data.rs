//! Results as NumPy archives: named arrays of `f64` in one `.npz` file.
//!
//! ```text
//! file.npz  =  zip { name.npy, … },   each array f64, little-endian, C order (last index fastest)
//! ```
//!
//! ```
//! use rattle::data::{Npz, read};
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("run.npz");
//! let q = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5]; // two steps of one particle in space
//! Npz::create(&path)?.array("t", &[2], &[0.0, 0.01])?.array("q", &[2, 3], &q)?.finish()?;
//!
//! let array = read(&path, "q")?;
//! assert_eq!((array.shape, array.data), (vec![2, 3], q.to_vec()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! In Python the same file is `numpy.load("run.npz")["q"]`.

mod npy;

use crate::{Trajectory, files};
use std::collections::HashSet;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

/// An archive being written. [`finish`](Npz::finish) completes the file.
#[doc(alias = "numpy")]
#[doc(alias = "save")]
#[doc(alias = "dump")]
#[derive(Debug)]
#[must_use = "the file is complete only after `finish`"]
pub struct Npz {
    path: PathBuf,
    zip: ZipWriter<BufWriter<FailsOnce>>,
    names: HashSet<String>,
}

impl Npz {
    /// Creates the file, and its folder where that is missing. An old file of this name is replaced.
    ///
    /// # Errors
    /// [`DataError::Io`] when the file can't be made.
    ///
    /// ```
    /// # let folder = tempfile::tempdir()?;
    /// let npz = rattle::data::Npz::create(folder.path().join("out/run.npz"))?;
    /// npz.array("lambda", &[3], &[1.0, 2.0, 3.0])?.finish()?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn create(path: impl AsRef<Path>) -> Result<Self, DataError> {
        let path = path.as_ref().to_path_buf();
        let file = files::create(&path).map_err(|source| DataError::Io { path: path.clone(), source })?;
        Ok(Self {
            path,
            zip: ZipWriter::new(BufWriter::new(FailsOnce { file, failed: false })),
            names: HashSet::new(),
        })
    }

    /// Adds an array; in `data` the last index runs fastest.
    ///
    /// # Errors
    /// [`DataError::Shape`] when the number of values is not the product of the extents in `shape`,
    /// [`DataError::Repeated`] when the archive has an array of that name, [`DataError::Io`].
    ///
    /// ```
    /// # let folder = tempfile::tempdir()?;
    /// let npz = rattle::data::Npz::create(folder.path().join("run.npz"))?;
    /// let message = npz.array("q", &[2, 3], &[0.0; 5]).unwrap_err().to_string();
    /// assert!(message.contains("array `q`: shape [2, 3] holds 6 values, but 5 were given"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn array(mut self, name: &str, shape: &[usize], data: &[f64]) -> Result<Self, DataError> {
        if product(shape) != Some(data.len()) {
            return Err(DataError::Shape {
                path: self.path,
                name: name.into(),
                shape: shape.into(),
                length: data.len(),
            });
        }
        if !self.names.insert(name.into()) {
            return Err(DataError::Repeated { path: self.path, name: name.into() });
        }
        match self.append(name, shape, data) {
            Ok(()) => Ok(self),
            Err(source) => Err(DataError::Io { path: self.path, source }),
        }
    }

    /// Adds a trajectory: `t` of shape \[rows\], `q` and `p` of shape \[rows, bodies, D\], and if it has multipliers
    /// `lambda` and `mu` of shape \[rows, equations\].
    ///
    /// # Errors
    /// As [`array`](Npz::array).
    ///
    /// ```
    /// # use rattle::prelude::*;
    /// # let folder = tempfile::tempdir()?;
    /// # let path = folder.path().join("run.npz");
    /// # let start = State::of([[0.0, 1.0], [0.0, 2.0]]).moving([1.0, 0.0]);
    /// let mut simulation = Scene::points(2).simulate(start, Rattle::new(0.1))?;
    /// let mut trajectory = Trajectory::of(&simulation);
    /// simulation.observe(100, 10, &mut trajectory)?;
    /// rattle::data::Npz::create(&path)?.trajectory(&trajectory)?.finish()?;
    /// assert_eq!(rattle::data::read(&path, "q")?.shape, [11, 2, 2]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn trajectory(self, trajectory: &Trajectory) -> Result<Self, DataError> {
        let shape @ [rows, ..] = trajectory.shape();
        let npz = self
            .array("t", &[rows], trajectory.times())?
            .array("q", &shape, trajectory.positions())?
            .array("p", &shape, trajectory.momenta())?;
        let Some(multipliers) = trajectory.multipliers() else { return Ok(npz) };
        let shape = [rows, trajectory.equations()];
        npz.array("lambda", &shape, &multipliers.position)?.array("mu", &shape, &multipliers.momentum)
    }

    /// Writes the archive's directory and closes the file.
    ///
    /// # Errors
    /// [`DataError::Io`], for example for a full disk.
    ///
    /// ```
    /// # let folder = tempfile::tempdir()?;
    /// # let path = folder.path().join("run.npz");
    /// rattle::data::Npz::create(&path)?.array("t", &[1], &[0.0])?.finish()?;
    /// assert!(path.exists());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn finish(self) -> Result<(), DataError> {
        let written = self.zip.finish().map_err(io::Error::from).and_then(|mut file| file.flush());
        written.map_err(|source| DataError::Io { path: self.path, source })
    }

    fn append(&mut self, name: &str, shape: &[usize], data: &[f64]) -> io::Result<()> {
        // Beyond 4 GiB, header included, zip needs its 64-bit form.
        let large = data.len() >= (u32::MAX - 2 * npy::LONGEST_TEXT) as usize / 8;
        let options =
            SimpleFileOptions::default().compression_method(CompressionMethod::Stored).large_file(large);
        self.zip.start_file(format!("{name}.npy"), options)?;
        npy::write(&mut self.zip, shape, data)
    }
}

/// A file that fails once, and then says no more: a `ZipWriter` that is dropped after its error has been handed on
/// would try again and print to stderr.
#[derive(Debug)]
struct FailsOnce {
    file: File,
    failed: bool,
}

impl FailsOnce {
    fn once<T>(&mut self, instead: T, act: impl FnOnce(&mut File) -> io::Result<T>) -> io::Result<T> {
        if self.failed {
            return Ok(instead);
        }
        act(&mut self.file).inspect_err(|error| self.failed = error.kind() != io::ErrorKind::Interrupted)
    }
}

impl Write for FailsOnce {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.once(bytes.len(), |file| file.write(bytes))
    }
    fn flush(&mut self) -> io::Result<()> {
        self.once((), File::flush)
    }
}

impl Seek for FailsOnce {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.once(0, |file| file.seek(to))
    }
}

/// An array read from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Extent along each index.
    pub shape: Vec<usize>,
    /// The values, last index fastest.
    pub data: Vec<f64>,
}

/// Reads one array of `f64` from a `.npz` file, written here or by NumPy (uncompressed, by `numpy.savez`).
///
/// # Errors
/// [`DataError::Missing`] when the archive has no such array, [`DataError::Layout`] for another type than `f64` or for
/// Fortran order, [`DataError::Io`] for a file that cannot be read: damaged, compressed, or with more or fewer values
/// than its header says. Memory is allocated for the values found, not for those that a header claims.
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("run.npz");
/// # rattle::data::Npz::create(&path)?.array("t", &[2], &[0.0, 0.5])?.finish()?;
/// assert_eq!(rattle::data::read(&path, "t")?.data, [0.0, 0.5]);
/// assert!(rattle::data::read(&path, "x").is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(alias = "load")]
pub fn read(path: impl AsRef<Path>, name: &str) -> Result<Array, DataError> {
    let path = path.as_ref();
    let failed = |source| DataError::Io { path: path.into(), source };
    let file = File::open(path).map_err(failed)?;
    let mut archive = ZipArchive::new(BufReader::new(file)).map_err(|error| failed(error.into()))?;
    let member = archive.by_name(&format!("{name}.npy")).map_err(|error| match error {
        zip::result::ZipError::FileNotFound => DataError::Missing { path: path.into(), name: name.into() },
        other => failed(other.into()),
    })?;
    let of_array =
        |error: io::Error| failed(io::Error::new(error.kind(), format!("array `{name}`: {error}")));
    let read = npy::read(member).map_err(of_array)?;
    let (shape, data) = read.ok_or_else(|| DataError::Layout { path: path.into(), name: name.into() })?;
    Ok(Array { shape, data })
}

/// What can go wrong with an archive.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum DataError {
    /// The file can't be made, written or read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The error of the file system.
        source: io::Error,
    },
    /// The shape does not hold as many values as were given.
    #[error("{}: array `{name}`: shape {shape:?} holds {} values, but {length} were given", path.display(), size(shape))]
    Shape {
        /// The file.
        path: PathBuf,
        /// The array.
        name: String,
        /// The shape asked for.
        shape: Vec<usize>,
        /// How many values were given.
        length: usize,
    },
    /// The archive already has an array of that name.
    #[error("{}: array `{name}` is written twice", path.display())]
    Repeated {
        /// The file.
        path: PathBuf,
        /// The array.
        name: String,
    },
    /// The archive has no array of that name.
    #[error("{}: no array `{name}`", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
        /// The array.
        name: String,
    },
    /// The array is not `f64` in C order.
    #[error("{}: array `{name}` is not f64 in C order, try `numpy.ascontiguousarray(a, dtype=float)`", path.display())]
    Layout {
        /// The file.
        path: PathBuf,
        /// The array.
        name: String,
    },
}

debug_as_display!(DataError);

fn product(shape: &[usize]) -> Option<usize> {
    shape.iter().try_fold(1, |size: usize, &n| size.checked_mul(n))
}

fn size(shape: &[usize]) -> String {
    product(shape).map_or_else(|| "too many".into(), |size| size.to_string())
}
