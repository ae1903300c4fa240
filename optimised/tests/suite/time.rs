//! Steps very short, very long, very many, backwards, of changing length; constraints that move.

use crate::common::{billiard_45, distance};
use crate::suite::case::{Case, Kind, Measured};
use crate::suite::scenes::*;
use rattle::Error;
use rattle::composition::KAHAN_LI_1997_ORDER_8;
use rattle::error::{StepFailure, SurfaceFailure};
use rattle::links::planar::TurningLine;
use rattle::prelude::*;

/// Along a great circle of radius 2, in steps of reach·R/v: the largest error of a place, in radii.
fn great_circle(reach: f64, steps: u64) -> Measured {
    let (radius, h) = (2.0, 2.0 * reach);
    let simulation = on(sphere(radius), 0.0, at([radius, 0.0, 0.0], [0.0, 0.6, 0.8]), Rattle::new(h))?;
    largest(simulation, steps, |now| {
        let (sin, cos) = (now.steps() as f64 * reach.asin()).sin_cos();
        distance(place(now), [radius * cos, 0.6 * radius * sin, 0.8 * radius * sin]) / radius
    })
}

pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    let short = Kind {
        why: "the step moves the body by less than the rounding of its place, and is lost in the sum",
        expect: "the way of 10 000 steps, as part of itself: an angle of asin(h|v|/R) each",
        reason: "compensated sums lose nothing: speed, step and place are rounded once each",
    };
    for reach in [1e-4, 1e-6, 1e-9, 1e-12, 1e-15] {
        cases.push(
            short.case(format!("great circle, steps of {reach:e} R"), 4.0 * E, move || short_way(reach)),
        );
    }
    let long = Kind {
        why: "at h·κ·|v| = 1 the position equation has a double root: Newton's method lands on the far side",
        expect: "the discrete solution on the sphere, up to the limit",
        reason: "50 roundings of a step's angle, magnified by 1/√(1 − (h|v|/R)²)",
    };
    for reach in [0.1, 0.5, 0.9, 0.95_f64] {
        let bound = 200.0 * E / (1.0 - reach * reach).sqrt();
        cases.push(
            long.case(format!("great circle, h·κ·|v| = {reach}"), bound, move || great_circle(reach, 50)),
        );
    }
    let beyond = Kind {
        why: "no root is left, or one on the other side: garbage in silence",
        expect: "an error with h·κ·|v|, and the state as it was",
        reason: "each is refused",
    };
    for reach in [1.0 + 1e-12, 1.5, 1e3, 1e9] {
        let name = if reach < 1.1 { "1 + 1e-12".into() } else { reach.to_string() };
        cases.push(beyond.case(format!("step with h·κ·|v| = {name}"), 0.0, move || Ok(refused(reach))));
    }
    let huge = Kind {
        why: "a root exists on the other side of the tube, and all equations hold there",
        expect: "of 300 random steps with h·κ·|v| up to 3 none crosses a tube by more than its own path",
        reason: "none",
    };
    cases.push(huge.case("random steps across a thin tube", 0.0, || Ok(across_the_tube())));
    let drift = Kind {
        why: "a solve that ends early errs to one side: energy drifts as n",
        expect: "the largest energy error of 10⁶ more steps is that of the first swings",
        reason: "the swing is sampled at other phases: six digits",
    };
    cases.push(drift.long("pendulum, 10⁶ steps", 1e-6, no_drift));
    let sums = Kind {
        why: "10⁶ sums round 10⁶ times: a bias of ε/2 each is 1e-10",
        expect: "the angle n·asin(h|v|/R), and the energy",
        reason: "speed and step are rounded once: ε of 10⁴ radians each; the energy is rounded when read",
    };
    cases.push(sums.long("great circle, 10⁶ steps", 2e4 * E, || great_circle(0.01, 1_000_000)));
    cases.push(sums.long("great circle, energy over 10⁶ steps", 16.0 * E, || {
        let simulation = on(sphere(1.0), 0.0, at([1.0, 0.0, 0.0], [0.0, 0.6, 0.8]), Rattle::new(0.01))?;
        largest(simulation, 1_000_000, |now| now.energy_error().abs())
    }));
    let clock = Kind {
        why: "t += h gathers n roundings: 1e-9 after 10⁶ steps of 0.1",
        expect: "t = n·h",
        reason: "to the last bit or the next",
    };
    cases.push(clock.long("time after 10⁶ steps of 0.1", E, || {
        let mut simulation = on(sphere(1.0), 0.0, at([1.0, 0.0, 0.0], [0.0, 0.1, 0.0]), Rattle::new(0.1))?;
        simulation.run(1_000_000)?;
        Ok((simulation.time() / 1e5 - 1.0).abs())
    }));
    let back = Kind {
        why: "a solve that leaves a remainder, or guesses from the past, is no longer reversible",
        expect: "as many steps back end at the start",
        reason: "roundings of ε/2, spread by the motion: neighbours part e-fold in a time of one",
    };
    for (n, bound) in [(300, 1e-14), (1000, 2e-13)] {
        let there = Rattle::new(0.01);
        cases.push(back.case(format!("genus two, {n} steps and back"), bound, move || and_back(there, n)));
    }
    cases.push(back.case("genus two, a composition of order 8 and back", 2e-14, || {
        and_back(Composition::new(KAHAN_LI_1997_ORDER_8, 0.02), 100)
    }));
    cases.push(
        back.case("genus two, Lobatto of order 8 and back", 1e-14, || and_back(Lobatto::<5>::new(0.02), 100)),
    );
    let forever = Kind {
        why: "a guess from the step before makes a step depend on its past: a restart differs",
        expect: "a run in two parts is the run in one, bit for bit",
        reason: "bit for bit",
    };
    cases.push(forever.case("restart in the middle", 0.0, || {
        let mut whole = on(SURFACE, 1.0, billiard_45(), Rattle::new(0.01))?;
        whole.run(500)?;
        let mut second = on(SURFACE, 1.0, whole.state(), Rattle::new(0.01))?;
        whole.run(500)?;
        second.run(500)?;
        Ok(apart(&whole.state(), &second.state()))
    }));
    let variable = Kind {
        why: "steps chosen from the present state alone lose what symmetric methods keep: energy drifts",
        expect: "after ten times as many steps the energy error is no more than a tenth larger",
        reason: "the swing, sampled for longer",
    };
    cases.push(variable.case("adaptive steps near a pinch", 1.1, adaptive));
    let moving = Kind {
        why: "g depends on time: normals and velocities of the surface belong to different times",
        expect: "the solution, a bead thrown out as cosh ωt on a line that turns",
        reason: "second order: cosh(1) h²/4",
    };
    for h in [1e-2, 1e-3] {
        cases.push(moving.case(format!("bead on a turning line, h = {h:e}"), 0.4 * h * h, move || bead(h)));
    }
    let truth = Kind {
        why: "a method of high order shows every digit that a solve, a guess or a constant loses",
        expect: "the solution to 30 digits in tests/data",
        reason: "rounding, spread by the motion's own instability until then",
    };
    cases.push(truth.case("genus two under gravity at t = 1, order 8", 1e-12, || solution(1.0, 1e-2)));
    cases.push(truth.case("genus two under gravity at t = 5, order 8", 1e-11, || solution(5.0, 1e-2)));
    cases
}

