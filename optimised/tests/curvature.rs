//! Curvatures against exact formulas, integrals over closed surfaces against Gauss and Bonnet.

use crate::common::{Gravity, PlanarGravity, order};
use nalgebra::{SVector, vector};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle::curvature::{Curvature, IntegralError, Measure, integrate, measure};
use rattle::error::{Error, StepFailure, SurfaceFailure};
use rattle::prelude::*;
use rattle::surfaces::*;
use rattle::view::Mesh;
use std::f64::consts::{PI, TAU};

constraint! {
    /// An ellipse, and by that a curve.
    struct Ellipse { a, b }
    |x, y| (x / a)^2 + (y / b)^2 - 1
}

constraint! {
    /// A sphere of three dimensions, stretched along its last axis.
    struct Spheroid { r, c }
    |x, y, z, w| (x^2 + y^2 + z^2) / r^2 + (w / c)^2 - 1
}

constraint! {
    /// No zero, but a change of sign at r: through infinity.
    struct Pole { r }
    |x, y, z| 1 / (x^2 + y^2 + z^2 - r^2)
}

constraint! {
    /// No zero, but a change of sign at r: a step.
    struct Step { r }
    |x, y, z| sign(x^2 + y^2 + z^2 - r^2) + x / 10
}

constraint! {
    /// The root leaves no number inside the unit sphere.
    struct Hollow {}
    |x, y, z| sqrt(x^2 + y^2 + z^2 - 1) - 1
}

constraint! {
    /// It has a normal at x = 0, but no second derivative along x.
    struct Edge {}
    |x, y, z, w| w + x^(6/5) + y^2 + z^2
}

constraint! {
    /// The ends of an interval.
    struct Ends {}
    |x| x^2 - 1
}

type Point = SVector<f64, 3>;

fn random(generator: &mut StdRng) -> Point {
    Point::from_fn(|_, _| generator.random_range(-1.0..1.0))
}

/// Newton's method along the gradient from q.
fn onto<C: Constraint<3, 1>>(surface: &C, mut q: Point) -> Option<Point> {
    for _ in 0..50 {
        let (g, gradient) = surface.value_and_jacobian(&q);
        q -= gradient.transpose() * (g[0] / gradient.norm_squared());
    }
    q.iter().all(|x| x.abs() < 4.0).then_some(q)
}

/// `exact` gives (K, H) at a point of the surface.
#[track_caller]
fn check(name: &str, surface: &impl Constraint<3, 1>, exact: impl Fn(&Point) -> (f64, f64)) {
    let mut generator = StdRng::seed_from_u64(3);
    let mut seen = 0;
    for _ in 0..300 {
        let start = random(&mut generator) * 2.0;
        let Some(q) = onto(surface, start) else { continue };
        seen += 1;
        let (gauss, mean) = exact(&q);
        let principal = surface.principal_curvatures(&q);
        let [(k1, e1), (k2, e2)] = principal[..] else { panic!("{name}: {principal:?}") };
        let bound = 1e-11 * (1.0 + k1.abs().max(k2.abs()).powi(2));
        let near = |what: &str, found: f64, exact: f64| {
            assert!((found - exact).abs() <= bound, "{name}, {what} at {q}: {found}, exact {exact}");
        };
        near("K", surface.gaussian_curvature(&q), gauss);
        near("H", surface.mean_curvature(&q), mean);
        near("κ₁κ₂", k1 * k2, gauss);
        near("(κ₁+κ₂)/2", (k1 + k2) / 2.0, mean);
        assert!(k1 <= k2, "{name}: {k1} {k2}");

        // The directions: a basis of the tangent plane, and each has the curvature it comes with.
        let normal = surface.jacobian(&q).transpose().normalize();
        for (found, exact) in [
            (e1.norm(), 1.0),
            (e2.norm(), 1.0),
            (e1.dot(&e2), 0.0),
            (e1.dot(&normal), 0.0),
            (e2.dot(&normal), 0.0),
        ] {
            assert!((found - exact).abs() < 1e-14, "{name}: {e1} {e2} {normal}");
        }
        // Euler: κ(v) = κ₁ cos² + κ₂ sin². A part of v along n, and the length of v, are not seen.
        let angle: f64 = generator.random_range(0.0..TAU);
        let v = 3.0 * (e1 * angle.cos() + e2 * angle.sin());
        let euler = k1 * angle.cos().powi(2) + k2 * angle.sin().powi(2);
        near("κ", surface.normal_curvature(&q, &v), euler);
        near("κ of v + 2n", surface.normal_curvature(&q, &(v + 2.0 * normal)), euler);
        // Goldman's closed formulas, which know no tangent vectors.
        let gradient = surface.jacobian(&q).transpose();
        let [hessian] = surface.hessian(&q);
        let adjugate = hessian_adjugate(&hessian);
        let goldman = gradient.dot(&(adjugate * gradient)) / gradient.norm_squared().powi(2);
        near("Goldman's K", surface.gaussian_curvature(&q), goldman);
    }
    assert!(seen > 50, "{name}: {seen} points");
}

