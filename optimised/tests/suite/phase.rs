//! Constraints on phase space: the sphere |q|² + |p|² = r², whose fibres are those of Hopf.

use crate::common::{distance, table};
use crate::suite::case::{Case, Kind, Measured};
use crate::suite::scenes::{E, apart, ends, larger, largest, unless};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle::Error;
use rattle::composition::SOFRONIOU_SPALETTA_2005_ORDER_10;
use rattle::error::{PhaseFailure, PhaseMistake, StartFailure, StepFailure};
use rattle::prelude::*;

phase_constraint! {
    /// The three-sphere, as c·g = 0.
    struct Hopf { c, r }
    |q: [f64; 2], p: [f64; 2]| c * (dot(q, q) + dot(p, p) - r^2)
}

phase_constraint! {
    /// Three-spheres, π/k apart in the sum of squares.
    struct Shells { k }
    |q: [f64; 2], p: [f64; 2]| sin(k * (dot(q, q) + dot(p, p) - 1))
}

hamiltonian! {
    /// An oscillator in a field.
    struct Swing { k, g }
    |q: [f64; 2], p: [f64; 2]| dot(p, p) / 2 + k * dot(q, q) / 2 + g * q[1]
}

const UNIT: Hopf = Hopf { c: 1.0, r: 1.0 };
const FALLING: Swing = Swing { k: 0.0, g: 0.3 };

fn simulate<S: Method + 'static>(
    (sphere, energy): (Hopf, Swing),
    start: State<2>,
    method: S,
) -> Result<BoxedSimulation<2>, Error> {
    Ok(Scene::in_phase_space(sphere, energy).simulate(start, method)?.boxed())
}

/// A start of the references.
fn start(name: &str) -> State<2> {
    let rows = table("hopf_pendulum");
    let row = rows.iter().find(|row| row.text("start") == name && row.number("t") == 0.0).expect("a start");
    State::at(row.numbers(["q1", "q2"])).moving(row.numbers(["p1", "p2"]))
}

/// The same in a unit 1/r of q and p: with g·r it is the same motion.
fn larger_by(state: &State<2>, r: f64) -> State<2> {
    State::at(state.positions().next().unwrap() * r).moving(state.momenta().next().unwrap() * r)
}

pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    let golden = Kind {
        why: "a fibre, a circle, meets the hidden constraint several times: a far root goes unseen",
        expect: "the discrete map in 50-digit arithmetic, tests/data",
        reason: "one rounding of the start, which grows like t",
    };
    for n in [1_u32, 10, 100] {
        let bound = 1e-15 * (1.0 + f64::from(n));
        cases.push(golden.case(format!("Hopf pendulum, discrete map, {n} steps"), bound, move || map(n)));
    }
    let truth = Kind {
        why: "forces and multipliers act on positions too: a method for mechanics has another order here",
        expect: "the solution to 30 digits in tests/data, by steps of order 10",
        reason: "rounding, grown like t²",
    };
    for (name, t) in [("B", 1.0), ("B", 20.0), ("C", 1.0), ("C", 20.0)] {
        let case =
            truth.case(format!("Hopf pendulum, start {name}, t = {t}"), 2e-14, move || solution(name, t));
        cases.push(Case { long: t > 1.0, ..case });
    }
    let scaled = Kind {
        why: "the parameter of fibres has the inverse scale of g, and a tolerance on g has its own",
        expect: "c·g = 0 moves like g = 0",
        reason: "200 roundings at random, at most 14 of ε/2",
    };
    for c in [-2e-2, 1e-100, 1e-8, 1e8, 1e100] {
        cases.push(scaled.case(format!("Hopf pendulum, g times {c:e}"), 2e-15, move || {
            let end = |c| after((Hopf { c, r: 1.0 }, FALLING), start("B"), 200);
            Ok(apart(&end(c)?, &end(1.0)?))
        }));
    }
    let sized = Kind {
        why: "what is small against one is taken for zero",
        expect: "another radius in a field as much stronger: the same motion in its own unit",
        reason: "200 roundings at random, at most 14 of ε/2",
    };
    for r in [1e-50, 1e-6, 1e6, 1e50] {
        cases.push(sized.case(format!("Hopf pendulum of radius {r:e}"), 2e-15, move || {
            let scene = (Hopf { c: 1.0, r }, Swing { k: 0.0, g: 0.3 * r });
            let end = after(scene, larger_by(&start("B"), r), 200)?;
            Ok(apart(&larger_by(&end, 1.0 / r), &after((UNIT, FALLING), start("B"), 200)?))
        }));
    }
    let back = Kind {
        why: "an inner solve that ends early makes the map irreversible",
        expect: "as many steps back end at the start",
        reason: "roundings of ε/2, spread with time",
    };
    for (n, bound) in [(20_u32, 1e-15), (1000, 1e-14)] {
        cases.push(back.case(format!("Hopf pendulum, {n} steps and back"), bound, move || {
            let mut there = simulate((UNIT, FALLING), start("B"), Rattle::new(0.02))?;
            there.run(n.into())?;
            let mut back = simulate((UNIT, FALLING), there.state(), Rattle::new(-0.02))?;
            back.run(n.into())?;
            Ok(apart(&back.state(), &start("B")))
        }));
    }
    let kept = Kind {
        why: "energy and constraint are not separate here: projection onto one drifts along the other",
        expect: "the energy swings with h² and does not drift in 20 000 steps; g and {g, H} hold",
        reason: "the swing of a run of 10⁵ steps; four coordinates rounded by ε/2 with slopes of 2",
    };
    cases.push(kept.long("Hopf pendulum, energy", 1.2e-4, || {
        largest(simulate((UNIT, FALLING), start("B"), Rattle::new(0.1))?, 20_000, |now| {
            now.energy_error().abs()
        })
    }));
    cases.push(kept.long("Hopf pendulum, constraints", 3e-15, || {
        let simulation = simulate((UNIT, FALLING), start("B"), Rattle::new(0.1))?;
        largest(simulation, 20_000, |now| larger(now.constraint_residual(), now.cotangent_residual()))
    }));
    let shells = Kind {
        why: "a corrector that converges does not tell which of the shells in phase space it found",
        expect: "of 300 random motions none leaves its shell; where it could, the step is refused",
        reason: "each is counted",
    };
    for k in [30.0, 1e3, 3e4] {
        let name = format!("shells π/{k:e} apart in |q|² + |p|²");
        cases.push(shells.long(name, 0.0, move || Ok(leave_their_shell(k))));
    }
    let refused = Kind {
        why: "no multiplier is determined, or none keeps the constraint: any number is an answer",
        expect: "an error that says which condition fails",
        reason: "each is refused",
    };
    cases.push(refused.case("a Hamiltonian that commutes with the constraint", 0.0, || {
        let run = simulate((UNIT, Swing { k: 1.0, g: 0.0 }), start("B"), Rattle::new(0.1));
        Ok(mistaken(run, |mistake| matches!(mistake, PhaseMistake::Undetermined { .. })))
    }));
    cases.push(refused.case("a start off the sphere", 0.0, || {
        let run = simulate((UNIT, FALLING), State::at([0.5, 0.5]), Rattle::new(0.1));
        Ok(mistaken(run, |mistake| matches!(mistake, PhaseMistake::Off { .. })))
    }));
    cases.push(refused.case("a start on the sphere that leaves it", 0.0, || {
        let run = simulate((UNIT, FALLING), State::at([0.6, 0.0]).moving([0.8, 0.0]), Rattle::new(0.1));
        Ok(mistaken(run, |mistake| matches!(mistake, PhaseMistake::Hidden { .. })))
    }));
    cases.push(refused.case("a step of half a turn", 0.0, || {
        let run = simulate((UNIT, FALLING), start("B"), Rattle::new(10.0)).and_then(|now| ends(now, 1));
        Ok(unless(run, no_multiplier))
    }));
    let ends_there = Kind {
        why: "the motion has no continuation: a solver leaps to another sheet, energy jumps by a third",
        expect: "an error where the motion of the references ends, at t = 2.58986",
        reason: "three steps, in which the slope is known to be too near zero",
    };
    for h in [0.05, 0.01, 0.002] {
        cases.push(ends_there.case(format!("Hopf pendulum that ends, h = {h}"), 3.0 * h, move || impasse(h)));
    }
    cases
}

