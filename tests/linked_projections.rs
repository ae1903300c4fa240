//! Linked bodies that are projected: onto places that `simulate` takes, be bodies light, be they far away, or be g
//! rounded to more than coordinates are; and what is said where there are none.

use rattle::error::{Error, StartFailure};
use rattle::links::planar::Rod;
use rattle::prelude::*;

constraint! {
    /// A large sphere whose lowest place is the origin.
    struct Sphere { radius } |x, y, z| x^2 + y^2 + (z - radius)^2 - radius^2
}

/// A chain of rods of length 1 from a pin, whose other bodies have these masses.
fn chain(masses: &[f64], from: [f64; 2]) -> Scene<rattle::network::Network<2>, (), rattle::bodies::Many, 2> {
    let rods: Vec<_> = (0..masses.len()).map(|i| [i, i + 1]).collect();
    Scene::points(masses.len() + 1)
        .link(Rod { length: 1.0 }, rods)
        .masses(std::iter::once(1.0).chain(masses.iter().copied()))
        .pin(0, from)
}

/// Its rods hold to some roundings of places, a simulation takes them, and all count.
fn check_chain(masses: &[f64], places: Vec<[f64; 2]>, what: &str) {
    let (scene, from) = (chain(masses, places[0]), places[0]);
    let state = scene.project(&State::of(places)).unwrap_or_else(|error| panic!("{what}: {error}"));
    let found: Vec<_> = state.positions().collect();
    for ends in found.windows(2) {
        let off = (ends[1] - ends[0]).norm() - 1.0;
        // 64 roundings of what is along a rod; each end is off by √½ of that.
        let allowed = 2.0_f64.sqrt() * 64.0 * f64::EPSILON * (from[0].abs() + masses.len() as f64);
        assert!(off.abs() <= allowed, "{what}: {off:e}");
    }
    let simulation =
        scene.simulate(state, Rattle::new(1e-3)).unwrap_or_else(|error| panic!("{what}: {error}"));
    assert_eq!(simulation.freedom(), masses.len(), "{what}");
}

/// Light joints are thrown far by steps in the metric of the masses; such steps also come near slowly.
#[test]
fn light_joints_are_projected() {
    for light in [1.0, 1e-3, 1e-5, 1e-6, 1e-8, 1e-10] {
        check_chain(
            &[light, 1.0],
            vec![[0.0, 0.0], [1.001, 1e-3], [2.003, 0.0]],
            &format!("beside the origin, {light:e}"),
        );
        for away in [1e3, 1e4, 1e6] {
            let places = vec![[away, 0.0], [away + 1.003, 1e-5], [away + 2.0033, 0.0]];
            check_chain(&[light, 1.0], places, &format!("{away:e}, {light:e}"));
        }
    }
}

#[test]
fn chains_of_light_joints_are_projected() {
    for (away, bend, off, light) in [
        (0.0, 0.05, 1e-2, 1e-6),
        (0.0, 0.05, 1e-2, 1.0),
        (1e6, 1e-3, 1e-4, 1e-8),
        (1e5, 1e-3, 1e-3, 1e-6),
        (1e3, 0.3, 1e-2, 1e-10),
    ] {
        for seed in 0..12 {
            let any = |k: usize| (3.7 * k as f64 + 0.9 * f64::from(seed)).sin();
            let ([mut x, mut y], mut angle) = ([away, 0.0], 0.0_f64);
            let mut places = vec![[x, y]];
            for i in 1..=10 {
                angle += bend * any(i);
                (x, y) = (x + angle.cos(), y + angle.sin());
                places.push([x + off * any(20 + i), y + off * any(40 + i)]);
            }
            let masses: Vec<_> = (1..=10).map(|i| if i % 2 == 1 { light } else { 1.0 }).collect();
            check_chain(&masses, places, &format!("{away:e}, {light:e}, {seed}"));
        }
    }
}

