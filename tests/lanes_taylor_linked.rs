//! Taylor's method of linked bodies in lanes: as each trajectory alone but for rounding, whatever the links, masses and
//! effects; its order, constraints and energies, sweeps, failures, branches of potentials, and other sheets.

use crate::common::{PlanarGravity, Trough, bits, larger};
use crate::lanes_linked::{chain, check, off_alone, starts};
use crate::lanes_projected::{end_as_alone, fast};
use crate::lanes_projected_linked::{MASSES, scene, start};
use rattle::bodies::Count;
use rattle::effect::Effects;
use rattle::ensemble::InstructionSet;
use rattle::links::planar::Rod as PlanarRod;
use rattle::links::{Angle, Rod};
use rattle::network::Network;
use rattle::potentials::planar::{Spring, weights};
use rattle::prelude::*;
use rattle::scene::Hold;

pair_potential! {
    struct Repulsion { strength }
    |r| strength * exp(-r^2)
}

potential! {
    /// Its slope jumps at x = 0.
    struct Edge { slope }
    |x, y| y + slope * abs(x)
}

potential! {
    /// Its slope jumps at this x.
    struct Ledge { x0, slope }
    |x, y| y + slope * abs(x - x0)
}

potential! {
    /// A narrow hill.
    struct Hill { x0, y0, width, height }
    |x, y| height * exp(-((x - x0)^2 + (y - y0)^2) / width^2)
}

/// Fixed steps and inner ones, forwards and backwards; one trajectory, a few, some rows of a few, and more than a wide
/// row.
fn agree<C: Hold<D> + 'static, E: Effects<D>, N: Count, const D: usize>(
    scene: &Scene<C, E, N, D>,
    places: impl Fn(f64) -> Vec<[f64; D]>,
) {
    fn off<C: Hold<D> + 'static, E: Effects<D>, N: Count, const D: usize>(
        scene: &Scene<C, E, N, D>,
        starts: &[State<D>],
        method: Taylor,
        steps: u64,
    ) -> f64 {
        let mut ensemble = scene.ensemble(starts.iter().cloned(), method).unwrap();
        ensemble.run(steps);
        assert_eq!(ensemble.plan().in_lanes, if InstructionSet::widest().fuses() { starts.len() } else { 0 });
        let each = starts.iter().enumerate().step_by(3);
        each.map(|(i, start)| off_alone(&ensemble, i, scene, start, &method, steps)).fold(0.0, larger)
    }
    let starts = starts(scene, places);
    check(&[
        off(scene, &starts, Taylor::new(15, 0.02), 25),
        off(scene, &starts[..20], Taylor::new(2, -0.01), 20),
        off(scene, &starts[..3], Taylor::new(9, 0.02), 25),
        off(scene, &starts, Taylor::adaptive(12, 0.1, 1e-12), 5),
        off(scene, &starts[..20], Taylor::adaptive(18, 0.25, 1e-13), 2),
        off(scene, &starts[..1], Taylor::adaptive(9, -0.25, 1e-10), 2),
    ]);
}

#[test]
fn double_pendulums_under_springs_and_repulsion() {
    let scene = scene()
        .with(Spring { stiffness: 2.0, length: 0.5 }.over([[0, 2]]))
        .with(Repulsion { strength: 1.0 })
        .with(Edge { slope: 0.3 });
    agree(&scene, |lean| chain(2, lean));
}

#[test]
fn chains_in_space_with_weights_and_a_free_end() {
    let scene = Scene::points(7)
        .link(Rod { length: 1.0 }, (0..5).map(|i| [i, i + 1])) // body 6 is free
        .masses((0..7).map(|i| [1.0 + 0.1 * f64::from(i), 2.0, 0.7]))
        .with(Trough { g: 0.5 })
        .with(rattle::potentials::weights(1.0, (0..7).map(f64::from)));
    agree(&scene, |lean| [chain(5, lean), vec![[3.0, 1.0, lean]]].concat());
}

