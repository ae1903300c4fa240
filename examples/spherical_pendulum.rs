//! A spherical pendulum: a rod that swings in space, and the rosette that its end draws.
//!
//! ```text
//! cargo run --release --example spherical_pendulum
//! g = |q|² − l²,   U = g z
//! ```
//!
//! Energy is kept to second order, the angular momentum about the vertical to rounding. The rosette turns; by how much
//! from one outermost point to the next is known as an integral, which the table compares with.
//!
//! Draws the path seen from above, and energy and angular momentum, into `out/spherical_pendulum/`.

use rattle::links::Pendulum;
use rattle::plot::Chart;
use rattle::potentials::Gravity;
use rattle::prelude::*;
use std::error::Error;
use std::f64::consts::PI;

/// Outermost point of the start, and the speed across.
const TILT: f64 = 1.0;
const SPEED: f64 = 0.4;

fn main() -> Result<(), Box<dyn Error>> {
    let scene = Scene::on(Pendulum { length: 1.0, pivot: [0.0; 3] }).with(Gravity { g: 1.0 });
    let start = State::at([TILT.sin(), 0.0, -TILT.cos()]).moving([0.0, SPEED, 0.0]);
    let momentum = TILT.sin() * SPEED;
    let exact = turn_per_swing();

    println!("      h    energy error   Lz error      |g|    turn per swing    its error");
    let (mut seen_from_above, mut energy, mut spin) = (Vec::new(), Vec::new(), Vec::new());
    for h in [0.02, 0.01, 0.005] {
        let mut simulation = scene.simulate(start.clone(), Rattle::new(h))?;
        let (mut worst, mut residual) = ([0.0_f64; 2], 0.0_f64);
        let mut outermost = Vec::new();
        let mut before = 0.0;
        [&mut seen_from_above, &mut energy, &mut spin].into_iter().for_each(Vec::clear);
        let mut see = |now: &Simulation<_, _, 3>| {
            let (q, v, t) = (now.position(), now.momentum(), now.time());
            let errors = [now.energy_error(), q.x * v.y - q.y * v.x - momentum];
            worst = [0, 1].map(|i| worst[i].max(errors[i].abs()));
            residual = residual.max(now.constraint_residual());
            seen_from_above.push((q.x, q.y));
            energy.push((t, errors[0]));
            spin.push((t, errors[1]));
            if before > 0.0 && v.z <= 0.0 {
                // Highest a part of a step ago.
                let part = h * v.z / (before - v.z);
                outermost.push(q.y.atan2(q.x) + part * (q.x * v.y - q.y * v.x) / (q.x.powi(2) + q.y.powi(2)));
            }
            before = v.z;
        };
        see(&simulation);
        simulation.run_with((100.0 / h) as u64, see)?;
        // Twice the way from one outermost point to the next, less the full circle.
        let turns = outermost.windows(2).map(|pair| (2.0 * (pair[1] - pair[0])).rem_euclid(2.0 * PI));
        let turn = turns.sum::<f64>() / (outermost.len() - 1) as f64;
        println!(
            "{h:7.3} {:14.1e} {:10.0e} {residual:8.0e} {:16.5}° {:11.1e}°",
            worst[0],
            worst[1],
            turn.to_degrees(),
            (turn - exact).to_degrees()
        );
    }
    println!("exact: {:49.5}°", exact.to_degrees());
    println!("\n{}", scene.simulate(start, Rattle::new(0.005))?.bill()?);

    let folder = "out/spherical_pendulum";
    Chart::new("Spherical pendulum seen from above, until t = 60")
        .x("x / l")
        .y("y / l")
        .equal_aspect()
        .line("", seen_from_above.into_iter().take(12_000))
        .save(format!("{folder}/above.svg"))?;
    Chart::new("Spherical pendulum, h = 0.005: energy error")
        .x("time t / √(l/g)")
        .y("E − E₀, in units of m g l")
        .line("", energy)
        .save(format!("{folder}/energy.svg"))?;
    Chart::new("Spherical pendulum, h = 0.005: error of the angular momentum about the vertical")
        .x("time t / √(l/g)")
        .y("Lz − Lz₀, in units of m l √(g l)")
        .line("", spin)
        .save(format!("{folder}/angular_momentum.svg"))?;
    println!("\nWritten to {folder}: above.svg, energy.svg, angular_momentum.svg");
    Ok(())
}

/// 4 ∫ φ̇ dt from the lowest to the highest point, less 2π, with ż² = 2 (E − z)(1 − z²) − Lz² and l = g = 1.
fn turn_per_swing() -> f64 {
    let (z1, momentum) = (-TILT.cos(), TILT.sin() * SPEED);
    let energy = SPEED.powi(2) / 2.0 + z1;
    // ż² = 2 (z − z₁)(z − z₂)(z − z₃): the sum of the roots is E, the sum of their products −1.
    let (sum, product) = (energy - z1, -1.0 - z1 * (energy - z1));
    let root = (sum.powi(2) / 4.0 - product).sqrt();
    let (z2, z3) = (sum / 2.0 - root, sum / 2.0 + root);
    // z = middle + half·cos θ takes the ends away; the midpoint rule is then exact to rounding.
    let n = 60;
    let angle = (0..n).map(|k| {
        let z = (z1 + z2) / 2.0 + (z1 - z2) / 2.0 * (PI * (f64::from(k) + 0.5) / f64::from(n)).cos();
        momentum / ((1.0 - z * z) * (2.0 * (z3 - z)).sqrt())
    });
    4.0 * angle.sum::<f64>() * PI / f64::from(n) - 2.0 * PI
}