fn hessian_adjugate(m: &nalgebra::Matrix3<f64>) -> nalgebra::Matrix3<f64> {
    let column = |k: usize| m.column((k + 1) % 3).cross(&m.column((k + 2) % 3));
    nalgebra::Matrix3::from_columns(&[column(0), column(1), column(2)])
}

#[test]
fn surfaces_with_known_curvature() {
    check("sphere", &Sphere { r: 1.5 }, |_| (1.0 / 2.25, 1.0 / 1.5));
    check("cylinder", &Cylinder { r: 0.5 }, |_| (0.0, 1.0));
    check("plane", &Plane { a: 1.0, b: 2.0, c: 3.0, d: 0.5 }, |_| (0.0, 0.0));
    let (major, minor) = (1.5, 0.5);
    // 1/ρ dρ/dn, with ρ the distance from the axis.
    let torus = |q: &Point| {
        let rho = q.x.hypot(q.y);
        let (meridian, parallel) = (1.0 / minor, (rho - major) / minor / rho);
        (meridian * parallel, (meridian + parallel) / 2.0)
    };
    check("torus", &Torus { major, minor }, torus);
    check("torus by distance", &TorusByDistance { major, minor }, torus);
    let (a, b, c) = (1.0, 1.5, 2.0);
    check("ellipsoid", &Ellipsoid { a, b, c }, |q| {
        let steep = (q.x / (a * a)).powi(2) + (q.y / (b * b)).powi(2) + (q.z / (c * c)).powi(2);
        let volume: f64 = (a * b * c) * (a * b * c);
        let mean = (a * a + b * b + c * c - q.norm_squared()) / (2.0 * volume * steep.powf(1.5));
        (1.0 / (volume * steep * steep), mean)
    });
    check("catenoid", &Catenoid { a }, |q| (-1.0 / (a * (q.z / a).cosh().powi(2)).powi(2), 0.0));
    check("helicoid", &Helicoid { c }, |q| (-(c / (c * c + q.x * q.x + q.y * q.y)).powi(2), 0.0));
    check("scherk", &Scherk {}, |q| {
        // z = ln cos x − ln cos y; w² = 1 + tan² x + tan² y.
        let (sec_x, sec_y) = (1.0 / q.x.cos().powi(2), 1.0 / q.y.cos().powi(2));
        (-sec_x * sec_y / (sec_x + sec_y - 1.0).powi(2), 0.0)
    });
    check("saddle", &Saddle { a, b }, |q| {
        // A graph z = f: K = (f_xx f_yy − f_xy²)/w⁴, 2H = div(∇f/w) seen from below, where g grows.
        let (fx, fy, fxx, fyy) = (2.0 * q.x / (a * a), -2.0 * q.y / (b * b), 2.0 / (a * a), -2.0 / (b * b));
        let w2: f64 = 1.0 + fx * fx + fy * fy;
        let mean = ((1.0 + fy * fy) * fxx + (1.0 + fx * fx) * fyy) / (2.0 * w2.powf(1.5));
        (fxx * fyy / (w2 * w2), mean)
    });
}

