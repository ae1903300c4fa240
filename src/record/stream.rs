//! A thread that writes rows, and the formats of its files.

use crate::data::{DataError, Npz};
use crate::files;
use crate::watch::{Column, Rows, Sink};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::Path;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{JoinHandle, spawn};

/// So many blocks may wait for the thread that writes; then the run waits.
const WAITING: usize = 16;

/// Formats that write parts gather rows of so many numbers for each: 8 MiB.
pub(super) const NUMBERS: usize = 1 << 20;

/// A file format: writes blocks of rows.
pub trait Writer: Send + 'static {
    /// Writes a block. One without rows has the columns of a run in which none was recorded.
    ///
    /// # Errors
    /// Those of the file system; after an error nothing more is written.
    fn write(&mut self, rows: &Rows) -> io::Result<()>;
    /// Passes what was written to the system.
    ///
    /// # Errors
    /// What the system says.
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
    /// Completes the file.
    ///
    /// # Errors
    /// What the system says.
    fn finish(self) -> io::Result<()>;
}

/// A file could not be written to its end.
#[derive(thiserror::Error)]
#[error("the writer had taken {rows} rows, then: {source}")]
pub struct StreamError {
    /// Rows that the writer had taken before. The last of them may not have come as far as the file.
    pub rows: u64,
    /// What the system says.
    pub source: io::Error,
}

debug_as_display!(StreamError);

/// What a thread is told.
enum Told {
    Rows(Rows),
    /// To be answered when everything before is written.
    Flush(SyncSender<()>),
    End,
}

/// A thread that writes.
#[derive(Debug)]
#[must_use = "the file is complete only after `finish`"]
pub struct Stream {
    sender: SyncSender<Told>,
    why: Arc<Mutex<String>>,
    /// One more for each recorder that is not finished.
    unfinished: Arc<()>,
    thread: JoinHandle<Result<u64, StreamError>>,
}

impl Stream {
    /// Starts a thread for this writer.
    pub fn to(writer: impl Writer) -> Self {
        let (sender, receiver) = sync_channel(WAITING);
        let why = Arc::new(Mutex::new(String::new()));
        let told = why.clone();
        let thread = spawn(move || {
            let mut taken = 0;
            let ended = catch_unwind(AssertUnwindSafe(|| write_all(writer, &receiver, &mut taken)));
            let ended = ended.unwrap_or_else(|_| Err(io::Error::other("the writer panicked")));
            let ended = ended.map_err(|source| StreamError { rows: taken, source }).map(|()| taken);
            if let Err(error) = &ended {
                *told.lock().unwrap_or_else(PoisonError::into_inner) = error.to_string();
            }
            ended // the receiver goes after that: who cannot send finds the reason
        });
        Self { sender, why, unfinished: Arc::new(()), thread }
    }

    /// A sink for a recorder, which passes its rows to this thread.
    #[must_use]
    pub fn sink(&self) -> Handed {
        Handed {
            sender: self.sender.clone(),
            why: self.why.clone(),
            unfinished: Some(self.unfinished.clone()),
        }
    }

    /// Waits until all rows are written, completes the file, and returns the number of rows. Finish the recorders
    /// first.
    ///
    /// # Errors
    /// [`StreamError`], with the number of rows that the writer had taken; also where a recorder is not finished, whose
    /// last rows then are missing in a file that is complete otherwise.
    pub fn finish(self) -> Result<u64, StreamError> {
        let _ = self.sender.send(Told::End); // a thread that has ended needs no telling
        let rows = self.thread.join().unwrap_or_else(|panic| resume_unwind(panic))?; // those of writers are caught
        if Arc::strong_count(&self.unfinished) > 1 {
            let source = wrong("a recorder still has rows: finish recorders first, then the stream");
            return Err(StreamError { rows, source });
        }
        Ok(rows)
    }
}

pub(super) fn wrong(what: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, what)
}

/// Whether a column has a vector for each body, as positions do. A quantity may be called as one that has.
pub(super) fn is_as_positions(rows: &Rows, name: &str) -> bool {
    let shape = |name| rows.column(name).map(|column| &column.shape);
    shape(name).is_some_and(|of_name| Some(of_name) == shape("q"))
}

/// Numbers in a row.
pub(super) fn width(columns: &[Column]) -> usize {
    columns.last().map_or(0, |last| last.place.end)
}

