//! Brownian motion of linked and of rigid bodies in lanes: as each trajectory alone but for rounding.

use crate::common::larger;
use crate::lanes_brownian::{Ending, Unstable, ends_alike, kept_where_forces_grow, words};
use crate::lanes_rigid::{Field, start as start_of_top};
use rattle::Error;
use rattle::bodies::Many;
use rattle::effect::Effects;
use rattle::ensemble::InstructionSet;
use rattle::error::{RigidFailure, StepFailure};
use rattle::links::Rod;
use rattle::links::planar::Rod as PlanarRod;
use rattle::nalgebra::{Matrix3, Vector3};
use rattle::network::Network;
use rattle::potentials::planar::Gravity as PlanarGravity;
use rattle::prelude::*;
use rattle::rigid::Rigid;

const MOMENTS: [f64; 3] = [0.6, 0.8, 1.0];

fn method(h: f64) -> Brownian {
    Brownian::new(1.5, 0.4, 9, h)
}

/// A chain of beads of different masses, by its number of links.
fn chain(links: usize) -> Scene<Network<3>, impl Effects<3> + Clone + 'static, Many, 3> {
    let masses: Vec<_> = (0..=links).map(|i| 1.0 + 0.3 * i as f64).collect();
    Scene::points(links + 1).link(Rod { length: 1.0 }, (0..links).map(|i| [i, i + 1])).masses(masses)
}

fn pendulum(length: f64, mass: f64) -> Scene<Network<2>, impl Effects<2> + Clone + 'static, Many, 2> {
    Scene::points(3)
        .link(PlanarRod { length }, [[0, 1], [1, 2]])
        .pin(0, [0.0, 0.0])
        .masses([1.0, mass, 0.5])
        .with(PlanarGravity { g: 1.0 })
}

/// A zigzag of so many bodies, with rods of this length, moving anyhow.
fn zigzag<const D: usize>(bodies: usize, length: f64, i: u64) -> State<D> {
    let mut places = vec![[0.0; D]];
    for body in 1..bodies {
        let angle = 0.02 * i as f64 + if body % 2 == 0 { 0.5 } else { -0.3 };
        let mut next = places[body - 1];
        (next[0], next[1]) = (next[0] + length * angle.cos(), next[1] + length * angle.sin());
        places.push(next);
    }
    State::of(places)
}

/// Numbers of their own, and steps behind them.
fn counted<const D: usize>(state: State<D>, i: u64) -> State<D> {
    if i.is_multiple_of(2) { state.numbered(1000 + i) } else { state.numbered(i).after_steps(5 * i) }
}

/// How far places are from each other; momenta have to be zero.
fn off<const D: usize>(a: &State<D>, b: &State<D>) -> f64 {
    assert_eq!((a.time(), a.steps()), (b.time(), b.steps()));
    assert!(a.momenta().chain(b.momenta()).all(|p| p.norm() == 0.0));
    a.positions().zip(b.positions()).map(|(a, b)| (a - b).norm()).fold(0.0, larger)
}

fn in_lanes<const D: usize>(ensemble: &Ensemble<D>) {
    let plan = ensemble.plan();
    assert_eq!(plan.in_lanes == ensemble.len(), InstructionSet::widest().fuses(), "{plan:?}");
}

/// How far lanes are from simulations after so many steps.
macro_rules! apart {
    ($scene:expr, $start:expr, $number:expr, $precision:expr, $h:expr, $steps:expr) => {{
        let starts = || (0..$number).map(|i| counted($start(i), i));
        let mut ensemble = $scene.ensemble_in($precision, starts(), method($h)).unwrap();
        in_lanes(&ensemble);
        ensemble.run($steps / 2);
        ensemble.run($steps - $steps / 2);
        assert_eq!(ensemble.failures().count(), 0);
        let alone = starts().enumerate().step_by(5).map(|(i, start)| {
            let mut simulation = $scene.simulate(start, method($h)).unwrap();
            simulation.run($steps).unwrap();
            assert_eq!([simulation.work(), ensemble.work(i)], [0.0; 2]);
            off(&simulation.state(), &ensemble.state(i))
        });
        alone.fold(0.0, larger)
    }};
}

