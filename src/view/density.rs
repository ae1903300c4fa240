//! The density of points on a mesh.

use super::mesh::{Mesh, MeshError, cross, length, minus};
use std::collections::HashMap;

impl Mesh {
    /// Points per area around each vertex: the number of points within `radius` of the vertex, divided by the area of
    /// the mesh within `radius`. For [`Scene3::heat`](super::Scene3::heat).
    ///
    /// Distances are straight lines through space, so the radius should be small against the thinnest part of the
    /// surface. Areas are sums over vertices, so the radius should be some edges long.
    ///
    /// ```
    /// use rattle::view::Mesh;
    /// let sphere = |[x, y, z]: [f64; 3]| (x * x + y * y + z * z - 1.0, [2.0 * x, 2.0 * y, 2.0 * z]);
    /// let mesh = Mesh::of(sphere, [-1.5; 3], [1.5; 3], 30)?;
    /// let seven = [[0.0, 0.0, 1.0]; 7];
    /// let density = mesh.density(&seven, 0.3)?;
    /// let pole = mesh.vertices.iter().position(|q| q[2] > 0.98).unwrap();
    /// assert!((density[pole] * 0.09 * std::f64::consts::PI - 7.0).abs() < 2.0);
    /// # Ok::<(), rattle::view::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// [`MeshError::Radius`] if the radius is not a positive number.
    pub fn density<P: Copy + Into<[f64; 3]>>(
        &self,
        points: &[P],
        radius: f64,
    ) -> Result<Vec<f64>, MeshError> {
        if !(radius.is_finite() && radius > 0.0) {
            return Err(MeshError::Radius(radius));
        }
        let points = Cells::of(points.iter().map(|&point| (point.into(), 1.0)), radius);
        let areas = Cells::of(self.vertices.iter().copied().zip(self.areas()), radius);
        let density = |&vertex: &[f64; 3]| match areas.within(vertex) {
            0.0 => 0.0, // a vertex that no triangle uses
            area => points.within(vertex) / area,
        };
        Ok(self.vertices.iter().map(density).collect())
    }

    /// A third of the triangles around each vertex.
    fn areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.vertices.len()];
        for corners in &self.triangles {
            let [a, b, c] = corners.map(|vertex| self.vertices[vertex as usize]);
            let area = 0.5 * length(cross(minus(b, a), minus(c, a)));
            corners.iter().for_each(|&vertex| areas[vertex as usize] += area / 3.0);
        }
        areas
    }
}

/// Places with weights, by the cube of the side `radius` that they lie in.
struct Cells {
    radius: f64,
    cells: HashMap<[i64; 3], Vec<([f64; 3], f64)>>,
}

impl Cells {
    fn of(places: impl Iterator<Item = ([f64; 3], f64)>, radius: f64) -> Self {
        let mut cells: HashMap<_, Vec<_>> = HashMap::new();
        for (place, weight) in places.filter(|(place, _)| place.iter().all(|x| x.is_finite())) {
            cells.entry(cell(place, radius)).or_default().push((place, weight));
        }
        Self { radius, cells }
    }

    /// The weight within the radius.
    fn within(&self, from: [f64; 3]) -> f64 {
        let middle = cell(from, self.radius);
        let mut sum = 0.0;
        for n in 0..27_i64 {
            let near = [n % 3, n / 3 % 3, n / 9].map(|i| i - 1);
            let Some(places) = self.cells.get(&[0, 1, 2].map(|i| middle[i] + near[i])) else { continue };
            for (place, weight) in places {
                let squared: f64 = (0..3).map(|i| (place[i] - from[i]).powi(2)).sum();
                sum += if squared < self.radius.powi(2) { *weight } else { 0.0 };
            }
        }
        sum
    }
}

fn cell(place: [f64; 3], side: f64) -> [i64; 3] {
    place.map(|x| ((x / side).floor() as i64).clamp(i64::MIN / 2, i64::MAX / 2))
}
