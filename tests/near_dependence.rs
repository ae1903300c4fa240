//! Elimination where equations nearly depend on each other, or are scaled to the limits of numbers: a right number, or
//! a refusal that says why.

use rattle::Error;
use rattle::error::{LinkedFailure, StepFailure};
use rattle::links::Rod;
use rattle::network::LinearAlgebra::Elimination;
use rattle::potentials::Gravity;
use rattle::prelude::*;

constraint! {
    /// A rod, as c·g = 0.
    struct Scaled { c, length } |a: [f64; 3], b: [f64; 3]| c * (sum(i in 0..3, (a[i] - b[i])^2) - length^2)
}

/// c·g = 0 are the same rods as g = 0, for all c with which |∇g|² is a number.
#[test]
fn scales_of_links_change_no_motion() {
    for n in [3, 9] {
        let end = |c: f64| {
            let scene = Scene::points::<3>(n)
                .link(Scaled { c, length: 1.0 }, (1..n).map(|i| [i - 1, i]))
                .pin(0, [0.0; 3])
                .with(Gravity { g: 1.0 });
            // The last rods turn the fastest.
            let start = State::of((0..n).map(|i| [0.6 * i as f64, 0.8 * i as f64, 0.0]))
                .with_momenta((0..n).map(|i| [0.0, 0.0, 0.1 * (i * i) as f64]));
            let mut simulation = scene.simulate(start, Rattle::new(0.01)).unwrap();
            simulation.run(20).unwrap();
            // A step that is too long says by how much.
            let mut coarse = scene.simulate(simulation.state(), Rattle::new(4.0)).unwrap();
            let Error::Step { cause, .. } = coarse.run(1).unwrap_err() else { panic!("a step was refused") };
            let StepFailure::Linked(LinkedFailure::NotSolved { turn, .. }) = cause else { panic!("{cause}") };
            (simulation.positions().collect::<Vec<_>>(), turn)
        };
        let right = end(1.0);
        for exponent in [-270, 258] {
            let found = end(2.0_f64.powi(exponent));
            // Powers of two change no bit but for the order in which a matrix of two is eliminated.
            for (a, b) in found.0.iter().zip(&right.0) {
                assert!((a - b).amax() <= 16.0 * f64::EPSILON, "{n} 2^{exponent}: {a} for {b}");
            }
            let off = found.1 / right.1 - 1.0;
            assert!(off.abs() <= 256.0 * f64::EPSILON, "{n} 2^{exponent}: {} for {}", found.1, right.1);
        }
    }
}

/// A rod from a hub, and one in the same line from there to a pin: an equation that is solved for after all others.
#[test]
fn late_equations_ask_for_no_memory() {
    let place = |i: usize| {
        let a = i as f64;
        if i == 41 {
            [2.0, 0.0, 0.0]
        } else {
            [(a - 1.0).cos(), (a - 1.0).sin(), 0.0].map(|x| if i == 0 { 0.0 } else { x })
        }
    };
    let scene = Scene::points::<3>(42)
        .link(Rod { length: 1.0 }, (1..41).map(|leaf| [0, leaf]).chain([[1, 41]]))
        .pin(41, place(41))
        .with(Gravity { g: 1.0 });
    let mut simulation = scene.simulate(State::of((0..42).map(place)), Rattle::new(1e-3)).unwrap();
    assert_eq!(simulation.system().components().next().unwrap().by, Elimination);
    assert_eq!(allocation_counter::measure(|| simulation.run(3).unwrap()).count_total, 0);
}