#[test]
fn chains_and_tops_as_alone() {
    let top = Scene::rigid(Rigid::new(MOMENTS)).with(Field { weight: 1.0, pull: 0.5 });
    let begin = |i: u64| start_of_top(i as u32, MOMENTS, 1.0);
    let found = [
        apart!(chain(1), |i| zigzag(2, 1.0, i), 67, Double, 0.01, 51),
        apart!(chain(1), |i| zigzag(2, 1.0, i), 7, Compensated, 0.01, 51),
        apart!(chain(2), |i| zigzag(3, 1.0, i), 67, Compensated, 0.01, 51),
        apart!(chain(7), |i| zigzag(8, 1.0, i), 67, Double, 0.003, 51),
        apart!(pendulum(1.0, 2.5), |i| zigzag(3, 1.0, i), 67, Compensated, 0.01, 51),
        apart!(top, begin, 67, Double, 0.005, 51),
        apart!(top, begin, 7, Compensated, 0.005, 51),
    ];
    println!("{found:?}");
    let fused = InstructionSet::widest().fuses();
    assert!(found.iter().all(|&off| off < 1e-13 && (off > 0.0) == fused), "{found:?}");
}

/// Lengths and masses of each trajectory's own.
#[test]
fn sweeps_of_pendulums() {
    for masses_differ in [false, true] {
        let own = |i: u64| {
            let length = 1.0 + 0.01 * i as f64;
            (length, pendulum(length, if masses_differ { 1.0 + 0.1 * i as f64 } else { 2.5 }))
        };
        let scenes: Vec<_> = (0..66).map(own).collect();
        let begin = |i: u64| counted(zigzag(3, scenes[i as usize].0, i), i);
        let trajectories = scenes.iter().map(|(_, scene)| scene).zip((0..).map(begin));
        let mut sweep = Ensemble::sweep(Double, trajectories, method(0.01)).unwrap();
        in_lanes(&sweep);
        sweep.run(30);
        for (i, (_, scene)) in scenes.iter().enumerate().step_by(3) {
            let mut alone = scene.simulate(begin(i as u64), method(0.01)).unwrap();
            alone.run(30).unwrap();
            let apart = off(&alone.state(), &sweep.state(i));
            assert!(apart < 3e-14, "{i}, masses differ: {masses_differ}: {apart}");
        }
    }
}

/// Bits depend on no neighbour, on no division of a run, and not on a checkpoint between.
macro_rules! the_same_bits {
    ($scene:expr, $start:expr, $h:expr) => {{
        let of = |by: Brownian, numbers: Vec<u64>| {
            $scene.ensemble(numbers.into_iter().map(|i| $start(i).numbered(i)), by).unwrap()
        };
        let few_of = || (0..70).step_by(3).collect::<Vec<_>>();
        let (mut all, mut few) = (of(method($h), (0..70).collect()), of(method($h), few_of()));
        all.run(90);
        few.run(33);
        let record = few.checkpoint();
        few.run(57);
        let mut again = of(method($h), few_of());
        again.resume(&record).unwrap();
        again.run(57);
        for (i, state) in few.states().enumerate() {
            let bits = format!("{state:?}");
            assert_eq!(bits, format!("{:?}", all.state(3 * i)), "{i}");
            assert_eq!(bits, format!("{:?}", again.state(i)), "{i}, from a checkpoint");
        }
        let refused = of(Brownian::new(1.5, 0.4, 10, $h), few_of()).resume(&record).unwrap_err();
        assert!(refused.to_string().contains("method"), "{refused}");
    }};
}

#[test]
fn the_same_bits_of_chains_and_tops() {
    the_same_bits!(chain(2), |i| zigzag(3, 1.0, i), 0.01);
    the_same_bits!(pendulum(1.0, 2.5), |i| zigzag(3, 1.0, i), 0.01);
    let top = Scene::rigid(Rigid::new(MOMENTS)).with(Field { weight: 1.0, pull: 0.5 });
    the_same_bits!(top, |i| start_of_top(i as u32, MOMENTS, 1.0), 0.005);
}

