//! Files for ParaView: a mesh with numbers at its vertices and in its triangles (`.vtu`), and a series of them
//! (`.pvd`).

use crate::mesh::Mesh;
use rattle::vtu::{Cells, Field};

pub use rattle::vtu::Series;

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
/// If the length of `height` or of a field is not the number of vertices, or triangles.
#[track_caller]
#[must_use]
pub fn text(
    mesh: &Mesh,
    height: &[f64],
    at_vertices: &[(&str, &[f64])],
    in_triangles: &[(&str, &[[f64; 2]])],
) -> String {
    assert!(height.len() == mesh.points().len(), "one height for each vertex");
    let points: Vec<_> = mesh.points().iter().zip(height).map(|(&[x, y], &z)| [x, y, z]).collect();
    let at_points: Vec<_> = at_vertices.iter().map(|(name, field)| Field::number(name, field)).collect();
    let in_cells: Vec<_> = in_triangles.iter().map(|(name, field)| Field::vector(name, field)).collect();
    rattle::vtu::text(&points, &Cells::Triangles(mesh.triangles()), &at_points, &in_cells)
}
