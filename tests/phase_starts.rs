//! Starts in phase space: how far off `project` may begin, and what is told where equations repeat each other.

use rattle::Error;
use rattle::prelude::*;

phase_constraint! {
    /// A sphere of positions, of any scale: momenta slide along its normal.
    struct Ball { c }
    |q: [f64; 3], p: [f64; 3]| c * (dot(q, q) - 1) + 0 * p[0]
}
phase_constraint! {
    /// Two circles of positions, each with a scale of its own.
    struct Circles { a, b }
    |q: [f64; 4], p: [f64; 4]| [a * (q[0]^2 + q[1]^2 - 1) + 0 * p[0], b * (q[2]^2 + q[3]^2 - 4)]
}
hamiltonian! {
    /// A relativistic body with a weight: convex in p, and straight far away.
    struct Fast {}
    |q: [f64; 3], p: [f64; 3]| sqrt(1 + dot(p, p)) + q[2]
}
hamiltonian! {
    /// Two bodies in a plane, that share one root.
    struct Both {}
    |q: [f64; 4], p: [f64; 4]| sqrt(1 + dot(p, p)) + q[1]
}
hamiltonian! {
    /// Convex, and steeper and steeper.
    struct Steep {}
    |q: [f64; 3], p: [f64; 3]| exp(dot(p, p)) + q[2]
}

fn momentum<const D: usize>(state: Result<State<D>, Error>, what: &str) -> [f64; D] {
    let state = state.unwrap_or_else(|error| panic!("{what}: {error}"));
    state.momenta().next().unwrap().into()
}

/// Where energies are convex along the fibre, the momentum without normal part is the only one. It is known to the
/// rounding of the momentum before: 16 roundings for the sums of three terms.
#[test]
fn momenta_far_along_the_fibre_slide_back() {
    for c in [1.0, 1e6, -1e-6] {
        for along in [0.3, 1.0, 1.2, 2.0, 5.0, -30.0, 1e3, 1e5] {
            let what = format!("{along} along the normal, scale {c}");
            let scene = Scene::in_phase_space(Ball { c }, Fast {});
            let start = State::at([0.6, 0.0, -0.8]).moving([0.6 * along, 0.3, -0.8 * along]);
            let p = momentum(scene.project(&start), &what);
            let off = p[0].abs().max((p[1] - 0.3).abs()).max(p[2].abs());
            println!("{what}: {p:?}");
            assert!(off < 16.0 * f64::EPSILON * along.abs().max(1.0), "{what}: {p:?}");
        }
        let steep = Scene::in_phase_space(Ball { c }, Steep {});
        let p = momentum(steep.project(&State::at([0.6, 0.0, -0.8]).moving([3.0, 0.3, -4.0])), "steep");
        assert!(p[0].abs().max((p[1] - 0.3).abs()).max(p[2].abs()) < 80.0 * f64::EPSILON, "{p:?}");
    }
}

/// The same with two constraints, of which one is far off and one near, in scales of their own.
#[test]
fn so_do_those_of_several_constraints() {
    for (a, b) in [(1.0, 1.0), (1e5, 1e-3), (1e-4, 30.0)] {
        for (one, other) in [(1.2, 50.0), (40.0, -0.1), (5.0, 5.0), (0.0, 300.0)] {
            let what = format!("{one} and {other} along the normals, scales {a} and {b}");
            let scene = Scene::in_phase_space(Circles { a, b }, Both {});
            let p = [0.6 * one - 0.08, 0.8 * one + 0.06, other, 0.2];
            let p = momentum(scene.project(&State::at([0.6, 0.8, 2.0, 0.0]).moving(p)), &what);
            let exact = [-0.08, 0.06, 0.0, 0.2];
            let off = (0..4).map(|i| (p[i] - exact[i]).abs()).fold(0.0, f64::max);
            assert!(off < 16.0 * f64::EPSILON * f64::max(one.abs(), f64::abs(other)), "{what}: {p:?}");
        }
    }
}

