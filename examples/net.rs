//! A net of rods, pinned at two corners, falls.
//!
//! ```text
//! cargo run --release --example net
//! g = |qᵢ − qⱼ|² − ℓ²  for every two neighbours,   U = g Σ z
//! ```
//!
//! 31 × 31 knots in space: 1860 equations that share one component. At first the net is at rest, folded once into a
//! gutter, and pinned at the two corners of one of its ends; it swings down. The first line says how the multipliers
//! are found, the table what the steps cost and keep.
//!
//! Draws the net at four times into `out/net/`, and writes the page `out/net/index.html` on which it moves.

use rattle::links::Rod;
use rattle::nalgebra::Vector3;
use rattle::plot::Chart;
use rattle::potentials::Gravity;
use rattle::prelude::*;
use rattle::view::{Page, Scene3};
use std::error::Error;

/// Knots along a side; the sides have length 1.
const N: usize = 31;
const LINK: f64 = 1.0 / (N - 1) as f64;

/// Slope of the two halves of the gutter.
const FOLD: f64 = 0.8;

fn knot(row: usize, column: usize) -> usize {
    row * N + column
}

fn main() -> Result<(), Box<dyn Error>> {
    let along = (0..N).flat_map(|i| (1..N).map(move |j| [knot(i, j - 1), knot(i, j)]));
    let across = (0..N).flat_map(|j| (1..N).map(move |i| [knot(i - 1, j), knot(i, j)]));
    let rods: Vec<[usize; 2]> = along.chain(across).collect();
    let scene = Scene::points(N * N)
        .link(Rod { length: LINK }, rods.iter().copied())
        .pin(knot(0, 0), [0.0, 0.0, 0.0])
        .pin(knot(0, N - 1), [FOLD.cos(), 0.0, 0.0])
        .with(Gravity { g: 1.0 });
    let place = |k: usize| {
        let (row, column) = (k / N, k % N);
        let deep = column.min(N - 1 - column) as f64;
        [column as f64 * LINK * FOLD.cos(), row as f64 * LINK, -deep * LINK * FOLD.sin()]
    };
    let start = scene.project(&State::of((0..N * N).map(place)))?;
    let mut simulation = scene.simulate(start, Rattle::new(1e-3))?;
    for component in simulation.system().components() {
        println!("{component}");
    }

    println!(
        "energies in units of the weight of a knot times the side\n\n   t    kinetic energy   energy error   |g|/ℓ²   corrections per step   derivatives per step"
    );
    let (mut snapshots, mut film) = (Vec::new(), Trajectory::of(&simulation));
    for _ in 0..=7 {
        let (steps, counts) = (simulation.steps().max(1) as f64, simulation.counts());
        println!(
            "{:4.1} {:14.3} {:14.1e} {:11.0e} {:13.2} {:22.2}",
            simulation.time(),
            simulation.kinetic_energy(),
            simulation.energy_error(),
            simulation.constraint_residual() / LINK.powi(2),
            counts.corrections as f64 / steps,
            counts.gradients as f64 / steps
        );
        snapshots.push((simulation.time(), threads(&simulation.positions().collect::<Vec<_>>())));
        simulation.observe(200, 20, &mut film)?;
    }
    println!("\n{}", simulation.bill()?);

    // Side by side and drawn slantwise: what is further back is further up and to the right.
    let apart = 1.6;
    let chosen = snapshots
        .into_iter()
        .filter(|(t, _)| [0.0, 0.6, 1.0, 1.4].iter().any(|chosen| (t - chosen).abs() < 1e-9));
    let nets = chosen.enumerate().map(|(i, (t, net))| {
        let flat = net.into_iter().map(move |q| (q.x + 0.45 * q.y + apart * i as f64, q.z + 0.3 * q.y));
        (format!("t = {t:.1}"), flat.collect::<Vec<_>>())
    });
    Chart::new("A net falls")
        .x(format!("x + 0.45 y, in sides of the net; from picture to picture {apart} further"))
        .y("z + 0.3 y")
        .equal_aspect()
        .family(nets.collect::<Vec<_>>())
        .save("out/net/fall.svg")?;
    let ends = rods.iter().map(|&[a, b]| (a, b));
    let caption = "961 knots and 1860 rods, pinned at two corners.";
    let shown = Scene3::new("Net").trajectory(&film).rods(ends).caption(caption).seconds(6.0);
    Page::new("A net falls").scene(shown).write("out/net/index.html")?;
    println!("\nWritten to out/net: fall.svg, index.html");
    Ok(())
}

/// One line through all knots along every rod: rows to and fro, then columns.
fn threads(q: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let to_and_fro = |i: usize, j: usize| if i.is_multiple_of(2) { j } else { N - 1 - j };
    let rows = (0..N).flat_map(|i| (0..N).map(move |j| knot(i, to_and_fro(i, j))));
    // With N odd the rows end in the last knot; from there the columns, last one first.
    let columns = (0..N).rev().flat_map(|j| (0..N).rev().map(move |i| knot(to_and_fro(j, i), j)));
    rows.chain(columns).map(|k| q[k]).collect()
}
