//! Files for ParaView: a grid of points or triangles with fields (`.vtu`), and a series of them in time (`.pvd`), which
//! is the file to open.
//!
//! To write a run, use a recorder with `record::Vtu` (feature `data`).
//!
//! ```
//! use rattle::vtu::{Cells, Field, Series, text};
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("fall.pvd");
//! let mut series = Series::create(&path)?;
//! for step in 0..3 {
//!     let time = 0.1 * f64::from(step);
//!     let bodies = [[0.0, 0.0, -0.5 * time * time], [1.0, 0.0, -0.5 * time * time]];
//!     series.add(time, &text(&bodies, &Cells::Points, &[Field::number("mass", &[1.0, 2.0])], &[]))?;
//! }
//! # let list = std::fs::read_to_string(path)?;
//! # assert!(list.contains("timestep=\"0.1\"") && list.contains("fall_000002.vtu"));
//! # Ok::<(), std::io::Error>(())
//! ```

use crate::base64::base64;
use crate::files;
use crate::xml::escaped;
use std::fmt::{Debug, Write as _};
use std::fs::{self, File};
use std::io::{self, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

/// The cells of a grid.
#[derive(Debug, Clone, Copy)]
pub enum Cells<'a> {
    /// Each point by itself.
    Points,
    /// Triangles, three points each.
    Triangles(&'a [[u32; 3]]),
}

/// Numbers at all points, or in all cells.
#[derive(Debug, Clone)]
pub struct Field<'a> {
    name: &'a str,
    components: usize,
    numbers: Vec<f64>,
}

impl<'a> Field<'a> {
    /// One number for each point or cell.
    #[must_use]
    pub fn number(name: &'a str, numbers: &[f64]) -> Self {
        Self { name, components: 1, numbers: numbers.to_vec() }
    }

    /// A vector of up to three coordinates for each point or cell.
    #[must_use]
    pub fn vector<const D: usize>(name: &'a str, vectors: &[[f64; D]]) -> Self {
        const { assert!(D <= 3, "ParaView's space has three coordinates") }
        let numbers = vectors.iter().flat_map(|v| (0..3).map(|i| v.get(i).copied().unwrap_or(0.0)));
        Self { name, components: 3, numbers: numbers.collect() }
    }
}