/// The names of a table with a column for each number; for an entry of an array its place after that of the array.
pub(super) fn names(columns: &[Column]) -> Result<Vec<String>, String> {
    let mut names = ["step", "trajectory", "t"].map(String::from).to_vec();
    for Column { name, shape, place } in columns {
        for number in 0..place.len() {
            let (mut index, mut left) = (String::new(), number);
            for &size in shape.iter().rev() {
                index = format!("_{}{index}", left % size);
                left /= size;
            }
            names.push(format!("{name}{index}"));
        }
    }
    let mut sorted: Vec<&String> = names.iter().collect();
    sorted.sort_unstable();
    match sorted.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(twice) => Err(format!("two columns would be called `{}`; rename the quantity", twice[0])),
        None => Ok(names),
    }
}

/// Adds rows to those that wait, which have the same columns.
pub(super) fn append(rows: &Rows, waiting: &mut Rows) {
    waiting.steps.extend(&rows.steps);
    waiting.trajectories.extend(&rows.trajectories);
    waiting.times.extend(&rows.times);
    waiting.numbers.extend(&rows.numbers);
}

/// The rows that wait; their columns stay.
pub(super) fn taken(waiting: &mut Rows) -> Rows {
    let columns = waiting.columns.clone();
    std::mem::replace(waiting, Rows { columns, ..Rows::default() })
}

/// Does what it is told, and counts the rows that the writer has taken.
fn write_all(mut writer: impl Writer, receiver: &Receiver<Told>, taken: &mut u64) -> io::Result<()> {
    loop {
        match receiver.recv() {
            Ok(Told::Rows(rows)) => {
                writer.write(&rows)?;
                *taken += rows.len() as u64;
            }
            Ok(Told::Flush(answer)) => {
                writer.flush()?;
                let _ = answer.send(()); // who asked may be gone
            }
            Ok(Told::End) | Err(_) => return writer.finish(),
        }
    }
}

/// Passes rows to the thread that writes them.
#[derive(Debug, Clone)]
pub struct Handed {
    sender: SyncSender<Told>,
    why: Arc<Mutex<String>>,
    unfinished: Option<Arc<()>>,
}

impl Handed {
    fn why(&self) -> String {
        let why = self.why.lock().unwrap_or_else(PoisonError::into_inner);
        if why.is_empty() { "the stream was finished before".into() } else { why.clone() }
    }
}

impl std::fmt::Debug for Told {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Rows(_) => "rows",
            Self::Flush(_) => "flush",
            Self::End => "the end",
        })
    }
}

impl Sink for Handed {
    fn take(&mut self, rows: &mut Rows) -> Result<(), String> {
        let empty = Rows { columns: rows.columns.clone(), ..Rows::default() };
        let sent = self.sender.send(Told::Rows(std::mem::replace(rows, empty)));
        sent.map_err(|_| self.why())
    }
    fn flush(&mut self) -> Result<(), String> {
        let (answer, done) = sync_channel(1);
        let sent = self.sender.send(Told::Flush(answer)).is_ok();
        if sent && done.recv().is_ok() { Ok(()) } else { Err(self.why()) }
    }
    fn end(&mut self) {
        self.unfinished = None;
    }
    fn join(&mut self, _: Self) -> Result<(), String> {
        Ok(()) // the rows are where they go
    }
}

/// A NumPy archive written in parts: for each 8 MiB of rows the arrays `step`, `trajectory`, `t` and one for each
/// column, each with the number of the part after its name. Where rows with other shapes come, as in a sweep over
/// networks of several sizes, they begin a part. Without rows there is one part of arrays of length 0. Each array costs
/// some 300 bytes of memory until the end. The file is readable after [`Stream::finish`]; a flush writes nothing
/// before.
#[doc(alias = "numpy")]
#[doc(alias = "npz")]
#[derive(Debug)]
pub struct NpzParts {
    npz: Option<Npz>,
    parts: usize,
    waiting: Rows,
}

impl NpzParts {
    /// Creates the file, and its folder where that is missing.
    ///
    /// # Errors
    /// [`DataError::Io`].
    pub fn create(path: impl AsRef<Path>) -> Result<Self, DataError> {
        Ok(Self { npz: Some(Npz::create(path)?), parts: 0, waiting: Rows::default() })
    }
}

