//! What a step costs as the mesh gets fine, in CPU time of one core:
//! `cargo run --release -p rattle-flow --example cost`.
//!
//! 32 steps of the dam break after 32 others, Δt in proportion to the mesh; the finest spacing may be given: 0.0055 has
//! 10⁶ triangles. Spacings are halved, and the last is the one given. With a number of threads behind it, seconds are
//! those of the clock: `… --example cost 0.0156 2`.

use rattle_flow::dam_break;
use std::env::args;
use std::error::Error;
use std::time::Instant;

type Failure = Box<dyn Error + Send + Sync>;

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = args().skip(1).collect();
    let finest = arguments.first().map_or(Ok(0.03), |text| text.parse())?;
    match arguments.get(1) {
        None => costs(finest, cpu_seconds),
        Some(text) => {
            let start = Instant::now();
            let threads = rayon::ThreadPoolBuilder::new().num_threads(text.parse()?).build()?;
            threads.install(|| costs(finest, || start.elapsed().as_secs_f64()))
        }
    }
}

fn costs(finest: f64, seconds: impl Fn() -> f64) -> Result<(), Failure> {
    println!("spacing  vertices  triangles   s/step   steps/s  iterations/step   to the power");
    let mut last: Option<(f64, f64)> = None;
    let mut spacing = 0.25;
    loop {
        let mesh = dam_break::mesh(spacing)?;
        let (vertices, triangles) = (mesh.points().len(), mesh.triangles().len());
        let depth = dam_break::depth(&mesh);
        let mut simulation = dam_break::flow(mesh).simulate(depth, spacing / 4.0)?;
        simulation.run(32)?; // the first steps, from a jump, take more iterations
        let (start, before) = (seconds(), simulation.iterations());
        simulation.run(32)?;
        let seconds = (seconds() - start) / 32.0;
        let power = last.map(|(n, s)| (seconds / s).ln() / (vertices as f64 / n).ln());
        let power = power.map_or(String::new(), |power| format!("{power:.2}"));
        let iterations = (simulation.iterations() - before) as f64 / 32.0;
        println!(
            "{spacing:7.4} {vertices:9} {triangles:10} {seconds:9.5} {:9.2} {iterations:14.1} {power:>14}",
            1.0 / seconds
        );
        last = Some((vertices as f64, seconds));
        if spacing <= finest {
            break;
        }
        spacing = (0.5 * spacing).max(finest);
    }
    Ok(())
}

/// CPU time of the process, which other programs on the machine do not lengthen.
fn cpu_seconds() -> f64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}