/// Of more than 64 coordinates, which go in rows of a few.
#[test]
fn long_chains() {
    let scene = Scene::points(40)
        .link(PlanarRod { length: 0.1 }, (0..39).map(|i| [i, i + 1]))
        .pin(0, [0.0, 0.0])
        .with(PlanarGravity { g: 1.0 });
    agree(&scene, |lean| {
        let places = (0..40).map(|i| {
            let x = 0.1 * f64::from(i);
            [x * lean.sin(), -x * lean.cos()]
        });
        places.collect()
    });
}

/// A net that hangs from two corners, with more links than trees have; and a link between pins, no equation of motion.
#[test]
fn pinned_nets() {
    let body = |x: usize, y: usize| 4 * y + x;
    let across = (0..3).flat_map(move |y| (0..3).map(move |x| [body(x, y), body(x + 1, y)]));
    let down = (0..2).flat_map(move |y| (0..4).map(move |x| [body(x, y), body(x, y + 1)]));
    let scene = Scene::points(13)
        .link(Rod { length: 1.0 }, across.chain(down).chain([[0, 12]]))
        .pin(0, [0.0, 0.0, 0.0])
        .pin(3, [2.6, 0.0, 0.0])
        .pin(12, [-1.0, 0.0, 0.0])
        .with(Trough { g: 1.0 });
    agree(&scene, |lean| {
        let (sin, cos) = (0.3 * lean).sin_cos();
        let row = [[0.0, 0.0], [0.8, -0.6], [1.8, -0.6], [2.6, 0.0]];
        let hang = |i: usize| {
            let ([x, z], down) = (row[i % 4], (i / 4) as f64);
            [x, sin * down, z - cos * down]
        };
        (0..12).map(hang).chain([[-1.0, 0.0, 0.0]]).collect()
    });
}

/// A ring fills in where it is eliminated.
#[test]
fn rings_and_angles() {
    let ring = |lean: f64| {
        let corner = |i: u32| {
            let angle = lean + f64::from(i) * std::f64::consts::TAU / 5.0;
            let radius = 0.5 / (std::f64::consts::TAU / 10.0).sin();
            [radius * angle.cos(), radius * angle.sin(), 0.3 * lean]
        };
        (0..5).map(corner).collect()
    };
    let inner = 0.6 * std::f64::consts::PI;
    let scene = Scene::points(5)
        .link(Rod { length: 1.0 }, (0..5).map(|i| [i, (i + 1) % 5]))
        .link(Angle { angle: inner }, [[0, 1, 2]])
        .with(Trough { g: 1.0 });
    agree(&scene, ring);
}

/// Components of two bodies each, with forces between all.
#[test]
fn dumbbells_that_repel_each_other() {
    let scene = Scene::points(6)
        .link(PlanarRod { length: 1.0 }, [[0, 1], [2, 3], [4, 5]])
        .with(Repulsion { strength: 2.0 });
    let places = |lean: f64| {
        let pair = |i: u32| {
            let (x, angle) = (1.5 * f64::from(i), lean * f64::from(i + 1));
            [[x, 0.0], [x + angle.cos(), angle.sin()]]
        };
        (0..3).flat_map(pair).collect()
    };
    agree(&scene, places);
}

/// Halved steps leave 2⁻ⁿ of the error of a method of order n.
#[test]
fn of_their_orders() {
    let mut exact = scene().simulate(start(1.0, 0.5), Dop853::adaptive(0.125, 1e-15)).unwrap();
    exact.run(8).unwrap();
    for order in [4, 7] {
        let [one, two] = [16_u32, 32].map(|steps| {
            let starts = (0..9).map(|_| start(1.0, 0.5));
            let mut ensemble = scene().ensemble(starts, Taylor::new(order, 1.0 / f64::from(steps))).unwrap();
            ensemble.run(steps.into());
            let off = |state: State<2>| {
                state.positions().zip(exact.positions()).map(|(a, b)| (a - b).norm()).sum::<f64>()
            };
            ensemble.states().map(off).fold(0.0, larger)
        });
        let found = (one / two).log2();
        println!("{one:e} {two:e}: {found}");
        assert!((found - f64::from(order)).abs() < 1.0, "{found}");
    }
}

