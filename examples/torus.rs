//! A geodesic on a torus: a particle that nothing acts on but the surface.
//!
//! ```text
//! cargo run --release --example torus
//! ```

use rattle::prelude::*;

constraint! {
    /// Points at distance `minor` from a circle of radius `major` about the z axis.
    struct Torus { major, minor }
    |x, y, z| (sqrt(x^2 + y^2) - major)^2 + z^2 - minor^2
}

fn main() -> Result<(), rattle::Error> {
    let torus = Torus { major: 1.0, minor: 0.3 };
    let angle = 30_f64.to_radians(); // to the outer equator
    let start = State::at([1.3, 0.0, 0.0]).moving([0.0, angle.cos(), angle.sin()]);
    let mut simulation = Scene::on(torus).simulate(start, Rattle::new(0.01))?;

    // On a surface of revolution ρ² φ̇ is constant (Clairaut); RATTLE keeps it to rounding.
    let clairaut = |q: [f64; 3], v: [f64; 3]| q[0] * v[1] - q[1] * v[0];
    let at_start = clairaut(simulation.position().into(), simulation.momentum().into());

    println!("     t        x          y          z       |g|     energy error   Clairaut error");
    for _ in 0..=10 {
        let (q, v) = (simulation.position(), simulation.momentum());
        println!(
            "{:6.1} {:10.6} {:10.6} {:10.6} {:8.0e} {:14.1e} {:14.1e}",
            simulation.time(),
            q.x,
            q.y,
            q.z,
            simulation.constraint_residual(),
            simulation.energy_error(),
            clairaut(q.into(), v.into()) - at_start,
        );
        simulation.run(1000)?;
    }
    println!("\n{}", simulation.bill()?);
    Ok(())
}
