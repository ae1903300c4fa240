//! A step of a chain costs as many operations as it has links: from 100 to 100 000.
//!
//! ```text
//! cargo bench --bench chain
//! ```
//!
//! A chain of total length and mass 1 falls from the horizontal; its step is a fifth of the time that a wave needs for
//! a link, so that chains of all lengths are equally accurate. Times are medians of several runs; the slope is that of
//! log(time per step) over log(links), fitted. Allocations are counted over the timed steps.
//!
//! Then molecules: so few that each is moved by itself, and so many that they go side by side.

mod common;

use common::{RUNS, slope, timed};
use rattle::links::{self, planar::Rod};
use rattle::potentials::planar::Gravity;
use rattle::prelude::*;
use std::time::Instant;

const LINKS: [u32; 4] = [100, 1_000, 10_000, 100_000];
/// Steps that one timing covers, as many as fit before the chain has fallen far.
const STEPS: [u32; 4] = [150, 150, 150, 20];

fn main() -> Result<(), rattle::Error> {
    println!("  links   µs per step   ns per link   corrections per step   allocations   largest |g|/|∇g|ℓ");
    let mut points = Vec::new();
    for (links, steps) in LINKS.into_iter().zip(STEPS) {
        let length = 1.0 / f64::from(links);
        let n = links as usize;
        let scene = Scene::points(n + 1)
            .link(Rod { length }, (0..n).map(|i| [i, i + 1]))
            .pin(0, [0.0, 0.0])
            .mass(length)
            .with(Gravity { g: length });
        let straight = State::of((0..=links).map(|i| [f64::from(i) * length, 0.0]));
        let mut start = scene.simulate(scene.project(&straight)?, Rattle::new(0.2 * length))?;
        start.run(20)?; // leaves the straight line
        let mut simulation = start.clone();
        let mut times = Vec::new();
        let mut allocations = 0;
        for _ in 0..RUNS {
            simulation = start.clone();
            let mut outcome = Ok(());
            let clock = Instant::now();
            allocations += allocation_counter::measure(|| outcome = simulation.run(steps.into())).count_total;
            times.push(clock.elapsed().as_secs_f64() / f64::from(steps));
            outcome?;
        }
        times.sort_by(f64::total_cmp);
        let (time, before, after) = (times[RUNS / 2], start.counts(), simulation.counts());
        let corrections =
            (after.corrections - before.corrections) as f64 / (after.solves - before.solves) as f64;
        println!(
            "{links:7} {:13.2} {:13.1} {corrections:22.3} {allocations:13} {:20.1e}",
            1e6 * time,
            1e9 * time / f64::from(links),
            simulation.constraint_residual() / (2.0 * length * length),
        );
        points.push((f64::from(links).ln(), time.ln()));
    }
    println!("\nratio slope {:.3}", slope(&points));
    molecules()
}

const MOLECULES: [usize; 3] = [20, 1_000, 10_000];

/// Dumbbells, and triangles of rods, that fly freely.
fn molecules() -> Result<(), rattle::Error> {
    println!("\n                  molecules   ns per molecule and step   allocations");
    for (name, bodies) in [("dumbbells", 2), ("triangles", 3)] {
        let mut alone = 0.0;
        for n in MOLECULES {
            let corners = [[0.0, 0.0, 0.0], [0.8, 0.6, 0.0], [-0.8, 0.6, 0.0]];
            let places = (0..n).flat_map(|_| corners.into_iter().take(bodies));
            let momentum = |i: usize| [0.3, 1.7, 2.9].map(|speed| (speed * i as f64).sin());
            let legs = (0..n).flat_map(|i| (1..bodies).map(move |leg| [bodies * i, bodies * i + leg]));
            let rest = (0..if bodies == 3 { n } else { 0 }).map(|i| [bodies * i + 1, bodies * i + 2]);
            let scene = Scene::points(bodies * n)
                .link(links::Rod { length: 1.0 }, legs)
                .link(links::Rod { length: 1.6 }, rest);
            let start = scene.project(&State::of(places).with_momenta((0..bodies * n).map(momentum)))?;
            let (time, allocations) = timed(scene.simulate(start, Rattle::new(0.01))?, 200_000 / n as u64)?;
            let each = 1e9 * time / n as f64;
            println!("{name:18} {n:8} {each:26.1} {allocations:13}");
            if n == MOLECULES[0] {
                alone = each;
            } else {
                println!("ratio {name}_alone_over_{n} {:.2}", alone / each);
            }
        }
    }
    Ok(())
}
