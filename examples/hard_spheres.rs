//! Beads that collide on a surface of genus two: billiards among themselves.
//!
//! ```text
//! cargo run --release --example hard_spheres
//! ```
//!
//! Thirty beads that cannot overlap. Prints how often they met, and how energy and distances are kept: a collision
//! keeps the energy to rounding, so that what is left is the method's. Writes `out/hard_spheres/index.html`, in which
//! the beads move.

use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle::effect::HardSpheres;
use rattle::prelude::*;
use rattle::surfaces::Lemniscate;
use rattle::view::{Mesh, Page, Scene3, surface};

const SURFACE: Lemniscate = Lemniscate { a: 1.0, r: 1.0 / 6.0 };
const DIAMETER: f64 = 0.12;

/// Places that are farther apart than a diameter, momenta in any direction along the surface.
fn start() -> State<3> {
    let (one, mut random) = (Scene::on(SURFACE), StdRng::seed_from_u64(1));
    let mut beads: Vec<[nalgebra::Vector3<f64>; 2]> = Vec::new();
    while beads.len() < 30 {
        let mut draw = |r: f64| nalgebra::Vector3::from_fn(|_, _| random.random_range(-r..r));
        let Ok(state) = one.project(&State::at(draw(1.0)).moving(draw(1.0))) else { continue };
        let (Some(q), Some(p)) = (state.positions().next(), state.momenta().next()) else { continue };
        if beads.iter().all(|other| (other[0] - q).norm() > 1.05 * DIAMETER) {
            beads.push([q, p]);
        }
    }
    State::of(beads.iter().map(|bead| bead[0])).with_momenta(beads.iter().map(|bead| bead[1]))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let start = start();
    let scene = Scene::on(SURFACE).bodies(start.len());
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
