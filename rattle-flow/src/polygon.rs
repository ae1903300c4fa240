//! The mesh of a polygon: a lattice of equilateral triangles inside, a Delaunay triangulation with the boundary kept.

use crate::error::MeshError;
use crate::mesh::{Mesh, centroid, squared};
use spade::{AngleLimit, ConstrainedDelaunayTriangulation, Point2, RefinementParameters, Triangulation};

/// Points of the lattice stay this far from the boundary, in spacings: 0.5 is where triangles between get too flat.
const MARGIN: f64 = 0.55;
/// More points are a slip of the spacing.
const MOST: f64 = 2e7;

impl Mesh {
    /// The mesh of a simple polygon, with edges of about the length `spacing`.
    ///
    /// The edges of the polygon are divided evenly. Angles of triangles are at least 30° if those of the polygon are.
    ///
    /// ```
    /// use rattle_flow::Mesh;
    /// let mesh = Mesh::polygon(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]], 0.1)?;
    /// assert!((mesh.area() - 2.0).abs() < 1e-12);
    /// # Ok::<(), rattle_flow::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// [`MeshError::Polygon`]: fewer than three corners, crossing edges, or a spacing that is not positive or asks for
    /// more than twenty million points.
    pub fn polygon(corners: &[[f64; 2]], spacing: f64) -> Result<Mesh, MeshError> {
        let wrong = |reason| MeshError::Polygon { corners: corners.len(), spacing, reason };
        if corners.len() < 3 || !corners.iter().flatten().all(|x| x.is_finite()) {
            return Err(wrong("it needs three finite corners or more"));
        }
        let [low, high] = bounds(corners);
        let [wide, tall] = [0, 1].map(|x| (high[x] - low[x]) / spacing + 2.0);
        let around = (0..corners.len()).map(|i| squared(corners[i], corners[(i + 1) % corners.len()]).sqrt());
        let too_many = wide * tall > MOST || around.sum::<f64>() / spacing > MOST;
        if spacing.is_nan() || spacing <= 0.0 || too_many {
            return Err(wrong(
                "the spacing has to be positive, and not so small that there are millions of points",
            ));
        }
        let mut points = outline(corners, spacing);
        let rim: Vec<[usize; 2]> = (0..points.len()).map(|i| [i, (i + 1) % points.len()]).collect();
        points.extend(lattice(corners, spacing, low, high));
        let vertices = points.iter().map(|&[x, y]| Point2::new(x, y)).collect();
        let conflicts = std::cell::Cell::new(false);
        let mut net =
            ConstrainedDelaunayTriangulation::<Point2<f64>>::try_bulk_load_cdt(vertices, rim, |_| {
                conflicts.set(true);
            })
            .map_err(|_| wrong("the triangulation failed"))?;
        if conflicts.get() {
            return Err(wrong("its edges cross"));
        }
        net.refine(
            RefinementParameters::new()
                .keep_constraint_edges()
                .exclude_outer_faces(true)
                .with_angle_limit(AngleLimit::from_deg(30.0)),
        );
        let points: Vec<[f64; 2]> = net.vertices().map(|v| [v.position().x, v.position().y]).collect();
        let triangles: Vec<[u32; 3]> =
            net.inner_faces().map(|face| face.vertices().map(|v| v.fix().index() as u32)).collect();
        let inside =
            |corners_of: &[u32; 3]| within(corners, centroid(corners_of.map(|v| points[v as usize])));
        let mut triangles: Vec<[u32; 3]> = triangles.into_iter().filter(inside).collect();
        // Vertices come row by row of the lattice. So do triangles then: assembly on 10⁵ takes a fifth less time.
        triangles.sort_by_key(|corners| corners.iter().min().copied());
        Mesh::new(points, triangles)
    }
}

fn bounds(corners: &[[f64; 2]]) -> [[f64; 2]; 2] {
    let fold = |start: f64, better: fn(f64, f64) -> f64| {
        [0, 1].map(|i| corners.iter().map(|corner| corner[i]).fold(start, better))
    };
    [fold(f64::INFINITY, f64::min), fold(f64::NEG_INFINITY, f64::max)]
}

/// The edges of the polygon, divided.
fn outline(corners: &[[f64; 2]], spacing: f64) -> Vec<[f64; 2]> {
    let mut points = Vec::new();
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let parts = (squared(a, b).sqrt() / spacing - 1e-9).ceil().max(1.0) as usize;
        for k in 0..parts {
            let s = k as f64 / parts as f64;
            points.push([a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])]);
        }
    }
    points
}

/// The points of a lattice of equilateral triangles well inside the polygon.
fn lattice(corners: &[[f64; 2]], spacing: f64, low: [f64; 2], high: [f64; 2]) -> Vec<[f64; 2]> {
    let row = spacing * 0.75_f64.sqrt();
    let rows = ((high[1] - low[1]) / row) as usize + 1;
    let columns = ((high[0] - low[0]) / spacing) as usize + 2;
    let mut points = Vec::new();
    for j in 0..=rows {
        let y = low[1] + (j as f64 + 0.5) * row;
        for i in 0..=columns {
            let x = low[0] + (i as f64 + if j % 2 == 0 { 0.25 } else { 0.75 }) * spacing;
            if within(corners, [x, y]) && distance(corners, [x, y]) > MARGIN * spacing {
                points.push([x, y]);
            }
        }
    }
    points
}

/// Whether a point is inside, by the edges that a ray crosses.
fn within(corners: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let mut inside = false;
    for (i, &[ax, ay]) in corners.iter().enumerate() {
        let [bx, by] = corners[(i + 1) % corners.len()];
        if (ay > y) != (by > y) && x < ax + (y - ay) * (bx - ax) / (by - ay) {
            inside = !inside;
        }
    }
    inside
}

fn distance(corners: &[[f64; 2]], point: [f64; 2]) -> f64 {
    let to_edge = |i: usize| {
        let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
        let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        let s = (((point[0] - a[0]) * dx + (point[1] - a[1]) * dy) / squared(a, b)).clamp(0.0, 1.0);
        squared(point, [a[0] + s * dx, a[1] + s * dy])
    };
    (0..corners.len()).map(to_edge).fold(f64::INFINITY, f64::min).sqrt()
}
