//! Elimination where equations nearly depend on each other, or are scaled to the limits of numbers: a right number, or
//! a refusal that says why.

use rattle::links::Rod;
use rattle::network::LinearAlgebra::Elimination;
use rattle::potentials::Gravity;
use rattle::prelude::*;

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
