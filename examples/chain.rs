//! A chain of rods held at both ends: it swings, and comes to rest as a catenary.
//!
//! ```text
//! cargo run --release --example chain
//! gₖ = |qₖ₊₁ − qₖ|² − ℓ²,  k = 0 … n−1,   q₀ and qₙ pinned,   total mass 1
//! ```
//!
//! 1. A thousand links, let go from a lopsided V: energy, iterations, and where the chain is from time to time. The
//!    work for a step grows with the number of links, not with its cube.
//! 2. Two hundred links, which a drag slows down until they hang at rest. The shape of such a chain is known exactly,
//!    and comes close to the catenary y = a cosh(x/a); so does the tension.
//!
//! Draws into `out/chain/`, and writes a page on which the long chain swings.

use rattle::bodies::Many;
use rattle::effect::{Effects, LinearDrag};
use rattle::links::planar::Rod;
use rattle::nalgebra::Vector2;
use rattle::network::Network;
use rattle::plot::Chart;
use rattle::potentials::planar::Gravity;
use rattle::prelude::*;
use rattle::view::{Page, Scene3};
use std::error::Error;

/// Length of the chain; its supports are 1 apart.
const LENGTH: f64 = 2.0;
/// Of the way to the other end, where the V has its tip.
const TIP: f64 = 0.65;

/// n links between joints of mass 1/n each.
fn chain(n: usize) -> Scene<Network<2>, impl Effects<2>, Many, 2> {
    let mass = 1.0 / n as f64;
    Scene::points(n + 1)
        .link(Rod { length: LENGTH / n as f64 }, (0..n).map(|k| [k, k + 1]))
        .pin(0, [0.0, 0.0])
        .pin(n, [1.0, 0.0])
        .mass(mass)
        .with(Gravity { g: mass })
}

/// Both halves of the V straight.
fn lopsided(n: usize) -> State<2> {
    let (left, right) = (TIP * LENGTH, (1.0 - TIP) * LENGTH);
    let x = (left.powi(2) - right.powi(2) + 1.0) / 2.0;
    let (tip, end) = (Vector2::new(x, -(left.powi(2) - x * x).sqrt()), Vector2::new(1.0, 0.0));
    State::of((0..=n).map(|k| {
        let s = k as f64 / n as f64;
        if s < TIP { tip * (s / TIP) } else { tip + (end - tip) * ((s - TIP) / (1.0 - TIP)) }
    }))
}

fn main() -> Result<(), Box<dyn Error>> {
    swing()?;
    hang()
}

fn swing() -> Result<(), Box<dyn Error>> {
    let (n, h) = (1000, 2e-4);
    let scene = chain(n);
    let mut simulation = scene.simulate(scene.project(&lopsided(n))?, Rattle::new(h))?;
    for component in simulation.system().components() {
        println!("{component}");
    }
    println!("\n   t     kinetic energy   energy error     |g|/ℓ²   corrections per step");
    let (mut snapshots, mut film) = (Vec::new(), Trajectory::of(&simulation));
    for _ in 0..=10 {
        println!(
            "{:5.2} {:15.5} {:15.1e} {:11.1e} {:14.2}",
            simulation.time(),
            simulation.kinetic_energy(),
            simulation.energy_error(),
            simulation.constraint_residual() * (n as f64 / LENGTH).powi(2),
            simulation.counts().corrections as f64 / simulation.steps().max(1) as f64
        );
        let label = format!("t = {:.1}", simulation.time());
        snapshots.push((label, simulation.positions().map(|q| (q.x, q.y)).collect::<Vec<_>>()));
        simulation.observe(1000, 50, &mut film)?;
    }
    println!("\n{}", simulation.bill()?);
    Chart::new("A chain of 1000 links let go from a lopsided V")
        .x("x / distance of the supports")
        .y("y / distance of the supports")
        .equal_aspect()
        .family(snapshots)
        .save("out/chain/swing.svg")?;
    let upright = upright(&film);
    let shown =
        Scene3::new("A chain of 1000 links").bodies(film.times(), &upright).chain(0..=n).seconds(20.0);
    Page::new("A chain let go from a lopsided V").scene(shown).write("out/chain/index.html")?;
    Ok(())
}

/// The paths of a motion in the plane, with y upwards in space.
fn upright(film: &Trajectory) -> Vec<Vec<[f64; 3]>> {
    (0..film.shape()[1]).map(|body| film.path(body).map(|q| [q[0], 0.0, q[1]]).collect()).collect()
}

