//! In phase space, where g is rounded by more than its coordinates let expect, and where coordinates are what is left
//! of what a step gives and takes. What simulations do, lanes do, too.

use crate::common::larger;
use rattle::Error;
use rattle::error::{PhaseFailure, StartFailure, StepFailure};
use rattle::prelude::*;

phase_constraint! {
    /// A pendulum that hangs from (0, a): near the bottom its terms cancel.
    struct Rod { a }
    |q: [f64; 2], p: [f64; 2]| q[0]^2 + (q[1] - a)^2 - a^2 + 0 * p[0]
}
phase_constraint! {
    /// The same, without cancellation.
    struct Plain { a }
    |q: [f64; 2], p: [f64; 2]| q[0]^2 + q[1]^2 - 2 * a * q[1] + 0 * p[0]
}
hamiltonian! {
    struct Weight {}
    |q: [f64; 2], p: [f64; 2]| dot(p, p) / 2 + 9.81 * q[1]
}
phase_constraint! {
    /// Two such pendulums.
    struct Rods { a, b }
    |q: [f64; 4], p: [f64; 4]| [
        q[0]^2 + (q[1] - a)^2 - a^2 + 0 * p[0],
        q[2]^2 + (q[3] - b)^2 - b^2,
    ]
}
hamiltonian! {
    struct Weights {}
    |q: [f64; 4], p: [f64; 4]| dot(p, p) / 2 + 9.81 * (q[1] + q[3])
}
phase_constraint! {
    /// Momenta on a circle.
    struct Hodograph { a }
    |q: [f64; 2], p: [f64; 2]| p[0]^2 + (p[1] - a)^2 - a^2 + 0 * q[0]
}
hamiltonian! {
    struct Turned {}
    |q: [f64; 2], p: [f64; 2]| dot(q, q) / 2 + 9.81 * p[1]
}

/// By how much a place is off the circle, as a part of its radius.
fn off([x, y]: [f64; 2], a: f64) -> f64 {
    ((x / a).powi(2) + (y / a).powi(2) - 2.0 * y / a).abs() / 2.0
}

/// Place and momentum after so many steps, of a simulation and of a lane; they stay on the circle, and energy errors
/// are as large in the last quarter as before.
macro_rules! swing {
    ($scene:expr, $start:expr, $a:expr, $h:expr, $steps:expr) => {{
        let (scene, start, a, h, steps) = ($scene, $start, $a, $h, $steps);
        let what = format!("a = {a}, h = {h}, {:?}", start.momenta().next().unwrap());
        let mut alone =
            scene.simulate(start.clone(), Rattle::new(h)).unwrap_or_else(|e| panic!("{what}: {e}"));
        let (mut worst, mut energy, mut now) = (0.0, [0.0; 2], 0);
        alone
            .run_with(steps, |at| {
                worst = larger(worst, off(at.position().into(), a));
                let late = usize::from(4 * now > 3 * steps);
                energy[late] = larger(energy[late], at.energy_error().abs());
                now += 1;
            })
            .unwrap_or_else(|error| panic!("{what}: {error}"));
        println!("{what}: off by {worst:e}, energy {energy:?}");
        assert!(worst < 4.0 * f64::EPSILON, "{what}: off by {worst:e}");
        assert!(energy[1] <= 1.01 * energy[0] + 1e-14 * a, "{what}: {energy:?}");
        let mut lanes = scene.ensemble(vec![start; 2], Rattle::new(h)).unwrap();
        lanes.run(steps);
        assert!(lanes.failure(1).is_none(), "{what}: {:?}", lanes.failure(1));
        [alone.state(), lanes.state(1)].map(|state| {
            let (q, p) = (state.positions().next().unwrap(), state.momenta().next().unwrap());
            [q[0], q[1], p[0], p[1]]
        })
    }};
}