/// Who cannot go on says what a simulation says; the others go on, and each as by itself. How many end, and how many do
/// not. Lanes take steps in which rods turn by more than a simulation lets them: of those, how far rods are off.
macro_rules! ends {
    ($scene:expr, $start:expr, $h:expr, $off:expr) => {{
        let mut ensemble =
            $scene.ensemble((0..64).map(|i| $start(i).numbered(i)), method($h)).unwrap().retry(6);
        ensemble.run(6);
        let mut ended = 0;
        for i in 0..64 {
            let mut alone = $scene.simulate($start(i).numbered(i), method($h)).unwrap().retry(6);
            let (own, told, state) =
                (alone.run(6).err(), ensemble.failure(i as usize), ensemble.state(i as usize));
            let off = match (&own, told) {
                (Some(own), Some(told)) => {
                    assert_eq!(words(own), words(told), "{i}");
                    ended += 1;
                    0.0
                }
                (None, Some(told)) => panic!("{i}: {told}"),
                (Some(_), None) => $off(&state),
                (None, None) => off(&alone.state(), &state),
            };
            assert!(off < 1e-11, "{i}: {off}");
        }
        [ended, 64 - ended]
    }};
}

/// How far rods of length 1 between neighbours are off.
fn rods<const D: usize>(state: &State<D>) -> f64 {
    let places: Vec<_> = state.positions().collect();
    places.windows(2).map(|two| ((two[1] - two[0]).norm() - 1.0).abs()).fold(0.0, larger)
}

#[test]
fn steps_that_are_too_long() {
    let top = Scene::rigid(Rigid::new(MOMENTS)).with(Field { weight: 1.0, pull: 0.5 });
    let found = [
        ends!(chain(2), |i| zigzag(3, 1.0, i), 0.2, rods),
        ends!(pendulum(1.0, 2.5), |i| zigzag(3, 1.0, i), 0.2, rods),
        ends!(top, |i| start_of_top(i as u32, MOMENTS, 1.0), 0.25, |_: &State<9>| 1.0),
    ];
    println!("{found:?}");
    assert!(found.as_flattened().iter().all(|&number| number > 3), "{found:?}");
}

constraint! {
    /// Bodies at a distance of 1 + nπ/k.
    struct Shells { k }
    |a, b, c, x, y, z| sin(k * (sqrt((x - a)^2 + (y - b)^2 + (z - c)^2) - 1))
}

potential! {
    /// A torque that has no value once a body leans so far.
    struct Leaning { g }
    |_a, _b, _c, _d, _e, _f, _g, _h, z| g * sqrt(z - 0.5)
}

