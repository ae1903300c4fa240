//! Distances along surfaces far from the origin, far along them, near the origin, and in periodic boxes: what rounds a
//! place is no fault of the surface, and no excuse for a place off it.

use rattle::curvature::{GeodesicError, geodesic_distance};
use rattle::nalgebra::{Vector3, vector};
use rattle::prelude::*;
use rattle::surfaces::{Cylinder, Gyroid, Sphere};
use std::f64::consts::{PI, TAU};

constraint! {
    /// A sphere of radius 1 about a point.
    struct Ball { x0, y0, z0 }
    |x, y, z| (x - x0)^2 + (y - y0)^2 + (z - z0)^2 - 1
}

pair_potential! {
    /// A soft push.
    struct Soft { strength }
    |r| strength * exp(-r^2)
}

/// Two places on the unit sphere, so far apart along it.
fn on_unit_sphere(angle: f64) -> [Vector3<f64>; 2] {
    let (u, w) = (vector![0.6, 0.0, 0.8], vector![0.48, 0.8, -0.36]);
    [u, u * angle.cos() + w * angle.sin()]
}

/// Far from the origin places are rounded, and by as much a distance may be off; the directions by that part of it.
#[test]
fn spheres_far_from_the_origin() {
    for centre in [[1e4, 1e4, 1e4], [1e5; 3], [1e6, 0.0, 0.0], [5e5, 5.6e6, 0.0], [0.0, 1e9, 1e9]] {
        let [x0, y0, z0] = centre;
        let (ball, centre) = (Ball { x0, y0, z0 }, Vector3::from(centre));
        let rounding = f64::EPSILON * centre.amax();
        for angle in [0.5_f64, 0.05, 0.2] {
            let [a, b] = on_unit_sphere(angle).map(|q| q + centre);
            let way = geodesic_distance(&ball, &a, &b);
            let way = way.unwrap_or_else(|error| panic!("{centre:?}, {angle}: {error}"));
            // As they are rounded.
            let [u, w] = [a, b].map(|q| (q - centre).normalize());
            let exact = u.cross(&w).norm().atan2(u.dot(&w));
            let off = way.distance - exact;
            assert!(off.abs() < 10.0 * rounding, "{centre:?}, {angle}: {off:e}, {rounding:e}");
            let from = (w - u * exact.cos()) / exact.sin();
            let turned = (way.from - from).norm();
            assert!(turned < 10.0 * rounding / angle, "{centre:?}, {angle}: {turned:e}");
        }
    }
}

/// What does not come nearer by rounding is not tried in ever shorter stretches.
#[test]
fn ways_far_from_the_origin_are_as_cheap() {
    let asked = |x0: f64| {
        let ball = Counted::new(Ball { x0, y0: 0.0, z0: 0.0 });
        let [a, b] = on_unit_sphere(0.5).map(|q| q + vector![x0, 0.0, 0.0]);
        geodesic_distance(&ball, &a, &b).unwrap();
        ball.counts().gradients()
    };
    let home = asked(0.0);
    for x0 in [1e2, 1e4, 1e6] {
        let far = asked(x0);
        assert!(far < 4 * home, "{x0:e}: {far}, at home {home}");
    }
}

/// On a surface that repeats itself bodies may be any number of periods away; how far they are from each other is
/// rounded by what their places are.
#[test]
fn pairs_any_number_of_periods_away() {
    let gyroid = Gyroid { k: 1.0, epsilon: 0.0 };
    let home = Scene::on(gyroid).bodies(2);
    let start = State::of([[0.4, 0.3, 2.9], [1.1, 0.2, 2.4]]);
    let start: Vec<Vector3<f64>> = home.project(&start).unwrap().positions().collect();
    let energy = |periods: [f64; 2]| {
        let soft = Soft { strength: 3.0 }.within(1.5).shifted().periodic([TAU; 3]).along_geodesics(gyroid);
        let away = start.iter().zip(periods).map(|(q, n)| q + vector![n, -n, 2.0 * n] * TAU);
        let scene = Scene::on(gyroid).bodies(2).with(soft);
        let run = scene.simulate(State::of(away), Rattle::new(0.01));
        run.unwrap_or_else(|error| panic!("{periods:?}: {error}")).potential_energy()
    };
    let exact = energy([0.0, 0.0]);
    assert!(exact > 0.5, "{exact}: within reach");
    for (n, m) in [(1.0, 0.0), (100.0, 100.0), (1e4, -1e4), (1e5, 1e5), (0.0, 1e5)] {
        let off = energy([n, m]) - exact;
        let rounding = f64::EPSILON * 2.0 * TAU * f64::max(n.abs(), f64::abs(m));
        assert!(off.abs() < 10.0 * rounding + 1e-14, "{n}, {m}: {off:e}, {rounding:e}");
    }
}

