//! What accuracy costs: error against CPU time over mesh and time step, against solutions in closed form.
//!
//! ```text
//! cargo run --release -p rattle-flow --example flow_accuracy
//! ```
//!
//! Prints a table, and writes the page of the example `accuracy` and a diagram into `out/flow_accuracy`. Errors are
//! Σ M |h − exact| / Σ M exact at the end, and the part of the volume that the budget lacks. The order is that in the
//! spacing, Δt in proportion.

#[path = "../../examples/accuracy/clock.rs"]
mod clock;
#[path = "../tests/exact/mod.rs"]
mod exact;

use clock::cpu_seconds;
use exact::{UNIT, barenblatt, error, strip, wave};
use rattle::plot::{Chart, PlotError};
use rattle_flow::{Flow, Mesh, Method, Simulation};
use serde_json::{Value, json};
use std::fs;

type Failure = Box<dyn std::error::Error>;
const FOLDER: &str = "out/flow_accuracy";

/// A solution in closed form, and what computes it with so many cells in so many steps.
struct Case {
    title: &'static str,
    file: &'static str,
    duration: f64,
    /// Of the coarsest mesh; the others have twice as many, and twice as many steps, each.
    cells: usize,
    steps: [usize; 5],
    meshes: u32,
    run: fn(usize, usize) -> Result<Found, Failure>,
}

/// Errors of depth and volume.
type Found = [f64; 2];

struct Row {
    cells: usize,
    steps: usize,
    found: Found,
    /// CPU time, and half the range of repeats in parts of it.
    seconds: f64,
    spread: f64,
    order: Option<f64>,
    /// Whether nothing cheaper is as exact.
    front: bool,
}

const CASES: [Case; 3] = [
    Case {
        title: "A drop that spreads along a line (Barenblatt)",
        file: "drop_1d",
        duration: 7.0,
        cells: 50,
        steps: [5, 10, 20, 50, 200],
        meshes: 5,
        run: drop_on_a_line,
    },
    Case {
        title: "A drop that spreads on a plane (Barenblatt)",
        file: "drop_2d",
        duration: 7.0,
        cells: 8,
        steps: [3, 6, 12, 28, 56],
        meshes: 4,
        run: drop_on_a_square,
    },
    Case {
        title: "A front that runs down a dry plane",
        file: "front",
        duration: 2.0,
        cells: 40,
        steps: [10, 20, 40, 80, 160],
        meshes: 4,
        run: front_on_a_plane,
    },
];

fn main() -> Result<(), Failure> {
    fs::create_dir_all(FOLDER)?;
    let mut scenes = Vec::new();
    for case in &CASES {
        println!("\n{}\n", case.title);
        println!("1/size   steps      error  order    volume        ms");
        let rows = measured(case)?;
        diagram(case, &rows)?.save(format!("{FOLDER}/{}.svg", case.file))?;
        scenes.push(scene(case, &rows));
    }
    let data = json!({
        "processor": "Overland flow, one core", "scenes": scenes, "effects": [], "units": ["ms", "milliseconds"],
        "errors": ["depth", "volume"], "step": "Δt", "orders": [0.5, 1],
    });
    let page = include_str!("../../examples/accuracy/page.html");
    let page = page.replace("LONG RUNS", "").replace("\"DATA\"", &data.to_string());
    fs::write(format!("{FOLDER}/index.html"), page)?;
    println!("\nWritten to {FOLDER}: open index.html");
    Ok(())
}

fn measured(case: &Case) -> Result<Vec<Row>, Failure> {
    let mut rows: Vec<Row> = Vec::new();
    for mesh in 0..case.meshes {
        for steps in case.steps {
            let (cells, steps) = (case.cells << mesh, steps << mesh);
            let mut times = [0.0; 3];
            let mut found = Ok([0.0; 2]);
            for time in &mut times {
                let start = cpu_seconds();
                found = (case.run)(cells, steps);
                *time = cpu_seconds() - start;
            }
            let found = match found {
                Ok(found) => found,
                Err(why) => {
                    println!("{cells:6} {steps:7}  {why}");
                    continue;
                }
            };
            times.sort_by(f64::total_cmp);
            let [least, seconds, most] = times;
            let coarser = rows.iter().find(|row| 2 * row.cells == cells && 2 * row.steps == steps);
            let order = coarser.map(|row| (row.found[0] / found[0]).log2());
            let spread = (most - least) / (2.0 * seconds);
            let told = order.map_or(String::new(), |order| format!("{order:.2}"));
            println!(
                "{cells:6} {steps:7} {:10.3e} {told:>6} {:9.1e} {:9.1}",
                found[0],
                found[1],
                1e3 * seconds
            );
            rows.push(Row { cells, steps, found, seconds, spread, order, front: false });
        }
    }
    for i in 0..rows.len() {
        let better = |other: &Row| other.seconds < rows[i].seconds && other.found[0] <= rows[i].found[0];
        rows[i].front = !rows.iter().any(better);
    }
    Ok(rows)
}

