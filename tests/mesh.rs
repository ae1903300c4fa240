//! Meshes: closed, of the right topology, on the surface, wound and lit the right way; and typed errors.

use rattle::view::{Mesh, MeshError, surface};

type Point = [f64; 3];
type Region = (Point, Point);
type Surface = fn(Point) -> (f64, Point);

fn sphere([x, y, z]: Point) -> (f64, Point) {
    (x * x + y * y + z * z - 1.0, [2.0 * x, 2.0 * y, 2.0 * z])
}

fn hollow(q: Point) -> (f64, Point) {
    let (g, gradient) = sphere(q);
    (-g, gradient.map(|component| -component)) // negative outside
}

fn torus([x, y, z]: Point) -> (f64, Point) {
    let s = x * x + y * y + z * z + 1.0 - 0.16;
    (s * s - 4.0 * (x * x + y * y), [4.0 * s * x - 8.0 * x, 4.0 * s * y - 8.0 * y, 4.0 * s * z])
}

fn lemniscate([x, y, z]: Point) -> (f64, Point) {
    let s = x * x + y * y;
    let f = s * s - (x * x - y * y);
    let gradient = [2.0 * f * (4.0 * s * x - 2.0 * x), 2.0 * f * (4.0 * s * y + 2.0 * y), 2.0 * z];
    (f * f + z * z - 1.0 / 36.0, gradient)
}

fn scaled_up(q: Point) -> (f64, Point) {
    let (g, gradient) = lemniscate(q);
    (g * 1e60, gradient.map(|component| component * 1e60)) // far above it
}

fn scaled_down(q: Point) -> (f64, Point) {
    let (g, gradient) = lemniscate(q);
    (g * 1e-60, gradient.map(|component| component * 1e-60)) // far below the range of f32
}

const EYE: Region = ([-1.2, -0.6, -0.3], [1.2, 0.6, 0.3]);

#[test]
fn meshes_are_closed_and_lie_on_the_surface() {
    #[rustfmt::skip]
    let cases: [(&str, Surface, Region, usize, isize, f64); 10] = [
        // name              g            box                                  cells  V−E+F  volume's sign
        ("sphere",           sphere,      ([-1.5; 3], [1.5; 3]),                 32,    2,  1.0),
        ("tight box",        sphere,      ([-1.01; 3], [1.01; 3]),               31,    2,  1.0),
        ("off-centre",       sphere,      ([-1.1, -1.7, -1.03], [1.9, 1.2, 2.3]), 40,   2,  1.0),
        ("hollow",           hollow,      ([-1.5; 3], [1.5; 3]),                 32,    2, -1.0),
        ("torus",            torus,       ([-1.6, -1.6, -0.6], [1.6, 1.6, 0.6]), 40,    0,  1.0),
        ("lemniscate",       lemniscate,  EYE,                                   48,   -2,  1.0),
        ("fine lemniscate",  lemniscate,  EYE,                                  112,   -2,  1.0),
        ("grid on symmetry", lemniscate,  EYE,                                   96,   -2,  1.0),
        ("huge g",           scaled_up,   EYE,                                   48,   -2,  1.0),
        ("tiny g",           scaled_down, EYE,                                   48,   -2,  1.0),
    ];
    for (name, g, (low, high), cells, euler, sign) in cases {
        let mesh = Mesh::of(g, low, high, cells).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(mesh.triangles.len() > 500, "{name}: {} triangles", mesh.triangles.len());
        assert!(mesh.is_closed(), "{name}: not closed");
        assert_eq!(mesh.euler_characteristic(), euler, "{name}");
        for (&vertex, normal) in mesh.vertices.iter().zip(&mesh.normals) {
            let (value, gradient) = g(vertex);
            let slope = dot(gradient, gradient).sqrt();
            assert!((value / slope).abs() < 1e-13, "{name}: {:e} off the surface", value / slope);
            assert!(dot(gradient, *normal) > (1.0 - 1e-9) * slope, "{name}: normal {normal:?}");
        }
        let volume = mesh.volume();
        assert!(volume * sign > 0.0, "{name}: wound the wrong way, volume {volume}");
        if (euler, sign) == (2, 1.0) {
            let exact = 4.0 / 3.0 * std::f64::consts::PI;
            // An inscribed polyhedron with edges of a cell c is missing about c²/2 of it.
            let cell = (high[0] - low[0]).max(high[1] - low[1]).max(high[2] - low[2]) / cells as f64;
            assert!((0.0..cell * cell).contains(&(1.0 - volume / exact)), "{name}: volume {volume}");
        }
        for &[a, b, c] in &mesh.triangles {
            let corner = |vertex: u32| mesh.vertices[vertex as usize];
            let normal = cross(minus(corner(b), corner(a)), minus(corner(c), corner(a)));
            let facing = dot(normal, mesh.normals[a as usize]);
            assert!(dot(normal, normal) > 0.0 && facing > 0.0, "{name}: a degenerate or folded triangle");
        }
    }
}

