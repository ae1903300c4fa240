//! What accuracy costs in time: error against time for RATTLE, compositions of it, Lobatto methods, and methods without
//! structure.
//!
//! ```text
//! cargo run --release --example accuracy
//! ```
//!
//! The billiard under gravity at θ = 45° until t = 5, against a reference with 30 digits. Prints a table, and
//! draws error over time into `out/accuracy/accuracy.svg`. Then a torus, a pendulum and a double pendulum in short.

use rattle::Counted;
use rattle::bodies::{Count, One};
use rattle::composition::KAHAN_LI_1997_ORDER_8;
use rattle::effect::Effects;
use rattle::links::planar::Rod;
use rattle::plot::Chart;
use rattle::potentials::{Gravity, planar};
use rattle::prelude::*;
use rattle::scene::Hold;
use rattle::surfaces::{Lemniscate, TorusByDistance};
use rattle::system::System;
use std::error::Error;
use std::f64::consts::FRAC_1_SQRT_2;
use std::time::Instant;

const SURFACE: Lemniscate = Lemniscate { a: 1.0, r: 1.0 / 6.0 };
const GRAVITY: Gravity = Gravity { g: 1.0 };
const T: f64 = 5.0;
/// Each time is the median of this many runs.
const RUNS: usize = 15;

