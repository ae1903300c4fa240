//! Ensembles: many trajectories in lanes and threads, each the same whatever goes beside it.

use crate::common::*;
use rattle::composition::KAHAN_LI_1997_ORDER_8;
use rattle::ensemble::{Compensated, Double, Ensemble, InstructionSet, Precision, Single};
use rattle::error::{StepFailure, SurfaceFailure};
use rattle::prelude::*;
use rattle::surfaces::Gyroid;
use rattle::{Error, ensemble};
use std::f64::consts::TAU;

fn directions_of(number: usize) -> impl Iterator<Item = State<3>> + Clone {
    (0..number).map(move |i| billiard(TAU * i as f64 / number as f64))
}

/// Places and momenta of all trajectories, by their bits.
fn bits_of<const D: usize>(ensemble: &Ensemble<D>) -> Vec<String> {
    ensemble.states().map(|state| bits(&state)).collect()
}

/// The instruction sets of this processor that fuse.
fn fusing() -> impl Iterator<Item = InstructionSet> {
    use InstructionSet::{Avx2, Avx512, Portable};
    [Portable, Avx2, Avx512].into_iter().filter(|set| set.is_present() && set.fuses())
}

/// The largest difference between the places and momenta of an ensemble and of simulations by themselves.
fn off<P: Precision, S: Method>(precision: P, method: &S, steps: u64) -> f64 {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let mut together = scene.ensemble_in(precision, directions_of(25), method.clone()).unwrap();
    together.run(steps);
    assert_eq!((together.len(), together.steps(), together.failures().count()), (25, steps, 0));
    let mut worst = 0.0_f64;
    for (state, start) in together.states().zip(directions_of(25)) {
        let mut alone = scene.simulate(start, method.clone()).unwrap();
        alone.run(steps).unwrap();
        let (q, p) = (state.positions().next().unwrap(), state.momenta().next().unwrap());
        worst = worst.max(distance(q, alone.position())).max(distance(p, alone.momentum()));
        assert_eq!(state.time(), alone.time());
    }
    worst
}

/// Neighbouring trajectories part like e^(2.3 t) on this surface, the worst by 1e2 until t = 1 and by 1e5 until t = 5.
/// What they start from is the rounding of some steps, of 1e-16 to 1e-15.
#[test]
fn lanes_are_simulations_to_rounding() {
    let rattle = Rattle::new(0.01);
    for (name, until_1, until_5) in [
        ("double", off(Double, &rattle, 100), off(Double, &rattle, 500)),
        ("compensated", off(Compensated, &rattle, 100), off(Compensated, &rattle, 500)),
    ] {
        println!("RATTLE, {name}: {until_1:e} at t = 1, {until_5:e} at t = 5");
        assert!(until_1 < 1e-13 && until_5 < 1e-10, "{name}: {until_1:e}, {until_5:e}");
    }
    let single = off(Single, &rattle, 100);
    println!("single: {single:e}");
    assert!(single < 1e-4 && single > 1e-9, "{single:e}"); // 2²⁹ times that of double
    for coefficients in [SUZUKI_1990_ORDER_4, KAHAN_LI_1997_ORDER_8] {
        let composed = off(Double, &Composition::new(coefficients, 0.02), 50);
        println!("{}: {composed:e}", coefficients.name);
        assert!(composed < 3e-13, "{}: {composed:e}", coefficients.name);
    }
}

#[test]
fn what_does_not_go_in_lanes_goes_alone_and_is_a_simulation() {
    assert_eq!(off(Double, &Bdf2::new(0.02), 20), 0.0);
    assert_eq!(off(Double, &Shake::new(0.02), 20), 0.0);
}

