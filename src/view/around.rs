//! The closed surface that holds a point: a box is grown about the point until the surface no longer leaves it.
//!
//! ```text
//! a box of 10⁻⁸ of the coordinates ─▶ sides through which the surface leaves move out ─▶ … ─▶ none: the mesh
//! ```
//!
//! From small to large, since a large box may step over a small surface. Grids are coarse as long as they see the
//! surface near the point.

use super::mesh::{Border, Foot, Function, Mesh, MeshError, cross, dot, length, minus, project};

/// Cells along the longest side of boxes that are tried; more where they miss the surface.
const COARSE: usize = 24;
/// The first box that is tried, in parts of the point's coordinates: so small that nothing else is in it.
const FIRST: f64 = 1e-8;
/// Boxes that are tried, each up to three times as large as the one before: to 10⁶ of the coordinates.
const BOXES: usize = 30;
/// The least step by which a box grows, in parts of it.
const LEAST_STEP: f64 = 0.25;
/// A mesh that passes a point has a vertex within so many cells of it.
const PASSES: f64 = 2.0;
/// The part of triangles that may look another way than their normals: at edges and pinches of a surface some do.
const FOLDED: f64 = 0.05;

impl Mesh {
    /// Meshes the closed surface near this point, such as the start of a motion. A small box is grown until the surface
    /// no longer leaves it; all of {g = 0} inside the box is meshed, with `cells` as for [`Mesh::of`].
    ///
    /// # Errors
    /// As [`Mesh::of`]; [`MeshError::Endless`] where no box holds the surface, [`MeshError::Thin`] where the mesh would
    /// be of pieces, or would not pass the point.
    ///
    /// ```
    /// use rattle::view::{Mesh, surface};
    /// let torus = rattle::surfaces::Torus { major: 1.0, minor: 0.3 };
    /// let mesh = Mesh::around(surface(&torus), [1.3, 0.0, 0.0], 40)?;
    /// assert!(mesh.is_closed() && mesh.euler_characteristic() == 0);
    /// # Ok::<(), rattle::view::MeshError>(())
    /// ```
    pub fn around(
        g: impl Fn([f64; 3]) -> (f64, [f64; 3]),
        near: [f64; 3],
        cells: usize,
    ) -> Result<Self, MeshError> {
        Search::of(&g, near, cells)?.mesh()
    }

    /// Whether a triangle has a corner within this distance of the point.
    fn passes(&self, point: [f64; 3], distance: f64) -> bool {
        let near = |&vertex: &u32| length(minus(self.vertices[vertex as usize], point)) <= distance;
        self.triangles.iter().flatten().any(near)
    }

    /// Whether triangles look another way than ∇g: cells that are too wide join what is apart.
    fn is_folded(&self) -> bool {
        let folded = |corners: &&[u32; 3]| {
            let [a, b, c] = corners.map(|vertex| self.vertices[vertex as usize]);
            let towards = cross(minus(b, a), minus(c, a));
            corners.iter().any(|&vertex| dot(towards, self.normals[vertex as usize]) < 0.0)
        };
        self.triangles.iter().filter(folded).count() as f64 > FOLDED * self.triangles.len() as f64
    }
}

/// A box that grows about a point of the surface.
struct Search<'a> {
    g: Function<'a>,
    start: [f64; 3],
    low: [f64; 3],
    high: [f64; 3],
    /// Cells along the longest side: as few as show the surface near the point. Once a sheet was found to be thin, all
    /// grids are as fine: a coarser one would see a part of it.
    coarse: usize,
    cells: usize,
    /// The last box that showed the surface, and the sides of it that were moved out.
    last: Option<Seen>,
    /// By which part of the box they were: less where the surface was lost.
    by: f64,
}

struct Seen {
    low: [f64; 3],
    high: [f64; 3],
    below: [bool; 3],
    above: [bool; 3],
}

impl<'a> Search<'a> {
    fn of(g: Function<'a>, near: [f64; 3], cells: usize) -> Result<Self, MeshError> {
        let Foot { point: start, .. } = project(g, near, f64::INFINITY)?;
        let size = start.into_iter().fold(0.0, |size: f64, x| size.max(x.abs()));
        let half = FIRST * if size > 0.0 { size } else { 1.0 };
        let (low, high) = (start.map(|x| x - half), start.map(|x| x + half));
        Ok(Self { g, start, low, high, coarse: COARSE.min(cells), cells, last: None, by: 1.0 })
    }

