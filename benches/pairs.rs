//! A step of a gas with a cut-off costs as many operations as there are near pairs: from 1000 bodies to 100 000.
//!
//! ```text
//! cargo bench --bench pairs
//! ```
//!
//! A liquid of Lennard-Jones, ρ = 0.8 and T = 1, in a box that repeats itself, with a reach of 2.5 (some 27 near pairs
//! for each body), and a gas of the same potential on a sphere, 0.4 bodies in a unit of area. Times are of the
//! processor, medians of several runs; the slope is that of log(time per step) over log(bodies), fitted. The gas of 10
//! 000 is timed without cut-off too, by all pairs.

mod common;

use common::{slope, timed};
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use rattle::potentials::LennardJones;
use rattle::prelude::*;
use rattle::surfaces::Sphere;

const ATOMS: LennardJones = LennardJones { epsilon: 1.0, sigma: 1.0 };
const REACH: f64 = 2.5;
const BODIES: [usize; 3] = [1_000, 10_000, 100_000];

fn main() -> Result<(), rattle::Error> {
    let mut all_pairs = 0.0;
    let mut slopes = Vec::new();
    println!("                    bodies   µs per step   ns per body   allocations");
    for (name, on_sphere) in [("liquid in a box", false), ("gas on a sphere", true)] {
        let mut points = Vec::new();
        for n in BODIES {
            let (time, allocations) = if on_sphere { gas(n)? } else { liquid(n)? };
            println!("{name:18} {n:7} {:13.1} {:13.1} {allocations:13}", 1e6 * time, 1e9 * time / n as f64);
            points.push(((n as f64).ln(), time.ln()));
            if n == 10_000 && on_sphere {
                let (sphere, start) = on_a_sphere(n)?;
                all_pairs = timed(sphere.with(ATOMS).simulate(start, Rattle::new(1e-4))?, 1)?.0 / time;
            }
        }
        slopes.push((name, slope(&points)));
    }
    println!();
    for (name, slope) in slopes {
        println!("ratio slope {slope:.3} ({name})");
    }
    println!("ratio all_pairs_over_near_pairs {all_pairs:.1} (10 000 on a sphere)");
    Ok(())
}

/// A liquid that has left its lattice.
fn liquid(n: usize) -> Result<(f64, u64), rattle::Error> {
    let side = (n as f64 / 0.8).cbrt();
    let rows = (n as f64).cbrt().ceil() as usize;
    let mut random = SmallRng::seed_from_u64(1);
    let place = |i: usize| {
        [i % rows, i / rows % rows, i / rows / rows].map(|k| (k as f64 + 0.5) * side / rows as f64)
    };
    let momenta: Vec<[f64; 3]> = (0..n).map(|_| normal(&mut random)).collect();
    let start = State::of((0..n).map(place)).with_momenta(momenta);
    let scene = Scene::points::<3>(n).with(ATOMS.within(REACH).shifted().periodic([side; 3]));
    timed(scene.simulate(start, Rattle::new(0.004))?, 50)
}

/// Bodies on a spiral about a sphere.
fn on_a_sphere(n: usize) -> Result<(Scene<Sphere, (), rattle::bodies::Many, 3>, State<3>), rattle::Error> {
    let r = (n as f64 / (0.4 * 4.0 * std::f64::consts::PI)).sqrt();
    let mut random = SmallRng::seed_from_u64(1);
    let place = |i: usize| {
        let (z, angle) = (1.0 - (2 * i + 1) as f64 / n as f64, 2.399_963_229_728_653 * i as f64);
        let rho = (1.0 - z * z).sqrt();
        [rho * angle.cos(), rho * angle.sin(), z].map(|x| r * x)
    };
    let scene = Scene::on(Sphere { r }).bodies(n);
    let momenta: Vec<[f64; 3]> = (0..n).map(|_| normal(&mut random)).collect();
    let start = scene.project(&State::of((0..n).map(place)).with_momenta(momenta))?;
    Ok((scene, start))
}

fn gas(n: usize) -> Result<(f64, u64), rattle::Error> {
    let (scene, start) = on_a_sphere(n)?;
    timed(scene.with(ATOMS.within(REACH).shifted()).simulate(start, Rattle::new(0.004))?, 50)
}

/// Three numbers of mean 0 and variance 1, nearly normal.
fn normal(random: &mut SmallRng) -> [f64; 3] {
    [(); 3].map(|()| (0..12).map(|_| random.random::<f64>() - 0.5).sum())
}
