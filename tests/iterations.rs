//! Ways to solve the position equation, and first guesses: the same motion by all of them, and what each costs.

use crate::common::linked::*;
use crate::common::*;
use rattle::guess::{FromState, Guess};
use rattle::iteration::Iteration;
use rattle::network::{LinearAlgebra, Network};
use rattle::prelude::*;
use rattle::{Counted, Error, nalgebra};

/// Calls a macro for every guess and every way.
macro_rules! each {
    ($call:ident) => {
        each!($call, "g̈", FromState);
        each!($call, "last μ", LastMultiplier);
        each!($call, "three λ", Extrapolated);
    };
    ($call:ident, $name:literal, $guess:expr) => {
        $call!(concat!($name, ", Newton"), $guess, Newton);
        $call!(concat!($name, ", symmetric"), $guess, Symmetric);
        $call!(concat!($name, ", simplified"), $guess, Simplified);
        $call!(concat!($name, ", Broyden"), $guess, Broyden);
    };
}

fn method<G: Guess, X: Iteration>(h: f64, guess: G, by: X) -> Rattle<G, X> {
    Rattle::new(h).guess(guess).solved_by(by)
}

/// Forth and back by each method: at the same place as Newton's from g̈, at the start again, without allocation.
fn same<C, E, N, const D: usize>(
    what: &str,
    scene: &Scene<C, E, N, D>,
    start: &State<D>,
    (h, steps): (f64, u64),
    tolerance: f64,
) where
    C: rattle::scene::Hold<D>,
    E: rattle::effect::Effects<D>,
    N: rattle::bodies::Count,
{
    let mut reference = scene.simulate(start.clone(), Rattle::new(h)).unwrap();
    reference.run(steps).unwrap();
    let reference = phase(&reference.state());
    let mut others = 0;
    macro_rules! check {
        ($name:expr, $guess:expr, $by:expr) => {
            let mut simulation = scene.simulate(start.clone(), method(h, $guess, $by)).unwrap();
            let allocated = allocation_counter::measure(|| simulation.run(steps).unwrap());
            let found = phase(&simulation.state());
            let mut back = scene.simulate(simulation.state(), method(-h, $guess, $by)).unwrap();
            back.run(steps).unwrap();
            let (off, back) = (apart(&found, &reference), apart(&phase(&back.state()), &phase(start)));
            println!("{what}: {:24} {off:.1e}, and back {back:.1e}", $name);
            assert!(off <= tolerance && back <= tolerance, "{what}: {}: {off:e}, back {back:e}", $name);
            assert_eq!(allocated.count_total, 0, "{what}: {}", $name);
            others += usize::from(found != reference);
        };
    }
    each!(check);
    assert!(others > 0, "{what}: none differs in last bits, so all are the same code");
}

/// Each step may round otherwise, by ε of places and momenta up to 2, and what happens to them until t = 1 amplifies
/// that: by 10 on the lemniscate, less in the others.
#[test]
fn every_way_gives_the_same_motion() {
    let free = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    same("lemniscate", &free, &billiard_45(), (0.01, 100), 1e-14);
    let torus = Scene::on(TorusByDistance { major: 1.0, minor: 0.3 }).bodies(2).with(Gravity { g: 1.0 });
    let pair = State::of([[1.3, 0.0, 0.0], [0.0, -0.7, 0.0]]).moving([0.0, 0.0, 1.0]);
    same("two on a torus", &torus, &pair, (0.01, 100), 1e-14);

    let double = Scene::points(3).pin(0, [0.0, 0.0]).masses([1.0, 0.3, 2.0]);
    let both = [LinearAlgebra::Orthogonal, LinearAlgebra::Elimination];
    for (name, algebra) in ["double pendulum, basis", "double pendulum, elimination"].into_iter().zip(both) {
        let double = double.clone().link(Rod { length: 1.0 }, [[0, 1], [1, 2]]).linear_algebra(algebra);
        same(name, &double.with(PlanarGravity { g: 1.0 }), &double_pendulum(), (0.01, 100), 1e-14);
    }
    let twice = double.link(Rod { length: 1.0 }, [[0, 1], [1, 2], [1, 0]]).with(PlanarGravity { g: 1.0 });
    same("a rod named twice", &twice, &double_pendulum(), (0.01, 100), 1e-14);

    let lifted = Scene::point().link_moving(Lifted { length: 1.0, height: 0.1 }, [[0]]);
    let hanging = State::at([0.6, -0.8]);
    let lifted = lifted.with(PlanarGravity { g: 1.0 });
    same("a pivot that moves", &lifted, &lifted.project(&hanging).unwrap(), (0.01, 100), 1e-14);
    let sideways = Scene::point().link_acting(Pendulum { length: 1.0 }, [[0]], [[true, false]]);
    same("on x alone", &sideways.with(PlanarGravity { g: 0.1 }), &hanging, (0.01, 100), 1e-14);
    let chain = hanging_chain(100);
    same("chain of 100", &chain.0, &chain.1, (0.002, 100), 1e-14);
}

