//! Foucault's pendulum, without a rotating frame: a rod whose support travels with a turning planet.
//!
//! ```text
//! cargo run --release --example foucault
//! g(q, t) = |q − s(t)|² − l²,   s(t) on a circle of latitude,   U = −µ/|q|
//! ```
//!
//! A planet with a radius of 50 rods turns once while the pendulum swings some 50 times. Everything is computed among
//! the fixed stars; only the picture turns with the ground. There the plane of the swing turns by Ω sin φ, with φ the
//! latitude that a plumb line shows, but for the part 3/8 of the squared amplitude (the same that a spherical pendulum
//! has).
//!
//! The support does work on the bob, more than the swing has energy; energy less work is kept to second order.
//!
//! Draws the path on the ground, the direction of the swing, and energy and work into `out/foucault/`, and
//! writes a page as seen from the ground.

use rattle::nalgebra::{Matrix3, Rotation3, Vector3};
use rattle::plot::Chart;
use rattle::prelude::*;
use rattle::view::{Page, Scene3};
use std::error::Error;
use std::f64::consts::{FRAC_PI_4, PI};

constraint! {
    /// A rod of this length from a support on a planet that turns about z.
    struct Rod { length, along_axis, off_axis, rate }
    |x, y, z, t| {
        let support = [off_axis * cos(rate * t), off_axis * sin(rate * t), along_axis];
        (x - support[0])^2 + (y - support[1])^2 + (z - support[2])^2 - length^2
    }
}

potential! {
    /// Of a planet at the origin.
    struct Planet { mu }
    |x, y, z| -mu / sqrt(x^2 + y^2 + z^2)
}

const RADIUS: f64 = 50.0;
/// Turns of the planet in radians per unit of time; a swing takes 2π.
const RATE: f64 = 0.02;
/// Gravity 1 on the ground.
const MU: f64 = RADIUS * RADIUS;
const AMPLITUDE: f64 = 0.1;
const T: f64 = 450.0;

