//! Tables as text, for whatever reads numbers.

use super::stream::{Writer, names, width, wrong};
use crate::files;
use crate::watch::{Column, Rows};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::sync::Arc;

/// Text with commas: a line with the names `step`, `trajectory`, `t` and one for each recorded number, then a line for
/// each row. Names are those of `Parquet`: `height`, or `q_0_2` for an entry of an array (for positions: body 0,
/// coordinate 2). One with commas, quotes or line breaks is in quotes. Numbers have as many digits as tell them from
/// all others; those that are none are `NaN`, `inf` and `-inf`. The line of names is there also where no row was
/// recorded.
///
/// ```
/// use rattle::prelude::*;
/// use rattle::record::{Csv, Stream};
/// use rattle::watch::{Columns, Recorder};
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("run.csv");
/// let start = State::at([0.0, 1.0]).moving([1.0, 0.0]);
/// let mut simulation = Scene::point().simulate(start, Rattle::new(0.5))?;
/// let stream = Stream::to(Csv::create(&path)?);
/// let columns = Columns::<2>::new().positions().quantity("speed", |now| now.momentum().norm()).with_start();
/// let mut recorder = Recorder::of(&columns, stream.sink());
/// simulation.observe(2, 1, &mut recorder)?;
/// recorder.finish()?;
/// stream.finish()?;
/// let text = std::fs::read_to_string(&path)?;
/// assert_eq!(
///     text.lines().collect::<Vec<_>>(),
///     ["step,trajectory,t,q_0_0,q_0_1,speed", "0,0,0.0,0.0,1.0,1.0", "1,0,0.5,0.5,1.0,1.0", "2,0,1.0,1.0,1.0,1.0"]
/// );
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Numbers as text take some 18 bytes each, where binary ones take 8: for long runs take
/// [`NpzParts`](super::NpzParts) or `Parquet`.
#[doc(alias = "table")]
#[doc(alias = "text")]
#[doc(alias = "loadtxt")]
#[doc(alias = "pandas")]
#[derive(Debug)]
pub struct Csv<W: Write> {
    to: BufWriter<W>,
    /// Of the first row, where the names are written.
    columns: Option<Arc<[Column]>>,
}

impl Csv<File> {
    /// Creates the file `path`, and its folder where that is missing.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn create(path: impl AsRef<Path>) -> io::Result<Self> {
        Ok(Self::to(files::create(path.as_ref())?))
    }
}

impl<W: Write> Csv<W> {
    /// Writes rows to a writer, such as an open file.
    pub fn to(to: W) -> Self {
        Self { to: BufWriter::new(to), columns: None }
    }

    /// The line of names.
    fn begin(&mut self, columns: &Arc<[Column]>) -> io::Result<()> {
        let names = names(columns).map_err(wrong)?;
        let quoted = |name: String| {
            let is_plain = !name.contains([',', '"', '\n', '\r']);
            if is_plain { name } else { format!("\"{}\"", name.replace('"', "\"\"")) }
        };
        let line = names.into_iter().map(quoted).collect::<Vec<_>>().join(",") + "\n";
        self.to.write_all(line.as_bytes())?;
        self.columns = Some(columns.clone());
        Ok(())
    }
}

impl<W: Write + Send + 'static> Writer for Csv<W> {
    fn write(&mut self, rows: &Rows) -> io::Result<()> {
        match &self.columns {
            None => self.begin(&rows.columns)?,
            Some(columns) if !rows.is_empty() => {
                let first = Rows { columns: columns.clone(), ..Rows::default() };
                rows.fit(&first).map_err(wrong)?; // a table has one width
            }
            Some(_) => {}
        }
        let (width, mut line) = (width(&rows.columns), Vec::new());
        for row in 0..rows.len() {
            let (step, trajectory, time) = (rows.steps[row], rows.trajectories[row], rows.times[row]);
            write!(line, "{step},{trajectory},{time:?}")?;
            for number in &rows.numbers[row * width..][..width] {
                write!(line, ",{number:?}")?;
            }
            writeln!(line)?;
            self.to.write_all(&line)?; // as a whole: a buffer is passed on between lines
            line.clear();
        }
        Ok(())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }

    fn finish(mut self) -> io::Result<()> {
        if self.columns.is_none() {
            self.begin(&Arc::default())?;
        }
        self.to.flush()
    }
}
