//! Beads that collide on a surface of genus two: billiards among themselves.
//!
//! ```text
//! cargo run --release --example hard_spheres
//! ```
//!
//! Thirty beads that cannot overlap. Prints how often they met, and how energy and distances are kept: a collision
//! keeps the energy to rounding, so that what is left is the method's. Writes `out/hard_spheres/index.html`, in which
//! the beads move.

use rattle::curvature::points;
use rattle::effect::HardSpheres;
use rattle::prelude::*;
use rattle::surfaces::Lemniscate;
use rattle::view::{Mesh, Page, Scene3, surface};

const SURFACE: Lemniscate = Lemniscate { a: 1.0, r: 1.0 / 6.0 };
const DIAMETER: f64 = 0.12;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = Scene::on(SURFACE).bodies(30);
    let (low, high) = ([-1.2, -0.6, -0.25], [1.2, 0.6, 0.25]);
    let places = points::apart(&SURFACE, low, high, 30, 1.05 * DIAMETER, 1)?;
    let start = scene.maxwell(&State::of(places), 0.1, 1)?; // momenta in any direction along the surface
    let mut gas = scene.simulate(start, Lobatto::<5>::new(0.01))?.collide(HardSpheres::new(DIAMETER))?;
    let mut trajectory = Trajectory::of(&gas);
    println!("     t   collisions   energy error   nearest − diameter");
    for _ in 0..10 {
        gas.observe(400, 1, &mut trajectory)?;
        let q: Vec<_> = gas.positions().collect();
        let pairs = (0..q.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        let nearest = pairs.map(|(i, j)| (q[i] - q[j]).norm()).fold(f64::INFINITY, f64::min);
        let (off, near) = (gas.energy_error(), nearest - DIAMETER);
        println!("{:6.1} {:12} {off:14.1e} {near:20.1e}", gas.time(), gas.events());
    }
    println!("\n{}", gas.bill()?);
    let mesh = Mesh::around(surface(&SURFACE), [0.0, 0.0, 0.1], 120)?;
    let beads = Scene3::new("Thirty beads").surface(&mesh).trajectory(&trajectory).sizes(&[[DIAMETER / 2.0]]);
    Page::new("Beads that collide").scene(beads).write("out/hard_spheres/index.html")?;
    println!("\nWritten to out/hard_spheres/index.html; open it in a browser.");
    Ok(())
}
