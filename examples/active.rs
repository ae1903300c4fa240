//! Active particles on a gyroid: each pushes itself along a heading of its own in the tangent plane, which is carried
//! along parallel to the surface and turned by noise; those that meet repel each other, and jam.
//!
//! ```text
//! cargo run --release --example active
//! dp = (F u − ∇U − γ p + ∇g λ) dt + √(2γ kT) Π dW,   du = √(2D_r) (n × u) dW′ along the path
//! ```
//!
//! 240 particles in one period of the surface. The table shows how far they have come from their start; how fast they
//! go along their headings, as a part of F/(γ + D_r), the speed of one by itself: those that stand in each other's way
//! lose a part of it; and the work of pushes and heat together, which is booked: what is left is the error of the
//! method, which friction makes grow by a ten-thousandth of the 500 that pushes give in a unit of time, and by a fourth
//! of that with half the step. The page in `out/active/` shows the motion, wrapped into the period.

use rattle::curvature::points;
use rattle::effect::{Langevin, SelfPropulsion};
use rattle::potentials::Wca;
use rattle::prelude::*;
use rattle::surfaces::Gyroid;
use rattle::view::{self, Mesh, Page, Scene3};
use std::error::Error;
use std::f64::consts::TAU;

const PARTICLES: usize = 240;
const SIGMA: f64 = 0.5;
const FRICTION: f64 = 5.0;
const PUSH: f64 = 5.0;
const TURNING: f64 = 0.2;

fn main() -> Result<(), Box<dyn Error>> {
    let surface = Gyroid { k: 1.0, epsilon: 0.0 }; // of period 2π
    let repulsion = Wca { epsilon: 1.0, sigma: SIGMA };
    let scene = Scene::on(surface)
        .bodies(PARTICLES)
        .with(repulsion.within(SIGMA * 2_f64.powf(1.0 / 6.0)).shifted().periodic([TAU; 3]))
        .with(Langevin { friction: FRICTION, temperature: 0.02, seed: 7 })
        .with(SelfPropulsion::new(PUSH, TURNING, 7));
    // Apart from those of the next period, too: a margin of half of the distance on all sides.
    let (low, high) = ([0.5 * SIGMA; 3], [TAU - 0.5 * SIGMA; 3]);
    let start = State::of(points::apart(&surface, low, high, PARTICLES, SIGMA, 7)?);
    let mut simulation = scene.simulate(start, Baoab::new(0.005))?.retry(8);
    let first: Vec<_> = simulation.positions().collect();

    println!("   t   ⟨(q − q₀)²⟩   speed   work      energy error     |g|");
    let (mut times, mut films) = (Vec::new(), vec![Vec::new(); PARTICLES]);
    for _ in 0..10 {
        let mut speed = 0.0;
        for _ in 0..60 {
            simulation.run(10)?;
            times.push(simulation.time());
            for (film, q) in films.iter_mut().zip(simulation.positions()) {
                film.push(q.map(|x| x.rem_euclid(TAU)));
            }
            let headings = SelfPropulsion::<3>::headings(simulation.marks());
            speed += simulation.velocities().zip(headings).map(|(v, u)| v.dot(&u)).sum::<f64>();
        }
        let far =
            simulation.positions().zip(&first).map(|(q, first)| (q - first).norm_squared()).sum::<f64>();
        println!(
            "{:4.0} {:12.2} {:8.3} {:9.1} {:13.1e} {:10.0e}",
            simulation.time(),
            far / PARTICLES as f64,
            speed / (60 * PARTICLES) as f64 * (FRICTION + TURNING) / PUSH,
            simulation.work(),
            simulation.energy_error(),
            simulation.constraint_residual(),
        );
    }
    println!("\n{}", simulation.bill()?);

    let mesh = Mesh::within(view::surface(&surface), [0.0; 3], [TAU; 3], 60)?;
    let caption = "240 particles that push themselves along, on one period of a gyroid: who leaves it at one side comes in at the other.";
    let motion = Scene3::new("Active particles").surface(&mesh).bodies(&times, &films).caption(caption);
    let motion = motion.periods([TAU; 3]).trail(8);
    Page::new("Active particles on a gyroid").scene(motion).write("out/active/index.html")?;
    println!("\nWritten to out/active: index.html");
    Ok(())
}
