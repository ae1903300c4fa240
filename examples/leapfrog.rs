//! The staggered leapfrog on a pendulum, positions at whole steps and momenta at half steps, and a slip explained.
//!
//! ```text
//! θ̇ = p     ṗ = −sin θ         H = p²/2 − cos θ,  h = 0.1, until t = 500
//! ```
//!
//! A lecture note on symplectic methods runs this leapfrog from x = π/2, p = 0 with the two derivatives swapped:
//! `dHdx(p) = p` and `dHdp(θ) = sin θ`. What it then integrates is ẋ = sin p, ṗ = −x: the angle sits in `p` and the
//! momentum, up to sign, in `x`. It is a pendulum too, but another one: it starts at the bottom with momentum −π/2
//! instead of at rest at the angle π/2. Its code also hands the derivatives times that are half a step and a whole step
//! late, which nothing here depends on, and its unit of momentum is m L^{3/2} √g (there: over √g). Its runs by a
//! package are right: leapfrog, and the composition of order 10 by Sofroniou and Spaletta with steps of 1.2 until t =
//! 50.
//!
//! ```text
//! cargo run --release --example leapfrog          # then open out/leapfrog/*.svg
//! ```

use rattle::composition::SOFRONIOU_SPALETTA_2005_ORDER_10;
use rattle::plot::Chart;
use rattle::prelude::*;
use std::f64::consts::FRAC_PI_2;

potential! {
    /// The weight of a pendulum of length 1 at this angle from the bottom.
    struct Weight {}
    |theta| -cos(theta)
}

/// Angles and momenta, each with its own times.
struct Run {
    angle: Vec<(f64, f64)>,
    momentum: Vec<(f64, f64)>,
    energies: (f64, f64),
}

fn run(angle: f64, momentum: f64, h: f64) -> Result<Run, rattle::Error> {
    let scene = Scene::point().with(Weight {});
    let method = Leapfrog::new(h);
    let start = scene.staggered(&State::at([angle]).moving([momentum]), &method)?; // momenta of half a step later
    let mut simulation = scene.simulate(start, method)?;
    let mut run =
        Run { angle: Vec::new(), momentum: Vec::new(), energies: (f64::INFINITY, f64::NEG_INFINITY) };
    let mut before = simulation.momentum().x; // half a step before the next position
    while simulation.time() < 500.0 {
        run.angle.push((simulation.time(), simulation.position().x));
        run.momentum.push((simulation.momentum_time(), simulation.momentum().x));
        simulation.step()?;
        // The momentum at the time of the position: the mean of those half a step before and after it.
        let at_position = 0.5 * (before + simulation.momentum().x);
        let energy = 0.5 * at_position * at_position + simulation.potential_energy();
        run.energies = (run.energies.0.min(energy), run.energies.1.max(energy));
        before = simulation.momentum().x;
    }
    Ok(run)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("pendulum               h    largest |θ|   largest |p|   energy from … to");
    let mut runs = Vec::new();
    for (name, angle, momentum) in [("as meant", FRAC_PI_2, 0.0), ("with the slip", 0.0, -FRAC_PI_2)] {
        for h in [0.1, 0.05] {
            let run = run(angle, momentum, h)?;
            let largest = |points: &[(f64, f64)]| points.iter().map(|(_, y)| y.abs()).fold(0.0, f64::max);
            println!(
                "{name:18} {h:6.2} {:12.4} {:13.4}   {:9.5} … {:8.5}",
                largest(&run.angle),
                largest(&run.momentum),
                run.energies.0,
                run.energies.1
            );
            if h == 0.1 {
                runs.push((name, run));
            }
        }
    }
    for (file, (name, run)) in ["meant", "slip"].into_iter().zip(runs) {
        let early = |points: Vec<(f64, f64)>| points.into_iter().take_while(|&(t, _)| t < 30.0);
        Chart::new(format!("The leapfrog on a pendulum, {name}"))
            .x("time, in √(L/g)")
            .y("angle θ, momentum p")
            .points("θ, at whole steps", early(run.angle))
            .points("p, at half steps", early(run.momentum))
            .save(format!("out/leapfrog/{file}.svg"))?;
    }

    let (mut angle, mut momentum, mut error) = (Vec::new(), Vec::new(), 0.0_f64);
    let method = Composition::new(SOFRONIOU_SPALETTA_2005_ORDER_10, 1.2);
    let mut simulation = Scene::point().with(Weight {}).simulate(State::at([FRAC_PI_2]), method)?;
    while simulation.time() < 50.0 {
        angle.push((simulation.time(), simulation.position().x));
        momentum.push((simulation.time(), simulation.momentum().x));
        error = error.max(simulation.energy_error().abs());
        simulation.step()?;
    }
    println!(
        "order 10, as meant {:6.2}: {} steps, largest energy error {error:.1e}",
        1.2,
        simulation.steps()
    );
    let method = Composition::new(SOFRONIOU_SPALETTA_2005_ORDER_10, 0.1);
    let mut fine = Scene::point().with(Weight {}).simulate(State::at([FRAC_PI_2]), method)?;
    let (mut fine_angle, mut fine_momentum) = (Vec::new(), Vec::new());
    fine.run_with(492, |now| {
        fine_angle.push((now.time(), now.position().x));
        fine_momentum.push((now.time(), now.momentum().x));
    })?;
    println!("\n{}", fine.bill()?);
    Chart::new("The same pendulum by a method of order 10, h = 1.2")
        .x("time, in √(L/g)")
        .y("angle θ, momentum p")
        .line("θ, h = 0.1", fine_angle)
        .line("p, h = 0.1", fine_momentum)
        .points("θ, h = 1.2", angle)
        .points("p, h = 1.2", momentum)
        .save("out/leapfrog/order_10.svg")?;
    println!(
        "\nBounded for all 5000 steps at h = 0.1. Pictures: out/leapfrog/meant.svg, slip.svg and order_10.svg"
    );
    Ok(())
}