/// At both ends of a torus's tube: outside it is bent like a sphere, inside like a saddle.
#[test]
fn signs_on_a_torus() {
    let torus = Torus { major: 1.5, minor: 0.5 };
    let (along, around) = (vector![0.0, 0.0, 1.0], vector![0.0, 1.0, 0.0]);
    for (x, parallel) in [(2.0, 0.5), (1.0, -1.0)] {
        let q = vector![x, 0.0, 0.0];
        assert!((torus.normal_curvature(&q, &along) - 2.0).abs() < 1e-15);
        assert!((torus.normal_curvature(&q, &around) - parallel).abs() < 1e-15);
        let [(low, direction), (high, _)] = torus.principal_curvatures(&q)[..] else { unreachable!() };
        assert!((low - parallel).abs() < 1e-15 && (high - 2.0).abs() < 1e-15, "{low} {high}");
        assert!((direction.dot(&around).abs() - 1.0).abs() < 1e-15, "{direction}");
    }
}

#[test]
fn curves_and_spheres_of_three_dimensions() {
    let (a, b) = (2.0_f64, 0.5_f64);
    let ellipse = Ellipse { a, b };
    for t in (0..12).map(f64::from) {
        let (q, v) = (vector![a * t.cos(), b * t.sin()], vector![-a * t.sin(), b * t.cos()]);
        let exact = a * b / v.norm().powi(3);
        let [(principal, _)] = ellipse.principal_curvatures(&q)[..] else { unreachable!() };
        for found in [
            ellipse.normal_curvature(&q, &v),
            principal,
            ellipse.mean_curvature(&q),
            ellipse.gaussian_curvature(&q),
        ] {
            assert!((found / exact - 1.0).abs() < 1e-13, "{t}: {found}, exact {exact}");
        }
    }
    // The meridian is the ellipse; the two other curvatures are 1/(length of the normal up to the axis).
    let spheroid = Spheroid { r: a, c: b };
    for t in (1..12).map(f64::from) {
        let (rho, w) = (a * t.cos(), b * t.sin());
        let q = vector![0.6 * rho, 0.0, 0.8 * rho, w];
        let speed = (a * t.sin()).hypot(b * t.cos());
        let (meridian, parallel) = (a * b / speed.powi(3), b / (a * speed));
        let mut exact = [meridian, parallel, parallel];
        exact.sort_by(f64::total_cmp);
        let found = spheroid.principal_curvatures(&q);
        assert_eq!(found.len(), 3);
        for ((found, direction), exact) in found.iter().zip(exact) {
            assert!((found / exact - 1.0).abs() < 1e-13, "{t}: {found}, exact {exact}");
            assert!((spheroid.normal_curvature(&q, direction) / exact - 1.0).abs() < 1e-13);
        }
        assert!((spheroid.mean_curvature(&q) / exact.iter().sum::<f64>() * 3.0 - 1.0).abs() < 1e-13);
        assert!((spheroid.gaussian_curvature(&q) / exact.iter().product::<f64>() - 1.0).abs() < 1e-13);
    }
}

/// Where there is no normal there is NaN, and not an endless iteration.
/// Only the direction of v counts, be its square a number or not.
#[test]
fn curvatures_along_vectors_of_any_length() {
    let egg = Ellipsoid { a: 1.0, b: 1.5, c: 0.7 };
    let (q, v) = (vector![0.6, 0.0, 0.56], vector![0.3, -0.7, 0.2]);
    let exact = egg.normal_curvature(&q, &v);
    for length in [1e-300, 1e-170, 1e-160, 1e-3, 1e150, 1e200, 1e307] {
        let off = egg.normal_curvature(&q, &(v * length)) - exact;
        assert!(off.abs() < 1e-14 * exact, "{length:e}: {off:e}");
    }
    assert!(egg.normal_curvature(&q, &vector![0.0, 0.0, 0.0]).is_nan());
}

