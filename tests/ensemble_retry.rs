//! In ensembles too, a step that cannot be taken is taken in parts, if that is asked for; by its trajectory alone.

use crate::common::*;
use rattle::Error;
use rattle::bodies::One;
use rattle::composition::SUZUKI_1990_ORDER_4;
use rattle::ensemble::{Compensated, Double, Ensemble, InstructionSet, Precision, Single};
use rattle::prelude::*;
use rattle::system::System;

/// How far from each other a trajectory in lanes and its simulation are.
fn gap<Y: System<f64, 3, Count = One>, S: Method>(
    ensemble: &Ensemble<3>,
    alone: &Simulation<Y, S, 3>,
) -> f64 {
    let state = ensemble.state(0);
    let (q, p) = (state.positions().next().unwrap(), state.momenta().next().unwrap());
    assert_eq!(state.time(), alone.time());
    distance(q, alone.position()).max(distance(p, alone.momentum()))
}

/// Of the trajectories that fail in lanes and as simulations in the same step of the first 40: by which factor that
/// step, in parts, leads both farther apart than they were, or than `rounding`; and how many there were.
fn off<P: Precision, S: Method>(precision: P, method: &S, rounding: f64) -> (f64, usize) {
    let (mut worst, mut number) = (0.0_f64, 0);
    for i in 0..60 {
        let start = || start(4 * i + 1);
        let mut plain = scene().ensemble_in(precision, [start()], method.clone()).unwrap();
        plain.run(40);
        let failure = scene().simulate(start(), method.clone()).unwrap().run(40).err();
        let (Some(&Error::Step { step, .. }), Some(Error::Step { step: other, .. })) =
            (plain.failure(0), failure)
        else {
            continue;
        };
        if step != other {
            continue; // what is too long is a little longer in lanes
        }
        let mut ensemble = scene().ensemble_in(precision, [start()], method.clone()).unwrap().retry(5);
        let mut alone = scene().simulate(start(), method.clone()).unwrap().retry(5);
        ensemble.run(step - 1);
        alone.run(step - 1).unwrap();
        let before = gap(&ensemble, &alone);
        ensemble.run(1);
        let taken = alone.run(1).is_ok();
        assert_eq!(ensemble.failure(0).is_none(), taken);
        if !taken {
            continue;
        }
        worst = worst.max(gap(&ensemble, &alone) / before.max(rounding));
        number += 1;
    }
    (worst, number)
}

/// In a step near the longest that can be taken the normal turns by half a right angle and more, and neighbours part by
/// a factor of some 10.
#[test]
fn lanes_are_simulations_that_retry() {
    let rattle = Rattle::new(0.015);
    for (name, (factor, number)) in [
        ("double", off(Double, &rattle, 1e-15)),
        ("compensated", off(Compensated, &rattle, 1e-15)),
        ("composition", off(Double, &Composition::new(SUZUKI_1990_ORDER_4, 0.02), 1e-15)),
        ("position Verlet", off(Double, &PositionVerlet::new(0.03), 1e-15)),
        ("backwards", off(Double, &Rattle::new(-0.015), 1e-15)),
        ("single", off(Single, &rattle, 5e-7)),
        ("Lobatto", off(Double, &Lobatto::<2>::new(0.015), 1e-15)),
    ] {
        println!("{name}: by {factor}, {number} trajectories");
        assert!(number > 10 && factor < 30.0, "{name}: {factor}, {number}");
    }
    // By themselves they are simulations, bit for bit.
    let composed = Composition::of(SUZUKI_1990_ORDER_4, Lobatto::<2>::new(0.05));
    let (alone, number) = off(Double, &composed, 1e-15);
    assert!(alone == 0.0 && number > 10, "{alone:e}, {number}");
}

