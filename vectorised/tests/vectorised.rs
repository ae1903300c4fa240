//! The loops of an ensemble are vectorised, whole: read off the machine code of this program, which runs a
//! scene with a polynomial, one with a root, one with waves, three with all other functions, sweeps over parameters, a
//! gas, and particles on a surface.
//!
//! What would make them tens of times slower without a word: a function that is not inlined, a number read through
//! memory that the loop may write, a condition that is a branch.
//!
//! `cargo long --test vectorised`: without, nothing of it is compiled, which would take 19 s.
#![cfg(all(target_arch = "x86_64", target_os = "linux", long))]

use rattle::bodies::One;
use rattle::effect::Effects;
use rattle::ensemble::{Double, Ensemble, Precision, Single};
use rattle::potentials::Gravity;
use rattle::prelude::*;
use rattle::scene::Hold;
use rattle::surfaces::{Gyroid, Lemniscate, TorusByDistance};
use std::process::Command;

constraint! {
    struct Landscape { height }
    |x, y, z| z - height * exp(-x^2 - y^2) + tanh(x) / 4 - ln(2 + y^2) / 4
}

constraint! {
    struct Arcs { height }
    |x, y, z| z - height * atan(x) + acos(y / 4) / 8 + asin(x / 5) / 4 - atan2(y, 2 + x) / 8 + tan(x / 4) / 9 - hypot(x, 2)
}

constraint! {
    struct Powers { power }
    |x, y, z| z - (2 + x)^power / 8 + log2(2 + y^2) / 4 - log10(3 + x) / 4 + cbrt(3 + y) / 4 - erf(x) / 8
        + asinh(y) / 8 - acosh(3 + x) / 9 + atanh(y / 4) / 9
}

constraint! {
    struct Dented { a, b, c, depth, width }
    |x, y, z| x^2 / (a^2 + b^2) + y^2 * exp(-b / c) + z^2 / c^2 - depth * tanh(width) * x * y
        + sqrt(depth^2 + width^2) * z * x / (a * b) - cos(width) * (1 + depth / a)
}

potential! {
    struct Trap { stiffness, scale, g }
    |x, y, z| stiffness / (1 + scale^2) * (x^2 + y^2) / 2 + g * exp(-scale) * z + mod(z + 50, 100 + scale)^2 / 900
}

pair_potential! {
    struct Cloud { depth, width }
    |r| depth * exp(-r) / (1 + (r / width)^2)
}

/// The forces between all pairs, of lengths up to a tile and beyond.
fn gas() {
    let places = (0..100).map(f64::from).map(|i| [i.cos(), i.sin(), 0.1 * i]);
    let scene = Scene::points::<3>(100).with(Cloud { depth: 0.1, width: 1.0 });
    scene.simulate(State::of(places), Rattle::new(0.01)).unwrap().run(2).unwrap();
}

/// Particles on a surface.
fn particles() {
    let scene = Scene::on(Landscape { height: 0.5 }).with(Gravity { g: 1.0 }).bodies(100);
    let places = (0..100).map(f64::from).map(|i| [i.cos(), i.sin(), 0.1]);
    let start = scene.project(&State::of(places)).unwrap();
    scene.simulate(start, Rattle::new(0.01)).unwrap().run(2).unwrap();
}

fn run<C: Hold<3> + 'static, E: Effects<3>>(scene: &Scene<C, E, One, 3>, q: [f64; 3]) {
    run_in(Double, scene, q);
}

fn run_in<P: Precision, C: Hold<3> + 'static, E: Effects<3>>(
    precision: P,
    scene: &Scene<C, E, One, 3>,
    q: [f64; 3],
) {
    let directions = (0..64).map(f64::from);
    let starts =
        directions.map(|i| scene.project(&State::at(q).moving([0.1 * i.cos(), 0.1 * i.sin(), 0.1])).unwrap());
    let mut ensemble = scene.ensemble_in(precision, starts, Rattle::new(0.01)).unwrap();
    ensemble.run(10);
    assert_eq!(ensemble.failures().count(), 0);
}

fn sweep<C: Hold<3> + 'static, E: Effects<3> + 'static>(
    scene: impl Fn(f64) -> Scene<C, E, One, 3>,
    q: [f64; 3],
) {
    let scenes: Vec<_> = (0..64).map(|i| scene(f64::from(i) / 64.0)).collect();
    let start = |scene: &Scene<C, E, One, 3>| scene.project(&State::at(q).moving([0.1, 0.1, 0.1])).unwrap();
    let trajectories = scenes.iter().map(|scene| (scene, start(scene)));
    let mut ensemble = Ensemble::sweep(Double, trajectories, Rattle::new(0.01)).unwrap();
    ensemble.run(10);
    assert_eq!(ensemble.failures().count(), 0);
}

/// The ensembles that this program has, one of them in single precision, two of them sweeps …
const ENSEMBLES: usize = 9;

/// … and other loops: pair forces and energies, the first and the second half of a step of particles, and their looks
/// around.
const OTHERS: usize = 6;