#[test]
fn singular_points_have_no_curvature() {
    let (cone, apex) = (Hyperboloid { a: 1.0, c: 1.0 }, Point::zeros());
    assert!(cone.principal_curvatures(&apex).iter().all(|(kappa, _)| kappa.is_nan()));
    assert_eq!(cone.principal_curvatures(&apex).len(), 2);
    assert!(cone.mean_curvature(&apex).is_nan() && cone.gaussian_curvature(&apex).is_nan());
    assert!(cone.normal_curvature(&apex, &vector![1.0, 0.0, 0.0]).is_nan());
    let edge = Edge {}.principal_curvatures(&SVector::zeros());
    assert!(edge.iter().all(|(kappa, direction)| kappa.is_nan() && direction[0].is_nan()), "{edge:?}");
    let spheroid = Spheroid { r: 1.0, c: 1.0 }.principal_curvatures(&SVector::zeros());
    assert!(spheroid.len() == 3 && spheroid.iter().all(|(kappa, _)| kappa.is_nan()), "{spheroid:?}");
    // Two points of a line have no direction to bend in.
    assert!(Ends {}.principal_curvatures(&vector![1.0]).is_empty());
    let sphere = Sphere { r: 1.0 };
    assert!(sphere.normal_curvature(&vector![1.0, 0.0, 0.0], &Point::zeros()).is_nan());
}

/// λ|∇g| = −(κ|v|² + n·f): what a simulation says its multiplier is, and what the curvature says.
#[test]
fn the_multiplier_is_curvature_and_pressure() {
    let surface = || crate::common::SURFACE;
    let gravity = 0.7;
    let mut generator = StdRng::seed_from_u64(8);
    let (mut seen, mut signs) = (0, [0; 2]);
    for _ in 0..200 {
        let start = random(&mut generator).component_mul(&vector![1.0, 0.5, 0.2]);
        let Some(q) = onto(&surface(), start) else { continue };
        let state = State::at(q).moving(random(&mut generator));
        for f in [Point::zeros(), vector![0.0, 0.0, -gravity]] {
            let free = Scene::on(surface());
            let state = free.project(&state).unwrap();
            let method = Rattle::new(1e-3);
            let (v, lambda) = if f == Point::zeros() {
                let simulation = free.simulate(state, method).unwrap();
                (simulation.momentum(), simulation.multiplier())
            } else {
                let simulation = free.with(Gravity { g: gravity }).simulate(state, method).unwrap();
                (simulation.momentum(), simulation.multiplier())
            };
            let gradient = surface().jacobian(&q).transpose();
            let kappa = surface().normal_curvature(&q, &v);
            let held = -(kappa * v.norm_squared() + f.dot(&gradient) / gradient.norm());
            let found = lambda * gradient.norm();
            assert!((found - held).abs() <= 1e-11 * (1.0 + held.abs()), "{q} {v}: {found}, {held}");
            seen += 1;
            signs[usize::from(held > 0.0)] += 1;
        }
    }
    assert!(seen > 200 && signs[0] > 20 && signs[1] > 20, "{seen} {signs:?}");

    // A pendulum in the plane: the tension of its rod is −λ|∇g|, speed²/length + weight.
    let rod = Scene::on(crate::common::Pendulum { length: 2.0 }).with(PlanarGravity { g: 3.0 });
    let simulation = rod.simulate(State::at([0.0, -2.0]).moving([4.0, 0.0]), Rattle::new(0.01)).unwrap();
    assert_eq!(-simulation.multiplier() * 2.0 * 2.0, 16.0 / 2.0 + 3.0);
}

/// The κ in a step's error is this one, and 1/(κ|v|) its limit.
#[test]
fn the_longest_step_is_that_of_the_curvature() {
    let torus = || Torus { major: 1.5, minor: 0.5 };
    let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 3.0, 0.0]); // along the inner equator, κ = −1
    let mut simulation = Scene::on(torus()).simulate(start, Rattle::new(0.4)).unwrap();
    let kappa = torus().normal_curvature(&simulation.position(), &simulation.momentum());
    let Err(Error::Step {
        cause: StepFailure::Surface(SurfaceFailure::StepTooLong { curvature, longest, .. }),
        ..
    }) = simulation.step()
    else {
        panic!("a step with h·κ·|v| = 1.2 was taken");
    };
    assert!((kappa + 1.0).abs() < 1e-14, "{kappa}");
    assert!(
        (curvature - kappa.abs()).abs() < 1e-14 && (longest - 1.0 / 3.0).abs() < 1e-14,
        "{curvature} {longest}"
    );
    // Just below, it is taken.
    let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 3.0, 0.0]);
    assert!(Scene::on(torus()).simulate(start, Rattle::new(0.3)).unwrap().step().is_ok());
}

