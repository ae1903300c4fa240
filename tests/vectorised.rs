//! The loops of an ensemble are vectorised, whole: read off the machine code of this program, which runs one scene.
//!
//! What would make them tens of times slower without a word: a function that is not inlined, a number read through
//! memory that the loop may write, a condition that is a branch.
#![cfg(all(target_arch = "x86_64", target_os = "linux", not(debug_assertions)))]

use rattle::prelude::*;
use std::process::Command;

constraint! {
    struct Lemniscate { a, r }
    |x, y, z| {
        let f = (x^2 + y^2)^2 - a^2 * (x^2 - y^2);
        f^2 + z^2 - r^2
    }
}

potential! {
    struct Gravity { g }
    |x, y, z| g * z
}

#[test]
fn entries_are_vectorised() {
    let scene = Scene::on(Lemniscate { a: 1.0, r: 0.2 }).with(Gravity { g: 1.0 });
    let starts =
        (0..64).map(|i| State::at([0.0, 0.0, 0.2]).moving([f64::from(i).cos(), f64::from(i).sin(), 0.0]));
    let mut ensemble = scene.ensemble(starts, Rattle::new(0.01)).unwrap();
    ensemble.run(10);
    assert_eq!(ensemble.failures().count(), 0);

    let executable = std::env::current_exe().unwrap();
    let Ok(output) = Command::new("objdump").args(["-d", "--no-show-raw-insn"]).arg(executable).output()
    else {
        println!("not checked: no objdump here");
        return;
    };
    let text = String::from_utf8_lossy(&output.stdout);
    for (entry, register) in [("with_avx512", "%zmm"), ("with_avx2", "%ymm")] {
        let mut whole_groups = 0;
        for function in text.split("\n\n") {
            let name = function.lines().next().unwrap_or("");
            let count = |words: &[&str]| {
                function.lines().filter(|line| words.iter().all(|word| line.contains(word))).count()
            };
            let vectors = count(&["vdivp", register]);
            if !name.contains(entry) || vectors == 0 {
                continue; // also the entry of one trajectory alone
            }
            whole_groups += 1;
            // Three loops of each of two copies of a step divide.
            assert!(vectors >= 6, "{name} {vectors} divisions of vectors");
            assert_eq!(count(&["vdivs"]), 0, "{name} a loop goes number by number");
            assert_eq!(count(&["call", "fma"]), 0, "{name} multiply-add is a function");
        }
        assert!(whole_groups >= 1, "no {entry} of whole groups");
    }
}
