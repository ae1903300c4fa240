//! Particles for ParaView: a `.vtu` file for each row, and a `.pvd` file with their times.

use super::stream::{Writer, is_as_positions, wrong};
use crate::vtu::{Cells, Field, Series, text};
use crate::watch::Rows;
use std::io;
use std::path::Path;

/// Bodies as points, with momenta and constraint forces as vectors where they were recorded. `name.pvd` names the files
/// `name_000000.vtu`, … beside it with their times; open `name.pvd` in ParaView. For one trajectory, and for few rows,
/// since each row is a file.
#[doc(alias = "paraview")]
#[doc(alias = "vtk")]
#[derive(Debug)]
pub struct Vtu {
    series: Series,
    /// The number of the trajectory, from the first row.
    trajectory: Option<u64>,
}

impl Vtu {
    /// Creates `path`, and its folder where that is missing. `.pvd` is added to a path that does not end so.
    ///
    /// # Errors
    /// What the system says; a path without a file's name, or with one that is not Unicode.
    pub fn create(path: impl AsRef<Path>) -> io::Result<Self> {
        Ok(Self { series: Series::create(path)?, trajectory: None })
    }

    /// Adds a grid that does not move, such as the surface. `text` is the content of its file, `name_what.vtu`: for a
    /// mesh, `mesh.to_vtu()` (feature `view`).
    ///
    /// # Errors
    /// What the system says; a `what` of digits alone, which name the files of the rows.
    pub fn beside(mut self, what: &str, text: &str) -> io::Result<Self> {
        self.series.beside(what, text)?;
        Ok(self)
    }
}

impl Writer for Vtu {
    fn write(&mut self, rows: &Rows) -> io::Result<()> {
        let positions = rows.column("q").ok_or_else(|| wrong("VTU wants recorded positions"))?;
        let &[_, coordinates] = &positions.shape[..] else {
            return Err(wrong("VTU wants positions of bodies"));
        };
        if coordinates > 3 {
            return Err(wrong("VTU has three coordinates at most"));
        }
        for &other in &rows.trajectories {
            let one = *self.trajectory.get_or_insert(other);
            if other != one {
                return Err(wrong(format!(
                    "VTU takes one trajectory, found {one} and {other}; give each a recorder and a file of its own"
                )));
            }
        }
        let in_space = |name| {
            let vector = |v: &[f64]| std::array::from_fn(|i| v.get(i).copied().unwrap_or(0.0));
            let of_row = move |row: &[f64]| row.chunks_exact(coordinates).map(vector).collect();
            let vectors = rows.numbers(name).filter(|_| is_as_positions(rows, name));
            vectors.map(of_row).collect::<Vec<Vec<[f64; 3]>>>()
        };
        let (places, momenta, forces) = (in_space("q"), in_space("p"), in_space("constraint_forces"));
        for row in 0..rows.len() {
            let vectors = [("momentum", &momenta), ("constraint force", &forces)];
            let vectors = vectors.iter().filter_map(|(name, all)| Some(Field::vector(name, all.get(row)?)));
            let grid = text(&places[row], &Cells::Points, &vectors.collect::<Vec<_>>(), &[]);
            self.series.add(rows.times[row], &grid)?;
        }
        Ok(())
    }

    fn finish(self) -> io::Result<()> {
        Ok(()) // the list is whole after each file
    }
}