/// (area, genus) against what they must be, within the errors relative and absolute.
#[track_caller]
fn check_measure(
    name: &str,
    surface: &impl Constraint<3, 1>,
    (low, high): ([f64; 3], [f64; 3]),
    lines: usize,
    area: Option<(f64, f64)>,
    (genus, allowed): (f64, f64),
) {
    let found = measure(surface, low, high, lines).unwrap_or_else(|error| panic!("{name}: {error}"));
    if let Some((exact, allowed)) = area {
        assert!((found.area / exact - 1.0).abs() < allowed, "{name}: area {}, exact {exact}", found.area);
    }
    assert!((found.genus() - genus).abs() < allowed, "{name}: genus {}, {genus}", found.genus());
    assert!((found.euler_characteristic() - 2.0 * (1.0 - genus)).abs() < 2.0 * allowed, "{name}: {found:?}");
}

#[test]
#[cfg(long)]
fn areas_and_gauss_bonnet() {
    let eye = ([-1.3, -0.8, -0.5], [1.3, 0.8, 0.5]);
    let cube = |half: f64| ([-half; 3], [half; 3]);
    let torus = Torus { major: 1.0, minor: 0.4 };
    let lemniscate = |r| Lemniscate { a: 1.0, r };
    check_measure("sphere", &Sphere { r: 1.0 }, cube(1.3), 100, Some((4.0 * PI, 2e-7)), (0.0, 2e-7));
    let off = ([-1.31, -1.2, -1.43], [1.23, 1.3, 1.17]);
    check_measure("off-centre", &Sphere { r: 1.0 }, off, 100, Some((4.0 * PI, 2e-7)), (0.0, 2e-7));
    let area = 4.0 * PI * PI * 0.4;
    check_measure(
        "torus",
        &torus,
        ([-1.5, -1.5, -0.5], [1.5, 1.5, 0.5]),
        100,
        Some((area, 2e-6)),
        (1.0, 2e-6),
    );
    // 2πc² + 2πab/sin φ (E sin² φ + F cos² φ), cos φ = c/a, to 16 digits; also by direct quadrature.
    let ellipsoid = Ellipsoid { a: 3.0, b: 2.0, c: 1.0 };
    let box_ = ([-3.3, -2.2, -1.2], [3.2, 2.3, 1.1]);
    check_measure("ellipsoid", &ellipsoid, box_, 150, Some((48.882_146_302_582_06, 2e-6)), (0.0, 1e-5));
    // ∫K dA/4π = −1 and +1 within half a percent: the notebook's surface, and the same beyond r = a⁴/4.
    check_measure("r = 1/6", &lemniscate(1.0 / 6.0), eye, 200, None, (2.0, 5e-3));
    check_measure("r = 0.35", &lemniscate(0.35), eye, 200, None, (0.0, 5e-3));
    // Finer, they are much nearer.
    check_measure("r = 1/6", &lemniscate(1.0 / 6.0), eye, 300, None, (2.0, 1e-4));
    check_measure("tangle cube", &Tanglecube { c: 11.8 }, cube(2.6), 150, None, (5.0, 1e-3));
    // Six rings that meet in twelve places; in thicker ones the holes at the corners of the cube are closed.
    check_measure("decocube", &Decocube { b: 0.005, c: 0.95 }, cube(1.4), 250, None, (13.0, 2e-2));
    check_measure("thick decocube", &Decocube { b: 0.02, c: 0.95 }, cube(1.4), 150, None, (5.0, 1e-3));
    check_measure("cyclide", &DupinCyclide { a: 2.0, b: 1.9, d: 1.0 }, cube(5.0), 150, None, (1.0, 1e-3));
}

