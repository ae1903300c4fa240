//! What accuracy costs in time: error against time for every family of methods, in eleven scenes.
//!
//! ```text
//! cargo run --release --example accuracy                # 10 s for each scene; `-- 2` for 2 s
//! cargo run --release --example accuracy -- forecasts   # 50 runs, each against its forecast
//! cargo run --release --example accuracy -- wishes      # 1e-4 to 1e-11 in the gas and in phase space
//! cargo run --release --example accuracy -- long        # what rounding does to the energy, alone; `-- long 1e9` goes on
//! ```
//!
//! Prints tables, and writes into `out/accuracy` for each scene a diagram and all numbers (`torus.svg`, `torus.csv`),
//! and one page with all of them (`index.html`), on which the pointer tells method, step, error and cost. Times are
//! those of one core for this program alone, whatever else the machine does. Where a solution with 30 digits is known,
//! what the wish for 1e-8 gives is compared with it.

mod clock;
mod effects;
mod long;
mod page;
mod wishes;

use indicatif::{ProgressBar, ProgressStyle};
use rattle::bodies::Count;
use rattle::effect::Effects;
use rattle::links::planar::{Rod, Slider};
use rattle::nalgebra::Matrix3;
use rattle::plot::Chart;
use rattle::potentials::{Gravity, Ricker, planar};
use rattle::prelude::*;
use rattle::price::{Candidate, Clock, Price, Prices, Pricing};
use rattle::scene::Hold;
use rattle::surfaces::{Lemniscate, Sphere, TorusByDistance};
use std::error::Error;
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_6};
use std::fs;

const FOLDER: &str = "out/accuracy";
/// Colours of a chart.
const CURVES: usize = 6;
/// Solutions with 30 digits of the Hopf pendulum.
const HOPF: &str = include_str!("../../tests/data/hopf_pendulum.csv");
/// Between particles of the gas.
const RICKER: Ricker = Ricker { depth: 0.5, radius: 1.0 / 6.0 };
/// Steps of long runs.
const STEPS: f64 = 1e7;
/// Trajectories beside the one that is priced in lanes.
const LANES: u32 = 255;
/// What the list of digits looks for, and the wish that is checked.
const WISH: f64 = 1e-8;

constraint! {
    /// A rod about the origin.
    struct Pendulum { length }
    |x, y| x^2 + y^2 - length^2
}

phase_constraint! {
    /// The three-sphere of phase space.
    struct Hopf {}
    |q: [f64; 2], p: [f64; 2]| dot(q, q) + dot(p, p) - 1
}

hamiltonian! {
    /// A unit mass that falls along −y.
    struct Falling { g }
    |q: [f64; 2], p: [f64; 2]| dot(p, p) / 2 + g * q[1]
}

potential! {
    /// Weight of a body whose centre of mass lies on its third axis.
    struct Top { weight }
    |q: [[f64; 3]; 3]| weight * q[2][2]
}

/// A scene that was priced.
struct Report {
    file: &'static str,
    title: &'static str,
    prices: Prices,
}