impl NpzParts {
    fn write_part(&mut self) -> io::Result<()> {
        let (rows, part) = (taken(&mut self.waiting), self.parts);
        self.parts += 1;
        let name = |column: &str| format!("{column}.{part:06}");
        let float = |counts: &[u64]| counts.iter().map(|&x| x as f64).collect::<Vec<_>>();
        let number = [rows.len()];
        let npz =
            self.npz.take().ok_or_else(|| io::Error::other("the archive could not be written before"))?;
        let mut npz = npz
            .array(&name("step"), &number, &float(&rows.steps))
            .and_then(|npz| npz.array(&name("trajectory"), &number, &float(&rows.trajectories)))
            .and_then(|npz| npz.array(&name("t"), &number, &rows.times))
            .map_err(io::Error::other)?;
        for column in &*rows.columns {
            let numbers = rows.numbers(&column.name).flatten().copied().collect::<Vec<_>>();
            let shape = [&number[..], &column.shape].concat();
            npz = npz.array(&name(&column.name), &shape, &numbers).map_err(io::Error::other)?;
        }
        self.npz = Some(npz);
        Ok(())
    }
}

impl Writer for NpzParts {
    fn write(&mut self, rows: &Rows) -> io::Result<()> {
        if rows.is_empty() && (self.parts > 0 || !self.waiting.is_empty()) {
            return Ok(());
        }
        if self.waiting.columns != rows.columns {
            if !self.waiting.is_empty() {
                self.write_part()?;
            }
            self.waiting.columns = rows.columns.clone();
        }
        append(rows, &mut self.waiting);
        let numbers = (width(&rows.columns) + 3) * self.waiting.len();
        if numbers < NUMBERS { Ok(()) } else { self.write_part() }
    }

    fn finish(mut self) -> io::Result<()> {
        if self.parts == 0 || !self.waiting.is_empty() {
            self.write_part()?;
        }
        self.npz.map_or(Ok(()), |npz| npz.finish().map_err(io::Error::other))
    }
}

/// Extended XYZ: one frame for each row, with the positions of the bodies and, if they were recorded, their momenta and
/// `constraint_forces`.
/// Bodies have one to three coordinates; missing ones are written as 0. The second line of a frame has the time, step,
/// trajectory and the other numbers of the row; a quantity of one's own called `p` is one of these. They are called as
/// they were recorded, with `_` for blanks, `=`, quotes, brackets and `\`. A quantity called as a key of the format
/// itself is refused: `Lattice`, `Properties`, `pbc`, `Time`, `Step` or `Trajectory`; so are two of one name.
#[doc(alias = "ovito")]
#[doc(alias = "dump")]
#[derive(Debug)]
pub struct Xyz<W: Write> {
    to: BufWriter<W>,
    /// One for all bodies, or one for each.
    species: Vec<String>,
    /// What a line says of the cell.
    cell: String,
}

impl Xyz<File> {
    /// Creates the file `path`, and its folder where that is missing. Each body is an atom of this species: "Ar", "X".
    ///
    /// # Errors
    /// What the system says; a species that is not one word.
    pub fn create(path: impl AsRef<Path>, species: &str) -> io::Result<Self> {
        one_word(species)?;
        Ok(Self::to(files::create(path.as_ref())?, species))
    }
}

/// What a line of extended XYZ says besides the quantities of a user.
const KEYS: [&str; 6] = ["Lattice", "Properties", "pbc", "Time", "Step", "Trajectory"];

/// What has a vector for each body, and what the format calls it.
const VECTORS: [(&str, &str); 3] =
    [("q", "pos"), ("p", "momenta"), ("constraint_forces", "constraint_forces")];

/// Blanks divide what stands in a line.
fn one_word(species: &str) -> io::Result<()> {
    let is_word = !species.is_empty() && !species.contains(char::is_whitespace);
    if is_word { Ok(()) } else { Err(wrong("the species of extended XYZ is one word, such as `Ar`")) }
}

impl<W: Write> Xyz<W> {
    /// Writes frames to a writer, such as an open file. Each body is an atom of this species: "Ar", "X".
    pub fn to(to: W, species: &str) -> Self {
        Self { to: BufWriter::new(to), species: vec![species.into()], cell: "pbc=\"F F F\"".into() }
    }

    /// The same, where each body is an atom of a species of its own: they are told body by body.
    ///
    /// ```
    /// # use rattle::record::Xyz;
    /// let xyz = Xyz::to(Vec::new(), "X").species(&["O", "H", "H"])?;
    /// # drop(xyz);
    /// # Ok::<(), std::io::Error>(())
    /// ```
    ///
    /// # Errors
    /// A species that is not one word. If there are not as many as bodies, nothing can be written.
    pub fn species(self, of_bodies: &[impl AsRef<str>]) -> io::Result<Self> {
        let species = of_bodies.iter().map(|species| species.as_ref().to_string()).collect::<Vec<_>>();
        species.iter().try_for_each(|species| one_word(species))?;
        Ok(Self { species, ..self })
    }

