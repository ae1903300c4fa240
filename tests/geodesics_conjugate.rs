//! Beyond a point conjugate to its start a geodesic is not the shortest, however many such points it has passed, and
//! however little longer than the chord it is.

use rattle::curvature::geodesic_distance;
use rattle::nalgebra::{SVector, Vector3, vector};
use rattle::prelude::*;
use rattle::surfaces::{Ellipsoid, Helicoid, Torus};
use std::f64::consts::{FRAC_PI_2, PI};

/// Length of the way between two points of the equator of a spheroid, by their angle, that leads over one of its
/// sides: by Clairaut's integrals, which trapezoids give to rounding.
fn over_the_side(c: f64, angle: f64) -> f64 {
    let integrals = |top: f64| {
        let number = 4000;
        let (mut turned, mut length) = (0.0, 0.0);
        for i in 0..number {
            let w = (f64::from(i) + 0.5) * PI / f64::from(number);
            let sine = top.sin() * w.sin();
            let square = 1.0 - sine * sine;
            let speed = (sine * sine + c * c * square).sqrt();
            turned += top.cos() / square * speed;
            length += speed;
        }
        [turned, length].map(|sum| sum * PI / f64::from(number))
    };
    // The higher it leads, the farther it turns about the axis: from πc to π, over the pole.
    let (mut low, mut high) = (1e-9, FRAC_PI_2 - 1e-3);
    for _ in 0..100 {
        let top = 0.5 * (low + high);
        *(if integrals(top)[0] < angle { &mut low } else { &mut high }) = top;
    }
    integrals(low)[1]
}

/// Beyond a conjugate point the way that the chord leads to is not the shortest, however little longer than the chord
/// it is.
#[test]
fn beyond_a_conjugate_point_ways_lead_aside() {
    let on_equator = |angle: f64| Vector3::new(angle.cos(), angle.sin(), 0.0);
    // As many conjugate points lie on the equator as πc is contained in the angle.
    for (c, angles) in [
        (0.02, vec![10.5 * PI * 0.02]),
        (
            0.03,
            vec![1.01, 1.5, 1.99, 2.01, 2.5, 4.5, 6.5].into_iter().map(|times| times * PI * 0.03).collect(),
        ),
        (0.03, vec![0.8, 1.49]),
        (0.1, vec![0.4, 1.0, 1.3, 1.49, 1.51]),
        (0.3, vec![1.0, 1.49]),
    ] {
        let plate = Ellipsoid { a: 1.0, b: 1.0, c };
        for angle in angles {
            let found = geodesic_distance(&plate, &on_equator(0.0), &on_equator(angle)).unwrap().distance;
            let right = over_the_side(c, angle);
            assert!((found - right).abs() < 1e-9, "c = {c}, {angle}: {found} for {right}");
            assert!(right < angle);
        }
        // Before it the equator is the shortest.
        let near = 0.9 * PI * c;
        let found = geodesic_distance(&plate, &on_equator(0.0), &on_equator(near)).unwrap().distance;
        assert!((found - near).abs() < 1e-13, "{found} {near}");
    }
}

/// Length of the way between two points of the outer equator of a torus of radii 1 and r, by their angle, that leads
/// over one side of the tube: by Clairaut's integrals in w, where sin(θ/2) = k sin w, which trapezoids give to
/// rounding.
fn over_the_tube(r: f64, angle: f64) -> f64 {
    let integrals = |k: f64| {
        let number = 4000;
        let kept = 1.0 + r * (1.0 - 2.0 * k * k);
        let (mut turned, mut length) = (0.0, 0.0);
        for i in 0..number {
            let w = (f64::from(i) + 0.5) * PI / f64::from(number);
            let square = (k * w.cos()).powi(2);
            let wide = 1.0 + r * (1.0 - 2.0 * square);
            let share = (2.0 * r / ((1.0 - square) * (wide + kept))).sqrt();
            turned += share * kept / wide;
            length += share * wide;
        }
        [turned, length].map(|sum| sum * PI / f64::from(number))
    };
    // The farther around the tube it leads, the farther about the axis: from π√(r/(1 + r)) on.
    let (mut low, mut high) = (1e-9, 1.0 - 1e-9);
    for _ in 0..100 {
        let k = 0.5 * (low + high);
        *(if integrals(k)[0] < angle { &mut low } else { &mut high }) = k;
    }
    integrals(low)[1]
}

