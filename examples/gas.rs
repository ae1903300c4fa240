//! Ten thousand Lennard-Jones atoms on a sphere: at rest on a spiral at first, they draw together and grow warm.
//!
//! ```text
//! cargo run --release --example gas      # writes out/gas.html
//! ```

use rattle::potentials::LennardJones;
use rattle::prelude::*;
use rattle::surfaces::Sphere;
use rattle::view::{Mesh, Page, Scene3, surface};

const ATOMS: usize = 10_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let r = 45.0; // 0.4 atoms in a unit of area
    let sphere = Sphere { r };
    let spiral = (0..ATOMS).map(|i| {
        let (z, angle) = (1.0 - (2 * i + 1) as f64 / ATOMS as f64, 2.4 * i as f64);
        let rho = (1.0 - z * z).sqrt();
        [r * rho * angle.cos(), r * rho * angle.sin(), r * z]
    });
    let atoms = LennardJones { epsilon: 1.0, sigma: 1.0 }.within(2.5);
    let scene = Scene::on(sphere).bodies(ATOMS).with(atoms);
    let start = scene.project(&State::of(spiral))?;
    let mut simulation = scene.simulate(start, Rattle::new(0.01))?;

    let mut trajectory = Trajectory::of(&simulation);
    println!("     t      energy error   kinetic energy of an atom");
    for _ in 0..10 {
        simulation.observe(1000, 100, &mut trajectory)?;
        let (off, kinetic) = (simulation.energy_error(), simulation.kinetic_energy() / ATOMS as f64);
        println!("{:6.0} {:17.1e} {kinetic:27.3}", simulation.time(), off / simulation.energy().abs());
    }
    println!("\n{}", simulation.bill()?);
    let mesh = Mesh::around(surface(&sphere), [0.0, 0.0, r], 60)?;
    let motion = Scene3::new("atoms on a sphere").surface(&mesh).trajectory(&trajectory);
    Page::new("A gas").scene(motion).write("out/gas.html")?;
    Ok(())
}
