//! faer's factorisation of the momentum equation against elimination; built with the feature `faer` only.
//!
//! ```text
//! cargo test --release --features faer --test supernodal
//! ```

use rattle::iteration::{Iteration, Newton, Simplified};
use rattle::links::Rod;
use rattle::network::LinearAlgebra::{self, Elimination, Supernodal};
use rattle::potentials::Gravity;
use rattle::prelude::*;

/// Knots along an edge.
const N: usize = 10;

fn place(knot: usize) -> [f64; 3] {
    let at = [knot / N / N, knot / N % N, knot % N];
    std::array::from_fn(|d| at[d] as f64 + 0.2 * ((7 * knot + 3 * d) as f64).sin())
}

fn length([a, b]: [usize; 2]) -> f64 {
    (0..3).map(|d| (place(a)[d] - place(b)[d]).powi(2)).sum::<f64>().sqrt()
}

/// A lattice of rods, of which those along the first axis are every other: as many equations as bodies have freedoms
/// would not be independent.
fn rods() -> Vec<[usize; 2]> {
    let mut rods = Vec::new();
    for knot in 0..N * N * N {
        let (first, second, third) = (knot / N / N, knot / N % N, knot % N);
        if first + 1 < N && (second + third) % 2 == 0 {
            rods.push([knot, knot + N * N]);
        }
        if second + 1 < N {
            rods.push([knot, knot + N]);
        }
        if third + 1 < N {
            rods.push([knot, knot + 1]);
        }
    }
    rods
}

/// The positions after some steps, how they were found, and allocations on the way.
fn run(algebra: LinearAlgebra, iteration: impl Iteration) -> (Vec<f64>, LinearAlgebra, u64) {
    let scene = Scene::points(N * N * N)
        .link_each(rods().into_iter().map(|ends| (Rod { length: length(ends) }, ends)))
        .with(Gravity { g: 1.0 })
        .linear_algebra(algebra);
    let momenta = (0..N * N * N).map(|knot| [0, 1, 2].map(|d| 0.5 * ((5 * knot + d) as f64).cos()));
    let start = scene.project(&State::of((0..N * N * N).map(place)).with_momenta(momenta)).unwrap();
    let mut simulation = scene.simulate(start, Rattle::new(1e-3).solved_by(iteration)).unwrap();
    simulation.run(2).unwrap();
    let mut copy = simulation.clone();
    let counted = allocation_counter::measure(|| copy.run(20).unwrap()).count_total;
    let by = copy.system().components().next().unwrap().by;
    (copy.positions().flat_map(<[f64; 3]>::from).collect(), by, counted)
}

#[test]
fn lattices_move_as_by_elimination() {
    let (by_elimination, by, _) = run(Elimination, Newton);
    assert_eq!(by, Elimination);
    for (found, by, allocations) in [run(Supernodal, Newton), run(Supernodal, Simplified)] {
        assert_eq!((by, allocations), (Supernodal, 0));
        let apart = found.iter().zip(&by_elimination).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("apart by {apart:.1e}");
        assert!(apart <= 1e-12, "{apart:e}");
    }
}

#[test]
fn a_chain_stays_with_elimination() {
    let scene = Scene::points(51)
        .link(Rod { length: 1.0 }, (0..50).map(|i| [i, i + 1]))
        .pin(0, [0.0; 3])
        .linear_algebra(Supernodal);
    let start = State::of((0..51).map(|i| [f64::from(i), 0.0, 0.0]));
    let simulation = scene.simulate(start, Rattle::new(0.01)).unwrap();
    assert_eq!(simulation.system().components().next().unwrap().by, Elimination);
}

/// Nothing is there to put into blocks.
#[test]
fn one_equation_stays_with_elimination() {
    let scene = Scene::points(2).link(Rod { length: 1.0 }, [[0, 1]]).linear_algebra(Supernodal);
    let simulation = scene.simulate(State::of([[0.0; 3], [1.0, 0.0, 0.0]]), Rattle::new(0.01)).unwrap();
    assert_eq!(simulation.system().components().next().unwrap().by, Elimination);
}

#[test]
fn equations_that_depend_on_each_other_are_refused() {
    let twice = rods().into_iter().chain(rods().into_iter().take(1));
    let scene = Scene::points(N * N * N)
        .link_each(twice.map(|ends| (Rod { length: length(ends) }, ends)))
        .linear_algebra(Supernodal);
    let message = scene.simulate(State::of((0..N * N * N).map(place)), Rattle::new(1e-3)).map(drop);
    let message = message.unwrap_err().to_string();
    assert!(message.contains("depend"), "{message}");
}
