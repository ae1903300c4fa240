//! Lobatto methods of linked bodies in lanes beyond agreement with simulations, which `lanes_linked` tests in all its
//! scenes: their order, constraints and energies, sweeps, failures, steps that are taken back, and who goes by itself.

use crate::common::{PlanarGravity, bits, larger};
use crate::lanes_projected::{end_as_alone, fast};
use crate::lanes_projected_linked::{MASSES, scene, start};
use rattle::ensemble::InstructionSet;
use rattle::links::planar::Rod;
use rattle::method::Method;
use rattle::prelude::*;

/// Halved steps leave 2⁻⁴ and 2⁻⁸ of the error; the reference is a method that knows of no stages.
#[test]
fn of_their_orders() {
    fn order(method: impl Fn(f64) -> f64) -> f64 {
        let [one, two] = [8.0, 16.0].map(method);
        println!("{one:e} {two:e}: {}", (one / two).log2());
        (one / two).log2()
    }
    let mut exact = scene().simulate(start(1.0, 0.5), Taylor::adaptive(24, 0.25, 1e-16)).unwrap();
    exact.run(4).unwrap();
    let off = |ensemble: &mut Ensemble<2>, steps: f64| {
        ensemble.run(steps as u64);
        let off = |state: State<2>| {
            state.positions().zip(exact.positions()).map(|(a, b)| (a - b).norm()).sum::<f64>()
        };
        ensemble.states().map(off).fold(0.0, larger)
    };
    let starts = || (0..9).map(|_| start(1.0, 0.5));
    let three =
        order(|steps| off(&mut scene().ensemble(starts(), Lobatto::<3>::new(1.0 / steps)).unwrap(), steps));
    let five =
        order(|steps| off(&mut scene().ensemble(starts(), Lobatto::<5>::new(1.0 / steps)).unwrap(), steps));
    assert!((three - 4.0).abs() < 0.3 && (five - 8.0).abs() < 0.6, "{three} {five}");
}

/// Rods are as long as rounding lets them, velocities are along them, and the energy does not drift.
#[test]
fn constraints_to_rounding_and_no_drift() {
    let starts = (0..80).map(|i| start(0.5 + 0.01 * f64::from(i), 0.4));
    let mut ensemble = scene().ensemble(starts, Lobatto::<5>::new(0.05)).unwrap();
    let fuses = InstructionSet::widest().fuses();
    assert_eq!(ensemble.plan().in_lanes, if fuses { 80 } else { 0 });
    let energy = |state: &State<2>| {
        let each = state.positions().zip(state.momenta()).zip(MASSES);
        each.map(|((q, p), mass)| 0.5 * p.norm_squared() / mass + mass * q.y).sum::<f64>()
    };
    let first: Vec<f64> = ensemble.states().map(|state| energy(&state)).collect();
    let mut most = [0.0_f64; 2];
    for half in &mut most {
        for _ in 0..20 {
            ensemble.run(25);
            for (state, first) in ensemble.states().zip(&first) {
                *half = half.max((energy(&state) - first).abs());
            }
        }
    }
    assert_eq!(ensemble.failures().count(), 0);
    let (mut long, mut along) = (0.0_f64, 0.0_f64);
    for state in ensemble.states() {
        let q: Vec<_> = state.positions().collect();
        let v: Vec<_> = state.momenta().zip(MASSES).map(|(p, mass)| p / mass).collect();
        for i in 0..2 {
            let (rod, turn) = (q[i + 1] - q[i], v[i + 1] - v[i]);
            long = long.max((rod.norm() - 1.0).abs());
            along = along.max(rod.dot(&turn).abs());
        }
    }
    println!("{long:e} {along:e} {most:?}");
    // Coordinates up to 2 are rounded to 2e-16, velocities up to 4 to 4e-16.
    assert!(long < 1e-15 && along < 4e-15, "{long:e} {along:e}");
    // The error of order 8 goes to and fro: in the second half of 50 units of time it is no larger.
    assert!(most[0] < 1e-9 && most[1] < 1.5 * most[0], "{most:?}");
}

/// Each trajectory has masses, lengths and gravity of its own.
#[test]
fn sweeps() {
    let scenes: Vec<_> = (0..70)
        .map(|i| {
            let share = f64::from(i) / 70.0;
            Scene::points(3)
                .link_each((0..2).map(|n| (Rod { length: 1.0 + share }, [n, n + 1])))
                .pin(0, [0.0, 0.0])
                .masses([1.0, 1.0 + share, 2.0 - share])
                .with(PlanarGravity { g: 1.0 + share })
        })
        .collect();
    let start = |i: usize| {
        let length = 1.0 + i as f64 / 70.0;
        State::of([[0.0, 0.0], [length, 0.0], [2.0 * length, 0.0]])
    };
    let trajectories = scenes.iter().enumerate().map(|(i, scene)| (scene, start(i)));
    let mut ensemble = Ensemble::sweep(Double, trajectories, Lobatto::<4>::new(0.05)).unwrap();
    ensemble.run(5);
    let apart = scenes.iter().enumerate().map(|(i, scene)| {
        let mut alone = scene.simulate(start(i), Lobatto::<4>::new(0.05)).unwrap();
        alone.run(5).unwrap();
        let state = ensemble.state(i);
        let places = state.positions().zip(alone.positions()).map(|(a, b)| (a - b).norm());
        places.chain(state.momenta().zip(alone.momenta()).map(|(a, b)| (a - b).norm())).fold(0.0, larger)
    });
    let most = apart.fold(0.0, larger);
    println!("{most:e}");
    let fuses = InstructionSet::widest().fuses();
    assert_eq!(ensemble.plan().in_lanes, if fuses { 70 } else { 0 });
    assert!(most < 2e-14 && (most > 0.0) == fuses, "{most:e}");
}

