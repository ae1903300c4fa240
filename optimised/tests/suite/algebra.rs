//! Masses apart by twelve digits, dependent and contradictory equations, mechanisms that branch, chains and hubs.

use crate::common::linked::Rod;
use crate::common::table;
use crate::suite::case::{Case, Kind, Measured};
use crate::suite::scenes::*;
use rattle::Error;
use rattle::composition::KAHAN_LI_1997_ORDER_8;
use rattle::error::{LinkedFailure, StartFailure, StepFailure};
use rattle::prelude::*;

/// Two rods under a pin, the second one upright, as in `double_pendulum.csv`.
fn double_pendulum(masses: [f64; 2]) -> Rods {
    Rods {
        places: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]],
        masses: vec![1.0, masses[0], masses[1]],
        rods: vec![[0, 1], [1, 2]],
        pins: vec![0],
        g: 1.0,
        ..Rods::default()
    }
}

/// A chain of length and mass one.
fn chain(links: usize) -> Rods {
    let length = 1.0 / links as f64;
    Rods {
        places: (0..=links).map(|i| [i as f64 * length, 0.0]).collect(),
        masses: vec![length; links + 1],
        rods: (0..links).map(|i| [i, i + 1]).collect(),
        pins: vec![0],
        g: 1.0,
        ..Rods::default()
    }
}

/// A free quadrilateral that turns and moves, braced by these rods.
fn braced(rods: &[[usize; 2]]) -> Rods {
    Rods {
        places: vec![[0.0, 0.0], [1.0, 0.0], [1.1, 1.0], [0.0, 0.9]],
        momenta: vec![[0.3, 0.1], [0.2, 1.0], [-0.7, 0.6], [-0.5, -0.2]],
        rods: rods.to_vec(),
        ..Rods::default()
    }
}

const SIDES: [[usize; 2]; 5] = [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2]];

pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    let light = Kind {
        why: "the matrix of inverse masses has entries apart by that ratio",
        expect: "the energy swings by the method's own h², and the rods keep their lengths",
        reason: "second order; equal masses swing wider than a light tip",
    };
    for ratio in [1.0, 1e-3, 1e-6, 1e-9, 1e-12] {
        cases.push(light.case(
            format!("double pendulum, tip of mass {ratio:?}"),
            if ratio < 1.0 { 1e-6 } else { 1e-5 },
            move || {
                let simulation = double_pendulum([1.0, ratio]).simulate(Rattle::new(1e-3))?;
                largest(simulation, 10_000, move |now| now.energy_error().abs() / (1.0 + ratio))
            },
        ));
    }
    let lengths = Kind {
        why: "a residual that is weighed by masses leaves the rod of the light body unsolved",
        expect: "|q|² of each rod stays",
        reason: "coordinates of up to 2, which the solve leaves within 4 ε",
    };
    for ratio in [1e-12, 1e-6, 1e6] {
        cases.push(lengths.case(format!("rods of masses 1 and {ratio:e}"), 4.0 * E, move || {
            let h = if ratio > 1.0 { 1e-6 } else { 1e-3 };
            let simulation = double_pendulum([1.0, ratio]).simulate(Rattle::new(h))?;
            largest(simulation, 10_000, |now| now.constraint_residual())
        }));
    }
    let heavy = Kind {
        why: "a light joint between heavy bodies whips at the rate √(m₂/m₁): long steps miss it in silence",
        expect: "with steps that resolve it the energy stays until t = 20, as a part of the masses",
        reason: "second order, a hundredth with a tenth of the step; 0.043 by a program in Python",
    };
    for (h, bound) in [(1e-4, 0.1), (1e-5, 1e-3)] {
        cases.push(heavy.long(format!("double pendulum, tip of mass 1000, h = {h:e}"), bound, move || {
            let simulation = double_pendulum([1.0, 1e3]).simulate(Rattle::new(h))?;
            largest(simulation, (20.0 / h) as u64, |now| now.energy_error().abs() / 1001.0)
        }));
    }
    let truth = Kind {
        why: "λ from a matrix that is solved badly shows in the ninth digit of a place, not in g",
        expect: "the solution to 30 digits in tests/data",
        reason: "rounding, spread by the motion's own instability",
    };
    for t in [0.5, 1.0, 2.0] {
        cases.push(truth.case(format!("double pendulum at t = {t}, order 8"), 1e-14, move || solution(t)));
    }
    let dependent = Kind {
        why: "G M⁻¹ Gᵀ is singular: a factorisation divides by rounding",
        expect: "the motion is that of the independent equations",
        reason: "300 roundings at random, 17 ε, and the motion's own spread",
    };
    for copies in [2, 3, 10] {
        cases.push(dependent.case(format!("each rod {copies} times"), 1e-14, move || {
            let mut again = double_pendulum([1.0, 1.0]);
            again.rods = (0..copies).flat_map(|_| [[0, 1], [1, 2]]).collect();
            same_motion(&double_pendulum([1.0, 1.0]), &again)
        }));
    }
    cases.push(dependent.case("quadrilateral with both diagonals", 1e-14, || {
        let mut both = SIDES.to_vec();
        both.push([1, 3]);
        same_motion(&braced(&SIDES), &braced(&both))
    }));
    let other = Kind {
        why: "the order in which equations are eliminated decides what rounding does",
        expect: "elimination and an orthonormal basis give one motion",
        reason: "300 roundings at random, 17 ε, and the motion's own spread",
    };
    cases.push(other.case("quadrilateral, elimination and basis", 1e-14, || {
        let by = |algebra| Rods { algebra, ..braced(&SIDES) };
        same_motion(&by(LinearAlgebra::Elimination), &by(LinearAlgebra::Orthogonal))
    }));
    cases.push(other.case("chain of 20, elimination and basis", 1e-14, || {
        let by = |algebra| Rods { algebra, ..chain(20) };
        same_motion(&by(LinearAlgebra::Elimination), &by(LinearAlgebra::Orthogonal))
    }));
    let thin = Kind {
        why: "three rods nearly in one line: their normals differ by the height, the matrix by its square",
        expect: "the turning triangle keeps its energy",
        reason: "the condition does not show: roundings of the turning and of the reading",
    };
    for height in [1e-2, 1e-4, 1e-6] {
        cases.push(thin.case(format!("triangle of height {height:e}"), 16.0 * E, move || triangle(height)));
    }
    let contradictory = Kind {
        why: "no place satisfies all: a solver goes on for ever, or ends at a compromise",
        expect: "an error that names the equation",
        reason: "each is refused",
    };
    cases.push(contradictory.case("two rods of other lengths between two bodies", 0.0, || {
        let pair = Rods { places: vec![[0.0, 0.0], [1.0, 0.0]], ..Rods::default() };
        let rods = vec![(Rod { length: 1.0 }, [0, 1]), (Rod { length: 1.001 }, [0, 1])];
        Ok(unless(pair.simulate_with(rods, Rattle::new(0.01)), |error| matches!(error, Error::Start { .. })))
    }));
    cases.push(contradictory.case("a rod longer than its pins are apart", 0.0, || {
        let pinned = Rods { places: vec![[0.0, 0.0], [1.0, 0.0]], pins: vec![0, 1], ..Rods::default() };
        let rods = vec![(Rod { length: 2.0 }, [0, 1])];
        let between =
            |error: &Error| matches!(error, Error::Start { cause: StartFailure::BetweenPins { .. }, .. });
        Ok(unless(pinned.simulate_with(rods, Rattle::new(0.01)), between))
    }));
    cases.push(contradictory.case("a rod of length zero", 0.0, || {
        let pair = Rods { places: vec![[0.0, 0.0], [0.0, 0.0]], ..Rods::default() };
        let rods = vec![(Rod { length: 0.0 }, [0, 1])];
        Ok(unless(pair.simulate_with(rods, Rattle::new(0.01)), |error| matches!(error, Error::Start { .. })))
    }));
    let branch = Kind {
        why: "two motions meet: rounding chooses one, another with each step size",
        expect: "the run ends with an error that says that normals became dependent",
        reason: "each step size is refused there",
    };
    for h in [0.02, 0.01, 0.001] {
        cases.push(branch.case(format!("parallelogram into its flat position, h = {h}"), 0.0, move || {
            let ended = parallelogram(0.0).simulate(Rattle::new(h)).and_then(|now| ends(now, 1_000_000));
            let lost = |error: &Error| {
                matches!(
                    error,
                    Error::Step { cause: StepFailure::Linked(LinkedFailure::RankLost { .. }), .. }
                )
            };
            Ok(unless(ended, lost))
        }));
    }
    let near = Kind {
        why: "next to a branch the matrix is nearly singular and the motion fast",
        expect: "a crank that clears the flat position goes on with its energy",
        reason: "h²/clearance: the way curves by 1/√clearance",
    };
    for clearance in [0.1, 0.03] {
        cases.push(near.case(
            format!("four bars, pins {clearance} farther apart than the coupler"),
            1e-6 / clearance,
            move || relative_energy(parallelogram(clearance).simulate(Rattle::new(1e-3))?, 20_000),
        ));
    }
    let long = Kind {
        why: "a tolerance on displacements is out of reach at its end; the matrix has the condition n²",
        expect: "each rod keeps its length, as a part of it, while the chain falls",
        reason: "coordinates of size one rounded by ε against rods of 1/n",
    };
    for links in [10, 100, 1000] {
        let n = links as f64;
        let case = long.case(format!("falling chain of {links}"), E * n, move || {
            largest(chain(links).simulate(Rattle::new(2e-4))?, 1000, move |now| {
                now.constraint_residual() * n * n / 2.0
            })
        });
        cases.push(Case { long: links > 100, ..case });
    }
    let hangs = Kind {
        why: "forces along a chain cancel body by body; what is left of them is rounding that shakes it",
        expect: "a chain that hangs at rest stays",
        reason: "the last place of the lowest body",
    };
    for links in [10, 100] {
        cases.push(hangs.case(format!("hanging chain of {links}"), E, move || hanging(links)));
    }
    let hub = Kind {
        why: "one body of many rods couples all equations: n² entries",
        expect: "the energy of a turning star of free rods stays",
        reason: "(h·κ·|v|)² of rods of length 1 that turn with v = 1, h = 0.01",
    };
    for rods in [10, 300] {
        cases.push(hub.case(format!("star of {rods} rods"), 1e-4, move || {
            relative_energy(star(rods).simulate(Rattle::new(0.01))?, 300)
        }));
    }
    let free = Kind {
        why: "constraint forces that are not opposite to the last bit move the centre of mass",
        expect: "the sum of momenta stays",
        reason: "compensated sums lose nothing: rounding of the reading, and of forces",
    };
    cases.push(free.case("free quadrilateral, 3000 steps", 16.0 * E, || {
        let simulation = braced(&SIDES).simulate(Rattle::new(0.01))?;
        let sum = |now: &BoxedSimulation<2>| now.momenta().sum::<rattle::nalgebra::Vector2<f64>>();
        let first = sum(&simulation);
        largest(simulation, 3000, move |now| (sum(now) - first).amax())
    }));
    cases
}

