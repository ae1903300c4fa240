//! What accuracy costs: error against CPU time over mesh and time step, against solutions in closed form.
//!
//! ```text
//! cargo run --release -p rattle-flow --example flow_accuracy
//! ```
//!
//! Prints a table, and draws error over time into `out/flow_accuracy/accuracy.svg`. Error is Σ M |h − exact| / Σ M
//! exact at the end; its order is that in the spacing, Δt in proportion. Last, one mesh with shorter and shorter steps.

#[path = "../tests/exact/mod.rs"]
mod exact;

use exact::{UNIT, barenblatt, error, strip, wave};
use rattle::plot::Chart;
use rattle_flow::{Flow, Mesh};
use std::time::Instant;

type Failure = Box<dyn std::error::Error>;
/// Seconds and error.
type Point = (f64, f64);

fn main() -> Result<(), Failure> {
    println!("{:28} {:>7} {:>6} {:>10} {:>6} {:>9}", "solution", "1/size", "steps", "error", "order", "ms");
    let mut line = Vec::new();
    for cells in [50, 100, 200, 400, 800] {
        line.push(row("Barenblatt, 1-D", cells as f64, 4 * cells, line.last(), || {
            drop_on_a_line(cells, 4 * cells)
        })?);
    }
    let mut square = Vec::new();
    for cells in [8, 16, 32, 64] {
        let name = "Barenblatt, 2-D";
        square
            .push(row(name, cells as f64, 7 * cells, square.last(), || drop_on_a_square(cells, 7 * cells))?);
    }
    let mut front = Vec::new();
    for cells in [40, 80, 160, 320] {
        let name = "front on a dry plane";
        front.push(row(name, cells as f64, 2 * cells, front.last(), || front_on_a_plane(cells, 2 * cells))?);
    }
    let mut steps = Vec::new();
    for count in [25, 50, 100, 200, 400, 1600] {
        steps.push(row("Barenblatt, 1-D, 200 cells", 200.0, count, None, || drop_on_a_line(200, count))?);
    }
    let folder = std::path::Path::new("out/flow_accuracy");
    std::fs::create_dir_all(folder)?;
    let chart =
        Chart::new("Overland flow: error against time").x("seconds").y("relative error, L1").log_log();
    let chart = chart.marked("drop, 1-D", line).marked("drop, 2-D", square);
    let chart = chart.marked("front on a dry plane", front).marked("drop, 1-D: Δt alone", steps);
    chart.save(folder.join("accuracy.svg"))?;
    Ok(())
}

fn row(
    name: &str,
    size: f64,
    steps: usize,
    last: Option<&Point>,
    run: impl Fn() -> Result<f64, Failure>,
) -> Result<Point, Failure> {
    let start = Instant::now();
    let error = run()?;
    let seconds = start.elapsed().as_secs_f64();
    let order = last.map_or(String::new(), |(_, before)| format!("{:.2}", (before / error).log2()));
    println!("{name:28} {size:7} {steps:6} {error:10.3e} {order:>6} {:9.1}", 1e3 * seconds);
    Ok((seconds, error))
}

fn drop_on_a_line(cells: usize, steps: usize) -> Result<f64, Failure> {
    let mesh = strip(cells, 1.2);
    let depth = mesh.at_vertices(|[x, _]| barenblatt(1.0, 1.5, x, 1.0));
    let mut simulation = Flow::over(mesh, UNIT).simulate(depth, 7.0 / steps as f64)?;
    simulation.run(steps)?;
    Ok(error(&simulation, |[x, _]| barenblatt(1.0, 1.5, x, 8.0)))
}

fn drop_on_a_square(cells: usize, steps: usize) -> Result<f64, Failure> {
    let mesh = Mesh::polygon(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], 1.0 / cells as f64)?;
    let depth = mesh.at_vertices(|[x, y]| barenblatt(2.0, 1.5, x.hypot(y), 1.0));
    let mut simulation = Flow::over(mesh, UNIT).simulate(depth, 7.0 / steps as f64)?;
    simulation.run(steps)?;
    Ok(error(&simulation, |[x, y]| barenblatt(2.0, 1.5, x.hypot(y), 8.0)))
}

fn front_on_a_plane(cells: usize, steps: usize) -> Result<f64, Failure> {
    let mesh = strip(cells, 4.0);
    let depth = mesh.at_vertices(|[x, _]| wave(x, 1.0));
    let flow = Flow::over(mesh, UNIT).terrain(|[x, _]| -x);
    let flow = flow.inflow(|_, t| wave(0.0, 1.0 + t), |[x, _]| x < 1e-9);
    let mut simulation = flow.simulate(depth, 2.0 / steps as f64)?;
    simulation.run(steps)?;
    Ok(error(&simulation, |[x, _]| wave(x, 3.0)))
}
