//! Trajectories in lanes whose steps are taken back go by themselves: as simulations that are checked, to rounding, and
//! judged as those are.

use crate::common::{PlanarGravity, SURFACE, Trough, billiard, bits, directions, larger};
use crate::lanes_linked::{chain, starts};
use crate::lanes_rigid::Field;
use crate::{lanes_phase, lanes_rigid};
use rattle::bodies::Count;
use rattle::composition::SUZUKI_1990_ORDER_4;
use rattle::effect::{DryFriction, Effects, Langevin, LinearDrag, MagneticField};
use rattle::ensemble::{InstructionSet, NotInLanes};
use rattle::error::{EffectMistake, RecordMistake};
use rattle::links::planar::Rod;
use rattle::method::Method;
use rattle::potentials::Gravity;
use rattle::prelude::*;
use rattle::scene::Hold;
use rattle::surfaces::{Plane, Sphere, Torus};
use rattle::{Error, Variable};

force! {
    /// Wind that turns with time, against which bodies drag.
    struct Wind { c }
    |q: [f64; 3], v: [f64; 3], t| [c * (cos(t) - v[0]), c * (sin(t) - v[1]) * (1 + q[2]^2), -c * v[2]]
}

/// Trajectories that all lead back are those of an ensemble without the check, to rounding, however a run is divided.
fn passes<C: Hold<D> + 'static, E: Effects<D>, N: Count, S: Method, const D: usize>(
    scene: &Scene<C, E, N, D>,
    starts: &[State<D>],
    method: S,
    tolerance: f64,
) {
    let make = || scene.ensemble(starts.iter().cloned(), method.clone()).unwrap();
    let check = || make().check_reversal(tolerance).unwrap();
    let (mut plain, mut checked, mut divided) = (make(), check(), check());
    assert_eq!(plain.plan().in_lanes == starts.len(), InstructionSet::widest().fuses(), "{:?}", plain.plan());
    assert_eq!((checked.plan().in_lanes, checked.plan().alone), (0, starts.len()));
    assert!(!InstructionSet::widest().fuses() || checked.plan().reason == Some(NotInLanes::TakenBack));
    plain.run(40);
    checked.run(40);
    [1, 22, 17].into_iter().for_each(|steps| divided.run(steps));
    let mut worst = 0.0_f64;
    for i in 0..starts.len() {
        assert_eq!(checked.failure(i), None, "{i} by {}", method.name());
        let (a, b) = (checked.state(i), plain.state(i));
        assert_eq!(bits(&divided.state(i)), bits(&a), "{i} by {}", method.name());
        assert_eq!((a.time(), a.steps()), (b.time(), b.steps()));
        let apart = a.positions().zip(b.positions()).chain(a.momenta().zip(b.momenta()));
        worst = apart.map(|(a, b)| (a - b).norm()).fold(worst, larger);
    }
    println!("{}: {worst:e} apart", method.name());
    assert!(worst < 1e-11, "{worst:e} by {}", method.name());
}