/// A thin tube that is bent into a torus: the outer equator passes a conjugate point each π√(r/(1 + r)).
#[test]
fn beyond_conjugate_points_of_a_thin_tube() {
    let r = 0.003_f64;
    let torus = Torus { major: 1.0, minor: r };
    let on_equator = |angle: f64| (1.0 + r) * vector![angle.cos(), angle.sin(), 0.0];
    let to = |angle: f64| geodesic_distance(&torus, &on_equator(0.0), &on_equator(angle)).unwrap().distance;
    let first = PI * (r / (1.0 + r)).sqrt();
    for angle in [1.5, 2.5].map(|times| times * first) {
        let (found, right) = (to(angle), over_the_tube(r, angle));
        // Of ways that differ by less than a thousandth one is looked at: another leads around the whole tube.
        assert!(found > right - 1e-9 && found < 1.001 * right, "{angle}: {found} for {right}");
        assert!(found < (1.0 - 1e-4) * (1.0 + r) * angle, "{angle}: {found}, as the equator");
    }
    let near = 0.99 * first;
    assert!((to(near) - (1.0 + r) * near).abs() < 1e-13);
}

constraint! {
    /// A plate in four dimensions, thin in two of them.
    struct Plate { c }
    |x, y, z, w| x^2 + y^2 + (z^2 + w^2) / c^2 - 1
}

/// Each point conjugate to the start is one in two directions at once, after which ways beside are no mirror images.
#[test]
fn beyond_points_that_are_conjugate_in_two_directions() {
    let c = 0.1;
    let on_equator = |angle: f64| -> SVector<f64, 4> { vector![angle.cos(), angle.sin(), 0.0, 0.0] };
    let to =
        |angle: f64| geodesic_distance(&Plate { c }, &on_equator(0.0), &on_equator(angle)).unwrap().distance;
    for angle in [1.05, 1.5, 2.02, 2.2].map(|times| times * PI * c) {
        let (found, right) = (to(angle), over_the_side(c, angle));
        assert!((found - right).abs() < 1e-9, "{angle}: {found} for {right}");
        assert!(right < angle);
    }
    let near = 0.99 * PI * c;
    assert!((to(near) - near).abs() < 1e-13);
}

constraint! {
    /// A disk whose rim is blunt but for one sharp stretch, which is about as long as 2w, beside y = aside.
    struct Sharpened { s, w, aside }
    |x, y, z| x^2 + y^2 + z^2 * (1 + s / (1 + ((y - aside) / w)^4)) - 1
}

fn on_rim(angle: f64) -> Vector3<f64> {
    Vector3::new(angle.cos(), angle.sin(), 0.0)
}

/// Between blunt stretches of a rim, which is 0.6 long, lies a sharp one on which a way passes one to five conjugate
/// points, as s grows: both ends tell nothing of them. Ways over a side are shorter. Each is two of half the length, to
/// the plane of symmetry.
#[test]
fn conjugate_points_between_places_that_are_not_curved() {
    let (a, b) = (on_rim(-0.3), on_rim(0.3));
    let sharp = [2000.0, 4000.0, 10_000.0, 2500.0, 3000.0, 5000.0, 6000.0, 8000.0];
    for s in sharp.into_iter().take(if cfg!(long) { 8 } else { 3 }) {
        let rim = Sharpened { s, w: 0.04, aside: 0.0 };
        let found = geodesic_distance(&rim, &a, &b).unwrap().distance;
        assert!(found < 0.6 - 1e-4, "s = {s}: {found}");
        assert!(found > (b - a).norm());
        // Where it is the shortest to that plane it ends across it: by regula falsi (Illinois) from the rim to the top.
        let high = 1.0 / (1.0 + s).sqrt();
        let to = |angle: f64| {
            let half = geodesic_distance(&rim, &a, &vector![angle.cos(), 0.0, high * angle.sin()]).unwrap();
            let longer = half.to.dot(&vector![-angle.sin(), 0.0, high * angle.cos()]);
            (longer, half.distance)
        };
        let mut ends = [0.02, 1.0].map(|angle| (angle, to(angle).0));
        assert!(ends[0].1 < 0.0 && ends[1].1 > 0.0, "s = {s}: {ends:?}");
        let mut half = f64::NAN;
        for _ in 0..30 {
            let [(low, down), (top, up)] = ends;
            let angle = (low * up - top * down) / (up - down);
            let (longer, distance) = to(angle);
            half = distance;
            // Of second order in what is left of the slope.
            if longer.abs() < 1e-7 {
                break;
            }
            let (same, other) = if longer > 0.0 { (1, 0) } else { (0, 1) };
            ends[same] = (angle, longer);
            ends[other].1 *= 0.5;
        }
        assert!((found - 2.0 * half).abs() < 1e-11, "s = {s}: {found}, twice {half}");
    }
}