fn scene(case: &Case, rows: &[Row]) -> Value {
    let cost = |row: &Row| 1e3 * row.seconds / case.duration;
    let mesh = |row: &Row| format!("spacing 1/{}", row.cells);
    let marks = rows.iter().map(|row| {
        json!({
            "method": mesh(row), "h": case.duration / row.steps as f64, "tolerance": null, "first": row.found[0],
            "second": row.found[1], "cost": cost(row), "spread": row.spread, "steps": row.steps, "order": row.order,
            "rounding": false, "front": row.front,
        })
    });
    let cheapest = |digits: i32| {
        let enough = rows.iter().filter(move |row| row.found[0] <= 10_f64.powi(-digits));
        enough.min_by(|a, b| a.seconds.total_cmp(&b.seconds))
    };
    let digits = (1..).map_while(|digits| Some((digits, cheapest(digits)?)));
    let digits = digits.map(|(digits, row)| {
        json!([digits, cost(row), format!("{}, Δt = {:.3}", mesh(row), case.duration / row.steps as f64)])
    });
    let digits: Vec<Value> = digits.collect();
    json!({
        "title": case.title, "file": case.file, "duration": case.duration, "pilot": case.duration,
        "rows": marks.collect::<Vec<_>>(), "digits": digits, "lanes": [], "lyapunov": null, "predictable": null,
        "floor": 0.0, "positions": true,
    })
}

fn diagram(case: &Case, rows: &[Row]) -> Result<Chart, PlotError> {
    let chart = Chart::new(case.title).x("milliseconds for a unit of time").y("error in depth").log_log();
    Ok((0..case.meshes).map(|mesh| case.cells << mesh).fold(chart, |chart, cells| {
        let own = rows.iter().filter(|row| row.cells == cells);
        let points = own.map(|row| (1e3 * row.seconds / case.duration, row.found[0]));
        chart.marked(format!("spacing 1/{cells}"), points)
    }))
}

fn found(simulation: &Simulation<impl Method>, exact: impl Fn([f64; 2]) -> f64) -> Found {
    [error(simulation, exact), simulation.budget().remainder().abs() / simulation.volume()]
}

fn drop_on_a_line(cells: usize, steps: usize) -> Result<Found, Failure> {
    let mesh = strip(cells, 1.2);
    let depth = mesh.at_vertices(|[x, _]| barenblatt(1.0, 1.5, x, 1.0));
    let mut simulation = Flow::over(mesh, UNIT).simulate(depth, 7.0 / steps as f64)?;
    simulation.run(steps)?;
    Ok(found(&simulation, |[x, _]| barenblatt(1.0, 1.5, x, 8.0)))
}

fn drop_on_a_square(cells: usize, steps: usize) -> Result<Found, Failure> {
    let mesh = Mesh::polygon(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], 1.0 / cells as f64)?;
    let depth = mesh.at_vertices(|[x, y]| barenblatt(2.0, 1.5, x.hypot(y), 1.0));
    let mut simulation = Flow::over(mesh, UNIT).simulate(depth, 7.0 / steps as f64)?;
    simulation.run(steps)?;
    Ok(found(&simulation, |[x, y]| barenblatt(2.0, 1.5, x.hypot(y), 8.0)))
}

fn front_on_a_plane(cells: usize, steps: usize) -> Result<Found, Failure> {
    let mesh = strip(cells, 4.0);
    let depth = mesh.at_vertices(|[x, _]| wave(x, 1.0));
    let flow = Flow::over(mesh, UNIT).terrain(|[x, _]| -x);
    let flow = flow.inflow(|_, t| wave(0.0, 1.0 + t), |[x, _]| x < 1e-9);
    let mut simulation = flow.simulate(depth, 2.0 / steps as f64)?;
    simulation.run(steps)?;
    Ok(found(&simulation, |[x, _]| wave(x, 3.0)))
}
