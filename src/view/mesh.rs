//! The surface {g = 0} as triangles.
//!
//! ```text
//! sample g on a grid  ─surface nets─▶  one vertex per cell that the surface crosses, one quad per crossed grid edge
//!                     ─Newton──────▶  x ← x − g ∇g / |∇g|²   until x lies on the surface
//! ```
//!
//! Surface nets (Gibson 1998) instead of marching cubes: vertices are shared, so the mesh is closed without welding,
//! and triangles are even instead of slivers. `fast-surface-nets` makes the net; Newton's method with ∇g makes it
//! accurate.

use crate::kernel::Constraint;
use crate::vtu::{self, Cells, Field};
use fast_surface_nets::ndshape::{RuntimeShape, Shape};
use fast_surface_nets::{SurfaceNetsBuffer, surface_nets};

/// Steps of Newton's method at most; from within a cell it takes three or four, more where the gradient vanishes.
const NEWTON_STEPS: usize = 30;
/// A vertex is on the surface when the next displacement is below this part of a cell.
const ON_SURFACE: f64 = 1e-9;
/// A vertex whose last displacement was above this part of a cell has found no surface,
const REACHED: f64 = 1e-3;
/// and one that went farther than so many cells has found another part of it.
const ASTRAY: f64 = 3.0;
/// Halvings of an edge between two signs, after which g is below a part of what it was, unless it jumps.
const HALVINGS: usize = 40;
const VANISHED: f64 = 1e-6;

/// x ↦ (g, ∇g).
pub(super) type Function<'a> = &'a dyn Fn([f64; 3]) -> (f64, [f64; 3]);

/// The function x ↦ (g, ∇g) of a constraint, for [`Mesh::of`].
///
/// ```
/// use rattle::view::{Mesh, surface};
/// let torus = rattle::surfaces::Torus { major: 1.0, minor: 0.3 };
/// let half = Mesh::within(surface(&torus), [-1.4, -1.4, 0.0], [1.4, 1.4, 0.4], 40)?;
/// assert!(!half.is_closed());
/// # Ok::<(), rattle::view::MeshError>(())
/// ```
pub fn surface(constraint: &impl Constraint<3, 1>) -> impl Fn([f64; 3]) -> (f64, [f64; 3]) {
    |q| {
        let (g, gradient) = constraint.value_and_jacobian(&q.into());
        (g[0], gradient.row(0).transpose().into())
    }
}

