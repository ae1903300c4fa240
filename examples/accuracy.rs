//! What accuracy costs in time: error against time for RATTLE, compositions of it and Lobatto methods.
//!
//! ```text
//! cargo run --release --example accuracy
//! ```
//!
//! The billiard under gravity at θ = 45° until t = 5, against a reference with 30 digits. Prints a table, and
//! draws error over time into `out/accuracy/accuracy.svg`.

use rattle::Counted;
use rattle::bodies::One;
use rattle::composition::KAHAN_LI_1997_ORDER_8;
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
    let kahan_li = |h| Composition::new(KAHAN_LI_1997_ORDER_8, h);
    let methods: [(&str, Vec<Point>); 7] = [
        ("RATTLE, order 2", measure(Rattle::new, 0.02, exact)?),
        ("Suzuki, order 4", measure(|h| Composition::new(SUZUKI_1990_ORDER_4, h), 0.02, exact)?),
        ("Kahan–Li, order 8", measure(kahan_li, 0.04, exact)?),
        ("Lobatto, order 4", measure(Lobatto::<3>::new, 0.05, exact)?),
        ("Lobatto, order 8", measure(Lobatto::<5>::new, 0.05, exact)?),
        ("… extrapolated", measure(|h| Lobatto::<5>::new(h).extrapolated(), 0.05, exact)?),
        ("Lobatto, order 16", measure(Lobatto::<9>::new, 0.1, exact)?),
    ];
    println!(
        "billiard at θ = 45° until t = {T}; time is the median of {RUNS} runs, evaluations are per run\n"
    );
    for (name, points) in &methods {
        println!(
            "{name:18} {:>9} {:>10} {:>7} {:>9} {:>9} {:>9} {:>9}",
            "h", "error", "order", "ms", "g", "∇g", "∇U"
        );
        let mut last: Option<&Point> = None;
        for point in points {
            let order = last.map_or(String::new(), |last| {
                format!("{:.2}", (last.error / point.error).ln() / (last.h / point.h).ln())
            });
            println!(
                "{:18} {:9.5} {:10.2e} {order:>7} {:9.3} {:9} {:9} {:9}",
                "", point.h, point.error, point.milliseconds, point.values, point.gradients, point.forces
            );
            last = Some(point);
        }
    }

    println!("\nmilliseconds to an error of      1e-4     1e-6     1e-8    1e-10    1e-12");
    for (name, points) in &methods {
        let times = [1e-4, 1e-6, 1e-8, 1e-10, 1e-12]
            .map(|error| time_to(points, error).map_or("       –".into(), |time| format!("{time:8.3}")));
        println!("{name:28} {}", times.join(" "));
    }
    let steps = |method: usize| steps_to(&methods[method].1, 1e-8);
    if let (Some(composed), Some(pure), Some(extrapolated)) = (steps(2), steps(4), steps(5)) {
        let (mut over_pure, mut over_extrapolated) = (Vec::new(), Vec::new());
        let composed = run_of(composed, kahan_li)?;
        let pure = run_of(pure, Lobatto::<5>::new)?;
        let extrapolated = run_of(extrapolated, |h| Lobatto::<5>::new(h).extrapolated())?;
        for _ in 0..10 * RUNS {
            let time = composed()?; // in turns: a slow moment of the machine is one of all three
            over_pure.push(time / pure()?);
            over_extrapolated.push(time / extrapolated()?);
        }
        println!("\ntime to 1e-8, Kahan–Li over Lobatto of order 8, median of {} turns", 10 * RUNS);
        println!("ratio composition_over_lobatto {:.2}", median(over_pure));
        println!("ratio composition_over_lobatto_extrapolated {:.2}", median(over_extrapolated));
    }

    let mut chart = Chart::new("What accuracy costs: billiard at θ = 45° until t = 5")
        .x("time / ms, one core")
        .y("largest error of a coordinate")
        .log_log();
    for (name, points) in &methods {
        chart = chart.marked(*name, points.iter().map(|p| (p.milliseconds, p.error)));
    }
    chart.save("out/accuracy/accuracy.svg")?;
    println!("\nWritten to out/accuracy/accuracy.svg");
    Ok(())
}

/// The time to this error, between the points that have more and less, both on logarithmic scales.
fn time_to(points: &[Point], error: f64) -> Option<f64> {
    points.windows(2).find(|pair| pair[0].error >= error && pair[1].error < error).map(|pair| {
        let part = (pair[0].error / error).ln() / (pair[0].error / pair[1].error).ln();
        pair[0].milliseconds * (pair[1].milliseconds / pair[0].milliseconds).powf(part)
    })
}

/// The number of steps to this error, likewise.
fn steps_to(points: &[Point], error: f64) -> Option<u64> {
    points.windows(2).find(|pair| pair[0].error >= error && pair[1].error < error).map(|pair| {
        let part = (pair[0].error / error).ln() / (pair[0].error / pair[1].error).ln();
        (T / (pair[0].h * (pair[1].h / pair[0].h).powf(part))).round() as u64
    })
}

/// The time that a whole run in so many steps takes, every time it is called.
fn run_of<S: Stepper>(
    steps: u64,
    method: impl Fn(f64) -> S,
) -> Result<impl Fn() -> Result<f64, rattle::Error>, rattle::Error> {
    let fresh = Scene::on(SURFACE).with(GRAVITY).simulate(start(), method(T / steps as f64))?;
    Ok(move || time_of(&fresh, steps))
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

/// From the longest step to an eighth of it or to the rounding floor; RATTLE to a thirty-second.
fn measure<S: Stepper>(
    method: impl Fn(f64) -> S,
    longest: f64,
    exact: [f64; 3],
) -> Result<Vec<Point>, rattle::Error> {
    let mut points: Vec<Point> = Vec::new();
    for shorter in 0..if method(longest).order() < 8 { 11 } else { 9 } {
        let steps = (T / longest * 2_f64.powf(0.5 * f64::from(shorter))).round();
        let (h, steps) = (T / steps, steps as u64);

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
        times.push(time_of(fresh, steps)?);
    }
    Ok(median(times))
}

/// Milliseconds.
fn time_of<Y: System<f64, 3>, S: Stepper>(
    fresh: &Simulation<Y, S, 3>,
    steps: u64,
) -> Result<f64, rattle::Error> {
    let mut simulation = fresh.clone();
    let clock = Instant::now();
    simulation.run(steps)?;
    Ok(1e3 * clock.elapsed().as_secs_f64())
}

fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
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