/// One hash for all: any width, any instruction set that fuses, any number of threads, any neighbours, any division of
/// the run.
#[test]
fn the_same_bits_everywhere() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    fn all<P: Precision, S: Method>(
        precision: P,
        method: &S,
        scene: &(impl Fn() -> Vec<State<3>> + Sync),
    ) -> Vec<String> {
        let surface = Scene::on(SURFACE).with(Gravity { g: 1.0 });
        let of = |starts: Vec<State<3>>, set| {
            Ensemble::of(precision, &surface, starts, method.clone(), set).unwrap()
        };
        let widest = InstructionSet::widest();
        let mut first = of(scene(), widest);
        first.run(200);
        let expected = bits_of(&first);
        assert_eq!(expected.len(), 150);
        for set in fusing() {
            let mut other = of(scene(), set);
            assert_eq!(other.instruction_set(), set);
            other.run(200);
            assert_eq!(bits_of(&other), expected, "{set}");
        }
        for threads in [1, 2, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut other = of(scene(), widest);
            pool.install(|| other.run(200));
            assert_eq!(bits_of(&other), expected, "{threads} threads");
        }
        let mut divided = of(scene(), widest);
        for steps in [1, 2, 61, 65, 0, 71] {
            divided.run(steps);
        }
        assert_eq!(bits_of(&divided), expected, "in parts");
        let mut reversed = of(scene().into_iter().rev().collect(), widest);
        reversed.run(200);
        assert!(bits_of(&reversed).iter().rev().eq(&expected), "other neighbours");
        for (i, start) in scene().into_iter().enumerate().step_by(37) {
            let mut alone = of(vec![start], widest);
            alone.run(200);
            assert_eq!(bits_of(&alone), expected[i..=i], "trajectory {i} alone");
        }
        expected
    }
    let starts = || directions_of(150).collect::<Vec<_>>();
    let rattle = Rattle::new(0.01);
    let double = all(Double, &rattle, &starts);
    assert_ne!(all(Compensated, &rattle, &starts), double);
    #[cfg(long)]
    all(Single, &rattle, &starts);
    #[cfg(long)]
    all(Double, &Lobatto::<5>::new(0.025), &starts); // some of whose steps lanes take by themselves
    // Without fused multiply-add bits are others, and the same among themselves.
    let portable = |starts: Vec<State<3>>| {
        let mut ensemble =
            Ensemble::of(Double, &scene, starts, Rattle::new(0.01), InstructionSet::Portable).unwrap();
        ensemble.run(200);
        bits_of(&ensemble)
    };
    let (all, one) = (portable(starts()), portable(vec![starts().swap_remove(31)]));
    assert_eq!(all[31..32], one);
}

constraint! {
    /// A landscape of all functions that have straight-line code.
    pub struct Landscape { height }
    |x, y, z| z - height * exp(-x^2 - y^2) + tanh(x) / 4 - ln(2 + y^2) / 4 - sinh(y / 4) + cosh(x) / 8
}

potential! {
    /// A lattice of hollows.
    pub struct Lattice { depth }
    |x, y, z| depth * (cos(3 * x) + sin(3 * y)) + z
}

/// Waves, bells and steps: near the simulation, whose functions are the system's; the same bits with every instruction
/// set, and alone.
#[test]
fn elementary_functions_in_lanes() {
    fn check<C: rattle::scene::Hold<3> + 'static, E: rattle::effect::Effects<3>>(
        scene: &Scene<C, E, rattle::bodies::One, 3>,
        near: [f64; 3],
    ) {
        let start = |i: u32| State::at(near).moving([f64::from(i).cos(), f64::from(i).sin(), 0.1]);
        let starts: Vec<_> = (0..70).map(|i| scene.project(&start(i)).unwrap()).collect();
        let of = |starts: &[State<3>], set| {
            let mut ensemble = Ensemble::of(Double, scene, starts.to_vec(), Rattle::new(0.01), set).unwrap();
            ensemble.run(100);
            assert_eq!(ensemble.failures().count(), 0);
            ensemble
        };
        let first = of(&starts, InstructionSet::widest());
        for set in fusing() {
            assert_eq!(bits_of(&of(&starts, set)), bits_of(&first), "{set}");
        }
        assert_eq!(bits_of(&of(&starts[33..34], InstructionSet::widest())), bits_of(&first)[33..34]);
        for set in [InstructionSet::Portable, InstructionSet::widest()] {
            for (state, start) in of(&starts, set).states().zip(&starts) {
                let mut alone = scene.simulate(start.clone(), Rattle::new(0.01)).unwrap();
                alone.run(100).unwrap();
                // Rounding grows like e^(3t) at most, from some hundred steps of 1e-16 on coordinates of order 1.
                let gap = distance(state.positions().next().unwrap(), alone.position());
                assert!(gap < 1e-12, "{set}: {gap:e}");
            }
        }
    }
    check(&Scene::on(Gyroid { k: 2.0, epsilon: 0.1 }).with(Lattice { depth: 0.1 }), [0.1, 0.0, 0.0]);
    check(&Scene::on(Landscape { height: 0.5 }).with(Lattice { depth: 0.1 }), [0.1, 0.2, 0.3]);
}

