//! Taylor's method of rigid bodies in lanes beyond agreement with simulations, which `lanes_rigid` tests: its order,
//! rotations and energies, sweeps, failures, and what is met inside of an inner step.

use crate::common::larger;
use crate::lanes_projected::{end_as_alone, fast};
use crate::lanes_projected_rigid::{MOMENTS, lost, scene};
use crate::lanes_rigid::{Alike, Field, check, off, start, start_of_three};
use rattle::bodies::Count;
use rattle::effect::Effects;
use rattle::ensemble::InstructionSet;
use rattle::nalgebra::{Rotation3, Vector3};
use rattle::prelude::*;

potential! {
    /// A hill where the third axis points up, of this width and height.
    struct Hill { width, height }
    |q: [[f64; 3]; 3]| height * exp(-(q[0][2]^2 + q[1][2]^2 + (q[2][2] - 1)^2) / width^2)
}

potential! {
    /// Its slope jumps where the third axis is level.
    struct Level { slope }
    |q: [[f64; 3]; 3]| slope * abs(q[2][2])
}

/// How many of these go in lanes.
fn in_lanes(number: usize) -> usize {
    if InstructionSet::widest().fuses() { number } else { 0 }
}

/// Halved steps leave 2⁻ⁿ⁻¹ of the error of a method of order n: the series of momenta is as long as that of attitudes.
#[test]
fn of_their_orders() {
    let mut exact = scene().simulate(start(1, MOMENTS, 1.0), Dop853::adaptive(0.125, 1e-15)).unwrap();
    exact.run(16).unwrap();
    for order in [2, 5, 8] {
        let [one, two] = [20_u32, 40].map(|steps| {
            let starts = (0..9).map(|_| start(1, MOMENTS, 1.0));
            let mut ensemble = scene().ensemble(starts, Taylor::new(order, 2.0 / f64::from(steps))).unwrap();
            ensemble.run(steps.into());
            let off = |state: State<9>| (state.positions().next().unwrap() - exact.position()).norm();
            ensemble.states().map(off).fold(0.0, larger)
        });
        let found = (one / two).log2();
        println!("{one:e} {two:e}: {found}");
        assert!((found - f64::from(order + 1)).abs() < 0.5, "{found}");
    }
}

/// Attitudes are rotations to rounding, the energy is kept as the tolerance says, and so is the angular momentum of a
/// free body, which the method does not know of.
#[test]
fn rotations_to_rounding_and_energies_to_the_tolerance() {
    let method = Taylor::adaptive(16, 0.5, 1e-13);
    let free = lost(&Scene::rigid(Rigid::new(MOMENTS)), true, method);
    let heavy = lost(&scene(), false, method);
    println!("{free:?} {heavy:?}");
    // 20 units of time, some 100 inner steps, each of which leaves out less than its last terms, which are 1e-13; 1e-14
    // is where attitudes are brought back.
    assert!(free.iter().zip([1e-12, 1e-12, 1e-14]).all(|(found, bound)| *found < bound), "{free:?}");
    assert!(heavy[0] < 1e-12 && heavy[2] < 1e-14 && heavy[1] > 1e-3, "{heavy:?}");
}

/// How far trajectories, each of a scene of its own, are off those by themselves.
fn sweep<E: Effects<9> + Clone + 'static, N: Count>(
    scenes: &[Scene<Rigid, E, N, 9>],
    start: impl Fn(u32) -> State<9>,
    method: Taylor,
) -> f64 {
    let starts: Vec<_> = (0..scenes.len() as u32).map(start).collect();
    let trajectories = scenes.iter().zip(starts.iter().cloned());
    let mut ensemble = Ensemble::sweep(Double, trajectories, method).unwrap();
    assert_eq!(ensemble.plan().in_lanes, in_lanes(scenes.len()));
    off(&mut ensemble, |i| scenes[i].clone(), &starts, &method, 5, MOMENTS)
}

/// Each trajectory has moments of inertia and a weight of its own; and an attraction, which is not of each body by
/// itself.
#[test]
fn sweeps() {
    let share = |i: u32| f64::from(i) / 70.0;
    let one = |i: u32| {
        let field = Field { weight: 1.0 + share(i), pull: 0.5 };
        Scene::rigid(Rigid::new([0.6 + share(i), 0.8, 1.0])).with(field)
    };
    let three = |i: u32| one(i).bodies(3).with(Alike { strength: share(i) }.over([[0, 1], [1, 2]]));
    for method in [Taylor::new(10, 0.05), Taylor::adaptive(12, 0.2, 1e-11)] {
        let each: Vec<_> = (0..70).map(one).collect();
        let found = sweep(&each, |i| start(i, MOMENTS, 1.0), method);
        let few = sweep(&each[..5], |i| start(i, MOMENTS, 1.0), method);
        let pulled: Vec<_> = (0..70).map(three).collect();
        let coupled = sweep(&pulled, |i| start_of_three(i, MOMENTS, 1.0), method);
        check(&[found, few, coupled], MOMENTS);
    }
}

