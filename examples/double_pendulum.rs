//! The double pendulum: two rods, any masses.
//!
//! ```text
//! cargo run --release --example double_pendulum
//! g₁ = |q₁|² − l²,   g₂ = |q₂ − q₁|² − l²,   U = g (m₁ y₁ + m₂ y₂)
//! ```
//!
//! 1. Mass ratios m₂/m₁ from 10⁻¹² to 1: energy, constraints and iterations do not mind.
//! 2. Equal masses, released 30° above the horizontal: two starts 10⁻⁹ rad apart part visibly at t = 50.
//!
//! Draws the path of the lower mass and the angles of both starts into `out/double_pendulum/`, and writes a
//! page on which both swing.

use rattle::bill::Bill;
use rattle::links::planar::Rod;
use rattle::plot::Chart;
use rattle::potentials::planar::weights;
use rattle::prelude::*;
use rattle::view::{Page, Scene3};
use std::error::Error;

const HANGER: usize = 0;

/// Released at rest with both rods at this angle from the downward vertical; the path of every step.
fn swing(masses: [f64; 2], angle: f64, h: f64, time: f64) -> Result<Swing, rattle::Error> {
    let masses = [1.0, masses[0], masses[1]];
    let scene = Scene::points(3)
        .link(Rod { length: 1.0 }, [[0, 1], [1, 2]])
        .pin(HANGER, [0.0, 0.0])
        .masses(masses)
        .with(weights(1.0, masses));
    let (s, c) = angle.sin_cos();
    let start = scene.project(&State::of([[0.0, 0.0], [s, -c], [2.0 * s, -2.0 * c]]))?;
    let mut simulation = scene.simulate(start, Rattle::new(h))?;

    let mut swing = Swing::default();
    let mut kinetic = 0.0_f64;
    let mut see = |now: &Simulation<_, _, 2>| {
        let q: Vec<_> = now.positions().collect();
        let rod = q[2] - q[1];
        swing.lower.push((q[2].x, q[2].y));
        swing.upper.push((q[1].x, q[1].y));
        swing.angle.push((now.time(), rod.x.atan2(-rod.y).to_degrees()));
        swing.energy_error = swing.energy_error.max(now.energy_error().abs());
        swing.residual = swing.residual.max(now.constraint_residual());
        kinetic = kinetic.max(now.kinetic_energy());
    };
    see(&simulation);
    simulation.run_with((time / h).round() as u64, see)?;
    swing.energy_error /= kinetic;
    swing.bill = Some(simulation.bill()?);
    swing.corrections = simulation.counts().corrections as f64 / simulation.steps() as f64;
    Ok(swing)
}

#[derive(Default)]
struct Swing {
    lower: Vec<(f64, f64)>,
    upper: Vec<(f64, f64)>,
    /// Of the lower rod from the downward vertical, in degrees.
    angle: Vec<(f64, f64)>,
    /// Relative to the largest kinetic energy.
    energy_error: f64,
    residual: f64,
    corrections: f64,
    bill: Option<Bill>,
}

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "Released horizontally, h = 0.005, to t = 50; all numbers are the largest or the mean of the run.\n"
    );
    println!("  m₂/m₁   energy error / kinetic energy   |g|      corrections per step");
    for exponent in [-12, -9, -6, -3, -1, 0] {
        let ratio = 10_f64.powi(exponent);
        let run = swing([1.0, ratio], 90_f64.to_radians(), 0.005, 50.0)?;
        println!("{ratio:8.0e} {:22.1e} {:17.1e} {:14.2}", run.energy_error, run.residual, run.corrections);
    }

    let angle = 120_f64.to_radians();
    let (one, other) = (swing([1.0; 2], angle, 0.002, 60.0)?, swing([1.0; 2], angle + 1e-9, 0.002, 60.0)?);
    let mut apart = one.lower.iter().zip(&other.lower).zip(&one.angle);
    let parted =
        apart.find(|((a, b), _)| (a.0 - b.0).hypot(a.1 - b.1) > 0.1).map_or(f64::NAN, |(_, (t, _))| *t);
    println!("\nEqual masses from 120°, and 10⁻⁹ rad beside: 0.1 apart at t = {parted:.1}");
    println!("energy error / kinetic energy {:.1e}", one.energy_error);
    if let Some(bill) = &one.bill {
        println!("\n{bill}");
    }

    Chart::new("Double pendulum, equal masses, from 120° at rest: the lower mass until t = 40")
        .x("x / rod length")
        .y("y / rod length")
        .equal_aspect()
        .line("", one.lower.iter().copied().take(20_000))
        .save("out/double_pendulum/path.svg")?;
    // The angle jumps by 360° where the rod turns over; unrolled it is a curve.
    Chart::new("Two starts 10⁻⁹ rad apart")
        .x("time t / √(l/g)")
        .y("angle of the lower rod / °")
        .line("120°", unrolled(&one.angle))
        .line("120° + 10⁻⁹ rad", unrolled(&other.angle))
        .save("out/double_pendulum/parting.svg")?;
    // Every tenth step; the second pendulum beside the first, so that both can be seen.
    let thin =
        |path: &[(f64, f64)], y: f64| path.iter().step_by(10).map(|p| [p.0, y, p.1]).collect::<Vec<_>>();
    let paths =
        [thin(&one.upper, 0.0), thin(&one.lower, 0.0), thin(&other.upper, 0.4), thin(&other.lower, 0.4)];
    let times: Vec<f64> = one.angle.iter().step_by(10).map(|(t, _)| *t).collect();
    let angles = [&one, &other]
        .map(|swing| unrolled(&swing.angle).into_iter().step_by(10).map(|p| p.1).collect::<Vec<_>>());
    let shown = Scene3::new("Two starts 10⁻⁹ rad apart")
        .bodies(&times, &paths)
        .names(["", "120°", "", "120° + 10⁻⁹ rad"])
        .rods([(0, [0.0; 3]), (2, [0.0, 0.4, 0.0])])
        .rods([(0, 1), (2, 3)])
        .trail(60)
        .chart("Angle of the lower rod / °", ["one", "other"].into_iter().zip(angles))
        .seconds(60.0);
    Page::new("Double pendulum").scene(shown).write("out/double_pendulum/index.html")?;
    println!("\nWritten to out/double_pendulum: path.svg, parting.svg, index.html");
    Ok(())
}

fn unrolled(angles: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut turns = 0.0;
    let mut last = angles[0].1;
    let unroll = |&(t, angle): &(f64, f64)| {
        turns -= 360.0 * ((angle - last) / 360.0).round();
        last = angle;
        (t, angle + turns)
    };
    angles.iter().map(unroll).collect()
}