#[test]
fn who_ends_ends_in_the_same_step() {
    let by = Brownian::new(1.0, 0.02, 5, 0.02);
    let free = Scene::points::<3>(1).with(Ending { g: 1.0 });
    let beside = Scene::points::<3>(3).link(Rod { length: 1.0 }, [[0, 1]]).with(Ending { g: 1.0 });
    let low = |i: u64| [0.0, 0.0, 0.02 + 0.03 * i as f64];
    let apart = |i: u64| State::of([[0.0, 0.0, 9.0], [1.0, 0.0, 9.0], low(i)]);
    let low = |i: u64| State::at(low(i));
    let body = Scene::rigid(Rigid::new([1.0; 3])).with(Leaning { g: 1.0 });
    let upright = |_: u64| State::at([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    let found = [
        ends_alike!(free, low, by, 9, 20),
        ends_alike!(beside, apart, by, 9, 20),
        ends_alike!(body, upright, Brownian::new(1.0, 0.3, 5, 0.01), 60, 20),
    ];
    println!("{found:?}");
    assert!(found.as_flattened().iter().all(|&number| number > 3), "{found:?}");
}

/// As on surfaces.
#[test]
fn growing_forces_lead_to_no_other_shell() {
    let scene = |k, a| {
        let pair = Scene::points::<3>(2).link(Shells { k }, [[0, 1]]).pin(0, [0.0; 3]);
        pair.with(Unstable { a })
    };
    let found = kept_where_forces_grow!(scene, |at: [f64; 3]| [[0.0; 3], at], [3e3, 1e5], [0.35, 0.6]);
    assert!(found.iter().all(|&number| number > 5), "{found:?}");
}

/// A rod and a ball turn with ⟨u·u₀⟩ = exp(−2 Dₜ t): Dₜ = 2kT/(γ m L²) of a rod between two bodies of mass m, and
/// kT/(γ J) of a ball. To first order in h.
#[test]
fn they_turn_as_they_should() {
    const N: usize = 4096;
    let (friction, kt, h, steps) = (1.5, 0.4, 0.005, 100);
    let by = Brownian::new(friction, kt, 5, h);
    let rods = Scene::points::<3>(2).link(Rod { length: 1.2 }, [[0, 1]]).masses([0.8; 2]);
    let start = State::of([[0.0, 0.0, 0.0], [0.0, 0.0, 1.2]]);
    let mut ensemble = rods.ensemble(vec![start; N], by).unwrap();
    ensemble.run(steps);
    let along = |state: State<3>| {
        let places: Vec<_> = state.positions().collect();
        (places[1].z - places[0].z) / 1.2
    };
    let balls = Scene::rigid(Rigid::new([0.9; 3]));
    let upright = State::at([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    let mut turned = balls.ensemble(vec![upright; N], by).unwrap();
    turned.run(steps);
    let rod = ensemble.states().map(along).sum::<f64>() / N as f64;
    let ball = turned.states().map(|state| state.positions().next().unwrap()[8]).sum::<f64>() / N as f64;
    let exact = |rate: f64| (-2.0 * rate * h * steps as f64).exp();
    for (found, rate) in [(rod, 2.0 * kt / (friction * 0.8 * 1.2 * 1.2)), (ball, kt / (friction * 0.9))] {
        println!("{found} {}", exact(rate));
        // Cosines vary by 0.3 or so.
        assert!(
            (found - exact(rate)).abs() < 4.5 * 0.3 / (N as f64).sqrt() + h * rate,
            "{found} {}",
            exact(rate)
        );
    }
}

/// Of rigid bodies, too, the step that is said to pass does, with the momenta that it has then.
#[test]
fn steps_that_are_said_to_pass_do() {
    let scene = Scene::rigid(Rigid::new([0.5, 0.6, 0.7]));
    let start = || Rigid::start(&Matrix3::identity(), &Vector3::zeros());
    let mut failed = 0;
    for seed in 0..40 {
        let run = |h| scene.simulate(start(), Brownian::new(1.0, 1.0, seed, h)).unwrap().run(1);
        let h = 2.0;
        let Err(Error::Step { cause: StepFailure::Rigid(RigidFailure::TurnsTooFar { passing, .. }), .. }) =
            run(h)
        else {
            continue;
        };
        let passing = passing.0.unwrap();
        assert!(run(passing).is_ok(), "seed {seed}: {passing}");
        assert!((h / passing).log2() % 2.0 == 0.0, "{passing}");
        failed += 1;
    }
    assert!(failed > 10, "{failed}");
}

/// A body that noise leads so far that squares of places are no numbers has run away, in lanes too.
#[test]
fn who_runs_away_is_told() {
    let method = Brownian::new(1.0, 1e306, 5, 1.0);
    let scene = Scene::points(2);
    let start = || State::of([[1.33e154, 0.0], [0.0, 0.0]]);
    let alone = scene.simulate(start(), method).unwrap().run(50).unwrap_err();
    let mut ensemble = scene.ensemble((0..9).map(|_| start()), method).unwrap();
    assert!(ensemble.plan().in_lanes > 0, "{:?}", ensemble.plan());
    ensemble.run(50);
    let is = |error: &Error| matches!(error, Error::Step { cause: StepFailure::RanAway { .. }, .. });
    assert!(is(&alone), "{alone}");
    assert!((0..9).all(|i| ensemble.failure(i).is_some_and(is)), "{:?}", ensemble.failure(0));
}
