//! A pendulum in Cartesian coordinates: the rod is the constraint, its tension the multiplier.
//!
//! ```text
//! cargo run --release --example pendulum
//! ```

use rattle::prelude::*;

constraint! {
    /// A rod of this length from the origin.
    struct Rod { length }
    |x, y| x^2 + y^2 - length^2
}

potential! {
    /// Weight; y points up.
    struct Weight { g }
    |x, y| g * y
}

fn main() -> Result<(), rattle::Error> {
    let (length, g) = (1.0, 1.0);
    let scene = Scene::on(Rod { length }).with(Weight { g });
    let mut simulation = scene.simulate(State::at([length, 0.0]), Rattle::new(0.01))?; // horizontal, at rest

    // The period of the full quarter-circle swing is 7.4163 √(l/g).
    println!("    t     angle from the bottom   tension   energy error");
    for _ in 0..=16 {
        let q = simulation.position();
        println!(
            "{:5.1} {:16.2}° {:15.4} {:14.1e}",
            simulation.time(),
            q.x.atan2(-q.y).to_degrees(),
            -simulation.constraint_forces()[0].dot(&q) / length, // inwards
            simulation.energy_error(),
        );
        simulation.run(50)?;
    }
    println!("\n{}", simulation.bill()?); // what a step costs
    Ok(())
}