/// ∫ K dA/2π and V − E + F of a mesh: two ways to one integer, and they share nothing but g.
#[test]
#[cfg(long)]
fn the_integral_of_curvature_counts_like_a_mesh() {
    fn counted(name: &str, surface: &impl Constraint<3, 1>, half: f64, lines: usize, allowed: f64) -> isize {
        let value = |q: [f64; 3]| {
            let (g, gradient) = surface.value_and_jacobian(&q.into());
            (g[0], gradient.transpose().into())
        };
        let (low, high) = ([-half; 3], [half; 3]);
        let count = Mesh::of(value, low, high, 100).unwrap().euler_characteristic();
        let measured = measure(surface, low, high, lines).unwrap().euler_characteristic();
        assert!((measured - count as f64).abs() < allowed, "{name}: {measured}, counted {count}");
        count
    }
    assert_eq!(counted("two pieces", &Metaballs { c: 1.0, level: 3.0 }, 2.51, 101, 1e-2), 4);
    assert_eq!(counted("one piece", &Metaballs { c: 1.0, level: 1.5 }, 2.51, 101, 1e-2), 2);
    assert_eq!(counted("tangle cube", &Tanglecube { c: 11.8 }, 2.6, 150, 1e-2), -8);
    assert_eq!(counted("decocube", &Decocube { b: 0.02, c: 1.0 }, 1.5, 100, 5e-2), -8);
    assert_eq!(
        counted("superellipsoid", &Superellipsoid { a: 1.0, b: 0.8, c: 0.6, n: 4.0, m: 4.0 }, 1.1, 120, 1e-2),
        2
    );
}

/// Fourth order: root mean square over boxes that place the lines at random.
#[test]
#[cfg(long)]
fn integrals_converge_at_fourth_order() {
    let mut generator = StdRng::seed_from_u64(2);
    let sphere = Sphere { r: 1.0 };
    let boxes: Vec<_> = (0..40)
        .map(|_| {
            (
                random(&mut generator) * 0.1 - Point::repeat(1.2),
                random(&mut generator) * 0.1 + Point::repeat(1.2),
            )
        })
        .collect();
    let error = |lines: usize| {
        let squares = boxes.iter().map(|&(low, high)| {
            let area = measure(&sphere, low.into(), high.into(), lines).unwrap().area;
            (area / (4.0 * PI) - 1.0).powi(2)
        });
        (squares.sum::<f64>() / boxes.len() as f64).sqrt()
    };
    let errors = [16, 32, 64].map(error);
    let slope = order(&errors);
    assert!((3.5..5.0).contains(&slope), "order {slope:.2}, errors {errors:?}");
    assert!(errors[2] < 1e-6, "{errors:?}");
}

/// Other integrals: the volume by Gauss's theorem, Minkowski's ∫ H (n·q) dA = area, closedness ∫ n dA = 0.
#[test]
fn integrals_of_functions() {
    let (a, b, c) = (1.0, 0.7, 0.5);
    let ellipsoid = Ellipsoid { a, b, c };
    let [area, volume, minkowski, nx, ny, nz] =
        integrate(&ellipsoid, [-1.13, -0.81, -0.62], [1.15, 0.83, 0.6], 120, |q, n| {
            let height = n.dot(q);
            [1.0, height / 3.0, ellipsoid.mean_curvature(q) * height, n.x, n.y, n.z]
        })
        .unwrap();
    assert!((volume / (4.0 / 3.0 * PI * a * b * c) - 1.0).abs() < 1e-6, "{volume}");
    assert!((minkowski / area - 1.0).abs() < 1e-5, "{minkowski} {area}");
    assert!([nx, ny, nz].iter().all(|n| n.abs() < 1e-6), "{nx} {ny} {nz}");
}