constraint! {
    /// A rod about a pivot that goes up and down.
    struct Lifted { length, height }
    |x, y, t| x^2 + (y - height * (1 - cos(3 * t)))^2 - length^2
}

type Chain<E> = Scene<Network<2>, E, rattle::bodies::Many, 2>;

/// Of length and mass 1, straight and level.
fn hanging_chain(links: usize) -> (Chain<impl rattle::effect::Effects<2> + Clone>, State<2>) {
    let length = 1.0 / links as f64;
    let scene = Scene::points(links + 1)
        .link(Rod { length }, chain(links))
        .pin(0, [0.0, 0.0])
        .mass(length)
        .with(PlanarGravity { g: length });
    let straight = State::of((0..=links).map(|i| [i as f64 * length, 0.0]));
    let start = scene.project(&straight).unwrap();
    (scene, start)
}

/// Evaluations of g, ∇g and second derivatives per step on the lemniscate, at 15° until t = 10.
fn on_the_lemniscate<G: Guess, X: Iteration>(h: f64, guess: G, by: X) -> [f64; 3] {
    let surface = Counted::new(SURFACE);
    let counts = surface.counts();
    let steps = (10.0 / h).round() as u64;
    let scene = Scene::on(surface).with(Gravity { g: 1.0 });
    let start = billiard(15.0_f64.to_radians());
    let mut simulation = scene.simulate(start, method(h, guess, by)).unwrap();
    counts.reset();
    simulation.run(steps).unwrap();
    [counts.values(), counts.gradients(), counts.curvatures()].map(|count| count as f64 / steps as f64)
}

/// Evaluations of g and of ∇g before the end, per step of a chain that falls, a fifth of the time that a wave needs for
/// a link.
fn of_a_chain<G: Guess, X: Iteration>(links: usize, guess: G, by: X) -> [f64; 2] {
    let (scene, start) = hanging_chain(links);
    let mut simulation = scene.simulate(start, method(0.2 / links as f64, guess, by)).unwrap();
    simulation.run(20).unwrap();
    let before = simulation.counts();
    simulation.run(150).unwrap();
    let after = simulation.counts();
    assert_eq!(after.followed, before.followed);
    [after.values - before.values, after.gradients - before.gradients].map(|count| count as f64 / 150.0)
}

/// What each costs. On surfaces a part of it is for looks inside a step, which tell that no other sheet was landed
/// on: 0.1 of g, 0.2 where the
/// slope at the guess is not known, 0.3 where three λ are extrapolated, whose errors change more from step to step. In
/// chains a chord takes the slower of its last two contractions for its rate, which takes up to 0.8 evaluations
/// more than the last one alone would; see `solve/stop.rs` of the core, and `optimised/tests/stopping.rs` for what the
/// last one alone leaves.
#[test]
#[cfg(long)]
fn evaluations() {
    println!("{:24} lemniscate, h = 0.02       0.01                  0.002", "");
    println!("{:24} {} chain of 100   of 1000", "", "     g    ∇g   ∇²g ".repeat(3));
    let mut rows = Vec::new();
    macro_rules! measure {
        ($name:expr, $guess:expr, $by:expr) => {
            let surface = [0.02, 0.01, 0.002].map(|h| on_the_lemniscate(h, $guess, $by));
            let chain = [100, 1000].map(|links| of_a_chain(links, $guess, $by));
            print!("{:24} ", $name);
            surface.iter().for_each(|[g, slope, bend]| print!("{g:6.2}{slope:6.2}{bend:6.2} "));
            chain.iter().for_each(|[g, slope]| print!("{g:6.2}{slope:6.2} "));
            println!();
            rows.push((surface[1], chain[1]));
        };
    }
    each!(measure);
    let expected = [
        ([2.42, 2.13, 1.00], [2.00, 1.00]),
        ([3.25, 2.06, 1.00], [3.85, 1.09]),
        ([7.54, 1.20, 1.00], [4.23, 0.00]),
        ([3.64, 1.18, 1.00], [3.32, 0.05]),
        ([2.64, 2.22, 0.04], [2.01, 1.01]),
        ([3.50, 2.04, 0.04], [4.00, 1.06]),
        ([7.65, 1.18, 0.07], [4.27, 1.01]),
        ([3.69, 1.16, 0.06], [3.41, 1.01]),
        ([2.55, 2.11, 0.14], [2.05, 1.05]),
        ([3.01, 2.07, 0.14], [3.00, 1.05]),
        ([7.57, 1.40, 0.16], [3.27, 1.05]),
        ([3.97, 1.38, 0.15], [2.99, 1.05]),
    ];
    for ((surface, chain), (on_surface, of_chain)) in rows.iter().zip(&expected) {
        let near = |found: &[f64], expected: &[f64]| apart(found, expected) <= 0.06; // roundings decide a few solves
        assert!(near(surface, on_surface) && near(chain, of_chain), "{surface:?} {chain:?}");
    }
}

