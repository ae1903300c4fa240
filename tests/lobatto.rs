//! Lobatto IIIA–IIIB on surfaces: coefficients, the discrete map, orders, structure.

mod common;
use common::*;
use rattle::lobatto::Table;
use rattle::prelude::*;

/// Stages with a table.
const STAGES: std::ops::RangeInclusive<usize> = 2..=9;

fn each(stages: usize) -> &'static Table {
    Lobatto::new(stages, 1.0).table()
}

#[test]
fn coefficients_satisfy_their_conditions() {
    for s in STAGES {
        let Table { nodes, weights, positions } = each(s);
        assert_eq!((nodes.len(), weights.len(), positions.len()), (s, s, s - 1));
        let exact = |power: i32| 1.0 / f64::from(power + 1);
        // Quadrature is exact for polynomials of degree 2s − 3.
        for power in 0..=2 * s as i32 - 3 {
            let sum: f64 = nodes.iter().zip(*weights).map(|(c, b)| b * c.powi(power)).sum();
            assert!((sum - exact(power)).abs() < 4.0 * f64::EPSILON, "s = {s}, power {power}: {sum}");
        }
        // Σⱼ aᵢⱼ cⱼᵏ = cᵢᵏ⁺²/((k + 1)(k + 2)) for k ≤ s − 3: positions are exact for accelerations of that degree.
        for (i, row) in positions.iter().enumerate() {
            assert_eq!(row.len(), s - 1);
            for power in 0..=s as i32 - 3 {
                let sum: f64 = row.iter().zip(*nodes).map(|(a, c)| a * c.powi(power)).sum();
                let expected = nodes[i + 1].powi(power + 2) / f64::from((power + 1) * (power + 2));
                assert!((sum - expected).abs() < 4.0 * f64::EPSILON, "s = {s}, row {i}, power {power}");
            }
        }
        // The last row is bⱼ(1 − cⱼ), as symplecticity asks for: the quadrature of ∫ (1 − t) q̈ dt.
        for (j, a) in positions[s - 2].iter().enumerate() {
            assert!((a - weights[j] * (1.0 - nodes[j])).abs() < 2.0 * f64::EPSILON, "s = {s}, column {j}");
        }
        // Symmetry: read backwards in time, the method is the same.
        for j in 0..s {
            assert!((nodes[j] + nodes[s - 1 - j] - 1.0).abs() < 2.0 * f64::EPSILON);
            assert!((weights[j] - weights[s - 1 - j]).abs() < 2.0 * f64::EPSILON);
        }
    }
}

#[test]
fn the_discrete_maps_agree_with_40_digit_arithmetic() {
    let mut compared = 0;
    for row in table("golden_discrete_lemniscate") {
        let Some(stages) = row.text("method").strip_prefix("LobattoSPARK") else { continue };
        let (stages, h, n) =
            (stages.parse().unwrap(), row.number("h"), row.text("n").parse::<u64>().unwrap());
        let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
        let mut simulation = scene.simulate(billiard_45(), Lobatto::new(stages, h)).unwrap();
        simulation.run(n).unwrap();
        let error = distance(simulation.position(), row.numbers(["x", "y", "z"]));
        assert!(error <= 1e-15, "s = {stages}, n = {n}: position off by {error:e}");
        let error = distance(simulation.momentum(), row.numbers(["px", "py", "pz"]));
        assert!(error <= 4e-15, "s = {stages}, n = {n}: momentum off by {error:e}");
        compared += 1;
    }
    assert_eq!(compared, 8);
}

#[test]
fn orders_2_to_16_on_the_spherical_pendulum() {
    let rows = table("spherical_pendulum");
    let row = rows.iter().find(|row| row.text("case") == "a" && row.number("t") == 5.0).unwrap();
    let exact = row.numbers(["x", "y", "z"]);
    let alpha = std::f64::consts::FRAC_PI_3;
    let scene = Scene::on(Sphere { radius: 1.0 }).with(Gravity { g: 1.0 });
    let start = State::at([alpha.sin(), 0.0, -alpha.cos()]).moving([0.0, 1.5, 0.0]);
    let start = scene.project(&start).unwrap();
    // Steps where errors lie between 1e-2 and 1e-13.
    let steps = [
        [40, 60, 80],
        [16, 24, 32],
        [12, 18, 24],
        [9, 13, 18],
        [8, 12, 16],
        [6, 8, 10],
        [5, 6, 7],
        [4, 5, 6],
    ];
    for (s, steps) in STAGES.zip(steps) {
        let points = steps.map(|n| {
            let mut simulation = scene.simulate(start.clone(), Lobatto::new(s, 5.0 / n as f64)).unwrap();
            simulation.run(n).unwrap();
            let error = distance(simulation.position(), exact);
            assert!((1e-14..0.1).contains(&error), "s = {s}, {n} steps: {error:e}");
            ((1.0 / n as f64).ln(), error.ln())
        });
        let mean = |f: fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / 3.0;
        let (x, y) = (mean(|p| p.0), mean(|p| p.1));
        let slope = (mean(|p| p.0 * p.1) - x * y) / (mean(|p| p.0 * p.0) - x * x);
        println!("s = {s}: slope {slope:.2}, errors {:?}", points.map(|(_, e)| e.exp()));
        // Long steps are not yet in the limit: an eighth of the order.
        let order = f64::from(Lobatto::new(s, 1.0).order());
        assert!((slope - order).abs() < order / 8.0, "s = {s}: slope {slope}");
    }
}

#[test]
fn forth_and_back_and_on_the_surface() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    for s in STAGES {
        for h in [0.02, 0.05] {
            let start = billiard_45();
            let mut forth =
                scene.simulate(start.clone(), Lobatto::new(s, if s == 2 { 0.5 * h } else { h })).unwrap();
            forth.run(20).unwrap();
            assert!(forth.constraint_residual() < 1e-15 && forth.cotangent_residual() < 1e-15);
            let mut back =
                scene.simulate(forth.state(), Lobatto::new(s, -forth.stepper().step_size())).unwrap();
            back.run(20).unwrap();
            let error = distance(back.position(), start.positions().next().unwrap());
            println!("s = {s} h = {h}: {error:e}");
            assert!(error < 2e-14, "s = {s}: {error:e}");
        }
    }
}