#[test]
fn what_cannot_be_measured_is_an_error() {
    fn error(surface: &impl Constraint<3, 1>, low: [f64; 3], high: [f64; 3], lines: usize) -> IntegralError {
        match measure(surface, low, high, lines) {
            Ok(found) => panic!("measured {found:?}"),
            Err(error) => error,
        }
    }
    let (low, high) = ([-1.5; 3], [1.5; 3]);
    let sphere = Sphere { r: 1.0 };
    for (low, high) in [
        (high, low),
        ([-1.5, -1.5, 0.0], [1.5, 1.5, 0.0]),
        ([f64::NAN; 3], high),
        (low, [1.5, f64::INFINITY, 1.5]),
    ] {
        assert!(matches!(error(&sphere, low, high, 20), IntegralError::Box { .. }));
    }
    for lines in [0, 1, usize::MAX] {
        assert_eq!(error(&sphere, low, high, lines), IntegralError::Lines(lines));
    }
    assert!(matches!(error(&sphere, [2.0; 3], [3.0; 3], 20), IntegralError::Empty { lines: 20, .. }));
    assert!(matches!(error(&sphere, [-0.3; 3], [0.3; 3], 20), IntegralError::Empty { .. }));
    assert!(matches!(
        error(&Gyroid { k: 1.0, epsilon: 0.0 }, [-5.0; 3], [5.0; 3], 40),
        IntegralError::Cut { .. }
    ));
    for axis in 0..3 {
        let mut cut = high;
        cut[axis] = 0.5;
        let IntegralError::Cut { point } = error(&sphere, low, cut, 20) else { panic!("axis {axis}") };
        assert!(
            point
                .iter()
                .zip(low.iter().zip(cut))
                .any(|(x, (low, high))| x == low || (x - high).abs() < 1e-12)
        );
    }
    let IntegralError::NotFinite { what: "g", value, .. } = error(&Hollow {}, [-3.0; 3], [3.0; 3], 20) else {
        panic!("measured past a root of a negative number");
    };
    assert!(value.is_nan());
    assert!(matches!(error(&Pole { r: 1.0 }, low, high, 21), IntegralError::Jump { .. }));
    assert!(matches!(error(&Step { r: 1.0 }, low, high, 21), IntegralError::Jump { .. }));
    assert!(matches!(error(&Heart {}, low, high, 40), IntegralError::Singular { .. }));
    let infinite = integrate(&sphere, low, high, 20, |_, _| [1.0, f64::INFINITY]);
    assert!(matches!(infinite, Err(IntegralError::NotFinite { what: "f", .. })));
    let words = error(&sphere, [2.0; 3], [3.0; 3], 20).to_string();
    assert!(words.contains("no line meets the surface") && words.contains("20 lines"), "{words}");
}

/// Scaling g, or turning its sign, changes nothing but the normal.
#[test]
fn a_measure_belongs_to_the_surface() {
    constraint! { struct Scaled { s } |x, y, z| s * (x^2 + 2 * y^2 + 3 * z^2 - 1) }
    let of = |s| measure(&Scaled { s }, [-1.1; 3], [1.2; 3], 60).unwrap();
    let Measure { area, total_curvature, .. } = of(1.0);
    for s in [-1.0, 2f64.powi(60), -(2f64.powi(-60))] {
        let other = of(s);
        assert!((other.area / area - 1.0).abs() < 1e-13, "{s}: {other:?}");
        assert!((other.total_curvature / total_curvature - 1.0).abs() < 1e-13, "{s}: {other:?}");
    }
    let q = vector![1.0, 0.0, 0.0];
    let (one, minus) = (Scaled { s: 1.0 }, Scaled { s: -1.0 });
    assert_eq!(one.mean_curvature(&q), -minus.mean_curvature(&q));
    assert_eq!(one.gaussian_curvature(&q), minus.gaussian_curvature(&q));
}

/// What other rules from the same points say is farther off than the area, on tori too thin for their lines, too, whose
/// genus says nothing; and it is small where the surface is resolved.
#[test]
fn what_an_area_may_be_off() {
    use rattle::surfaces::TorusByDistance;
    let (mut worst, mut silent) = (0.0_f64, 0);
    let lines: &[usize] = if cfg!(long) { &[40, 60, 80, 100, 120, 160, 240] } else { &[40, 80, 120] };
    for minor in [0.01, 0.02] {
        let torus = TorusByDistance { major: 1.0, minor };
        for &lines in lines {
            let found = measure(&torus, [-1.1, -1.1, -0.1], [1.1, 1.1, 0.1], lines).unwrap();
            let off = (found.area - 4.0 * PI * PI * minor).abs();
            // Two rules may agree by chance: by half of the error at most, here.
            assert!(off < 2.0 * found.uncertainty, "{minor}, {lines}: {off} {found:?}");
            worst = worst.max(off / found.area);
            silent += usize::from(off > 0.1 * found.area && (found.genus() - 1.0).abs() < 0.02);
        }
    }
    assert!(worst > 0.5 && silent > 0, "{worst}, {silent}");
    for (lines, allowed) in [(10, 0.4), (20, 1e-2), (40, 3e-4)] {
        let ball = measure(&Sphere { r: 1.0 }, [-1.37; 3], [1.41; 3], lines).unwrap();
        let off = (ball.area - 4.0 * PI).abs();
        assert!(off < ball.uncertainty && ball.uncertainty < allowed * ball.area, "{lines}: {ball:?}");
    }
}

