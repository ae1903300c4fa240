//! The discrete maps themselves, step for step, against 40-digit arithmetic.

mod common;
use common::*;
use rattle::bodies::One;
use rattle::prelude::*;
use rattle::system::System;

#[test]
fn discrete_maps_agree_with_40_digit_arithmetic() {
    let mut compared = 0;
    for row in table("golden_discrete_lemniscate") {
        let (h, n) = (row.number("h"), row.text("n").parse().unwrap());
        let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
        let (q, p, multipliers) = match row.text("method") {
            "RATTLE" => last(scene.simulate(billiard_45(), Rattle::new(h)).unwrap(), n),
            "Suzuki4_s5" => {
                last(scene.simulate(billiard_45(), Composition::new(SUZUKI_1990_ORDER_4, h)).unwrap(), n)
            }
            _ => continue,
        };
        // One rounding of the start is amplified like the motion; the table's README gives 1e-15, 1e-14, 1e-13.
        let bound = if n <= 10 { 1e-15 } else { 1e-13 };
        let what = format!("{} h = {h} n = {n}", row.text("method"));
        let error = distance(q, row.numbers(["x", "y", "z"]));
        assert!(error <= bound, "{what}: position off by {error:e}");
        let error = distance(p, row.numbers(["px", "py", "pz"]));
        assert!(error <= bound, "{what}: momentum off by {error:e}");
        // λ is a displacement of rounding size ε divided by h²/2 and |∇g| ≥ 1/3.
        let error = distance(multipliers, row.numbers(["lambda_pos_last", "mu_last"]));
        let bound = 3.0 * 2.0 / (h * h) * f64::EPSILON * f64::from(u32::try_from(n).unwrap()).max(8.0);
        assert!(error <= bound, "{what}: multipliers off by {error:e}, allowed {bound:e}");
        compared += 1;
    }
    assert_eq!(compared, 6);
}

fn last<Y: System<f64, 3, Count = One>, S: Stepper>(
    mut simulation: Simulation<Y, S, 3>,
    n: u64,
) -> ([f64; 3], [f64; 3], [f64; 2]) {
    let mut trajectory = Trajectory::with_multipliers(&simulation);
    simulation.run_recording(n, &mut trajectory).unwrap();
    let multipliers = trajectory.multipliers().unwrap();
    let last = |list: &[f64]| *list.last().unwrap();
    let multipliers = [last(&multipliers.position), last(&multipliers.momentum)];
    (simulation.position().into(), simulation.momentum().into(), multipliers)
}

/// Σγ = 1, symmetry, and Σγ³ = 0: the conditions of order 4 for a symmetric composition of order 2.
#[test]
#[allow(clippy::excessive_precision, reason = "40 digits, rounded once")]
fn composition_satisfies_its_order_conditions() {
    let gammas = SUZUKI_1990_ORDER_4.gammas;
    let power_sum = |k: i32| gammas.iter().map(|gamma| gamma.powi(k)).sum::<f64>();
    assert!((power_sum(1) - 1.0).abs() <= f64::EPSILON);
    assert!(power_sum(3).abs() <= f64::EPSILON);
    assert!(gammas.iter().eq(gammas.iter().rev()));
    // 40 digits: 0.4144907717943757371423540628607614957118, −0.6579630871775029485694162514430459828471
    assert_eq!(gammas[0], 0.414_490_771_794_375_737_142_354_062_860_761_495_711_8);
    assert_eq!(gammas[2], -0.657_963_087_177_502_948_569_416_251_443_045_982_847_1);
}
