//! What `Single` costs in exactness, by the figures of its documentation.

use crate::common::*;
use rattle::ensemble::InstructionSet;
use rattle::prelude::*;

/// Round the unit sphere at unit speed.
fn circles() -> impl Iterator<Item = State<3>> + Clone {
    (0..64).map(|i| {
        let (sin, cos) = f64::from(i).sin_cos();
        let (up, level) = (0.3 * f64::from(i)).sin_cos();
        State::at([cos, sin, 0.0]).moving([-level * sin, level * cos, up])
    })
}

/// Energies drift by some 5e-9 of themselves in a step.
#[test]
fn energies_drift_on_the_unit_sphere() {
    if !InstructionSet::widest().fuses() {
        return; // all go alone, in double precision
    }
    let steps = 10_000;
    let mut ensemble =
        Scene::on(Sphere { r: 1.0 }).ensemble_in(Single, circles(), Rattle::new(0.01)).unwrap();
    ensemble.run(steps);
    assert_eq!(ensemble.failures().count(), 0);
    let energies = ensemble.states().map(|state| state.momenta().next().unwrap().norm_squared());
    let drift = (energies.sum::<f64>() / 64.0 - 1.0) / steps as f64;
    println!("{drift:e}");
    assert!((1e-9..1e-8).contains(&drift.abs()), "{drift:e}");
}

constraint! {
    /// Nothing turns on it.
    struct Floor {}
    |_x, _y, z| z
}

/// In steps of 1e-5 the way is wrong by up to 0.6 %, where it is straight.
#[test]
fn ways_in_short_steps_are_wrong() {
    if !InstructionSet::widest().fuses() {
        return;
    }
    let (h, steps) = (1e-5, 500);
    let speed = |i: u32| 1.0 + 5e-4 * f64::from(i);
    let starts = (0..64).map(|i| State::at([1.0, 0.0, 0.0]).moving([speed(i), 0.0, 0.0]));
    let worst = |mut ensemble: Ensemble<3>| {
        ensemble.run(steps);
        let ways = ensemble.states().map(|state| state.positions().next().unwrap().x - 1.0);
        let off = (0..).zip(ways).map(|(i, way)| (way / (speed(i) * h * steps as f64) - 1.0).abs());
        off.fold(0.0, larger)
    };
    let scene = Scene::on(Floor {});
    let single = worst(scene.ensemble_in(Single, starts.clone(), Rattle::new(h)).unwrap());
    let double = worst(scene.ensemble(starts, Rattle::new(h)).unwrap());
    println!("{single:e} {double:e}");
    assert!((5e-3..6e-3).contains(&single) && double < 1e-10, "{single:e} {double:e}");
}

/// Where h |v| is less than 3e-8 |q| nothing moves, by `Single` alone.
#[test]
fn nothing_moves_in_steps_that_are_too_short() {
    if !InstructionSet::widest().fuses() {
        return;
    }
    let (start, h) = (State::at([1.99, 0.0, 0.0]).moving([1.0, 0.0, 0.0]), 5e-8); // numbers near are 1.2e-7 apart
    let scene = Scene::on(Floor {});
    let moved = |mut ensemble: Ensemble<3>| {
        let x = |ensemble: &Ensemble<3>| ensemble.state(0).positions().next().unwrap().x;
        let before = x(&ensemble);
        ensemble.run(1000);
        x(&ensemble) - before
    };
    assert_eq!(moved(scene.ensemble_in(Single, [start.clone()], Rattle::new(h)).unwrap()), 0.0);
    let double = moved(scene.ensemble([start], Rattle::new(h)).unwrap());
    assert!((double - 1000.0 * h).abs() < 1e-12, "{double:e}");
}
