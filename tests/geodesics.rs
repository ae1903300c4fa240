//! Distances along surfaces: against great circles, helices and Bessel's integrals of the spheroid; as distances of a
//! pair potential, whose forces are the gradient of its energy.

use rattle::curvature::{GeodesicError, geodesic_distance, points};
use rattle::nalgebra::{Vector3, vector};
use rattle::prelude::*;
use rattle::surfaces::{Cylinder, Ellipsoid, Gyroid, Lemniscate, Sphere, Torus};

/// What the rounding of some hundred evaluations comes to, as part of the way.
const ROUNDING: f64 = 1e-13;

/// Great circles of any length short of half of them, down to one of 1e-9, of which places say less; near half of one
/// the rounding of places turns directions by more.
#[test]
fn great_circles() {
    let r = 1.7;
    let places = points::uniform(&Sphere { r }, [-2.0; 3], [2.0; 3], 40, 1).unwrap();
    let mut longest = 0.0_f64;
    for pair in places.chunks(2) {
        let (a, b) = (pair[0], pair[1]);
        let angle = a.cross(&b).norm().atan2(a.dot(&b));
        if angle > 3.0 {
            continue;
        }
        longest = longest.max(angle);
        let way = geodesic_distance(&Sphere { r }, &a, &b).unwrap();
        let (u, w) = (a / r, b / r);
        let from = (w - u * angle.cos()) / angle.sin();
        let to = (w * angle.cos() - u) / angle.sin();
        assert!(
            (way.distance - r * angle).abs() < ROUNDING * r * angle,
            "{angle}: {:e}",
            way.distance - r * angle
        );
        let bound = ROUNDING * (1.0 + 1.0 / angle.sin());
        assert!((way.from - from).norm() < bound && (way.to - to).norm() < bound, "{angle}");
        let back = geodesic_distance(&Sphere { r }, &b, &a).unwrap();
        assert!((back.distance - way.distance).abs() < ROUNDING * r * angle);
        assert!((back.from + way.to).norm() < bound && (back.to + way.from).norm() < bound);
    }
    assert!(longest > 2.5);
    for exponent in 1..10 {
        let angle = 10_f64.powi(-exponent);
        let (a, b) = (vector![0.0, 0.0, r], vector![r * angle.sin(), 0.0, r * angle.cos()]);
        let off = geodesic_distance(&Sphere { r }, &a, &b).unwrap().distance - r * angle;
        assert!(off.abs() < ROUNDING * angle + f64::EPSILON * r, "{angle}: {off:e}");
    }
}

/// A helix of radius r that turns by φ and climbs by z has the length √(r²φ² + z²); a meridian of a torus is r φ long,
/// its outer equator (R + r) φ.
#[test]
fn helices_and_circles_of_a_torus() {
    let r = 0.8;
    for (phi, z) in [(1.0_f64, 0.5), (2.0, 3.0), (0.01, -0.2), (0.0, 1.0)] {
        let a = vector![r, 0.0, 0.3];
        let b = vector![r * phi.cos(), r * phi.sin(), 0.3 + z];
        let way = geodesic_distance(&Cylinder { r }, &a, &b).unwrap();
        let exact = (r * phi).hypot(z);
        assert!((way.distance - exact).abs() < ROUNDING * exact, "{phi}: {:e}", way.distance - exact);
        let from = vector![0.0, r * phi, z] / exact;
        assert!((way.from - from).norm() < ROUNDING / exact.min(1.0), "{phi}: {}", way.from);
    }
    let (major, minor) = (1.2, 0.5);
    let torus = Torus { major, minor };
    for phi in [0.1_f64, 0.7, 1.5, 2.5] {
        let at = |angle: f64| vector![major + minor * angle.cos(), 0.0, minor * angle.sin()];
        let off = geodesic_distance(&torus, &at(0.4), &at(0.4 + phi)).unwrap().distance - minor * phi;
        assert!(off.abs() < ROUNDING * phi, "{phi}: {off:e}");
    }
    for phi in [0.1_f64, 0.5, 1.2] {
        let b = vector![(major + minor) * phi.cos(), (major + minor) * phi.sin(), 0.0];
        let way = geodesic_distance(&torus, &vector![major + minor, 0.0, 0.0], &b).unwrap();
        assert!((way.distance - (major + minor) * phi).abs() < ROUNDING * phi, "{phi}");
    }
}