    /// The same, whose frames have a cell: from the origin along the axes, of these lengths, and periodic along some of
    /// them. Positions are written as they are, which may be outside; viewers wrap them.
    ///
    /// ```
    /// # use rattle::record::Xyz;
    /// let periods = [8.0, 8.0, 1.0]; // a gas in the plane: the third length is any
    /// let xyz = Xyz::to(Vec::new(), "Ar").cell(periods, [true, true, false])?;
    /// # drop(xyz);
    /// # Ok::<(), std::io::Error>(())
    /// ```
    ///
    /// # Errors
    /// A length that is not positive and finite.
    #[doc(alias = "Lattice")]
    #[doc(alias = "pbc")]
    pub fn cell(self, lengths: [f64; 3], periodic: [bool; 3]) -> io::Result<Self> {
        if let Some(length) = lengths.into_iter().find(|&x| !(x > 0.0 && x.is_finite())) {
            return Err(wrong(format!("a length of a cell is positive and finite, found {length:?}")));
        }
        let ([a, b, c], [x, y, z]) = (lengths, periodic.map(|is| if is { "T" } else { "F" }));
        let lattice = format!("Lattice=\"{a:?} 0.0 0.0 0.0 {b:?} 0.0 0.0 0.0 {c:?}\"");
        Ok(Self { cell: format!("{lattice} pbc=\"{x} {y} {z}\""), ..self })
    }
}

impl<W: Write + Send + 'static> Writer for Xyz<W> {
    fn write(&mut self, rows: &Rows) -> io::Result<()> {
        self.species.iter().try_for_each(|species| one_word(species))?;
        let positions = rows.column("q").ok_or_else(|| wrong("extended XYZ wants recorded positions"))?;
        let &[bodies, coordinates] = &positions.shape[..] else {
            return Err(wrong("extended XYZ wants positions of bodies"));
        };
        if coordinates > 3 {
            return Err(wrong("extended XYZ has three coordinates at most"));
        }
        if ![1, bodies].contains(&self.species.len()) {
            return Err(wrong(format!(
                "extended XYZ has {} species for {bodies} bodies",
                self.species.len()
            )));
        }
        let is_vector =
            |name: &&str| VECTORS.map(|(name, _)| name).contains(name) && is_as_positions(rows, name);
        let vectors = VECTORS.iter().filter(|(name, _)| is_vector(name));
        let (vectors, properties): (Vec<_>, String) = vectors
            .map(|(name, property)| (rows.numbers(name).collect::<Vec<_>>(), format!(":{property}:R:3")))
            .unzip();
        let others = rows.columns.iter().filter(|column| !is_vector(&&*column.name));
        let key = |name: &str| name.replace(|c: char| c.is_whitespace() || "=\"'{}[]()\\".contains(c), "_");
        let others = others.map(|column| (key(&column.name), rows.numbers(&column.name).collect::<Vec<_>>()));
        let others = others.collect::<Vec<_>>();
        for (i, (name, _)) in others.iter().enumerate() {
            if KEYS.contains(&&**name) {
                return Err(wrong(format!(
                    "`{name}` is a key of extended XYZ itself; call the quantity otherwise"
                )));
            }
            if others[..i].iter().any(|other| other.0 == *name) {
                return Err(wrong(format!("two quantities would be called `{name}` in extended XYZ")));
            }
        }
        let mut frame = Vec::new();
        for row in 0..rows.len() {
            let (step, trajectory, time) = (rows.steps[row], rows.trajectories[row], rows.times[row]);
            writeln!(frame, "{bodies}")?;
            write!(frame, "Properties=species:S:1{properties} {} ", self.cell)?;
            write!(frame, "Time={time:?} Step={step} Trajectory={trajectory}")?;
            for (name, numbers) in &others {
                let numbers = numbers[row].iter().map(|x| format!("{x:?}")).collect::<Vec<_>>();
                write!(frame, " {name}=\"{}\"", numbers.join(" "))?;
            }
            writeln!(frame)?;
            for body in 0..bodies {
                write!(frame, "{}", self.species[body.min(self.species.len() - 1)])?;
                for of in &vectors {
                    for i in 0..3 {
                        let x = if i < coordinates { of[row][body * coordinates + i] } else { 0.0 };
                        write!(frame, " {x:?}")?;
                    }
                }
                writeln!(frame)?;
            }
            self.to.write_all(&frame)?; // as a whole: a buffer is passed on between frames
            frame.clear();
        }
        Ok(())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }

    fn finish(mut self) -> io::Result<()> {
        self.to.flush()
    }
}