/// Fast ones whose steps are divided, ones that end all the same, and calm ones, in turn.
fn start(i: u32) -> State<3> {
    let speed = [0.7, 5.0 + 0.02 * f64::from(i), 0.5, 40.0][i as usize % 4];
    let angle = 0.37 * f64::from(i);
    State::at([0.0, 0.0, SURFACE.r]).moving([speed * angle.cos(), speed * angle.sin(), 0.0])
}

fn scene() -> Scene<Lemniscate, impl rattle::effect::Effects<3> + Copy, One, 3> {
    Scene::on(SURFACE).with(Gravity { g: 1.0 })
}

fn all(set: InstructionSet) -> Ensemble<3> {
    Ensemble::of(Double, &scene(), (0..100).map(start), Rattle::new(0.01), set).unwrap().retry(3)
}

fn bits_of(ensemble: &Ensemble<3>) -> Vec<String> {
    ensemble.states().map(|state| bits(&state)).collect()
}

#[test]
#[cfg(long)]
fn parts_are_the_same_everywhere_and_touch_no_one_else() {
    let mut ensemble = all(InstructionSet::widest());
    ensemble.run(1000);
    let expected = bits_of(&ensemble);
    let mut plain = scene().ensemble((0..100).map(start), Rattle::new(0.01)).unwrap();
    plain.run(1000);
    let (mut calm, mut divided, mut ended) = (0, 0, 0);
    for i in 0..100 {
        match (plain.failure(i), ensemble.failure(i)) {
            (None, None) => {
                calm += 1;
                assert_eq!(bits(&plain.state(i)), expected[i], "trajectory {i} was touched");
            }
            (Some(_), None) => divided += 1,
            (Some(Error::Step { .. }), Some(Error::Retried { halvings: 3, .. })) => ended += 1,
            other => panic!("trajectory {i}: {other:?}"),
        }
    }
    assert!(calm > 40 && divided > 10 && ended > 10, "{calm} {divided} {ended}");

    let fusing = [InstructionSet::Portable, InstructionSet::Avx2, InstructionSet::Avx512];
    for set in fusing.into_iter().filter(|set| set.is_present() && set.fuses()) {
        let mut other = all(set);
        for steps in [1, 400, 99, 500] {
            other.run(steps);
        }
        assert_eq!(bits_of(&other), expected, "{set}, in parts");
    }
    for i in (0..100).step_by(23) {
        let mut alone = scene().ensemble([start(i as u32)], Rattle::new(0.01)).unwrap().retry(3);
        alone.run(1000);
        assert_eq!(bits(&alone.state(0)), expected[i], "trajectory {i} alone");
        let of = |ensemble: &Ensemble<3>, i| ensemble.failure(i).map(ToString::to_string);
        assert_eq!(of(&alone, 0), of(&ensemble, i));
    }
}

/// In a sweep lanes that stand in for others obey what those they are copies of do, and are given back.
#[test]
#[cfg(long)]
fn parts_obey_the_scene_of_their_trajectory() {
    let scenes: Vec<_> = (0..70)
        .map(|i| {
            let r = SURFACE.r * (1.0 + 1e-3 * f64::from(i));
            let start = start(i);
            let momentum: [f64; 3] = start.momenta().next().unwrap().into();
            let scene = Scene::on(Lemniscate { a: 1.0, r }).with(Gravity { g: 0.5 + 0.01 * f64::from(i) });
            (scene, State::at([0.0, 0.0, r]).moving(momentum))
        })
        .collect();
    let trajectories = || scenes.iter().map(|(scene, start)| (scene, start.clone()));
    let mut sweep = Ensemble::sweep(Double, trajectories(), Rattle::new(0.01)).unwrap().retry(3);
    sweep.run(700);
    let mut plain = Ensemble::sweep(Double, trajectories(), Rattle::new(0.01)).unwrap();
    plain.run(700);
    let [plain, ended] = [&plain, &sweep].map(|ensemble| ensemble.failures().count());
    assert!(plain > ended + 5 && ended > 5, "{plain} {ended}");
    for (i, (scene, start)) in scenes.iter().enumerate() {
        let mut own = scene.ensemble([start.clone()], Rattle::new(0.01)).unwrap().retry(3);
        own.run(700);
        assert_eq!(bits(&own.state(0)), bits(&sweep.state(i)), "trajectory {i}");
        assert_eq!(own.failure(0).is_some(), sweep.failure(i).is_some());
    }
}

