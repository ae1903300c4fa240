//! Wishes met, chaos told and errors estimated, by a clock that counts evaluations; the machine's clock decides
//! nothing.

#[path = "../../tests/common/mod.rs"]
mod common;
#[path = "../../tests/common/priced.rs"]
#[allow(dead_code, reason = "each test uses its part")]
mod priced;

use priced::*;
use rattle::Error;
use rattle::bodies::Count;
use rattle::composition::SUZUKI_1990_ORDER_4;
use rattle::effect::Effects;
use rattle::error::{Limit, PriceMistake};
use rattle::prelude::*;
use rattle::scene::Hold;

const WISHES: [f64; 4] = [1e-4, 1e-6, 1e-8, 1e-11];
/// Four million evaluations, where a step has few equations.
const BUDGET: f64 = 4.0;

#[test]
fn chaos_is_told() {
    // A double pendulum from such heights has a Lyapunov time of a few units (its exponent is about 0.4).
    let scene = double_pendulum(400.0);
    let prices = scene.scene.price(&scene.start, 400.0).budget(2.0).clock(scene.clock());
    let prices = prices.observe("height", |now| now.positions().nth(2).unwrap().y).measure().unwrap();
    let time = prices.lyapunov_time.unwrap();
    assert!((1.0..8.0).contains(&time), "Lyapunov time {time}");
    let predictable = prices.predictable.unwrap();
    assert!((30.0..250.0).contains(&predictable), "predictable until {predictable}");
    assert!(prices.averages[0].uncertainty > 1e-3 && prices.to_string().contains("chaotic"));

    let error = scene.within(1e-6, 2.0).unwrap_err();
    let Error::Price(PriceMistake::Unreachable { limit: Limit::Chaos { lyapunov_time, .. }, .. }) = &error
    else {
        panic!("{error}")
    };
    assert!((1.0..8.0).contains(lyapunov_time));
    let mut planned = scene
        .scene
        .within(0.02)
        .in_energy()
        .budget(2.0)
        .clock(scene.clock())
        .simulate(&scene.start, 400.0)
        .unwrap();
    planned.run().unwrap();
    assert!(planned.simulation.energy_error().abs() <= 0.02, "{planned}");

    let scene = pendulum();
    let prices = scene.scene.price(&scene.start, 500.0).budget(0.5).clock(scene.clock()).measure().unwrap();
    assert_eq!((prices.lyapunov_time, prices.predictable), (None, None));
}

/// The trials of wishes in a scene, against ladders that have so many times the budget.
fn trials<C: Hold<D>, E: Effects<D>, N: Count, const D: usize>(
    scene: &Counting<C, E, N, D>,
    wishes: &[f64],
    ladders: f64,
) -> Vec<Trial> {
    let (truth, budget) = (scene.truth(), BUDGET * (scene.counts.len() as f64 / 4.0).max(1.0));
    let all = scene.prices(ladders * budget);
    assert_eq!(all.pilot, all.duration, "{}", scene.name);
    wishes.iter().map(|&wish| scene.tried(wish, budget, &truth, &all)).collect()
}

/// Prints them, the most costly and the worst forecast, and what does not hold.
fn all_hold(trials: &[Trial]) {
    println!("{:18} {:>6} {:>8} {:>6} {:>6}  by", "scene", "wish", "error", "cost", "took");
    trials.iter().for_each(|trial| println!("{trial}"));
    let met = trials.iter().filter(|trial| trial.error <= trial.wish).count();
    let cost = trials.iter().map(|trial| trial.cost).fold(0.0, f64::max);
    let off = trials.iter().map(|trial| (trial.forecast - 1.0).abs()).fold(0.0, f64::max);
    println!(
        "{met} of {} met, at most {cost:.2} of the least, forecasts off by {off:.2} at most",
        trials.len()
    );
    let fell: Vec<_> = trials.iter().filter(|trial| !trial.holds()).map(Trial::to_string).collect();
    assert!(fell.is_empty(), "{}", fell.join("\n"));
}

#[test]
#[cfg_attr(not(long), ignore = "takes long if not optimised: cargo long")]
fn wishes_are_met() {
    let mut list = trials(&lemniscate(), &[1e-4, 1e-8], 2.0);
    list.extend(trials(&pendulum(), &[1e-6, 1e-11], 1.0));
    list.extend(trials(&generated(0), &[1e-6], 1.0));
    list.extend(trials(&generated_chain(0), &[1e-8], 1.0));
    all_hold(&list);
}

