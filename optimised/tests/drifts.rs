//! How the energy drifts by every method that keeps it, each step or stage of a million (Lobatto: a tenth of that):
//!
//! ```text
//! cargo long --test motion drifts:: -- --nocapture
//! ```
//!
//! Motions round a great circle, and of a dumbbell round its centre. Each step is the one before, turned; so whatever
//! keeps the angular momentum keeps the energy as well, and what is left of a slope is rounding. Random roundings of
//! 1e-17 leave 1e-20/√n of it in a million steps of n trajectories.

use crate::common::*;
use rattle::bodies::Count;
use rattle::composition::*;
use rattle::effect::Effects;
use rattle::ensemble::{Compensated, Ensemble};
use rattle::links::Rod;
use rattle::nalgebra::{Rotation3, Vector3};
use rattle::prelude::*;
use rattle::scene::Hold;

const STEPS: u64 = 1_000_000;
const R: f64 = 1.3;

/// The slope of the mean kinetic energy, relative and per step, from states at both ends.
fn slope(starts: &[State<3>], ends: &[State<3>], masses: &[f64], steps: u64) -> f64 {
    let energy = |state: &State<3>| -> f64 {
        state.momenta().zip(masses).map(|(p, mass)| p.norm_squared() / (2.0 * mass)).sum()
    };
    let change: f64 = starts.iter().zip(ends).map(|(start, end)| energy(end) / energy(start) - 1.0).sum();
    change / (starts.len() as f64 * steps as f64)
}

/// The slopes of 64 trajectories in lanes, and of four simulations.
fn slopes<C: Hold<3> + 'static, E: Effects<3>, N: Count, S: Method>(
    scene: &Scene<C, E, N, 3>,
    start: impl Fn(u32) -> State<3>,
    masses: &[f64],
    method: &S,
    steps: u64,
) -> [f64; 2] {
    let starts: Vec<_> = (0..64).map(|i| scene.project(&start(i)).unwrap()).collect();
    let mut ensemble: Ensemble<3> = scene.ensemble_in(Compensated, starts.clone(), method.clone()).unwrap();
    ensemble.run(steps);
    assert_eq!(ensemble.failures().count(), 0);
    let lanes = slope(&starts, &ensemble.states().collect::<Vec<_>>(), masses, steps);
    let alone = starts[..4].iter().map(|start| {
        let mut simulation = scene.simulate(start.clone(), method.clone()).unwrap();
        simulation.run(steps / 4).unwrap();
        simulation.state()
    });
    [lanes, slope(&starts[..4], &alone.collect::<Vec<_>>(), masses, steps / 4)]
}

/// Round a great circle, each in another plane.
fn circle(i: u32) -> State<3> {
    let speed = 0.7 + 0.011 * f64::from(i);
    let turn = Rotation3::new(Vector3::new(0.37, 0.11, 0.23) * f64::from(i));
    State::at(turn * Vector3::x() * R).moving(turn * Vector3::y() * speed)
}

/// A dumbbell that turns round its centre, about another axis each.
fn dumbbell(i: u32) -> State<3> {
    let speed = 0.7 + 0.011 * f64::from(i);
    let turn = Rotation3::new(Vector3::new(0.37, 0.11, 0.23) * f64::from(i));
    let (along, p) = (turn * Vector3::x(), turn * Vector3::y() * speed);
    State::of([along * 0.75, along * -0.25]).with_momenta([p, -p])
}

/// After so many steps in lanes, a quarter of that alone. So many stages make up a step, and the slope of each is at
/// most this.
fn check<S: Method>(name: &str, steps: u64, stages: usize, most: f64, method: S) {
    let steps = steps / stages as u64;
    let surface = slopes(&Scene::on(Sphere { r: R }), circle, &[1.0], &method, steps);
    let rods = Scene::points(2).link(Rod { length: 1.0 }, [[0, 1]]).masses([1.0, 3.0]);
    let links = slopes(&rods, dumbbell, &[1.0, 3.0], &method, steps);
    let each = [surface, links].as_flattened().iter().map(|slope| slope / stages as f64).collect::<Vec<_>>();
    println!("| {name} | {:.1e} | {:.1e} | {:.1e} | {:.1e} |", each[0], each[1], each[2], each[3]);
    assert!(each.iter().all(|slope| slope.abs() <= most), "{name}: {each:?}");
}

fn compositions(all: &[Coefficients], h: f64) {
    for coefficients in all {
        check(coefficients.name, STEPS, coefficients.gammas.len(), 1e-19, Composition::new(*coefficients, h));
    }
}

#[test]
#[cfg(long)]
fn of_every_method() {
    println!("| method | surface, lanes | surface, alone | links, lanes | links, alone |");
    check("RATTLE", STEPS, 1, 1e-19, Rattle::new(0.05));
    check("RATTLE, backwards", STEPS, 1, 1e-19, Rattle::new(-0.05));
    check("position Verlet", STEPS, 1, 1e-19, PositionVerlet::new(0.05));
    check("symplectic Euler", STEPS, 1, 1e-19, SymplecticEuler::new(0.05));
    check("geodesic RATTLE", STEPS, 2, 1e-19, Geodesic::new(2, 0.1));
    compositions(&[YOSHIDA_1990_ORDER_4], 0.05);
    compositions(&[YOSHIDA_1990_ORDER_4], 0.1);
    compositions(&[SUZUKI_1990_ORDER_4], 0.3);
    compositions(&[SUZUKI_1990_ORDER_4, KAHAN_LI_1997_ORDER_6, KAHAN_LI_1997_ORDER_8], 0.1);
    compositions(&[SOFRONIOU_SPALETTA_2005_ORDER_10], 0.2);
    check("Lobatto, 2 stages", STEPS / 10, 1, 1.5e-19, Lobatto::<2>::new(0.05));
    check("Lobatto, 3 stages", STEPS / 10, 1, 1.5e-19, Lobatto::<3>::new(0.05));
    check("Lobatto, 5 stages", STEPS / 10, 1, 1.5e-19, Lobatto::<5>::new(0.05));
    check("Lobatto, 8 stages", STEPS / 10, 1, 1.5e-19, Lobatto::<8>::new(0.05));
}
