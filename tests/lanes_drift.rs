//! Energies in lanes do not drift where steps are long, and what a solve leaves has one sign for many steps. Motions as
//! in `optimised/tests/drifts.rs`: round a circle, each step is the one before, turned.

use crate::common::*;
use rattle::composition::YOSHIDA_1990_ORDER_4;
use rattle::ensemble::{Compensated, Ensemble};
use rattle::links::Rod;
use rattle::nalgebra::vector;
use rattle::prelude::*;

/// How much the kinetic energy of so many trajectories grows in the mean, as a part of itself.
fn growth(starts: &[State<3>], masses: &[f64], mut ensemble: Ensemble<3>, steps: u64) -> f64 {
    let energy = |state: &State<3>| -> f64 {
        state.momenta().zip(masses).map(|(p, mass)| p.norm_squared() / (2.0 * mass)).sum()
    };
    ensemble.run(steps);
    assert_eq!(ensemble.failures().count(), 0);
    let all = starts.iter().zip(ensemble.states()).map(|(start, end)| energy(&end) / energy(start) - 1.0);
    all.sum::<f64>() / starts.len() as f64
}

/// Where a step turns by more than a third, errors of guesses must not feed the next guesses: 1e-15 a step.
#[test]
fn where_steps_on_a_surface_are_long() {
    let scene = Scene::on(Sphere { r: 1.3 }); // |q|² just below 1 is rounded to less than above it: 2e-18 a step
    let start = |i: u32| {
        let (sin, cos) = f64::from(i).sin_cos();
        let p = vector![-0.6 * sin, 0.6 * cos, 0.8] * (0.2 + 0.01 * f64::from(i));
        State::at(vector![cos, sin, 0.0] * 1.3).moving(p)
    };
    let starts: Vec<_> = (0..64).map(|i| scene.project(&start(i)).unwrap()).collect();
    let steps = 8000;
    let sums = scene.ensemble_in(Compensated, starts.clone(), Rattle::new(1.0)).unwrap();
    let slope = growth(&starts, &[1.0], sums, steps) / steps as f64;
    assert!(slope.abs() <= 1e-19, "{slope:e}");
    let doubles = scene.ensemble(starts.clone(), Rattle::new(1.0)).unwrap();
    let slope = growth(&starts, &[1.0], doubles, steps) / steps as f64;
    assert!(slope.abs() <= 3e-18, "not compensated: {slope:e}"); // their sum is rounded 8000 times
}

/// Normals of the place before the last correction would make a drift of 7e-18 a stage.
#[test]
fn where_stages_of_links_are_long() {
    let (masses, h) = ([1.0, 3.0], 0.1);
    let scene = Scene::points(2).link(Rod { length: 1.0 }, [[0, 1]]).masses(masses);
    let start = |i: u32| {
        let (sin, cos) = f64::from(i).sin_cos();
        let (along, speed) = (vector![cos, sin, 0.0], 0.7 + 0.01 * f64::from(i));
        let p = vector![-0.6 * sin, 0.6 * cos, 0.8] * speed;
        State::of([along * 0.75, along * -0.25]).with_momenta([p, -p])
    };
    let starts: Vec<_> = (0..64).map(|i| scene.project(&start(i)).unwrap()).collect();
    let steps = 1000;
    let method = Composition::new(YOSHIDA_1990_ORDER_4, h);
    let ensemble = scene.ensemble_in(Compensated, starts.clone(), method).unwrap();
    let slope = growth(&starts, &masses, ensemble, steps) / (3 * steps) as f64;
    assert!(slope.abs() <= 1e-19, "{slope:e}");
}