/// Triangles with a normal at each vertex. Seen from the side where g > 0, triangles run counter-clockwise.
///
/// All three lists are public, for a renderer of one's own: vertices are shared and triangles name them by number, as
/// buffers of vertices and of indices do.
///
/// ```
/// # let g = |[x, y, z]: [f64; 3]| (x * x + y * y + z * z - 1.0, [2.0 * x, 2.0 * y, 2.0 * z]);
/// # let mesh = rattle::view::Mesh::of(g, [-1.5; 3], [1.5; 3], 20)?;
/// let places: Vec<[f32; 3]> = mesh.vertices.iter().map(|q| q.map(|x| x as f32)).collect();
/// let normals: Vec<[f32; 3]> = mesh.normals.iter().map(|n| n.map(|x| x as f32)).collect();
/// let indices: &[u32] = mesh.triangles.as_flattened();
/// # assert!(places.len() == normals.len() && indices.iter().all(|&i| (i as usize) < places.len()));
/// # Ok::<(), rattle::view::MeshError>(())
/// ```
#[doc(alias = "triangulation")]
#[doc(alias = "isosurface")]
#[doc(alias = "marching cubes")]
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Points on the surface.
    pub vertices: Vec<[f64; 3]>,
    /// ∇g/|∇g| at each vertex.
    pub normals: Vec<[f64; 3]>,
    /// The three vertices of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Meshes {g = 0} inside the box from `low` to `high` with `cells` grid cells along its longest side.
    ///
    /// `g` returns the value and the gradient. It is evaluated at up to about `cells`³ grid points, and a few times per
    /// vertex; about 100 cells make a smooth picture. Parts of the surface that are less than two cells apart may join.
    ///
    /// # Errors
    /// [`MeshError::Empty`] when g does not change its sign in the box, [`MeshError::Cut`] when the surface leaves the
    /// box, [`MeshError::NotFinite`] when g or ∇g is NaN or infinite at a point, [`MeshError::Box`] for a box without
    /// volume or with too few or too many cells.
    ///
    /// ```
    /// use rattle::view::Mesh;
    /// let sphere = |[x, y, z]: [f64; 3]| (x * x + y * y + z * z - 1.0, [2.0 * x, 2.0 * y, 2.0 * z]);
    /// let mesh = Mesh::of(sphere, [-1.5; 3], [1.5; 3], 20)?;
    /// assert_eq!(mesh.euler_characteristic(), 2);
    /// assert!(mesh.vertices.iter().all(|&q| sphere(q).0.abs() < 1e-12));
    /// # Ok::<(), rattle::view::MeshError>(())
    /// ```
    pub fn of(
        g: impl Fn([f64; 3]) -> (f64, [f64; 3]),
        low: [f64; 3],
        high: [f64; 3],
        cells: usize,
    ) -> Result<Self, MeshError> {
        Self::net(&g, low, high, cells, Border::Closed)
    }

    /// As [`Mesh::of`], but open where the box cuts the surface: for infinite surfaces.
    ///
    /// # Errors
    /// As [`Mesh::of`], without [`MeshError::Cut`].
    ///
    /// ```
    /// use rattle::view::Mesh;
    /// let cylinder = |[x, y, _]: [f64; 3]| (x * x + y * y - 1.0, [2.0 * x, 2.0 * y, 0.0]);
    /// assert!(Mesh::of(cylinder, [-1.5; 3], [1.5; 3], 20).is_err());
    /// assert!(!Mesh::within(cylinder, [-1.5; 3], [1.5; 3], 20)?.is_closed());
    /// # Ok::<(), rattle::view::MeshError>(())
    /// ```
    pub fn within(
        g: impl Fn([f64; 3]) -> (f64, [f64; 3]),
        low: [f64; 3],
        high: [f64; 3],
        cells: usize,
    ) -> Result<Self, MeshError> {
        Self::net(&g, low, high, cells, Border::Open)
    }

    pub(super) fn net(
        g: Function,
        low: [f64; 3],
        high: [f64; 3],
        cells: usize,
        border: Border,
    ) -> Result<Self, MeshError> {
        let grid = Grid::new(low, high, cells)?;
        let net = grid.net(&grid.sample(g, border)?);
        let mut mesh = Self { vertices: Vec::new(), normals: Vec::new(), triangles: Vec::new() };
        // Where g changes its sign at a pole there is no surface to reach.
        let mut kept = Vec::with_capacity(net.positions.len());
        for &[i, j, k] in &net.positions {
            let start = grid.point([i, j, k].map(f64::from));
            let foot = project(g, start, grid.cell)?;
            let foot = if foot.is_near(start, grid.cell) { Some(foot) } else { grid.root(g, start)? };
            kept.push(foot.as_ref().map(|_| mesh.vertices.len() as u32));
            mesh.vertices.extend(foot.as_ref().map(|foot| foot.point));
            mesh.normals.extend(foot.map(|foot| foot.normal));
        }
        let triangles =
            net.indices.as_chunks().0.iter().map(|corners| corners.map(|vertex| kept[vertex as usize]));
        mesh.triangles = triangles.filter_map(|[a, b, c]| Some([a?, b?, c?])).collect();
        mesh.drop_slivers(1e-6 * grid.cell);
        if mesh.triangles.is_empty() {
            return Err(MeshError::Thin { cell: grid.cell, cells });
        }
        Ok(mesh)
    }

    /// V − E + F: 2 for a sphere, 0 for a torus, 2 − 2n for a surface of genus n.
    ///
    /// ```
    /// let ring = |[x, y, z]: [f64; 3]| {
    ///     let (rho, r) = (x.hypot(y), 0.4);
    ///     let d = 2.0 * (rho - 1.0) / rho;
    ///     ((rho - 1.0).powi(2) + z * z - r * r, [d * x, d * y, 2.0 * z])
    /// };
    /// # let ring = |q: [f64; 3]| if q[0] == 0.0 && q[1] == 0.0 { (1.0, [0.0; 3]) } else { ring(q) };
    /// let torus = rattle::view::Mesh::of(ring, [-1.6, -1.6, -0.6], [1.6, 1.6, 0.6], 30)?;
    /// assert_eq!(torus.euler_characteristic(), 0);
    /// # Ok::<(), rattle::view::MeshError>(())
    /// ```
    pub fn euler_characteristic(&self) -> isize {
        let mut used = vec![false; self.vertices.len()];
        self.triangles.iter().flatten().for_each(|&vertex| used[vertex as usize] = true);
        let vertices = used.iter().filter(|&&used| used).count();
        let mut edges = self.edges();
        edges.dedup();
        vertices as isize - edges.len() as isize + self.triangles.len() as isize
    }

    /// Whether every edge belongs to exactly two triangles, which run along it in opposite directions: a closed,
    /// oriented surface.
    ///
    /// ```
    /// use rattle::view::Mesh;
    /// let sphere = |[x, y, z]: [f64; 3]| (x * x + y * y + z * z - 1.0, [2.0 * x, 2.0 * y, 2.0 * z]);
    /// let mut mesh = Mesh::of(sphere, [-1.5; 3], [1.5; 3], 20)?;
    /// assert!(mesh.is_closed());
    /// mesh.triangles.pop();
    /// assert!(!mesh.is_closed());
    /// # Ok::<(), rattle::view::MeshError>(())
    /// ```
    pub fn is_closed(&self) -> bool {
        let mut directed: Vec<[u32; 2]> =
            self.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        directed.sort_unstable();
        let once = directed.windows(2).all(|pair| pair[0] != pair[1]);
        once && !directed.is_empty() && directed.iter().all(|&[a, b]| directed.binary_search(&[b, a]).is_ok())
    }

    /// The volume that a closed mesh encloses; negative where g > 0 inside.
    ///
    /// ```
    /// let sphere = |[x, y, z]: [f64; 3]| (x * x + y * y + z * z - 1.0, [2.0 * x, 2.0 * y, 2.0 * z]);
    /// let mesh = rattle::view::Mesh::of(sphere, [-1.5; 3], [1.5; 3], 60)?;
    /// assert!((mesh.volume() - 4.0 / 3.0 * std::f64::consts::PI).abs() < 0.01);
    /// # Ok::<(), rattle::view::MeshError>(())
    /// ```
    pub fn volume(&self) -> f64 {
        // From a vertex: far from the origin all digits would cancel.
        let from = self.triangles.first().map_or([0.0; 3], |corners| self.vertices[corners[0] as usize]);
        let corner = |vertex: u32| minus(self.vertices[vertex as usize], from);
        self.triangles.iter().map(|&[a, b, c]| dot(corner(a), cross(corner(b), corner(c))) / 6.0).sum()
    }

    /// The mesh with its normals for ParaView, as the text of a `.vtu` file; see [`vtu`](crate::vtu).
    ///
    /// ```
    /// use rattle::view::Mesh;
    /// let sphere = |[x, y, z]: [f64; 3]| (x * x + y * y + z * z - 1.0, [2.0 * x, 2.0 * y, 2.0 * z]);
    /// assert!(Mesh::of(sphere, [-1.5; 3], [1.5; 3], 20)?.to_vtu().contains("Name=\"normal\""));
    /// # Ok::<(), rattle::view::MeshError>(())
    /// ```
    #[must_use]
    pub fn to_vtu(&self) -> String {
        let normals = Field::vector("normal", &self.normals);
        vtu::text(&self.vertices, &Cells::Triangles(&self.triangles), &[normals], &[])
    }

    /// Every edge of every triangle, lower vertex first, sorted.
    fn edges(&self) -> Vec<[u32; 2]> {
        let ordered = |a: u32, b: u32| [a.min(b), a.max(b)];
        let mut edges: Vec<[u32; 2]> = self
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [ordered(a, b), ordered(b, c), ordered(c, a)])
            .collect();
        edges.sort_unstable();
        edges
    }

    /// Merges vertices nearer than `distance` along an edge, so that no triangle is degenerate and no hole opens.
    fn drop_slivers(&mut self, distance: f64) {
        let mut same: Vec<u32> = (0..self.vertices.len() as u32).collect();
        let first = |same: &[u32], mut vertex: u32| {
            while same[vertex as usize] != vertex {
                vertex = same[vertex as usize];
            }
            vertex
        };
        for [a, b] in self.edges() {
            if length(minus(self.vertices[a as usize], self.vertices[b as usize])) < distance {
                let [a, b] = [a, b].map(|vertex| first(&same, vertex));
                same[a.max(b) as usize] = a.min(b);
            }
        }
        for triangle in &mut self.triangles {
            *triangle = triangle.map(|vertex| first(&same, vertex));
        }
        self.triangles.retain(|&[a, b, c]| a != b && b != c && c != a);
    }
}