/// Near the lowest place of a large sphere terms of g are as large as its radius: one quantum of g is more than what is
/// tolerated of places.
#[test]
fn links_on_a_large_sphere_are_projected() {
    for (radius, size) in [(1e4, 1e-3), (1e6, 0.01), (1e6, 1e-3), (6.4e6, 0.1), (6.4e6, 1.0)] {
        let quantum = f64::EPSILON * radius; // of g over |∇g| = 2 R, of terms of R²
        let height = |q: &rattle::nalgebra::SVector<f64, 3>| q.z - (q.x * q.x + q.y * q.y) / (2.0 * radius);
        for seed in 0..50 {
            let any = |k: u32| (3.7 * f64::from(k) + 0.9 * f64::from(seed)).sin();
            let start = [size * any(1), size * any(2), 0.01 * size * any(3)];
            let one = Scene::points(1).link(Sphere { radius }, [[0]]);
            let what = format!("{radius:e}, {start:?}");
            let state = one.project(&State::of([start])).unwrap_or_else(|error| panic!("{what}: {error}"));
            assert!(state.positions().all(|q| height(&q).abs() <= 16.0 * quantum), "{what}");
            one.simulate(state, Rattle::new(1e-3)).unwrap();

            let length = size * (0.75 + 0.25 * any(4));
            let (sin, cos) = (3.0 * any(5)).sin_cos();
            let other = [start[0] + 1.1 * length * cos, start[1] + 1.1 * length * sin, 0.01 * size * any(6)];
            let two = Scene::points(2)
                .link(Sphere { radius }, [[0], [1]])
                .link(rattle::links::Rod { length }, [[0, 1]]);
            let state =
                two.project(&State::of([start, other])).unwrap_or_else(|error| panic!("{what}: {error}"));
            let [a, b] = [0, 1].map(|i| state.positions().nth(i).unwrap());
            assert!([a, b].iter().all(|q| height(q).abs() <= 16.0 * quantum), "{what}");
            assert!(((b - a).norm() - length).abs() <= 1e-10 * length, "{what}");
            assert_eq!(two.simulate(state, Rattle::new(1e-3)).unwrap().freedom(), 3);
        }
    }
}

/// Far away too links of other lengths are told to contradict each other, and not taken to a place that is refused.
#[test]
fn contradictions_far_away_are_told() {
    for (away, longer) in [(0.0, 1e-5), (1e6, 1e-5), (1e3, 1e-8), (1e3, 1e-9)] {
        let scene = Scene::points(2)
            .link_each([(Rod { length: 1.0 }, [0, 1]), (Rod { length: 1.0 + longer }, [0, 1])])
            .pin(0, [away, 0.0]);
        let error = scene.project(&State::of([[away, 0.0], [away + 1.0, 0.0]])).expect_err("two lengths");
        let Error::Start { cause: StartFailure::Contradictory { distance, .. }, .. } = &error else {
            panic!("{away:e}, {longer:e}: {error}")
        };
        // Each is off by a half.
        assert!((distance / longer - 0.5).abs() < 0.1, "{away:e}, {longer:e}: {distance:e}");
    }
}

/// From an exactly straight toggle no gradient leads to where its rods hold.
#[test]
fn straight_toggles_are_told_to_start_beside() {
    let scene =
        Scene::points(3).link(Rod { length: 1.0 }, [[0, 1], [1, 2]]).pin(0, [0.0; 2]).pin(2, [1.9, 0.0]);
    let start = |y: f64| State::of([[0.0, 0.0], [0.95, y], [1.9, 0.0]]);
    let error = scene.project(&start(0.0)).unwrap_err().to_string();
    assert!(error.contains("in one line") && error.contains("start beside"), "{error}");
    let state = scene.project(&start(1e-9)).unwrap();
    let joint = state.positions().nth(1).unwrap();
    assert!((joint.y.abs() - (1.0_f64 - 0.95 * 0.95).sqrt()).abs() < 1e-15, "{joint}");
}

/// A rod far away that is a little off is nothing that contradicts: it is moved to where it holds.
#[test]
fn rods_far_away_that_are_a_little_off_are_projected() {
    for off in [1e-10, 1e-9, 1e-8, 1e-4, 1e-2] {
        check_chain(&[1.0], vec![[1e6, 0.0], [1e6, 1.0 + off]], &format!("{off:e}"));
    }
}
