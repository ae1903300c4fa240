//! Links whose equation has many roots side by side: a step must not end on another one.
//!
//! `sin(k(|a − b| − 1))` holds two bodies at distance 1, or at any of 1 + πj/k. Only the distance, which no simulation
//! sees, tells which.

use crate::common::outcome::Outcome;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle::bodies::Many;
use rattle::effect::Effects;
use rattle::links::planar::Rod;
use rattle::nalgebra::Vector2;
use rattle::network::{LinearAlgebra, Network};
use rattle::potentials::planar::Gravity;
use rattle::prelude::*;
use rayon::prelude::*;

constraint! {
    /// Two bodies at a distance of 1, or of others.
    struct Distances { k }
    |x1, y1, x2, y2| sin(k * (sqrt((x2 - x1)^2 + (y2 - y1)^2) - 1))
}

/// A chain that hangs from a pivot: links of `Distances` and rods in turn.
fn chain(links: usize, k: f64, algebra: LinearAlgebra) -> Scene<Network<2>, impl Effects<2>, Many, 2> {
    let pairs = |parity: usize| (0..links).filter(move |i| i % 2 == parity).map(|i| [i, i + 1]);
    Scene::points(links + 1)
        .link(Distances { k }, pairs(0))
        .link(Rod { length: 1.0 }, pairs(1))
        .pin(0, [0.0, 0.0])
        .linear_algebra(algebra)
        .with(Gravity { g: 1.0 })
}

/// Random places and momenta of such a chain.
fn start(links: usize, random: &mut StdRng) -> State<2> {
    let mut places = vec![[0.0, 0.0]];
    let mut momenta = vec![[0.0, 0.0]];
    for i in 0..links {
        let (angle, rate) = (random.random_range(-3.0_f64..3.0), random.random_range(-1.5..1.5));
        let ([x, y], [u, v], (sin, cos)) = (places[i], momenta[i], angle.sin_cos());
        places.push([x + cos, y + sin]);
        momenta.push([u - rate * sin, v + rate * cos]);
    }
    State::of(places).with_momenta(momenta)
}

/// By how much a distance is not 1, at most.
fn strain(places: impl Iterator<Item = Vector2<f64>>) -> f64 {
    let places: Vec<_> = places.collect();
    places.windows(2).map(|pair| ((pair[1] - pair[0]).norm() - 1.0).abs()).fold(0.0, f64::max)
}

/// Random chains in lanes, 40 from each of so many scenes.
fn chains_in_lanes<P: Precision, S: Method>(
    precision: P,
    seed: u64,
    scenes: u32,
    links: usize,
    method: impl Fn(f64) -> S,
) -> Outcome {
    let mut random = StdRng::seed_from_u64(seed);
    let mut outcome = Outcome::default();
    for _ in 0..scenes {
        let k = 10_f64.powf(random.random_range(2.5..6.0));
        let h = 10_f64.powf(random.random_range(-2.5..-0.5));
        let starts = (0..40).map(|_| start(links, &mut random)).collect::<Vec<_>>();
        let scene = chain(links, k, LinearAlgebra::Automatic);
        let mut ensemble = scene.ensemble_in(precision, starts, method(h)).unwrap();
        ensemble.run(60);
        for (i, state) in ensemble.states().enumerate() {
            let worst = strain(state.positions());
            if worst > 1e-9 {
                println!("seed {seed} k = {k:e}, h = {h}: {worst:e} in lane {i}");
            }
            outcome.note(worst, ensemble.failure(i), 1e-9);
        }
    }
    outcome
}

/// Random chains.
fn chains<S: Method>(seed: u64, runs: u32, links: usize, method: impl Fn(f64) -> S) -> Outcome {
    let mut random = StdRng::seed_from_u64(seed);
    let mut outcome = Outcome::default();
    for _ in 0..runs {
        let k = 10_f64.powf(random.random_range(2.5..6.0));
        let h = 10_f64.powf(random.random_range(-2.0..-0.5));
        let start = start(links, &mut random);
        let algebra =
            if random.random_bool(0.7) { LinearAlgebra::Automatic } else { LinearAlgebra::Orthogonal };
        let scene = chain(links, k, algebra);
        let simulation = scene.simulate(start, method(h)).unwrap();
        let name = format_args!("seed {seed} k = {k:e}, h = {h}");
        outcome.watch(name, simulation, 60, |now| strain(now.positions()), 1e-9);
    }
    outcome
}

/// None is wrong, and so many are not refused: where roots are closer than a path in which one can be followed, it
/// cannot.
fn stay<S: Method>(seed: u64, runs: u32, links: usize, right: u32, method: impl Fn(f64) -> S) {
    chains(seed, runs, links, method).check(right);
}