/// Bessel's integrals (C. Karney, J. Geod. 87 (2013) 43, equations 7 and 8) for a geodesic of a spheroid with semi-axes
/// a, a, b that crosses the equator with the azimuth α₀: its length and longitude from there to the arc σ of the
/// auxiliary sphere. Simpson's rule with 20 000 intervals: to rounding.
fn bessel(a: f64, b: f64, alpha: f64, sigma: f64) -> (f64, Vector3<f64>) {
    let flat = (a - b) / a;
    let square = (a * a - b * b) * (alpha.cos() / b).powi(2); // less than 0 where b is longer
    let root = |s: f64| (1.0 + square * s.sin().powi(2)).sqrt();
    let simpson = |f: &dyn Fn(f64) -> f64| {
        let (n, mut sum) = (20_000, 0.0);
        for i in 0..=n {
            let weight = if i == 0 || i == n { 1.0 } else { 2.0 + 2.0 * f64::from(i % 2) };
            sum += weight * f(sigma * f64::from(i) / f64::from(n));
        }
        sum * sigma / f64::from(3 * n)
    };
    let length = b * simpson(&root);
    let lag = simpson(&|s| (2.0 - flat) / (1.0 + (1.0 - flat) * root(s)));
    let longitude = (alpha.sin() * sigma.sin()).atan2(sigma.cos()) - flat * alpha.sin() * lag;
    let height = alpha.cos() * sigma.sin(); // sin β
    let width = (1.0 - height * height).sqrt();
    (length, vector![a * width * longitude.cos(), a * width * longitude.sin(), b * height])
}

#[test]
fn a_spheroid_by_other_means() {
    let (a, b) = (1.5, 1.0);
    let egg = Ellipsoid { a, b: a, c: b };
    for alpha in [0.1_f64, 0.6, 1.2, 1.5] {
        for (from, to) in [(-0.4, 0.3), (0.2, 1.4), (-0.9, 0.9), (0.5, 0.51)] {
            let ((start, first), (end, last)) = (bessel(a, b, alpha, from), bessel(a, b, alpha, to));
            let way = geodesic_distance(&egg, &first, &last).unwrap();
            let off = way.distance - (end - start);
            assert!(off.abs() < ROUNDING * (end - start).max(1.0), "α₀ = {alpha}, {from} to {to}: {off:e}");
            // Clairaut: the distance from the axis times the part of the direction around it.
            let around = |q: &Vector3<f64>, u: &Vector3<f64>| q.x * u.y - q.y * u.x;
            let kept = around(&first, &way.from) - around(&last, &way.to);
            assert!(kept.abs() < 1e-12, "{kept:e}");
        }
    }
}

/// On a surface without formulas directions are the gradient of the distance.
#[test]
fn directions_are_the_gradient() {
    let surface = Lemniscate { a: 1.0, r: 1.0 / 6.0 };
    let free = Scene::on(surface);
    let place = |q: [f64; 3]| free.project(&State::at(q)).unwrap().positions().next().unwrap();
    let (a, b) = (place([0.3, 0.1, 0.15]), place([0.45, 0.2, 0.12]));
    let way = geodesic_distance(&surface, &a, &b).unwrap();
    let h = 1e-5;
    for u in [vector![1.0, 0.0, 0.0], vector![0.0, 1.0, 0.0], vector![0.3, -0.2, 0.9]] {
        let at = |q: &Vector3<f64>, s: f64| place((q + u * s).into());
        // Places move along the surface: by their way, which is h times a tangent.
        let difference = |q: &Vector3<f64>, d: &dyn Fn(&Vector3<f64>) -> f64, gradient: &Vector3<f64>| {
            let (ahead, behind) = (at(q, h), at(q, -h));
            let found = d(&ahead) - d(&behind);
            assert!((found - gradient.dot(&(ahead - behind))).abs() < 1e-9 * h.sqrt(), "{u}");
        };
        let distance =
            |a: &Vector3<f64>, b: &Vector3<f64>| geodesic_distance(&surface, a, b).unwrap().distance;
        difference(&b, &|b| distance(&a, b), &way.to);
        difference(&a, &|a| distance(a, &b), &-way.from);
    }
}

