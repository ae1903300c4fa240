//! A Furuta pendulum: a motor turns an arm about the vertical, and swings up the pendulum that hangs on its end.
//!
//! ```text
//! cargo run --release --example furuta
//! |a|² = l², a_z = 0        the arm
//! |b − a|² = l²             the pendulum
//! (b − a)·a = 0             its axle points along the arm
//! ```
//!
//! The motor pushes against the pendulum's velocity s along the way of the arm's end, while its energy E is less than
//! that of standing upright (K. J. Åström, K. Furuta 2000). All work is the motor's, less what its bearing takes.
//!
//! Writes the page `out/furuta/index.html`.

use rattle::links::Rod;
use rattle::nalgebra::Vector3;
use rattle::potentials::weights;
use rattle::prelude::*;
use rattle::view::{Page, Scene3};
use std::error::Error;

constraint! {
    /// The arm turns in the plane z = 0, and the pendulum in that across the arm.
    struct Axles {}
    |a: [f64; 3], b: [f64; 3]| [a[2], dot(b - a, a)]
}

force! {
    /// A motor that pushes the arm's end until the pendulum has the energy that it has upright.
    struct Motor { gain, limit, friction, g, length }
    |a: [f64; 3], b: [f64; 3], va: [f64; 3], vb: [f64; 3]| {
        let way = [-a[1], a[0], 0] / norm(a);
        let swing = dot(vb - va, way);
        let energy = (swing^2 + (vb[2] - va[2])^2) / 2 + g * (b[2] - a[2]);
        let push = limit * tanh(gain * (g * length - energy) * swing);
        [-(push + friction * dot(va, way)) * way, 0 * vb]
    }
}

const G: f64 = 9.81;
const LENGTH: f64 = 0.5;

fn main() -> Result<(), Box<dyn Error>> {
    let masses = [1.0, 1.0, 0.1];
    let motor = Motor { gain: 20.0, limit: 4.0, friction: 0.3, g: G, length: LENGTH };
    let scene = Scene::points(3)
        .link(Rod { length: LENGTH }, [[0, 1], [1, 2]])
        .link(Axles {}, [[1, 2]])
        .pin(0, [0.0; 3])
        .masses(masses)
        .with(weights(G, masses))
        .with(motor.over([[1, 2]]));
    let hanging = [[0.0; 3], [LENGTH, 0.0, 0.0], [LENGTH, 0.01, -LENGTH]];
    let start = scene.project(&State::of(hanging))?;
    let mut simulation = scene.simulate(start, Rattle::new(5e-4))?;

    println!(" t / s   height of the pendulum / l   energy / J   work / J   energy error / J   |g|");
    let (mut times, mut places, mut highest) = (Vec::new(), vec![Vec::new(); 3], -1.0_f64);
    let mut energies = [Vec::new(), Vec::new()];
    for frame in 0..=600 {
        let q: Vec<Vector3<f64>> = simulation.positions().collect();
        let height = (q[2].z - q[1].z) / LENGTH;
        highest = highest.max(height);
        if frame % 50 == 0 {
            println!(
                "{:6.2} {height:18.3} {:20.3} {:10.3} {:14.1e} {:10.0e}",
                simulation.time(),
                simulation.energy(),
                simulation.work(),
                simulation.energy_error(),
                simulation.constraint_residual()
            );
        }
        times.push(simulation.time());
        energies[0].push(simulation.energy());
        energies[1].push(simulation.work());
        places.iter_mut().zip(&q).for_each(|(places, q)| places.push(<[f64; 3]>::from(*q)));
        simulation.run(40)?;
    }
    println!("highest: {highest:.4} (1 is upright)");
    println!("\n{}", simulation.bill()?);
    let shown = Scene3::new("Furuta pendulum")
        .bodies(&times, &places)
        .chain(0..3)
        .trail(40)
        .chart("Energy / J", ["energy", "work"].into_iter().zip(energies))
        .seconds(12.0);
    let caption =
        "A motor turns the arm, by the pendulum's energy, until the pendulum stands upright and falls again.";
    Page::new("Furuta pendulum").scene(shown.caption(caption)).write("out/furuta/index.html")?;
    println!("Written: out/furuta/index.html");
    Ok(())
}
