//! What a step costs as the mesh gets fine, in CPU time of one core:
//! `cargo run --release -p rattle-flow --example cost`.
//!
//! 32 steps of the dam break, Δt in proportion to the mesh.

use rattle_flow::dam_break;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("spacing  vertices  triangles   s/step   iterations/step   to the power");
    let mut last: Option<(f64, f64)> = None;
    let finest: f64 = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(0.03);
    let mut spacing = 0.25;
    while spacing >= finest {
        let mesh = dam_break::mesh(spacing)?;
        let (vertices, triangles) = (mesh.points().len(), mesh.triangles().len());
        let depth = dam_break::depth(&mesh);
        let mut simulation = dam_break::flow(mesh).simulate(depth, spacing / 4.0)?;
        simulation.run(32)?; // the first steps, from a jump, take more iterations
        let (start, before) = (Instant::now(), simulation.iterations());
        simulation.run(32)?;
        let seconds = start.elapsed().as_secs_f64() / 32.0;
        let power = last.map(|(n, s)| (seconds / s).ln() / (vertices as f64 / n).ln());
        let power = power.map_or(String::new(), |power| format!("{power:.2}"));
        let iterations = (simulation.iterations() - before) as f64 / 32.0;
        println!("{spacing:7.4} {vertices:9} {triangles:10} {seconds:9.5} {iterations:14.1} {power:>14}");
        last = Some((vertices as f64, seconds));
        spacing *= 0.5;
    }
    Ok(())
}