fn main() -> Result<(), Box<dyn Error>> {
    let asked = std::env::args().nth(1);
    match asked.as_deref() {
        Some("forecasts") => return forecasts(),
        Some("wishes") => return wishes_by_the_clock(),
        _ => {}
    }
    fs::create_dir_all(FOLDER)?;
    if asked.as_deref() == Some("long") {
        let steps = std::env::args().nth(2).map_or(Ok(STEPS), |text| text.parse())?;
        return long_runs(steps).map(drop);
    }
    let budget = asked.map_or(Ok(10.0), |text| text.parse())?;
    println!("on {}, one core, {budget} s for each scene", processor());
    let mut all = Vec::new();
    let mut price = |report: Report| -> Result<(), Box<dyn Error>> {
        println!("\n{}\n\n{:#}", report.title, report.prices);
        draw(&report)?;
        fs::write(format!("{FOLDER}/{}.csv", report.file), report.prices.csv())?;
        all.push(report);
        Ok(())
    };

    let lemniscate = Lemniscate { a: 1.0, r: 1.0 / 6.0 };
    let scene = Scene::on(lemniscate).with(Gravity { g: 1.0 });
    let start = State::at([0.0, 0.0, 1.0 / 6.0]).moving([FRAC_1_SQRT_2, FRAC_1_SQRT_2.next_down(), 0.0]);
    let others: Vec<_> = (1..=LANES).map(|i| State::at([0.0, 0.0, 1.0 / 6.0]).moving(around(i))).collect();
    let title = "A billiard on a surface of genus two under gravity";
    price(measured("lemniscate", title, scene.price(&start, 5.0).side_by_side(others), 2.0 * budget)?)?;
    let having = [("theta_deg", "45"), ("ic", "f64"), ("t", "5.0")];
    let exact = row(include_str!("../../tests/data/lemniscate_gravity.csv"), &having, &["x", "y", "z"])?;
    check(&scene, &start, 5.0, budget, &exact)?;

    let gas = Scene::on(lemniscate).bodies(21).with(RICKER);
    price(measured("gas", "A gas of 21 particles on it", gas.price(&crowd(&gas)?, 1.0), budget)?)?;

    let scene = Scene::on(TorusByDistance { major: 1.0, minor: 0.3 });
    let start = State::at([1.3, 0.0, 0.0]).moving([0.0, FRAC_PI_6.cos(), FRAC_PI_6.sin()]);
    price(measured("torus", "A geodesic on a torus", scene.price(&start, 5.0), budget)?)?;
    let having = [("case", "30deg"), ("t", "5")];
    let exact = row(include_str!("../../tests/data/torus_geodesic.csv"), &having, &["x", "y", "z"])?;
    check(&scene, &start, 5.0, budget, &exact)?;

    let scene = Scene::on(Sphere { r: 2.0 });
    let start = State::at([2.0, 0.0, 0.0]).moving([0.0, 0.6, 0.8]);
    price(measured("sphere", "A great circle on a sphere", scene.price(&start, 5.0), budget)?)?;
    let (sin, cos) = 2.5_f64.sin_cos();
    check(&scene, &start, 5.0, budget, &[2.0 * cos, 1.2 * sin, 1.6 * sin])?;

    let scene = Scene::on(Pendulum { length: 1.0 }).with(planar::Gravity { g: 1.0 });
    price(measured("pendulum", "A pendulum from 90°", scene.price(&State::at([1.0, 0.0]), 5.0), budget)?)?;
    let having = [("theta0", "pi/2"), ("t", "5")];
    let exact = row(include_str!("../../tests/data/planar_pendulum.csv"), &having, &["x", "y"])?;
    check(&scene, &State::at([1.0, 0.0]), 5.0, budget, &exact)?;

    let double = Scene::points(3).link(Rod { length: 1.0 }, [[0, 1], [1, 2]]).pin(0, [0.0; 2]);
    let double = double.with(planar::Gravity { g: 1.0 });
    let start = State::of([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
    let others: Vec<_> = (1..=LANES).map(|i| bent(around(i))).collect();
    let pricing = double.price(&start, 5.0).side_by_side(others);
    price(measured("double_pendulum", "A double pendulum", pricing, 2.0 * budget)?)?;
    let columns = ["x1", "y1", "x2", "y2"];
    let exact = row(include_str!("../../tests/data/double_pendulum.csv"), &[("t", "5")], &columns)?;
    check(&double, &start, 5.0, budget, &exact)?;

    let chain = Scene::points(101).link(Rod { length: 0.01 }, (0..100).map(|i| [i, i + 1])).pin(0, [0.0; 2]);
    let chain = chain.with(planar::Gravity { g: 1.0 });
    let straight = State::of((0..=100).map(|i| [0.008 * f64::from(i), -0.006 * f64::from(i)]));
    price(measured("chain", "A chain of 100 links that swings", chain.price(&straight, 1.0), budget)?)?;

    let crank = Scene::points(3)
        .link(Rod { length: 1.0 }, [[0, 1]])
        .link(Rod { length: 2.0 }, [[1, 2]])
        .link(Slider { point: [0.0; 2], direction: [1.0, 0.0] }, [[2]])
        .pin(0, [0.0; 2])
        .with(planar::Gravity { g: 1.0 });
    let start = crank.project(&State::of([[0.0, 0.0], [0.6, 0.8], [2.43, 0.0]]).with_momenta([
        [0.0, 0.0],
        [0.8, -0.6],
        [0.0, 0.0],
    ]))?;
    price(measured("slider_crank", "A slider and its crank", crank.price(&start, 5.0), budget)?)?;

    let body = Rigid::new([0.6, 0.8, 1.0]);
    let free = Scene::rigid(body);
    let start = Rigid::start(&Matrix3::identity(), &[1.8, 0.4, -0.9].into());
    price(measured("free_body", "A free rigid body", free.price(&start, 5.0), budget)?)?;
    let top = Scene::rigid(body).with(Top { weight: 1.0 });
    let others = (1..=LANES).map(|i| Rigid::start(&Matrix3::identity(), &around(i).into()));
    let pricing = top.price(&start, 5.0).side_by_side(others);
    price(measured("heavy_body", "A heavy rigid body", pricing, 2.0 * budget)?)?;

    let hopf = Scene::in_phase_space(Hopf {}, Falling { g: 0.3 });
    let start = hopf.project(&on_fibres()?)?;
    price(measured("hopf", "The Hopf pendulum, in phase space", hopf.price(&start, 5.0), budget)?)?;
    let exact = row(HOPF, &[("start", "B"), ("t", "5.0")], &["q1", "q2"])?;
    check(&hopf, &start, 5.0, budget, &exact)?;

    let chart = long_runs(STEPS)?;
    let costs = effects::costs()?;
    println!("\nEffects: nanoseconds of a step of RATTLE on the surface of genus two, of one body");
    costs.iter().for_each(|(effects, ns)| println!("{effects:44} {ns:6.1}"));
    let page = page::page(&all, &costs, &processor(), &chart.to_svg()?)?;
    fs::write(format!("{FOLDER}/index.html"), page)?;
    println!("\nWritten to {FOLDER}: open index.html");
    Ok(())
}

/// Long runs of so many steps, as a diagram; prints what they cost.
fn long_runs(steps: f64) -> Result<Chart, Box<dyn Error>> {
    let runs = long::runs(steps)?;
    let chart = long::chart(&runs);
    chart.save(format!("{FOLDER}/long_runs.svg"))?;
    println!("\nLong runs: nanoseconds of a step, and the error of the energy after {steps:.0e} steps");
    for run in &runs {
        println!(
            "{:24} {:6.1} {:9.1e}",
            run.numbers,
            run.ns,
            run.errors.last().map_or(f64::NAN, |end| end.1)
        );
    }
    Ok(chart)
}

fn measured<C: Hold<D>, E: Effects<D>, N: Count, const D: usize>(
    file: &'static str,
    title: &'static str,
    pricing: Pricing<'_, C, E, N, D>,
    budget: f64,
) -> Result<Report, rattle::Error> {
    let style = ProgressStyle::with_template("{msg:24} {bar:40} {elapsed}").expect("a template");
    let bar = ProgressBar::new(1000).with_style(style).with_message(file);
    let pricing = pricing.budget(budget).clock(Clock::of(clock::cpu_seconds));
    let prices = pricing.progress(|part| bar.set_position((1000.0 * part) as u64)).measure()?;
    bar.finish_and_clear();
    Ok(Report { file, title, prices })
}

/// What a wish gives, against an exact solution of the bodies that come last.
fn check<C: Hold<D>, E: Effects<D>, N: Count, const D: usize>(
    scene: &Scene<C, E, N, D>,
    start: &State<D>,
    duration: f64,
    budget: f64,
    exact: &[f64],
) -> Result<(), Box<dyn Error>> {
    let mut planned = scene
        .within(WISH)
        .budget(0.1 * budget)
        .clock(Clock::of(clock::cpu_seconds))
        .simulate(start, duration)?;
    println!("within {WISH:e}: {planned}");
    let spent = planned.run()?;
    let found: Vec<f64> = planned.simulation.positions().flat_map(<[f64; D]>::from).collect();
    let found = &found[found.len() - exact.len()..];
    let off = found.iter().zip(exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("it took {spent}, and is {off:.1e} off the exact solution");
    Ok(())
}

/// Wishes in the scenes of which no evaluations are counted.
fn wishes_by_the_clock() -> Result<(), Box<dyn Error>> {
    let gas = Scene::on(Lemniscate { a: 1.0, r: 1.0 / 6.0 }).bodies(21).with(RICKER);
    wishes::wishes("A gas of 21 particles", &gas, &crowd(&gas)?, 1.0, 4000)?;
    let hopf = Scene::in_phase_space(Hopf {}, Falling { g: 0.3 });
    wishes::wishes("The Hopf pendulum", &hopf, &hopf.project(&on_fibres()?)?, 5.0, 400)
}

/// A start of the Hopf pendulum, rounded.
fn on_fibres() -> Result<State<2>, Box<dyn Error>> {
    let numbers = row(HOPF, &[("start", "B"), ("t", "0.0")], &["q1", "q2", "p1", "p2"])?;
    Ok(State::at([numbers[0], numbers[1]]).moving([numbers[2], numbers[3]]))
}

/// How long runs take, over what was forecast: the distribution.
fn forecasts() -> Result<(), Box<dyn Error>> {
    let scene = Scene::on(Lemniscate { a: 1.0, r: 1.0 / 6.0 }).with(Gravity { g: 1.0 });
    let start = State::at([0.0, 0.0, 1.0 / 6.0]).moving([FRAC_1_SQRT_2, FRAC_1_SQRT_2.next_down(), 0.0]);
    let mut ratios = Vec::new();
    for number in 0..50 {
        let wish = [1e-3, 1e-5, 1e-6, 1e-8, 1e-9][number % 5];
        let wished = scene.within(wish).in_energy().budget(1.0).clock(Clock::of(clock::cpu_seconds));
        let mut planned = wished.simulate(&start, 200.0)?;
        let spent = planned.run()?;
        println!("{wish:7.0e} {planned}: {spent}");
        ratios.push(spent.seconds / spent.expected);
    }
    ratios.sort_by(f64::total_cmp);
    let at = |part: usize| ratios[(ratios.len() - 1) * part / 10];
    println!("\ntook, over what was forecast, on {}, one core, of 50 runs:", processor());
    println!(
        "least {:.2}, a tenth below {:.2}, median {:.2}, nine tenths below {:.2}, most {:.2}",
        at(0),
        at(1),
        at(5),
        at(9),
        at(10)
    );
    let near = ratios.iter().filter(|&&ratio| (ratio - 1.0).abs() <= 0.15).count();
    println!("{near} within 15 %");
    Ok(())
}

/// Directions all around, for the trajectories side by side.
fn around(number: u32) -> [f64; 3] {
    let (sin, cos) = (f64::from(number) * std::f64::consts::TAU / f64::from(LANES + 1)).sin_cos();
    [cos, sin, 0.0]
}

/// A double pendulum at rest, its second rod in this direction.
fn bent([x, y, _]: [f64; 3]) -> State<2> {
    State::of([[0.0, 0.0], [1.0, 0.0], [1.0 + x, y]])
}

/// Twenty-one bodies at rest, apart from each other.
fn crowd<C: Hold<3>, E: Effects<3>, N: Count>(scene: &Scene<C, E, N, 3>) -> Result<State<3>, rattle::Error> {
    let places = (0..21).map(|i| {
        let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 21.0).sin_cos();
        // Along the lemniscate, above and below in turn.
        let d = 1.0 + sin * sin;
        [cos / d, sin * cos / d + 0.01, if i % 2 == 0 { 0.15 } else { -0.15 }]
    });
    scene.project(&State::of(places))
}

/// Error over time of the methods that have most of the front: of simulations, and of trajectories side by side.
fn draw(report: &Report) -> Result<(), rattle::plot::PlotError> {
    let Report { file, title, prices } = report;
    diagram(title, prices, false)?.save(format!("{FOLDER}/{file}.svg"))?;
    if prices.digits_in_lanes().is_empty() {
        return Ok(());
    }
    diagram(&format!("{title}: one of {} side by side", LANES + 1), prices, true)?
        .save(format!("{FOLDER}/{file}_in_lanes.svg"))
}

fn diagram(title: &str, prices: &Prices, lanes: bool) -> Result<Chart, rattle::plot::PlotError> {
    let told = prices.tells_positions();
    let what = if told { "error in position" } else { "error in energy" };
    let point =
        |row: &&Price| (1e9 * row.seconds, if told { row.position } else { None }.unwrap_or(row.energy));
    let rows = || prices.rows.iter().filter(|row| row.method.is_in_lanes() == lanes && point(row).1 > 0.0);
    let mut methods: Vec<_> =
        prices.methods().into_iter().filter(|method| rows().any(|row| row.method == *method)).collect();
    let most = |method: &Candidate| rows().filter(|row| row.method == *method && row.front).count();
    methods.sort_by_key(|method| std::cmp::Reverse(most(method)));
    methods.truncate(CURVES);
    let mut chart =
        Chart::new(title).x("nanoseconds for a unit of simulated time, one core").y(what).log_log();
    for method in methods {
        chart = chart
            .marked(method.to_string(), rows().filter(|row| row.method == method).map(|row| point(&row)));
    }
    chart =
        chart.points("nothing cheaper is as exact", rows().filter(|row| row.front).map(|row| point(&row)));
    let [fastest, slowest] = [f64::min, f64::max].map(|of| rows().map(|row| point(&row).0).reduce(of));
    let floor = prices.reference_error.max(prices.rounding);
    if let (Some(fastest), Some(slowest), true) = (fastest, slowest, told && floor > 0.0) {
        chart = chart.line("known no better", [(fastest, floor), (slowest, floor)]);
    }
    Ok(chart)
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

/// The processor's name, where the system tells it.
fn processor() -> String {
    let told = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = told.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    name.map_or_else(|| std::env::consts::ARCH.into(), |(_, name)| name.trim().into())
}