/// How many of 300 motions of 40 steps get nearer to another shell than to their own.
fn leave_their_shell(k: f64) -> f64 {
    let mut random = StdRng::seed_from_u64(1);
    let (mut wrong, mut steps) = (0, 0);
    for _ in 0..300 {
        let mut vector = || [0, 1].map(|_| random.random_range(-1.0..1.0));
        let scene = Scene::in_phase_space(Shells { k }, FALLING);
        let Ok(start) = scene.project(&State::at(vector()).moving(vector())) else { continue };
        let h = 10_f64.powf(random.random_range(-2.5..-0.3));
        let Ok(run) = scene.simulate(start, Rattle::new(h)) else { continue };
        let mut run = run.boxed();
        let level = |run: &BoxedSimulation<2>| {
            run.positions().chain(run.momenta()).map(|x| x.norm_squared()).sum::<f64>()
        };
        let own = level(&run);
        let mut far = 0.0_f64;
        while run.steps() < 40 && run.step().is_ok() {
            far = far.max((level(&run) - own).abs());
        }
        steps += run.steps();
        wrong += u32::from(far > 1.0 / k);
    }
    assert!(steps > 500, "many move: {steps} steps");
    f64::from(wrong)
}

/// How far from its true end the motion from start A of the references is stopped.
fn impasse(h: f64) -> Measured {
    let (q, turn) = ([0.3_f64, 0.4], 1.040_765_8_f64);
    let p = [0.75_f64.sqrt() * 1.0_f64.cos(), 0.75_f64.sqrt() * 1.0_f64.sin()];
    let (sin, cos) = turn.sin_cos();
    let place = [0, 1].map(|i| q[i] * cos + p[i] * sin);
    let momentum = [0, 1].map(|i| p[i] * cos - q[i] * sin);
    let scene = Scene::in_phase_space(UNIT, FALLING);
    let start = scene.project(&State::at(place).moving(momentum))?;
    let mut simulation = scene.simulate(start, Rattle::new(h))?.boxed();
    let ended = simulation.run((4.0 / h) as u64);
    let far = larger(unless(ended, no_multiplier), simulation.energy_error().abs() - h);
    Ok(larger(far, (simulation.time() - 2.589_86).abs()))
}

fn no_multiplier(error: &Error) -> bool {
    let Error::Step { cause, .. } = error else { return false };
    use PhaseFailure::{NoSlide, SheetLost, Undetermined};
    matches!(cause, StepFailure::Phase(Undetermined { .. } | NoSlide { .. } | SheetLost { .. }))
}

fn mistaken<T>(result: Result<T, Error>, meant: impl Fn(&PhaseMistake) -> bool) -> f64 {
    unless(
        result,
        |error| matches!(error, Error::Start { cause: StartFailure::Phase(mistake), .. } if meant(mistake)),
    )
}

fn after(scene: (Hopf, Swing), start: State<2>, steps: u64) -> Result<State<2>, Error> {
    let mut simulation = simulate(scene, start, Rattle::new(0.05))?;
    simulation.run(steps)?;
    Ok(simulation.state())
}

fn from_table(row: &crate::common::Row) -> State<2> {
    State::at(row.numbers(["q1", "q2"])).moving(row.numbers(["p1", "p2"]))
}

fn map(n: u32) -> Measured {
    let rows = table("golden_discrete_hopf");
    let row = rows.iter().find(|row| row.number("n") == f64::from(n)).expect("so many steps");
    let mut simulation = simulate((UNIT, FALLING), start("B"), Rattle::new(0.1))?;
    simulation.run(n.into())?;
    Ok(apart(&simulation.state(), &from_table(row)))
}

fn solution(name: &str, t: f64) -> Measured {
    let rows = table("hopf_pendulum");
    let row = rows.iter().find(|row| row.text("start") == name && row.number("t") == t).expect("such a row");
    let method = Composition::new(SOFRONIOU_SPALETTA_2005_ORDER_10, 0.05);
    let mut simulation = simulate((UNIT, FALLING), start(name), method)?;
    simulation.run((20.0 * t).round() as u64)?;
    let exact = row.numbers(["q1", "q2"]);
    assert!(distance(start(name).positions().next().unwrap(), exact) > 100.0 * E, "it moves");
    Ok(apart(&simulation.state(), &from_table(row)))
}
