//! Flows of momenta on rigid bodies in lanes: as each trajectory alone but for rounding, and at the right temperature.

use crate::common::larger;
use crate::lanes_rigid::{Alike, Field, start, start_of_three};
use rattle::bodies::Count;
use rattle::composition::SUZUKI_1990_ORDER_4;
use rattle::effect::{Effects, Flow, Interval, Langevin, LinearDrag};
use rattle::ensemble::InstructionSet;
use rattle::method::Method;
use rattle::prelude::*;
use rattle::real::Real;

const HEAT: Langevin = Langevin { friction: 2.0, temperature: 0.5, seed: 7 };
const MOMENTS: [f64; 3] = [0.6, 0.8, 1.0];

/// A brake about the third axis that turns with time, differs by body, and knows attitudes.
#[derive(Debug, Clone)]
struct Brake(f64);

impl<const D: usize> Flow<D> for Brake {
    fn flow<T: Real>(&self, during: &Interval<'_, T, D>, changes: &mut [[T; D]]) {
        for (body, (change, p)) in changes.iter_mut().zip(during.momenta).enumerate() {
            let upright = during.at.positions[body][8];
            let lost = (-self.0 * during.h * (1.5 + during.at.time.sin()) / (1.0 + body as f64)).exp_m1();
            *change = [T::from_f64(0.0); D];
            change[2] = T::from_f64(lost) * upright * upright * p[2];
        }
    }
    fn changes_with_time(&self) -> bool {
        true
    }
}

/// How far lanes are from simulations after so many steps, in attitudes, momenta and work; some with numbers of their
/// own, some after steps.
fn apart<P: Precision, E: Effects<9>, N: Count, S: Method>(
    precision: P,
    scene: &Scene<Rigid, E, N, 9>,
    start: impl Fn(u32) -> State<9>,
    trajectories: u32,
    method: &S,
    steps: u64,
) -> f64 {
    let start = |i: u32| {
        let state = start(i).at_time(0.01 * f64::from(i));
        if i.is_multiple_of(2) {
            state.numbered(1000 + u64::from(i))
        } else {
            state.after_steps(5 * u64::from(i))
        }
    };
    let mut ensemble = scene.ensemble_in(precision, (0..trajectories).map(start), method.clone()).unwrap();
    let plan = ensemble.plan();
    assert_eq!(plan.in_lanes == ensemble.len(), InstructionSet::widest().fuses(), "{plan:?}");
    ensemble.run(steps / 2);
    ensemble.run(steps - steps / 2);
    let alone = (0..trajectories).step_by(5).map(|i| {
        let mut simulation = scene.simulate(ensemble_start(start, i), method.clone()).unwrap();
        simulation.run(steps).unwrap();
        let (own, state) = (simulation.state(), ensemble.state(i as usize));
        assert_eq!((own.time(), own.steps()), (state.time(), state.steps()));
        let pairs = own.positions().zip(state.positions()).chain(own.momenta().zip(state.momenta()));
        let off = pairs.map(|(a, b)| (a - b).amax()).fold(0.0, larger);
        larger(off, (simulation.work() - ensemble.work(i as usize)).abs())
    });
    alone.fold(0.0, larger)
}

/// The start of a trajectory with the number that an ensemble gives it.
fn ensemble_start(start: impl Fn(u32) -> State<9>, i: u32) -> State<9> {
    let state = start(i);
    if i.is_multiple_of(2) { state } else { state.numbered(i.into()) }
}

/// By RATTLE, a composition and BAOAB, in rows of 64 and of a few.
fn check<E: Effects<9>, N: Count>(
    name: &str,
    scene: &Scene<Rigid, E, N, 9>,
    start: impl Fn(u32) -> State<9> + Copy,
) {
    let found = [
        apart(Double, scene, start, 70, &Rattle::new(0.02), 51),
        apart(Compensated, scene, start, 7, &Rattle::new(0.05), 20),
        apart(Double, scene, start, 7, &Baoab::new(0.02), 51),
        apart(Compensated, scene, start, 70, &Composition::new(SUZUKI_1990_ORDER_4, 0.05), 20),
    ];
    println!("{name}: {found:?}");
    let fused = InstructionSet::widest().fuses();
    assert!(found.iter().all(|&off| off < 3e-14 && (off > 0.0) == fused), "{name}: {found:?}");
}