/// Rods are as long as rounding lets them, velocities are along them, and the energy is kept as the tolerance says.
#[test]
fn constraints_to_rounding_and_energies_to_the_tolerance() {
    let starts = (0..80).map(|i| start(0.5 + 0.03 * f64::from(i), 0.4));
    let mut ensemble = scene().ensemble(starts, Taylor::adaptive(14, 0.5, 1e-12)).unwrap();
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
    // 20 units of time, some 100 inner steps, each of which leaves out less than its last terms, which are 1e-12.
    assert!(lost < 1e-11, "{lost:e}");
}

/// Trajectories of rows of 64 have the bits that they have in rows of 8, and beside no other.
#[test]
fn the_same_bits_in_rows_of_any_width() {
    let start = |i: u32| start(0.03 * f64::from(i), 0.4);
    for method in [Taylor::new(10, 0.05), Taylor::adaptive(12, 0.4, 1e-9)] {
        let of = |numbers: &[u32]| {
            let mut ensemble = scene().ensemble(numbers.iter().map(|&i| start(i)), method).unwrap();
            ensemble.run(30);
            assert_eq!(ensemble.failures().count(), 0);
            ensemble.states().map(|state| bits(&state)).collect::<Vec<_>>()
        };
        let all = of(&(0..70).collect::<Vec<_>>());
        for few in [&[3][..], &[69, 5, 17], &(0..20).rev().collect::<Vec<_>>()] {
            let expected: Vec<_> = few.iter().map(|&i| all[i as usize].clone()).collect();
            assert_eq!(of(few), expected, "{few:?}");
        }
    }
}

/// How far trajectories, each of a scene of its own, are off those by themselves.
fn sweep<E: Effects<2> + 'static, N: Count>(
    scenes: &[Scene<Network<2>, E, N, 2>],
    start: impl Fn(usize) -> State<2>,
    method: Taylor,
) -> f64 {
    let trajectories = scenes.iter().enumerate().map(|(i, scene)| (scene, start(i)));
    let mut ensemble = Ensemble::sweep(Double, trajectories, method).unwrap();
    ensemble.run(5);
    assert_eq!(ensemble.plan().in_lanes, if InstructionSet::widest().fuses() { scenes.len() } else { 0 });
    let each = scenes.iter().enumerate();
    each.map(|(i, scene)| off_alone(&ensemble, i, scene, &start(i), &method, 5)).fold(0.0, larger)
}

/// Each trajectory has masses, lengths and gravity of its own; and repulsion and springs, which are not of each body by
/// itself.
#[test]
fn sweeps() {
    let share = |i: usize| i as f64 / 70.0;
    let scene = |i: usize| {
        Scene::points(3)
            .link_each((0..2).map(|n| (PlanarRod { length: 1.0 + share(i) }, [n, n + 1])))
            .pin(0, [0.0, 0.0])
            .masses([1.0, 1.0 + share(i), 2.0 - share(i)])
            .with(PlanarGravity { g: 1.0 + share(i) })
    };
    let start = |i: usize| {
        let length = 1.0 + share(i);
        State::of([[0.0, 0.0], [length, 0.0], [2.0 * length, 0.0]])
    };
    let plain: Vec<_> = (0..70).map(scene).collect();
    let pulled: Vec<_> = (0..70)
        .map(|i| {
            let spring = Spring { stiffness: share(i), length: 1.0 }.over([[0, 2]]);
            scene(i).with(Repulsion { strength: 1.0 - share(i) }).with(spring)
        })
        .collect();
    let methods = [Taylor::new(10, 0.02), Taylor::adaptive(12, 0.2, 1e-11)];
    check(&methods.map(|method| sweep(&plain, start, method)));
    check(&methods.map(|method| sweep(&pulled, start, method)));
    check(&methods.map(|method| sweep(&plain[..9], start, method)));
}