/// c·g = 0 moves as g = 0 does, whatever the scale of each equation: a simulation, and its ensemble.
#[test]
fn equations_have_scales_of_their_own() {
    let moved = |a: f64, b: f64| {
        let scene = Scene::in_phase_space(Circles { a, b }, Both {});
        let start = scene.project(&State::at([0.6, 0.8, 2.0, 0.0]).moving([-0.4, 0.4, 0.1, 0.7])).unwrap();
        let mut simulation =
            scene.simulate(start.clone(), Rattle::new(0.02)).unwrap_or_else(|e| panic!("{e}"));
        simulation.run(200).unwrap_or_else(|e| panic!("{a} {b}: {e}"));
        let mut ensemble = scene.ensemble(vec![start; 3], Rattle::new(0.02)).unwrap();
        ensemble.run(200);
        let lane = ensemble.state(1);
        [simulation.state(), lane].map(|state| <[f64; 4]>::from(state.positions().next().unwrap()))
    };
    let [one, _] = moved(1.0, 1.0);
    for (a, b) in [(1.0, 1.0), (1e5, 1e-3), (1e-4, 30.0), (1e-30, 1e30)] {
        for other in moved(a, b) {
            let off = (0..4).map(|i| (one[i] - other[i]).abs()).fold(0.0, f64::max);
            assert!(off < 1e-13, "scales {a} and {b}: off by {off:e}");
        }
    }
}

phase_constraint! {
    /// One equation, written `c` times as large once more.
    struct Twice { c }
    |q: [f64; 2], p: [f64; 2]| [dot(q, q) + dot(p, p) - 1, c * (dot(q, q) + dot(p, p) - 1)]
}
phase_constraint! {
    /// The equation alone.
    struct Once {}
    |q: [f64; 2], p: [f64; 2]| dot(q, q) + dot(p, p) - 1
}
hamiltonian! {
    struct Fall { g }
    |q: [f64; 2], p: [f64; 2]| dot(p, p) / 2 + g * q[1]
}

#[test]
fn equations_that_repeat_each_other_are_told() {
    let once = Scene::in_phase_space(Once {}, Fall { g: 0.3 });
    let off = State::at([-0.55, -0.83]).moving([0.03, 0.02]);
    let on = once.project(&off).unwrap();
    for c in [2.0, -3.0, 0.7, 1e4] {
        let twice = Scene::in_phase_space(Twice { c }, Fall { g: 0.3 });
        let errors = [
            twice.project(&off).and_then(|start| twice.simulate(start, Rattle::new(0.01)).map(|_| ())),
            twice.simulate(on.clone(), Rattle::new(0.01)).map(|_| ()),
        ];
        for error in errors {
            let error = error.unwrap_err().to_string();
            assert!(error.contains("equation 1") && error.contains("leave out"), "{c}: {error}");
        }
    }
    // Where the only equation has no gradient, nothing leads to its surface.
    let error = once.project(&State::at([0.0, 0.0])).unwrap_err().to_string();
    assert!(error.contains("equation 0 has no gradient"), "{error}");
}

/// Fibres of equations that do not commute lead off g = 0: `project` says so, as `simulate` does, and gives no start
/// that is refused.
#[test]
fn equations_that_do_not_commute_are_told_by_projections() {
    phase_constraint! {
        struct Two {}
        |q: [f64; 3], p: [f64; 3]| [dot(q, q) - 1 + 0.1 * p[0] * p[1], q[2] - 0.3 * q[0] + 0.05 * p[2] * q[1]]
    }
    hamiltonian! {
        struct Free {}
        |q: [f64; 3], p: [f64; 3]| dot(p, p) / 2 + 0.3 * q[1] * q[0]
    }
    let start = State::at([0.8, 0.5, 0.25]).moving([0.3, -0.4, 0.2]);
    let error = Scene::in_phase_space(Two {}, Free {}).project(&start).err().unwrap().to_string();
    assert!(error.contains("not coisotropic"), "{error}");
}

hamiltonian! {
    /// A weight, along any direction.
    struct Weight { x, y, z }
    |q: [f64; 3], p: [f64; 3]| dot(p, p) / 2 + x * q[0] + y * q[1] + z * q[2]
}

/// Directions without a pattern.
fn direction(i: u32) -> [f64; 3] {
    let x = [1, 2, 3].map(|k| f64::from(7 * i + k).sin());
    let length = x.iter().map(|x| x * x).sum::<f64>().sqrt();
    x.map(|x| x / length)
}

