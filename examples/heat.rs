//! A gas at a temperature, on a surface of genus two: Langevin's friction and noise, by g-BAOAB.
//!
//! ```text
//! cargo run --release --example heat
//! dp = (−∇U − γ p + ∇g λ) dt + √(2γ kT) Π dW
//! ```
//!
//! 100 particles with Lennard-Jones forces start at a fifth of the temperature of their bath. The table shows them
//! become warm: ½kT for each of the two momenta of a particle on a surface; heat is booked as work, so that the energy
//! error is that of the method. The same seed gives the same run on any machine, after a restart too. The page in
//! `out/heat/` shows the motion.

use rattle::curvature::points;
use rattle::effect::Langevin;
use rattle::potentials::LennardJones;
use rattle::prelude::*;
use rattle::surfaces::Lemniscate;
use rattle::view::{self, Mesh, Page, Scene3};
use std::error::Error;

const KT: f64 = 0.5;

fn main() -> Result<(), Box<dyn Error>> {
    let surface = Lemniscate { a: 1.0, r: 1.0 / 6.0 };
    let (low, high) = ([-1.2, -0.6, -0.25], [1.2, 0.6, 0.25]);
    let gas = Scene::on(surface).bodies(100).with(LennardJones { epsilon: 0.2, sigma: 0.1 }).with(Langevin {
        friction: 1.0,
        temperature: KT,
        seed: 7,
    });
    let places = State::of(points::apart(&surface, low, high, 100, 0.1, 7)?);
    let start = gas.maxwell(&places, KT / 5.0, 7)?;
    let mut simulation = gas.simulate(start, Baoab::new(0.001))?.retry(8);

    println!("   t    temperature   (mean)    heat taken   energy error     |g|");
    let per_momentum = |now: &Sight<'_, 3>| now.kinetic_energy() / 100.0; // ½kT for each of 200
    let mut watching = (Trajectory::default(), Mean::of(per_momentum));
    for _ in 0..10 {
        watching.1 = Mean::of(per_momentum);
        simulation.observe(500, 5, &mut watching)?;
        println!(
            "{:5.1} {:11.3} {:11.3} {:12.3} {:14.1e} {:10.0e}",
            simulation.time(),
            simulation.temperature(),
            watching.1.mean(),
            simulation.work(),
            simulation.energy_error(),
            simulation.constraint_residual(),
        );
    }
    println!("\n{}", simulation.bill()?);

    let mesh = Mesh::of(view::surface(&surface), low, high, 160)?;
    let caption = "100 particles that attract each other a little, in a bath of kT = ½.";
    let motion = Scene3::new("A gas in heat").surface(&mesh).trajectory(&watching.0).caption(caption);
    // Where they are, in the mean over the second half of the time.
    let places = watching.0.positions();
    let (late, _) = places[places.len() / 6 * 3..].as_chunks::<3>();
    let samples = late.len() as f64 / 100.0;
    let density = mesh.density(late, 0.08)?.into_iter().map(|per_area| per_area / samples);
    let dense = motion.clone().renamed("Mean density").heat("particles per area", density);
    Page::new("A gas at a temperature").scene(motion).scene(dense).write("out/heat/index.html")?;
    println!("\nWritten to out/heat: index.html");
    Ok(())
}
