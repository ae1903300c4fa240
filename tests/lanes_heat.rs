//! Friction and noise in lanes: as each trajectory alone but for rounding, with the same random numbers.

use crate::common::{Gravity, larger};
use crate::lanes_brownian::words;
use rattle::effect::Langevin;
use rattle::ensemble::InstructionSet;
use rattle::prelude::*;

constraint! {
    /// Spheres of radius 1 + nπ/k.
    struct Shells { k }
    |x, y, z| sin(k * (sqrt(x^2 + y^2 + z^2) - 1))
}

const HEAT: Langevin = Langevin { friction: 2.0, temperature: 0.5, seed: 7 };

macro_rules! scene {
    ($k:expr, $heat:expr) => {
        scene!($k, 1.0, $heat)
    };
    ($k:expr, $g:expr, $heat:expr) => {
        Scene::on(Shells { k: $k }).with(Gravity { g: $g }).with($heat)
    };
}

/// From different places, of trajectories with numbers and steps behind them, and without.
fn start(i: u64) -> State<3> {
    let angle = 0.1 * i as f64;
    let state = State::at([angle.cos(), angle.sin(), 0.0]).moving([0.0, 0.0, 0.3 + 0.01 * i as f64]);
    match i % 3 {
        0 => state.numbered(1000 + i),
        1 => state.after_steps(5 * i),
        _ => state,
    }
}

fn bits(state: &State<3>) -> String {
    format!("{state:?}")
}

fn off(a: &State<3>, b: &State<3>) -> f64 {
    let apart = a.positions().zip(b.positions()).chain(a.momenta().zip(b.momenta()));
    apart.map(|(a, b)| (a - b).norm()).fold(0.0, larger)
}

#[test]
#[cfg(long)]
fn as_alone_but_for_rounding() {
    fn worst<P: Precision>(precision: P, method: Baoab, steps: u64) -> f64 {
        let scene = scene!(1.0, HEAT);
        let mut ensemble = scene.ensemble_in(precision, (0..70).map(start), method).unwrap();
        ensemble.run(steps);
        assert_eq!(ensemble.bill().unwrap().side_by_side > 1, InstructionSet::widest().fuses());
        let alone = (0..70).map(|i| {
            // An ensemble counts its trajectories; a simulation has to be told.
            let numbered = if i % 3 == 0 { start(i) } else { start(i).numbered(i) };
            let mut simulation = scene.simulate(numbered, method).unwrap();
            simulation.run(steps).unwrap();
            let (own, state) = (simulation.state(), ensemble.state(i as usize));
            assert_eq!((own.time(), own.steps()), (state.time(), state.steps()));
            off(&own, &state)
        });
        alone.fold(0.0, larger)
    }
    let found = [
        worst(Double, Baoab::new(0.05), 40),
        worst(Double, Baoab::with_inner(3, 0.1), 20),
        worst(Compensated, Baoab::new(0.05), 40),
        worst(Compensated, Baoab::with_inner(2, 0.1), 20),
    ];
    println!("{found:?}");
    assert!(found.iter().all(|&off| off < 1e-12), "{found:?}");
}

/// Each trajectory of a sweep has a bath of its own.
#[test]
fn baths_by_lane() {
    let scenes: Vec<_> =
        (0..66).map(|i| scene!(1.0, Langevin { friction: 0.1 * f64::from(i), ..HEAT })).collect();
    let trajectories = scenes.iter().zip((0..).map(start));
    let mut sweep = Ensemble::sweep(Double, trajectories, Baoab::new(0.05)).unwrap();
    sweep.run(30);
    for (i, scene) in scenes.iter().enumerate() {
        let number = i as u64;
        let numbered = if i % 3 == 0 { start(number) } else { start(number).numbered(number) };
        let mut alone = scene.simulate(numbered, Baoab::new(0.05)).unwrap();
        alone.run(30).unwrap();
        assert!(off(&alone.state(), &sweep.state(i)) < 1e-12, "{i}");
    }
}

