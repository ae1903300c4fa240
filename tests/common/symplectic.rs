//! How far a map is from symplectic.

use rattle::bodies::Count;
use rattle::effect::Effects;
use rattle::prelude::*;
use rattle::scene::Hold;

/// ε of the differences.
const SHORT: f64 = 1e-4;

/// The largest change of ω = dq ∧ dp under a map of the tangent bundle of the constraints: over every two of four
/// directions, by central differences of fourth order. Its rounding is some 2e-12.
pub fn defect<C: Hold<D>, E: Effects<D>, N: Count, const D: usize>(
    scene: &Scene<C, E, N, D>,
    state: &State<D>,
    step: impl Fn(State<D>) -> State<D>,
) -> f64 {
    defect_in(scene, state, |state| state, step)
}

/// The same in the momenta that `canonical` gives: where they are not M v.
pub fn defect_in<C: Hold<D>, E: Effects<D>, N: Count, const D: usize>(
    scene: &Scene<C, E, N, D>,
    state: &State<D>,
    canonical: impl Fn(State<D>) -> State<D>,
    step: impl Fn(State<D>) -> State<D>,
) -> f64 {
    let n = state.len();
    let coordinates = |state: &State<D>| -> Vec<f64> {
        let (q, p) = (state.positions(), state.momenta());
        q.flat_map(<[f64; D]>::from).chain(p.flat_map(<[f64; D]>::from)).collect()
    };
    let here = coordinates(state);
    let near = |direction: usize, by: f64| {
        // Directions without a pattern; bodies that cannot move stay.
        let moved = |i: usize, x: f64| {
            let wave = (1.0 + direction as f64 + 2.7 * i as f64).sin();
            let pinned = n > 1 && i % (n * D) < D;
            if pinned { x } else { x + by * wave }
        };
        let moved: Vec<f64> = here.iter().enumerate().map(|(i, &x)| moved(i, x)).collect();
        let bodies =
            |numbers: &[f64]| -> Vec<[f64; D]> { numbers.chunks(D).map(|x| x.try_into().unwrap()).collect() };
        let (q, p) = moved.split_at(n * D);
        scene.project(&State::of(bodies(q)).with_momenta(bodies(p))).unwrap()
    };
    let derivative = |map: &dyn Fn(State<D>) -> State<D>, direction: usize| -> Vec<f64> {
        let at = |k: f64| coordinates(&map(near(direction, k * SHORT)));
        let (p1, m1, p2, m2) = (at(1.0), at(-1.0), at(2.0), at(-2.0));
        (0..p1.len()).map(|i| (8.0 * (p1[i] - m1[i]) - (p2[i] - m2[i])) / (12.0 * SHORT)).collect()
    };
    let omega = |a: &[f64], b: &[f64]| -> f64 {
        let m = n * D;
        (0..m).map(|i| a[i] * b[m + i] - a[m + i] * b[i]).sum()
    };
    let before: Vec<_> = (0..4).map(|d| derivative(&|state| canonical(state), d)).collect();
    let after: Vec<_> = (0..4).map(|d| derivative(&|state| canonical(step(state)), d)).collect();
    let mut worst = 0.0_f64;
    for a in 0..4 {
        for b in 0..a {
            assert!(omega(&before[a], &before[b]).abs() > 1e-3, "directions that see something");
            worst = worst.max((omega(&after[a], &after[b]) - omega(&before[a], &before[b])).abs());
        }
    }
    worst
}
