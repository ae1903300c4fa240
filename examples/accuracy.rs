//! What accuracy costs in time: error against time for RATTLE and a composition of order 4.
//!
//! ```text
//! cargo run --release --example accuracy
//! ```
//!
//! The billiard under gravity at θ = 45° until t = 5, against a reference with 30 digits. Prints a table, and
//! draws error over time into `out/accuracy/accuracy.svg`.

use rattle::Counted;
use rattle::bodies::One;
use rattle::plot::Chart;
use rattle::prelude::*;
use rattle::system::System;
use std::error::Error;
use std::f64::consts::FRAC_1_SQRT_2;
use std::time::Instant;

constraint! {
    /// The Bernoulli lemniscate, inflated into a surface of genus two.
    pub struct Lemniscate { a, r }
    |x, y, z| {
        let f = (x^2 + y^2)^2 - a^2 * (x^2 - y^2);
        f^2 + z^2 - r^2
    }
}

potential! {
    /// Uniform gravity along −z.
    pub struct Gravity { g }
    |x, y, z| g * z
}

const SURFACE: Lemniscate = Lemniscate { a: 1.0, r: 1.0 / 6.0 };
const GRAVITY: Gravity = Gravity { g: 1.0 };
const T: f64 = 5.0;
/// Each time is the median of this many runs.
const RUNS: usize = 15;

fn main() -> Result<(), Box<dyn Error>> {
    let exact = reference()?;
    let methods: [(&str, Vec<Point>); 2] = [
        ("RATTLE, order 2", measure(Rattle::new, exact)?),
        ("Suzuki, order 4", measure(|h| Composition::new(SUZUKI_1990_ORDER_4, h), exact)?),
    ];
    println!(
        "billiard at θ = 45° until t = {T}; time is the median of {RUNS} runs, evaluations are per run\n"
    );
    for (name, points) in &methods {
        println!(
            "{name:16} {:>9} {:>10} {:>7} {:>9} {:>9} {:>9} {:>9}",
            "h", "error", "order", "ms", "g", "∇g", "∇U"
        );
        let mut last: Option<&Point> = None;
        for point in points {
            let order =
                last.map_or(String::new(), |last| format!("{:.2}", (last.error / point.error).log2()));
            println!(
                "{:16} {:9} {:10.2e} {order:>7} {:9.3} {:9} {:9} {:9}",
                "", point.h, point.error, point.milliseconds, point.values, point.gradients, point.forces
            );
            last = Some(point);
        }
    }
    let cost = |points: &[Point]| points.iter().map(|p| (p.milliseconds, p.error)).collect::<Vec<_>>();
    let [(rattle, slow), (suzuki, fast)] = &methods;
    Chart::new("What accuracy costs: billiard at θ = 45° until t = 5")
        .x("time / ms, one core")
        .y("largest error of a coordinate")
        .log_log()
        .marked(*rattle, cost(slow))
        .slope(-2.0, "time⁻²")
        .marked(*suzuki, cost(fast))
        .slope(-4.0, "time⁻⁴")
        .save("out/accuracy/accuracy.svg")?;
    println!("\nWritten to out/accuracy/accuracy.svg");
    Ok(())
}

/// One step size: what it costs and what it gives.
struct Point {
    h: f64,
    error: f64,
    milliseconds: f64,
    values: u64,
    gradients: u64,
    forces: u64,
}

fn measure<S: Stepper>(method: impl Fn(f64) -> S, exact: [f64; 3]) -> Result<Vec<Point>, rattle::Error> {
    let mut points = Vec::new();
    for halvings in 0..6 {
        let h = 0.02 / f64::from(1 << halvings);
        let steps = (T / h).round() as u64;

        let (surface, gravity) = (Counted::new(SURFACE), Counted::new(GRAVITY));
        let (on_surface, on_gravity) = (surface.counts(), gravity.counts());
        let mut counted = Scene::on(surface).with(gravity).simulate(start(), method(h))?;
        counted.run(steps)?;

        let fresh = Scene::on(SURFACE).with(GRAVITY).simulate(start(), method(h))?;
        points.push(Point {
            h,
            error: error(&counted, exact),
            milliseconds: median_time(&fresh, steps)?,
            values: on_surface.values(),
            gradients: on_surface.gradients(),
            forces: on_gravity.gradients(),
        });
    }
    Ok(points)
}

/// cos and sin of 45° as the reference has them, rounded from the rounded angle.
fn start() -> State<3> {
    State::at([0.0, 0.0, SURFACE.r]).moving([FRAC_1_SQRT_2, FRAC_1_SQRT_2.next_down(), 0.0])
}

fn error<Y: System<f64, 3, Count = One>, S: Stepper>(
    simulation: &Simulation<Y, S, 3>,
    exact: [f64; 3],
) -> f64 {
    simulation.position().iter().zip(exact).map(|(q, exact)| (q - exact).abs()).fold(0.0, f64::max)
}

fn median_time<Y: System<f64, 3>, S: Stepper>(
    fresh: &Simulation<Y, S, 3>,
    steps: u64,
) -> Result<f64, rattle::Error> {
    let mut times = Vec::with_capacity(RUNS);
    for _ in 0..RUNS {
        let mut simulation = fresh.clone();
        let clock = Instant::now();
        simulation.run(steps)?;
        times.push(1e3 * clock.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    Ok(times[RUNS / 2])
}

/// The position at t = 5 for the start in double precision.
fn reference() -> Result<[f64; 3], Box<dyn Error>> {
    let mut table = csv::Reader::from_reader(include_str!("../tests/data/lemniscate_gravity.csv").as_bytes());
    let columns = table.headers()?.clone();
    for row in table.records() {
        let row = row?;
        let text = |name: &str| columns.iter().position(|column| column == name).map_or("", |i| &row[i]);
        if text("theta_deg") == "45" && text("ic") == "f64" && text("t") == "5.0" {
            return Ok([text("x").parse()?, text("y").parse()?, text("z").parse()?]);
        }
    }
    Err("the reference has no row for θ = 45° and t = 5".into())
}