/// The same from the other end: of a disk and its mirror image, from the blunter end and from the sharper one.
#[test]
fn conjugate_points_are_passed_from_either_end() {
    for s in [2500.0, 5000.0, 10_000.0] {
        let [one, other] = [0.1, -0.1].map(|aside| {
            let rim = Sharpened { s, w: 0.04, aside };
            geodesic_distance(&rim, &on_rim(-0.3), &on_rim(0.3)).unwrap().distance
        });
        assert!((one - other).abs() < 1e-12, "s = {s}: {one}, {other}");
        assert!(one < 0.6 - 1e-4, "s = {s}: {one}");
    }
}

/// Evaluations of a surface for a distance, which is this one.
fn asked<C: Constraint<D, 1>, const D: usize>(surface: C, ends: [SVector<f64, D>; 2], right: f64) -> f64 {
    let surface = Counted::new(surface);
    let found = geodesic_distance(&surface, &ends[0], &ends[1]).unwrap().distance;
    assert!((found - right).abs() < 1e-13 * right.max(1.0), "{found} for {right}");
    surface.counts().all() as f64
}

/// Where K < 0 no point is conjugate, and none is looked for aside: ways beside go away by e^(√−K l), up to e¹⁰⁰ here,
/// in as many stretches as √−K l is long.
#[test]
fn saddles_have_no_conjugate_points() {
    let helicoid = |l: f64| asked(Helicoid { c: 0.1 }, [Vector3::zeros(), 0.1 * l * Vector3::z()], 0.1 * l);
    let near = helicoid(5.0);
    for l in [10.0, 20.0, 40.0, 100.0] {
        let far = helicoid(l);
        assert!(far < 2.0 * l / 5.0 * near, "{l}: {far}, at 5 {near}");
    }
    // √−K is 1/√(r (1 − r)), and the inner equator 1 − r times its angle.
    let inner = |r: f64, angle: f64| {
        let at = |angle: f64| (1.0 - r) * vector![angle.cos(), angle.sin(), 0.0];
        asked(Torus { major: 1.0, minor: r }, [at(0.0), at(angle)], (1.0 - r) * angle)
    };
    let (thick, thin) = (inner(0.02, 0.68), inner(0.001, 0.68));
    assert!(thin < 2.0 * 20_f64.sqrt() * thick, "{thin}, on a thick one {thick}");
}

constraint! {
    /// A disk whose rim goes over into one of a saddle, K = s y.
    struct Turning { s }
    |x, y, z| x^2 + y^2 + s * y * z^2 - 1
}