pair_potential! {
    /// The square of the distance.
    struct Square {}
    |r| r^2
}

/// On the unit sphere the expansion of d² is 2x + x²/3 with x = 1 − cos d, whose series is d² − d⁶/90 + d⁸/1008 − ….
#[test]
fn the_expansion_agrees_to_its_order() {
    let sphere = Sphere { r: 1.0 };
    let off = |angle: f64| {
        let ends = [vector![0.0, 0.0, 1.0], vector![angle.sin(), 0.0, angle.cos()]];
        let scene = Scene::on(sphere).bodies(2).with(Square {}.within(1.0).along(sphere));
        let square = scene.simulate(State::of(ends), Rattle::new(0.01)).unwrap().energy();
        geodesic_distance(&sphere, &ends[0], &ends[1]).unwrap().distance.powi(2) - square
    };
    for d in [0.4_f64, 0.2, 0.1] {
        let part = 90.0 * off(d) / d.powi(6) - (1.0 - 90.0 / 1008.0 * d * d);
        assert!(part.abs() < 0.01 * d.powi(4), "{d}: {part:e}"); // the next term of the series, 0.004 of it
    }
}

pair_potential! {
    /// A soft repulsion.
    struct Soft { strength }
    |r| strength * (1 - r^2 / 0.64)^2
}

/// Twelve bodies on a torus that repel each other up to ways of 0.8, where chords are shorter by a tenth: forces are
/// differences of the energy, and of second order it keeps its error, forth and back; also across a periodic box.
#[test]
fn forces_are_the_gradient_of_the_energy() {
    let torus = Torus { major: 1.2, minor: 0.5 };
    let soft = || Soft { strength: 3.0 }.within(0.8).shifted();
    let scene = Scene::on(torus).bodies(12).with(soft().along_geodesics(torus));
    let places = points::apart(&torus, [-1.8; 3], [1.8; 3], 12, 0.35, 5).unwrap();
    let energy_at = |places: &[Vector3<f64>]| {
        let start = scene.project(&State::of(places.iter().copied())).unwrap();
        (scene.simulate(start.clone(), Rattle::new(0.01)).unwrap().potential_energy(), start)
    };
    let chords = Scene::on(torus).bodies(12).with(soft());
    let start = energy_at(&places).1;
    let by_chords = chords.simulate(start.clone(), Rattle::new(0.01)).unwrap().potential_energy();
    assert!((by_chords - energy_at(&places).0).abs() > 0.01, "ways are longer than chords");

    // One step from rest: p = h f along the surface, to first order in h; so −ΔU/Δs.
    let h = 1e-6;
    let mut simulation = scene.simulate(start, Rattle::new(h)).unwrap();
    simulation.step().unwrap();
    let forces: Vec<_> = simulation.momenta().map(|p| p / h).collect();
    assert!(forces.iter().all(|f| f.norm() < 50.0) && forces.iter().any(|f| f.norm() > 0.5));
    let s = 1e-5;
    for body in 0..12 {
        for u in [vector![1.0, 0.0, 0.0], vector![0.0, 0.6, 0.8]] {
            let moved = |s: f64| {
                let mut places = places.clone();
                places[body] += s * u;
                let (energy, start) = energy_at(&places);
                (energy, start.positions().nth(body).unwrap())
            };
            let ((ahead, to), (behind, from)) = (moved(s), moved(-s));
            let slope = (ahead - behind) / (2.0 * s);
            let exact = -forces[body].dot(&(to - from)) / (2.0 * s);
            assert!((slope - exact).abs() < 1e-6 * (1.0 + exact.abs()), "{body}: {slope} {exact}");
        }
    }

    let start = scene.maxwell(&energy_at(&places).1, 0.5, 3).unwrap();
    let swing = |h: f64| {
        let mut simulation = scene.simulate(start.clone(), Rattle::new(h)).unwrap();
        let mut most = 0.0_f64;
        simulation.run_with((0.6 / h) as u64, |now| most = most.max(now.energy_error().abs())).unwrap();
        most
    };
    let errors = [0.02, 0.01, 0.005].map(swing);
    assert!((1.7..2.3).contains(&crate::common::order(&errors)), "{errors:?}");

    // Bodies that are a period away act as near ones do, on a cylinder that repeats itself.
    let pipe = Cylinder { r: 0.5 };
    let energy = |shift: f64| {
        let two = Scene::on(pipe)
            .bodies(2)
            .with(soft().periodic([f64::INFINITY, f64::INFINITY, 2.0]).along_geodesics(pipe));
        let at = 0.9_f64;
        let start = State::of([[0.5, 0.0, 0.1], [0.5 * at.cos(), 0.5 * at.sin(), 0.4 + shift]]);
        two.simulate(start, Rattle::new(0.01)).unwrap().potential_energy()
    };
    let exact = Soft { strength: 3.0 }.value(0.45_f64.hypot(0.3)) - Soft { strength: 3.0 }.value(0.8);
    assert!((energy(0.0) - exact).abs() < 1e-13 && (energy(4.0) - exact).abs() < 1e-13);
}