/// So far out that sin is not a number in lanes, a trajectory ends with an error, and only that one.
#[test]
fn beyond_the_farthest_angle_a_trajectory_ends() {
    let scene = Scene::on(Gyroid { k: 1e12, epsilon: 0.0 });
    let start = |i: u32| {
        let at = if i == 3 { 1.2 } else { 0.0 };
        scene.project(&State::at([at, at, at]).moving([1e-4, -2e-4, 1e-4])).unwrap()
    };
    let mut ensemble = scene.ensemble((0..5).map(start), Rattle::new(1e-9)).unwrap();
    ensemble.run(10);
    println!("{:?}", ensemble.failures().collect::<Vec<_>>());
    assert_eq!(ensemble.failures().map(|(trajectory, _)| trajectory).collect::<Vec<_>>(), [3]);
}

#[test]
fn g_scaled_by_powers_of_two_is_the_same_motion() {
    constraint! {
        struct Scaled { a, r, c }
        |x, y, z| {
            let f = (x^2 + y^2)^2 - a^2 * (x^2 - y^2);
            c * (f^2 + z^2 - r^2)
        }
    }
    let run = |c| {
        let scene = Scene::on(Scaled { a: 1.0, r: SURFACE.r, c }).with(Gravity { g: 1.0 });
        let mut ensemble = scene.ensemble(directions_of(64), Rattle::new(0.01)).unwrap();
        ensemble.run(200);
        bits_of(&ensemble)
    };
    let plain = run(1.0);
    for exponent in [-40, -3, 1, 40] {
        assert_eq!(run(2.0_f64.powi(exponent)), plain, "2^{exponent}");
    }
}

/// On the surface to some ulps, tangent, with the energy error of the method, and no drift.
#[test]
fn laws_hold_in_lanes() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let mut ensemble = scene.ensemble(directions_of(640), Rattle::new(0.01)).unwrap();
    let (mut off_surface, mut off_tangent, mut energy) = (0.0_f64, 0.0_f64, 0.0_f64);
    for _ in 0..20 {
        ensemble.run(100);
        for state in ensemble.states() {
            let (q, p) = (state.positions().next().unwrap(), state.momenta().next().unwrap());
            let n = SURFACE.jacobian(&q);
            off_surface = off_surface.max(SURFACE.value(&q)[0].abs() / n.norm());
            off_tangent = off_tangent.max(n.dot(&p.transpose()).abs() / (n.norm() * p.norm()));
            energy = energy.max((0.5 * p.norm_squared() + q.z - 0.5 - SURFACE.r).abs());
        }
    }
    println!(
        "off the surface by {off_surface:e}, off the tangent plane by {off_tangent:e}, energy {energy:e}"
    );
    // Coordinates up to 1.1 round by 1.1e-16 each. The gradient is a product with a difference of numbers up to 1.5
    // that is no larger than r = 1/6, and so rounds by some 1e-15; twice, here and there.
    assert!(off_surface < 6e-16 && off_tangent < 1e-14);
    assert!((6e-3..1.4e-2).contains(&energy), "{energy:e}");
}