/// Trajectories too fast for their steps end, as they do alone, and [the others](end_as_alone) go on.
#[test]
fn who_fails_touches_no_one_else() {
    fn check(method: Taylor, some_end: bool) {
        let start = |i: u32| start(0.02 * f64::from(i), if fast(i) { 400.0 } else { 1.0 });
        let of = |numbers: &[u32], set| {
            Ensemble::of(Double, &scene(), numbers.iter().map(|&i| start(i)), method, set).unwrap()
        };
        let alone = |i| scene().simulate(start(i), method).unwrap().run(60).unwrap_err();
        end_as_alone(70, some_end, of, alone);
    }
    check(Taylor::new(8, 0.02), true);
    check(Taylor::adaptive(10, 0.02, 1e-9), false);
}

/// In a sweep whoever stands in for those that end obeys what it is a copy of, wherever in the row.
#[test]
fn who_fails_in_a_sweep_touches_no_one_else() {
    fn check<E: Effects<2> + 'static, N: Count>(scenes: &[Scene<Network<2>, E, N, 2>]) {
        let method = Taylor::new(8, 0.02);
        let start = |i: u32| {
            let (length, rate) = (1.0 + f64::from(i) / 70.0, if fast(i) { 400.0 } else { 1.0 });
            State::of([[0.0, 0.0], [length, 0.0], [2.0 * length, 0.0]]).with_momenta([
                [0.0, 0.0],
                [0.0, rate * length],
                [0.0, 2.0 * rate * length],
            ])
        };
        let of = |numbers: &[u32], _| {
            let trajectories = numbers.iter().map(|&i| (&scenes[i as usize], start(i)));
            Ensemble::sweep(Double, trajectories, method).unwrap()
        };
        let alone = |i| scenes[i as usize].simulate(start(i), method).unwrap().run(60).unwrap_err();
        end_as_alone(70, true, of, alone);
    }
    let scene = |i: u32| {
        let share = f64::from(i) / 70.0;
        Scene::points(3)
            .link(PlanarRod { length: 1.0 + share }, [[0, 1], [1, 2]])
            .pin(0, [0.0, 0.0])
            .with(PlanarGravity { g: 1.0 + share })
    };
    check(&(0..70).map(scene).collect::<Vec<_>>());
    let repelled = |i: u32| scene(i).with(Repulsion { strength: 0.02 * f64::from(i) });
    check(&(0..70).map(repelled).collect::<Vec<_>>());
}

/// Trajectories that take some steps by themselves have the same bits in any company and order.
#[test]
fn who_goes_by_itself_depends_on_no_other() {
    let start = |i: u32| start(0.05 * f64::from(i), if i.is_multiple_of(2) { 12.0 } else { 0.5 });
    let survived = std::cell::Cell::new(0);
    let of = |numbers: &[u32]| {
        let method = Taylor::new(9, 0.1);
        let mut ensemble = scene().ensemble(numbers.iter().map(|&i| start(i)), method).unwrap();
        ensemble.run(100);
        let survivors =
            numbers.iter().enumerate().filter(|&(n, i)| i % 2 == 0 && ensemble.failure(n).is_none());
        survived.set(survivors.count());
        ensemble.states().map(|state| bits(&state)).collect::<Vec<_>>()
    };
    let numbers: Vec<u32> = (0..40).collect();
    let (all, back) = (of(&numbers), of(&numbers.iter().rev().copied().collect::<Vec<_>>()));
    println!("{} of the 20 fast ones survive", survived.get());
    assert!(survived.get() > 5, "{}", survived.get());
    for i in 0..40 {
        assert_eq!(all[i], back[39 - i], "trajectory {i}");
    }
    for one in [0, 2, 7] {
        assert_eq!(of(&[one])[0], all[one as usize], "trajectory {one} by itself");
    }
}