/// Trajectories too fast for their steps end, as they do alone, and [the others](end_as_alone) go on.
#[test]
fn who_fails_touches_no_one_else() {
    let method = Lobatto::<3>::new(0.02);
    let start = |i: u32| start(0.02 * f64::from(i), if fast(i) { 400.0 } else { 1.0 });
    let of = |numbers: &[u32], set| {
        Ensemble::of(Double, &scene(), numbers.iter().map(|&i| start(i)), method, set).unwrap()
    };
    let alone = |i| scene().simulate(start(i), method).unwrap().run(60).unwrap_err();
    end_as_alone(70, true, of, alone);
}

/// How many of ten steps of these trajectories, each 0.1 long, lead farther off the mean of the velocities at their
/// ends than a tenth of the path: those no lane takes.
fn bold(ensemble: &mut Ensemble<2>) -> usize {
    let mut number = 0;
    for _ in 0..10 {
        let before: Vec<_> = ensemble.states().collect();
        ensemble.run(1);
        for (from, to) in before.iter().zip(ensemble.states()) {
            let [mut off, mut paths] = [0.0; 2];
            for body in 0..3 {
                let [(q, v), (r, w)] = [from, &to].map(|state| {
                    let momentum = state.momenta().nth(body).unwrap();
                    (state.positions().nth(body).unwrap(), momentum / MASSES[body])
                });
                let path = 0.05 * (v + w);
                off += (r - q - path).norm_squared();
                paths += path.norm_squared();
            }
            number += usize::from(off > 0.01 * paths);
        }
    }
    number
}

/// Trajectories that take some steps by themselves have the same bits in any company and order, and in any division of
/// the run.
#[test]
fn who_goes_by_itself_depends_on_no_other() {
    let start = |i: u32| start(0.05 * f64::from(i), if i.is_multiple_of(2) { 12.0 } else { 0.5 });
    let of = |numbers: &[u32], runs: &[u64]| {
        let starts = numbers.iter().map(|&i| start(i));
        let mut ensemble = scene().ensemble(starts, Lobatto::<5>::new(0.1)).unwrap();
        runs.iter().for_each(|&steps| ensemble.run(steps));
        assert_eq!(ensemble.failures().count(), 0);
        ensemble.states().map(|state| bits(&state)).collect::<Vec<_>>()
    };
    let numbers: Vec<u32> = (0..40).collect();
    assert!(
        bold(&mut scene().ensemble(numbers.iter().map(|&i| start(i)), Lobatto::<5>::new(0.1)).unwrap()) > 100
    );
    let all = of(&numbers, &[60]);
    let back = of(&numbers.iter().rev().copied().collect::<Vec<_>>(), &[1, 7, 52]);
    for i in 0..40 {
        assert_eq!(all[i], back[39 - i], "trajectory {i}");
    }
    for one in [0, 2, 7] {
        assert_eq!(of(&[one], &[59, 1])[0], all[one as usize], "trajectory {one} by itself");
    }
}

/// Those pass whose steps can be taken back that pass as simulations, and with the same states but for rounding.
#[test]
fn steps_are_taken_back_as_in_simulations() {
    fn check<S: Method + Copy>(method: S, tolerance: f64) -> (usize, usize) {
        let start = |i: u32| start(0.1 * f64::from(i), 0.5 * f64::from(i % 9));
        let starts = (0..45).map(start);
        let mut ensemble = scene().ensemble(starts, method).unwrap().check_reversal(tolerance).unwrap();
        ensemble.run(3);
        let mut number = (0, 0);
        for i in 0..45 {
            let mut alone = scene().simulate(start(i), method).unwrap().check_reversal(tolerance).unwrap();
            let passed = alone.run(3).is_ok();
            *if passed { &mut number.0 } else { &mut number.1 } += 1;
            assert_eq!(ensemble.failure(i as usize).is_none(), passed, "trajectory {i}");
            let state = ensemble.state(i as usize);
            let off = state.positions().zip(alone.positions()).map(|(a, b)| (a - b).norm()).sum::<f64>();
            assert!(!passed || off < 1e-13, "trajectory {i}: {off:e}");
        }
        number
    }
    let (passed, refused) = check(Lobatto::<3>::new(0.5), 1e-11);
    println!("{passed} passed, {refused} refused");
    assert!(passed > 5 && refused > 5, "{passed} passed, {refused} refused");
    // Steps that come back but for rounding: that is more than this tolerance.
    let (_, refused) = check(Lobatto::<3>::new(0.05), 1e-18);
    assert!(refused > 5, "{refused} refused");
}
