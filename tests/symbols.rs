//! A program of a scene with gravity alone has no code of pairs, of heat or of random numbers: read off the names in
//! its own file.

use names::{UNASKED, has, own_file};
use rattle::potentials::Gravity;
use rattle::prelude::*;
use rattle::surfaces::Torus;

#[path = "common/names.rs"]
mod names;

#[test]
fn what_is_not_named_is_not_there() {
    let scene = Scene::on(Torus { major: 1.0, minor: 0.5 }).with(Gravity { g: 1.0 });
    let mut simulation =
        scene.simulate(State::at([1.5, 0.0, 0.0]).moving([0.0, 1.0, 0.0]), Rattle::new(0.01)).unwrap();
    simulation.run(100).unwrap();
    let file = own_file();
    for present in ["eroc_elttar", "gnidnal"] {
        assert!(has(&file, present), "{present}: names are not to be read, so this test sees nothing");
    }
    // That these are the names of what they mean is tested in a program that has it all: `named.rs`.
    for absent in UNASKED {
        assert!(!has(&file, absent), "{absent}, read backwards, is in a program that does not name it");
    }
}