/// The same motion, however the circle is written. Where g is known to a rounding of the radius, so is the place, and
/// after n steps, of which each turns by less than a radian, it may be off by √n of that.
#[test]
fn circles_are_kept_near_their_bottom() {
    for a in [1.0, 0.7, 10.0, 1e-6] {
        // At least once there and back, in which the energy comes back twice.
        for (h, p, steps) in [
            (0.01, 0.1, 300),
            (0.001, 1.0, 1500),
            (0.01, 1.0, 300),
            (0.05, 0.1, 300),
            (0.01, 1e-8, 100),
            (0.01, 1e-12, 100),
            (0.01, 0.0, 100),
        ] {
            let time = f64::sqrt(a);
            let start = || State::at([0.0; 2]).moving([p * time, 0.0]);
            let rod = swing!(Scene::in_phase_space(Rod { a }, Weight {}), start(), a, h * time, steps);
            let plain = swing!(Scene::in_phase_space(Plain { a }, Weight {}), start(), a, h * time, steps);
            for one in rod.iter().chain(&plain[1..]) {
                let off = [0, 1, 2, 3].map(|i| (one[i] - plain[0][i]).abs() / if i < 2 { a } else { time });
                assert!(off.into_iter().fold(0.0, larger) < 1e-14, "a = {a}, h = {h}, p = {p}: {off:?}");
            }
        }
    }
}

/// A start on the circle but for the rounding of where it was computed is taken, and one that is off by more is not,
/// but `project` brings it there.
#[test]
fn starts_near_the_bottom_are_on_the_circle_by_rounding() {
    for a in [1.0, 0.7, 1e8] {
        let scene = Scene::in_phase_space(Rod { a }, Weight {});
        for x in [0.0, 1e-9, 1e-7, 1e-5, 1e-3, 0.1].map(|x| x * a) {
            let y = a - (a * a - x * x).sqrt();
            let _ = swing!(scene, State::at([x, y]), a, 0.01 * a.sqrt(), 100);
            let far = State::at([x, y + 1e-13 * a]);
            let refused = scene.simulate(far.clone(), Rattle::new(0.01)).map(|_| ());
            let on = x > 0.05 * a; // 1e-10 of what terms are made of is allowed
            let told = matches!(refused, Err(Error::Start { cause: StartFailure::Phase(_), .. }));
            assert!(told != on, "a = {a}, x = {x:e}: {refused:?}");
            let back = scene.project(&far).unwrap_or_else(|error| panic!("a = {a}, x = {x:e}: {error}"));
            let back: [f64; 2] = back.positions().next().unwrap().into();
            assert!(off(back, a) < 4.0 * f64::EPSILON, "a = {a}, x = {x:e}: {back:?}");
            scene.simulate(scene.project(&far).unwrap(), Rattle::new(0.01)).unwrap();
        }
    }
}

/// Of two pendulums one is where its terms cancel, and the other where they do not.
#[test]
fn each_equation_has_its_own_rounding() {
    let (a, b, h) = (0.7, 2.3, 0.01);
    let scene = Scene::in_phase_space(Rods { a, b }, Weights {});
    let start = || State::at([0.0, 0.0, b, b]).moving([0.1, 0.0, 0.0, 1.0]);
    let mut alone = scene.simulate(start(), Rattle::new(h)).unwrap();
    let mut worst = 0.0;
    alone
        .run_with(500, |now| {
            let [x, y, z, w] = now.position().into();
            worst = larger(worst, larger(off([x, y], a), off([z, w], b)));
        })
        .unwrap();
    println!("{worst:e}");
    assert!(worst < 4.0 * f64::EPSILON, "{worst:e}");
    assert!(scene.simulate(State::at([0.0, 0.0, b + 1e-9, b]), Rattle::new(h)).is_err());
}

/// The rounding of g may be that of momenta.
#[test]
fn momenta_on_a_circle_near_its_bottom() {
    for a in [1.0, 0.7, 2.3] {
        let scene = Scene::in_phase_space(Hodograph { a }, Turned {});
        let mut run = scene.simulate(State::at([0.1, 0.0]).moving([0.0, 0.0]), Rattle::new(0.01)).unwrap();
        let mut worst = 0.0;
        run.run_with(1000, |now| worst = larger(worst, off(now.momentum().into(), a))).unwrap();
        assert!(worst < 4.0 * f64::EPSILON, "{worst:e}");
    }
}

/// A step for which the rod is too short is refused.
#[test]
fn steps_without_an_end_near_the_bottom_are_refused() {
    for (a, p) in [(1.0, 300.0), (0.7, 1e3), (2.3, 1e4)] {
        let scene = Scene::in_phase_space(Rod { a }, Weight {});
        let mut run = scene.simulate(State::at([0.0; 2]).moving([p, 0.0]), Rattle::new(0.01)).unwrap();
        let error = run.run(1).unwrap_err();
        let Error::Step { cause: StepFailure::Phase(cause), .. } = &error else { panic!("{error}") };
        assert!(matches!(cause, PhaseFailure::NoSlide { .. } | PhaseFailure::SheetLost { .. }), "{error}");
    }
}