/// Along a great circle of radius one: how far 10 000 steps lead, as part of the way.
fn short_way(reach: f64) -> Measured {
    let simulation = on(sphere(1.0), 0.0, at([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]), Rattle::new(reach))?;
    Ok((place_after(simulation, 10_000)?.y / (1e4 * reach.asin()).sin() - 1.0).abs())
}

fn refused(reach: f64) -> f64 {
    let start = at([1.0, 0.0, 0.0], [0.0, 0.6, 0.8]);
    let mut simulation = on(sphere(1.0), 0.0, start.clone(), Rattle::new(reach)).unwrap();
    let step = simulation.step();
    let same = apart(&simulation.state(), &start) == 0.0 && simulation.steps() == 0;
    let told = unless(step, |error| {
        matches!(error, Error::Step { cause: StepFailure::Surface(SurfaceFailure::StepTooLong { .. }), .. })
    });
    told + f64::from(!same)
}

/// On a tube of radius 0.01 about the circle of radius 1: no step may turn by more than 90° about its core.
fn across_the_tube() -> f64 {
    let (r, mut wrong, mut taken) = (0.01, 0, 0);
    for i in 0..300 {
        let (around, along) = (0.7 * f64::from(i), 0.3 * f64::from(i));
        let (sin, cos) = around.sin_cos();
        let h = 0.01 * f64::from(i + 1) * r;
        let start = at([1.0 + r * cos, 0.0, r * sin], [-sin * along.cos(), along.sin(), cos * along.cos()]);
        let mut simulation =
            onto(TorusByDistance { major: 1.0, minor: r }, 0.0, start, Rattle::new(h)).unwrap();
        let before = simulation.state();
        if simulation.step().is_ok() {
            taken += 1;
            let normal = |q: rattle::nalgebra::Vector3<f64>| {
                let out = q.x.hypot(q.y);
                rattle::nalgebra::Vector3::new(q.x / out * (out - 1.0), q.y / out * (out - 1.0), q.z)
            };
            let turned = normal(before.positions().next().unwrap()).dot(&normal(place(&simulation)));
            wrong += u32::from(turned <= 0.0);
        }
    }
    assert!(taken > 50, "{taken} taken");
    f64::from(wrong)
}