/// A lane that meets another branch of a potential takes the step by itself, and ends behind it.
#[test]
fn branches_of_potentials_are_not_passed_over() {
    let scene = Scene::points(3)
        .link(PlanarRod { length: 1.0 }, [[0, 1], [1, 2]])
        .pin(0, [0.0, 0.0])
        .with(Edge { slope: 0.5 });
    let start = |i: u32| start(0.1 + 0.02 * f64::from(i), -0.3);
    let method = Taylor::adaptive(12, 0.25, 1e-10);
    let mut ensemble = scene.ensemble((0..40).map(start), method).unwrap();
    assert_eq!(ensemble.plan().in_lanes == 40, InstructionSet::widest().fuses());
    ensemble.run(16);
    let mut met = 0;
    for i in 0..40 {
        let mut alone = scene.simulate(start(i), method).unwrap();
        let sides = |alone: &Simulation<_, _, 2>| alone.positions().map(|q| q.x > 0.0).collect::<Vec<_>>();
        let before = sides(&alone);
        alone.run(16).unwrap();
        met += usize::from(sides(&alone) != before);
        let state = ensemble.state(i as usize);
        let off = state.positions().zip(alone.positions()).map(|(a, b)| (a - b).norm()).fold(0.0, larger);
        let lost = alone.energy_error().abs();
        println!("{lost:e} {off:e}");
        assert!(lost < 2e-8 && off < 2e-7, "{i}: {lost:e} {off:e}");
    }
    assert!(met > 5, "{met}");
}

/// Far from the origin too, where places are rounded to 1e-10, a lane meets as small a change of branch as a simulation
/// does, and takes that step by itself, with the same numbers. Passed over, it would leave momenta 2e-7 off.
#[test]
fn small_changes_of_branch_are_met_far_from_the_origin() {
    let x0 = 1e6;
    let scene = Scene::points(2)
        .link(PlanarRod { length: 1.0 }, [[0, 1]])
        .pin(0, [x0, 0.0])
        .with(Ledge { x0, slope: 1e-6 });
    let start = |i: u32| {
        let (sin, cos) = (-0.06 - 0.01 * f64::from(i)).sin_cos();
        let start = State::of([[x0, 0.0], [x0 + sin, -cos]]).with_momenta([[0.0, 0.0], [cos, sin]]);
        scene.project(&start).unwrap()
    };
    let method = Taylor::adaptive(12, 0.25, 1e-9);
    let mut ensemble = scene.ensemble((0..9).map(start), method).unwrap();
    assert_eq!(ensemble.plan().in_lanes, if InstructionSet::widest().fuses() { 9 } else { 0 });
    ensemble.run(1);
    for i in 0..9 {
        let off = off_alone(&ensemble, i, &scene, &start(i as u32), &method, 1);
        // A rounding of places, which a lane hands over as they are.
        assert!(off < 2e-10, "{i}: {off:e}");
    }
}

/// Where a rod may have many lengths, as close as a step leads astray, each keeps its own, or the motion ends.
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
        for method in [Taylor::new(6, h), Taylor::adaptive(8, h, 1e-6)] {
            let starts = (0..26).map(|i| start(0.1 * f64::from(i), 2.0));
            let mut ensemble = scene.ensemble(starts, method).unwrap();
            ensemble.run(4);
            for (i, state) in ensemble.states().enumerate() {
                let q: Vec<_> = state.positions().collect();
                let off = (0..2).map(|n| ((q[n + 1] - q[n]).norm() - 1.0).abs()).fold(0.0, larger);
                assert!(off < 0.1 / k, "k = {k}, h = {h}, trajectory {i}: {off:e} off");
                *if ensemble.failure(i).is_some() { &mut refused } else { &mut right } += 1;
            }
        }
    }
    println!("{right} right, {refused} refused");
    assert!(right > 20, "{right} right, {refused} refused");
}