/// Along the normal all momentum is taken away, but for its rounding; `simulate` takes what is left. In lanes as well.
#[test]
fn what_comes_to_rest_by_projection_may_start() {
    let scene = Scene::in_phase_space(Ball { c: 1.0 }, Weight { x: 0.0, y: 0.0, z: 1.0 });
    for along in [1e-3, 0.3, 3.0, 1e3] {
        let starts = (0..50).map(|i| {
            let n = direction(i);
            scene.project(&State::at(n).moving(n.map(|x| along * x))).unwrap()
        });
        let starts: Vec<_> = starts.collect();
        for start in &starts {
            let p = start.momenta().next().unwrap().amax();
            assert!(p < 2.0 * f64::EPSILON * along, "{along}: {p:e}");
            for h in [0.01, 1e-4] {
                scene
                    .simulate(start.clone(), Rattle::new(h))
                    .unwrap_or_else(|error| panic!("{along}: {error}"));
            }
        }
        scene.ensemble(starts, Rattle::new(0.01)).unwrap();
    }
}

/// A body that rests, in an equilibrium or where it turns, goes on from its state as it would have.
#[test]
fn bodies_at_rest_start_again() {
    let (h, [x, y, z]) = (0.05, direction(3));
    let hanging = Scene::in_phase_space(Ball { c: 1.0 }, Weight { x, y, z });
    let falling = Scene::in_phase_space(Ball { c: 1.0 }, Weight { x: 0.0, y: 0.0, z: 1.0 });
    let mut hangs =
        hanging.simulate(hanging.project(&State::at([-x, -y, -z])).unwrap(), Rattle::new(-h)).unwrap();
    hangs.run(10).unwrap();
    let turning = (0..20).map(|i| {
        let start = falling.project(&State::at(direction(i))).unwrap();
        let mut there = falling.simulate(start, Rattle::new(h)).unwrap();
        there.run(10).unwrap();
        let mut back = falling.simulate(there.state(), Rattle::new(-h)).unwrap();
        back.run(10).unwrap();
        (falling, back)
    });
    for (i, (scene, mut simulation)) in std::iter::once((hanging, hangs)).chain(turning).enumerate() {
        let state = simulation.state();
        assert!(simulation.momentum().amax() < 1e-14, "{i} rests");
        for h in [h, -1e-3 * h] {
            scene.simulate(state.clone(), Rattle::new(h)).unwrap_or_else(|error| panic!("{i}, {h}: {error}"));
        }
        let mut again = scene.simulate(state.clone(), Rattle::new(-h)).unwrap();
        let mut lanes = scene.ensemble(vec![state; 2], Rattle::new(-h)).unwrap();
        simulation.run(10).unwrap();
        again.run(10).unwrap();
        lanes.run(10);
        let [one, lane] = [again.state(), lanes.state(1)].map(|state| state.positions().next().unwrap());
        let off = (one - simulation.position()).amax().max((lane - simulation.position()).amax());
        assert!(off < 1e-14, "{i}: {off:e}");
    }
}

phase_constraint! {
    /// A pendulum in a plane, beside a coordinate that is free.
    struct Beside {}
    |q: [f64; 3], p: [f64; 3]| q[1]^2 + q[2]^2 - 1 + 0 * p[0]
}

/// What {g, H} does not depend on may be as large as it likes: a momentum of 0.1 along the normal is told as it is.
#[test]
fn starts_are_held_to_the_coordinates_that_matter() {
    let scene = Scene::in_phase_space(Beside {}, Weight { x: 0.0, y: 0.0, z: 1.0 });
    for far in [0.0, 1.0, 1e6, 1e12] {
        let start =
            |normal: f64| State::at([far, 0.6, 0.8]).moving([0.0, 0.6 * normal + 0.08, 0.8 * normal - 0.06]);
        let error = scene.simulate(start(0.1), Rattle::new(0.01)).unwrap_err().to_string();
        assert!(error.contains("{g, H} = 2.000e-1"), "{far:e}: {error}");
        scene.simulate(start(0.0), Rattle::new(0.01)).unwrap_or_else(|error| panic!("{far:e}: {error}"));
        let p = momentum(scene.project(&start(0.1)), "projected");
        assert!((p[1] - 0.08).abs().max((p[2] + 0.06).abs()) < 1e-16 * (1.0 + far), "{far:e}: {p:?}");
    }
}

