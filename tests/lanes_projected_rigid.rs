//! DOP853 of rigid bodies in lanes beyond agreement with simulations, which `lanes_rigid` tests: its order, rotations
//! and energies, sweeps, and failures.

use crate::common::larger;
use crate::lanes_projected::{end_as_alone, fast};
use crate::lanes_rigid::{Field, start};
use rattle::ensemble::InstructionSet;
use rattle::error::{Error, MethodFailure, StepFailure};
use rattle::nalgebra::{Matrix3, Vector3};
use rattle::prelude::*;
use std::f64::consts::TAU;

pub(crate) const MOMENTS: [f64; 3] = [0.6, 0.8, 1.0];

pub(crate) fn scene() -> Scene<Rigid, impl rattle::effect::list::Effects<9>, rattle::bodies::One, 9> {
    Scene::rigid(Rigid::new(MOMENTS)).with(Field { weight: 1.0, pull: 0.5 })
}

/// The energy, the angular momentum in space, and how far the attitude is off a rotation, of a body that is free or in
/// [the scene](scene).
fn measured(state: &State<9>, free: bool) -> (f64, Vector3<f64>, f64) {
    let q = Matrix3::from_row_slice(state.positions().next().unwrap().as_slice());
    let m = Vector3::from_iterator(state.momenta().next().unwrap().iter().copied().take(3));
    let kinetic = 0.5 * m.component_div(&Vector3::from(MOMENTS)).dot(&m);
    let potential = q[(2, 2)] + 0.5 * (q[(0, 1)].powi(2) + q[(1, 0)] / 3.0);
    let crooked = (Matrix3::identity() - q.transpose() * q).amax();
    (kinetic + if free { 0.0 } else { potential }, q * m, crooked)
}

/// The most that 80 bodies, all of them in lanes, lose of their energy and of their angular momentum in 40 steps, and
/// how far attitudes are off rotations then.
pub(crate) fn lost<E: rattle::effect::Effects<9>>(
    scene: &Scene<Rigid, E, rattle::bodies::One, 9>,
    free: bool,
    method: impl Method,
) -> [f64; 3] {
    let starts = (0..80).map(|i| start(i, MOMENTS, 1.0));
    let mut ensemble = scene.ensemble(starts, method).unwrap();
    let fuses = InstructionSet::widest().fuses();
    assert_eq!(ensemble.plan().in_lanes, if fuses { 80 } else { 0 });
    let first: Vec<_> = ensemble.states().map(|state| measured(&state, free)).collect();
    ensemble.run(40);
    assert_eq!(ensemble.failures().count(), 0);
    let mut most = [0.0_f64; 3];
    for (state, (energy, momentum, _)) in ensemble.states().zip(first) {
        let (now, turned, crooked) = measured(&state, free);
        let found = [(now - energy).abs(), (turned - momentum).norm(), crooked];
        most.iter_mut().zip(found).for_each(|(most, found)| *most = most.max(found));
    }
    most
}

/// Halved steps leave 2⁻⁸ of the error; the reference is Taylor's method with a tolerance.
#[test]
fn of_order_eight() {
    let mut exact = scene().simulate(start(1, MOMENTS, 1.0), Taylor::adaptive(20, 0.25, 1e-16)).unwrap();
    exact.run(8).unwrap();
    let [one, two] = [8_u32, 16].map(|steps| {
        let starts = (0..9).map(|_| start(1, MOMENTS, 1.0));
        let mut ensemble = scene().ensemble(starts, Dop853::new(2.0 / f64::from(steps))).unwrap();
        ensemble.run(steps.into());
        let off = |state: State<9>| (state.positions().next().unwrap() - exact.position()).norm();
        ensemble.states().map(off).fold(0.0, larger)
    });
    let order = (one / two).log2();
    println!("{one:e} {two:e}: {order}");
    assert!((order - 8.0).abs() < 1.0, "{order}");
}

/// Attitudes are rotations to rounding, the energy is kept as the tolerance says, and so is the angular momentum of a
/// free body, which the method does not know of.
#[test]
fn rotations_to_rounding_and_energies_to_the_tolerance() {
    let method = Dop853::adaptive(0.5, 1e-11);
    let free = lost(&Scene::rigid(Rigid::new(MOMENTS)), true, method);
    let heavy = lost(&scene(), false, method);
    println!("{free:?} {heavy:?}");
    // 20 units of time, some 200 inner steps each of which is off by no more than 1e-11; 1e-14 is where attitudes are
    // brought back.
    assert!(free.iter().zip([1e-9, 1e-9, 1e-14]).all(|(found, bound)| *found < bound), "{free:?}");
    assert!(heavy[0] < 1e-9 && heavy[2] < 1e-14 && heavy[1] > 1e-3, "{heavy:?}");
}