#[test]
fn flows_on_rigid_bodies_are_as_alone() {
    let one = |i| start(i, MOMENTS, 1.0);
    let top = Scene::rigid(Rigid::new(MOMENTS)).with(Field { weight: 1.0, pull: 0.5 });
    check("heat", &top.with(HEAT), one);
    check("drag", &top.with(LinearDrag::new(0.7)), one);
    check("a brake", &top.with(Brake(0.6)), one);
    check(
        "all of them, without a force",
        &Scene::rigid(Rigid::new(MOMENTS)).with(HEAT).with(Brake(0.6)),
        one,
    );
    let three = |i| start_of_three(i, MOMENTS, 1.0);
    let coupled = top.bodies(3).with(Alike { strength: 0.7 }.over([[0, 1], [1, 2]]));
    check("three bodies", &coupled.with(Brake(0.3)).with(HEAT), three);
}

/// The same bits as an ensemble of one scene, of heat and moments of each trajectory's own.
#[test]
fn a_sweep_of_flows_on_rigid_bodies() {
    let scene = |i: u32| {
        let t = f64::from(i);
        let heat = Langevin { friction: 1.0 + 0.1 * t, temperature: 0.1 + 0.02 * t, seed: u64::from(i % 3) };
        Scene::rigid(Rigid::new([0.6 + 0.01 * t, 0.8, 1.0])).with(heat).with(Brake(0.1 * t))
    };
    let scenes: Vec<_> = (0..67).map(scene).collect();
    let start = |i: u32| start(i, MOMENTS, 1.0).numbered(i.into());
    let each = scenes.iter().zip((0..67).map(start));
    let mut sweep = Ensemble::sweep(Double, each, Rattle::new(0.05)).unwrap();
    assert_eq!(sweep.plan().in_lanes > 0, InstructionSet::widest().fuses());
    sweep.run(40);
    for i in 0..67 {
        let mut own = scene(i).ensemble([start(i)], Rattle::new(0.05)).unwrap();
        own.run(40);
        assert_eq!(format!("{:?}", own.state(0)), format!("{:?}", sweep.state(i as usize)), "trajectory {i}");
    }
}

/// ⟨m²/J⟩ = T about each axis, to four deviations of a mean of independent numbers (4 √(2/n) T).
#[test]
fn heat_gives_rigid_bodies_its_temperature() {
    let (n, t) = (4000, HEAT.temperature);
    let scene = Scene::rigid(Rigid::new(MOMENTS)).with(Field { weight: 1.0, pull: 0.5 }).with(HEAT);
    let mut ensemble = scene.ensemble((0..n).map(|i| start(i, MOMENTS, 0.0)), Baoab::new(0.05)).unwrap();
    ensemble.run(100);
    let mut found = [0.0; 3];
    for m in ensemble.states().map(|state| state.momenta().next().unwrap()) {
        for (k, found) in found.iter_mut().enumerate() {
            *found += m[k] * m[k] / (MOMENTS[k] * f64::from(n));
        }
    }
    println!("{found:?}");
    let most = 4.0 * (2.0 / f64::from(n)).sqrt() * t;
    assert!(found.iter().all(|found| (found - t).abs() < most), "{found:?}");
}

/// Steps in parts have flows in parts, and book their work, as in a simulation.
#[test]
fn parts_of_steps() {
    let scene = Scene::rigid(Rigid::new(MOMENTS)).with(HEAT).with(Brake(0.3)).with(LinearDrag::new(0.1));
    let begin = |i: u32| start(i, MOMENTS, 6.0).numbered(i.into()).after_steps(i.into());
    let method = Rattle::new(0.5);
    let mut whole = scene.ensemble((0..20).map(begin), method).unwrap();
    whole.run(1);
    let failed = whole.failures().count();
    assert!(failed > 10, "{failed} of 20");
    let mut ensemble = scene.ensemble((0..20).map(begin), method).unwrap().retry(8);
    assert_eq!(ensemble.plan().in_lanes == 20, InstructionSet::widest().fuses());
    ensemble.run(3);
    for i in 0..20 {
        let mut alone = scene.simulate(begin(i), method).unwrap().retry(8);
        alone.run(3).unwrap();
        let (state, work) = (ensemble.state(i as usize), ensemble.work(i as usize));
        let off = (state.positions().next().unwrap() - alone.position()).amax();
        let work = (work - alone.work()).abs();
        assert!(off < 1e-11 && work < 1e-11, "{i}: {off:e}, {work:e}");
    }
}