fn main() -> Result<(), Box<dyn Error>> {
    let exact = reference()?;
    let kahan_li = |h| Composition::new(KAHAN_LI_1997_ORDER_8, h);
    let methods: [(&str, Vec<Point>); 10] = [
        ("RATTLE, order 2", measure(Rattle::new, 0.02, exact)?),
        ("Suzuki, order 4", measure(|h| Composition::new(SUZUKI_1990_ORDER_4, h), 0.02, exact)?),
        ("Kahan–Li, order 8", measure(kahan_li, 0.04, exact)?),
        ("Lobatto, order 4", measure(Lobatto::<3>::new, 0.05, exact)?),
        ("Lobatto, order 8", measure(Lobatto::<5>::new, 0.05, exact)?),
        ("Lobatto 8, extrapolated", measure(|h| Lobatto::<5>::new(h).guess(Extrapolated), 0.05, exact)?),
        ("Lobatto, order 16", measure(Lobatto::<9>::new, 0.1, exact)?),
        ("DOP853", measure(Dop853::new, 0.05, exact)?),
        ("DOP853, adaptive", measure_tolerances(|tolerance| Dop853::adaptive(T, tolerance), exact)?),
        ("Taylor, adaptive", measure_tolerances(|tolerance| Taylor::adaptive(18, T, tolerance), exact)?),
    ];
    println!(
        "billiard at θ = 45° until t = {T}; time is the median of {RUNS} runs, evaluations are per run\n"
    );
    for (name, points) in &methods {
        println!(
            "{name:23} {:>9} {:>10} {:>7} {:>9} {:>9} {:>9} {:>9}",
            if name.contains("adaptive") { "tolerance" } else { "h" },
            "error",
            "order",
            "ms",
            "g",
            "∇g",
            "∇U"
        );
        let mut last: Option<&Point> = None;
        for point in points {
            let last_of_steps = last.filter(|_| !name.contains("adaptive"));
            let order = last_of_steps.map_or(String::new(), |last| {
                format!("{:.2}", (last.error / point.error).ln() / (last.h / point.h).ln())
            });
            println!(
                "{:23} {:9.1e} {:10.2e} {order:>7} {:9.3} {:9} {:9} {:9}",
                "", point.h, point.error, point.milliseconds, point.values, point.gradients, point.forces
            );
            last = Some(point);
        }
    }

    println!("\nmilliseconds to an error of      1e-4     1e-6     1e-8    1e-10    1e-12");
    for (name, points) in &methods {
        print_times(name, points);
    }
    let steps = |method: usize| steps_to(&methods[method].1, 1e-8);
    if let (Some(composed), Some(pure), Some(extrapolated)) = (steps(2), steps(4), steps(5)) {
        let (mut over_pure, mut over_extrapolated) = (Vec::new(), Vec::new());
        let composed = run_of(composed, kahan_li)?;
        let pure = run_of(pure, Lobatto::<5>::new)?;
        let extrapolated = run_of(extrapolated, |h| Lobatto::<5>::new(h).guess(Extrapolated))?;
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
    // The chart has seven colours.
    let drawn =
        methods.iter().filter(|(name, _)| !["Lobatto, order 4", "Suzuki, order 4", "DOP853"].contains(name));
    for (name, points) in drawn {
        chart = chart.marked(*name, points.iter().map(|p| (p.milliseconds, p.error)));
    }
    chart.save("out/accuracy/accuracy.svg")?;
    println!("\nWritten to out/accuracy/accuracy.svg");
    others()
}

fn print_times(name: &str, points: &[Point]) {
    let times =
        [1e-4, 1e-6, 1e-8, 1e-10, 1e-12].map(|error| match (time_to(points, error), points.first()) {
            (Some(time), _) => format!("{time:8.3}"),
            (None, Some(first)) if first.error < error => {
                format!("{:>8}", format!("<{:.3}", first.milliseconds))
            }
            _ => "       –".into(),
        });
    println!("{name:28} {}", times.join(" "));
}

constraint! {
    /// A rod about the origin.
    struct Pendulum { length }
    |x, y| x^2 + y^2 - length^2
}

/// Three more systems at t = 5, in short.
fn others() -> Result<(), Box<dyn Error>> {
    let angle = std::f64::consts::FRAC_PI_6;
    let along = State::at([1.3, 0.0, 0.0]).moving([0.0, angle.cos(), angle.sin()]);
    let exact = row(include_str!("../tests/data/torus_geodesic.csv"), &[("t", "5")], &["x", "y", "z"])?;
    let torus = Scene::on(TorusByDistance { major: 1.0, minor: 0.3 });
    println!(
        "\na geodesic on a torus until t = {T}: milliseconds to an error as above, < at the longest step"
    );
    structured(&torus, &along, &exact, 0.1)?;

    let exact = row(
        include_str!("../tests/data/planar_pendulum.csv"),
        &[("theta0", "pi/2"), ("t", "5")],
        &["x", "y"],
    )?;
    let pendulum = Scene::on(Pendulum { length: 1.0 }).with(planar::Gravity { g: 1.0 });
    let start = State::at([1.0, 0.0]);
    println!("\na pendulum from 90° until t = {T}");
    structured(&pendulum, &start, &exact, 0.2)?;

    let columns = ["x1", "y1", "x2", "y2"];
    let exact = row(include_str!("../tests/data/double_pendulum.csv"), &[("t", "5")], &columns)?;
    let double = Scene::points(3).link(Rod { length: 1.0 }, [[0, 1], [1, 2]]).pin(0, [0.0; 2]);
    println!("\na double pendulum until t = {T}");
    let start = State::of([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
    structured(&double.with(planar::Gravity { g: 1.0 }), &start, &exact, 0.1)
}

/// Prints a line for each method that moves every system.
fn structured<C: Hold<D>, E: Effects<D>, N: Count, const D: usize>(
    scene: &Scene<C, E, N, D>,
    start: &State<D>,
    exact: &[f64],
    longest: f64,
) -> Result<(), Box<dyn Error>> {
    let kahan_li = |h| Composition::new(KAHAN_LI_1997_ORDER_8, h);
    let suzuki = |h| Composition::new(SUZUKI_1990_ORDER_4, h);
    print_times("RATTLE, order 2", &steps(scene, start, exact, 0.2 * longest, Rattle::new));
    print_times("Suzuki, order 4", &steps(scene, start, exact, longest, suzuki));
    print_times("Kahan–Li, order 8", &steps(scene, start, exact, longest, kahan_li));
    print_times("Lobatto, order 4", &steps(scene, start, exact, longest, Lobatto::<3>::new));
    print_times("Lobatto, order 8", &steps(scene, start, exact, 2.0 * longest, Lobatto::<5>::new));
    print_times("Lobatto, order 16", &steps(scene, start, exact, 5.0 * longest, Lobatto::<9>::new));
    print_times("DOP853", &steps(scene, start, exact, 4.0 * longest, Dop853::new));
    print_times("DOP853, adaptive", &tolerances(scene, start, exact, |x| Dop853::adaptive(T, x))?);
    print_times("Taylor, adaptive", &tolerances(scene, start, exact, |x| Taylor::adaptive(18, T, x))?);
    Ok(())
}

/// Error and time from the longest step to a thirty-second of it; steps that are too long are left out.
fn steps<C: Hold<D>, E: Effects<D>, N: Count, S: Method, const D: usize>(
    scene: &Scene<C, E, N, D>,
    start: &State<D>,
    exact: &[f64],
    longest: f64,
    method: impl Fn(f64) -> S,
) -> Vec<Point> {
    let steps = (0..11).map(|shorter| (T / longest * 2_f64.powf(0.5 * f64::from(shorter))).round());
    steps.filter_map(|n| point(scene, start, exact, T / n, method(T / n)).ok()).collect()
}

/// Error and time with tolerances of 1e-2 to 1e-15.
fn tolerances<C: Hold<D>, E: Effects<D>, N: Count, S: Method, const D: usize>(
    scene: &Scene<C, E, N, D>,
    start: &State<D>,
    exact: &[f64],
    method: impl Fn(f64) -> S,
) -> Result<Vec<Point>, rattle::Error> {
    (2..16)
        .map(|digits| {
            let tolerance = 10_f64.powi(-digits);
            point(scene, start, exact, tolerance, method(tolerance))
        })
        .collect()
}

fn point<C: Hold<D>, E: Effects<D>, N: Count, const D: usize>(
    scene: &Scene<C, E, N, D>,
    start: &State<D>,
    exact: &[f64],
    h: f64,
    method: impl Method,
) -> Result<Point, rattle::Error> {
    let steps = (T / method.step_size()).round() as u64;
    let fresh = scene.simulate(start.clone(), method)?;
    let mut run = fresh.clone();
    run.run(steps)?;
    let found: Vec<f64> = run.positions().flat_map(<[f64; D]>::from).collect();
    let moving = &found[found.len() - exact.len()..]; // pinned bodies come first
    let error = moving.iter().zip(exact).map(|(q, exact)| (q - exact).abs()).fold(0.0, f64::max);
    let milliseconds = median_time(&fresh, steps)?;
    Ok(Point { h, error, milliseconds, values: 0, gradients: 0, forces: 0 })
}

/// The numbers of the first row with these texts.
fn row(table: &str, having: &[(&str, &str)], wanted: &[&str]) -> Result<Vec<f64>, Box<dyn Error>> {
    let mut table = csv::Reader::from_reader(table.as_bytes());
    let columns = table.headers()?.clone();
    for row in table.records() {
        let row = row?;
        let text = |name: &str| columns.iter().position(|column| column == name).map_or("", |i| &row[i]);
        if having.iter().all(|&(name, value)| text(name) == value) {
            return Ok(wanted.iter().map(|name| text(name).parse()).collect::<Result<_, _>>()?);
        }
    }
    Err(format!("no row has {having:?}").into())
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
fn run_of<S: Method>(
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

/// From the longest step down, by halves and their halves, to the rounding floor or to the last rung.
fn measure<S: Method>(
    method: impl Fn(f64) -> S,
    longest: f64,
    exact: [f64; 3],
) -> Result<Vec<Point>, rattle::Error> {
    let rungs = 0..if method(longest).order() < 8 { 11 } else { 9 };
    let steps = rungs.map(|shorter| (T / longest * 2_f64.powf(0.5 * f64::from(shorter))).round());
    steps.map(|steps| counted(T / steps, method(T / steps), exact)).collect()
}

/// With tolerances of 1e-2 to 1e-15, one step to the end.
fn measure_tolerances<S: Method>(
    method: impl Fn(f64) -> S,
    exact: [f64; 3],
) -> Result<Vec<Point>, rattle::Error> {
    let tolerances = (2..16).map(|digits| 10_f64.powi(-digits));
    tolerances.map(|tolerance| counted(tolerance, method(tolerance), exact)).collect()
}

/// One run of the billiard, with what it evaluates.
fn counted(h: f64, method: impl Method, exact: [f64; 3]) -> Result<Point, rattle::Error> {
    let steps = (T / method.step_size()).round() as u64;
    let (surface, gravity) = (Counted::new(SURFACE), Counted::new(GRAVITY));
    let (on_surface, on_gravity) = (surface.counts(), gravity.counts());
    let mut counted = Scene::on(surface).with(gravity).simulate(start(), method.clone())?;
    counted.run(steps)?;

    let fresh = Scene::on(SURFACE).with(GRAVITY).simulate(start(), method)?;
    Ok(Point {
        h,
        error: error(&counted, exact),
        milliseconds: median_time(&fresh, steps)?,
        values: on_surface.values(),
        gradients: on_surface.gradients(),
        forces: on_gravity.gradients(),
    })
}

/// cos and sin of 45° as the reference has them, rounded from the rounded angle.
fn start() -> State<3> {
    State::at([0.0, 0.0, SURFACE.r]).moving([FRAC_1_SQRT_2, FRAC_1_SQRT_2.next_down(), 0.0])
}

fn error<Y: System<f64, 3, Count = One>, S: Method>(
    simulation: &Simulation<Y, S, 3>,
    exact: [f64; 3],
) -> f64 {
    simulation.position().iter().zip(exact).map(|(q, exact)| (q - exact).abs()).fold(0.0, f64::max)
}

fn median_time<Y: System<f64, D>, S: Method, const D: usize>(
    fresh: &Simulation<Y, S, D>,
    steps: u64,
) -> Result<f64, rattle::Error> {
    let mut times = Vec::with_capacity(RUNS);
    for _ in 0..RUNS {
        times.push(time_of(fresh, steps)?);
    }
    Ok(median(times))
}

/// Milliseconds.
fn time_of<Y: System<f64, D>, S: Method, const D: usize>(
    fresh: &Simulation<Y, S, D>,
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
    let having = [("theta_deg", "45"), ("ic", "f64"), ("t", "5.0")];
    let found = row(include_str!("../tests/data/lemniscate_gravity.csv"), &having, &["x", "y", "z"])?;
    Ok(std::array::from_fn(|i| found[i]))
}