#[test]
fn what_leads_back_goes_on_as_without_the_check() {
    let billiards: Vec<_> = directions().take(70).map(billiard).collect();
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    passes(&scene, &billiards, Rattle::new(0.01), 1e-13);
    passes(&scene, &billiards[..1], Rattle::new(-0.01), 1e-13);
    passes(&scene, &billiards, Lobatto::<2>::new(0.01), 1e-12);

    // With flows, each trajectory at a time of its own.
    let ring = Scene::on(Torus { major: 1.2, minor: 0.5 }).with(Trough { g: 1.0 });
    let start = |i: u64| {
        let angle = 0.1 * i as f64;
        let state = State::at([1.7 * angle.cos(), 1.7 * angle.sin(), 0.0]);
        state.moving([-0.4 * angle.sin(), 0.4 * angle.cos(), 0.8]).at_time(0.3 * i as f64)
    };
    let around: Vec<_> = (0..67).map(start).collect();
    passes(&ring.with(MagneticField::new([0.7, -0.4, 1.5])), &around, Rattle::new(-0.02), 1e-13);
    passes(&ring.with(Wind { c: 0.5 }), &around, Rattle::new(0.02), 1e-13);

    let pendulum = Scene::points(3)
        .link(Rod { length: 1.0 }, [[0, 1], [1, 2]])
        .pin(0, [0.0, 0.0])
        .masses([1.0, 2.5, 0.3])
        .with(PlanarGravity { g: 1.0 });
    let hanging = starts(&pendulum, |lean| chain(2, lean));
    passes(&pendulum, &hanging, Rattle::new(0.01), 1e-13);
    passes(&pendulum, &hanging, Composition::new(SUZUKI_1990_ORDER_4, 0.02), 1e-13);

    let top = Scene::rigid(Rigid::new([0.6, 0.8, 1.0])).with(Field { weight: 1.0, pull: 0.3 });
    let turning: Vec<_> = (0..70).map(|i| lanes_rigid::start(i, [0.6, 0.8, 1.0], 1.0)).collect();
    passes(&top, &turning, Rattle::new(0.01), 1e-13);

    let charge = lanes_phase::charge(7);
    let moving: Vec<_> = (1..20).filter(|i| i % 10 != 0).map(|i| lanes_phase::start(&charge, i)).collect();
    passes(&charge, &moving, Rattle::new(0.05), 1e-12);
}

/// Balls that fall from the top of a sphere at different speeds, by steps of which some find another root.
fn falling() -> Vec<State<3>> {
    (0..150).map(|i| State::at([0.0, 0.0, 1.0]).moving([0.1 + 0.01 * f64::from(i), 0.03, 0.0])).collect()
}

#[test]
fn what_does_not_lead_back_fails_as_in_a_simulation() {
    let scene = Scene::on(Sphere { r: 1.0 }).with(Gravity { g: 1.0 });
    let starts = falling();
    let make = || scene.ensemble(starts.iter().cloned(), Rattle::new(0.7)).unwrap();
    let (mut checked, mut halving) =
        (make().check_reversal(1e-12).unwrap(), make().check_reversal(1e-12).unwrap().retry(5));
    let (mut irreversible, mut impossible, mut fine) = (0, 0, 0);
    for step in 1..=4 {
        checked.run(1);
        halving.run(1);
        for (i, start) in starts.iter().enumerate() {
            let mut alone =
                scene.simulate(start.clone(), Rattle::new(0.7)).unwrap().check_reversal(1e-12).unwrap();
            let error = alone.run(step).err();
            match (&error, checked.failure(i)) {
                (None, None) => fine += 1,
                (Some(Error::NotReversed { step: a, .. }), Some(Error::NotReversed { step: b, .. })) => {
                    assert_eq!(a, b);
                    irreversible += 1;
                }
                (Some(Error::Step { step: a, .. }), Some(Error::Step { step: b, .. })) => {
                    assert_eq!(a, b);
                    impossible += 1;
                }
                (a, b) => panic!("{i}: {a:?} alone, {b:?} in lanes"),
            }
            let off = |ensemble: &Ensemble<3>, simulation: &State<3>| {
                let state = ensemble.state(i);
                let places = state.positions().zip(simulation.positions());
                places.map(|(a, b)| (a - b).norm()).fold(0.0, larger)
            };
            assert!(off(&checked, &alone.state()) < 1e-11, "{i}");
            let mut alone = scene.simulate(start.clone(), Rattle::new(0.7)).unwrap();
            alone = alone.check_reversal(1e-12).unwrap().retry(5);
            assert_eq!(alone.run(step).err().is_some(), halving.failure(i).is_some(), "{i} in parts");
            assert!(off(&halving, &alone.state()) < 1e-11, "{i} in parts");
        }
    }
    println!("{fine} steps lead back, {irreversible} do not, {impossible} could not be taken");
    assert!(fine > 100 && irreversible > 20, "{fine}, {irreversible}");
}