/// Whether a surface may leave the box.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Border {
    Closed,
    Open,
}

/// A grid of points: `count` along each side, `cell` apart.
struct Grid {
    low: [f64; 3],
    cell: f64,
    count: [u32; 3],
}

impl Grid {
    fn new(low: [f64; 3], high: [f64; 3], cells: usize) -> Result<Self, MeshError> {
        let sides = minus(high, low);
        let longest = sides.into_iter().fold(0.0, f64::max);
        let proper = sides.iter().all(|side| side.is_finite() && *side > 0.0);
        if !proper || !(4..=600).contains(&cells) {
            return Err(MeshError::Box { low, high, cells });
        }
        let cell = longest / cells as f64;
        // Cubic cells; the box grows about its middle to whole ones.
        let count = sides.map(|side| (side / cell - 1e-9).ceil().max(2.0) as u32 + 1);
        let low = [0, 1, 2].map(|i| 0.5 * (low[i] + high[i] - f64::from(count[i] - 1) * cell));
        Ok(Self { low, cell, count })
    }

    fn point(&self, index: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|i| self.low[i] + self.cell * index[i])
    }

    fn shape(&self) -> RuntimeShape<u32, 3> {
        RuntimeShape::<u32, 3>::new(self.count)
    }

    /// g at every point, first coordinate fastest, as single precision: the net needs the sign and roughly the size.
    fn sample(&self, g: Function, border_is: Border) -> Result<Vec<f32>, MeshError> {
        let shape = self.shape();
        let mut values = Vec::with_capacity(shape.usize());
        let (mut inside, mut border) = ([false; 2], [None; 2]);
        for n in 0..shape.size() {
            let index = shape.delinearize(n);
            let point = self.point(index.map(f64::from));
            let value = g(point).0;
            if !value.is_finite() {
                return Err(MeshError::NotFinite { point, value });
            }
            let side = usize::from(value < 0.0);
            inside[side] = true;
            if (0..3).any(|i| index[i] == 0 || index[i] + 1 == self.count[i]) {
                border[side].get_or_insert((point, value));
            }
            values.push(value);
        }
        if inside != [true; 2] {
            return Err(MeshError::Empty { positive: inside[0] });
        }
        if border_is == Border::Closed
            && let [Some((above, _)), Some((below, _))] = border
        {
            return Err(MeshError::Cut { above, below });
        }
        // Scaled so that neither huge nor tiny g leaves the range of f32; the sign is kept.
        let scale = values.iter().fold(0.0, |size: f64, value| size.max(value.abs()));
        let single = |value: f64| {
            let value_f32 = (value / scale) as f32;
            if value < 0.0 && value_f32 == 0.0 { -f32::MIN_POSITIVE } else { value_f32 }
        };
        Ok(values.into_iter().map(single).collect())
    }

    /// The root on an edge of the cell that holds this point that is nearest to the point: by halving, where Newton's
    /// method goes astray. There is none if g changes its sign by jumps alone.
    fn root(&self, g: Function, start: [f64; 3]) -> Result<Option<Foot>, MeshError> {
        let first = [0, 1, 2].map(|i| ((start[i] - self.low[i]) / self.cell).floor());
        let corner = |bits: usize| self.point([0, 1, 2].map(|i| first[i] + (bits >> i & 1) as f64));
        let mut best: Option<[f64; 3]> = None;
        for (bits, axis) in
            (0..8).flat_map(|bits| [(bits, 1), (bits, 2), (bits, 4)]).filter(|(n, axis)| n & axis == 0)
        {
            let [mut a, mut b] = [corner(bits), corner(bits | axis)];
            let [below, above] = [g(a).0, g(b).0];
            if (below < 0.0) == (above < 0.0) {
                continue;
            }
            for _ in 0..HALVINGS {
                let middle = [0, 1, 2].map(|i| 0.5 * (a[i] + b[i]));
                *if (g(middle).0 < 0.0) == (below < 0.0) { &mut a } else { &mut b } = middle;
            }
            let vanished = g(a).0.abs().max(g(b).0.abs()) <= VANISHED * below.abs().max(above.abs());
            let nearer = best.is_none_or(|best| length(minus(a, start)) < length(minus(best, start)));
            best = if vanished && nearer { Some(a) } else { best };
        }
        best.map(|point| project(g, point, 0.0)).transpose()
    }

    fn net(&self, values: &[f32]) -> SurfaceNetsBuffer {
        let mut net = SurfaceNetsBuffer::default();
        surface_nets(values, &self.shape(), [0; 3], self.count.map(|n| n - 1), &mut net);
        net
    }
}