/// A rod that turns towards a hill higher than its energy is thrown back, wherever inner steps begin. Compared at the
/// ends of these alone, two thirds of them would turn on, through the hill.
#[test]
fn narrow_hills_are_met_inside_of_inner_steps() {
    let scene = Scene::points(2)
        .link(PlanarRod { length: 1.0 }, [[0, 1]])
        .pin(0, [0.0, 0.0])
        .with(Hill { x0: 0.0, y0: 1.0, width: 0.05, height: 2.0 }.over([[1]]));
    let start = |i: usize| {
        let (sin, cos) = (0.4 + 0.02 * i as f64).sin_cos();
        State::of([[0.0, 0.0], [cos, sin]]).with_momenta([[0.0, 0.0], [-sin, cos]])
    };
    let method = Taylor::adaptive(18, 1.0, 1e-8);
    let mut ensemble = scene.ensemble((0..40).map(start), method).unwrap();
    assert_eq!(ensemble.plan().in_lanes, if InstructionSet::widest().fuses() { 40 } else { 0 });
    ensemble.run(2);
    for i in 0..40 {
        let end = ensemble.state(i).positions().nth(1).unwrap();
        let mut alone = scene.simulate(start(i), method).unwrap();
        alone.run(2).unwrap();
        let off = (end - alone.positions().nth(1).unwrap()).norm();
        assert!(end.x > 0.0 && off < 1e-6, "{i}: at {end:?}, {off:e} off");
    }
}

/// Springs of one type between other bodies in other lanes, more or fewer of them than in the first lane; alone each is
/// the same but for rounding.
#[test]
fn sweeps_over_numbers_of_springs() {
    let scene = |springs: usize| {
        let ends = [[0, 2], [1, 3], [0, 3]];
        Scene::points(4)
            .link(PlanarRod { length: 1.0 }, [[0, 1], [1, 2], [2, 3]])
            .pin(0, [0.0, 0.0])
            .with(Spring { stiffness: 1.0, length: 1.0 }.over(ends.into_iter().take(springs)))
    };
    let start = |_: usize| {
        let state = State::of([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]);
        state.with_momenta([[0.0, 0.0], [0.0, 0.3], [0.0, 0.2], [0.0, 1.0]])
    };
    for numbers in [[1, 3, 2], [3, 1, 2]] {
        let scenes: Vec<_> = (0..9).map(|i| scene(numbers[i % 3])).collect();
        check(&[sweep(&scenes, start, Taylor::new(10, 0.02))]);
    }
}

/// In any unit of length and time, at orders at which coefficients would not be numbers in units of 1.
#[test]
fn in_any_units() {
    for (length, h) in [(1e-10, 1e-15), (1e6, 1e13)] {
        let scene = Scene::points(2)
            .link(PlanarRod { length }, [[0, 1]])
            .pin(0, [0.0, 0.0])
            .with(PlanarGravity { g: 0.01 * length / (h * h) });
        let starts: Vec<_> = (0..9)
            .map(|i| {
                let (sin, cos) = (0.1 * f64::from(i)).sin_cos();
                State::of([[0.0, 0.0], [length * cos, length * sin]])
            })
            .collect();
        for method in [Taylor::new(30, h), Taylor::adaptive(30, h, 1e-15 * length)] {
            let mut ensemble = scene.ensemble(starts.iter().cloned(), method).unwrap();
            ensemble.run(20);
            let found = starts.iter().enumerate().map(|(i, start)| {
                let mut alone = scene.simulate(start.clone(), method).unwrap();
                alone.run(20).unwrap();
                let there = ensemble.state(i).positions().nth(1).unwrap();
                (there - alone.positions().nth(1).unwrap()).norm() / length
            });
            check(&[found.fold(0.0, larger)]); // also that some was made in lanes
        }
    }
}

/// A force on a pinned body moves nothing, also where it has no series.
#[test]
fn forces_without_a_series_on_pinned_bodies() {
    potential! {
        struct Tether { k, l }
        |q: [f64; 2]| k / 2 * (norm(q) - l)^2
    }
    let scene = Scene::points(3)
        .link(PlanarRod { length: 1.0 }, [[0, 1], [1, 2]])
        .pin(0, [0.0, 0.0])
        .with(Tether { k: 1.0, l: 0.5 });
    let (start, method) = (State::of([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), Taylor::new(12, 0.05));
    let mut ensemble = scene.ensemble(vec![start.clone(); 64], method).unwrap();
    ensemble.run(20); // later bodies come so near to the pin that all that differs grows
    check(&[off_alone(&ensemble, 7, &scene, &start, &method, 20)]);
}