/// A grid with fields at its points and in its cells, as the text of a `.vtu` file. Numbers read back bit for bit: an
/// array in which some are NaN or infinite is written as bytes in base64.
///
/// # Panics
/// If the length of a field is not the number of points, or cells.
#[track_caller]
#[must_use]
pub fn text(
    points: &[[f64; 3]],
    cells: &Cells<'_>,
    at_points: &[Field<'_>],
    in_cells: &[Field<'_>],
) -> String {
    let n = points.len();
    let (m, corners, kind) = match cells {
        Cells::Points => (n, 1, 1),
        Cells::Triangles(triangles) => (triangles.len(), 3, 5),
    };
    let fits =
        |fields: &[Field<'_>], n| fields.iter().all(|field| field.numbers.len() == field.components * n);
    assert!(fits(at_points, n), "a field at points has an entry for each point");
    assert!(fits(in_cells, m), "a field in cells has an entry for each cell");
    let mut out = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n",
    );
    let _ = writeln!(out, "<UnstructuredGrid><Piece NumberOfPoints=\"{n}\" NumberOfCells=\"{m}\">");
    for (place, fields) in [("PointData", at_points), ("CellData", in_cells)] {
        let _ = writeln!(out, "<{place}>");
        for Field { name, components, numbers } in fields {
            floats(&mut out, name, *components, numbers);
        }
        let _ = writeln!(out, "</{place}>");
    }
    out.push_str("<Points>\n");
    floats(&mut out, "points", 3, points.as_flattened());
    out.push_str("</Points><Cells>\n");
    match cells {
        Cells::Points => words(&mut out, "Int64", "connectivity", 1, 0..n),
        Cells::Triangles(triangles) => {
            words(&mut out, "Int64", "connectivity", 1, triangles.as_flattened());
        }
    }
    words(&mut out, "Int64", "offsets", 1, (1..=m).map(|i| corners * i));
    words(&mut out, "UInt8", "types", 1, (0..m).map(|_| kind));
    out.push_str("</Cells></Piece></UnstructuredGrid></VTKFile>\n");
    out
}

/// As words, or as bytes: older readers end an array at the word `NaN`.
fn floats(out: &mut String, name: &str, components: usize, numbers: &[f64]) {
    if numbers.iter().all(|x| x.is_finite()) {
        return words(out, "Float64", name, components, numbers);
    }
    let mut bytes = (8 * numbers.len() as u64).to_le_bytes().to_vec();
    bytes.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
    array(out, ["Float64", name, "binary"], components, &base64(&bytes));
}

fn words(
    out: &mut String,
    kind: &str,
    name: &str,
    components: usize,
    numbers: impl IntoIterator<Item = impl Debug>,
) {
    let mut text = String::new();
    for number in numbers {
        let _ = write!(text, "{number:?} "); // into a string
    }
    array(out, [kind, name, "ascii"], components, &text);
}

fn array(out: &mut String, [kind, name, format]: [&str; 3], components: usize, content: &str) {
    let name = escaped(name);
    let _ = writeln!(
        out,
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"{format}\">\n{content}\n</DataArray>"
    );
}

fn wrong(why: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, why)
}

/// A time series: files `name_000000.vtu`, … and `name.pvd` with their times. `name.pvd` is complete after each file.
#[doc(alias = "paraview")]
#[doc(alias = "vtk")]
#[derive(Debug)]
pub struct Series {
    folder: PathBuf,
    name: String,
    number: usize,
    still: Vec<String>,
    list: File,
    /// Where the next entry goes.
    end: u64,
}

/// The list's last lines.
const END: &str = "</Collection></VTKFile>\n";

impl Series {
    /// Creates the list `path`, and its folder where that is missing. `.pvd` is added to a path that does not end so:
    /// `k=0.1` is `k=0.1.pvd`.
    ///
    /// # Errors
    /// Those of the file system; a path without a file's name, or with one that is not Unicode.
    pub fn create(path: impl AsRef<Path>) -> io::Result<Self> {
        let path = path.as_ref();
        let name = path.file_name().ok_or_else(|| wrong("the path names no file"))?;
        let name = name.to_str().ok_or_else(|| wrong("the name of the file is not Unicode"))?;
        let name = name.strip_suffix(".pvd").unwrap_or(name).to_owned();
        if name.is_empty() {
            return Err(wrong("the name of the file is its ending"));
        }
        let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        let list = files::create(&folder.join(format!("{name}.pvd")))?;
        let mut series = Self { folder, name, number: 0, still: Vec::new(), list, end: 0 };
        series
            .append("<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\"><Collection>\n")?;
        Ok(series)
    }

    /// Adds a grid that does not move, such as the surface, to all times added after it. Its file is `name_what.vtu`.
    ///
    /// # Errors
    /// Those of the file system; a `what` of digits alone, which name the files of the series itself.
    pub fn beside(&mut self, what: &str, text: &str) -> io::Result<()> {
        if !what.is_empty() && what.bytes().all(|byte| byte.is_ascii_digit()) {
            return Err(wrong("what lies beside a series is called otherwise than by digits alone"));
        }
        let file = format!("{}_{what}.vtu", self.name);
        fs::write(self.folder.join(&file), text)?;
        self.still.push(file);
        Ok(())
    }

    /// Adds the [text] of a grid at this time.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn add(&mut self, time: f64, text: &str) -> io::Result<()> {
        let file = format!("{}_{:06}.vtu", self.name, self.number);
        fs::write(self.folder.join(&file), text)?;
        self.number += 1;
        let mut entries = String::new();
        for (part, file) in [&file].into_iter().chain(&self.still).enumerate() {
            // into a string
            let file = escaped(file);
            let _ = writeln!(entries, "<DataSet timestep=\"{time:?}\" part=\"{part}\" file=\"{file}\"/>");
        }
        self.append(&entries)
    }

    /// In place of the last lines, which follow.
    fn append(&mut self, entries: &str) -> io::Result<()> {
        self.list.seek(SeekFrom::Start(self.end))?;
        self.list.write_all(format!("{entries}{END}").as_bytes())?;
        self.end += entries.len() as u64;
        Ok(())
    }
}
