//! A long run that can be stopped: Ctrl-C ends it after the step, and the next start goes on, bit for bit.
//!
//! ```text
//! cargo run --release --example checkpoint            # Ctrl-C, kill -9, a crash: then the same again
//! cargo run --release --example checkpoint 1000000    # so many steps
//! ```
//!
//! A particle in a heat bath on the lemniscate. Saved every second into `out/checkpoint/run.rattle`.

use rattle::checkpoint::{Ended, Saving};
use rattle::effect::Langevin;
use rattle::potentials::Gravity;
use rattle::prelude::*;
use rattle::surfaces::Lemniscate;
use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

fn main() -> Result<(), Box<dyn Error>> {
    let steps = std::env::args().nth(1).map_or(Ok(20_000_000), |steps| steps.parse())?;
    let stop = Arc::new(AtomicBool::new(false));
    let told = stop.clone();
    ctrlc::set_handler(move || told.store(true, Ordering::Relaxed))?;

    let scene = Scene::on(Lemniscate { a: 1.0, r: 1.0 / 6.0 }).with(Gravity { g: 1.0 }).with(Langevin {
        friction: 0.1,
        temperature: 0.2,
        seed: 7,
    });
    let start = State::at([0.0, 0.0, 1.0 / 6.0]).moving([1.0, 0.0, 0.0]);
    let mut simulation = scene.simulate(start, Rattle::new(0.01))?;

    let path = "out/checkpoint/run.rattle";
    let saving = Saving::to(path).every_time(Duration::from_secs(1)).until(stop);
    if saving.restore(&mut simulation)? {
        println!("going on after {} steps, from {path}", simulation.steps());
    }
    match saving.run_to(&mut simulation, steps)? {
        Ended::Done => {
            println!("{} steps, q = {:?}", simulation.steps(), simulation.position());
            println!("{}", simulation.bill()?);
            println!("to begin anew, remove {path}");
        }
        Ended::Stopped => {
            println!("stopped after {} of {steps} steps, saved in {path}", simulation.steps());
            println!("to go on: cargo run --release --example checkpoint {steps}");
        }
    }
    Ok(())
}