/// Thin tubes and curves, no force at all, two coordinates: the same code.
#[test]
fn other_scenes_go_in_lanes_too() {
    let torus = Scene::on(TorusByDistance { major: 1.0, minor: 0.3 });
    let starts =
        (0..10).map(|i| State::at([1.3, 0.0, 0.0]).moving([0.0, f64::from(i).cos(), f64::from(i).sin()]));
    let mut ensemble = torus.ensemble(starts.clone(), Rattle::new(0.01)).unwrap();
    ensemble.run(300);
    for (state, start) in ensemble.states().zip(starts) {
        let mut alone = torus.simulate(start, Rattle::new(0.01)).unwrap();
        alone.run(300).unwrap();
        assert!(distance(state.positions().next().unwrap(), alone.position()) < 1e-13);
    }
    let circle = Scene::on(Pendulum { length: 2.0 }).with(PlanarGravity { g: 9.81 });
    let starts = (0..3).map(|i| State::at([2.0, 0.0]).moving([0.0, f64::from(i)]));
    let mut ensemble = circle.ensemble(starts.clone(), Rattle::new(0.01)).unwrap();
    ensemble.run(300);
    for (state, start) in ensemble.states().zip(starts) {
        let mut alone = circle.simulate(start, Rattle::new(0.01)).unwrap();
        alone.run(300).unwrap();
        assert!(distance(state.positions().next().unwrap(), alone.position()) < 1e-13);
    }
    let thin = Lemniscate { a: 1.0, r: 1e-4 };
    let start = |i: u32| State::at([0.0, 0.0, 1e-4]).moving([f64::from(i).cos(), f64::from(i).sin(), 0.0]);
    let tube = Scene::on(thin);
    let mut ensemble = tube.ensemble((0..20).map(start), Rattle::new(5e-6)).unwrap();
    ensemble.run(2000);
    assert_eq!(ensemble.failures().count(), 0);
    for (i, state) in (0..).zip(ensemble.states()) {
        let mut alone = tube.simulate(start(i), Rattle::new(5e-6)).unwrap();
        alone.run(2000).unwrap();
        let gap = distance(state.positions().next().unwrap(), alone.position());
        assert!(gap < 1e-12, "{i}: {gap:e}");
    }
}

/// Speeds for which the step becomes too long somewhere on the way end there, with the error of a simulation; the
/// others are not touched by it.
#[test]
fn who_fails_rests_and_the_others_go_on() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let start = |i: u32| {
        let speed = if i.is_multiple_of(3) { 5.0 + 0.05 * f64::from(i) } else { 1.0 };
        let angle = 0.37 * f64::from(i);
        State::at([0.0, 0.0, SURFACE.r]).moving([speed * angle.cos(), speed * angle.sin(), 0.0])
    };
    let mut ensemble = scene.ensemble((0..100).map(start), Rattle::new(0.01)).unwrap();
    ensemble.run(500);
    let calm = (0..100).filter(|i| i % 3 != 0);
    let mut calm_ones = scene.ensemble(calm.clone().map(start), Rattle::new(0.01)).unwrap();
    calm_ones.run(500);
    for (i, state) in calm.zip(calm_ones.states()) {
        assert_eq!(bits(&ensemble.state(i as usize)), bits(&state), "trajectory {i}");
        assert!(ensemble.failure(i as usize).is_none());
    }
    let failures: Vec<_> = ensemble.failures().collect();
    assert!(failures.len() > 5, "{} failures", failures.len());
    for &(i, error) in &failures {
        assert!(i % 3 == 0);
        let Error::Step { step, time, cause, .. } = error else { panic!("{error}") };
        assert!(matches!(
            cause,
            StepFailure::Surface(SurfaceFailure::StepTooLong { .. })
                | StepFailure::Surface(SurfaceFailure::RootLost { .. })
                | StepFailure::Surface(SurfaceFailure::NoConvergence { .. })
        ));
        // It rests where it was before that step, which one more step does not change.
        let mut again = scene.ensemble([start(i as u32)], Rattle::new(0.01)).unwrap();
        again.run(step - 1);
        assert_eq!(bits(&again.state(0)), bits(&ensemble.state(i)), "trajectory {i}: {error}");
        assert!(again.failure(0).is_none());
        again.run(1);
        assert_eq!(again.failure(0).unwrap().to_string(), error.to_string());
        assert_eq!(bits(&again.state(0)), bits(&ensemble.state(i)));
        assert!((ensemble.state(i).time() - time).abs() < 1e-12);
    }
}