/// Points that are even on a sphere, by Archimedes' theorem on a lattice, are n / 4π everywhere; on one half twice
/// that, and nothing on the other.
#[test]
fn densities_are_points_by_area() {
    let mesh = Mesh::of(sphere, [-1.5; 3], [1.5; 3], 40).unwrap();
    let n = 40_000;
    let even = |top: f64| -> Vec<Point> {
        let place = |i: usize| {
            let z = top - (top + 1.0) * (i as f64 + 0.5) / n as f64;
            let (sin, cos) = (2.399_963_229_728_653 * i as f64).sin_cos();
            [(1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z]
        };
        (0..n).map(place).collect()
    };
    let whole = n as f64 / (4.0 * std::f64::consts::PI);
    // The area within the radius is that of about a hundred vertices: off by those at its rim, √100 or so of them.
    for (vertex, density) in mesh.vertices.iter().zip(mesh.density(&even(1.0), 0.35).unwrap()) {
        assert!((density / whole - 1.0).abs() < 0.1, "{vertex:?}: {density} for {whole}");
    }
    for (vertex, density) in mesh.vertices.iter().zip(mesh.density(&even(0.0), 0.35).unwrap()) {
        let expected = if vertex[2] < 0.0 { 2.0 * whole } else { 0.0 };
        assert!(vertex[2].abs() < 0.36 || (density - expected).abs() < 0.2 * whole, "{vertex:?}: {density}");
    }
    // What lies elsewhere is not counted.
    assert_eq!(mesh.density(&[[5.0; 3]], 0.3).unwrap().iter().sum::<f64>(), 0.0);
    for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(mesh.density(&[[5.0; 3]], radius), Err(MeshError::Radius(_))), "{radius}");
    }
}

#[test]
fn boxes_and_numbers_that_cannot_serve_are_errors() {
    let nan: Surface = |[x, _, _]| ((x + 2.0).sqrt(), [0.0; 3]);
    #[rustfmt::skip]
    let cases: [(&str, Surface, Point, Point, usize, &str); 8] = [
        ("inside it",    sphere, [-0.3; 3], [0.3; 3],  20, "g is < 0 at every grid point"),
        ("beside it",    sphere, [2.0; 3],  [3.0; 3],  20, "g is ≥ 0 at every grid point"),
        ("cut",          sphere, [-1.5, -1.5, 0.0], [1.5; 3], 20, "the box cuts the surface"),
        ("turned box",   sphere, [1.5; 3],  [-1.5; 3], 20, "can't lay 20 cells"),
        ("flat box",     sphere, [-1.5, -1.5, 0.0], [1.5, 1.5, 0.0], 20, "can't lay 20 cells"),
        ("NaN box",      sphere, [f64::NAN; 3], [1.5; 3], 20, "can't lay 20 cells"),
        ("no cells",     sphere, [-1.5; 3], [1.5; 3],   0, "can't lay 0 cells"),
        ("NaN in g",     nan,    [-3.0; 3], [3.0; 3],  20, "not finite at [-3.0, -3.0, -3.0]"),
    ];
    for (name, g, low, high, cells, words) in cases {
        let error = Mesh::of(g, low, high, cells).expect_err(name);
        assert!(error.to_string().contains(words), "{name}: {error}");
    }
    // The gradient is looked at too.
    let blind = |q| (sphere(q).0, [f64::NAN; 3]);
    assert!(matches!(Mesh::of(blind, [-1.5; 3], [1.5; 3], 20), Err(MeshError::NotFinite { .. })));
}

/// A sphere about this centre.
fn ball(centre: Point, r: f64) -> impl Fn(Point) -> (f64, Point) {
    move |q| {
        let d = minus(q, centre);
        (dot(d, d) - r * r, d.map(|x| 2.0 * x))
    }
}

