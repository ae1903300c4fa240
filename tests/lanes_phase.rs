//! Trajectories in phase space in lanes: as each alone but for rounding, whatever the constraints, Hamiltonians and
//! methods.

use crate::common::larger;
use crate::lanes_linked::{Told, off_alone};
use rattle::bodies::{Count, One};
use rattle::composition::SUZUKI_1990_ORDER_4;
use rattle::ensemble::InstructionSet;
use rattle::error::{PhaseFailure, StepFailure};
use rattle::method::Method;
use rattle::phase::PhaseSpace;
use rattle::prelude::*;
use rattle::scene::Hold;

phase_constraint! {
    /// The three-sphere, whose fibres are those of Hopf.
    pub(crate) struct Hopf { r }
    |q: [f64; 2], p: [f64; 2]| dot(q, q) + dot(p, p) - r^2
}
phase_constraint! {
    /// A sphere in six dimensions and an angular momentum: they commute.
    struct Turning { l }
    |q: [f64; 3], p: [f64; 3]| [dot(q, q) + dot(p, p) - 1, q[0] * p[1] - q[1] * p[0] - l]
}
phase_constraint! {
    /// Not quadratic, so that its fibres have no formula.
    struct Wavy {}
    |q: [f64; 2], p: [f64; 2]| q[0]^2 + q[1]^4 + exp(p[0]) + p[1]^2 * (2 + sin(q[0])) - 3
}
hamiltonian! {
    /// A charge in a magnetic field, that falls: not separable where b is not 0.
    pub(crate) struct Charge { b, g }
    |q: [f64; 2], p: [f64; 2]| ((p[0] + b * q[1])^2 + (p[1] - b * q[0])^2) / 2 + g * q[1]
}
hamiltonian! {
    /// Without symmetry.
    struct Uneven { g }
    |q: [f64; 3], p: [f64; 3]| (p[0]^2 + 2 * p[1]^2 + p[2]^2 / 2) / 2 + g * q[2] + q[0]^2 * q[1] + q[2] * p[0] / 4
}

pub(crate) type OnSphere = Scene<PhaseSpace<Hopf, Charge, 1>, (), One, 2>;

/// A charge on a sphere; it is another one for each i, but for those of numbers that 10 divides.
pub(crate) fn charge(i: usize) -> OnSphere {
    let share = if wild(i) { 0.0 } else { (0.618 * i as f64).fract() };
    Scene::in_phase_space(Hopf { r: 1.0 + 0.1 * share }, Charge { b: 0.4 * share, g: 0.3 })
}

/// A start near start B of the references; those of numbers that 10 divides come to where N vanishes.
pub(crate) fn start(scene: &OnSphere, i: usize) -> State<2> {
    let e = 1.0 + 3e-3 * i as f64;
    let place = if wild(i) {
        let (q, s) = ([0.3_f64, 0.4], 1.040_765_8_f64);
        let p = [1.0_f64.cos(), 1.0_f64.sin()].map(|x| 0.75_f64.sqrt() * x);
        let turned = [0, 1].map(|i| q[i] * s.cos() + p[i] * s.sin());
        State::at(turned).moving([0, 1].map(|i| p[i] * s.cos() - q[i] * s.sin()))
    } else {
        State::at([-0.55 / e, -0.83 * e]).moving([0.03, 0.02])
    };
    scene.project(&place).unwrap()
}
fn wild(i: usize) -> bool {
    i.is_multiple_of(10)
}

/// Whether all is rounding, and something is: who goes alone is off by nothing.
///
/// A step rounds four or six coordinates near 1 and what it solves for, some 1e-16; for as short as this is these
/// roundings add up, and nothing makes them larger.
fn check(what: &str, found: f64) {
    println!("{what}: {found:e}");
    let fused = InstructionSet::widest().fuses(); // else all go alone, and nothing differs
    assert!(found < 1e-14 && (found > 0.0) == fused, "{what}: {found:e}");
}

/// How far places and momenta of trajectories are off simulations, each of its scene.
fn off<C: Hold<D>, N: Count, S: Method, const D: usize>(
    ensemble: &mut Ensemble<D>,
    scene: impl Fn(usize) -> Scene<C, (), N, D>,
    starts: &[State<D>],
    method: &S,
    steps: u64,
) -> f64 {
    assert_eq!(ensemble.plan().in_lanes > 0, InstructionSet::widest().fuses());
    ensemble.run(steps);
    let each = starts.iter().enumerate();
    each.map(|(i, start)| off_alone(ensemble, i, &scene(i), start, method, steps)).fold(0.0, larger)
}