#[test]
fn all_may_fail() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let start = State::at([0.0, 0.0, SURFACE.r]).moving([0.6, 0.8, 0.0]);
    let mut ensemble = scene.ensemble(vec![start.clone(); 70], Rattle::new(0.3)).unwrap();
    ensemble.run(1000);
    assert_eq!(ensemble.failures().count(), 70);
    assert_eq!(ensemble.steps(), 1000);
    let mut alone = scene.simulate(start, Rattle::new(0.3)).unwrap();
    let error = alone.run(1000).unwrap_err();
    assert!(
        matches!((ensemble.failure(69).unwrap(), error), (Error::Step { step: a, .. }, Error::Step { step: b, .. }) if *a == b)
    );
}

/// Guesses that land beyond the turn of a surface, where the slope is that of another sheet, are not taken: a lane goes
/// where the simulation goes, or ends. (Sheets closer than guesses are off are another matter, and told in the docs.)
#[test]
fn lanes_do_not_change_sheets() {
    constraint! {
        struct Sheets { k }
        |x, y, z| sin(k * (z - 0.3 * sin(3 * x) * cos(2 * y)))
    }
    let scene = Scene::on(Sheets { k: 40.0 });
    let place = |i: u32| [0.37 * f64::from(i), 0.61 * f64::from(i), 0.0].map(|x: f64| x.sin());
    let starts = (0..640).map(|i| {
        let state = State::at(place(i)).moving(place(3 * i + 1).map(|x| 1.3 * x));
        scene.project(&state).unwrap()
    });
    let sheet = |state: &State<3>| {
        let q = state.positions().next().unwrap();
        (40.0 * (q.z - 0.3 * (3.0 * q.x).sin() * (2.0 * q.y).cos()) / std::f64::consts::PI).round()
    };
    let mut ensemble = scene.ensemble(starts.clone(), Rattle::new(0.15)).unwrap();
    ensemble.run(100);
    let changed = ensemble.states().zip(starts).filter(|(now, start)| sheet(now) != sheet(start)).count();
    let ended = ensemble.failures().count();
    assert!(changed == 0 && ended < 300, "{changed} of 640 changed, {ended} ended");
}

#[test]
fn what_is_too_large_for_single_precision_is_refused() {
    let scene = Scene::on(Sphere { r: 1e50 });
    let start = || State::at([1e50, 0.0, 0.0]).moving([0.0, 1.0, 0.0]);
    assert!(scene.ensemble([start()], Rattle::new(0.01)).is_ok());
    let error = scene.ensemble_in(Single, [start()], Rattle::new(0.01)).unwrap_err();
    assert!(matches!(error, Error::Trajectory { trajectory: 0, .. }), "{error}");
}

