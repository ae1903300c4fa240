//! The Hopf pendulum: a constraint on positions and momenta together, moved by geometric RATTLE.
//!
//! ```text
//! cargo run --release --example hopf
//! ```
//!
//! A point falls while |q|² + |p|² = 1 holds: on the three-sphere, whose fibres are the circles of the Hopf fibration.
//! The constraint pushes along them, the motion is where the energy is stationary along the fibre: {g, H} = 0. (O.
//! Verdier, *Geometric generalisation of SHAKE and RATTLE*, talk, Toronto 2012.) Some starts come to where that no
//! longer says where to go, and end.
//!
//! Prints how well constraints and energy are kept; draws into `out/hopf`: the motion across its fibres (`fibres.svg`),
//! the energy along fibres (`along.svg`), and its error (`energy.svg`).

use rattle::plot::Chart;
use rattle::prelude::*;

phase_constraint! {
    /// The three-sphere.
    struct Hopf {}
    |q: [f64; 2], p: [f64; 2]| dot(q, q) + dot(p, p) - 1
}

hamiltonian! {
    /// A unit mass that falls along −y.
    struct Falling { g }
    |q: [f64; 2], p: [f64; 2]| dot(p, p) / 2 + g * q[1]
}

const FALLING: Falling = Falling { g: 0.3 };
type Point = [f64; 4];

/// The point of the fibre at this angle: every pair (qᵢ, pᵢ) turned.
fn turned([x, y, px, py]: Point, angle: f64) -> Point {
    let (sin, cos) = angle.sin_cos();
    [x * cos + px * sin, y * cos + py * sin, px * cos - x * sin, py * cos - y * sin]
}

/// The three-sphere in space, projected from the pole q_x = 1, and that seen from the side and above. Fibres are
/// circles, every two of them linked.
fn seen([x, y, px, py]: Point) -> (f64, f64) {
    let scale = 1.0 / (1.0 - x);
    let [a, b, c] = [y * scale, py * scale, px * scale];
    (0.9 * a - 0.44 * b, c + 0.5 * (0.44 * a + 0.9 * b))
}

fn energy([x, y, px, py]: Point) -> f64 {
    Hamiltonian::value(&FALLING, &[x, y].into(), &[px, py].into())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = Scene::in_phase_space(Hopf {}, FALLING);
    let start = scene.project(&State::at([-0.55, -0.83]).moving([0.03, 0.02]))?;
    let mut simulation = scene.simulate(start.clone(), Rattle::new(0.05))?;
    let point = |now: &Simulation<_, _, 2>| -> Point {
        let (q, p) = (now.position(), now.momentum());
        [q.x, q.y, p.x, p.y]
    };

    println!("    t        q                    p               λ     energy error      g    {{g, H}}");
    let mut path = vec![point(&simulation)];
    for _ in 0..=10 {
        let [x, y, px, py] = point(&simulation);
        println!(
            "{:5.1} {x:9.5} {y:9.5} {px:9.5} {py:9.5} {:9.5} {:10.1e} {:10.1e} {:8.1e}",
            simulation.time(),
            simulation.multiplier(),
            simulation.energy_error(),
            simulation.constraint_residual(),
            simulation.cotangent_residual(),
        );
        simulation.run_with(20, |now| path.push(point(now)))?;
    }
    println!("\n{}", simulation.bill()?);

    let fibres = path[..200].iter().step_by(12).map(|&at| {
        let circle = (0..=200).map(move |k| seen(turned(at, f64::from(k) * std::f64::consts::TAU / 200.0)));
        (String::new(), circle.collect::<Vec<_>>())
    });
    Chart::new("The Hopf pendulum crosses its fibres; the constraint pushes along them")
        .equal_aspect()
        .x("0.9 a − 0.44 b,  (a, b, c) = (q_y, p_y, p_x) / (1 − q_x)")
        .y("c + 0.22 a + 0.45 b")
        .family(fibres)
        .line("motion", path.iter().map(|&at| seen(at)))
        .marked("start", [seen(path[0])])
        .save("out/hopf/fibres.svg")?;

    let along = |at: Point| {
        (-180..=180).map(move |degrees| {
            let angle = f64::from(degrees).to_radians();
            (angle, energy(turned(at, angle)))
        })
    };
    let mut chart = Chart::new("Energy along fibres: the motion stays where it is stationary")
        .x("angle along the fibre / rad")
        .y("H");
    for (k, at) in path.iter().enumerate().step_by(70) {
        chart = chart.line(format!("t = {:.1}", 0.05 * k as f64), along(*at));
    }
    let stationary = path.iter().step_by(70).map(|&at| (0.0, energy(at)));
    chart.points("motion", stationary).save("out/hopf/along.svg")?;

    let errors = |method: Composition, label: &str| -> Result<_, rattle::Error> {
        let mut simulation = scene.simulate(start.clone(), method)?;
        let mut errors = Vec::new();
        simulation.run_with(2000, |now| errors.push((now.time(), now.energy_error())))?;
        Ok((label.to_owned(), errors))
    };
    let order_4 = errors(Composition::new(SUZUKI_1990_ORDER_4, 0.05), "order 4")?;
    let mut rattle = scene.simulate(start.clone(), Rattle::new(0.05))?;
    let mut order_2 = Vec::new();
    rattle.run_with(2000, |now| order_2.push((now.time(), now.energy_error())))?;
    println!("\nLargest energy errors to t = 100, h = 0.05:");
    for (name, errors) in [("RATTLE", &order_2), ("order 4", &order_4.1)] {
        println!("  {name:8} {:.1e}", errors.iter().map(|e| e.1.abs()).fold(0.0, f64::max));
    }
    Chart::new("Energy error, h = 0.05")
        .x("time t")
        .y("H − H₀")
        .line("RATTLE", order_2)
        .line("order 4", order_4.1)
        .save("out/hopf/energy.svg")?;

    // From here the motion comes to a fold of {g, H} = 0 over the space of fibres.
    let (q, p) = ([0.3, 0.4], [0.75_f64.sqrt() * 1.0_f64.cos(), 0.75_f64.sqrt() * 1.0_f64.sin()]);
    let [x, y, px, py] = turned([q[0], q[1], p[0], p[1]], 1.040_765_8);
    let folding = scene.project(&State::at([x, y]).moving([px, py]))?;
    let mut ending = scene.simulate(folding, Rattle::new(0.01))?;
    if let Err(error) = ending.run(400) {
        println!("\nAnother start ends at t = {:.2}, exact 2.58986:\n  {error}", ending.time());
    }
    println!("\nWritten to out/hopf: fibres.svg, along.svg, energy.svg");
    Ok(())
}
