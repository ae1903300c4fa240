//! What several benchmarks time alike.

mod clock;

use clock::cpu_seconds;
use rattle::method::Method;
use rattle::prelude::*;
use rattle::system::System;

/// Of so many runs the median counts.
pub(crate) const RUNS: usize = 5;

/// Seconds for a step, and allocations in as many steps as are timed.
pub(crate) fn timed<Y: System<f64, 3>, S: Method>(
    mut simulation: Simulation<Y, S, 3>,
    steps: u64,
) -> Result<(f64, u64), rattle::Error> {
    simulation.run(2 * steps)?;
    let (mut times, mut allocations, mut outcome) = (Vec::new(), 0, Ok(()));
    for _ in 0..RUNS {
        let before = cpu_seconds();
        allocations += allocation_counter::measure(|| outcome = simulation.run(steps)).count_total;
        times.push((cpu_seconds() - before) / steps as f64);
        outcome.clone()?;
    }
    times.sort_by(f64::total_cmp);
    Ok((times[RUNS / 2], allocations))
}

/// The slope of the straight line through the points, by least squares.
pub(crate) fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let mean = |f: fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let (xy, xx) = (mean(|p| p.0 * p.1) - x * y, mean(|p| p.0 * p.0) - x * x);
    xy / xx
}