/// A force that is not a number ends a trajectory in the step in which it acts, as it ends a simulation.
#[test]
fn a_force_that_is_not_a_number_is_told_at_once() {
    constraint! {
        struct Floor {}
        |x, y, z| z + 0 * x + 0 * y
    }
    potential! {
        struct Root {}
        |x, y, z| sqrt(x) + 0 * y + 0 * z
    }
    let scene = Scene::on(Floor {}).with(Root {});
    let start = |speed: f64| State::at([0.1, 0.0, 0.0]).moving([-speed, 0.0, 0.0]);
    for (steps, speed) in [(4, 1.0), (3, 1.0), (150, 1.0)] {
        let mut ensemble = scene.ensemble([start(-3.0), start(speed)], Rattle::new(0.03)).unwrap();
        ensemble.run(steps);
        let mut alone = scene.simulate(start(speed), Rattle::new(0.03)).unwrap();
        let error = alone.run(steps).err();
        assert_eq!(error.is_some(), steps > 3);
        assert_eq!(ensemble.failure(1).map(ToString::to_string), error.map(|error| error.to_string()));
        assert!(distance(ensemble.state(1).positions().next().unwrap(), alone.position()) < 1e-15);
        assert!(ensemble.failure(0).is_none());
    }
}

/// Times are those of simulations, also after stops and starts.
#[test]
fn times_are_those_of_simulations() {
    let scene = Scene::on(SURFACE);
    let mut state = billiard(0.3).at_time(0.7);
    let mut alone = scene.simulate(state.clone(), Rattle::new(0.1 / 3.0)).unwrap();
    for _ in 0..200 {
        let mut ensemble = scene.ensemble([state], Rattle::new(0.1 / 3.0)).unwrap();
        ensemble.run(1);
        state = ensemble.state(0);
        alone.run(1).unwrap();
        assert_eq!(state.time(), alone.time());
    }
    let mut for_ever = scene.ensemble([billiard(0.3)], Rattle::new(5.0)).unwrap();
    for_ever.run(3);
    for_ever.run(u64::MAX); // all have failed
    assert_eq!((for_ever.steps(), for_ever.failures().count()), (u64::MAX, 1));
}

/// The trajectory that is farthest away says how many steps there are; one that has failed does not.
#[test]
fn a_run_goes_until_a_time() {
    let scene = Scene::on(SURFACE);
    for h in [0.1, -0.1] {
        let at = |time: f64| billiard(0.3).at_time(h * time);
        let mut ensemble = scene.ensemble([at(3.0), at(1.5), at(2.0)], Rattle::new(h)).unwrap();
        ensemble.run_until(h * 7.0).unwrap();
        assert_eq!(ensemble.steps(), 6); // 5.5 steps, of the second one
        let mut alone = scene.simulate(at(1.5), Rattle::new(h)).unwrap();
        alone.run_until(h * 7.0).unwrap();
        assert_eq!((alone.steps(), alone.time()), (6, ensemble.time(1)));
        ensemble.run_until(h * 7.0).unwrap();
        ensemble.run_until(h * 2.0).unwrap();
        assert_eq!(ensemble.steps(), 6, "all are there");
    }
    let fast = billiard(0.3).moving([0.0, 1e3, 0.0]);
    let mut ensemble = scene.ensemble([fast, billiard(0.3).at_time(0.5)], Rattle::new(0.1)).unwrap();
    ensemble.run_until(1.0).unwrap();
    assert_eq!((ensemble.steps(), ensemble.failures().count()), (10, 1));
    ensemble.run_until(1.2).unwrap();
    assert_eq!(ensemble.steps(), 10, "the first one goes nowhere any more");
    assert!(matches!(ensemble.run_until(f64::NAN), Err(Error::EndTime(_))));
    // Steps whose lengths the method chooses.
    let mut ensemble =
        scene.ensemble([at_speed(0.3), at_speed(1.2)], Variable::of(Rattle::new(0.01), 0.02)).unwrap();
    ensemble.run_until(0.7).unwrap();
    assert!((0..2).all(|number| ensemble.time(number) >= 0.7 && ensemble.time(number) < 2.0));
}

fn at_speed(speed: f64) -> State<3> {
    billiard(0.3).moving([0.0, speed, 0.0])
}