/// Edges hold part of the curvature, so that a cube had the genus 1: an error that says where they are. Surfaces whose
/// curvature alone jumps have a genus, and so have those with kinks between two parts that do not touch.
#[test]
fn edges_have_no_genus() {
    constraint! { struct Cube {} |x, y, z| max(abs(x), abs(y), abs(z)) - 1 }
    constraint! { struct Can {} |x, y, z| max(norm(x, y), abs(z)) - 1 }
    constraint! { struct Lens { c } |x, y, z| max(x^2 + y^2 + (z - c)^2, x^2 + y^2 + (z + c)^2) - 1 }
    constraint! { struct Two { c } |x, y, z| min(x^2 + y^2 + (z - c)^2, x^2 + y^2 + (z + c)^2) - 1 }
    constraint! { struct Capsule {} |x, y, z| x^2 + y^2 + max(abs(z) - 0.3, 0)^2 - 0.25 }
    constraint! {
        /// The same with a dent, as `DentedCylinder` has it.
        struct Dented { r, l, a }
        |x, y, z| {
            let dent = if abs(z) < l { a * (1 + cos(3.141592653589793 * z / l)) / 2 } else { 0 };
            x^2 + y^2 + max(abs(z) - 1, 0)^2 - (r - dent)^2
        }
    }
    let (low, high) = ([-1.37; 3], [1.41; 3]);
    let told = |name: &str,
                found: Result<Measure, IntegralError>,
                on: &dyn Fn([f64; 3]) -> f64,
                turn: f64| {
        let Err(IntegralError::Edge { point, angle }) = found else { panic!("{name}: {found:?}") };
        assert!(on(point).abs() < 0.02 && (angle / turn - 1.0).abs() < 0.05, "{name}: {point:?}, {angle}");
    };
    for lines in [20, 40, 57] {
        let edge = |q: [f64; 3]| {
            let mut q = q.map(f64::abs);
            q.sort_by(f64::total_cmp);
            (q[1] - 1.0).hypot(q[2] - 1.0)
        };
        told("cube", measure(&Cube {}, low, high, lines), &edge, PI / 2.0);
        let rim = |q: [f64; 3]| (q[0].hypot(q[1]) - 1.0).hypot(q[2].abs() - 1.0);
        told("can", measure(&Can {}, low, high, lines), &rim, PI / 2.0);
        let rim = |q: [f64; 3]| (q[0].hypot(q[1]) - 0.75_f64.sqrt()).hypot(q[2]);
        told("lens", measure(&Lens { c: 0.5 }, low, high, lines), &rim, PI / 3.0);
    }
    let [area] = integrate(&Cube {}, low, high, 57, |_, _| [1.0]).unwrap();
    assert!((area / 24.0 - 1.0).abs() < 0.01, "{area}");
    let two = measure(&Two { c: 1.05 }, [-1.2, -1.2, -2.2], [1.2, 1.2, 2.2], 66).unwrap();
    assert!((two.genus() + 1.0).abs() < 1e-3, "two balls: {}", two.genus());
    let capsule = measure(&Capsule {}, [-0.67, -0.67, -1.0], [0.68, 0.68, 1.0], 60).unwrap();
    assert!(capsule.genus().abs() < 0.1, "{}", capsule.genus()); // of first order: K jumps
    let dented = Dented { r: 0.6, l: 0.7, a: 0.2 };
    let dented = measure(&dented, [-0.77, -0.77, -1.8], [0.78, 0.78, 1.8], 120).unwrap();
    assert!(dented.genus().abs() < 0.1, "{}", dented.genus());
}