/// One equation, more than a row of trajectories, with several stages as well; a single one; bodies by themselves.
#[test]
fn one_equation() {
    let (scene, method) = (charge(7), Rattle::new(0.05));
    let starts: Vec<_> = (1..20).filter(|&i| !wild(i)).map(|i| start(&scene, i)).collect();
    let mut ensemble = scene.ensemble(starts.iter().cloned(), method).unwrap();
    check("equal steps", off(&mut ensemble, |_| scene, &starts, &method, 30));
    let mut single = scene.ensemble(starts[..1].iter().cloned(), method).unwrap();
    single.run(30);
    assert_eq!(single.state(0), ensemble.state(0), "a single one");
    let method = Composition::new(SUZUKI_1990_ORDER_4, -0.1);
    let mut stages = scene.ensemble(starts.iter().cloned(), method).unwrap();
    check("stages, back in time", off(&mut stages, |_| scene, &starts, &method, 5));

    let wavy = Scene::in_phase_space(Wavy {}, Charge { b: 0.0, g: 0.3 });
    let start = |i: u32| {
        let e = 1.0 + 0.01 * f64::from(i);
        wavy.project(&State::at([0.96 * e, -0.81]).moving([0.42, 0.21 / e])).unwrap()
    };
    let (starts, method) = ((0..5).map(start).collect::<Vec<_>>(), Rattle::new(0.02));
    let mut ensemble = wavy.ensemble(starts.iter().cloned(), method).unwrap();
    check("not quadratic", off(&mut ensemble, |_| wavy, &starts, &method, 30));
}

/// Constraints hold, too, to a few roundings of six coordinates with slopes of up to 2.
#[test]
fn two_equations() {
    let scene = Scene::in_phase_space(Turning { l: 0.2 }, Uneven { g: 0.3 });
    let start = |i: u32| {
        let e = 1.0 + 2e-3 * f64::from(i);
        scene.project(&State::at([0.5 * e, 0.1 * e, 0.4 * e]).moving([0.1 / e, 0.6 / e, -0.3 / e])).ok()
    };
    let (starts, method) =
        ((0..9).filter_map(start).collect::<Vec<_>>(), Composition::new(SUZUKI_1990_ORDER_4, 0.05));
    assert!(starts.len() > 5);
    let mut ensemble = scene.ensemble(starts.iter().cloned(), method).unwrap();
    check("two equations", off(&mut ensemble, |_| scene, &starts, &method, 10));
    for i in 0..starts.len() {
        let simulation = scene.simulate(ensemble.state(i), method).unwrap();
        let [g, hidden] = [simulation.constraint_residual(), simulation.cotangent_residual()];
        assert!(g < 2e-15 && hidden < 4e-15, "{i}: {g:e}, {hidden:e}");
    }
}

/// Two bodies in one scene move as each alone, bit for bit.
#[test]
fn bodies_do_not_see_each_other() {
    let (scene, method) = (charge(7), Rattle::new(0.05));
    let both = |i: usize| {
        let [one, other] = [start(&scene, i), start(&scene, i + 2)];
        let places = [&one, &other].map(|state| state.positions().next().unwrap());
        State::of(places).with_momenta([&one, &other].map(|state| state.momenta().next().unwrap()))
    };
    let two = scene.bodies(2);
    let starts = [both(1), both(2)];
    let mut pairs = two.ensemble(starts.iter().cloned(), method).unwrap();
    check("two bodies", off(&mut pairs, |_| two, &starts, &method, 20));
    let mut alone = scene.ensemble((1..5).map(|i| start(&scene, i)), method).unwrap();
    alone.run(20);
    for (i, (pair, body)) in [(0, 0), (1, 0), (0, 1), (1, 1)].into_iter().enumerate() {
        let (state, own) = (pairs.state(pair), alone.state(i));
        assert_eq!(state.positions().nth(body), own.positions().next());
        assert_eq!(state.momenta().nth(body), own.momenta().next());
    }
}