#[test]
fn what_cannot_be_checked_is_refused() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let starts = || directions().take(3).map(billiard);
    for tolerance in [-1.0, 0.0, f64::INFINITY, f64::NAN] {
        let error = scene.ensemble(starts(), Rattle::new(0.01)).unwrap().check_reversal(tolerance);
        assert!(matches!(error.err(), Some(Error::Tolerance(_))), "{tolerance}");
    }
    for error in [
        scene.ensemble(starts(), SymplecticEuler::new(0.01)).unwrap().check_reversal(1e-13),
        scene.ensemble(starts(), Variable::of(Rattle::new(0.01), 0.3)).unwrap().check_reversal(1e-13),
    ] {
        assert!(matches!(error.err(), Some(Error::NeedsSymmetricMethod { .. })));
    }
    let heat = Langevin { friction: 2.0, temperature: 0.5, seed: 7 };
    let heated = scene.with(heat).ensemble(starts(), Rattle::new(0.01)).unwrap().check_reversal(1e-13);
    let refused = |error: &Error| matches!(error, Error::Effect { mistake: EffectMistake::NoWayBack, .. });
    assert!(heated.err().is_some_and(|error| refused(&error)));

    // Trajectories that are simulations: friction loses what it does not give back.
    let rough = scene.with(DryFriction { coefficient: 0.5 });
    let mut rough = rough.ensemble(starts(), Rattle::new(0.01)).unwrap().check_reversal(1e-13).unwrap();
    assert_eq!(rough.plan().alone, 3);
    rough.run(200);
    let failures = rough.failures().map(|(_, error)| matches!(error, Error::NotReversed { .. }));
    assert_eq!(failures.collect::<Vec<_>>(), [true; 3]);
}

/// The check is a part of a run: a checkpoint is not taken up without it, or with another tolerance.
#[test]
fn checkpoints_know_the_check() {
    let scene = Scene::on(Sphere { r: 1.0 }).with(Gravity { g: 1.0 });
    let make = || scene.ensemble(falling(), Rattle::new(0.7)).unwrap();
    let mut checked = make().check_reversal(1e-12).unwrap();
    checked.run(2);
    let record = checked.checkpoint();
    let mut again = make().check_reversal(1e-12).unwrap();
    again.resume(&record).unwrap();
    checked.run(2);
    again.run(2);
    for i in 0..150 {
        assert_eq!(bits(&again.state(i)), bits(&checked.state(i)));
        assert_eq!(again.failure(i).map(ToString::to_string), checked.failure(i).map(ToString::to_string));
    }
    let refused = |other: &mut Ensemble<3>, record| {
        let error = other.resume(record).unwrap_err();
        let Error::Record(RecordMistake::Another { part, .. }) = &error else { panic!("{error}") };
        assert_eq!(part, "options", "{error}");
    };
    refused(&mut make(), &record);
    refused(&mut make().check_reversal(1e-11).unwrap(), &record);
    refused(&mut checked, &make().checkpoint());
}