#[test]
fn a_start_that_is_refused_is_named() {
    let scene = Scene::on(SURFACE);
    let starts = (0..80).map(|i| billiard(0.1).at_time(if i == 71 { f64::NAN } else { 0.0 }));
    let error = scene.ensemble(starts, Rattle::new(0.01)).unwrap_err();
    assert!(matches!(error, Error::Trajectory { trajectory: 71, .. }), "{error}");
    assert!(error.to_string().starts_with("trajectory 71: "));
    assert!(scene.ensemble(directions_of(3), Rattle::new(0.0)).is_err());
    let none = scene.ensemble([], Rattle::new(0.01)).unwrap();
    assert!(none.is_empty() && none.states().count() == 0 && none.failure(0).is_none());
    assert!(matches!(scene.ensemble([], Rattle::new(f64::NAN)), Err(Error::StepSize(h)) if h.is_nan()));
}

/// What rounding does to the energy in 1e5 steps, as a difference to a run of ten times the digits' worth: compensated
/// sums lose less.
#[test]
fn compensated_sums_lose_less() {
    // Not of radius 1: doubles above 1 are twice as far apart as those below, so that rounding of |q|² is biased, and
    // the energy grows by 1.3e-17 of itself in each step.
    let scene = Scene::on(Sphere { r: 1.3 });
    let start = || (0..64).map(|i| State::at([1.3, 0.0, 0.0]).moving([0.0, 1.0 + f64::from(i) / 64.0, 0.0]));
    fn drift(mut ensemble: Ensemble<3>) -> f64 {
        let energies = |ensemble: &Ensemble<3>| {
            ensemble
                .states()
                .map(|state| 0.5 * state.momenta().next().unwrap().norm_squared())
                .collect::<Vec<_>>()
        };
        let before = energies(&ensemble);
        ensemble.run(10_000);
        let after = energies(&ensemble);
        let squares = before.iter().zip(&after).map(|(a, b)| ((a - b) / a).powi(2));
        (squares.sum::<f64>() / 64.0).sqrt()
    }
    // On great circles RATTLE keeps the energy exactly, so that all of it is rounding.
    let plain = drift(scene.ensemble_in(Double, start(), Rattle::new(0.01)).unwrap());
    let compensated = drift(scene.ensemble_in(Compensated, start(), Rattle::new(0.01)).unwrap());
    println!("relative energy after 1e4 steps: double {plain:e}, compensated {compensated:e}");
    assert!(compensated < 0.2 * plain && plain < 2e-13, "{compensated:e} {plain:e}");
}

#[test]
fn a_run_does_not_allocate_and_a_trajectory_takes_little() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build().unwrap();
    pool.install(|| {
        let mut ensemble = scene.ensemble(directions_of(640), Rattle::new(0.01)).unwrap();
        ensemble.run(1);
        let of = |ensemble: &mut Ensemble<3>, steps| {
            allocation_counter::measure(|| ensemble.run(steps)).count_total
        };
        let (few, many) = (of(&mut ensemble, 10), of(&mut ensemble, 1000));
        assert_eq!(few, many, "allocations in 10 and in 1000 steps");
    });
    let mut kept = None;
    let number = 64_000;
    let size = allocation_counter::measure(|| {
        kept = Some(scene.ensemble(directions_of(number), Rattle::new(0.01)).unwrap());
    });
    let each = size.bytes_current as f64 / number as f64;
    println!("{each} bytes per trajectory, 48 of them its state");
    assert!(each > 96.0 && each < 48.0 + 200.0, "{each} bytes per trajectory");
}

#[test]
fn debug_says_what_it_is() {
    let scene = Scene::on(SURFACE);
    let ensemble = scene.ensemble(directions_of(3), Rattle::new(0.01)).unwrap();
    let text = format!("{ensemble:?}");
    assert!(text.contains("trajectories: 3") && text.contains("step_size: 0.01"), "{text}");
    let _: &dyn Fn() -> ensemble::InstructionSet = &InstructionSet::widest;
}

