//! A bicycle chain: links around two sprockets, driven at one and braked at the other.
//!
//! ```text
//! cargo run --release --example bicycle_chain
//! |qᵢ₊₁ − qᵢ|² = ℓ²   for every two neighbours, the last and the first too
//! U = g Σ y + k/2 Σ max(0, r − |q − c|)²          the sprockets are stiff, and push outwards alone
//! ```
//!
//! The driving force goes along the chain where it lies on the right sprocket, and grows for five seconds; the brake on
//! the left one is drag. In the end both do the same work, and the chain runs with one speed: push × links on the right
//! = brake × speed × links on the left.
//!
//! Writes the page `out/bicycle_chain/index.html`.

use rattle::links::planar::Rod;
use rattle::potentials::planar::Gravity;
use rattle::prelude::*;
use rattle::view::{Page, Scene3};
use std::error::Error;

potential! {
    /// Two discs of radius r at (±c, 0).
    struct Sprockets { stiffness, r, c }
    |x, y| stiffness / 2 * (max(0, r - hypot(x - c, y))^2 + max(0, r - hypot(x + c, y))^2)
}

force! {
    /// A push along the right disc, clockwise, and drag on the left one.
    struct Drive { push, brake, r, c }
    |x, y, vx, vy, t| {
        let right = hypot(x - c, y);
        let left = hypot(x + c, y);
        let pushed = if right < 1.05 * r { push * min(t / 5, 1) / right } else { 0 };
        let braked = if left < 1.05 * r { brake } else { 0 };
        [pushed * y - braked * vx, -pushed * (x - c) - braked * vy]
    }
}

const LINKS: usize = 72;
const R: f64 = 1.0;
const C: f64 = 2.0;

/// The place after a part of the way around, clockwise from the top of the left disc.
fn around(share: f64) -> [f64; 2] {
    let (half, side) = (std::f64::consts::PI * R, 2.0 * C);
    let way = share * 2.0 * (half + side);
    let (sign, way) = if way < half + side { (1.0, way) } else { (-1.0, way - half - side) };
    let (sin, cos) = ((way - side).max(0.0) / R).sin_cos();
    [sign * (way.min(side) - C + R * sin), sign * R * cos]
}

fn main() -> Result<(), Box<dyn Error>> {
    let places = (0..LINKS).map(|i| around(i as f64 / LINKS as f64));
    let length = 2.0 * (std::f64::consts::PI * R + 2.0 * C) / LINKS as f64;
    let scene = Scene::points(LINKS)
        .link(Rod { length }, (0..LINKS).map(|i| [i, (i + 1) % LINKS]))
        .with(Gravity { g: 1.0 })
        .with(Sprockets { stiffness: 4e3, r: R, c: C })
        .with(Drive { push: 1.0, brake: 0.5, r: R, c: C });
    let start = scene.project(&State::of(places))?;
    let mut simulation = scene.simulate(start, Rattle::new(2e-3))?;

    println!("   t    mean speed   energy    work      energy error   |g|");
    let (mut times, mut shown) = (Vec::new(), vec![Vec::new(); LINKS]);
    let (mut energies, mut speeds) = ([Vec::new(), Vec::new()], Vec::new());
    for frame in 0..=800 {
        let speed = simulation.momenta().map(|p| p.norm()).sum::<f64>() / LINKS as f64;
        if frame % 80 == 0 {
            println!(
                "{:5.1} {speed:11.4} {:10.3} {:9.3} {:13.1e} {:9.0e}",
                simulation.time(),
                simulation.energy(),
                simulation.work(),
                simulation.energy_error(),
                simulation.constraint_residual()
            );
        }
        times.push(simulation.time());
        speeds.push(speed);
        energies[0].push(simulation.energy());
        energies[1].push(simulation.work());
        shown.iter_mut().zip(simulation.positions()).for_each(|(shown, q)| shown.push([q.x, 0.0, q.y]));
        simulation.run(25)?;
    }
    println!("\n{}", simulation.bill()?);
    let shown = Scene3::new("Bicycle chain")
        .bodies(&times, &shown)
        .ring(0..LINKS)
        .disc([-C, 0.0, 0.0], [0.0, 1.0, 0.0], 0.97 * R)
        .disc([C, 0.0, 0.0], [0.0, 1.0, 0.0], 0.97 * R)
        .chart("Mean speed of the links", [("", speeds)])
        .chart("Energy", ["energy", "work"].into_iter().zip(energies))
        .seconds(40.0);
    let caption = "Driven on the right, braked on the left.";
    Page::new("Bicycle chain").scene(shown.caption(caption)).write("out/bicycle_chain/index.html")?;
    println!("Written: out/bicycle_chain/index.html");
    Ok(())
}
