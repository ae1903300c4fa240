//! A program of a scene with gravity alone has no code of pairs, of heat or of random numbers: read off the names in
//! its own file.

use rattle::potentials::Gravity;
use rattle::prelude::*;
use rattle::surfaces::Torus;

/// Whether the file of this program has this name, told backwards so that the name in this source does not count.
fn has(file: &[u8], backwards: &str) -> bool {
    let name: Vec<u8> = backwards.bytes().rev().collect();
    file.windows(name.len()).any(|window| window == name)
}

#[test]
fn what_is_not_named_is_not_there() {
    let scene = Scene::on(Torus { major: 1.0, minor: 0.5 }).with(Gravity { g: 1.0 });
    let mut simulation =
        scene.simulate(State::at([1.5, 0.0, 0.0]).moving([0.0, 1.0, 0.0]), Rattle::new(0.01)).unwrap();
    simulation.run(100).unwrap();
    let file = std::fs::read(std::env::current_exe().unwrap()).unwrap();
    for present in ["eroc_elttar", "gnidnal7"] {
        assert!(has(&file, present), "{present}: names are not to be read, so this test sees nothing");
    }
    // between_pairs, tiles of pairs, philox, langevin, andersen, magnetic, sincos of random angles.
    for absent in
        ["sriap_neewteb", "secrof_dda5selit", "xolihp", "nivegnal", "nesredna", "citengam", "socnis4mbil"]
    {
        assert!(!has(&file, absent), "{absent}, read backwards, is in a program that does not name it");
    }
}