/// All at once, so that nobody stands in for anybody.
#[test]
fn all_may_be_divided() {
    let scene = Scene::on(Sphere { r: 1.0 }).with(Gravity { g: 1.0 });
    let falling = State::at([0.0, 0.0, 1.0]).moving([0.2, 0.0, 0.0]);
    let mut alone = scene.simulate(falling.clone(), Rattle::new(0.7)).unwrap();
    let Err(Error::Step { step, .. }) = alone.run(40) else { panic!("nothing failed") };
    let mut alone = alone.retry(4);
    alone.run(1).unwrap();
    for number in [1, 64, 65] {
        let mut ensemble = scene.ensemble(vec![falling.clone(); number], Rattle::new(0.7)).unwrap();
        ensemble.run(step - 1);
        assert_eq!(ensemble.failures().count(), 0);
        let mut ensemble = ensemble.retry(4);
        ensemble.run(1);
        assert_eq!((ensemble.failures().count(), ensemble.steps()), (0, step));
        for state in ensemble.states() {
            let q = state.positions().next().unwrap();
            assert!(distance(q, alone.position()) < 1e-14, "{q:?} {:?}", alone.position());
            assert_eq!(state.time(), alone.time());
        }
    }
}

#[test]
fn what_cannot_be_taken_in_parts_either_rests_where_it_was() {
    let scene = Scene::on(Sphere { r: 1.0 });
    let starts = || [1.0, 100.0].map(|v| State::at([1.0, 0.0, 0.0]).moving([0.0, v, 0.0]).at_time(3.0));
    let mut ensemble = scene.ensemble(starts(), Rattle::new(0.7)).unwrap().retry(3);
    let before = bits(&ensemble.state(1));
    ensemble.run(10);
    assert_eq!(bits(&ensemble.state(1)), before);
    let mut alone = scene.simulate(starts()[1].clone(), Rattle::new(0.7)).unwrap().retry(3);
    let error = alone.run(10).unwrap_err();
    assert!(matches!(error, Error::Retried { step: 1, halvings: 3, time: 3.0, .. }), "{error}");
    assert_eq!(ensemble.failure(1).unwrap().to_string(), error.to_string());
    assert!(ensemble.failure(0).is_none());
}

/// What passes by.
struct All(Vec<String>);

impl<const D: usize> Observer<D> for All {
    fn see(&mut self, _: &Sight<'_, D>, now: &Sight<'_, D>) {
        self.0.push(format!("{} {} {:?} {:?}", now.trajectory, now.time, now.positions, now.momenta));
    }
    fn join(&mut self, next: Self) {
        self.0.extend(next.0);
    }
}

#[test]
#[cfg(long)]
fn onlookers_see_whole_steps() {
    let of = || scene().ensemble((0..50).map(start), Rattle::new(0.01)).unwrap().retry(3);
    let seen = of().observe(1200, 3, || All(vec![])).0;
    let (mut slowly, mut expected) = (of(), vec![]);
    for _ in 0..400 {
        slowly.run(3);
        let going = (0..50).filter(|&i| slowly.failure(i).is_none()).map(|i| (i, slowly.state(i)));
        expected.extend(going.map(|(i, state)| {
            let (q, p) = (state.positions().collect::<Vec<_>>(), state.momenta().collect::<Vec<_>>());
            format!("{i} {} {q:?} {p:?}", state.time())
        }));
    }
    assert_eq!(seen.len(), expected.len());
    assert!(seen == expected);
}