/// A point of the surface.
pub(super) struct Foot {
    pub(super) point: [f64; 3],
    /// The unit normal there.
    normal: [f64; 3],
    /// The last displacement; infinite where it was cut.
    off: f64,
}

impl Foot {
    fn is_near(&self, start: [f64; 3], cell: f64) -> bool {
        self.off <= REACHED * cell && length(minus(self.point, start)) <= ASTRAY * cell
    }
}

/// The point of the surface near `start`, by Newton's method along the gradient. A step is at most a cell, so that no
/// vertex flies off; where the gradient vanishes, at a pinch, the vertex stays.
pub(super) fn project(g: Function, start: [f64; 3], cell: f64) -> Result<Foot, MeshError> {
    let mut foot = Foot { point: start, normal: [0.0, 0.0, 1.0], off: 0.0 };
    for _ in 0..NEWTON_STEPS {
        let (value, gradient) = g(foot.point);
        let slope = length(gradient);
        if !(value.is_finite() && slope.is_finite()) {
            return Err(MeshError::NotFinite { point: foot.point, value });
        }
        if slope == 0.0 {
            foot.off = 0.0;
            break;
        }
        foot.normal = gradient.map(|component| component / slope);
        let step = (value / slope).clamp(-cell, cell);
        foot.off = if step.abs() < cell { step.abs() } else { f64::INFINITY };
        foot.point = [0, 1, 2].map(|i| foot.point[i] - step * foot.normal[i]);
        let size = foot.point.into_iter().fold(step.abs(), |size: f64, x| size.max(x.abs()));
        if step.abs() <= ON_SURFACE * if cell.is_finite() { cell } else { size } {
            break;
        }
    }
    Ok(foot)
}