#[test]
fn what_is_not_found_is_told() {
    let sphere = Sphere { r: 1.0 };
    let pole = vector![0.0, 0.0, 1.0];
    let same = geodesic_distance(&sphere, &pole, &pole).unwrap();
    assert_eq!((same.distance, same.from.norm(), same.to.norm()), (0.0, 0.0, 0.0));
    let off = geodesic_distance(&sphere, &pole, &vector![0.0, 1.1, 0.0]).unwrap_err();
    assert!(matches!(off, GeodesicError::NotOnSurface { place: "b", .. }), "{off}");
    // Nothing leads from one sphere to another.
    let other = geodesic_distance(&Two {}, &vector![2.0, 0.0, 1.0], &vector![-2.0, 0.0, 1.0]).unwrap_err();
    assert!(matches!(other, GeodesicError::NotFound { .. }), "{other}");
    assert!(other.to_string().contains("misses the end of a chord of 4.000e0"), "{other}");
    assert!(other.to_string().contains("conjugate to a"), "{other}");
}

/// Half of the circumference of a torus lies in nobody's straight way: every two points are joined by a geodesic, and
/// no way over a third point is shorter. The surfaces are symmetric about the origin, which turns a pair: it is shot at
/// from its other end then, and as long. From b to a the same geodesic is told.
#[test]
fn any_two_points() {
    fn check<C: Constraint<3, 1>>(name: &str, surface: &C, half: f64, seed: u64) {
        let number = if cfg!(long) { 9 } else { 4 };
        let places = points::uniform(surface, [-half; 3], [half; 3], number, seed).unwrap();
        let between = |i: usize, j: usize| {
            let way = geodesic_distance(surface, &places[i], &places[j]).unwrap();
            let back = geodesic_distance(surface, &places[j], &places[i]).unwrap();
            assert!(back.distance == way.distance && back.from == -way.to && back.to == -way.from, "{name}");
            if i == j + 1 {
                let turned = geodesic_distance(surface, &-places[i], &-places[j]).unwrap();
                assert!((turned.distance - way.distance).abs() < 1e-12 * way.distance, "{name}: {i}, {j}");
            }
            assert!(way.distance >= (places[i] - places[j]).norm(), "{name}: {i}, {j}");
            way.distance
        };
        let mut distance = vec![vec![0.0; number]; number];
        for i in 0..number {
            for j in 0..i {
                distance[i][j] = between(i, j);
                distance[j][i] = distance[i][j];
            }
        }
        for (i, row) in distance.iter().enumerate() {
            for (j, d) in row.iter().enumerate() {
                for k in 0..number {
                    let over = row[k] + distance[k][j];
                    assert!(*d <= over * (1.0 + 1e-9), "{name}: {i} to {j} {d}, over {k} {over}");
                }
            }
        }
    }
    check("torus", &Torus { major: 1.2, minor: 0.5 }, 1.8, 5);
    check("lemniscate", &Lemniscate { a: 1.0, r: 1.0 / 6.0 }, 1.3, 6);
    check("gyroid", &Gyroid { k: 1.0, epsilon: 0.0 }, 3.0, 7);
}

