//! Members, potentials and forces of the wrong size, and effects in phase space: found when code is made, after all
//! types are known.

use rattle::effect::LinearDrag;
use rattle::links::{Rod, planar};
use rattle::potentials::Gravity;
use rattle::prelude::*;

hamiltonian! {
    struct Oscillator {}
    |q: [f64; 3], p: [f64; 3]| dot(p, p) / 2 + dot(q, q) / 2
}

fn main() {
    let rod = Rod { length: 1.0 };
    let _ = Scene::points::<3>(3).link(rod, [[0, 1, 2]]);
    let _ = Scene::points::<2>(2).link(rod, [[0, 1]]);
    let _ = Scene::points::<3>(2).link_each([(planar::Rod { length: 1.0 }, [0, 1])]);
    let _ = Scene::points::<3>(2).link_moving(rod, [[0, 1]]);
    let _ = Scene::points::<3>(2).link_acting(rod, [[0]], [[true; 3]]);
    let scene = Scene::points::<3>(2).with(Gravity { g: 1.0 }.over([[0, 1]]));
    let _ = scene.simulate(State::of([[0.0; 3]; 2]), Rattle::new(0.1));
    let start = || State::at([0.0; 3]);
    let _ = Scene::hamiltonian(Oscillator {}).with(Gravity { g: 1.0 }).simulate(start(), Rattle::new(0.1));
    let _ = Scene::hamiltonian(Oscillator {}).with(LinearDrag::new(0.1)).simulate(start(), Rattle::new(0.1));
}
