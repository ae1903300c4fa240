//! Elimination where equations nearly depend on each other, or are scaled to the limits of numbers: a right number, or
//! a refusal that says why.

use rattle::Error;
use rattle::bodies::Many;
use rattle::effect::list::Effects;
use rattle::error::{LinkedFailure, StepFailure};
use rattle::links::Rod;
use rattle::network::LinearAlgebra::{Automatic, Elimination, Orthogonal};
use rattle::network::Network;
use rattle::potentials::{self, Gravity};
use rattle::prelude::*;
use rattle::{Dop853, Taylor};

constraint! {
    /// Two planes along x, with the sine d between them where x is 1.
    struct Wedge { d } |x, y, z| [z, z + y * (d + (x - 1)^2)]
}

potential! { struct Across { f } |x, y, z| f * y + 0 * x + 0 * z }

constraint! {
    /// A rod, as c·g = 0.
    struct Scaled { c, length } |a: [f64; 3], b: [f64; 3]| c * (sum(i in 0..3, (a[i] - b[i])^2) - length^2)
}

/// A body between the planes that draws a straight chain behind it: eight equations, with the sine 3e-7.
fn train() -> Scene<Network<3>, impl Effects<3>, Many, 3> {
    Scene::points::<3>(7)
        .link(Wedge { d: 3e-7 }, [[0]])
        .link(Rod { length: 1.0 }, (0..6).map(|i| [i, i + 1]))
        .linear_algebra(Elimination)
        .with(Across { f: 1.0 }.over([[0]]))
}

/// Where the first body is x, with the velocity 1.
fn on_the_way(x: f64) -> State<3> {
    State::of((0..7).map(|i| [x + f64::from(i), 0.0, 0.0])).with_momenta([[1.0, 0.0, 0.0]; 7])
}

/// The planes give just the force that is put on, where one elimination leaves ε/sine² = 2e-3 of it.
#[test]
fn forces_between_planes_that_nearly_coincide_are_right() {
    let simulation = train().simulate(on_the_way(1.0), Rattle::new(1e-3)).unwrap();
    let force = simulation.constraint_forces()[0];
    // λ is f/sine, and its roundings are those of the force along the planes' normals.
    assert!((force.y - 1.0).abs() <= 8.0 * f64::EPSILON, "{force:?}");
    assert!(force.z.abs() <= f64::EPSILON / 3e-7, "{force:?}");
}

/// Nothing acts along the path. What is left by each round of elimination is taken for a force where x is 1, by one
/// order of a series after another.
#[test]
fn paths_past_such_a_place_are_straight() {
    fn check<S: Method>(method: S) {
        let mut simulation = train().simulate(on_the_way(0.9955), method).unwrap();
        simulation.run(9).unwrap();
        let off = simulation.positions().next().unwrap().x - 0.9955 - simulation.time();
        // Of 9 steps some roundings of places; it was 4e-12 by DOP853.
        assert!(off.abs() <= 32.0 * f64::EPSILON, "{}: {off:e}", simulation.method().name());
    }
    check(Rattle::new(1e-3));
    check(Dop853::new(1e-3));
    check(Taylor::new(10, 1e-3));
}

/// The tension at the top of a hanging chain is the weight below it, however light each other body is.
#[test]
fn light_bodies_hand_on_tensions_whole() {
    let n = 101;
    for light in [1e-4, 1e-8] {
        let masses: Vec<f64> = (0..n).map(|i| if i % 2 == 1 { light } else { 1.0 }).collect();
        let scene = Scene::points::<3>(n)
            .masses(masses.clone())
            .link(Rod { length: 1.0 }, (1..n).map(|i| [i - 1, i]))
            .pin(0, [0.0; 3])
            .with(potentials::weights(1.0, masses.clone()))
            .linear_algebra(Elimination);
        let start = State::of((0..n).map(|i| [0.0, 0.0, -(i as f64)]));
        let simulation = scene.simulate(start, Rattle::new(1e-4)).unwrap();
        let (told, right) = (-simulation.constraint_forces()[0][2], masses[1..].iter().sum::<f64>());
        // Each rod adds a rounding of what it bears; it was 1e-9 for masses of 1e-4.
        assert!((told - right).abs() <= n as f64 * f64::EPSILON * right, "{light:e}: {told} for {right}");
    }
}

/// A light body with heavy ones around it: a basis where one may be chosen, elsewhere an error that says the truth.
#[test]
fn light_hubs_are_borne_or_refused() {
    let place = |i: usize| {
        let (a, b) = (i as f64, 0.3 * i as f64);
        if i == 0 { [0.0; 3] } else { [a.cos() * b.cos(), a.sin() * b.cos(), b.sin()] }
    };
    let momentum = |i: usize| [0, 1, 2].map(|d| if i == 0 { 0.0 } else { (5.0 * i as f64 + d as f64).cos() });
    let scene = |light: f64, by| {
        let masses = (0..41).map(move |i| if i == 0 { light } else { 1.0 });
        let rods = (1..41).map(|leaf| [0, leaf]);
        Scene::points::<3>(41).masses(masses).link(Rod { length: 1.0 }, rods).linear_algebra(by)
    };
    for (light, by) in [(1e-4, Elimination), (1e-9, Orthogonal), (1e-12, Orthogonal)] {
        let start = State::of((0..41).map(place)).with_momenta((0..41).map(momentum));
        let start = scene(light, Automatic).project(&start).unwrap();
        let mut simulation = scene(light, Automatic).simulate(start, Rattle::new(1e-3)).unwrap();
        assert_eq!(simulation.system().components().next().unwrap().by, by, "{light:e}");
        simulation.run(3).unwrap();
        assert!(simulation.cotangent_residual() <= 1e-14, "{light:e}: {:e}", simulation.cotangent_residual());
    }
    let start = State::of((0..41).map(place)).with_momenta((0..41).map(momentum));
    let error = scene(1e-15, Elimination).project(&start).unwrap_err().to_string();
    assert!(error.contains("depends on the others"), "{error}"); // and nothing moves apart
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