fn main() -> Result<(), Box<dyn Error>> {
    let support = Vector3::new(FRAC_PI_4.cos(), 0.0, FRAC_PI_4.sin()) * (RADIUS + 1.0);
    let turning = Vector3::z() * RATE;

    // The plumb line: where the bob rests on the turning planet, below the support along what pulls it there.
    let mut rest = support - support.normalize();
    for _ in 0..100 {
        let pull = -rest * MU / rest.norm().powi(3) - turning.cross(&turning.cross(&rest));
        rest = support + pull.normalize();
    }
    let up = support - rest;
    let east = Vector3::y();
    let ground = Matrix3::from_columns(&[east, up.cross(&east), up]); // east, north, up
    let expected = RATE * up.z;

    // Held to the south and let go: at rest on the ground.
    let aside = support + ground * Vector3::new(0.0, -AMPLITUDE, -(1.0 - AMPLITUDE.powi(2)).sqrt());
    let rod = Rod { length: 1.0, along_axis: support.z, off_axis: support.x, rate: RATE };
    let scene = Scene::point().link_moving(rod, [[0]]).with(Planet { mu: MU });
    let start = scene.project(&State::at(aside).moving(turning.cross(&aside)))?;

    println!(
        "plumb line {:.3}° from the equator, {:.3}° off the radius",
        up.z.asin().to_degrees(),
        up.angle(&support).to_degrees()
    );
    println!(
        "Ω sin φ = {expected:.6};  with 3/8 of the squared amplitude less: {:.6}\n",
        expected * (1.0 - 0.375 * AMPLITUDE.powi(2))
    );
    println!("     h    turn of the plane   energy − work, largest error   ratio");
    let (mut last, mut path, mut directions) = (None, Vec::new(), Vec::new());
    let mut bob = Vec::new();
    let (mut gain, mut work) = (Vec::new(), Vec::new());
    for h in [0.02, 0.01, 0.005] {
        let mut simulation = scene.simulate(start.clone(), Rattle::new(h))?;
        let (energy, mut worst) = (simulation.energy(), 0.0_f64);
        bob.clear();
        [&mut path, &mut directions, &mut gain, &mut work].into_iter().for_each(Vec::clear);
        let mut see = |now: &Simulation<_, _, 3>| {
            let back = Rotation3::from_axis_angle(&Vector3::z_axis(), -RATE * now.time());
            let seen = ground.transpose() * (back * now.position() - support);
            path.push((seen.x, seen.y));
            bob.push(<[f64; 3]>::from(seen));
            gain.push((now.time(), now.energy() - energy));
            work.push((now.time(), now.work()));
            worst = worst.max(now.energy_error().abs());
        };
        see(&simulation);
        simulation.run_with((T / h).round() as u64, see)?;
        directions = outermost(&path, h);
        // From the first to the last of the outermost points.
        let (first, end) = (directions[0], directions[directions.len() - 1]);
        let measured = (first.1 - end.1) / (end.0 - first.0);
        let ratio = last.map_or(String::new(), |last: f64| format!("{:.2}", last / worst));
        println!("{h:7.3} {measured:15.6} {worst:24.2e} {ratio:>15}");
        last = Some(worst);
    }
    println!("\n{}", scene.simulate(start, Rattle::new(0.005))?.bill()?);

    let (times, bob): (Vec<f64>, Vec<[f64; 3]>) =
        gain.iter().map(|(t, _)| *t).zip(bob).step_by(20).take((PI / expected / 0.1) as usize).unzip();
    let shown = Scene3::new("seen from the ground")
        .bodies(&times, &[bob])
        .rods([(0, [0.0; 3])])
        .trail(600)
        .axes(["east", "north", "up"])
        .seconds(60.0);
    Page::new("Foucault's pendulum").scene(shown).write("out/foucault/index.html")?;
    Chart::new("Foucault's pendulum at 45° on a fast planet: the path on the ground, half a turn")
        .x("east / rod length")
        .y("north / rod length")
        .equal_aspect()
        .line("", path.into_iter().take((PI / expected / 0.005) as usize))
        .save("out/foucault/ground.svg")?;
    let line =
        [0.0, T].map(|t| (t, directions[0].1.to_degrees() - (expected * (t - directions[0].0)).to_degrees()));
    Chart::new("The direction of the swing")
        .x("time t / √(l/g)")
        .y("azimuth from east, northwards / °")
        .points("measured", directions.iter().step_by(4).map(|(t, angle)| (*t, angle.to_degrees())))
        .line("−Ω t sin φ", line)
        .save("out/foucault/direction.svg")?;
    let early = |curve: Vec<(f64, f64)>| curve.into_iter().take_while(|p| p.0 <= 60.0).collect::<Vec<_>>();
    Chart::new("Energy gained and work done by the support, seen from the stars")
        .x("time t / √(l/g)")
        .y("energy / m g l")
        .line("energy − energy at the start", early(gain))
        .line("work", early(work))
        .save("out/foucault/energy.svg")?;
    println!("\nWritten to out/foucault: ground.svg, direction.svg, energy.svg, index.html");
    Ok(())
}

/// When the path is furthest out, and in which direction, counted on without jumps; opposite ends count as one
/// direction.
fn outermost(path: &[(f64, f64)], h: f64) -> Vec<(f64, f64)> {
    let square = |(x, y): (f64, f64)| x * x + y * y;
    let mut found = Vec::new();
    let mut angle = PI / 2.0;
    for (i, triple) in path.windows(3).enumerate() {
        let [before, now, after] = [0, 1, 2].map(|k| square(triple[k]));
        if before < now && now >= after {
            // The top of the parabola through three points.
            let part = (before - after) / (before - 2.0 * now + after) / 2.0;
            let (x, y) = triple[1];
            angle += (y.atan2(x) - angle + PI / 2.0).rem_euclid(PI) - PI / 2.0;
            found.push(((i as f64 + 1.0 + part) * h, angle));
        }
    }
    found
}