/// Trajectories too fast for their steps end, as they do alone, and [the others](end_as_alone) go on; also in a sweep,
/// where whoever stands in for those that end obeys what it is a copy of.
#[test]
fn who_fails_touches_no_one_else() {
    fn ends(method: Taylor, some_end: bool) {
        let start = |i: u32| start(i, MOMENTS, if fast(i) { 100.0 } else { 1.0 });
        let scene_of = |i: u32| {
            Scene::rigid(Rigid::new(MOMENTS)).with(Field { weight: 1.0 + 0.01 * f64::from(i), pull: 0.5 })
        };
        let of = |numbers: &[u32], set| {
            Ensemble::of(Double, &scene(), numbers.iter().map(|&i| start(i)), method, set).unwrap()
        };
        let alone = |i| scene().simulate(start(i), method).unwrap().run(60).unwrap_err();
        end_as_alone(70, some_end, of, alone);
        let scenes: Vec<_> = (0..70).map(scene_of).collect();
        let of = |numbers: &[u32], _| {
            let each = numbers.iter().map(|&i| (&scenes[i as usize], start(i)));
            Ensemble::sweep(Double, each, method).unwrap()
        };
        let alone = |i| scene_of(i).simulate(start(i), method).unwrap().run(60).unwrap_err();
        end_as_alone(70, some_end, of, alone);
    }
    ends(Taylor::new(8, 0.1), true);
    ends(Taylor::adaptive(10, 0.1, 1e-9), false);
}

/// A lane that meets another branch of a potential takes the step by itself, and ends behind it.
#[test]
fn branches_of_potentials_are_not_passed_over() {
    let scene = Scene::rigid(Rigid::new(MOMENTS)).with(Level { slope: 0.5 });
    let method = Taylor::adaptive(12, 0.25, 1e-10);
    let mut ensemble = scene.ensemble((0..40).map(|i| start(i, MOMENTS, 1.0)), method).unwrap();
    assert_eq!(ensemble.plan().in_lanes, in_lanes(40));
    ensemble.run(16);
    let mut met = 0;
    for i in 0..40 {
        let start = start(i, MOMENTS, 1.0);
        let up = start.positions().next().unwrap()[8];
        let mut alone = scene.simulate(start, method).unwrap();
        alone.run(16).unwrap();
        let (lost, there) = (alone.energy_error().abs(), alone.position());
        let off = (ensemble.state(i as usize).positions().next().unwrap() - there).amax();
        met += usize::from(up * there[8] < 0.0);
        assert!(lost < 2e-9 && off < 2e-8, "{i}: {lost:e} {off:e}");
    }
    assert!(met > 5, "{met}");
}

/// A lane meets as small a change of branch as a simulation does, and takes that step by itself, with the same numbers.
/// Passed over, it would leave momenta 2e-13 off.
#[test]
fn small_changes_of_branch_are_met() {
    let scene = Scene::rigid(Rigid::new(MOMENTS)).with(Level { slope: 1e-12 });
    let start = |i: u32| {
        let angle = std::f64::consts::FRAC_PI_2 - 0.06 - 0.01 * f64::from(i);
        let attitude = Rotation3::from_euler_angles(angle, 0.0, 0.0);
        Rigid::start(attitude.matrix(), &Vector3::new(MOMENTS[0], 0.0, 0.0))
    };
    let starts: Vec<_> = (0..9).map(start).collect();
    let method = Taylor::adaptive(20, 0.25, 1e-14);
    let mut ensemble = scene.ensemble(starts.iter().cloned(), method).unwrap();
    assert_eq!(ensemble.plan().in_lanes, in_lanes(9));
    let off = off(&mut ensemble, |_| scene, &starts, &method, 1, MOMENTS);
    // Some roundings of numbers up to 1.
    assert!(off < 1e-15, "{off:e}");
}

/// A body whose third axis turns towards a hill higher than its energy is thrown back, wherever inner steps begin, by
/// itself and in lanes.
#[test]
fn narrow_hills_are_met_inside_of_inner_steps() {
    let scene = Scene::rigid(Rigid::new([1.0; 3])).with(Hill { width: 0.05, height: 2.0 });
    let start = |i: usize| {
        let attitude = Rotation3::from_axis_angle(&Vector3::y_axis(), -0.4 - 0.02 * i as f64);
        Rigid::start(attitude.matrix(), &Vector3::y())
    };
    let method = Taylor::adaptive(18, 1.0, 1e-8);
    let mut ensemble = scene.ensemble((0..40).map(start), method).unwrap();
    assert_eq!(ensemble.plan().in_lanes, in_lanes(40));
    ensemble.run(2);
    for i in 0..40 {
        let end = ensemble.state(i).positions().next().unwrap();
        let mut alone = scene.simulate(start(i), method).unwrap();
        alone.run(2).unwrap();
        let (off, lost) = ((end - alone.position()).amax(), alone.energy_error().abs());
        assert!(end[2] < 0.0 && off < 1e-6 && lost < 1e-5, "{i}: at {end:?}, {off:e} off, {lost:e}");
    }
}
