//! Functions with jumps as depths at vertices.

use crate::mesh::{Mesh, signed_area};
use crate::sparse::Sparse;

/// Each side of a triangle is divided in so many parts to integrate a function.
const PARTS: usize = 8;

impl Mesh {
    /// The L² projection of `f` onto continuous functions that are linear in each triangle, as values at the vertices.
    /// It has the integral of `f`.
    ///
    /// It overshoots near jumps; [clamping](f64::clamp) changes its integral. `f` is evaluated at the centres of 64
    /// parts of each triangle.
    ///
    /// ```
    /// use rattle_flow::Mesh;
    /// let mesh = Mesh::polygon(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], 0.2)?;
    /// let linear = mesh.projected(|[x, y]| x - 2.0 * y);
    /// assert!(mesh.points().iter().zip(&linear).all(|([x, y], h)| (h - (x - 2.0 * y)).abs() < 1e-2));
    /// assert!((mesh.volume(&linear)? + 0.5).abs() < 1e-13);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn projected(&self, f: impl Fn([f64; 2]) -> f64) -> Vec<f64> {
        let mut matrix = Sparse::of_groups(self.points().len(), self.triangles().iter().copied());
        let mut moments = vec![0.0; self.points().len()];
        for (triangle, vertices) in self.triangles().iter().enumerate() {
            let corners = self.corners(triangle);
            let area = signed_area(corners);
            for (weights, part) in middles() {
                let place = [0, 1].map(|x| (0..3).map(|i| weights[i] * corners[i][x]).sum());
                let value = f(place) * area * part;
                (0..3).for_each(|i| moments[vertices[i] as usize] += weights[i] * value);
            }
            for (i, &row) in vertices.iter().enumerate() {
                for (j, &column) in vertices.iter().enumerate() {
                    let entry = matrix.place(row, column) as usize;
                    matrix.values[entry] += area / if i == j { 6.0 } else { 12.0 };
                }
            }
        }
        let mut iterative = matrix.iterative();
        let solved = iterative.take(&matrix.values) && iterative.solve(&mut moments, 1e-14, &[]).is_some();
        if !solved && matrix.factorise().is_ok() {
            matrix.solve(&mut moments);
        }
        moments
    }
}

/// Barycentric coordinates of the middles of the parts of a triangle, with their share of the area.
fn middles() -> impl Iterator<Item = ([f64; 3], f64)> {
    let n = PARTS;
    let upright =
        (0..n).flat_map(move |i| (0..n - i).map(move |j| [i as f64 + 1.0 / 3.0, j as f64 + 1.0 / 3.0]));
    let inverted =
        (1..n).flat_map(move |i| (1..=n - i).map(move |j| [i as f64 - 1.0 / 3.0, j as f64 - 1.0 / 3.0]));
    upright.chain(inverted).map(move |at| {
        let [a, b] = at.map(|x| x / n as f64);
        ([a, b, 1.0 - a - b], 1.0 / (n * n) as f64)
    })
}