pub(super) fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] - b[i])
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn length([x, y, z]: [f64; 3]) -> f64 {
    x.hypot(y).hypot(z)
}

/// What can go wrong with a mesh.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// g has one sign at all grid points.
    #[error("no surface in the box: g is {} at every grid point; try a larger box or more cells", if *positive { "≥ 0" } else { "< 0" })]
    Empty {
        /// Whether g ≥ 0.
        positive: bool,
    },
    /// The surface leaves the box.
    #[error(
        "the box cuts the surface: on its border g ≥ 0 at {above:?} and g < 0 at {below:?}; try a larger box"
    )]
    Cut {
        /// A point of the border where g ≥ 0.
        above: [f64; 3],
        /// A point of the border where g < 0.
        below: [f64; 3],
    },
    /// No box holds the surface.
    #[error(
        "the surface leaves even the box from {low:?} to {high:?}; mesh a part of it with `Mesh::within`"
    )]
    Endless {
        /// Lowest corner.
        low: [f64; 3],
        /// Highest corner.
        high: [f64; 3],
    },
    /// The surface is thinner than a cell, or g changes its sign at a pole alone.
    #[error(
        "no whole surface is seen with cells of {cell:e}: it is thinner, or g changes its sign at poles; try more than {cells} cells, or a smaller box"
    )]
    Thin {
        /// The side of a cell.
        cell: f64,
        /// Cells along the longest side.
        cells: usize,
    },
    /// g or its gradient is NaN or infinite.
    #[error(
        "g or its gradient is not finite at {point:?}, where g = {value:e}; try a box that avoids that point"
    )]
    NotFinite {
        /// Where.
        point: [f64; 3],
        /// g there.
        value: f64,
    },
    /// A radius within which points are counted that is not a positive number.
    #[error("points are counted within a positive radius, not {0}")]
    Radius(f64),
    /// The box has no volume, or the number of cells is out of range.
    #[error("can't lay {cells} cells (4 to 600) along a box from {low:?} to {high:?}")]
    Box {
        /// Lowest corner.
        low: [f64; 3],
        /// Highest corner.
        high: [f64; 3],
        /// Cells asked for along the longest side.
        cells: usize,
    },
}

debug_as_display!(MeshError);