fn hang() -> Result<(), Box<dyn Error>> {
    let (n, damping) = (200, 2.5); // makes the slowest swing die out soonest
    let scene = chain(n).with(LinearDrag::new(damping / n as f64)); // joints have mass 1/n
    let mut simulation = scene.simulate(scene.project(&lopsided(n))?, Rattle::new(0.002))?;
    let mut snapshots = Vec::new();
    for (label, steps) in [
        ("t = 0", 0),
        ("t = 0.4", 200),
        ("t = 0.8", 200),
        ("t = 1.2", 200),
        ("t = 1.6", 200),
        ("at rest", 19_200),
    ] {
        simulation.run(steps)?;
        snapshots.push((label, simulation.positions().map(|q| (q.x, q.y)).collect::<Vec<_>>()));
    }
    println!("\n{n} links at rest: kinetic energy {:.0e}\n", simulation.kinetic_energy());
    // |∇g λ| on either end of a link.
    let tension: Vec<_> = simulation.multipliers().iter().map(|l| -2.0 * l * LENGTH / n as f64).collect();
    compare(&simulation.positions().collect::<Vec<_>>(), &tension, simulation.constraint_forces()[n])?;
    Chart::new("Coming to rest: 200 links, damped")
        .x("x / distance of the supports")
        .y("y / distance of the supports")
        .equal_aspect()
        .family(snapshots)
        .save("out/chain/hang.svg")?;
    println!("\nWritten to out/chain: swing.svg, hang.svg, tension.svg, index.html");
    Ok(())
}

/// The zero of an increasing function between 0 and `high`.
fn zero(f: impl Fn(f64) -> f64, high: f64) -> f64 {
    let (mut low, mut high) = (0.0, high);
    for _ in 0..200 {
        let middle = (low + high) / 2.0;
        if f(middle) < 0.0 { low = middle } else { high = middle }
    }
    (low + high) / 2.0
}

fn compare(q: &[Vector2<f64>], tension: &[f64], pull: Vector2<f64>) -> Result<(), Box<dyn Error>> {
    let n = tension.len();
    let (link, weight) = (LENGTH / n as f64, 1.0 / n as f64);
    // Link k pulls with H across and Vₖ up, as many joints' weight as hang on it; its direction is that of its pull.
    let up = |k: usize| weight * (k as f64 - (n as f64 - 1.0) / 2.0);
    let across = zero(|h| (0..n).map(|k| link * h / h.hypot(up(k))).sum::<f64>() - 1.0, 10.0);
    let (mut at, mut worst) = (Vector2::zeros(), [0.0_f64; 4]);
    // 2a sinh(1/2a) is the length between supports at distance 1.
    let a = zero(|a| LENGTH - 2.0 * a * (0.5 / a).sinh(), 10.0);
    let density = 1.0 / LENGTH;
    let (mut found, mut exact) = (Vec::new(), Vec::new());
    for k in 0..n {
        let middle = (q[k].x + q[k + 1].x) / 2.0;
        let catenary = density * a * ((middle - 0.5) / a).cosh();
        let height = a * (((q[k].x - 0.5) / a).cosh() - (0.5 / a).cosh());
        let off = [
            (q[k] - at).norm(),
            (q[k].y - height).abs(),
            (tension[k] / across.hypot(up(k)) - 1.0).abs(),
            (tension[k] / catenary - 1.0).abs(),
        ];
        worst = [0, 1, 2, 3].map(|i| worst[i].max(off[i]));
        at += Vector2::new(across, up(k)) * (link / across.hypot(up(k)));
        if k % 8 == 4 {
            found.push((middle, tension[k]));
        }
        exact.push((middle, catenary));
    }
    println!("largest difference             from the exact chain of links    from the catenary");
    println!("place / distance of supports {:24.1e} {:24.1e}", worst[0], worst[1]);
    println!("tension, relative            {:24.1e} {:24.1e}", worst[2], worst[3]);
    println!("pull on the right support: ({:.9}, {:.9}); exact H = {across:.9}", pull.x, pull.y);
    Chart::new("Tension of the hanging chain")
        .x("x / distance of the supports")
        .y("tension / weight of the chain")
        .line("catenary, H cosh((x − ½)/a)", exact)
        .points("links, from the multipliers", found)
        .save("out/chain/tension.svg")?;
    Ok(())
}
