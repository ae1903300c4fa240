//! Coordinates of another kind or number, and the one body of many.

use rattle::prelude::*;
use rattle::surfaces::Sphere;

fn main() {
    let numbers = vec![0.0, 0.0, 1.0];
    let _: State<3> = State::at(numbers);
    let _: State<3> = State::at([0.0, 1.0]);
    let _: State<3> = State::at([0.0, 0.0, 1.0]).moving(1.0);
    let _: State<3> = State::at([0.0, 0.0, 1.0]).moving([1.0, 0.0]);
    let _: State<3> = State::at([0, 0, 1]);
    let two = Scene::on(Sphere { r: 1.0 }).bodies(2);
    let start = State::of([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]);
    let simulation = two.simulate(start, Rattle::new(0.01)).unwrap();
    let _ = simulation.position();
    let _ = simulation.multiplier();
}
