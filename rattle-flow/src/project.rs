//! Functions with jumps as depths at vertices.

use crate::mesh::Mesh;
use crate::plane::signed_area;
use crate::sparse::Sparse;

/// Each side of a triangle is divided in so many parts to integrate a function.
const PARTS: usize = 8;

impl Mesh {
    /// The L² projection of `f` onto continuous functions that are linear in each triangle, as values at the vertices.
    /// It has the integral of `f`, and is `f` where that is such a function.
    ///
    /// It overshoots near jumps; [clamping](f64::clamp) changes its integral. Integrals are sums over the centres of 64
    /// parts of each triangle: of all such functions it is the nearest to `f` there, by least squares.
    ///
    /// ```
    /// use rattle_flow::Mesh;
    /// let mesh = Mesh::polygon(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], 0.2)?;
    /// let linear = mesh.projected(|[x, y]| x - 2.0 * y);
    /// assert!(mesh.points().iter().zip(&linear).all(|([x, y], h)| (h - (x - 2.0 * y)).abs() < 1e-13));
    /// assert!((mesh.volume(&linear)? + 0.5).abs() < 1e-13);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn projected(&self, f: impl Fn([f64; 2]) -> f64) -> Vec<f64> {
        let mut matrix = Sparse::of_groups(self.points().len(), self.triangles().iter().copied());
        let mut moments = vec![0.0; self.points().len()];
        let products = products();
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
                    matrix.values[entry] += area * products[i][j];
                }
            }
        }
        let mut iterative = matrix.iterative();
        let mut heights = moments.clone();
        let solved = iterative.take(&matrix.values) && iterative.solve(&mut heights, 1e-14, &[]).is_some();
        if solved {
            // With what the first answer left, the second is right to rounding.
            for (column, height) in heights.iter().enumerate() {
                for (row, place) in matrix.column(column) {
                    moments[row] -= matrix.values[place] * height;
                }
            }
            if iterative.solve(&mut moments, 1e-3, &[]).is_some() {
                heights.iter_mut().zip(&moments).for_each(|(height, more)| *height += more);
            }
        } else if matrix.factorise().is_ok() {
            matrix.solve(&mut heights);
        }
        heights
    }
}

/// The integrals of products of barycentric coordinates as part of the area, by the points at which functions are
/// integrated: 1/6 and 1/12 would be off from these by a part of 1/128, and linear functions would not come back.
fn products() -> [[f64; 3]; 3] {
    let mut sums = [[0.0; 3]; 3];
    for (weights, part) in middles() {
        for i in 0..3 {
            (0..3).for_each(|j| sums[i][j] += weights[i] * weights[j] * part);
        }
    }
    sums
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
