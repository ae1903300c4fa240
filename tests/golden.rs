//! The discrete maps themselves, step for step, against 40-digit arithmetic.

use crate::common::*;
use rattle::bodies::One;
use rattle::composition::*;
use rattle::prelude::*;
use rattle::system::System;

#[test]
fn discrete_maps_agree_with_40_digit_arithmetic() {
    let compared: Vec<_> = table("golden_discrete_lemniscate").iter().map(|row| check(row, true)).collect();
    assert_eq!(compared.len(), 20, "RATTLE, four compositions and four Lobatto methods: {compared:?}");
}

/// The same from formulas written a second time, for every method.
#[test]
fn all_methods_agree_with_50_digit_arithmetic() {
    let compared: Vec<_> = table("golden_discrete_methods").iter().map(|row| check(row, false)).collect();
    assert_eq!(compared.len(), 2 * (4 + ALL.len() + 2), "{compared:?}");
}

/// Compares a row, and returns its method. The multipliers of Lobatto methods are not in the table.
fn check(row: &Row, with_multipliers: bool) -> String {
    let (h, n) = (row.number("h"), row.text("n").parse().unwrap());
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let run =
        |coefficients| last(scene.simulate(billiard_45(), Composition::new(coefficients, h)).unwrap(), n);
    let (q, p, multipliers) = match row.text("method") {
        "RATTLE" => last(scene.simulate(billiard_45(), Rattle::new(h)).unwrap(), n),
        "symplectic Euler" => last(scene.simulate(billiard_45(), SymplecticEuler::new(h)).unwrap(), n),
        "geodesic RATTLE" => last(scene.simulate(billiard_45(), Geodesic::new(4, h)).unwrap(), n),
        "position Verlet" => last(scene.simulate(billiard_45(), PositionVerlet::new(h)).unwrap(), n),
        "SHAKE" => {
            let method = Shake::new(h);
            last(scene.simulate(scene.staggered(&billiard_45(), &method).unwrap(), method).unwrap(), n)
        }
        "geodesic RATTLE KAHAN_LI_1997_ORDER_6" => {
            let method = Composition::of(KAHAN_LI_1997_ORDER_6, Geodesic::new(4, h));
            last(scene.simulate(billiard_45(), method).unwrap(), n)
        }
        "position Verlet SUZUKI_1990_ORDER_4" => {
            let method = Composition::of(SUZUKI_1990_ORDER_4, PositionVerlet::new(h));
            last(scene.simulate(billiard_45(), method).unwrap(), n)
        }
        "Suzuki4_s5" => run(SUZUKI_1990_ORDER_4),
        "KahanLi6_s9" => run(KAHAN_LI_1997_ORDER_6),
        "KahanLi8_s17" => run(KAHAN_LI_1997_ORDER_8),
        "SofSpa10_s35" => run(SOFRONIOU_SPALETTA_2005_ORDER_10),
        "LobattoSPARK2" => last(scene.simulate(billiard_45(), Lobatto::<2>::new(h)).unwrap(), n),
        "LobattoSPARK3" => last(scene.simulate(billiard_45(), Lobatto::<3>::new(h)).unwrap(), n),
        "LobattoSPARK4" => last(scene.simulate(billiard_45(), Lobatto::<4>::new(h)).unwrap(), n),
        "LobattoSPARK5" => last(scene.simulate(billiard_45(), Lobatto::<5>::new(h)).unwrap(), n),
        name => run(constant(name)),
    };
    // One rounding of the start is amplified like the motion; the table's README gives 1e-15, 1e-14, 1e-13.
    let bound = if n <= 10 { 1e-15 } else { 1e-13 };
    let what = format!("{} h = {h} n = {n}", row.text("method"));
    let error = distance(q, row.numbers(["x", "y", "z"]));
    assert!(error <= bound, "{what}: position off by {error:e}");
    let error = distance(p, row.numbers(["px", "py", "pz"]));
    assert!(error <= bound, "{what}: momentum off by {error:e}");
    if with_multipliers && !row.text("mu_last").is_empty() {
        // λ is a displacement of rounding size ε divided by h²/2 and |∇g| ≥ 1/3, with the shortest step of all stages.
        let error = distance(multipliers, row.numbers(["lambda_pos_last", "mu_last"]));
        let bound = 3.0 * 2.0 / (h * h) * f64::EPSILON * f64::from(u32::try_from(n).unwrap()).max(8.0);
        assert!(error <= bound, "{what}: multipliers off by {error:e}, allowed {bound:e}");
    }
    what
}

fn last<Y: System<f64, 3, Count = One>, S: Method>(
    mut simulation: Simulation<Y, S, 3>,
    n: u64,
) -> ([f64; 3], [f64; 3], [f64; 2]) {
    let mut trajectory = Trajectory::with_multipliers(&simulation);
    simulation.observe(n, 1, &mut trajectory).unwrap();
    let multipliers = trajectory.multipliers().unwrap();
    let last = |list: &[f64]| *list.last().unwrap();
    let multipliers = [last(&multipliers.position), last(&multipliers.momentum)];
    (simulation.position().into(), simulation.momentum().into(), multipliers)
}
