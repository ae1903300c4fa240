//! A slider-crank with one guide too many: redundant equations, and where leaving one out goes wrong.
//!
//! ```text
//! cargo run --release --example slider_crank
//! crank |a| = r     rod b = 2a − c, |b − c| = 2r     slider b_y = 0     cross guide c_x = 0
//! ```
//!
//! The crank turns the middle a of a rod twice its length, whose end b slides along x; then the other end c runs along
//! y by itself. Six equations between six coordinates leave one freedom: one equation is redundant. With unit masses
//! the inertia is constant, and the angle of the crank obeys 5 r φ̈ = −3 g cos φ: that is the reference.
//!
//! * All six: rank 5, and the motion is right. Of all multipliers that fit, those are given that are smallest together,
//!   as forces λ|∇g|.
//! * Without the crank: the same motion and the same force on every body, from five equations.
//! * Without the cross guide: until the crank stands upright. There b could stay at the middle while the rod turns on:
//!   the mechanism branches, and the step is refused.
//!
//! Draws the mechanism and the multipliers into `out/slider_crank/`, and writes a page on which it turns.

use rattle::bill::Bill;
use rattle::links::planar::Rod;
use rattle::plot::Chart;
use rattle::potentials::planar::Gravity;
use rattle::prelude::*;
use rattle::view::{Page, Scene3};
use std::error::Error;
use std::f64::consts::PI;

constraint! {
    /// From the origin to a.
    struct Crank { r }
    |x, y| x^2 + y^2 - r^2
}

constraint! {
    /// a is the middle between b and c.
    struct Middle {}
    |a: [f64; 2], b: [f64; 2], c: [f64; 2]| [a[0] - (b[0] + c[0]) / 2, a[1] - (b[1] + c[1]) / 2]
}

constraint! {
    /// Keeps to the x axis.
    struct AlongX {}
    |_x, y| y
}

constraint! {
    /// Keeps to the y axis.
    struct AlongY {}
    |x, _y| x
}

potential! {
    /// The weights of all three over the angle of the crank.
    struct Turn { g, r }
    |angle| 3 * g * r * sin(angle)
}

/// Bodies a, b and c.
const START: [[f64; 2]; 3] = [[R, 0.0], [2.0 * R, 0.0], [0.0, 0.0]];
const R: f64 = 1.0;
const G: f64 = 1.0;
/// φ̇ at φ = 0: enough to turn over.
const SPEED: f64 = 2.0;
const T: f64 = 20.0;

/// What one variant did.
#[derive(Default)]
struct Run {
    /// Coordinates of a, b and c every ten steps.
    places: Vec<[f64; 6]>,
    /// Forces of all constraints on a, b and c.
    forces: Vec<[f64; 6]>,
    /// t, and λ|∇g| of every equation.
    pulls: Vec<(f64, Vec<f64>)>,
    /// φ at the end, without jumps.
    angle: f64,
    /// What a step costs.
    bill: Option<Bill>,
}

/// Runs one variant and prints its row, without the end of the line.
fn run(crank: bool, guide: bool, h: f64) -> Result<(Run, Option<rattle::Error>), rattle::Error> {
    let mut scene = Scene::points(3)
        .link(Middle {}, [[0, 1, 2]])
        .link(Rod { length: 2.0 * R }, [[1, 2]])
        .link(AlongX {}, [[1]])
        .with(Gravity { g: G });
    let mut gradients = vec![1.5_f64.sqrt(), 1.5_f64.sqrt(), 32_f64.sqrt() * R, 1.0];
    if guide {
        scene = scene.link(AlongY {}, [[2]]);
        gradients.push(1.0);
    }
    if crank {
        scene = scene.link(Crank { r: R }, [[0]]);
        gradients.push(2.0 * R);
    }
    let start = State::of(START).with_momenta([[0.0, R * SPEED], [0.0, 0.0], [0.0, 2.0 * R * SPEED]]);
    let mut simulation = scene.simulate(start, Rattle::new(h))?;
    let rank = simulation.system().components().map(|component| component.rank).sum::<usize>();
    let (mut run, mut energy_error, mut residual) = (Run::default(), 0.0_f64, 0.0_f64);
    let mut see = |now: &Simulation<_, _, 2>| {
        let q: Vec<_> = now.positions().collect();
        run.angle += (q[0].y.atan2(q[0].x) - run.angle + PI).rem_euclid(2.0 * PI) - PI;
        energy_error = energy_error.max(now.energy_error().abs());
        residual = residual.max(now.constraint_residual());
        if now.steps() % 10 == 0 {
            let forces = now.constraint_forces();
            run.places.push(std::array::from_fn(|i| q[i / 2][i % 2]));
            run.forces.push(std::array::from_fn(|i| forces[i / 2][i % 2]));
            let pulls = now.multipliers().iter().zip(&gradients).map(|(l, g)| l * g).collect();
            run.pulls.push((now.time(), pulls));
        }
    };
    see(&simulation);
    let ended = simulation.run_with((T / h).round() as u64, see);
    run.bill = simulation.bill().ok();
    print!("{:6} {rank:6} {h:8.4} {energy_error:12.1e} {residual:9.0e}", gradients.len());
    Ok((run, ended.err()))
}

