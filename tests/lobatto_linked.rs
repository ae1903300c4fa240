//! Lobatto IIIA–IIIB where links nearly depend on each other: what rounding makes of displacements is larger by 1 over
//! the sine of their normals, and is no reason to give a step up.

use rattle::guess::Extrapolated;
use rattle::links::planar::Rod;
use rattle::prelude::*;

constraint! {
    /// On a circle about (a, b).
    struct Bent { a, b, r }
    |x, y| (x - a)^2 + (y - b)^2 - r^2
}

/// Two circles that cross at this angle hold a body, about which another goes round.
#[test]
fn links_at_a_small_angle_are_moved() {
    for angle in [1e-1, 1e-2, 1e-3, 1e-4_f64] {
        let (s, c) = angle.sin_cos();
        let scene = Scene::points(2)
            .link(Bent { a: 0.0, b: 0.0, r: 1.0 }, [[0]])
            .link(Bent { a: 1.0 + 0.7 * c, b: 0.7 * s, r: 0.7 }, [[0]])
            .link(Rod { length: 1.0 }, [[0, 1]]);
        let start = State::of([[1.0, 0.0], [1.0, -1.0]]).with_momenta([[0.0, 0.0], [1.0, 0.0]]);
        macro_rules! by {
            ($method:expr) => {{
                let mut simulation = scene.simulate(start.clone(), $method).unwrap();
                simulation.run(100).unwrap();
                let [held, round] = [0, 1].map(|body| simulation.positions().nth(body).unwrap());
                let (s, c) = simulation.time().sin_cos();
                // g is rounded to an ε or two, and bodies by 1 over the sine as much.
                let rounding = 4.0 * f64::EPSILON / angle;
                let off = [held.x - 1.0, held.y, round.x - 1.0 - s, round.y + c, simulation.energy_error()];
                assert!(off.iter().all(|off| off.abs() <= rounding), "at {angle}: {off:?}");
            }};
        }
        by!(Lobatto::<4>::new(0.01));
        by!(Lobatto::<5>::new(0.01).guess(Extrapolated));
        by!(Lobatto::<5>::new(0.001));
    }
}

potential! {
    /// A spring to (1, 1).
    struct Spring { k }
    |x, y| k * ((x - 1)^2 + (y - 1)^2) / 2
}

/// A body without links beside a rod is at the origin in the middle of a step: forces are rounded to more than its
/// place there.
#[test]
fn bodies_without_links_pass_the_origin() {
    let (k, h) = (60.0_f64, 0.1);
    let scene = Scene::points(3).link(Rod { length: 1.0 }, [[0, 1]]).with(Spring { k }.over([[2]]));
    let (sin, cos) = (k.sqrt() * h / 2.0).sin_cos();
    for i in -200..=200 {
        let (middle, begin) = (1e-6 * f64::from(i), -0.1);
        let speed = k.sqrt() * (middle - 1.0 - (begin - 1.0) * cos) / sin;
        let start = State::of([[5.0, 5.0], [6.0, 5.0], [begin, begin]]);
        let start = start.with_momenta([[0.0, 0.0], [0.0, 0.0], [speed, speed]]);
        let mut simulation = scene.simulate(start, Lobatto::<5>::new(h)).unwrap();
        let step = simulation.step();
        assert!(step.is_ok(), "{i}: {step:?}");
    }
}