fn solution(t: f64) -> Measured {
    let rows = table("double_pendulum");
    let row = rows
        .iter()
        .find(|row| row.text("case") == "equal" && row.number("t") == t)
        .expect("a row of this time");
    let mut simulation =
        double_pendulum([1.0, 1.0]).simulate(Composition::new(KAHAN_LI_1997_ORDER_8, 0.01))?;
    simulation.run((t / 0.01).round() as u64)?;
    let exact = [row.numbers(["x1", "y1"]), row.numbers(["x2", "y2"])];
    let off = simulation.positions().skip(1).zip(exact).map(|(q, exact)| crate::common::distance(q, exact));
    Ok(off.fold(0.0, larger))
}

fn same_motion(one: &Rods, other: &Rods) -> Measured {
    let [one, other] = [one, other].map(|rods| {
        let mut simulation = rods.simulate(Rattle::new(0.005))?;
        let start = simulation.state();
        simulation.run(300)?;
        assert!(apart(&simulation.state(), &start) > 0.1, "it moves");
        Ok::<_, Error>(simulation.state())
    });
    Ok(apart(&one?, &other?))
}

fn triangle(height: f64) -> Measured {
    let turning = Rods {
        places: vec![[-1.0, 0.0], [0.0, height], [1.0, 0.0]],
        momenta: vec![[0.0, -1.0], [-height, 0.0], [0.0, 1.0]],
        rods: vec![[0, 1], [1, 2], [0, 2]],
        ..Rods::default()
    };
    // A body that turns freely: the error of the method is one of its rate, so that the energy stays.
    relative_energy(turning.simulate(Rattle::new(0.01))?, 2000)
}

/// Two upright cranks of length 1 on pins that are 2 apart, or farther by so much, and a coupler of 2.
fn parallelogram(farther: f64) -> Rods {
    Rods {
        places: vec![[0.0, 0.0], [2.0 + farther, 0.0], [0.0, 1.0], [2.0, 1.0]],
        momenta: vec![[0.0; 2], [0.0; 2], [1.0, 0.0], [1.0, 0.0]],
        rods: vec![[0, 2], [2, 3], [3, 1]],
        pins: vec![0, 1],
        ..Rods::default()
    }
}

fn hanging(links: usize) -> Measured {
    let mut rods = chain(links);
    for place in &mut rods.places {
        *place = [0.0, -place[0]];
    }
    let simulation = rods.simulate(Rattle::new(1e-3))?;
    let start = simulation.state();
    largest(simulation, 1000, move |now| {
        now.positions().zip(start.positions()).map(|(q, first)| (q - first).amax()).fold(0.0, larger)
    })
}

/// Rods from a free body in the middle, which turn.
fn star(rods: usize) -> Rods {
    let angle = |i: usize| std::f64::consts::TAU * i as f64 / rods as f64;
    let end = |i: usize| [angle(i).cos(), angle(i).sin()];
    Rods {
        places: std::iter::once([0.0; 2]).chain((0..rods).map(end)).collect(),
        momenta: std::iter::once([0.0; 2])
            .chain((0..rods).map(|i| [-end(i)[1] * (1.0 + 0.5 * (i as f64).sin()), 0.7 * end(i)[0]]))
            .collect(),
        rods: (1..=rods).map(|i| [0, i]).collect(),
        ..Rods::default()
    }
}
