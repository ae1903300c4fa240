//! Particles for ParaView: a `.vtu` for each row, and a `.pvd` that says when.

use super::stream::Writer;
use crate::watch::Rows;
use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Unstructured grids of points, as text: positions, and momenta and constraint forces as vectors where they were
/// recorded. `name.pvd` names the files `name_000000.vtu`, … beside it with their times; ParaView opens the former. Of
/// one trajectory; few rows, since each is a file.
#[derive(Debug)]
pub struct Vtu {
    folder: PathBuf,
    name: String,
    index: String,
    number: usize,
}

impl Vtu {
    /// Into `path`, which ends in `.pvd`, and files beside it; makes the folder where it is missing.
    ///
    /// # Errors
    /// What the system says; a path without a file's name.
    pub fn create(path: impl AsRef<Path>) -> io::Result<Self> {
        let path = path.as_ref();
        let name = path.file_stem().ok_or_else(|| wrong("the path names no file"))?;
        let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        fs::create_dir_all(&folder)?;
        Ok(Self { folder, name: name.to_string_lossy().into_owned(), index: String::new(), number: 0 })
    }

    /// The index with what is written so far: whole after each block.
    fn write_index(&self) -> io::Result<()> {
        let index = &self.index;
        let text = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n{index}</Collection>\n</VTKFile>\n"
        );
        fs::write(self.folder.join(format!("{}.pvd", self.name)), text)
    }
}

impl Writer for Vtu {
    fn write(&mut self, rows: &Rows) -> io::Result<()> {
        let positions = rows.column("q").ok_or_else(|| wrong("VTU wants recorded positions"))?;
        let &[bodies, coordinates] = &positions.shape[..] else {
            return Err(wrong("VTU wants positions of bodies"));
        };
        if coordinates > 3 {
            return Err(wrong("VTU has three coordinates at most"));
        }
        if rows.trajectories.iter().any(|&trajectory| trajectory != rows.trajectories[0]) {
            return Err(wrong("VTU takes one trajectory"));
        }
        let named = |name| rows.numbers(name).collect::<Vec<_>>();
        let (places, momenta, forces) = (named("q"), named("p"), named("constraint_forces"));
        for row in 0..rows.len() {
            let mut point_data = String::new();
            for (name, all) in [("momentum", &momenta), ("constraint force", &forces)] {
                if let Some(numbers) = all.get(row) {
                    point_data += &array(name, &in_space(numbers, coordinates));
                }
            }
            let counts = |from: usize| (from..from + bodies).map(|i| format!("{i} ")).collect::<String>();
            let cells = [
                ("Int64", "connectivity", counts(0)),
                ("Int64", "offsets", counts(1)),
                ("UInt8", "types", "1 ".repeat(bodies)),
            ];
            let cells = cells.map(|(kind, name, numbers)| {
                format!("<DataArray type=\"{kind}\" Name=\"{name}\" format=\"ascii\">{numbers}</DataArray>\n")
            });
            let text = format!(
                "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n\
                 <UnstructuredGrid><Piece NumberOfPoints=\"{bodies}\" NumberOfCells=\"{bodies}\">\n\
                 <Points>\n{}</Points>\n<Cells>\n{}</Cells>\n<PointData>\n{point_data}</PointData>\n\
                 </Piece></UnstructuredGrid>\n</VTKFile>\n",
                array("positions", &in_space(places[row], coordinates)),
                cells.concat(),
            );
            let file = format!("{}_{:06}.vtu", self.name, self.number);
            fs::write(self.folder.join(&file), text)?;
            self.number += 1;
            let time = rows.times[row];
            let _ = writeln!(self.index, "<DataSet timestep=\"{time:?}\" file=\"{file}\"/>"); // into a string
        }
        self.write_index()
    }

    fn finish(self) -> io::Result<()> {
        self.write_index()
    }
}

fn wrong(what: &'static str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, what)
}

/// Vectors with zeros for the coordinates that are none.
fn in_space(numbers: &[f64], coordinates: usize) -> String {
    let mut text = String::new();
    for vector in numbers.chunks_exact(coordinates) {
        for i in 0..3 {
            let _ = write!(text, "{:?} ", vector.get(i).unwrap_or(&0.0)); // into a string
        }
    }
    text
}

fn array(name: &str, numbers: &str) -> String {
    format!(
        "<DataArray type=\"Float64\" Name=\"{name}\" NumberOfComponents=\"3\" format=\"ascii\">{numbers}</DataArray>\n"
    )
}