fn no_drift() -> Measured {
    let mut simulation = on(sphere(1.0), 1.0, State::at([1.0, 0.0, 0.0]), Rattle::new(0.01))?;
    let mut first = 0.0_f64;
    simulation.run_with(20_000, |now| first = first.max(now.energy_error().abs()))?;
    let all = largest_more(simulation, 1_000_000)?;
    Ok((all / first - 1.0).abs())
}

fn largest_more(mut simulation: BoxedSimulation<3>, steps: u64) -> Measured {
    let mut all = 0.0;
    simulation.run_with(steps, |now| all = larger(all, now.energy_error().abs()))?;
    Ok(all)
}

fn and_back<S: Method + 'static>(method: S, steps: u64) -> Measured {
    let start = billiard_45();
    let mut there = on(SURFACE, 1.0, start.clone(), method.clone())?;
    there.run(steps)?;
    assert!(apart(&there.state(), &start) > 0.1);
    let mut back = on(SURFACE, 1.0, there.state(), method.with_step(-method.step_size()))?;
    back.run(steps)?;
    Ok(apart(&back.state(), &start))
}

fn adaptive() -> Measured {
    let start = at([std::f64::consts::FRAC_1_SQRT_2, 0.0, 0.02], [0.0, 0.7, 0.0]);
    let method = Variable::of(Rattle::new(0.002), 0.3);
    let mut simulation = onto(Lemniscate { a: 1.0, r: 0.249 }, 0.0, start, method)?;
    let mut first = 0.0_f64;
    simulation.run_with(10_000, |now| first = first.max(now.energy_error().abs()))?;
    Ok(largest_more(simulation, 90_000)? / first)
}

fn bead(h: f64) -> Measured {
    let start = State::at([1.0, 0.0]).moving([0.0, 1.0]);
    let scene = Scene::point().link_moving(TurningLine { omega: 1.0 }, [[0]]);
    let simulation = scene.simulate(start, Rattle::new(h))?.boxed();
    largest(simulation, (1.0 / h) as u64, |now| {
        (now.positions().next().unwrap().norm() - now.time().cosh()).abs()
    })
}

fn solution(t: f64, h: f64) -> Measured {
    let rows = crate::common::table("lemniscate_gravity");
    let is = |row: &&crate::common::Row| {
        row.text("ic") == "f64" && row.text("theta_deg") == "45" && row.number("t") == t
    };
    let exact = rows.iter().find(is).expect("a row of this time").numbers(["x", "y", "z"]);
    let simulation = on(SURFACE, 1.0, billiard_45(), Composition::new(KAHAN_LI_1997_ORDER_8, h))?;
    Ok(distance(place_after(simulation, (t / h).round() as u64)?, exact))
}
