//! Lanes: other numbers, other neighbours, trajectories that fail, parameters of all sizes.

use crate::common::distance;
use crate::suite::case::{Case, Kind, Measured};
use crate::suite::scenes::*;
use rattle::Error;
use rattle::prelude::*;

const SINGLE: f64 = f32::EPSILON as f64;

/// How far rounding walks in n steps of 0.01, in ε: 2.5 n^1.5 h.
fn walk(n: u32) -> f64 {
    0.025 * f64::from(n).powf(1.5)
}

/// Directions along the unit sphere from one place.
fn start(i: usize) -> State<3> {
    let (sin, cos) = (0.1 * i as f64).sin_cos();
    at([1.0, 0.0, 0.0], [0.0, cos, sin])
}

/// Of the unit sphere as c·g = 0, after so many steps of 0.01.
fn states<P: Precision>(
    precision: P,
    c: f64,
    g: f64,
    starts: impl IntoIterator<Item = State<3>>,
    steps: u64,
) -> Result<Vec<State<3>>, Error> {
    let scene = Scene::on(Quadric { c, ..sphere(1.0) }).with(Gravity { g });
    let mut ensemble = scene.ensemble_in(precision, starts, Rattle::new(0.01))?;
    ensemble.run(steps);
    match ensemble.failures().next() {
        Some((_, error)) => Err(error.clone()),
        None => Ok(ensemble.states().collect()),
    }
}

/// The largest distance from the great circles.
fn off_circles<P: Precision>(precision: P, c: f64, steps: u64) -> Measured {
    let (sin, cos) = (steps as f64 * 0.01_f64.asin()).sin_cos();
    let states = states(precision, c, 0.0, (0..70).map(start), steps)?;
    let off = states.iter().enumerate().map(|(i, state)| {
        let (up, along) = (0.1 * i as f64).sin_cos();
        distance(state.positions().next().unwrap(), [cos, sin * along, sin * up])
    });
    Ok(off.fold(0.0, larger))
}

fn off_sphere(states: &[State<3>]) -> f64 {
    states.iter().map(|state| (state.positions().next().unwrap().norm() - 1.0).abs()).fold(0.0, larger)
}

pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    let circles = Kind {
        why: "lanes guess from the past and solve together: an early end of one is the error of all",
        expect: "70 great circles after 10 000 steps",
        reason: "places follow momenta that walk: 2.5 n^1.5 h ε; compensated: ε of 100 radians, twice",
    };
    cases.push(circles.long("70 lanes, doubles", walk(10_000) * E, || off_circles(Double, 1.0, 10_000)));
    cases.push(circles.long("70 lanes, compensated", 200.0 * E, || off_circles(Compensated, 1.0, 10_000)));
    cases.push(
        circles
            .long("70 lanes, single precision", walk(10_000) * SINGLE, || off_circles(Single, 1.0, 10_000)),
    );
    let kept = Kind {
        why: "a tolerance made for doubles is out of reach: every step goes to the limit of corrections",
        expect: "the sphere is kept under gravity for 20 000 steps",
        reason: "three coordinates rounded by half a last place, and one rounding of g",
    };
    cases.push(kept.long("on the sphere, single precision", 4.0 * SINGLE, || {
        states(Single, 1.0, 1.0, (0..70).map(start), 20_000).map(|states| off_sphere(&states))
    }));
    cases.push(kept.long("on the sphere, doubles", 4.0 * E, || {
        states(Double, 1.0, 1.0, (0..70).map(start), 20_000).map(|states| off_sphere(&states))
    }));
    let scaled = Kind {
        why: "c·g and its squares leave the range of the lanes' numbers, narrower in single precision",
        expect: "the same great circles",
        reason: "places follow momenta that walk: 2.5 n^1.5 h ε",
    };
    for c in [1e-100, 1e100] {
        cases.push(scaled.case(format!("70 lanes, doubles, g times {c:e}"), walk(1000) * E, move || {
            off_circles(Double, c, 1000)
        }));
    }
    for c in [1e-8, 1e8] {
        let name = format!("70 lanes, single precision, g times {c:e}");
        cases.push(scaled.case(name, walk(1000) * SINGLE, move || off_circles(Single, c, 1000)));
    }
    let neighbours = Kind {
        why: "a vector loop treats its last lanes otherwise, and all lanes iterate until the slowest is done",
        expect: "a trajectory has the same bits whatever and how many its neighbours",
        reason: "bit for bit",
    };
    for n in [1, 63, 64, 65, 130] {
        cases.push(neighbours.case(format!("{n} neighbours"), 0.0, move || {
            let alone = states(Double, 1.0, 1.0, [start(7)], 500)?;
            let fast = (0..n).map(|i| at([1.0, 0.0, 0.0], [0.0, 0.03 * f64::from(i), 1.0]));
            let among = states(Double, 1.0, 1.0, fast.chain([start(7)]), 500)?;
            Ok(apart(&alone[0], among.last().expect("one at least")))
        }));
    }
    let failing = Kind {
        why: "one lane without a root sends NaN to its neighbours, or stops them",
        expect: "too fast ones are refused by name, their neighbours have the bits that they have alone",
        reason: "none else fails, bit for bit",
    };
    cases.push(failing.case("each tenth lane too fast for its step", 0.0, each_tenth_too_fast));
    let sweep = Kind {
        why: "lanes with radii apart by twelve digits share a tolerance",
        expect: "each great circle, as part of its radius",
        reason: "100 roundings of a step's angle of 0.1, five times",
    };
    cases.push(sweep.case("a sweep over radii from 1e-6 to 1e6", 50.0 * E, radii));
    let alike = Kind {
        why: "lanes and a single simulation are other code for one method",
        expect: "both give one motion",
        reason: "1000 roundings, spread by the pendulum",
    };
    cases.push(alike.case("lanes and simulations", 1e-12, || {
        let lanes = states(Double, 1.0, 1.0, (0..70).map(start), 1000)?;
        let mut worst = 0.0;
        for (i, lane) in lanes.iter().enumerate() {
            let mut alone = on(sphere(1.0), 1.0, start(i), Rattle::new(0.01))?;
            alone.run(1000)?;
            worst = larger(worst, apart(lane, &alone.state()));
        }
        Ok(worst)
    }));
    cases
}

fn each_tenth_too_fast() -> Measured {
    let scene = Scene::on(sphere(1.0)).with(Gravity { g: 1.0 });
    let begin = |i: usize| {
        let too_fast = if i % 10 == 3 { 150.0 } else { 1.0 };
        let p = start(i).momenta().next().unwrap() * too_fast;
        State::at([1.0, 0.0, 0.0]).moving(p)
    };
    let mut ensemble = scene.ensemble((0..70).map(begin), Rattle::new(0.01))?;
    ensemble.run(200);
    let slow = (0..70).filter(|i| i % 10 != 3);
    let alone = states(Double, 1.0, 1.0, slow.clone().map(begin), 200)?;
    let failed: Vec<_> = ensemble.failures().map(|(i, _)| i).collect();
    let others = slow.zip(&alone).map(|(i, alone)| apart(&ensemble.state(i), alone)).fold(0.0, larger);
    Ok(others + f64::from(u8::from(failed != [3, 13, 23, 33, 43, 53, 63])))
}

fn radii() -> Measured {
    let radius = |i: i32| 10_f64.powf(f64::from(i) * 0.1 - 6.0);
    let scenes: Vec<_> = (0..=120).map(|i| Scene::on(sphere(radius(i))).with(Gravity { g: 0.0 })).collect();
    let starts = (0..=120).map(|i| at([radius(i), 0.0, 0.0], [0.0, 0.6 * radius(i), 0.8 * radius(i)]));
    let mut ensemble = Ensemble::sweep(Double, scenes.iter().zip(starts), Rattle::new(0.1))?;
    ensemble.run(100);
    let (sin, cos) = (100.0 * 0.1_f64.asin()).sin_cos();
    let off = ensemble.states().zip(0..).map(|(state, i)| {
        distance(state.positions().next().unwrap() / radius(i), [cos, 0.6 * sin, 0.8 * sin])
    });
    Ok(off.fold(0.0, larger))
}