/// A mesh with a sphere's normals outwards has its volume, wherever it lies: an inscribed polyhedron with edges of a
/// cell c is missing about c²/2 of it, and a vertex is rounded to 1e-16 of its coordinates.
#[test]
fn volumes_are_those_at_the_origin() {
    let exact = 4.0 / 3.0 * std::f64::consts::PI;
    for away in [0.0, 1e3, 1e5, 1e6, -1e7] {
        let centre = [away, 2.0 * away, 3.0 * away];
        let [low, high] = [-1.3, 1.3].map(|side| centre.map(|x| x + side));
        let volume = Mesh::of(ball(centre, 1.0), low, high, 40).unwrap().volume();
        let cell: f64 = 2.6 / 40.0;
        assert!((0.0..cell * cell).contains(&(1.0 - volume / exact)), "{away:e}: volume {volume}");
    }
}

/// The surface that holds the start, or an error: no other surface, no pieces of it, and no mesh without triangles.
#[test]
fn around_a_point_is_its_surface_or_an_error() {
    let far = |x: f64, r: f64| (ball([x, 0.0, 0.0], r), [x, 0.0, r], r);
    for (g, near, r) in [far(1e6, 1.0), far(100.0, 0.001), far(1e5, 1.0), far(1e7, 1.0)] {
        let mesh = Mesh::around(g, near, 40).unwrap_or_else(|error| panic!("{near:?}: {error}"));
        assert!(mesh.is_closed() && mesh.euler_characteristic() == 2, "{near:?}");
        assert!(
            (mesh.volume() / (4.0 / 3.0 * std::f64::consts::PI * r.powi(3)) - 1.0).abs() < 0.01,
            "{near:?}"
        );
    }
    // A small ball beside a large one, in one formula.
    let (small, large) = (ball([1024.0, 0.0, 0.0], 1.0 / 64.0), ball([0.0; 3], 500.0));
    let both = |q| {
        let ((f, df), (g, dg)) = (small(q), large(q));
        (f * g, [0, 1, 2].map(|i| df[i] * g + f * dg[i]))
    };
    let mesh = Mesh::around(both, [1024.0 + 1.0 / 64.0, 0.0, 0.0], 40).unwrap();
    assert!(mesh.is_closed());
    assert!(mesh.vertices.iter().all(|q| (q[0] - 1024.0).abs() < 0.02), "the other ball");
    // Rings from thick to thinner than a cell, from two starts: whole, or refused.
    let (mut whole, mut refused) = (0, 0);
    for minor in [0.3, 0.08, 0.05, 0.04, 0.03, 0.02, 0.005] {
        for angle in [0.0, 0.7f64] {
            let ring = rattle::surfaces::TorusByDistance { major: 1.0, minor };
            let near = [(1.0 + minor) * angle.cos(), (1.0 + minor) * angle.sin(), 0.0];
            match Mesh::around(surface(&ring), near, 40) {
                Ok(mesh) => {
                    let closed = mesh.is_closed() && mesh.euler_characteristic() == 0;
                    assert!(
                        closed && mesh.vertices.iter().any(|q| q[0] < -0.97),
                        "{minor} at {angle}: pieces"
                    );
                    whole += 1;
                }
                Err(MeshError::Thin { .. }) => refused += 1,
                Err(error) => panic!("{minor} at {angle}: {error}"),
            }
        }
    }
    assert!(whole >= 4 && refused >= 4, "{whole} whole, {refused} refused");
    let nothing = Mesh { vertices: Vec::new(), normals: Vec::new(), triangles: Vec::new() };
    assert!(!nothing.is_closed());
}

/// At a pole g changes its sign without a root: there are no triangles, and all others lie on the surface.
#[test]
fn poles_are_no_walls() {
    let tangent: Surface = |[x, _, z]| (z - x.tan(), [-1.0 - x.tan().powi(2), 0.0, 1.0]);
    let inverse: Surface = |[x, _, z]| (1.0 / x - z, [-1.0 / (x * x), 0.0, -1.0]);
    for (name, g, low, high, sheets) in [
        ("tangent", tangent, [-3.0, -1.0, -2.0], [3.0, 1.0, 2.0], 3),
        ("inverse", inverse, [-2.03, -1.0, -3.0], [2.0, 1.0, 3.0], 2),
    ] {
        let mesh = Mesh::within(g, low, high, 60).unwrap();
        assert!(mesh.triangles.len() > 500, "{name}: {} triangles", mesh.triangles.len());
        assert_eq!(mesh.euler_characteristic(), sheets, "{name}: sheets without holes");
        for &vertex in &mesh.vertices {
            let (value, gradient) = g(vertex);
            assert!(
                value.abs() < 1e-4 * dot(gradient, gradient).sqrt(),
                "{name}: {vertex:?} is off the surface"
            );
        }
        for corners in &mesh.triangles {
            let [a, b, c] = corners.map(|vertex| mesh.vertices[vertex as usize]);
            let longest = [minus(a, b), minus(b, c), minus(c, a)].map(|side| dot(side, side).sqrt());
            assert!(longest.iter().all(|&side| side < 0.5), "{name}: a triangle to another sheet");
        }
    }
    let alone: Surface = |[x, _, _]| (1.0 / x, [-1.0 / (x * x), 0.0, 0.0]);
    let error = Mesh::within(alone, [-1.03; 3], [1.0; 3], 20).unwrap_err();
    assert!(matches!(error, MeshError::Thin { .. }), "{error}");
}