/// Evaluations of g per step of the double pendulum.
fn of_the_double_pendulum<G: Guess, X: Iteration>(algebra: LinearAlgebra, guess: G, by: X) -> f64 {
    let scene = Scene::points(3).pin(0, [0.0, 0.0]).link(Rod { length: 1.0 }, [[0, 1], [1, 2]]);
    let scene = scene.masses([1.0, 0.3, 2.0]).linear_algebra(algebra).with(PlanarGravity { g: 1.0 });
    let mut simulation = scene.simulate(double_pendulum(), method(0.005, guess, by)).unwrap();
    simulation.run(400).unwrap();
    simulation.counts().values as f64 / 400.0
}

/// A basis and elimination are two ways to the same corrections. Only Broyden's depend on what is a long multiplier.
#[test]
fn evaluations_do_not_depend_on_the_linear_algebra() {
    macro_rules! check {
        ($name:expr, $guess:expr, $by:expr) => {
            let both = [LinearAlgebra::Orthogonal, LinearAlgebra::Elimination];
            let [basis, elimination] = both.map(|algebra| of_the_double_pendulum(algebra, $guess, $by));
            println!("{:24} {basis:.3} {elimination:.3}", $name);
            // Roundings decide a few solves.
            let differently = if $name.ends_with("Broyden") { 0.3 } else { 0.06 };
            assert!((basis - elimination).abs() <= differently, "{}: {basis}, {elimination}", $name);
        };
    }
    each!(check);
}

/// Steps of a composition differ in length, and sign; the last multiplier is a guess for all of them. What that is
/// off by differs from
/// step to step too, so that six of ten are looked at again.
#[test]
fn compositions_remember_too() {
    let surface = Counted::new(SURFACE);
    let counts = surface.counts();
    let scene = Scene::on(surface).with(Gravity { g: 1.0 });
    let mut pure = scene.simulate(billiard_45(), Composition::new(SUZUKI_1990_ORDER_4, 0.01)).unwrap();
    pure.run(100).unwrap();
    macro_rules! check {
        ($name:expr, $guess:expr, $by:expr) => {
            let composition = Composition::of(SUZUKI_1990_ORDER_4, method(0.01, $guess, $by));
            let mut simulation = scene.simulate(billiard_45(), composition).unwrap();
            counts.reset();
            simulation.run(100).unwrap();
            let off = distance(simulation.position(), pure.position());
            let bends = counts.curvatures() as f64 / 500.0;
            println!("{:24} off by {off:.1e}, {bends} second derivatives per step of RATTLE", $name);
            assert!(off <= 1e-14, "{}: {off:e}", $name);
            assert!($name.starts_with("g̈") == (bends == 1.0), "{}: {bends}", $name);
            assert!(!$name.starts_with("last") || bends < 0.65, "{}: {bends}", $name);
        };
    }
    each!(check);
}

/// What has no position equation along kept normals does not take a way to solve it, but any guess.
#[test]
fn systems_without_it_refuse() {
    let scene = Scene::rigid(Rigid::new([1.0, 2.0, 2.5]));
    let start = Rigid::start(&nalgebra::Matrix3::identity(), &nalgebra::Vector3::new(1.0, 0.1, 0.0));
    let error = scene.simulate(start.clone(), Rattle::new(0.01).solved_by(Broyden)).unwrap_err();
    assert!(matches!(error, Error::CannotMove { .. }), "{error}");
    scene.simulate(start, Rattle::new(0.01).guess(LastMultiplier)).unwrap().run(10).unwrap();
}
