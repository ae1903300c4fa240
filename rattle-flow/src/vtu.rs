//! Files for ParaView: a mesh with numbers at its vertices and in its triangles (`.vtu`), and a series of them
//! (`.pvd`).

use crate::mesh::Mesh;
use std::fmt::{Display, Write as _};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// A mesh with fields, as the text of a `.vtu` file.
///
/// ```
/// use rattle_flow::{Mesh, vtu};
/// let mesh = Mesh::polygon(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], 0.5)?;
/// let depth = mesh.at_vertices(|[x, _]| x);
/// let text = vtu::text(&mesh, &depth, &[("depth", &depth)], &[]);
/// assert!(text.contains("Name=\"depth\""));
/// # Ok::<(), rattle_flow::MeshError>(())
/// ```
///
/// `height` is the third coordinate of the vertices. Numbers are written so that they read back bit for bit.
///
/// # Panics
/// If `height` or a field has another length than there are vertices or triangles.
#[track_caller]
pub fn text(
    mesh: &Mesh,
    height: &[f64],
    at_vertices: &[(&str, &[f64])],
    in_triangles: &[(&str, &[[f64; 2]])],
) -> String {
    let (n, m) = (mesh.points().len(), mesh.triangles().len());
    assert!(
        height.len() == n && at_vertices.iter().all(|(_, field)| field.len() == n),
        "one number for each vertex"
    );
    assert!(in_triangles.iter().all(|(_, field)| field.len() == m), "one vector for each triangle");
    let mut out = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n",
    );
    let _ = writeln!(out, "<UnstructuredGrid><Piece NumberOfPoints=\"{n}\" NumberOfCells=\"{m}\">");
    out.push_str("<PointData>\n");
    for (name, field) in at_vertices {
        array(&mut out, "Float64", name, 1, field.iter());
    }
    out.push_str("</PointData><CellData>\n");
    for (name, field) in in_triangles {
        array(&mut out, "Float64", name, 3, field.iter().flat_map(|&[x, y]| [x, y, 0.0]));
    }
    out.push_str("</CellData><Points>\n");
    let places = mesh.points().iter().zip(height).flat_map(|(&[x, y], &z)| [x, y, z]);
    array(&mut out, "Float64", "points", 3, places);
    out.push_str("</Points><Cells>\n");
    array(&mut out, "UInt32", "connectivity", 1, mesh.triangles().iter().flatten());
    array(&mut out, "UInt32", "offsets", 1, (1..=m).map(|i| 3 * i));
    array(&mut out, "UInt8", "types", 1, (0..m).map(|_| 5)); // a triangle
    out.push_str("</Cells></Piece></UnstructuredGrid></VTKFile>\n");
    out
}

fn array(
    out: &mut String,
    kind: &str,
    name: &str,
    components: usize,
    numbers: impl Iterator<Item = impl Display>,
) {
    let name = name.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;");
    let _ = writeln!(
        out,
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"ascii\">"
    );
    for number in numbers {
        let _ = write!(out, "{number} ");
    }
    out.push_str("\n</DataArray>\n");
}

/// Files `name_0000.vtu`, … in a folder, and `name.pvd` with their times, which is the file to open.
#[derive(Debug)]
pub struct Series {
    folder: PathBuf,
    name: String,
    times: Vec<f64>,
}

impl Series {
    /// A series in a folder, which is made where it is missing.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn new(folder: impl AsRef<Path>, name: impl Into<String>) -> io::Result<Self> {
        fs::create_dir_all(&folder)?;
        Ok(Series { folder: folder.as_ref().to_owned(), name: name.into(), times: Vec::new() })
    }

    /// Adds the [text] of a mesh at a time, and writes the list anew.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn add(&mut self, time: f64, text: &str) -> io::Result<()> {
        let file = |i: usize| format!("{}_{i:04}.vtu", self.name);
        fs::write(self.folder.join(file(self.times.len())), text)?;
        self.times.push(time);
        let mut list = String::from(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\"><Collection>\n",
        );
        for (i, time) in self.times.iter().enumerate() {
            let _ = writeln!(list, "<DataSet timestep=\"{time}\" part=\"0\" file=\"{}\"/>", file(i));
        }
        list.push_str("</Collection></VTKFile>\n");
        fs::write(self.folder.join(format!("{}.pvd", self.name)), list)
    }
}
