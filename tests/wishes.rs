//! Wishes held after every step of the planned run, not only where they were measured: a pendulum of length 2 under a
//! weight of 2, by a clock that counts evaluations.

use super::common::larger;
use super::priced::{Counting, FREE, Forces, NONE, OnSurface, Several, on};
use rattle::Error;
use rattle::error::{Limit, PriceMistake};
use rattle::prelude::*;
use rattle::price::{Candidate, Planned};

const ANGLES: [f64; 3] = [0.5, 1.5, 2.8];
const DURATIONS: [f64; 3] = [7.0, 20.0, 100.0];
/// A million evaluations, in which not every wish is reached.
const BUDGET: f64 = 1.0;
/// Of 27 or 36 wishes: the small ones of long runs.
const LATE: u32 = 8;
/// Where there are more steps than instants at which errors are measured, they may be larger in between.
const BETWEEN: f64 = 1.03;

/// Released at rest at an angle from the bottom; from 2.8 it falls through the bottom in a short part of its period.
fn released(angle: f64, duration: f64) -> OnSurface {
    let (sin, cos) = angle.sin_cos();
    let start = State::at([2.0 * sin, 0.0, -2.0 * cos]);
    on("pendulum", Several { sphere: 1.0, ..NONE }, Forces { g: 2.0, ..FREE }, start, duration)
}

/// Whether a wish was refused for the budget alone.
fn is_late(error: &Error) -> bool {
    let Error::Price(PriceMistake::Unreachable { limit, .. }) = error else { return false };
    matches!(limit, Limit::Budget { .. })
}

fn all(mut check: impl FnMut(&OnSurface, String)) {
    for angle in ANGLES {
        for duration in DURATIONS {
            check(&released(angle, duration), format!("from {angle} for {duration}"));
        }
    }
}

/// The largest distance from the exact motion after any step, and the largest error of the energy; NaN where one is.
fn worst(scene: &OnSurface, mut planned: Planned<3>) -> (f64, f64) {
    let exact = Dop853::adaptive(planned.h, 1e-13);
    let mut exact = scene.scene.simulate(scene.start.clone(), exact).unwrap().retry(6);
    let (mut farthest, mut energy) = (0.0_f64, 0.0_f64);
    let mut steps = 0;
    planned
        .simulation
        .run_with(planned.steps, |now| {
            exact.step().unwrap();
            farthest = larger(farthest, (now.positions().next().unwrap() - exact.position()).norm());
            energy = larger(energy, now.energy_error().abs());
            steps += 1;
        })
        .unwrap();
    assert!(steps > 0 && steps == planned.steps);
    (farthest, energy)
}

#[test]
fn positions_are_within_the_wish_after_every_step() {
    let (mut fell, mut late) = (Vec::new(), 0);
    all(|scene, who| {
        for wish in [1e-1, 1e-2, 1e-3, 1e-5] {
            match scene.within(wish, BUDGET) {
                Err(error) if is_late(&error) => late += 1,
                Err(error) => fell.push(format!("{who}, {wish:e}: {error}")),
                Ok(planned) => {
                    let told = planned.to_string();
                    let (farthest, _) = worst(scene, planned);
                    if farthest.is_nan() || farthest > BETWEEN * wish {
                        fell.push(format!("{who}, {wish:e}: {told}, in truth {farthest:e}"));
                    }
                }
            }
        }
    });
    assert!(fell.is_empty() && late <= LATE, "{late} late\n{}", fell.join("\n"));
}

#[test]
fn energies_are_within_the_wish_after_every_step() {
    let (mut fell, mut late) = (Vec::new(), 0);
    all(|scene, who| {
        for wish in [1e-1, 1e-2, 1e-4] {
            let asked = scene.scene.within(wish).in_energy().budget(BUDGET).clock(scene.clock());
            match asked.simulate(&scene.start, scene.duration) {
                Err(error) if is_late(&error) => late += 1,
                Err(error) => fell.push(format!("{who}, {wish:e}: {error}")),
                Ok(planned) => {
                    let told = planned.to_string();
                    let (_, energy) = worst(scene, planned);
                    if energy.is_nan() || energy > BETWEEN * wish {
                        fell.push(format!("{who}, {wish:e}: {told}, in truth {energy:e}"));
                    }
                }
            }
        }
    });
    assert!(fell.is_empty() && late <= LATE, "{late} late\n{}", fell.join("\n"));
}

fn height(now: &BoxedSimulation<3>) -> f64 {
    now.positions().next().unwrap().z
}

/// The average of the height by Simpson's rule, with 6000 steps of order 8.
fn exactly(scene: &OnSurface) -> f64 {
    let number = 6000;
    let method = Lobatto::<5>::new(scene.duration / f64::from(number));
    let mut run = scene.scene.simulate(scene.start.clone(), method).unwrap();
    let mut sum = run.position().z;
    for step in 1..=number {
        run.step().unwrap();
        let weight = if step == number { 1.0 } else { f64::from(2 + 2 * (step % 2)) };
        sum += weight * run.position().z;
    }
    sum / f64::from(3 * number)
}

