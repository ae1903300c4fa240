//! Meshes of triangles in the plane.

use crate::error::{FlowError, MeshError, one_for_each_vertex};
use crate::overlap::{Boundary, Over};
use crate::plane::{centroid, signed_area, squared};
use std::collections::HashMap;

/// A vertex of the boundary that is nearer to an edge, or to a vertex, than this part of the edge is meant to be on
/// it …
const NEAR: f64 = 1e-9;
/// … and one that is nearer than so many roundings of the coordinates: both may come from a slanted line.
const ROUNDED: f64 = 4.0;

/// What a boundary must not have: a vertex inside of an edge, or two vertices at one place.
enum Torn {
    Hanging([u32; 2], u32),
    Seam(u32, u32),
}

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
    /// Any [`MeshError`] except `Polygon` and `SidesMeet`: the first one found, with its position.
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
        match mesh.torn() {
            Some(Torn::Hanging([from, to], vertex)) => {
                let triangle = sides[&[from, to]];
                let [from, to, vertex] = [from, to, vertex].map(|v| v as usize);
                Err(MeshError::Hanging { vertex, from, to, triangle })
            }
            Some(Torn::Seam(one, other)) => {
                let [x, y] = mesh.points[one as usize];
                let (first, second) = (one.min(other) as usize, one.max(other) as usize);
                Err(MeshError::Seam { first, second, x, y })
            }
            None => match mesh.over() {
                Some(Over { triangles, place: [x, y] }) => {
                    let [first, second] = [triangles[0].min(triangles[1]), triangles[0].max(triangles[1])];
                    Err(MeshError::Over { first: first as usize, second: second as usize, x, y })
                }
                None => Ok(mesh),
            },
        }
    }

    /// Where the boundary has a vertex inside of an edge, or two vertices at one place: nearer than a part of the edge,
    /// or than coordinates are rounded. Vertices are looked up by cells a little larger than the longest edge.
    fn torn(&self) -> Option<Torn> {
        let ends = |[a, b]: [u32; 2]| [self.points[a as usize], self.points[b as usize]];
        let lengths = self.boundary.iter().map(|&edge| squared(ends(edge)[0], ends(edge)[1]));
        let size = 1.000_001 * lengths.fold(0.0, f64::max).sqrt();
        let cell = |[x, y]: [f64; 2]| [(x / size).floor() as i64, (y / size).floor() as i64];
        let mut cells: HashMap<[i64; 2], Vec<u32>> = HashMap::new();
        for &[from, _] in &self.boundary {
            cells.entry(cell(self.points[from as usize])).or_default().push(from);
        }
        for &edge in &self.boundary {
            let [a, b] = ends(edge);
            let [i, j] = cell(a);
            let length = squared(a, b).sqrt();
            let largest = [a, b].into_iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
            let near = NEAR * length + ROUNDED * f64::EPSILON * largest;
            for cell in (-1..=1).flat_map(|di| (-1..=1).map(move |dj| [i + di, j + dj])) {
                for &vertex in cells.get(&cell).into_iter().flatten().filter(|vertex| !edge.contains(vertex))
                {
                    let place = self.points[vertex as usize];
                    for (end, at) in edge.into_iter().zip([a, b]) {
                        if squared(place, at).sqrt() <= near {
                            return Some(Torn::Seam(end, vertex));
                        }
                    }
                    let [x, y] = [place[0] - a[0], place[1] - a[1]];
                    let along = (x * (b[0] - a[0]) + y * (b[1] - a[1])) / length;
                    let aside = (x * (b[1] - a[1]) - y * (b[0] - a[0])) / length;
                    if along > 0.0 && along < length && aside.abs() <= near {
                        return Some(Torn::Hanging(edge, vertex));
                    }
                }
            }
        }
        None
    }

    /// Where two triangles lie over each other, whose boundary is not [torn](Self::torn).
    fn over(&self) -> Option<Over> {
        let Self { points, triangles, boundary, at_boundary, .. } = self;
        Boundary { points, triangles, edges: boundary, at: at_boundary }.over()
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