/// A coordinate along an axis that the surface does not know excuses nothing across it.
#[test]
fn places_are_as_near_far_along_as_elsewhere() {
    for z in [0.0, 1e8] {
        let at = |r: f64, angle: f64| vector![r * angle.cos(), r * angle.sin(), z];
        let between = |r: f64| geodesic_distance(&Cylinder { r: 1.0 }, &at(r, 0.0), &at(r, 1.0));
        assert!((between(1.0).unwrap().distance - 1.0).abs() < 1e-13, "z = {z:e}");
        for off in [0.05, 1e-6, 2e-9] {
            let found = between(1.0 + off);
            assert!(matches!(found, Err(GeodesicError::NotOnSurface { .. })), "z = {z:e}, {off}: {found:?}");
        }
        // One body on the tube, another beside it.
        let beside = |r: f64| {
            let scene = Scene::points(2).link(Cylinder { r: 1.0 }, [[0]]).link(Cylinder { r }, [[1]]);
            let scene = scene.with(Soft { strength: 3.0 }.within(2.0).shifted().along(Cylinder { r: 1.0 }));
            scene.simulate(State::of([at(1.0, 0.0), at(r, 1.0)]), Rattle::new(0.01)).map(drop)
        };
        beside(1.0).unwrap();
        for r in [1.05, 1.0 + 1e-6] {
            let told = beside(r).expect_err("refused").to_string();
            assert!(told.contains("the surface on which bodies are"), "z = {z:e}: {told}");
        }
    }
}

constraint! {
    /// Hyperbolas.
    struct Product {}
    |x, y, _z| x * y
}

/// A body far away, where g is steep, hides no other.
#[test]
fn levels_are_compared_pair_by_pair() {
    let scene = |x: f64| {
        let scene = Scene::points(3).pin(0, [x, 1.0 / x, 0.0]);
        let soft = Soft { strength: 3.0 }.within(2.0).shifted().along(Product {});
        let start = State::of([[x, 1.0 / x, 0.0], [1.0, 1.0, 0.0], [1.1, 1.1, 0.0]]);
        scene.with(soft).simulate(start, Rattle::new(0.01)).map(drop)
    };
    for x in [1e2, 1e8] {
        let told = scene(x).expect_err("refused").to_string();
        assert!(told.contains("the surface on which bodies are"), "x = {x:e}: {told}");
    }
}

constraint! {
    /// A ball on the floor.
    struct OnFloor { r }
    |x, y, z| x^2 + y^2 + (z - r)^2 - r^2
}

/// Where coordinates are all small, g is rounded to what it is made of: no double is nearer to the surface.
#[test]
fn near_the_origin_g_is_rounded() {
    for x in [1.2e-8_f64, 3e-8, 1e-10, 1e-5, 1e-2] {
        let ball = OnFloor { r: 1.0 };
        let a = vector![x, 0.0, x * x / (1.0 + (1.0 - x * x).sqrt())];
        let start = State::at(a).moving([0.0, 1.0, 0.0]);
        Scene::on(ball).simulate(start, Rattle::new(1e-3)).unwrap();
        let way = geodesic_distance(&ball, &a, &Vector3::zeros()).unwrap();
        // The chord is shorter by a part of x²/24: 4e-6 and 4e-12 of the last two.
        assert!((way.distance - x.asin()).abs() < 1e-13 * x, "{x:e}: {:e}", way.distance - x.asin());
        let off = geodesic_distance(&ball, &vector![x, 0.0, 1e-3 * x], &Vector3::zeros());
        assert!(matches!(off, Err(GeodesicError::NotOnSurface { place: "a", .. })), "{x:e}: {off:?}");
    }
}

constraint! {
    /// The diamond surface of Schwarz: half a period along one axis changes the sign of g, and nothing else.
    struct Diamond {}
    |x, y, z| cos(x) * cos(y) * cos(z) - sin(x) * sin(y) * sin(z)
}