/// Steps so long that lanes are solved by themselves are taken where a simulation takes them, and end where it ends.
#[test]
#[cfg(long)]
fn long_steps_end_where_those_of_a_simulation_end() {
    let ball = Scene::on(Sphere { r: 1.0 });
    let start = State::at([0.48, -0.64, 0.6]).moving([0.8, 0.6, 0.0]);
    for h in [0.58, 0.8, 0.9, 0.92, 0.99] {
        let mut ensemble = ball.ensemble([start.clone(), start.clone()], Rattle::new(h)).unwrap();
        ensemble.run(100);
        let end = ball.simulate(start.clone(), Rattle::new(h)).unwrap().run(100).err();
        assert_eq!(
            ensemble.failure(1).map(ToString::to_string),
            end.map(|error| error.to_string()),
            "h = {h}"
        );
    }
    // A force along the normal, strong against the motion: what lanes keep of it leads off the surface.
    for g in [3e3, 1e4] {
        let pendulum = Scene::on(Sphere { r: 1.0 }).with(Gravity { g });
        let start = State::at([0.05_f64.sin(), 0.0, -0.05_f64.cos()]);
        let mut ensemble = pendulum.ensemble([start.clone()], Rattle::new(0.01)).unwrap();
        ensemble.run(300);
        assert!(ensemble.failure(0).is_none(), "{}", ensemble.failure(0).unwrap());
        let mut simulation = pendulum.simulate(start, Rattle::new(0.01)).unwrap();
        simulation.run(300).unwrap();
        assert!(distance(ensemble.state(0).positions().next().unwrap(), simulation.position()) < 1e-10);
    }
}

/// On great circles guesses are all but exact, so that normals are those of the places: what adds up over 1e5 steps is
/// less than half an ulp of each.
#[test]
fn a_steady_motion_keeps_its_speed() {
    let ball = Scene::on(Sphere { r: 1.0 });
    let start = State::at([0.48, -0.64, 0.6]).moving([0.8, 0.6, 0.0]);
    for h in [0.05, 0.15, 0.3] {
        let mut ensemble = ball.ensemble_in(Compensated, [start.clone()], Rattle::new(h)).unwrap();
        ensemble.run(100_000);
        let speed = ensemble.state(0).momenta().next().unwrap().norm();
        assert!((speed - 1.0).abs() < 1e-11, "h = {h}: {:e}", speed - 1.0);
    }
}

/// The bill of trajectories in lanes, and of others; a run knows nothing of it.
#[test]
fn a_bill_of_trajectories() {
    let scene = Scene::on(Lemniscate { a: 1.0, r: 1.0 / 6.0 }).with(Gravity { g: 1.0 });
    let start = |i: u32| State::at([0.0, 0.0, 1.0 / 6.0]).moving([1.0 / f64::from(i + 1), 0.1, 0.0]);
    let ensemble = || scene.ensemble((0..70).map(start), Rattle::new(0.01)).unwrap();
    let (mut billed, mut other) = (ensemble(), ensemble());
    billed.run(50);
    let bill = billed.bill().unwrap();
    billed.run(50);
    other.run(50);
    other.run(50);
    assert!(billed.states().eq(other.states()));
    let sum = |bill: &rattle::bill::Bill| bill.items.iter().map(|item| item.nanoseconds).sum::<f64>();
    assert!(bill.step > 0.0 && sum(&bill) >= bill.step * (1.0 - 1e-12), "{bill}");
    assert_eq!(bill.items[0].what, "force of `Gravity`");
    let in_lanes = InstructionSet::widest().fuses();
    assert_eq!((bill.bodies, bill.side_by_side), (1, if in_lanes { 64 } else { 1 }));
    // One by one; and no trajectory at all.
    let alone = scene.ensemble((0..3).map(start), Bdf2::new(0.01)).unwrap().bill().unwrap();
    assert_eq!((alone.bodies, alone.side_by_side), (1, 1));
    let nothing = scene.ensemble([], Rattle::new(0.01)).unwrap().bill().unwrap();
    assert!(nothing.items.is_empty() && nothing.step == 0.0);
}