fn minus(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|i| a[i] - b[i])
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Whatever its size, place and shape, and wherever on it the search begins.
#[test]
#[cfg(long)]
fn a_box_is_found() {
    type Shifted = fn(Point) -> (f64, Point);
    let far: Shifted = |[x, y, z]| sphere([x - 100.0, y + 50.0, z]);
    let small: Shifted = |q| {
        let (g, gradient) = torus(q.map(|x| 1e6 * x));
        (g, gradient.map(|slope| 1e6 * slope))
    };
    let flat: Shifted = |[x, y, z]| (x * x + y * y + 1e3 * z * z - 1.0, [2.0 * x, 2.0 * y, 2e3 * z]);
    // Where (x² + y²)² − (x² − y²) = 1/6 is farthest along x and along y, where z is.
    let eye = [((1.0 + (5.0_f64 / 3.0).sqrt()) / 2.0).sqrt(), (5.0_f64 / 24.0).sqrt(), 1.0 / 6.0];
    let half = 1e-3_f64.sqrt();
    #[rustfmt::skip]
    let cases: [(&str, Surface, Point, Region, isize); 7] = [
        // name          g            near              the box that is right, V−E+F
        ("sphere",       sphere,      [1.0, 0.0, 0.0],  ([-1.0; 3], [1.0; 3]), 2),
        ("from afar",    sphere,      [9.0, -4.0, 2.0], ([-1.0; 3], [1.0; 3]), 2),
        ("off-centre",   far,         [100.0, -50.0, 1.0], ([99.0, -51.0, -1.0], [101.0, -49.0, 1.0]), 2),
        ("torus",        torus,       [1.4, 0.0, 0.0],  ([-1.4, -1.4, -0.4], [1.4, 1.4, 0.4]), 0),
        ("small torus",  small,       [1.4e-6, 0.0, 0.0], ([-1.4e-6, -1.4e-6, -4e-7], [1.4e-6, 1.4e-6, 4e-7]), 0),
        ("lemniscate",   lemniscate,  [0.0, 0.0, 0.1],  (eye.map(|x| -x), eye), -2),
        ("flat",         flat,        [0.0, 0.0, 0.03], ([-1.0, -1.0, -half], [1.0, 1.0, half]), 2),
    ];
    for (name, g, near, (low, high), euler) in cases {
        let mesh = Mesh::around(g, near, 60).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(mesh.is_closed() && mesh.euler_characteristic() == euler, "{name}");
        for i in 0..3 {
            let of = |pick: fn(f64, f64) -> f64, from| mesh.vertices.iter().map(|v| v[i]).fold(from, pick);
            let (least, most) = (of(f64::min, f64::INFINITY), of(f64::max, f64::NEG_INFINITY));
            // The outermost vertex is half a cell or so beside the outermost point, and what is round falls back by
            // less.
            let off = [least - low[i], most - high[i]].map(|off| off.abs() / (high[i] - low[i]));
            assert!(off[0] < 0.01 && off[1] < 0.01, "{name}: {least} {most}");
        }
    }
    let plane = rattle::surfaces::Plane { a: 0.0, b: 0.0, c: 1.0, d: 0.5 };
    let error = Mesh::around(surface(&plane), [0.0, 0.0, 0.5], 40).unwrap_err();
    assert!(matches!(error, MeshError::Endless { .. }), "{error}");
    let pole: Surface =
        |[x, y, z]| (x * x + y * y + z * z - 1.0 + 1e-9 / (x - 0.5), [2.0 * x, 2.0 * y, 2.0 * z]);
    let _ = Mesh::around(pole, [0.0, 0.0, 1.0], 40); // a mesh or an error
    let nan: Surface = |_| (f64::NAN, [1.0; 3]);
    assert!(matches!(Mesh::around(nan, [0.0; 3], 40), Err(MeshError::NotFinite { .. })));
}
