//! A free body and a heavy top, each in three formulations: QᵀQ = 1 as six equations, as nine of which three are
//! redundant, and reduced to three unknowns. All are the same discrete motion.
//!
//! ```text
//! cargo run --release --example rigid_body        # then open out/rigid_body/index.html and *.svg
//! ```

use rattle::bill::Bill;
use rattle::bodies::One;
use rattle::links::RotationMatrix;
use rattle::nalgebra::{Matrix3, Rotation3, Vector3};
use rattle::plot::Chart;
use rattle::prelude::*;
use rattle::system::System;
use rattle::view::{Page, Scene3};

constraint! {
    /// QᵀQ = 1, the mixed equations twice.
    struct Redundant {}
    |m: [[f64; 3]; 3]| for i in 0..3, j in 0..3 { sum(k in 0..3, m[k][i] * m[k][j]) - delta(i, j) }
}

potential! {
    /// The weight of a top whose centre of mass lies on its third axis; z points up in space.
    struct Weight { mgl }
    |q: [[f64; 3]; 3]| mgl * q[2][2]
}

const H: f64 = 0.02;
const STEPS: u64 = 2500;

/// Time, attitude, and angular momentum in the body's frame.
type Sample = (f64, Matrix3<f64>, Vector3<f64>);

/// A run step by step, and the largest energy error.
struct Run {
    path: Vec<Sample>,
    energy_error: f64,
    bill: Bill,
}

fn run<Y: System<f64, 9, Count = One>>(
    mut simulation: Simulation<Y, Rattle, 9>,
    momentum: fn(&Matrix3<f64>, &[f64; 9]) -> Vector3<f64>,
) -> Result<Run, rattle::Error> {
    let mut run = Run { path: Vec::new(), energy_error: 0.0, bill: simulation.bill()? };
    for _ in 0..STEPS {
        let attitude = Rigid::attitude(&simulation.position().into());
        run.path.push((simulation.time(), attitude, momentum(&attitude, &simulation.momentum().into())));
        run.energy_error = run.energy_error.max(simulation.energy_error().abs());
        simulation.step()?;
    }
    Ok(run)
}