/// Bits depend on no neighbour, on no division of a run, and not on a checkpoint between.
#[test]
fn the_same_bits() {
    let (scene, method) = (scene!(1.0, HEAT), Baoab::new(0.05));
    let of = |numbers: Vec<u64>| {
        scene.ensemble(numbers.into_iter().map(|i| start(i).numbered(i)), method).unwrap()
    };
    let (mut all, mut few) = (of((0..70).collect()), of((0..70).step_by(7).collect()));
    all.run(90);
    few.run(33);
    let record = few.checkpoint();
    few.run(57);
    let mut again = of((0..70).step_by(7).collect());
    again.resume(&record).unwrap();
    again.run(57);
    for (i, state) in few.states().enumerate() {
        assert_eq!(bits(&state), bits(&all.state(7 * i)), "{i}");
        assert_eq!(bits(&state), bits(&again.state(i)), "{i}, from a checkpoint");
    }
    let other = scene!(1.0, Langevin { seed: 8, ..HEAT });
    let other = &mut other.ensemble((0..10).map(|i| start(i).numbered(i)), method).unwrap();
    let refused = other.resume(&record).unwrap_err().to_string();
    assert!(!InstructionSet::widest().fuses() || refused.contains("flow 0"), "{refused}");
}

/// In equilibrium ½kT for each of two momenta, and heights with the density exp(−gz/kT), uniform in z on a sphere.
#[test]
fn equilibrium() {
    let scene = scene!(1.0, HEAT);
    let starts = (0..192).map(|_| State::at([0.0, 0.0, -1.0]));
    let mut ensemble = scene.ensemble(starts, Baoab::new(0.1)).unwrap();
    ensemble.run(40);
    let new = || (Mean::of(|now: &Sight<'_, 3>| 0.5 * now.momentum().norm_squared()), Mean::of(height));
    fn height(now: &Sight<'_, 3>) -> f64 {
        now.position().z
    }
    let (energy, height) = ensemble.observe(200, 20, new);
    // 1920 samples, of which 192 at least are independent; energies lose their past in 1/2γ, 2.5 steps.
    let (kt, z) = (0.5, 0.5 - 1.0 / (1.0_f64 / 0.5).tanh());
    assert!((energy.mean() / kt - 1.0).abs() < 4.5 / 1920.0_f64.sqrt(), "{}", energy.mean());
    assert!((height.mean() - z).abs() < 4.5 * 0.42 / 192.0_f64.sqrt(), "{} {z}", height.mean());
}

/// Trajectories that start at rest and are heated do not land on shells 3e-5 to 0.1 apart in silence. Those that go by
/// themselves draw what simulations draw.
#[test]
fn shells_are_kept() {
    let (mut kept, mut refused) = (0, 0);
    for (k, g, h) in [(1e3, 1.0, 0.05), (30.0, 1.0, 0.1), (1e5, 0.0, 0.2)] {
        let scene = scene!(k, g, Langevin { friction: 5.0, temperature: 1.0, seed: 3 });
        let begin = |i: u64| State::at([(i as f64).cos(), (i as f64).sin(), 0.0]).numbered(i);
        let mut ensemble = scene.ensemble((0..32).map(begin), Baoab::new(h)).unwrap();
        ensemble.run(20);
        refused += ensemble.failures().count();
        for (i, state) in ensemble.states().enumerate() {
            let radius = state.positions().next().unwrap().norm();
            assert!(
                (radius - 1.0).abs() < 0.5 / k,
                "k = {k}, h = {h}, {i}: on the sphere of radius {radius}"
            );
            let mut alone = scene.simulate(begin(i as u64), Baoab::new(h)).unwrap();
            match (alone.run(20), ensemble.failure(i)) {
                (Ok(()), None) => {
                    assert!(off(&alone.state(), &state) < 1e-10, "k = {k}, {i}");
                    kept += 1;
                }
                (Err(own), Some(told)) => assert_eq!(words(&own), words(told)),
                (own, told) => panic!("k = {k}, {i}: alone {own:?}, in lanes {told:?}"),
            }
        }
    }
    println!("{kept} kept their shell for 20 steps, {refused} were refused");
    assert!(kept > 20, "{kept} {refused}");
}

/// A step in parts draws what a simulation draws for it.
#[test]
fn parts_of_steps() {
    let (scene, method) = (scene!(1.0, HEAT), Baoab::new(0.9)); // a drift of 1.8 radii at first
    let begin = |i: u64| State::at([1.0, 0.0, 0.0]).moving([0.0, 4.0, 0.0]).numbered(i).after_steps(i);
    let mut whole = scene.ensemble((0..20).map(begin), method).unwrap();
    whole.run(1);
    assert_eq!(whole.failures().count(), 20);
    let mut ensemble = scene.ensemble((0..20).map(begin), method).unwrap().retry(8);
    ensemble.run(1);
    for i in 0..20 {
        let mut alone = scene.simulate(begin(i), method).unwrap().retry(8);
        alone.run(1).unwrap();
        assert!(off(&alone.state(), &ensemble.state(i as usize)) < 1e-12, "{i}");
    }
}
