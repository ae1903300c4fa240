//! Geometry where normals or curvatures jump: ways that lead over edges, and ways over bumps that end at a circle.

use rattle::curvature::{Curvature, GeodesicError, geodesic_distance};
use rattle::nalgebra::{Vector3, vector};
use rattle::prelude::*;
use rattle::surfaces::{GaussianBump, Torus};

constraint! {
    /// A cylinder of radius 1 and height 2, with its caps.
    struct Can {}
    |x, y, z| max(norm(x, y), abs(z)) - 1
}

constraint! {
    /// A cube of side 2.
    struct Cube {}
    |x, y, z| max(abs(x), abs(y), abs(z)) - 1
}

/// A place of the can's side.
fn on_the_side(angle: f64, z: f64) -> Vector3<f64> {
    vector![angle.cos(), angle.sin(), z]
}

/// Near the rim of a can the shortest way leads over the cap: 2.005 instead of 2.9 around. It is not followed over the
/// edge, and told. The way around is right where it is the shortest.
#[test]
fn what_is_shorter_over_an_edge_is_told() {
    let (a, b) = (on_the_side(0.0, 0.99), on_the_side(2.9, 0.99));
    for (a, b) in [(a, b), (b, a)] {
        let told = geodesic_distance(&Can {}, &a, &b).unwrap_err();
        let GeodesicError::NotFound { chord, length, .. } = told else { panic!("{told}") };
        assert!((length / 2.0053 - 1.0).abs() < 0.01 && chord < length, "{length}");
        let told = told.to_string();
        assert!(told.contains("not followed to its end") && told.contains("beyond an edge"), "{told}");
    }
    // Farther from the rim only ways through points of the graph tell, which are joined over edges.
    for (angle, [z, w], over) in
        [(2.77383, [0.67616, 0.94112], 2.34099), (1.77752, [-0.89854, -0.95123], 1.66595)]
    {
        let told = geodesic_distance(&Can {}, &on_the_side(0.0, z), &on_the_side(angle, w)).unwrap_err();
        let GeodesicError::NotFound { length, .. } = told else { panic!("{told}") };
        assert!((length / over - 1.0).abs() < 0.02, "{angle}: {length} {over}");
    }
    for (angle, z) in [(0.3, 0.1), (1.5, -0.4), (2.0, 0.2)] {
        let way = geodesic_distance(&Can {}, &on_the_side(0.0, 0.0), &on_the_side(angle, z)).unwrap();
        assert!((way.distance / angle.hypot(z) - 1.0).abs() < 1e-12, "{angle}, {z}: {}", way.distance);
    }
    let way = geodesic_distance(&Cube {}, &vector![1.0, -0.5, 0.3], &vector![1.0, 0.7, -0.4]).unwrap();
    assert!((way.distance - 1.2_f64.hypot(0.7)).abs() < 1e-13, "{}", way.distance);
    let told = geodesic_distance(&Cube {}, &vector![1.0, 0.2, 0.1], &vector![0.3, 1.0, -0.2]).unwrap_err();
    assert!(matches!(told, GeodesicError::NotFound { .. }), "{told}");
}

/// The curvature of the ready-made bump jumps at two circles. Each is passed by halving, twice on a way over the top;
/// straight ways are as long as their profile.
#[test]
fn ways_over_bumps_whose_curvature_jumps() {
    let bump = GaussianBump { a: 0.3, l: 0.5, inner: 1.0, outer: 1.5 };
    let at = |x: f64, y: f64| vector![x, y, -bump.value(&vector![x, y, 0.0])[0]];
    // The way over the top, by Simpson's rule along a radius.
    let profile = |from: f64, to: f64| {
        let n = 20_000;
        let h = (to - from) / f64::from(n);
        let rate = |x: f64| {
            let gradient = bump.jacobian(&at(x, 0.0));
            (1.0 + (gradient[0] / gradient[2]).powi(2)).sqrt()
        };
        let part = |i: i32| {
            let x = from + f64::from(i) * h;
            h / 6.0 * (rate(x) + 4.0 * rate(x + 0.5 * h) + rate(x + h))
        };
        (0..n).map(part).sum::<f64>()
    };
    let (every, scattered) = if cfg!(long) { (1, 20) } else { (4, 8) };
    for k in (0..12).step_by(every) {
        let (sin, cos) = (0.2 + 0.5 * f64::from(k)).sin_cos();
        let radius = 1.55 + 0.04 * f64::from(k);
        let (a, b) = (at(radius * cos, radius * sin), at(-2.0 * cos, -2.0 * sin));
        let way = geodesic_distance(&bump, &a, &b).unwrap_or_else(|told| panic!("{k}: {told}"));
        // The way over the top, unless one around it is shorter.
        let over = profile(-2.0, radius);
        assert!(
            way.distance < over * (1.0 + 1e-9) && way.distance > 2.0 + radius,
            "{k}: {} {over}",
            way.distance
        );
    }
    // A scatter of ways that cross the circles anywhere.
    for k in 1..=scattered {
        let share = |n: f64| 4.0 * (n * f64::from(k)).fract() - 2.0;
        let (a, b) =
            (at(share(0.754_877_666), share(0.569_840_291)), at(share(0.618_033_989), share(0.414_213_562)));
        let way = geodesic_distance(&bump, &a, &b).unwrap_or_else(|told| panic!("{k}: {told}"));
        let chord = (b - a).norm();
        assert!((chord..1.3 * chord).contains(&way.distance), "{k}: {} of {chord}", way.distance);
    }
}

/// Along the normal there is no direction: NaN, as promised, however rounding fell. Along the rest of a vector there
/// is.
#[test]
fn no_curvature_along_the_normal() {
    let torus = Torus { major: 1.0, minor: 0.5 };
    for i in 0..50 {
        let (u, v) = (0.3 + f64::from(i), 1.1 * f64::from(i));
        let r = 1.0 + 0.5 * v.cos();
        let q = vector![r * u.cos(), r * u.sin(), 0.5 * v.sin()];
        let gradient = torus.jacobian(&q).transpose();
        for along in [gradient, gradient.normalize(), -1e-150 * gradient, 1e3 * gradient] {
            let kappa = torus.normal_curvature(&q, &along);
            assert!(kappa.is_nan(), "{i}: {kappa}");
        }
        let meridian = vector![-v.sin() * u.cos(), -v.sin() * u.sin(), v.cos()];
        let kappa = torus.normal_curvature(&q, &(meridian + 1e3 * gradient));
        assert!((kappa.abs() - 2.0).abs() < 1e-9, "{i}: {kappa}");
    }
}