/// Each trajectory has moments of inertia and a weight of its own, and is as in an ensemble of its own scene.
#[test]
fn sweeps() {
    let scenes: Vec<_> = (0..70)
        .map(|i| {
            let share = f64::from(i) / 70.0;
            Scene::rigid(Rigid::new([0.6 + share, 0.8, 1.0])).with(Field { weight: 1.0 + share, pull: 0.5 })
        })
        .collect();
    for method in [Dop853::new(0.1), Dop853::adaptive(0.5, 1e-10)] {
        let each = scenes.iter().enumerate().map(|(i, scene)| (scene, start(i as u32, MOMENTS, 1.0)));
        let mut sweep = Ensemble::sweep(Double, each, method).unwrap();
        sweep.run(5);
        assert_eq!(sweep.plan().in_lanes, if InstructionSet::widest().fuses() { 70 } else { 0 });
        for (i, scene) in scenes.iter().enumerate().step_by(9) {
            let mut own = scene.ensemble([start(i as u32, MOMENTS, 1.0)], method).unwrap();
            own.run(5);
            assert_eq!(format!("{:?}", own.state(0)), format!("{:?}", sweep.state(i)), "trajectory {i}");
        }
    }
}

/// Trajectories too fast for their steps end, as they do alone, and [the others](end_as_alone) go on.
#[test]
fn who_fails_touches_no_one_else() {
    fn check(method: Dop853, some_end: bool) {
        let start = |i: u32| start(i, MOMENTS, if fast(i) { 100.0 } else { 1.0 });
        let of = |numbers: &[u32], set| {
            Ensemble::of(Double, &scene(), numbers.iter().map(|&i| start(i)), method, set).unwrap()
        };
        let alone = |i| scene().simulate(start(i), method).unwrap().run(60).unwrap_err();
        end_as_alone(70, some_end, of, alone);
    }
    check(Dop853::new(0.1), true);
    check(Dop853::adaptive(0.1, 1e-9), false);
}

/// A step that leads an attitude so far astray that it could only be made a rotation of another sheet, or one half a
/// turn away, is refused, by itself and [in lanes](end_as_alone).
#[test]
fn no_attitude_is_turned_over() {
    fn check(moments: [f64; 3], momentum: [f64; 3], method: impl Method) {
        let scene = Scene::rigid(Rigid::new(moments));
        let start = |i: u32| {
            let speed = if fast(i) { 1.0 } else { 0.05 };
            Rigid::start(&Matrix3::identity(), &(speed * Vector3::from(momentum)))
        };
        let of = |numbers: &[u32], set| {
            Ensemble::of(Double, &scene, numbers.iter().map(|&i| start(i)), method.clone(), set).unwrap()
        };
        let alone = |i| {
            let error = scene.simulate(start(i), method.clone()).unwrap().step().unwrap_err();
            let is = matches!(
                error,
                Error::Step { cause: StepFailure::Method(MethodFailure::NotProjected { .. }), .. }
            );
            assert!(is, "{error}");
            error
        };
        end_as_alone(22, true, of, alone);
    }
    // Determinants of −1, and about one axis of 1.
    check([1.28, 0.405, 0.92], [5.12, 0.38475, -1.472], Dop853::new(1.0));
    check([0.37, 0.69, 0.94], [-0.444, 1.035, 1.88], Taylor::new(8, 1.0));
    check([1.0; 3], [0.0, 0.0, 2.4], Taylor::new(2, 1.0));
}

/// About one axis a step of so low an order that is taken leads somewhere near to where the body turns.
#[test]
fn long_steps_are_not_half_a_turn_off() {
    let (mut taken, mut worst) = (0, 0.0_f64);
    for turn in (1..80).map(|i| 0.1 * f64::from(i)) {
        let start = Rigid::start(&Matrix3::identity(), &Vector3::new(0.0, 0.0, turn));
        let mut simulation = Scene::rigid(Rigid::new([1.0; 3])).simulate(start, Taylor::new(2, 1.0)).unwrap();
        if simulation.step().is_ok() {
            let q = simulation.position();
            let off = (q[3].atan2(q[0]) - turn).rem_euclid(TAU);
            (taken, worst) = (taken + 1, worst.max(off.min(TAU - off)));
        }
    }
    println!("{taken} taken, {worst} off");
    assert!(taken > 20 && worst < 0.7, "{taken} taken, {worst} off");
}