    fn cell(&self) -> f64 {
        minus(self.high, self.low).into_iter().fold(0.0, f64::max) / self.coarse as f64
    }

    fn refine(&mut self) -> bool {
        let finer = self.coarse < self.cells;
        self.coarse = (2 * self.coarse).min(self.cells);
        finer
    }

    /// A smaller step from the last box that showed the surface.
    fn retreat(&mut self) -> bool {
        let Some(Seen { low, high, below, above }) = self.last.take().filter(|_| self.by > LEAST_STEP) else {
            return false;
        };
        (self.low, self.high, self.by) = (low, high, 0.5 * self.by);
        self.grow(below, above);
        true
    }

    fn thin<T>(&self) -> Result<T, MeshError> {
        Err(MeshError::Thin { cell: self.cell(), cells: self.cells })
    }

    fn mesh(mut self) -> Result<Mesh, MeshError> {
        let mut boxes = 0;
        while boxes < BOXES {
            let Some(mesh) = self.sight()? else {
                self.grow([true; 3], [true; 3]);
                self.last = None;
                boxes += 1;
                continue;
            };
            let (mut least, mut most) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
            for &vertex in mesh.triangles.iter().flatten() {
                let vertex = mesh.vertices[vertex as usize];
                (0..3).for_each(|i| (least[i], most[i]) = (least[i].min(vertex[i]), most[i].max(vertex[i])));
            }
            let cell = self.cell();
            let below = [0, 1, 2].map(|i| least[i] < self.low[i] + 1.5 * cell);
            let above = [0, 1, 2].map(|i| most[i] > self.high[i] - 1.5 * cell);
            if below == [false; 3] && above == [false; 3] {
                let [low, high] = [least.map(|x| x - 2.0 * cell), most.map(|x| x + 2.0 * cell)];
                match self.whole(low, high)? {
                    Some(mesh) => return Ok(mesh),
                    None if self.refine() || self.retreat() => continue,
                    None => return self.thin(),
                }
            }
            self.grow(below, above);
            boxes += 1;
        }
        Err(MeshError::Endless { low: self.low, high: self.high })
    }

    /// What the box shows: nothing before the surface was met.
    fn sight(&mut self) -> Result<Option<Mesh>, MeshError> {
        loop {
            match Mesh::net(self.g, self.low, self.high, self.coarse, Border::Open) {
                Ok(mesh) if mesh.passes(self.start, PASSES * self.cell()) => return Ok(Some(mesh)),
                Ok(_) | Err(MeshError::Empty { .. } | MeshError::Thin { .. }) if self.last.is_none() => {
                    return Ok(None);
                }
                // A sheet between two points of the grid.
                Ok(_) | Err(MeshError::Empty { .. } | MeshError::Thin { .. })
                    if self.refine() || self.retreat() => {}
                Ok(mesh) => return Ok(Some(mesh)),
                Err(MeshError::Empty { .. }) => return self.thin(),
                Err(error) => return Err(error),
            }
        }
    }

    /// The mesh with all cells, if it is closed and passes the start.
    fn whole(&self, low: [f64; 3], high: [f64; 3]) -> Result<Option<Mesh>, MeshError> {
        let cell = minus(high, low).into_iter().fold(0.0, f64::max) / self.cells as f64;
        match Mesh::net(self.g, low, high, self.cells, Border::Closed) {
            Ok(mesh) => {
                let whole = mesh.is_closed() && mesh.passes(self.start, PASSES * cell) && !mesh.is_folded();
                Ok(whole.then_some(mesh))
            }
            Err(MeshError::Empty { .. } | MeshError::Thin { .. } | MeshError::Cut { .. }) => Ok(None),
            Err(error) => Err(error),
        }
    }

    fn grow(&mut self, below: [bool; 3], above: [bool; 3]) {
        let sides = minus(self.high, self.low).map(|side| self.by * side);
        self.last = Some(Seen { low: self.low, high: self.high, below, above });
        for i in 0..3 {
            self.low[i] -= if below[i] { sides[i] } else { 0.0 };
            self.high[i] += if above[i] { sides[i] } else { 0.0 };
        }
    }
}
