//! DOP853 of linked bodies in lanes beyond agreement with simulations, which `lanes_linked` tests in all its scenes:
//! its order, constraints and energies, sweeps, failures, and other sheets.

use crate::common::{PlanarGravity, bits, larger};
use crate::lanes_projected::{end_as_alone, fast};
use rattle::ensemble::InstructionSet;
use rattle::links::planar::Rod;
use rattle::potentials::planar::weights;
use rattle::prelude::*;

pub(crate) const MASSES: [f64; 3] = [1.0, 2.0, 0.5];

/// A double pendulum.
pub(crate) fn scene()
-> Scene<rattle::network::Network<2>, impl rattle::effect::list::Effects<2>, rattle::bodies::Many, 2> {
    Scene::points(3)
        .link(Rod { length: 1.0 }, [[0, 1], [1, 2]])
        .pin(0, [0.0, 0.0])
        .masses(MASSES)
        .with(weights(1.0, MASSES))
}

/// Both rods turn at this rate.
pub(crate) fn start(angle: f64, rate: f64) -> State<2> {
    let (sin, cos) = angle.sin_cos();
    let momenta = [0.0, 1.0, 2.0].iter().zip(MASSES).map(|(far, mass)| {
        let speed = far * rate * mass;
        [speed * cos, speed * sin]
    });
    State::of([[0.0, 0.0], [sin, -cos], [2.0 * sin, -2.0 * cos]]).with_momenta(momenta)
}

/// Halved steps leave 2⁻⁸ of the error; the reference is a composition of order 8 in short steps.
#[test]
fn of_order_eight() {
    let mut exact = scene().simulate(start(1.0, 0.5), Lobatto::<7>::new(1.0 / 128.0)).unwrap();
    exact.run(128).unwrap();
    let [one, two] = [4_u32, 8].map(|steps| {
        let starts = (0..9).map(|_| start(1.0, 0.5));
        let mut ensemble = scene().ensemble(starts, Dop853::new(1.0 / f64::from(steps))).unwrap();
        ensemble.run(steps.into());
        let off = |state: State<2>| {
            state.positions().zip(exact.positions()).map(|(a, b)| (a - b).norm()).sum::<f64>()
        };
        ensemble.states().map(off).fold(0.0, larger)
    });
    let order = (one / two).log2();
    println!("{one:e} {two:e}: {order}");
    assert!((order - 8.0).abs() < 1.0, "{order}");
}

/// Rods are as long as rounding lets them, velocities are along them, and the energy is kept as the tolerance says.
#[test]
fn constraints_to_rounding_and_energies_to_the_tolerance() {
    let starts = (0..80).map(|i| start(0.5 + 0.03 * f64::from(i), 0.4));
    let mut ensemble = scene().ensemble(starts, Dop853::adaptive(0.5, 1e-11)).unwrap();
    let fuses = InstructionSet::widest().fuses();
    assert_eq!(ensemble.plan().in_lanes, if fuses { 80 } else { 0 });
    let energy = |state: &State<2>| {
        let each = state.positions().zip(state.momenta()).zip(MASSES);
        each.map(|((q, p), mass)| 0.5 * p.norm_squared() / mass + mass * q.y).sum::<f64>()
    };
    let first: Vec<f64> = ensemble.states().map(|state| energy(&state)).collect();
    ensemble.run(40);
    assert_eq!(ensemble.failures().count(), 0);
    let (mut long, mut along, mut lost) = (0.0_f64, 0.0_f64, 0.0_f64);
    for (state, first) in ensemble.states().zip(first) {
        let q: Vec<_> = state.positions().collect();
        let v: Vec<_> = state.momenta().zip(MASSES).map(|(p, mass)| p / mass).collect();
        for i in 0..2 {
            let (rod, turn) = (q[i + 1] - q[i], v[i + 1] - v[i]);
            long = long.max((rod.norm() - 1.0).abs());
            along = along.max(rod.dot(&turn).abs());
        }
        lost = lost.max((energy(&state) - first).abs());
    }
    println!("{long:e} {along:e} {lost:e}");
    // Coordinates up to 2 are rounded to 2e-16, velocities up to 4 to 4e-16.
    assert!(long < 1e-15 && along < 4e-15, "{long:e} {along:e}");
    // 20 units of time, some 200 inner steps each of which is off by no more than 1e-11.
    assert!(lost < 1e-9, "{lost:e}");
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
    for method in [Dop853::new(0.02), Dop853::adaptive(0.2, 1e-10)] {
        let trajectories = scenes.iter().enumerate().map(|(i, scene)| (scene, start(i)));
        let mut ensemble = Ensemble::sweep(Double, trajectories, method).unwrap();
        ensemble.run(5);
        let apart = scenes.iter().enumerate().map(|(i, scene)| {
            let mut alone = scene.simulate(start(i), method).unwrap();
            alone.run(5).unwrap();
            let state = ensemble.state(i);
            let places = state.positions().zip(alone.positions()).map(|(a, b)| (a - b).norm());
            places.chain(state.momenta().zip(alone.momenta()).map(|(a, b)| (a - b).norm())).fold(0.0, larger)
        });
        let apart: Vec<f64> = apart.collect();
        let most = apart.iter().copied().fold(0.0, larger);
        println!("{most:e}");
        let fuses = InstructionSet::widest().fuses();
        assert_eq!(ensemble.plan().in_lanes, if fuses { 70 } else { 0 });
        assert!(most < 4e-14 && (most > 0.0) == fuses, "{most:e}");
    }
}