/// A box after which the surface does not repeat itself is refused, and told.
#[allow(clippy::approx_constant, reason = "periods that are nearly those of the surface")]
#[test]
fn boxes_have_the_periods_of_their_surfaces() {
    let soft = || Soft { strength: 3.0 }.within(1.0).shifted();
    fn told(result: Result<(), rattle::Error>) {
        let told = result.expect_err("refused").to_string();
        assert!(told.contains("does not repeat itself"), "{told}");
        assert!(told.contains("infinite"), "{told}");
    }
    let gyroid = Gyroid { k: 1.0, epsilon: 0.0 };
    let scene = Scene::on(gyroid).bodies(2);
    let home = scene.project(&State::of([[0.4, 0.3, 2.9], [2.1, 0.2, 5.4]])).unwrap();
    let run = |periods: [f64; 3], away: f64| {
        let start = State::of(home.positions().map(|q| q + vector![away, 0.0, -away]));
        let along = scene.with(soft().periodic(periods).along(gyroid));
        let geodesics = scene.with(soft().periodic(periods).along_geodesics(gyroid));
        let method = Rattle::new(0.01);
        [along.simulate(start.clone(), method).map(drop), geodesics.simulate(start, method).map(drop)]
    };
    for periods in [[6.28; 3], [TAU, TAU, 6.2832], [PI, TAU, TAU], [TAU, f64::INFINITY, 7.0]] {
        run(periods, 0.0).into_iter().for_each(told);
    }
    for (periods, away) in [
        ([TAU; 3], 0.0),
        ([6.283_185_307_18; 3], 0.0),
        ([TAU, 2.0 * TAU, f64::INFINITY], 0.0),
        ([TAU; 3], 1e5 * TAU),
        ([TAU; 3], 1e8 * TAU),
    ] {
        for result in run(periods, away) {
            result.unwrap_or_else(|error| panic!("{periods:?}, {away}: {error}"));
        }
    }

    // Opposite places of a tube: one level, and one line for their normals.
    let tube = Cylinder { r: 1.0 };
    let opposite = State::of([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.3]]);
    let small = soft().periodic([2.0, f64::INFINITY, f64::INFINITY]);
    let scene = Scene::on(tube).bodies(2);
    told(scene.with(small.along_geodesics(tube)).simulate(opposite, Rattle::new(0.01)).map(drop));

    // Normals point the other way, which d² by them asks, and the length of a way does not.
    let scene = Scene::on(Diamond {}).bodies(2);
    let start = scene.project(&State::of([[1.5, 0.1, 0.1], [1.4, 0.3, 0.0]])).unwrap();
    let half = soft().periodic([PI, TAU, TAU]);
    told(scene.with(half.along(Diamond {})).simulate(start.clone(), Rattle::new(0.01)).map(drop));
    scene.with(half.along_geodesics(Diamond {})).simulate(start, Rattle::new(0.01)).unwrap();
}

/// Along a surface bodies are looked for farther away than the reach, and what is asked of a box says so.
#[test]
fn a_box_is_told_how_far_bodies_are_looked_for() {
    let gyroid = Gyroid { k: 1.0, epsilon: 0.0 };
    let soft = Soft { strength: 3.0 }.within(2.5).shifted().periodic([6.0; 3]).along(gyroid);
    let told = Scene::on(gyroid).bodies(2).with(soft).simulate(State::of([[0.0; 3]; 2]), Rattle::new(0.01));
    let told = told.expect_err("refused").to_string();
    assert!(told.contains("reaches as far as 2.5,") && told.contains("1.225"), "{told}");
}

/// Where there is no normal, or no number, no place is on the surface, and that is told.
#[test]
fn places_without_a_normal_are_refused() {
    let refused = |place: Vector3<f64>, other: Vector3<f64>| {
        for [a, b] in [[place, other], [other, place]] {
            let found = geodesic_distance(&Sphere { r: 1.0 }, &a, &b);
            assert!(matches!(found, Err(GeodesicError::NotOnSurface { .. })), "{a:?}: {found:?}");
        }
    };
    let pole = vector![0.0, 0.0, 1.0];
    let none = f64::NAN;
    for place in [
        [0.0; 3],
        [none, 0.0, 1.0],
        [0.0, 0.0, none],
        [none; 3],
        [f64::INFINITY, 0.0, 0.0],
        [1e200, 0.0, 0.0],
    ] {
        refused(Vector3::from(place), pole);
    }
}