#[test]
fn entries_are_vectorised() {
    run(&Scene::on(Lemniscate { a: 1.0, r: 0.2 }).with(Gravity { g: 1.0 }), [0.0, 0.0, 0.2]);
    run(&Scene::on(TorusByDistance { major: 1.0, minor: 0.3 }), [1.3, 0.0, 0.0]);
    run(&Scene::on(Gyroid { k: 2.0, epsilon: 0.1 }), [0.1, 0.0, 0.0]);
    run(&Scene::on(Landscape { height: 0.5 }).with(Gravity { g: 1.0 }), [0.1, 0.2, 0.3]);
    run_in(Single, &Scene::on(Landscape { height: 0.5 }).with(Gravity { g: 1.0 }), [0.1, 0.2, 0.3]);
    run(&Scene::on(Arcs { height: 0.5 }), [0.1, 0.2, 2.0]);
    run(&Scene::on(Powers { power: 1.3 }), [0.1, 0.2, 0.3]);

    let tube = |t| Scene::on(Lemniscate { a: 1.0 + 0.1 * t, r: 0.2 - 0.05 * t });
    let dent = |t| Dented { a: 1.0 + t, b: 1.2, c: 0.9 + 0.2 * t, depth: 0.1 + 0.1 * t, width: 0.3 };
    sweep(|t| tube(t).with(Gravity { g: 1.0 + t }), [0.0, 0.0, 0.2]);
    sweep(
        |t| Scene::on(dent(t)).with(Trap { stiffness: 1.0, scale: 0.3 + t, g: t }).with(Gravity { g: t }),
        [0.0, 0.0, 0.9],
    );

    gas();
    particles();

    let executable = std::env::current_exe().unwrap();
    let Ok(output) = Command::new("objdump").args(["-d", "--no-show-raw-insn"]).arg(executable).output()
    else {
        println!("not checked: no objdump here");
        return;
    };
    let text = String::from_utf8_lossy(&output.stdout);
    for (entry, register) in [("with_avx512", "%zmm"), ("with_avx2", "%ymm")] {
        let mut entries = 0;
        for function in text.split("\n\n") {
            let name = function.lines().next().unwrap_or("");
            let count = |words: &[&str]| {
                function.lines().filter(|line| words.iter().all(|word| line.contains(word))).count()
            };
            let vectors = count(&["vdivp", register]);
            // What the core compiles for all its users is another matter: names tell of which crate they are.
            let of_lanes = name.contains("10vectorised") && !name.contains("Kj1_Kj3_"); // one lane, of three coordinates
            if !name.contains(entry) || !of_lanes || vectors == 0 {
                continue;
            }
            entries += 1;
            let (roots, larger) = (count(&["vsqrtp", register]), count(&["vmaxp", register]));
            if count(&["vdivs"]) == 0 {
                assert_eq!(count(&["vsqrts"]), 0, "{name} the gas goes number by number");
            } else {
                // A step stands there once, of equal steps. Two loops of it divide, three evaluate the constraint, one
                // asks once what is larger, and one four times. Looking, in the same function, makes all momenta whole
                // in one loop, and divides once more. (Lanes that are corrected again divide by themselves.)
                assert!(vectors >= 3, "{name} {vectors} divisions of vectors");
                assert!(roots >= 3 || count(&["vsqrt"]) == 0, "{name} {roots} roots of vectors");
                assert!(larger >= 5, "{name} {larger} comparisons of vectors");
                // Of all functions that have a name in Rust, only those of lanes that are solved alone, begin anew,
                // fail, or cross a kink.
                let known = ["5alone", "10guess_anew", "10not_finite", "8crossing4kink"];
                let seldom = |line: &str| known.iter().any(|known| line.contains(known));
                let named =
                    |line: &&str| line.contains("call ") && (line.contains("<_Z") || line.contains("<_R"));
                let mut calls = function.lines().filter(named);
                assert_eq!(calls.find(|line| !seldom(line)), None, "{name} calls a function");
            }
            // A loop that goes number by number has its products there, and again in what corrects one lane alone.
            let products = |numbers: [&str; 2]| {
                numbers.map(|of| count(&["vfmadd", of]) + count(&["vfnmadd", of])).iter().sum::<usize>()
            };
            let (packed, single) = (products(["pd ", "ps "]), products(["sd ", "ss "]));
            assert!(packed > single, "{name} {packed} products of vectors, {single} of numbers");
            // Loops over loops, vectorised across the outer one.
            assert_eq!(count(&["vgather"]) + count(&["vscatter"]), 0, "{name} numbers are gathered");
            for function in [
                "fma", "sin", "cos", "tan", "atan", "asin", "acos", "exp", "pow", "log", "sqrt", "cbrt",
                "hypot", "erf", "floor",
            ] {
                assert_eq!(count(&["call", &format!("<{function}")]), 0, "{name} {function} is a function");
            }
        }
        assert_eq!(entries, ENSEMBLES + OTHERS, "{entry} of whole groups");
    }
}