/// Trajectories too fast for their steps end, as they do alone, and [the others](end_as_alone) go on.
#[test]
fn who_fails_touches_no_one_else() {
    fn check(method: Dop853, some_end: bool) {
        let start = |i: u32| start(0.02 * f64::from(i), if fast(i) { 400.0 } else { 1.0 });
        let of = |numbers: &[u32], set| {
            Ensemble::of(Double, &scene(), numbers.iter().map(|&i| start(i)), method, set).unwrap()
        };
        let alone = |i| scene().simulate(start(i), method).unwrap().run(60).unwrap_err();
        end_as_alone(70, some_end, of, alone);
    }
    check(Dop853::new(0.02), true);
    check(Dop853::adaptive(0.02, 1e-9), false);
}

/// Trajectories that take some steps by themselves have the same bits in any company and order.
#[test]
fn who_goes_by_itself_depends_on_no_other() {
    let start = |i: u32| start(0.05 * f64::from(i), if i.is_multiple_of(2) { 12.0 } else { 0.5 });
    let of = |numbers: &[u32]| {
        let mut ensemble = scene().ensemble(numbers.iter().map(|&i| start(i)), Dop853::new(0.1)).unwrap();
        ensemble.run(100);
        assert_eq!(ensemble.failures().count(), 0);
        ensemble.states().map(|state| bits(&state)).collect::<Vec<_>>()
    };
    let numbers: Vec<u32> = (0..40).collect();
    let (all, back) = (of(&numbers), of(&numbers.iter().rev().copied().collect::<Vec<_>>()));
    for i in 0..40 {
        assert_eq!(all[i], back[39 - i], "trajectory {i}");
    }
    for one in [0, 2, 7] {
        assert_eq!(of(&[one])[0], all[one as usize], "trajectory {one} by itself");
    }
}

/// Where a rod may have many lengths, as close as a step leads astray, each keeps its own, or the motion ends. Without
/// being looked at, six of these would go on with another one.
#[test]
fn other_sheets_are_not_taken_in_silence() {
    constraint! {
        struct Lengths { k }
        |a: [f64; 2], b: [f64; 2]| sin(k * (norm(b - a) - 1))
    }
    let (mut right, mut refused) = (0, 0);
    for (k, h) in [(300.0, 0.6), (1e7, 0.3)] {
        let scene = Scene::points(3)
            .link(Lengths { k }, [[0, 1], [1, 2]])
            .pin(0, [0.0, 0.0])
            .masses(MASSES)
            .with(weights(1.0, MASSES));
        let mut check = |method: Dop853| {
            let starts = (0..26).map(|i| start(0.1 * f64::from(i), 2.0));
            let mut ensemble = scene.ensemble(starts, method).unwrap();
            ensemble.run(4);
            for (i, state) in ensemble.states().enumerate() {
                let q: Vec<_> = state.positions().collect();
                let off = (0..2).map(|n| ((q[n + 1] - q[n]).norm() - 1.0).abs()).fold(0.0, larger);
                assert!(off < 0.1 / k, "k = {k}, h = {h}, trajectory {i}: {off:e} off");
                *if ensemble.failure(i).is_some() { &mut refused } else { &mut right } += 1;
            }
        };
        check(Dop853::new(h));
        check(Dop853::adaptive(h, 1e-6));
    }
    println!("{right} right, {refused} refused");
    assert!(right > 60, "{right} right, {refused} refused");
}

/// Nor where a pinned body takes most of a gradient, and those that are free move for it: lanes that go on do so where
/// simulations do.
#[test]
fn other_sheets_beside_pins_are_asked_for_as_alone() {
    constraint! {
        struct Gear { k, ratio }
        |a: [f64; 2], b: [f64; 2]| sin(k * (b[0] - ratio * a[0] + 0.2 * cos(b[1])))
    }
    let (mut agree, mut refused, mut other) = (0, 0, 0);
    for (k, h) in [(10.0, 2.0), (30.0, 1.0), (30.0, 1.5), (100.0, 0.9), (300.0, 0.7), (1e3, 0.7), (1e4, 0.6)]
    {
        let scene = Scene::points(2).link(Gear { k, ratio: 10.0 }, [[0, 1]]).pin(0, [0.0, 0.0]);
        let starts: Vec<_> = (0..32)
            .map(|i| {
                let y = 0.1 * f64::from(i);
                let start = State::of([[0.0, 0.0], [-0.2 * y.cos(), y]]).with_momenta([[0.0; 2], [0.0, 1.5]]);
                scene.project(&start).unwrap()
            })
            .collect();
        let mut ensemble = scene.ensemble(starts.iter().cloned(), Dop853::new(h)).unwrap();
        ensemble.run(20);
        for (i, start) in starts.iter().enumerate() {
            let ended = scene.simulate(start.clone(), Dop853::new(h)).unwrap().run(20).is_err();
            match (ended, ensemble.failure(i).is_some()) {
                (true, true) => refused += 1,
                (false, false) => agree += 1,
                _ => other += 1,
            }
            let b = ensemble.state(i).positions().nth(1).unwrap();
            let off = (b[0] + 0.2 * b[1].cos()).abs();
            assert!(off < 0.1 / k, "k = {k}, h = {h}, trajectory {i}: {off:e} off");
        }
    }
    println!("{agree} go on, {refused} are refused, {other} by one of both");
    assert!(agree > 100 && refused > 10 && other <= 2, "{agree} {refused} {other}");
}