#[test]
#[cfg(long)]
fn chains_keep_their_distances() {
    stay(1, 1000, 1, 700, Rattle::new);
    stay(2, 500, 2, 290, Rattle::new);
    stay(3, 200, 7, 60, Rattle::new);
}

#[test]
#[cfg(long)]
fn other_iterations_and_guesses_keep_them() {
    stay(4, 300, 3, 140, |h| Rattle::new(h).solved_by(Broyden));
    stay(5, 300, 3, 130, |h| Rattle::new(h).solved_by(Simplified));
    stay(6, 300, 3, 130, |h| Rattle::new(h).guess(Extrapolated));
    stay(7, 300, 3, 130, |h| Rattle::new(h).guess(LastMultiplier).solved_by(Symmetric));
}

/// What a guess is off by grows and shrinks with the steps of a composition, the distance of roots does not.
#[test]
#[cfg(long)]
fn compositions_keep_them() {
    stay(8, 300, 2, 200, |h| Composition::new(rattle::composition::SUZUKI_1990_ORDER_4, h));
    stay(9, 300, 2, 140, |h| Composition::new(rattle::composition::YOSHIDA_1990_ORDER_4, h));
}

/// Methods that follow no root look inside their steps, and refuse those that end on another one.
#[test]
#[cfg(long)]
fn methods_without_a_guess_keep_them() {
    stay(20, 300, 2, 110, Lobatto::<3>::new);
    stay(21, 300, 3, 80, Lobatto::<5>::new);
    stay(22, 300, 2, 200, |h| Taylor::new(8, h));
    stay(23, 300, 2, 210, Dop853::new);
    stay(24, 300, 2, 80, Bdf2::new);
}

#[test]
#[cfg(long)]
fn lanes_keep_them() {
    for (seed, links, right) in [(30, 1, 240), (31, 2, 200), (32, 3, 160), (33, 7, 80)] {
        chains_in_lanes(Double, seed, 12, links, Rattle::new).check(right);
    }
    let suzuki = |h| Composition::new(rattle::composition::SUZUKI_1990_ORDER_4, h);
    chains_in_lanes(Compensated, 34, 8, 2, suzuki).check(80);
}

#[test]
#[cfg(long)]
#[ignore = "some minutes"]
fn many_chains_in_lanes_keep_them() {
    let wrong = |seed: u64| chains_in_lanes(Double, seed, 25, 1 + (seed % 4) as usize, Rattle::new).wrong;
    assert_eq!((9000..9100_u64).into_par_iter().map(wrong).sum::<u32>(), 0);
}

/// `cargo long --test networks sheets_linked::many_chains -- --ignored`
#[test]
#[cfg(long)]
#[ignore = "some minutes"]
fn many_chains_keep_them_by_methods_without_a_guess() {
    let wrong = |seed: u64| {
        let links = 1 + (seed % 4) as usize;
        chains(seed, 100, links, Lobatto::<3>::new).wrong
            + chains(seed, 100, links, Lobatto::<5>::new).wrong
            + chains(seed, 100, links, |h| Taylor::new(8, h)).wrong
            + chains(seed, 100, links, Dop853::new).wrong
            + chains(seed, 100, links, Bdf2::new).wrong
    };
    assert_eq!((5000..5200_u64).into_par_iter().map(wrong).sum::<u32>(), 0);
}

#[test]
#[cfg(long)]
#[ignore = "some minutes"]
fn a_hundred_thousand_chains_keep_them() {
    let wrong: u32 = (0..1000_u64)
        .into_par_iter()
        .map(|seed| chains(1000 + seed, 100, 1 + (seed % 4) as usize, Rattle::new).wrong)
        .sum();
    assert_eq!(wrong, 0);
}

constraint! {
    /// Two bodies at a distance of 1, of which the equation is no number where they are farther than 1.01 apart.
    struct Short {}
    |x1, y1, x2, y2| 1 - sqrt(1.0201 - (x2 - x1)^2 - (y2 - y1)^2) / sqrt(0.0201)
}

/// Where a guess lies beyond where an equation is a number, its root is followed in parts that do not.
#[test]
fn a_guess_beyond_the_domain_is_followed() {
    let mut followed = 0;
    for speed in [0.5, 1.0, 1.5, 2.0, 2.5] {
        let scene = Scene::points(2).link(Short {}, [[0, 1]]).pin(0, [0.0, 0.0]);
        let start = State::of([[0.0, 0.0], [1.0, 0.0]]).with_momenta([[0.0, 0.0], [0.0, speed]]);
        let mut simulation = scene.simulate(start, Rattle::new(0.25)).unwrap();
        if simulation.run(20).is_ok() {
            assert!((simulation.positions().nth(1).unwrap().norm() - 1.0).abs() < 1e-12);
            followed += simulation.counts().followed;
        }
        println!("{speed}: {} steps, {:?}", simulation.steps(), simulation.counts());
    }
    assert!(followed > 0);
}
