//! Which links follow from others does not depend on the units of coordinates, nor on what is elsewhere: normals are
//! told apart in the metric of the masses, and each by what turns those of which it is made.

use rattle::links::planar::Rod;
use rattle::network::Mass;
use rattle::prelude::*;

constraint! {
    /// The beginning of a bar is at a place.
    struct Hinge { length, x, y }
    |a: [f64; 3]| [a[0] - length / 2 * cos(a[2]) - x, a[1] - length / 2 * sin(a[2]) - y]
}

constraint! {
    /// The end of a bar is so far along another from its middle.
    struct Joint { length, along }
    |a: [f64; 3], b: [f64; 3]| [
        a[0] + length / 2 * cos(a[2]) - b[0] - along * cos(b[2]),
        a[1] + length / 2 * sin(a[2]) - b[1] - along * sin(b[2])
    ]
}

constraint! {
    /// A slot that a crank of this length moves: x and the angle.
    struct Yoke { length } |a: [f64; 2]| a[0] - length * cos(a[1])
}

constraint! { struct Same {} |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]] }

/// Where the third bar of a linkage of three parallel cranks and a coupler lies, all rigid bodies in the plane.
const TILT: f64 = 0.3;

/// The linkage with cranks of this length, the first of which turns about a place; and the places of all three.
#[allow(clippy::type_complexity, reason = "a scene and three places")]
fn cranks(
    length: f64,
    [x, y]: [f64; 2],
) -> (Scene<rattle::network::Network<3>, (), rattle::bodies::Many, 3>, [[f64; 2]; 3]) {
    let (sin, cos) = TILT.sin_cos();
    let pins = [0.0, 1.0, 2.0].map(|i| [x + i * length * cos, y + i * length * sin]);
    let hinges = (0..3).map(|i| (Hinge { length, x: pins[i][0], y: pins[i][1] }, [i]));
    let joints = (0..3).map(|i| (Joint { length, along: (i as f64 - 1.0) * length }, [i, 3]));
    let inertia = length * length / 12.0;
    let masses = [inertia, inertia, inertia, 4.0 * inertia].map(|i| Mass::Diagonal([1.0, 1.0, i]));
    let scene = Scene::points(4)
        .link_each(hinges.collect::<Vec<_>>())
        .link_each(joints.collect::<Vec<_>>())
        .masses(masses);
    (scene, pins)
}

/// Three cranks of this length are joined by a bar: twelve equations, of which eleven are independent. Each angle is
/// off by so much, and numbers are as `write` leaves them.
fn check_cranks(length: f64, angle: f64, off: [f64; 3], write: impl Fn(f64) -> f64) {
    let (scene, pins) = cranks(length, [0.0; 2]);
    let inertia = length * length / 12.0;
    // The cranks turn at 1.
    let (sin, cos) = angle.sin_cos();
    let [half, whole] = [length / 2.0, length].map(|r| ([r * cos, r * sin], [-r * sin, r * cos]));
    let mut places: Vec<_> =
        (0..3).map(|i| [pins[i][0] + half.0[0], pins[i][1] + half.0[1], angle + off[i]]).collect();
    places.push([pins[1][0] + whole.0[0], pins[1][1] + whole.0[1], TILT]);
    let places = places.into_iter().map(|place| place.map(&write));
    let crank = [half.1[0], half.1[1], inertia];
    let start = State::of(places).with_momenta([crank, crank, crank, [whole.1[0], whole.1[1], 0.0]]);
    let what = format!("{length:e}, {angle}, {off:?}");
    let mut simulation =
        scene.simulate(start, Rattle::new(0.01)).unwrap_or_else(|error| panic!("{what}: {error}"));
    assert_eq!(simulation.freedom(), 1, "{what}");
    simulation.run(10).unwrap();
    // No force does work on them: they turn as before, but for the order of the method.
    for p in simulation.momenta().take(3) {
        assert!((p[2] / inertia - 1.0).abs() < 1e-4, "{what}: {}", p[2] / inertia);
    }
}

#[test]
fn rigid_cranks_of_any_length_turn() {
    for length in [1e3, 1.0, 0.1, 0.03, 0.01, 1e-3, 1e-4] {
        for angle in [0.7, 1.0, 1.3, 1.9, 2.4] {
            check_cranks(length, angle, [0.0; 3], |x| x);
            if length <= 1.0 {
                check_cranks(length, angle, [3.3e-11, -2e-11, 1e-11], |x| x); // of more length more than is tolerated
            }
            check_cranks(length, angle, [0.0; 3], |x| format!("{x:.11e}").parse().unwrap());
        }
    }
}

/// Far away all g may be 0 where places are known to some roundings alone: linkages that are projected there turn.
#[test]
fn rigid_cranks_far_away_turn() {
    let mut locked = Vec::new();
    for (length, away) in
        [(1.0, 1e4), (1.0, 1e5), (0.1, 1e4), (0.1, 1e5), (0.01, 1e2), (0.01, 1e3), (0.01, 1e6)]
    {
        let (scene, pins) = cranks(length, [away, 0.7 * away]);
        for k in 0..60 {
            let angle = 0.5 + 0.03 * f64::from(k);
            let (sin, cos) = angle.sin_cos();
            let mut places: Vec<_> = (0..3)
                .map(|i| [pins[i][0] + 0.5 * length * cos, pins[i][1] + 0.5 * length * sin, angle])
                .collect();
            places.push([pins[1][0] + length * cos, pins[1][1] + length * sin, TILT]);
            for (i, x) in places.as_flattened_mut().iter_mut().enumerate() {
                let off = 1e-3 * (3.7 * i as f64 + 0.9 * f64::from(k)).sin();
                *x += if i % 3 == 2 { off } else { length * off };
            }
            let start = scene.project(&State::of(places)).unwrap();
            let simulation = scene.simulate(start, Rattle::new(1e-3)).unwrap();
            if simulation.freedom() != 1 {
                locked.push((length, away, angle, simulation.freedom()));
            }
        }
    }
    assert!(locked.is_empty(), "{locked:?}");
}

#[test]
fn yokes_of_any_length_turn() {
    for length in [1.0_f64, 0.1, 0.01, 1e-3, 1e-5] {
        for off in [0.0, 5e-11] {
            let (angle, x) = (0.7_f64, length * 0.7_f64.cos());
            let scene = Scene::points(2)
                .link(Yoke { length }, [[0], [1]])
                .link(Same {}, [[0, 1]])
                .masses([[1.0, length * length]; 2]);
            let start = State::of([[x, angle], [x, angle + off]]);
            let simulation = scene.simulate(start, Rattle::new(0.01)).unwrap();
            assert_eq!(simulation.freedom(), 1, "{length:e}, {off:e}");
        }
    }
}

/// A short crank far away, whose normal is known to few digits, leaves rods with a light joint as independent as they
/// are.
#[test]
fn short_cranks_leave_other_links_independent() {
    for (away, length, light) in [(1e3, 1e-6, 1e-10), (1e5, 1e-3, 1e-10), (5e6, 1e-3, 1e-8)] {
        let scene = Scene::points(4)
            .link(Rod { length }, [[0, 1]])
            .link(Rod { length: 1.0 }, [[1, 2], [2, 3]])
            .masses([1.0, 1.0, light, 1.0])
            .pin(0, [away, 0.0]);
        let start = State::of([[away, 0.0], [away, length], [away + 1.0, length], [away + 2.0, length]]);
        let simulation = scene.simulate(start, Rattle::new(1e-6)).unwrap();
        assert_eq!(simulation.freedom(), 3, "{away:e}, {length:e}, {light:e}");
    }
}
