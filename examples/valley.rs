//! Half an hour of rain in a valley: from a raster of heights to the hydrograph at the outlet.
//!
//! ```text
//! cargo run --release --example valley                  # then open out/valley/index.html
//! cargo run --release --example valley -- heights.asc   # heights of one's own, metres, as an ASCII grid of ESRI
//! ```
//!
//! Without a file the valley is made up: slopes towards a winding channel, a hollow that fills before it spills, and
//! some roughness. 40 mm fall in the first half hour, 10 mm/h can seep away, friction is Manning's with n = 0.05. Where
//! the southern edge is low the water leaves. `out/valley/valley.pvd` is for ParaView.

use rattle::plot::Chart;
use rattle_flow::{Flow, Page, Raster, Resistance, vtu};
use std::error::Error;
use std::fmt::Write;

const MINUTE: f64 = 60.0;
const RAIN: f64 = 0.040 / (30.0 * MINUTE);
const SOIL: f64 = 0.010 / (60.0 * MINUTE);

/// Heights in metres every 10 m, 500 m wide and 800 m long.
fn made_up() -> String {
    let mut text =
        String::from("ncols 50\nnrows 80\nxllcorner 0\nyllcorner 0\ncellsize 10\nNODATA_value -9999\n");
    for row in (0..80).rev() {
        for column in 0..50 {
            let (x, y) = (10.0 * f64::from(column) + 5.0, 10.0 * f64::from(row) + 5.0);
            let channel = 250.0 + 60.0 * (y / 130.0).sin();
            let slopes = 0.04 * y + 25.0 * (1.0 - (-((x - channel) / 180.0).powi(2)).exp());
            let hollow = 2.5 * (-((x - 330.0).powi(2) + (y - 420.0).powi(2)) / 2500.0).exp();
            let rough = 0.15 * (x * 0.11).sin() * (y * 0.07 + 1.0).cos();
            let _ = write!(text, "{:.3} ", 100.0 + slopes - hollow + rough);
        }
        text.push('\n');
    }
    text
}

fn main() -> Result<(), Box<dyn Error>> {
    let raster = match std::env::args().nth(1) {
        Some(path) => Raster::read(path)?,
        None => Raster::parse(&made_up())?,
    };
    let (mesh, heights) = raster.mesh()?;
    let area = mesh.area();
    println!("{} vertices, {:.2} km²", mesh.points().len(), 1e-6 * area);
    let south = mesh.points().iter().map(|[_, y]| *y).fold(f64::INFINITY, f64::min);
    let on_edge = |[_, y]: [f64; 2]| y < south + 1e-6;
    let edge: Vec<f64> =
        mesh.points().iter().zip(&heights).filter(|(p, _)| on_edge(**p)).map(|(_, b)| *b).collect();
    let low = edge.iter().copied().fold(f64::INFINITY, f64::min);
    let terrain = raster.clone();
    let dry = vec![0.0; mesh.points().len()];
    let flow = Flow::over(mesh, Resistance::Manning)
        .terrain(|place| raster.height(place))
        .friction(|_| 0.05)
        .rain(|_, t| if t <= 30.0 * MINUTE { RAIN } else { 0.0 })
        .infiltration(|_| SOIL)
        .outlet(0.04, move |place| on_edge(place) && terrain.height(place) < low + 10.0);
    let mut simulation = flow.simulate(dry, 1.0)?;

    let mut page = Page::new("Rain in a valley", simulation.flow())
        .caption("40 mm in half an hour; the outlet is in the south.")
        .units("m", "min")
        .lift(3.0);
    let mut series = vtu::Series::create("out/valley/valley.pvd")?;
    let (mut leaving, mut before) = (vec![(0.0, 0.0)], 0.0);
    println!(
        "minute   rain m³   seeped m³   left m³   outlet m³/s   on the land m³   unexplained m³   steps"
    );
    for minute in 1..=90 {
        let end = f64::from(minute) * MINUTE;
        simulation.run_until(end, 2e-3, 20.0)?;
        let budget = simulation.budget();
        let discharge = (budget.outflow - before) / MINUTE;
        before = budget.outflow;
        leaving.push((f64::from(minute), discharge));
        page.add(end / MINUTE, simulation.depth())?;
        if minute % 10 == 0 {
            println!(
                "{minute:6} {:9.0} {:11.0} {:9.0} {discharge:13.3} {:16.0} {:16.1e} {:7}",
                budget.rain,
                budget.infiltration,
                budget.outflow,
                budget.now,
                budget.remainder(),
                simulation.steps(),
            );
            let level: Vec<f64> = simulation.depth().iter().zip(&heights).map(|(h, b)| h + b).collect();
            let depth = [("depth", simulation.depth()), ("ground", &heights[..])];
            let flux = simulation.flux();
            series.add(end, &vtu::text(simulation.flow().mesh(), &level, &depth, &[("flux", &flux)]))?;
        }
    }
    let rain =
        [(0.0, RAIN), (30.0, RAIN), (30.0, 0.0), (90.0, 0.0)].map(|(minute, rate)| (minute, rate * area));
    Chart::new("Hydrograph")
        .x("time, min")
        .y("volume per time, m³/s")
        .line("rain on the valley", rain)
        .line("at the outlet", leaving)
        .save("out/valley/hydrograph.svg")?;
    page.write("out/valley/index.html")?;
    println!("out/valley/index.html, hydrograph.svg, valley.pvd");
    Ok(())
}