/// The average height of a pendulum over forty time units, by Simpson's rule of a series.
#[test]
fn a_wish_for_an_average_is_met() {
    const WISH: f64 = 1e-6;
    const STEPS: u32 = 4000;
    let scene = Counting { duration: 40.0, ..pendulum() };
    let height = |now: &BoxedSimulation<2>| now.positions().nth(1).unwrap().y;
    let asked = scene.scene.within(WISH).budget(BUDGET).clock(scene.clock()).in_average("height", height);
    let mut planned = asked.simulate(&scene.start, scene.duration).unwrap();

    let method = Taylor::adaptive(26, scene.duration / f64::from(STEPS), 1e-18);
    let mut series = scene.scene.simulate(scene.start.clone(), method).unwrap().boxed();
    let mut sum = height(&series);
    for step in 1..=STEPS {
        series.run(1).unwrap();
        sum += height(&series) * if step == STEPS { 1.0 } else { f64::from(2 + 2 * (step % 2)) };
    }
    let exact = sum / f64::from(3 * STEPS);

    let mut mean = Mean::over_time(|now: &Sight<'_, 2>| now.positions[1].y);
    planned.simulation.observe(planned.steps, 1, &mut mean).unwrap();
    let found = mean.mean();
    println!("{planned}: {found}, exact {exact}");
    assert!((found - exact).abs() <= WISH, "{planned}: {found}, exact {exact}");
    let told = &planned.prices.averages[0];
    assert_eq!(told.name, "height");
    assert!((told.mean - exact).abs() <= 0.1 * WISH, "{told:?}, exact {exact}");
}

#[test]
fn a_forecast_from_a_pilot_holds() {
    let scene = Counting { duration: 200.0, ..pendulum() };
    let mut planned = scene.within(1e-3, 1.0).unwrap();
    assert!(planned.prices.pilot < 100.0, "{planned}");
    let spent = planned.run().unwrap();
    // A period is 7.4: parts of the run that the pilot did not see cost as much, to the share of a period in it.
    assert!(
        (spent.seconds / spent.expected - 1.0).abs() < 0.15,
        "{spent}: {planned} from {}",
        planned.prices.pilot
    );
    assert!((planned.simulation.time() - 200.0).abs() < 1e-6);
}

/// Whether the estimate is within a factor of 3 of the truth, for runs by some methods and steps that make sense.
fn estimates<C: Hold<D>, E: Effects<D>, N: Count, const D: usize>(scene: &Counting<C, E, N, D>) -> Vec<bool> {
    let truth = scene.truth();
    let mut held = Vec::new();
    for steps in [200_u64, 400, 800] {
        let h = scene.duration / steps as f64;
        held.extend(estimated(scene, &truth, Rattle::new(0.25 * h), 4 * steps));
        held.extend(estimated(scene, &truth, Composition::new(SUZUKI_1990_ORDER_4, h), steps));
        held.extend(estimated(scene, &truth, Lobatto::<4>::new(2.0 * h), steps / 2));
        held.extend(estimated(scene, &truth, Dop853::adaptive(scene.duration / 10.0, 1e-3 * h.powi(3)), 10));
    }
    held
}

fn estimated<C: Hold<D>, E: Effects<D>, N: Count, S: Method, const D: usize>(
    scene: &Counting<C, E, N, D>,
    truth: &[f64],
    method: S,
    steps: u64,
) -> Option<bool> {
    let name = method.name();
    let mut run = scene.scene.simulate(scene.start.clone(), method).unwrap();
    run.run(steps).ok()?;
    let clock = scene.clock();
    let begun = clock.now();
    let estimate = run.estimate_error_by(&scene.start, &clock).unwrap();
    assert!(estimate.seconds > 0.0 && (estimate.seconds - (clock.now() - begun)).abs() < 1e-12, "{estimate}");
    let error = scene.off(&run.boxed(), truth);
    // Below, the error of the reference and the rounding of one run are as large.
    if error < 1e-13 {
        return None;
    }
    let ratio = estimate.position / error;
    let held = (1.0 / 3.0..3.0).contains(&ratio);
    if !held {
        println!("{}: {name} in {steps} steps: {:e} for {error:e}", scene.name, estimate.position);
    }
    Some(held)
}

fn nineteen_of_twenty(held: &[bool], at_least: usize) {
    let kept = held.iter().filter(|held| **held).count();
    println!("{kept} of {} estimates within a factor of 3", held.len());
    assert!(held.len() >= at_least, "{} estimates", held.len());
    assert!(kept as f64 >= 0.95 * held.len() as f64, "{kept} of {}", held.len());
}

#[test]
fn estimates_are_within_a_factor_of_three() {
    let mut held = estimates(&lemniscate());
    held.extend(estimates(&double_pendulum(3.0)));
    held.extend((0..2).flat_map(|seed| estimates(&generated(seed))));
    nineteen_of_twenty(&held, 30);
}

#[test]
#[ignore = "takes a minute: cargo test -p optimised --release --test price estimates -- --ignored --nocapture"]
fn estimates_of_a_hundred_scenes() {
    let mut held: Vec<_> = (0..60).flat_map(|seed| estimates(&generated(seed))).collect();
    held.extend((0..40).flat_map(|seed| estimates(&generated_chain(seed))));
    nineteen_of_twenty(&held, 800);
}

#[test]
#[ignore = "takes minutes: cargo test -p optimised --release --test price every_wish -- --ignored --nocapture"]
fn every_wish_is_met_in_every_scene() {
    let mut list = trials(&sphere(), &WISHES, 10.0);
    list.extend(trials(&torus(), &WISHES, 10.0));
    list.extend(trials(&lemniscate(), &WISHES, 10.0));
    list.extend(trials(&pendulum(), &WISHES, 10.0));
    list.extend(trials(&double_pendulum(5.0), &WISHES, 10.0));
    list.extend(trials(&crank(), &WISHES, 10.0));
    list.extend(trials(&hanging("chain of 10", 10), &WISHES, 10.0));
    list.extend(trials(&hanging("chain of 100", 100), &WISHES, 10.0));
    list.extend(trials(&free_body(), &WISHES, 10.0));
    list.extend(trials(&rigid("heavy body", 1.0), &WISHES, 10.0));
    list.extend((0..10).flat_map(|seed| trials(&generated(seed), &WISHES, 10.0)));
    list.extend((0..10).flat_map(|seed| trials(&generated_chain(seed), &WISHES, 10.0)));
    all_hold(&list);
}