/// By the trapezoidal rule over the steps of the planned run.
#[test]
fn averages_are_within_the_wish_over_the_steps() {
    let (mut fell, mut late) = (Vec::new(), 0);
    all(|scene, who| {
        let exact = exactly(scene);
        for wish in [1e-1, 1e-3, 1e-5] {
            let asked =
                scene.scene.within(wish).in_average("height", height).budget(BUDGET).clock(scene.clock());
            match asked.simulate(&scene.start, scene.duration) {
                Err(error) if is_late(&error) => late += 1,
                Err(error) => fell.push(format!("{who}, {wish:e}: {error}")),
                Ok(mut planned) => {
                    let known = planned.prices.averages[0].mean;
                    let told = format!("{planned}, {known}");
                    let mut sum = 0.5 * height(&planned.simulation);
                    planned.simulation.run_with(planned.steps, |now| sum += height(now)).unwrap();
                    let average = (sum - 0.5 * height(&planned.simulation)) / planned.steps as f64;
                    // Of a part of the run that was measured, another average is known.
                    let whole = planned.prices.pilot == scene.duration;
                    let of_reference = if whole { (known - exact).abs() } else { 0.0 };
                    let off = larger((average - exact).abs(), of_reference);
                    if off.is_nan() || off > wish {
                        fell.push(format!("{who}, {wish:e}: {told}, found {average}, in truth {exact}"));
                    }
                }
            }
        }
    });
    assert!(fell.is_empty() && late <= LATE, "{late} late\n{}", fell.join("\n"));
    // What no step reaches is told as such.
    let scene = released(1.5, 20.0);
    let asked = scene.scene.within(1e-15).in_average("height", height).budget(0.05).clock(scene.clock());
    let asked = asked.simulate(&scene.start, scene.duration);
    assert!(matches!(asked, Err(Error::Price(PriceMistake::Unreachable { .. }))), "{asked:?}");
}

/// The error that a row tells is the largest after any of its steps.
#[test]
fn rows_tell_the_largest_error_of_all_steps() {
    let scene = released(2.8, 20.0);
    let asked = scene.scene.price(&scene.start, scene.duration).budget(1.0).clock(scene.clock());
    let prices = asked.observe("height", height).measure().unwrap();
    let whole = prices.pilot;
    let exact = exactly(&Counting { duration: whole, ..released(2.8, 20.0) });
    let mut checked = 0;
    for row in prices.rows.iter().filter(|row| row.tolerance.is_none()) {
        let (Some(told), true) = (row.position, row.steps < 1000) else { continue };
        if row.method != rattle::price::Candidate::Rattle || told < 1e-6 {
            continue;
        }
        let mut own = scene.scene.simulate(scene.start.clone(), Rattle::new(row.h)).unwrap();
        let dop = Dop853::adaptive(row.h, 1e-13);
        let mut truth = scene.scene.simulate(scene.start.clone(), dop).unwrap().retry(6);
        let (mut farthest, mut sum) = (0.0_f64, 0.5 * own.position().z);
        own.run_with(row.steps, |now| {
            truth.step().unwrap();
            farthest = larger(farthest, (now.position() - truth.position()).norm());
            sum += now.position().z;
        })
        .unwrap();
        assert!((farthest / told - 1.0).abs() < 0.03, "told {told:e}, in truth {farthest:e}: h = {}", row.h);
        let off = ((sum - 0.5 * own.position().z) / row.steps as f64 - exact).abs();
        assert!((off - row.averages[0]).abs() < 1e-7 + 0.01 * off, "{:e}, in truth {off:e}", row.averages[0]);
        checked += 1;
    }
    assert!(checked > 2, "{checked} of\n{prices:#}");
}

/// Once `Taylor` reaches a wish, `DOP853` is not tried further where it takes longer, and the longer the finer it is.
#[test]
fn ladders_end_where_they_only_get_dearer() {
    let mut longest = 0;
    for angle in ANGLES {
        for wish in [1e-7, 1e-9] {
            let planned = released(angle, 7.0).within(wish, BUDGET).unwrap();
            let rows = |method| planned.prices.rows.iter().filter(move |row| row.method == method);
            let reached =
                rows(Candidate::Taylor).filter(|row| row.position.is_some_and(|off| off < 0.1 * wish));
            let least = reached.map(|row| row.seconds).fold(f64::INFINITY, f64::min);
            let (mut before, mut dearer) = (f64::INFINITY, 0);
            for row in rows(Candidate::Dop853) {
                dearer = if row.seconds > least.max(before) { dearer + 1 } else { 0 };
                before = row.seconds;
                longest = longest.max(dearer);
            }
            assert!(least.is_finite() && dearer <= 3, "from {angle}, {wish:e}: {dearer} in turn");
        }
    }
    assert!(longest > 1);
}
