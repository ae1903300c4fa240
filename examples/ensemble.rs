//! Many trajectories at once: a Poincaré section of billiards, and what speed an ensemble has.
//!
//! ```text
//! cargo run --release --example ensemble
//! ```
//!
//! Ten thousand particles leave one point of the lemniscate surface in all directions, under gravity, all with the same
//! energy. Where they pass through the plane y = 0 they leave a dot: position and momentum along x. Nothing of the way
//! between is stored. The dots fill what the energy allows of the three parts of the plane that lie on the surface, as
//! chaos does; streaks are what is left of the first swing, which starts from a line.
//!
//! Prints time per step and trajectory, with the bill of it, and energy errors; draws into `out/ensemble`: the section
//! (`section.svg`) and how long trajectories take to come back to it (`returns.svg`).

use rattle::ensemble::Precision;
use rattle::plot::Chart;
use rattle::potentials::Gravity;
use rattle::prelude::*;
use rattle::progress::Bar;
use rattle::surfaces::Lemniscate;
use std::time::Instant;

const R: f64 = 1.0 / 6.0;
const NUMBER: usize = 10_000;
const H: f64 = 0.005;

fn starts() -> impl Iterator<Item = State<3>> {
    (0..NUMBER).map(|i| {
        let angle = std::f64::consts::TAU * (i as f64 + 0.5) / NUMBER as f64;
        State::at([0.0, 0.0, R]).moving([angle.cos(), angle.sin(), 0.0])
    })
}

fn speed<P: Precision>(name: &str, precision: P) -> Result<(), rattle::Error> {
    let scene = Scene::on(Lemniscate { a: 1.0, r: R }).with(Gravity { g: 1.0 });
    let mut ensemble = scene.ensemble_in(precision, starts(), Rattle::new(H))?;
    let clock = Instant::now();
    ensemble.run(2000);
    let time = clock.elapsed().as_secs_f64() / (2000.0 * NUMBER as f64);
    let failed = ensemble.failures().count();
    println!("{name:12} {:6.2} ns per step and trajectory, {failed} of {NUMBER} ended", 1e9 * time);
    println!("{}\n", ensemble.bill()?);
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    speed("single", Single)?;
    speed("double", Double)?;
    speed("compensated", Compensated)?;

    let scene = Scene::on(Lemniscate { a: 1.0, r: R }).with(Gravity { g: 1.0 });
    let mut ensemble = scene.ensemble(starts(), Rattle::new(H))?;
    println!("{} instructions, {} threads", ensemble.instruction_set(), rayon::current_num_threads());
    let error = |now: &Sight<'_, 3>| (now.energy() - 0.5 - R).abs();
    let errors = Histogram::of(error, 0.0, 0.01, 100)?;
    let bar = Bar::of(4000 * ensemble.len() as u64); // sights, if no trajectory fails
    let observers = || {
        let through = Section::of(|now: &Sight<'_, 3>| now.position().y);
        ((through, bar.observer()), (Mean::of(error), errors.clone()))
    };
    let ((section, _), (errors, histogram)) = ensemble.observe(4000, 1, observers);
    drop(bar);
    println!("{} crossings; energy error {:.1e} on average", section.crossings().len(), errors.mean());
    println!("{} of {} sights with more than 0.01", histogram.outside(), errors.number());
    for (trajectory, error) in ensemble.failures().take(3) {
        println!("trajectory {trajectory}: {error}");
    }

    let dots = section.crossings().iter().filter(|crossing| crossing.positions[0].z > 0.0).step_by(4);
    let dots = dots.map(|crossing| (crossing.positions[0].x, crossing.momenta[0].x)).take(30_000);
    Chart::new("Through the plane y = 0 towards y > 0, where z > 0")
        .x("x")
        .y("momentum along x")
        .points("crossings", dots)
        .save("out/ensemble/section.svg")?;

    let mut times: Vec<f64> = section.return_times().into_iter().map(|(_, time)| time).collect();
    times.sort_by(f64::total_cmp);
    let (bins, longest) = (200, 10.0);
    let mut counts = vec![0_u32; bins];
    for time in times.iter().filter(|&&time| time < longest) {
        counts[(time / longest * bins as f64) as usize] += 1;
    }
    let share = |count: u32| f64::from(count) / times.len() as f64 * bins as f64 / longest;
    let curve =
        counts.iter().enumerate().map(|(i, &count)| ((i as f64 + 0.5) * longest / bins as f64, share(count)));
    Chart::new("How long from one crossing to the next")
        .x("time")
        .y("share per unit of time")
        .line("10 000 trajectories", curve)
        .save("out/ensemble/returns.svg")?;
    println!("out/ensemble/section.svg, out/ensemble/returns.svg");
    Ok(())
}