/// What a hybrid Monte Carlo method needs: a proposal that is taken leads back to where it began, and is taken there
/// too, however long steps are. Without the check lanes take steps whose way back they refuse, with it they take what
/// simulations take.
#[test]
fn what_is_taken_is_taken_on_the_way_back() {
    let scene = Scene::on(Torus { major: 1.0, minor: 0.5 });
    let starts: Vec<_> = (0..2000)
        .map(|i| {
            let (u, v) = (0.7 * f64::from(i), 1.9 * f64::from(i));
            let place = [(1.0 + 0.5 * v.cos()) * u.cos(), (1.0 + 0.5 * v.cos()) * u.sin(), 0.5 * v.sin()];
            scene.maxwell(&State::at(place), 1.0, i as u64).unwrap()
        })
        .collect();
    let proposals = |starts: &[State<3>], checks: bool| {
        let mut ensemble = scene.ensemble(starts.iter().cloned(), Rattle::new(0.4)).unwrap();
        if checks {
            ensemble = ensemble.check_reversal(1e-10).unwrap();
        }
        ensemble.run(5);
        let taken = (0..starts.len()).filter(|&i| ensemble.failure(i).is_none());
        taken.map(|i| (i, ensemble.state(i))).collect::<Vec<_>>()
    };
    let lost = |checks: bool| {
        let taken = proposals(&starts, checks);
        let turned: Vec<_> = taken
            .iter()
            .map(|(_, state)| State::of(state.positions()).with_momenta(state.momenta().map(|p| -p)))
            .collect();
        let back = proposals(&turned, checks);
        for (i, state) in &back {
            let start = &starts[taken[*i].0];
            let off = (state.positions().next().unwrap() - start.positions().next().unwrap()).norm();
            assert!(!checks || off < 1e-7, "{off:e}");
        }
        println!("{} taken, {} on the way back, with the check: {checks}", taken.len(), back.len());
        taken.len() - back.len()
    };
    assert!(lost(false) > 5);
    assert_eq!(lost(true), 0);
    let taken: Vec<_> = proposals(&starts, true).into_iter().map(|(i, _)| i).collect();
    let alone = starts.iter().enumerate().filter(|(_, start)| {
        let simulation = scene.simulate((*start).clone(), Rattle::new(0.4));
        simulation.is_ok_and(|run| run.check_reversal(1e-10).unwrap().run(5).is_ok())
    });
    assert_eq!(alone.map(|(i, _)| i).collect::<Vec<_>>(), taken);
}

/// In single precision flows of lanes that go by themselves are as exact as its numbers, and no more is asked of them.
#[test]
fn flows_in_single_precision_are_taken_back() {
    let scene = Scene::on(Torus { major: 1.0, minor: 0.4 })
        .with(Gravity { g: 1.0 })
        .with(MagneticField::new([0.7, -0.4, 1.5]))
        .with(LinearDrag::new(0.2));
    let starts =
        || (0..32).map(|i| State::at([1.4, 0.0, 0.0]).moving([0.0, (i as f64).cos(), (i as f64).sin()]));
    let by = Rattle::new(0.01);
    let mut single = scene.ensemble_in(Single, starts(), by).unwrap().check_reversal(1e-4).unwrap();
    let mut double = scene.ensemble_in(Double, starts(), by).unwrap();
    single.run(100);
    double.run(100);
    assert_eq!(single.failures().count(), 0, "{:?}", single.failures().next());
    for (state, exact) in single.states().zip(double.states()) {
        let off = (state.positions().next().unwrap() - exact.positions().next().unwrap()).norm();
        assert!(off > 0.0 && off < 1e-4, "{off:e}");
    }
}

/// The work of flows is summed in double precision there too: on a slope, where much is lost at first, and little then.
#[test]
fn work_in_single_precision_keeps_its_digits() {
    let slope = Plane { a: 0.6, b: 0.0, c: 0.8, d: 0.0 };
    let scene = Scene::on(slope).with(LinearDrag::new(1.0)).with(Gravity { g: 1.0 });
    let starts = || [60.0, -30.0].map(|v| State::at([0.0; 3]).moving([0.8 * v, 0.0, -0.6 * v]));
    let mut lanes = scene.ensemble_in(Single, starts(), Rattle::new(0.01)).unwrap();
    let mut alone =
        scene.ensemble_in(Single, starts(), Rattle::new(0.01)).unwrap().check_reversal(1e-4).unwrap();
    lanes.run(5000);
    alone.run(5000);
    assert_eq!(alone.failures().count(), 0);
    for i in 0..2 {
        let (work, there) = (lanes.work(i), alone.work(i));
        assert!((work - there).abs() < 2e-5 * work.abs() && work < -10.0, "{work} {there}");
    }
}