/// Behind a saddle in which ways beside have gone away by e⁸ to e⁵⁰, the conjugate point lies where they say: at the
/// first zero of J″ = −K J along the rim, here by the method of Störmer.
#[test]
fn behind_saddles_points_are_conjugate() {
    for s in [5e3, 2e4, 2e5] {
        let (h, mut angle, mut pair) = (1e-6, -0.3_f64, [0.0, 1e-6]);
        while pair[1] > 0.0 {
            angle += h;
            pair = [pair[1], (2.0 - h * h * s * angle.sin()) * pair[1] - pair[0]];
        }
        let asks = |angle: f64| {
            let rim = Counted::new(Turning { s });
            let found = geodesic_distance(&rim, &on_rim(-0.3), &on_rim(angle)).unwrap().distance;
            (rim.counts().all(), found - 0.3 - angle)
        };
        // Beyond it other ways are searched for, with some hundred thousand evaluations.
        let [before, beyond] = [0.998, 1.002].map(|times| asks(times * angle));
        assert!(before.1.abs() < 1e-13, "s = {s}, {angle}: {before:?}");
        assert!(beyond.0 > 10 * before.0, "s = {s}, {angle}: {before:?}, {beyond:?}");
    }
}

constraint! {
    /// Half of a sphere in three dimensions, and no number beyond its rim.
    struct Half {}
    |x, y, z| z + sqrt(1 - x^2 - y^2)
}

constraint! {
    /// And in four.
    struct HalfOfFour {}
    |x, y, z, w| w + sqrt(1 - x^2 - y^2 - z^2)
}

/// Ways that are tried beyond the rim of a surface are no numbers, be they one of three vectors or of four: shorter
/// stretches follow, and no conjugate point is there. One product more with ∇²g is asked for, of three.
#[test]
fn what_is_no_number_is_no_conjugate_point() {
    let low = 0.05_f64;
    let r = (1.0 - low * low).sqrt();
    let (x, y) = (r * 0.3_f64.cos(), r * 0.3_f64.sin());
    let right = 2.0 * (r * 0.15_f64.sin()).asin();
    let three = asked(Half {}, [vector![r, 0.0, -low], vector![x, y, -low]], right);
    let four = asked(HalfOfFour {}, [vector![r, 0.0, 0.0, -low], vector![x, y, 0.0, -low]], right);
    assert!(four < 2.0 * three, "{four}, in three dimensions {three}");
}

pair_potential! {
    /// The distance itself.
    struct Distance {}
    |r| r
}

/// Within half of the way to the first conjugate point, as pair potentials by geodesics ask for, they are as long as
/// these: in a simulation and in an ensemble.
#[test]
fn pair_potentials_have_the_same_distances() {
    fn check<C: Constraint<3, 1> + Copy>(surface: C, reach: f64, ends: [Vector3<f64>; 2]) {
        let right = geodesic_distance(&surface, &ends[0], &ends[1]).unwrap().distance;
        let scene =
            Scene::on(surface).bodies(2).with(Distance {}.within(reach).shifted().along_geodesics(surface));
        let mut alone = scene.simulate(State::of(ends), Rattle::new(1e-3)).unwrap();
        assert!(right < reach && right > 0.9 * reach, "{right}");
        let off = alone.energy() + reach - right;
        assert!(off.abs() < 1e-13 * reach, "{right}: {off:e}");
        let mut ensemble = scene.ensemble(vec![State::of(ends); 3], Rattle::new(1e-3)).unwrap();
        alone.step().unwrap();
        ensemble.run(1);
        let moves = |state: &State<3>| state.momenta().next().unwrap();
        let pulled = moves(&alone.state());
        assert!((pulled.norm() - 1e-3).abs() < 1e-5, "{pulled}"); // the slope is 1
        assert!(ensemble.states().all(|state| (moves(&state) - pulled).norm() < 1e-16), "{pulled}");
    }
    let (c, r) = (0.03, 0.003_f64);
    let on_plate = |share: f64| Vector3::new((share * PI * c).cos(), (share * PI * c).sin(), 0.0);
    check(Ellipsoid { a: 1.0, b: 1.0, c }, 0.5 * PI * c, [on_plate(0.0), on_plate(0.48)]);
    let on_tube = |share: f64| {
        let angle = share * PI * (r / (1.0 + r)).sqrt();
        (1.0 + r) * Vector3::new(angle.cos(), angle.sin(), 0.0)
    };
    let reach = 0.5 * PI * (r * (1.0 + r)).sqrt();
    check(Torus { major: 1.0, minor: r }, reach, [on_tube(0.0), on_tube(0.48)]);
}
