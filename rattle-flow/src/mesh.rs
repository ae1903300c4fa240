//! Meshes of triangles in the plane.

use crate::error::{FlowError, MeshError, one_for_each_vertex};
use std::collections::HashMap;

/// A mesh of triangles that meet edge to edge; checked when it is made.
///
/// ```
/// use rattle_flow::Mesh;
/// let mesh = Mesh::new(vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], vec![[0, 1, 2], [0, 2, 3]])?;
/// assert!((mesh.area() - 1.0).abs() < 1e-15);
/// assert_eq!(mesh.boundary().len(), 4);
/// # Ok::<(), rattle_flow::MeshError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    points: Vec<[f64; 2]>,
    triangles: Vec<[u32; 3]>,
    boundary: Vec<[u32; 2]>,
    /// The triangle at each edge of the boundary.
    at_boundary: Vec<u32>,
    shares: Vec<f64>,
}

impl Mesh {
    /// The mesh of these vertices and triangles, each counter-clockwise.
    ///
    /// # Errors
    /// Any [`MeshError`] except `Polygon`: the first one found, with its position.
    pub fn new(points: Vec<[f64; 2]>, triangles: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        if triangles.is_empty() {
            return Err(MeshError::Empty);
        }
        if let Some((vertex, &[x, y])) =
            points.iter().enumerate().find(|(_, p)| !p.iter().all(|x| x.is_finite()))
        {
            return Err(MeshError::NotFinite { vertex, x, y });
        }
        let mut shares = vec![0.0; points.len()];
        let mut sides: HashMap<[u32; 2], usize> = HashMap::with_capacity(3 * triangles.len());
        for (triangle, &corners) in triangles.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&vertex| vertex as usize >= points.len()) {
                return Err(MeshError::NoVertex {
                    triangle,
                    vertex: vertex as usize,
                    vertices: points.len(),
                });
            }
            let place = corners.map(|vertex| points[vertex as usize]);
            let area = signed_area(place);
            let longest = (0..3).map(|i| squared(place[i], place[(i + 1) % 3])).fold(0.0, f64::max);
            if area.is_nan() || area <= 1e-14 * longest {
                let [x, y] = centroid(place);
                return Err(MeshError::Inverted { triangle, x, y, area });
            }
            corners.iter().for_each(|&vertex| shares[vertex as usize] += area / 3.0);
            for i in 0..3 {
                let [from, to] = [corners[i], corners[(i + 1) % 3]];
                if let Some(first) = sides.insert([from, to], triangle) {
                    let [from, to] = [from as usize, to as usize];
                    return Err(MeshError::Overlap { first, second: triangle, from, to });
                }
            }
        }
        if let Some(vertex) = shares.iter().position(|&share| share == 0.0) {
            return Err(MeshError::Loose { vertex });
        }
        let mut boundary: Vec<[u32; 2]> =
            sides.keys().copied().filter(|&[from, to]| !sides.contains_key(&[to, from])).collect();
        boundary.sort_unstable();
        let at_boundary = boundary.iter().map(|edge| sides[edge] as u32).collect();
        let mesh = Mesh { points, triangles, boundary, at_boundary, shares };
        match mesh.hanging() {
            Some(([from, to], vertex)) => {
                let triangle = sides[&[from, to]];
                let [from, to, vertex] = [from, to, vertex].map(|v| v as usize);
                Err(MeshError::Hanging { vertex, from, to, triangle })
            }
            None => Ok(mesh),
        }
    }

    /// A vertex of the boundary inside an edge of it. Vertices are looked up by cells as large as the longest edge.
    fn hanging(&self) -> Option<([u32; 2], u32)> {
        let ends = |[a, b]: [u32; 2]| [self.points[a as usize], self.points[b as usize]];
        let longest = self
            .boundary
            .iter()
            .map(|&edge| squared(ends(edge)[0], ends(edge)[1]))
            .fold(0.0, f64::max)
            .sqrt();
        let cell = |[x, y]: [f64; 2]| [(x / longest).floor() as i64, (y / longest).floor() as i64];
        let mut cells: HashMap<[i64; 2], Vec<u32>> = HashMap::new();
        for &[from, _] in &self.boundary {
            cells.entry(cell(self.points[from as usize])).or_default().push(from);
        }
        for &edge in &self.boundary {
            let [a, b] = ends(edge);
            let [i, j] = cell(a);
            let length = squared(a, b);
            for near in (-1..=1).flat_map(|di| (-1..=1).map(move |dj| [i + di, j + dj])) {
                for &vertex in cells.get(&near).into_iter().flatten().filter(|vertex| !edge.contains(vertex))
                {
                    let [x, y] = self.points[vertex as usize];
                    let along = ((x - a[0]) * (b[0] - a[0]) + (y - a[1]) * (b[1] - a[1])) / length;
                    let aside = ((x - a[0]) * (b[1] - a[1]) - (y - a[1]) * (b[0] - a[0])) / length;
                    if along > 0.0 && along < 1.0 && aside.abs() < 1e-9 {
                        return Some((edge, vertex));
                    }
                }
            }
        }
        None
    }

    /// The positions of the vertices.
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }
    /// The vertices of each triangle, counter-clockwise.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }
    /// The edges of the boundary, with the mesh on their left.
    pub fn boundary(&self) -> &[[u32; 2]] {
        &self.boundary
    }
    /// The triangle at each edge of the boundary.
    pub(crate) fn at_boundary(&self) -> &[u32] {
        &self.at_boundary
    }
    /// The area that belongs to each vertex: a third of the area of each of its triangles.
    pub fn shares(&self) -> &[f64] {
        &self.shares
    }
    /// The whole area.
    pub fn area(&self) -> f64 {
        self.shares.iter().sum()
    }
    /// The corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [[f64; 2]; 3] {
        self.triangles[triangle].map(|vertex| self.points[vertex as usize])
    }
    /// The volume ∫ h of depths at the vertices, linear between them.
    ///
    /// # Errors
    /// [`FlowError::Count`] if the number of depths is not the number of vertices.
    pub fn volume(&self, depth: &[f64]) -> Result<f64, FlowError> {
        one_for_each_vertex(depth, self.points.len())?;
        Ok(self.volume_of(depth))
    }
    /// The volume of one depth for each vertex.
    pub(crate) fn volume_of(&self, depth: &[f64]) -> f64 {
        depth.iter().zip(&self.shares).map(|(h, share)| h * share).sum()
    }
    /// The values of a function at the vertices.
    pub fn at_vertices(&self, f: impl Fn([f64; 2]) -> f64) -> Vec<f64> {
        self.points.iter().map(|&place| f(place)).collect()
    }
}

/// The area of a triangle, positive if it is counter-clockwise.
pub(crate) fn signed_area([a, b, c]: [[f64; 2]; 3]) -> f64 {
    0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]))
}

pub(crate) fn centroid([a, b, c]: [[f64; 2]; 3]) -> [f64; 2] {
    [(a[0] + b[0] + c[0]) / 3.0, (a[1] + b[1] + c[1]) / 3.0]
}

pub(crate) fn squared(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
}
