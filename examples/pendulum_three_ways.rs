//! The pendulum three ways: by its angle, with a multiplier, and with a multiplier that acts on x alone.
//!
//! ```text
//! cargo run --release --example pendulum_three_ways
//! angle        φ̈ = −(g/l) sin φ
//! multiplier   q̈ = −g e_y + λ ∇c,          c = √(x² + y²) − l
//! x alone      ẍ = λ ∂c/∂x,   ÿ = −g,      c = 0
//! ```
//!
//! The first two are one motion, and come together like h². λ is positive where the rod pushes outwards; texts that
//! write the force as −λ∇c have the tension −λ of here, and that is drawn. The third is not mechanics: the mass falls
//! freely in y, and at the bottom no force along x can hold the rod: the error says so.
//!
//! Draws φ(t), the tension, and the kinetic energy into `out/pendulum_three_ways/`.

use rattle::plot::Chart;
use rattle::prelude::*;
use std::error::Error;
use std::f64::consts::PI;

constraint! {
    /// A rod of this length from the origin; |∇c| = 1, so that λ is a force.
    struct Rod { length }
    |x, y| sqrt(x^2 + y^2) - length
}

potential! {
    /// Weight; y points up.
    struct Weight { g }
    |x, y| g * y
}

potential! {
    /// The same over the angle from the bottom.
    struct Swing { g, length }
    |angle| -g * length * cos(angle)
}

const LENGTH: f64 = 1.0;
const G: f64 = 1.0;
const START: f64 = 0.9 * PI;
const T: f64 = 100.0;

type Curve = Vec<(f64, f64)>;

/// φ and kinetic energy by the angle. The momentum of an angle is l² φ̇: the mass in that coordinate is l².
fn by_angle(h: f64) -> Result<(Curve, Curve), rattle::Error> {
    let scene = Scene::point().mass(LENGTH * LENGTH).with(Swing { g: G, length: LENGTH });
    let mut simulation = scene.simulate(State::at([START]), Rattle::new(h))?;
    let (mut angle, mut kinetic) = (Vec::new(), Vec::new());
    let mut see = |now: &Simulation<_, _, 1>| {
        angle.push((now.time(), now.position().x));
        kinetic.push((now.time(), now.kinetic_energy()));
    };
    see(&simulation);
    simulation.run_with((T / h).round() as u64, see)?;
    Ok((angle, kinetic))
}

/// φ, tension and kinetic energy in x and y, and why the run ended. The multiplier acts on these coordinates; on both is
/// what `link` or `Scene::on` would do.
fn by_multiplier(h: f64, acting: [bool; 2]) -> Result<([Curve; 3], Option<rattle::Error>), rattle::Error> {
    let rod = Rod { length: LENGTH };
    let scene = Scene::point().link_acting(rod, [[0]], [acting]).with(Weight { g: G });
    let start = State::at([LENGTH * START.sin(), -LENGTH * START.cos()]);
    let mut simulation = scene.simulate(start, Rattle::new(h))?;
    let mut curves = [Vec::new(), Vec::new(), Vec::new()];
    let mut see = |now: &Simulation<_, _, 2>| {
        let (q, t) = (now.position(), now.time());
        curves[0].push((t, q.x.atan2(-q.y)));
        curves[1].push((t, -now.multiplier()));
        curves[2].push((t, now.kinetic_energy()));
    };
    see(&simulation);
    let ended = simulation.run_with((T / h).round() as u64, see);
    Ok((curves, ended.err()))
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("     h    largest |φ − φ'| of angle and multiplier, to t = {T}");
    let mut last = None;
    for h in [0.01, 0.005, 0.0025] {
        let ((angle, _), ([same, ..], _)) = (by_angle(h)?, by_multiplier(h, [true, true])?);
        let apart = angle.iter().zip(&same).map(|(a, b)| (a.1 - b.1).abs()).fold(0.0, f64::max);
        let ratio = last.map_or(String::new(), |last: f64| format!("ratio {:.2}", last / apart));
        println!("{h:8.4} {apart:14.2e}   {ratio}");
        last = Some(apart);
    }

    let h = 0.01;
    let (angle, kinetic) = by_angle(h)?;
    let ([same, tension, _], _) = by_multiplier(h, [true, true])?;
    let ([falling, push, falling_kinetic], ended) = by_multiplier(h, [true, false])?;
    let largest = tension.iter().map(|p| p.1).fold(f64::MIN, f64::max);
    let smallest = tension.iter().map(|p| p.1).fold(f64::MAX, f64::min);
    println!("\nTension of the rod from {smallest:.4} to {largest:.4}; exact, 3 cos φ − 2 cos φ₀ times m g:");
    println!("                   from {:.4} to {:.4}", START.cos(), 3.0 - 2.0 * START.cos());
    if let Some(error) = ended {
        let bottom = (2.0 * LENGTH * (1.0 - START.cos()) / G).sqrt();
        println!("\nMultiplier on x alone; free fall reaches the bottom at t = {bottom:.4}:\n  {error}");
    }

    let time = "time t / √(l/g)";
    Chart::new("A pendulum from 0.9 π: angle and multiplier coincide, on x alone it falls freely")
        .x(time)
        .y("angle φ from the bottom / rad")
        .line("angle", angle)
        .line("multiplier", same.iter().copied())
        .line("on x alone", falling)
        .save("out/pendulum_three_ways/angle.svg")?;
    Chart::new("Tension of the rod: negative where it pushes the mass outwards")
        .x(time)
        .y("tension −λ / m g")
        .line("", tension.iter().copied())
        .save("out/pendulum_three_ways/tension.svg")?;
    // What grows without bound at the bottom, t = 1.98, would flatten all else.
    let early = |curve: Curve| curve.into_iter().filter(|p| p.0 <= 1.6).collect::<Vec<_>>();
    Chart::new("The first moments, whole multiplier and on x alone")
        .x(time)
        .y("tension −λ / m g, kinetic energy / m g l")
        .line("tension", early(tension))
        .line("tension, on x", early(push))
        .line("energy", early(kinetic))
        .line("energy, on x", early(falling_kinetic))
        .save("out/pendulum_three_ways/first_moments.svg")?;
    println!("\nWritten to out/pendulum_three_ways: angle.svg, tension.svg, first_moments.svg");
    Ok(())
}
