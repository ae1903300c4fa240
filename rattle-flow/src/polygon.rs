//! The mesh of a polygon: a lattice of equilateral triangles inside, a Delaunay triangulation with the boundary kept.

use crate::error::MeshError;
use crate::mesh::Mesh;
use crate::outline::{Outline, to_segment};
use crate::plane::squared;
use spade::handles::FixedVertexHandle;
use spade::{AngleLimit, ConstrainedDelaunayTriangulation, Point2, RefinementParameters, Triangulation};

/// Points of the lattice stay this far from the boundary, in spacings: 0.5 is where triangles between get too flat.
const MARGIN: f64 = 0.55;
/// More points are a slip of the spacing.
const MOST: f64 = 2e7;
/// The smallest spacing, and the largest coordinate: beyond them numbers of the triangulation may overflow.
const SIZES: [f64; 2] = [1e-12, 1e30];

impl Mesh {
    /// The mesh of a simple polygon, with edges of about the length `spacing`.
    ///
    /// The sides of the polygon are divided evenly. Inside, angles of triangles are 60°, and 30° or more where points
    /// could be added. Beside the sides, which are not divided further, they may be smaller: 24.7° is the least in 180
    /// turned rectangles. Small angles of the polygon stay.
    ///
    /// Corners may go around either way. A corner that is the one before it once more is left out, so that rings which
    /// are closed by their first corner are taken as they are.
    ///
    /// ```
    /// use rattle_flow::Mesh;
    /// let mesh = Mesh::polygon(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]], 0.1)?;
    /// assert!((mesh.area() - 2.0).abs() < 1e-12);
    /// # Ok::<(), rattle_flow::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// [`MeshError::SidesMeet`]: sides that cross or touch. [`MeshError::Polygon`]: fewer than three corners, corners
    /// on one line, or a spacing that is not positive or asks for more than twenty million points.
    pub fn polygon(corners: &[[f64; 2]], spacing: f64) -> Result<Mesh, MeshError> {
        let wrong = |reason| MeshError::Polygon { corners: corners.len(), spacing, reason };
        let named = distinct(corners);
        let corners: Vec<[f64; 2]> = named.iter().map(|&corner| corners[corner]).collect();
        let corners = &corners[..];
        if corners.len() < 3 || !corners.iter().flatten().all(|x| x.is_finite()) {
            return Err(wrong("it needs three finite corners or more"));
        }
        if flat(corners) {
            return Err(wrong("its corners lie on one line"));
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
        let farthest = corners.iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
        if spacing < SIZES[0] || farthest > SIZES[1] {
            return Err(wrong("lengths have to be between 1e-12 and 1e30; take another unit"));
        }
        let rounded = f64::EPSILON * farthest;
        if spacing < 64.0 * rounded {
            return Err(wrong("its coordinates are too large to tell points apart at this spacing"));
        }
        let outline = Outline::of(corners, &named, spacing, rounded);
        outline.distinct()?;
        let mut points = outline.points.clone();
        let rim: Vec<[usize; 2]> = (0..points.len()).map(|i| [i, outline.next(i)]).collect();
        points.extend(lattice(corners, spacing, low, high));
        let vertices = points.iter().map(|&[x, y]| Point2::new(x, y)).collect();
        let conflict = std::cell::Cell::new(None);
        let mut net =
            Net::try_bulk_load_cdt(vertices, rim.clone(), |ends| conflict.set(Some(outline.part(ends))))
                .map_err(|_| wrong("the triangulation failed"))?;
        // A part that goes through a point of another is not there as it is.
        let lacks = |[from, to]: [usize; 2]| !net.exists_constraint(handle(from), handle(to));
        let split = || rim.iter().position(|&part| lacks(part));
        if let Some(part) = conflict.get().or_else(split) {
            return Err(outline.meeting(part));
        }
        // Parts that touch but for rounding are told before points are added, which asks for triangles that are not
        // flat.
        let meshed = |net: &Net| {
            let triangles = inner(net);
            let (points, numbered) = used(net, &triangles);
            Mesh::new(points, numbered).map_err(|error| match error {
                MeshError::Hanging { from, to, .. } => outline.meeting(outline.part([from, to])),
                MeshError::Seam { first, .. } => outline.meeting(first),
                MeshError::Inverted { triangle, .. } => outline.nearest(triangles[triangle]).unwrap_or(error),
                other => other,
            })
        };
        meshed(&net)?;
        net.refine(
            RefinementParameters::new()
                .keep_constraint_edges()
                .exclude_outer_faces(true)
                .with_angle_limit(AngleLimit::from_deg(30.0)),
        );
        meshed(&net)
    }
}

type Net = ConstrainedDelaunayTriangulation<Point2<f64>>;

fn handle(vertex: usize) -> FixedVertexHandle {
    FixedVertexHandle::from_index(vertex)
}

/// The triangles inside: those that are not reached from outside without going over a side of the polygon.
///
/// The points of a slanted side are on one line but for rounding. Between some of them and the convex hull are flat
/// triangles, which a test of their centroids takes for inside or outside by chance.
fn inner(net: &Net) -> Vec<[u32; 3]> {
    let mut outside = vec![false; net.num_all_faces()];
    let mut entered: Vec<_> = net.convex_hull().map(|edge| edge.rev()).collect();
    while let Some(edge) = entered.pop() {
        let Some(face) = edge.face().as_inner().filter(|_| !edge.is_constraint_edge()) else { continue };
        if !std::mem::replace(&mut outside[face.fix().index()], true) {
            entered.extend(face.adjacent_edges().map(|edge| edge.rev()));
        }
    }
    let faces = net.inner_faces().filter(|face| !outside[face.fix().index()]);
    let mut triangles: Vec<[u32; 3]> =
        faces.map(|face| face.vertices().map(|v| v.fix().index() as u32)).collect();
    // Vertices come row by row of the lattice. So do triangles then: assembly on 10⁵ takes a fifth less time.
    triangles.sort_by_key(|corners| corners.iter().min().copied());
    triangles
}

/// The points of triangles, and the triangles with these numbers. Refinement may add a point outside, where the centre
/// of a circle is on an edge there.
fn used(net: &Net, triangles: &[[u32; 3]]) -> (Vec<[f64; 2]>, Vec<[u32; 3]>) {
    let mut is_used = vec![false; net.num_vertices()];
    triangles.iter().flatten().for_each(|&vertex| is_used[vertex as usize] = true);
    let (mut points, mut numbers) = (Vec::new(), Vec::new());
    for (vertex, used) in net.vertices().zip(is_used) {
        numbers.push(points.len() as u32);
        if used {
            points.push([vertex.position().x, vertex.position().y]);
        }
    }
    (points, triangles.iter().map(|corners| corners.map(|vertex| numbers[vertex as usize])).collect())
}

/// The numbers of the corners, without those that are the one before them once more.
fn distinct(corners: &[[f64; 2]]) -> Vec<usize> {
    let mut named: Vec<usize> = (0..corners.len()).collect();
    named.dedup_by_key(|corner| corners[*corner]);
    while named.len() > 1 && corners[named[0]] == corners[named[named.len() - 1]] {
        named.pop();
    }
    named
}

/// Whether all corners are on the line from the first one to the one farthest from it, but for rounding.
fn flat(corners: &[[f64; 2]]) -> bool {
    let away = |corner: &[f64; 2]| [corner[0] - corners[0][0], corner[1] - corners[0][1]];
    let length = |[x, y]: [f64; 2]| x.hypot(y);
    let farthest = corners.iter().map(away).fold([0.0; 2], |a, b| if length(b) > length(a) { b } else { a });
    let size = length(farthest);
    corners.iter().map(away).all(|[x, y]| {
        (x / size * (farthest[1] / size) - y / size * (farthest[0] / size)).abs() <= 4.0 * f64::EPSILON
    })
}

fn bounds(corners: &[[f64; 2]]) -> [[f64; 2]; 2] {
    let fold = |start: f64, better: fn(f64, f64) -> f64| {
        [0, 1].map(|i| corners.iter().map(|corner| corner[i]).fold(start, better))
    };
    [fold(f64::INFINITY, f64::min), fold(f64::NEG_INFINITY, f64::max)]
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
    let to_side = |i: usize| to_segment(point, [corners[i], corners[(i + 1) % corners.len()]]).0;
    (0..corners.len()).map(to_side).fold(f64::INFINITY, f64::min)
}