/// φ(T) from 5 r φ̈ = −3 g cos φ, by a method of order 4.
fn exact() -> Result<f64, rattle::Error> {
    let inertia = 5.0 * R * R;
    let scene = Scene::point().mass(inertia).with(Turn { g: G, r: R });
    let start = State::at([0.0]).moving([inertia * SPEED]);
    let mut simulation = scene.simulate(start, Composition::new(SUZUKI_1990_ORDER_4, 1e-3))?;
    simulation.run((T / 1e-3_f64).round() as u64)?;
    Ok(simulation.position().x)
}

fn main() -> Result<(), Box<dyn Error>> {
    let exact = exact()?;
    println!("equations  rank     h   energy error    |g|   φ(20) − exact");
    let (six, _) = run(true, true, 0.01)?;
    println!("{:14.2e}", six.angle - exact);
    for h in [0.005, 0.0025] {
        println!("{:14.2e}", run(true, true, h)?.0.angle - exact);
    }
    let (five, _) = run(false, true, 0.01)?;
    println!("{:14.2e}   without the crank", five.angle - exact);
    let (branching, ended) = run(true, false, 0.01)?;
    println!("         ended   without the cross guide");

    let largest = |a: &[[f64; 6]], b: &[[f64; 6]]| {
        let numbers = a.as_flattened().iter().zip(b.as_flattened());
        numbers.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let size = |run: &Run| {
        let squares = run.pulls.iter().flat_map(|(_, pulls)| pulls).map(|f| f * f);
        (squares.sum::<f64>() / run.pulls.len() as f64).sqrt()
    };
    println!(
        "\nWith the crank and without, largest difference: in place {:.0e}, in the force on a body {:.0e}",
        largest(&six.places, &five.places),
        largest(&six.forces, &five.forces)
    );
    println!("√ of the mean of Σ (λ|∇g|)²: {:.3} and {:.3}", size(&six), size(&five));
    if let Some(bill) = &six.bill {
        println!("\n{bill}\n");
    }
    if let Some(error) = ended {
        println!("Without the cross guide, at φ = {:.2}°:\n  {error}", branching.angle.to_degrees());
    }

    let rods = six
        .places
        .iter()
        .take(33)
        .zip(&six.pulls)
        .map(|(q, (t, _))| (format!("t = {t:.1}"), [(q[2], q[3]), (q[4], q[5])]));
    Chart::new("One turn: the rod, every 0.1 √(r/g)")
        .x("x / r")
        .y("y / r")
        .equal_aspect()
        .family(rods.collect::<Vec<_>>())
        .save("out/slider_crank/rod.svg")?;
    let pull = |run: &Run, equation: usize| {
        run.pulls.iter().take(100).map(|(t, pulls)| (*t, pulls[equation])).collect::<Vec<_>>()
    };
    Chart::new("Crank and cross guide: multipliers of least norm share the load")
        .x("time t / √(r/g)")
        .y("force λ|∇g| / m g")
        .line("crank", pull(&six, 5))
        .line("guide", pull(&six, 4))
        .line("guide, no crank", pull(&five, 4))
        .save("out/slider_crank/forces.svg")?;
    let path =
        |body: usize| six.places.iter().map(|q| [q[2 * body], 0.0, q[2 * body + 1]]).collect::<Vec<_>>();
    let times: Vec<f64> = six.pulls.iter().map(|(t, _)| *t).collect();
    let along = |equation: usize| six.pulls.iter().map(|(_, pulls)| pulls[equation]).collect::<Vec<_>>();
    let shown = Scene3::new("Slider-crank")
        .bodies(&times, &[0, 1, 2].map(path))
        .names(["a", "b", "c"])
        .rods([(0, [0.0; 3])])
        .rods([(1, 0), (0, 2)])
        .disc([0.0, 0.08, 0.0], [0.0, 1.0, 0.0], R)
        .axes(["x / r", "", "y / r"])
        .chart("Forces of crank and cross guide", [("crank", along(5)), ("guide", along(4))]);
    Page::new("A slider-crank").scene(shown).write("out/slider_crank/index.html")?;
    println!("\nWritten to out/slider_crank: rod.svg, forces.svg, index.html");
    Ok(())
}