/// Two places on the faces of a lens, one under the other: their chord is short, and the way goes around the rim, along
/// a meridian there and back.
#[test]
fn around_the_rim_of_a_lens() {
    let (a, c) = (1.0, 0.2);
    let at = |angle: f64, side: f64| vector![a * angle.cos(), 0.0, side * c * angle.sin()];
    for angle in [0.3, 0.7, 1.1] {
        let way = geodesic_distance(&Ellipsoid { a, b: a, c }, &at(angle, 1.0), &at(angle, -1.0)).unwrap();
        // An arc of the ellipse, by Simpson's rule.
        let n = 2000;
        let speed = |t: f64| (a * t.sin()).hypot(c * t.cos());
        let weight = |i: i32| if i == 0 || i == n { 1.0 } else { 2.0 + 2.0 * f64::from(i % 2) };
        let sum: f64 = (0..=n).map(|i| weight(i) * speed(angle * f64::from(i) / f64::from(n))).sum();
        let exact = 2.0 * sum * angle / f64::from(3 * n);
        let off = way.distance - exact;
        assert!(off.abs() < 1e-12 * exact, "{angle}: {} for {exact}", way.distance);
    }
}

/// Ways around nearly half of a circle.
#[test]
fn far_around() {
    let r = 0.8;
    for phi in [2.6_f64, 3.1] {
        let (a, b) = (vector![r, 0.0, 0.3], vector![r * phi.cos(), r * phi.sin(), 1.1]);
        let way = geodesic_distance(&Cylinder { r }, &a, &b).unwrap();
        let exact = (r * phi).hypot(0.8);
        assert!((way.distance - exact).abs() < ROUNDING * exact, "{phi}: {:e}", way.distance - exact);
    }
}

/// Chords along both normals, which say nothing of a direction; on the sphere all ways are as long.
#[test]
fn to_the_opposite() {
    let between = |q: [f64; 3], surface: &Ellipsoid| {
        geodesic_distance(surface, &q.into(), &(-Vector3::from(q))).unwrap().distance
    };
    let r = 1.7;
    let half = between([0.0, r, 0.0], &Ellipsoid { a: r, b: r, c: r });
    assert!((half - r * std::f64::consts::PI).abs() < 1e-11, "{half}");
    // Over the flatter side, half around an ellipse of semi-axes 1 and 0.4.
    let (a, c, n) = (1.0_f64, 0.4_f64, 4000);
    let speed = |i: i32| {
        let t = std::f64::consts::PI * f64::from(i) / f64::from(n);
        (a * t.sin()).hypot(c * t.cos())
    };
    let exact = (0..n).map(speed).sum::<f64>() * std::f64::consts::PI / f64::from(n); // periodic: to rounding
    let over = between([a, 0.0, 0.0], &Ellipsoid { a, b: 0.7, c });
    assert!((over - exact).abs() < 1e-12, "{over} for {exact}");
    // Half of a meridian of a torus, through its hole.
    let inside = geodesic_distance(
        &Torus { major: 1.0, minor: 0.5 },
        &vector![1.5, 0.0, 0.0],
        &vector![0.5, 0.0, 0.0],
    );
    let off = inside.unwrap().distance - 0.5 * std::f64::consts::PI;
    assert!(off.abs() < 1e-12, "{off:e}");
}