phase_constraint! {
    /// Their bracket is −p₀: zero with the first.
    struct Pair {}
    |q: [f64; 3], p: [f64; 3]| [p[0], p[1] + q[0] * p[0]]
}
hamiltonian! {
    /// A quadratic well in which no axis is by itself.
    struct Well {}
    |q: [f64; 3], p: [f64; 3]|
        dot(p, p) / 2
            + 0.65 * (q[0] - 0.7 - 0.3 * q[2])^2
            + 0.45 * (q[1] - 0.4 + 0.2 * q[2])^2
            + q[2]^2 / 2
            + 0.17 * q[0] * q[1]
}
phase_constraint! {
    /// No angular momentum.
    struct Straight {}
    |q: [f64; 2], p: [f64; 2]| q[0] * p[1] - q[1] * p[0]
}
hamiltonian! {
    /// A well with an axis along (x, y), steeper across.
    struct Valley { x, y }
    |q: [f64; 2], p: [f64; 2]| dot(p, p) / 2 + (x * q[0] + y * q[1])^2 / 2 + 1.5 * (x * q[1] - y * q[0])^2
}

/// 10 steps there and 10 back, from each state anew, as a simulation and as a lane: the body rests where it did.
macro_rules! there_and_back {
    ($scene:expr, $start:expr, $what:expr) => {{
        let (scene, start, what) = ($scene, $start, $what);
        let mut states = [start.clone(), start.clone()];
        for h in [0.05, -0.05, 0.05, -0.05] {
            let [alone, lane] = states;
            let mut alone =
                scene.simulate(alone, Rattle::new(h)).unwrap_or_else(|e| panic!("{what}, {h}: {e}"));
            alone.run(10).unwrap_or_else(|error| panic!("{what}, {h}: {error}"));
            let mut lanes = scene
                .ensemble(vec![lane; 3], Rattle::new(h))
                .unwrap_or_else(|error| panic!("{what}, {h}, lanes: {error}"));
            lanes.run(10);
            assert!(lanes.failure(1).is_none(), "{what}, {h}, lanes: {:?}", lanes.failure(1));
            states = [alone.state(), lanes.state(1)];
            let back = h < 0.0;
            for state in &states {
                let off = (state.positions().next().unwrap() - start.positions().next().unwrap()).amax();
                let p = state.momenta().next().unwrap().amax();
                assert!(!back || (off < 1e-14 && p < 1e-14), "{what}: off by {off:e}, {p:e}");
                assert!(back || (off > 1e-3 && p > 1e-3), "{what}: it has moved by {off:e} only");
            }
        }
    }};
}

/// At rest all terms of brackets are nothing.
#[test]
fn equations_that_commute_where_they_hold_do_so_at_rest() {
    let scene = Scene::in_phase_space(Pair {}, Well {});
    for far in [1.0, -0.77, 0.9] {
        // Where no force acts along the first two axes.
        let [x, y] = [1.3 * (0.7 + 0.3 * far), 0.9 * (0.4 - 0.2 * far)];
        let determinant = 1.3 * 0.9 - 0.17 * 0.17;
        let q = [(0.9 * x - 0.17 * y) / determinant, (1.3 * y - 0.17 * x) / determinant, far];
        there_and_back!(scene, scene.project(&State::at(q)).unwrap(), format!("{far}"));
    }
}

/// And those of equations of momenta.
#[test]
fn bodies_at_rest_satisfy_equations_of_momenta() {
    for (i, r) in [1.0, 0.8, 1.3, 0.55, 0.77, 0.31].into_iter().enumerate() {
        let (y, x) = (0.7 + 0.1 * i as f64).sin_cos();
        let scene = Scene::in_phase_space(Straight {}, Valley { x, y });
        there_and_back!(scene, State::at([r * x, r * y]), format!("{r}"));
    }
}

/// What is no rounding is told: a part of 1e-6 of all angular momentum, and of the first equation of a pair.
#[test]
fn starts_near_rest_are_held_to_their_equations() {
    let scene = Scene::in_phase_space(Straight {}, Valley { x: 0.6, y: 0.8 });
    let start = |part: f64| State::at([0.6, 0.8]).moving([0.06 - 0.08 * part, 0.08 + 0.06 * part]);
    scene.simulate(start(0.0), Rattle::new(0.05)).unwrap();
    assert!(scene.simulate(start(1e-6), Rattle::new(0.05)).is_err());
    let scene = Scene::in_phase_space(Pair {}, Well {});
    assert!(scene.simulate(State::at([0.7, 0.2, 1.0]).moving([1e-9, 0.0, 0.0]), Rattle::new(0.05)).is_err());
}
