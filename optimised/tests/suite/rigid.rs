//! Rigid bodies: flips about the middle axis, equal and nearly equal moments, needles, tops, steps too long.

use crate::common::table;
use crate::suite::case::{Case, Kind, Measured};
use crate::suite::scenes::{E, ends, larger, largest, relative_energy, unless};
use rattle::Error;
use rattle::composition::KAHAN_LI_1997_ORDER_8;
use rattle::error::{RigidFailure, StepFailure};
use rattle::nalgebra::{Matrix3, Vector3};
use rattle::prelude::*;

potential! {
    /// A top's weight: its centre of mass lies on its third axis.
    struct Top { weight }
    |q: [[f64; 3]; 3]| weight * q[2][2]
}

/// A body with this angular momentum, upright at the start.
fn turning<S: Method + 'static>(
    moments: [f64; 3],
    weight: f64,
    m: [f64; 3],
    method: S,
) -> Result<BoxedSimulation<9>, Error> {
    let start = Rigid::start(&Matrix3::identity(), &m.into());
    Ok(Scene::rigid(Rigid::new(moments)).with(Top { weight }).simulate(start, method)?.boxed())
}

fn attitude(now: &BoxedSimulation<9>) -> Matrix3<f64> {
    Rigid::attitude(&now.positions().next().unwrap().into())
}

/// Angular momentum in the body's axes.
fn in_body(now: &BoxedSimulation<9>) -> Vector3<f64> {
    let p = now.momenta().next().unwrap();
    Vector3::new(p[0], p[1], p[2])
}

fn in_space(now: &BoxedSimulation<9>) -> Vector3<f64> {
    attitude(now) * in_body(now)
}

const UNEVEN: [f64; 3] = [0.6, 0.8, 1.0];

pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    let flip = Kind {
        why: "the middle axis is unstable: each flip magnifies what rounding did",
        expect: "the angular momentum in space stays through all flips of 20 000 steps",
        reason: "three numbers that nothing rounds but their own change, and the reading",
    };
    for off in [1e-1, 1e-3, 1e-6, 1e-9] {
        cases.push(flip.case(format!("flips, disturbed by {off:e}"), 16.0 * E, move || {
            let simulation = turning(UNEVEN, 0.0, [off, 1.0, 0.0], Rattle::new(0.05))?;
            let first = in_space(&simulation);
            let mut flips = simulation.clone();
            let flipped = flips.run_while(20_000, |now| in_body(now).y > -0.9)?;
            assert!(flipped < 20_000, "it flips");
            largest(simulation, 20_000, move |now| (in_space(now) - first).amax())
        }));
    }
    let energy = Kind {
        why: "a method that turns the body by Euler's equations gains or loses energy at each flip",
        expect: "the energy of the free body stays",
        reason: "RATTLE keeps it exactly here; compensated sums, and the reading",
    };
    for (name, moments) in [
        ("uneven", UNEVEN),
        ("a lamina", [1.0, 2.0, 3.0]),
        ("nearly a lamina", [1.0, 2.0, 3.0 - 1e-12]),
        ("equal but for 1e-8", [1.0, 1.0 + 1e-8, 1.0 + 2e-8]),
        ("equal but for 1e-15", [1.0, 1.0, 1.0 + 1e-15]),
        ("a needle, 1 : 1e-3", [1.0, 1.0, 1e-3]),
        ("a needle, 1 : 1e-6", [1.0, 1.0, 1e-6]),
        ("light, 1e-100", [0.6e-100, 0.8e-100, 1e-100]),
        ("heavy, 1e100", [0.6e100, 0.8e100, 1e100]),
    ] {
        cases.push(energy.case(format!("free body, {name}"), 16.0 * E, move || {
            let i = moments;
            let m = [0.7 * i[0], 0.5 * i[1], 0.4 * i[2]];
            relative_energy(turning(i, 0.0, m, Rattle::new(0.05))?, 20_000)
        }));
    }
    let orthogonal = Kind {
        why: "products of rotations drift away from rotations",
        expect: "QᵀQ = 1 after 100 000 steps",
        reason: "what the step solves to, rounded: nine products",
    };
    cases.push(orthogonal.case("attitude after 100 000 steps", 1e-14, || {
        let mut simulation = turning(UNEVEN, 0.0, [1.8, 0.4, -0.9], Rattle::new(0.05))?;
        simulation.run(100_000)?;
        let q = attitude(&simulation);
        Ok((q.transpose() * q - Matrix3::identity()).amax())
    }));
    let symmetric = Kind {
        why: "with two equal moments a formula that divides by their difference is 0/0",
        expect: "the momentum about the axis of symmetry stays",
        reason: "compensated sums, and the reading",
    };
    for (name, difference) in [("equal", 0.0), ("equal but for 1e-15", 1e-15)] {
        cases.push(symmetric.case(format!("spinning top, moments {name}"), 16.0 * E, move || {
            let moments = [1.0, 1.0 + difference, 0.4];
            let simulation = turning(moments, 0.7, [0.3, 0.2, 2.0], Rattle::new(0.02))?;
            largest(simulation, 20_000, |now| (in_body(now).z - 2.0).abs())
        }));
    }
    let vertical = Kind {
        why: "without symmetry, a weight that turns the body about a horizontal axis turns it about the vertical",
        expect: "the vertical angular momentum of a heavy top stays",
        reason: "compensated sums, and the reading",
    };
    for (name, moments) in [("symmetric", [1.0, 1.0, 0.4]), ("uneven", UNEVEN)] {
        cases.push(vertical.case(format!("heavy top, {name}"), 16.0 * E, move || {
            let simulation = turning(moments, 0.7, [0.3, 0.2, 2.0], Rattle::new(0.02))?;
            let first = in_space(&simulation).z;
            largest(simulation, 20_000, move |now| (in_space(now).z - first).abs())
        }));
    }
    let sleeping = Kind {
        why: "upright on its axis a top is in equilibrium: rounding of one sign topples it",
        expect: "the fast top sleeps on; disturbed by 1e-8 it leans no further than some 1e-8",
        reason: "a stable oscillation of the size of the disturbance",
    };
    cases.push(sleeping.case("sleeping top, disturbed by 1e-8", 1e-8, || {
        let simulation = turning([1.0, 1.0, 0.4], 0.7, [1e-8, 0.0, 4.0], Rattle::new(0.02))?;
        largest(simulation, 20_000, |now| attitude(now)[(0, 2)].hypot(attitude(now)[(1, 2)]))
    }));
    cases.push(sleeping.case("sleeping top, undisturbed", 0.0, || {
        let simulation = turning([1.0, 1.0, 0.4], 0.7, [0.0, 0.0, 4.0], Rattle::new(0.02))?;
        largest(simulation, 20_000, |now| attitude(now)[(0, 2)].hypot(attitude(now)[(1, 2)]))
    }));
    let truth = Kind {
        why: "attitude and momentum are solved for by turns: an error of one hides in the other",
        expect: "the solution to 30 digits in tests/data, by steps of order 8",
        reason: "rounding, grown with time",
    };
    for (t, bound) in [(1.0, 1e-13), (20.0, 1e-12)] {
        cases.push(truth.case(format!("free body at t = {t}"), bound, move || solution(t)));
    }
    let long = Kind {
        why: "no rotation solves the step: Newton's method wanders among numbers",
        expect: "an error with the turn of the step",
        reason: "each is refused",
    };
    for h in [1.3, 10.0, 1000.0] {
        cases.push(long.case(format!("steps of {h} where a radian takes 0.5"), 0.0, move || {
            let run = turning(UNEVEN, 0.0, [1.8, 0.4, -0.9], Rattle::new(h)).and_then(|now| ends(now, 100));
            let far = |error: &Error| {
                matches!(
                    error,
                    Error::Step { cause: StepFailure::Rigid(RigidFailure::TurnsTooFar { .. }), .. }
                )
            };
            Ok(unless(run, far))
        }));
    }
    let rest = Kind { why: "the solve of a body at rest is 0/0", expect: "it rests", reason: "bit for bit" };
    cases.push(rest.case("body at rest, 1000 steps", 0.0, || {
        let simulation = turning(UNEVEN, 0.0, [0.0; 3], Rattle::new(0.05))?;
        largest(simulation, 1000, |now| (attitude(now) - Matrix3::identity()).amax())
    }));
    cases
}

fn solution(t: f64) -> Measured {
    let rows = table("rigid_body");
    let row = rows.iter().find(|row| row.number("t") == t).expect("a row of this time");
    let mut simulation =
        turning(UNEVEN, 0.0, [1.8, 0.4, -0.9], Composition::new(KAHAN_LI_1997_ORDER_8, 0.02))?;
    simulation.run((t / 0.02).round() as u64)?;
    let exact = row.numbers(["Q11", "Q12", "Q13", "Q21", "Q22", "Q23", "Q31", "Q32", "Q33"]);
    let off = (attitude(&simulation) - Matrix3::from_row_slice(&exact)).amax();
    let exact = Vector3::from(row.numbers(["m1", "m2", "m3"]));
    assert!(off.is_nan() || off > E / 64.0, "decimals are rounded");
    Ok(larger(off, (in_body(&simulation) - exact).amax()))
}