constraint! {
    /// A sphere in four dimensions.
    struct Hypersphere { r }
    |a, b, c, d| a^2 + b^2 + c^2 + d^2 - r^2
}

/// Places on a ring around the antipode, π − δ away in units of the radius: nearly conjugate. A rounding of places by ε
/// turns directions by ε/δ.
#[test]
fn around_the_antipode() {
    let pi = std::f64::consts::PI;
    let rings = [(1.0, 0.0_f64), (1e3, 0.7), (2.0, 4.0), (1.0, 2.5), (1.0, 4.0)];
    for (r, turn) in rings.into_iter().take(if cfg!(long) { 5 } else { 3 }) {
        for delta in [3e-3_f64, 1e-3, 1e-5, 1e-8, 1e-12, 0.0] {
            let to = vector![0.0, turn.cos(), turn.sin()];
            let (a, b) = (vector![r, 0.0, 0.0], (to * delta.sin() - Vector3::x() * delta.cos()) * r);
            let way = geodesic_distance(&Sphere { r }, &a, &b).unwrap();
            let off = way.distance / r - (pi - delta);
            assert!(off.abs() < 1e-12, "r = {r}, {turn}, δ = {delta:e}: {off:e}");
            let turned = (way.from - to).norm() * delta;
            assert!(turned < 1e-12, "r = {r}, {turn}, δ = {delta:e}: {turned:e}");
        }
    }
    for delta in [1e-2_f64, 1e-5] {
        let (a, to) = (vector![0.6, 0.8, 0.0, 0.0], vector![-0.64, 0.48, 0.0, 0.6]);
        let way =
            geodesic_distance(&Hypersphere { r: 1.0 }, &a, &(to * delta.sin() - a * delta.cos())).unwrap();
        let off = way.distance - (pi - delta);
        assert!(off.abs() < 1e-12 && (way.from - to).norm() * delta < 1e-12, "δ = {delta:e}: {off:e}");
    }
}

/// Nearly spheres, whose conjugate points lie on an astroid as small as they are flat, by Bessel's integrals. A
/// geodesic of an oblate spheroid is the shortest one until it has come to the opposite latitude (σ = π), that of a
/// prolate one until it has come to the opposite meridian.
#[test]
fn near_the_antipodes_of_spheroids() {
    for (a, b, gaps) in [(1.0001, 1.0, [1e-3, 1e-5, 1e-7]), (1.0, 1.0001, [1e-2, 2e-3, 5e-4])] {
        for (gap, alpha) in gaps.into_iter().zip([0.6_f64, 1.2, 0.1]) {
            let sigma = -0.4;
            let (start, first) = bessel(a, b, alpha, sigma);
            let (end, last) = bessel(a, b, alpha, sigma + std::f64::consts::PI - gap);
            assert!(first.cross(&last).z > 0.0, "the opposite meridian is not passed");
            let way = geodesic_distance(&Ellipsoid { a, b: a, c: b }, &first, &last).unwrap();
            let off = way.distance - (end - start);
            assert!(off.abs() < 1e-12, "{a}, {b}, {gap:e}: {off:e}");
        }
    }
}

/// The outer equator of a torus is the shortest way until its conjugate point, at φ = π √(r/(R + r)). Beyond it two
/// ways are as long, mirror images of each other, and each of itself in the meridian half way.
#[test]
fn near_the_conjugate_point_of_an_equator() {
    let (major, minor) = (1.0_f64, 0.5);
    let (torus, out) = (Torus { major, minor }, major + minor);
    let start = vector![out, 0.0, 0.0];
    let to = |b: Vector3<f64>| geodesic_distance(&torus, &start, &b).unwrap().distance;
    for gap in [-1e-3, -1e-6, 1e-3, 1e-2].into_iter().take(if cfg!(long) { 4 } else { 3 }) {
        let phi = std::f64::consts::PI * (minor / out).sqrt() + gap;
        let found = to(vector![out * phi.cos(), out * phi.sin(), 0.0]);
        let half = |theta: f64| {
            let wide = major + minor * theta.cos();
            2.0 * to(vector![wide * (0.5 * phi).cos(), wide * (0.5 * phi).sin(), minor * theta.sin()])
        };
        let over_the_side = || {
            let (mut low, mut high) = (0.0, 0.8);
            // Of second order in what is left of the angle.
            for _ in 0..28 {
                let (left, right) = (low + 0.4 * (high - low), low + 0.6 * (high - low));
                (low, high) = if half(left) < half(right) { (low, right) } else { (left, high) };
            }
            half(0.5 * (low + high))
        };
        let exact = if gap < 0.0 { out * phi } else { over_the_side() };
        assert!((found - exact).abs() < 1e-12, "{gap}: {:e}", found - exact);
        assert!(gap < 0.0 || exact < out * phi - 1e-7, "{gap}: the equator is longer");
    }
}

