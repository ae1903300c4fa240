//! Fekete points: particles on a sphere repel each other, and drag brings them to rest where they are farthest apart.
//!
//! ```text
//! cargo run --release --example fekete
//! g = |q|² − 1,   U = −Σ ln |qᵢ − qⱼ|,   ṗ = −½ v beside forces
//! ```
//!
//! Twenty particles start from places that are random, uniform in area. The table shows how energy goes into heat: U
//! falls, and what drag has taken is what is missing. A test compares the points with those of the test set for initial
//! value problems (`cargo long --test motion fekete::`). The page in `out/fekete/` shows the motion.

use rattle::curvature::points;
use rattle::effect::LinearDrag;
use rattle::prelude::*;
use rattle::surfaces::Sphere;
use rattle::view::{Mesh, Page, Scene3, surface};
use std::error::Error;

pair_potential! {
    /// The product of all distances becomes a maximum.
    struct Repulsion {}
    |r| -ln(r)
}

fn main() -> Result<(), Box<dyn Error>> {
    let sphere = Sphere { r: 1.0 };
    let scene = Scene::on(sphere).bodies(20).with(Repulsion {}).with(LinearDrag::new(0.5));
    let start = State::of(points::uniform(&sphere, [-1.0; 3], [1.0; 3], 20, 3)?);
    // Two particles that start close together fly apart: that step is taken in parts.
    let mut simulation = scene.simulate(start, Rattle::new(0.01))?.retry(8);

    println!("   t        U           kinetic     work of drag   energy error     |g|   nearest two");
    let mut film = Trajectory::default();
    for _ in 0..10 {
        let q: Vec<_> = simulation.positions().collect();
        let pairs = (0..q.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        let nearest = pairs.map(|(i, j)| (q[i] - q[j]).norm()).fold(f64::INFINITY, f64::min);
        println!(
            "{:5.0} {:12.6} {:12.2e} {:12.6} {:14.1e} {:10.0e} {:8.4}",
            simulation.time(),
            simulation.potential_energy(),
            simulation.kinetic_energy(),
            simulation.work(),
            simulation.energy_error(),
            simulation.constraint_residual(),
            nearest,
        );
        simulation.observe(500, 5, &mut film)?;
    }
    println!("\n{}", simulation.bill()?);

    let mesh = Mesh::around(surface(&sphere), [0.0, 0.0, 1.0], 80)?;
    let caption = "They start at random places and repel each other; drag takes the energy, until they rest.";
    let scene =
        Scene3::new("Twenty Fekete points").surface(&mesh).trajectory(&film).trail(100).caption(caption);
    Page::new("Fekete points on a sphere").scene(scene).write("out/fekete/index.html")?;
    println!("\nWritten to out/fekete: index.html");
    Ok(())
}
