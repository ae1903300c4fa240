//! Links of any length, and far from the origin.

use rattle::ensemble::Double;
use rattle::links::Rod;
use rattle::network::LinearAlgebra;
use rattle::potentials::Gravity;
use rattle::prelude::*;

/// Pendulums, single and double, far out along x, that swing in a plane across x: differences along x are exactly 0,
/// and so nothing of x is rounded into lengths. (`few.rs` took a pin's largest coordinate for what
/// g is rounded to: 3e-8 off at 1e9.)
#[test]
fn rods_far_along_an_axis_keep_their_lengths() {
    for far in [0.0, 1e6, 1e9] {
        for (bodies, h) in [(2, 0.1), (2, 0.2), (3, 0.05)] {
            for algebra in [LinearAlgebra::Automatic, LinearAlgebra::Elimination] {
                let scene = Scene::points(bodies)
                    .link(Rod { length: 1.0 }, (1..bodies).map(|i| [i - 1, i]))
                    .pin(0, [far, 0.0, 0.0])
                    .linear_algebra(algebra)
                    .with(Gravity { g: 1.0 });
                let start = State::of((0..bodies).map(|i| [far, 0.0, -(i as f64)]))
                    .with_momenta((0..bodies).map(|i| [0.0, 1.5 * (i as f64), 0.0]));
                let mut simulation = scene.simulate(start.clone(), Rattle::new(h)).unwrap();
                let mut ensemble = scene.ensemble_in(Double, [start.clone(), start], Rattle::new(h)).unwrap();
                let mut off = 0.0_f64;
                for _ in 0..300 {
                    simulation.step().unwrap();
                    ensemble.run(1);
                    let of_lane = ensemble.state(0);
                    for q in [simulation.positions().collect::<Vec<_>>(), of_lane.positions().collect()] {
                        for pair in q.windows(2) {
                            off = off.max(((pair[1] - pair[0]).norm() - 1.0).abs());
                        }
                    }
                }
                // Roundings of coordinates of up to 2.
                assert!(off <= 4.0 * f64::EPSILON, "{far:e} {bodies} {h} {algebra:?}: {off:e}");
            }
        }
    }
}

/// Rods of any length whose square has all digits: roundings of g may have none.
#[test]
fn the_shortest_rods_move() {
    for length in [1e-140, 1e-146, 1e-147, 1e-150, 1e-153] {
        for bodies in [2, 5] {
            let rod = Rod { length };
            let scene = Scene::points(bodies).link(rod, (1..bodies).map(|i| [i - 1, i])).pin(0, [0.0; 3]);
            let places = (0..bodies).map(|i| [length * i as f64, 0.0, 0.0]);
            let start = State::of(places).with_momenta((0..bodies).map(|i| [0.0, length * i as f64, 0.0]));
            let mut simulation = scene.simulate(start, Rattle::new(0.01)).unwrap();
            simulation.run(10).unwrap_or_else(|error| panic!("{length:e} {bodies}: {error}"));
            let q: Vec<_> = simulation.positions().collect();
            for pair in q.windows(2) {
                let off = ((pair[1] - pair[0]) / length).norm() - 1.0;
                // Roundings of coordinates; and, where those of g have no digits, the least number over 2 L².
                let most = 8.0 * f64::EPSILON * bodies as f64 + f64::MIN_POSITIVE / length / length;
                assert!(off.abs() <= most, "{length:e} {bodies}: {off:e}");
            }
        }
    }
}