/// The same motion in the three formulations.
fn formulations(
    body: Rigid,
    mgl: f64,
    attitude: &Matrix3<f64>,
    m: &Vector3<f64>,
) -> Result<[(&'static str, Run); 3], rattle::Error> {
    let d = body.column_masses();
    let masses: [f64; 9] = std::array::from_fn(|k| d[k % 3]);
    let start = State::at(Rigid::coordinates(attitude)).moving(body.matrix_momenta(attitude, m));
    let six = Scene::on(RotationMatrix {}).mass(masses).with(Weight { mgl });
    let nine = Scene::on(Redundant {}).mass(masses).with(Weight { mgl });
    let reduced = Scene::rigid(body).with(Weight { mgl });
    let nine = nine.simulate(start.clone(), Rattle::new(H))?;
    println!(
        "  nine equations: {}",
        nine.system().components().next().map_or(String::new(), |c| c.to_string())
    );
    Ok([
        ("six equations", run(six.simulate(start, Rattle::new(H))?, Rigid::angular_momentum_of_matrix)?),
        ("nine equations", run(nine, Rigid::angular_momentum_of_matrix)?),
        (
            "reduced",
            run(reduced.simulate(Rigid::start(attitude, m), Rattle::new(H))?, |_, p| {
                Vector3::new(p[0], p[1], p[2])
            })?,
        ),
    ])
}

/// Prints how far the formulations are apart, and how well each keeps what should stay.
fn compare(runs: &[(&'static str, Run); 3], kept: &str, constant: fn(&Matrix3<f64>, &Vector3<f64>) -> f64) {
    println!(
        "  {:16} {:>22} {:>14} {:>18} {:>10}",
        "", "largest energy error", kept, "apart from reduced", "ns a step"
    );
    let reduced = &runs[2].1.path;
    for (name, run) in runs {
        let at_start = constant(&run.path[0].1, &run.path[0].2);
        let change = run.path.iter().map(|(_, q, m)| (constant(q, m) - at_start).abs()).fold(0.0, f64::max);
        let apart = run.path.iter().zip(reduced).map(|(a, b)| (a.1 - b.1).amax()).fold(0.0, f64::max);
        println!(
            "  {name:16} {:22.1e} {change:14.1e} {apart:18.1e} {:10.0}",
            run.energy_error, run.bill.step
        );
    }
}

/// A line for the first formulation, points for the others, so that all can be seen where they coincide.
fn overlay(chart: Chart, runs: &[(&'static str, Run); 3], point: fn(&Sample) -> (f64, f64)) -> Chart {
    runs.iter().enumerate().fold(chart, |chart, (i, (name, run))| match i {
        0 => chart.line(*name, run.path.iter().map(point)),
        _ => chart.points(*name, run.path.iter().skip(20 * i).step_by(60).map(point)),
    })
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!(
        "a free body, I = (0.6, 0.8, 1.0), turning nearly about its middle axis (h = {H}, {STEPS} steps)"
    );
    let free =
        formulations(Rigid::new([0.6, 0.8, 1.0]), 0.0, &Matrix3::identity(), &Vector3::new(0.01, 1.6, 0.0))?;
    compare(&free, "change of |Qm|", |q, m| (q * m).norm());
    overlay(
        Chart::new("A free body turns over, again and again")
            .x("time")
            .y("angular momentum about the middle axis"),
        &free,
        |&(t, _, m)| (t, m.y),
    )
    .save("out/rigid_body/free.svg")?;

    println!("\na heavy top, I = (1, 1, 0.4), spinning at 12, leaning by 30°, weight × distance = 1");
    let leaning = Rotation3::from_axis_angle(&Vector3::x_axis(), 30_f64.to_radians());
    let top = formulations(
        Rigid::new([1.0, 1.0, 0.4]),
        1.0,
        leaning.matrix(),
        &Vector3::new(0.0, 0.0, 0.4 * 12.0),
    )?;
    compare(&top, "change of Lz", |q, m| (q * m).z);
    overlay(
        Chart::new("The tip of a heavy top, from above").x("x").y("y").equal_aspect(),
        &top,
        |(_, q, _)| (q[(0, 2)], q[(1, 2)]),
    )
    .save("out/rigid_body/top.svg")?;
    // Boxes with these moments of inertia: squares of the sides a, b, c are as I₂ + I₃ − I₁, …
    let times: Vec<f64> = free[2].1.path.iter().map(|(t, _, _)| *t).collect();
    let turns = |runs: &[(&str, Run); 3]| runs[2].1.path.iter().map(|(_, q, _)| *q).collect::<Vec<_>>();
    let middle = |runs: &[(&str, Run); 3]| runs[2].1.path.iter().map(|(_, _, m)| m.y).collect::<Vec<_>>();
    let tumbling = Scene3::new("free body")
        .times(&times)
        .turning_box([1.2, 0.8, 0.4].map(f64::sqrt), &[[0.0; 3]], &turns(&free))
        .chart("Angular momentum about the middle axis (green)", [("", middle(&free))]);
    // … and those of the top are about its tip: a plate of sides a, a, c on a stick of length l, l² = a²/3 − c²/12.
    let [a, c] = [0.9, 0.15_f64];
    let l = (a * a / 3.0 - c * c / 12.0).sqrt();
    let centres: Vec<[f64; 3]> = turns(&top).iter().map(|q| (l * q.column(2)).into()).collect();
    let leaning = Scene3::new("heavy top")
        .bodies(&times, &[&centres])
        .rods([(0, [0.0; 3])])
        .turning_box([a, a, c], &centres, &turns(&top))
        .wall([-1.0, -1.0, 0.0], [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0]]);
    Page::new("Rigid bodies").scene(tumbling).scene(leaning).write("out/rigid_body/index.html")?;
    println!("\n{}", top[2].1.bill);
    println!("\nout/rigid_body/free.svg and top.svg: the formulations lie on each other");
    Ok(())
}