constraint! {
    /// Spheres of radius 1 about (±2, 0, 0).
    struct Two {}
    |x, y, z| (abs(x) - 2)^2 + y^2 + z^2 - 1
}

/// Distances along another surface than that on which bodies are: refused at the start, and told. Other levels of the
/// same function are right.
#[test]
fn distances_along_another_surface_are_refused() {
    let sphere = Sphere { r: 1.0 };
    let a = 0.6_f64;
    let both = State::of([[0.0, 0.0, 1.0], [a.sin(), 0.0, a.cos()]]);
    let around = State::of([[0.6, 0.0, 0.8], [0.0, 0.6, 0.8]]);
    let scene = || Scene::on(sphere).bodies(2);
    let soft = || Soft { strength: 3.0 }.within(3.0).shifted();
    let method = Rattle::new(1e-3);
    let told = |result: Result<(), rattle::Error>| {
        let told = result.expect_err("refused").to_string();
        assert!(told.contains("the surface on which bodies are"), "{told}");
    };
    let floor = rattle::surfaces::Plane { a: 0.0, b: 0.0, c: 1.0, d: 5.0 };
    told(scene().with(soft().along(floor)).simulate(both.clone(), method).map(drop));
    told(scene().with(soft().along_geodesics(floor)).simulate(both.clone(), method).map(drop));
    // On the ellipsoid's level, and with another normal.
    let long = Ellipsoid { a: 1.0, b: 1.0, c: 3.0 };
    told(scene().with(soft().along(long)).simulate(around.clone(), method).map(drop));
    told(scene().with(soft().along_geodesics(long)).simulate(around.clone(), method).map(drop));
    told(scene().with(soft().along(long)).ensemble(vec![around.clone()], method).map(drop));
    // Links have no normals here, but levels.
    let linked = Scene::points(2).link(sphere, [[0], [1]]);
    told(linked.clone().with(soft().along(floor)).simulate(both.clone(), method).map(drop));
    told(linked.clone().with(soft().along_geodesics(floor)).simulate(both.clone(), method).map(drop));

    // Spheres of any radius have the distances of this one; and bodies that do not meet are anywhere.
    for r in [1.0, 0.3, 2.0] {
        let right = |energy: f64| {
            let exact = Soft { strength: 3.0 }.value(a) - Soft { strength: 3.0 }.value(3.0);
            assert!((energy - exact).abs() < 5e-3, "{r}: {energy} {exact}"); // of the expansion
        };
        let other = Sphere { r };
        right(scene().with(soft().along(other)).simulate(both.clone(), method).unwrap().energy());
        right(scene().with(soft().along_geodesics(other)).simulate(both.clone(), method).unwrap().energy());
        right(linked.clone().with(soft().along(other)).simulate(both.clone(), method).unwrap().energy());
    }
    let apart = Scene::points(3).link(sphere, [[0], [1]]).pin(2, [0.0, 0.0, 9.0]);
    let three = State::of([[0.0, 0.0, 1.0], [a.sin(), 0.0, a.cos()], [0.0, 0.0, 9.0]]);
    apart.clone().with(soft().along(sphere)).simulate(three.clone(), method).unwrap();
    apart.with(soft().along_geodesics(sphere)).simulate(three, method).unwrap();
}