/// A sweep, with trajectories that come to where N vanishes: they end as simulations do, after as many steps, and the
/// others go on. Bits depend on no neighbour, no thread, no instruction set that fuses, no division of the run, and not
/// on checkpoints.
#[test]
fn the_same_bits_everywhere() {
    let (method, steps) = (Rattle::new(0.1), 30);
    let scenes: Vec<_> = (0..20).map(charge).collect();
    let of = |numbers: &[usize]| {
        let trajectories = numbers.iter().map(|&i| (&scenes[i], start(&scenes[i], i)));
        Ensemble::sweep(Double, trajectories, method).unwrap()
    };
    let bits = |ensemble: &Ensemble<2>| {
        let each = (0..ensemble.len()).map(|i| (ensemble.state(i), ensemble.failure(i).is_some()));
        each.map(|now| format!("{now:?}")).collect::<Vec<_>>()
    };
    let all: Vec<_> = (0..20).collect();
    let mut first = of(&all);
    first.run(steps);
    let expected = bits(&first);
    for (i, scene) in scenes.iter().enumerate() {
        let mut simulation = scene.simulate(start(scene, i), method).unwrap();
        let end = simulation.run(steps).err();
        let (state, why) = (first.state(i), first.failure(i));
        assert_eq!((state.time(), why.is_some()), (simulation.time(), wild(i)), "{i}: {why:?}, {end:?}");
        let kind = |error: &rattle::Error| match error {
            rattle::Error::Step { step, cause: StepFailure::Phase(cause), .. } => {
                (*step, std::mem::discriminant::<PhaseFailure>(cause))
            }
            other => panic!("{other}"),
        };
        assert_eq!(why.map(kind), end.as_ref().map(kind), "{i}");
        let off = (state.positions().next().unwrap() - simulation.position()).amax();
        assert!(off < if wild(i) { 1e-9 } else { 1e-14 }, "{i}: {off:e}"); // near N = 0 rounding grows
    }
    let mut parts = of(&all);
    for part in [1, 22, steps - 23] {
        parts.run(part);
        let (record, mut again) = (parts.checkpoint(), of(&all));
        again.resume(&record).unwrap();
        parts = again;
    }
    assert_eq!(bits(&parts), expected, "in parts");
    let some: Vec<_> = all.iter().copied().filter(|i| i % 3 == 0).collect();
    let mut others = of(&some);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    pool.install(|| others.run(steps));
    let expected_others: Vec<_> = some.iter().map(|&i| expected[i].clone()).collect();
    assert_eq!(bits(&others), expected_others, "others beside them");

    let number = 3; // its scene is that of all
    let ensemble = |set| {
        let starts = (0..4).map(|i| start(&scenes[number], number + i));
        let mut ensemble = Ensemble::of(Compensated, &scenes[number], starts, method, set).unwrap();
        ensemble.run(steps);
        bits(&ensemble)
    };
    let widest = InstructionSet::widest();
    let wide = ensemble(widest);
    assert_eq!(wide[0], expected[number], "an ensemble is a sweep");
    for set in [InstructionSet::Avx2, InstructionSet::Avx512] {
        if set.is_present() && widest.fuses() {
            assert_eq!(ensemble(set), wide, "{set}");
        }
    }
}

/// Long steps are divided where they fail, as in a simulation.
#[test]
fn steps_are_divided() {
    let (scene, method) = (charge(7), Rattle::new(0.6));
    let start = |i: u32| {
        let x = |times: u32| 0.7 * f64::from(times * i).sin();
        scene.project(&State::at([x(2), x(3)]).moving([x(5), x(7)])).ok()
    };
    let starts: Vec<_> =
        (1..17).filter_map(start).filter(|start| scene.simulate(start.clone(), method).is_ok()).collect();
    let failed = [0, 2].map(|halvings| {
        let mut ensemble = scene.ensemble(starts.iter().cloned(), method).unwrap().retry(halvings);
        ensemble.run(1);
        for (i, start) in starts.iter().enumerate() {
            let mut simulation = scene.simulate(start.clone(), method).unwrap().retry(halvings);
            let end = simulation.run(1).err();
            let (state, why) = (ensemble.state(i), ensemble.failure(i));
            assert_eq!((state.time(), why.is_some()), (simulation.time(), end.is_some()), "{i}");
            let off = (state.positions().next().unwrap() - simulation.position()).amax();
            assert!(off < 1e-12, "{i}: {off:e}");
        }
        ensemble.failures().count()
    });
    println!("{failed:?}");
    assert!(failed[1] < failed[0], "{failed:?}");
}

/// What a sight tells in lanes, it tells of simulations.
#[test]
fn sights_tell_the_same() {
    let (scene, method) = (charge(3), Rattle::new(0.05));
    let starts: Vec<_> = (3..5).map(|i| start(&scene, i)).collect();
    let mut ensemble = scene.ensemble(starts.iter().cloned(), method).unwrap();
    let seen = ensemble.observe(30, 10, || Each::of(Told::default));
    for (i, start) in starts.iter().enumerate() {
        let off = seen.get(i).unwrap().off_alone(&scene, start, &method);
        assert!(off < 1e-13, "{i}: {off:e}");
    }
}
