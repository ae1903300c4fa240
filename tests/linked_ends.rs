//! Motions of linked bodies that end: the error names the reason, whatever the step.

use rand::{RngExt, SeedableRng, rngs::SmallRng};
use rattle::error::{Error, LinkedFailure, StepFailure};
use rattle::links::{Rod as Rod3, planar::Rod};
use rattle::network::LinearAlgebra;
use rattle::potentials::planar::Gravity;
use rattle::prelude::*;

constraint! {
    /// A rod of this length from the origin.
    struct Reach { length }
    |x, y| sqrt(x^2 + y^2) - length
}

constraint! {
    /// Keeps to the x axis.
    struct Guide {}
    |_x, y| y
}

/// A crank of length 1 and a rod of length 1 to a slider, which reaches the crank's axis: there it could stay.
#[test]
fn a_mechanism_that_branches_ends_at_the_branch() {
    let scene = Scene::points(2)
        .link(Reach { length: 1.0 }, [[0]])
        .link(Rod { length: 1.0 }, [[0, 1]])
        .link(Guide {}, [[1]]);
    for angle in [1.0_f64, 0.3] {
        for h in [0.02, 0.015, 0.01, 0.005, 0.002, 0.001, 0.0001] {
            let (s, c) = angle.sin_cos();
            let start = State::of([[c, s], [2.0 * c, 0.0]]).with_momenta([[-s, c], [-2.0 * s, 0.0]]);
            let mut simulation = scene.simulate(start, Rattle::new(h)).unwrap();
            let failure = simulation.run(1_000_000).unwrap_err();
            let Error::Step { cause: StepFailure::Linked(LinkedFailure::RankLost { sine, .. }), .. } =
                &failure
            else {
                panic!("from {angle} with h = {h}: {failure}");
            };
            let crank = simulation.positions().next().unwrap();
            assert!(crank.x.abs() < 0.1, "from {angle} with h = {h}: {crank:?}");
            assert!(*sine < 0.1, "from {angle} with h = {h}: {sine}");
        }
    }
}

/// Held by a force along x alone, the mass falls freely in y, and at the bottom nothing can hold it.
#[test]
fn a_rod_that_pulls_sideways_ends_at_the_bottom() {
    let scene =
        Scene::point().link_acting(Reach { length: 1.0 }, [[0]], [[true, false]]).with(Gravity { g: 1.0 });
    for angle in [1.0_f64, 2.0, 2.8] {
        let bottom = (2.0 * (1.0 - angle.cos())).sqrt();
        for h in [0.02, 0.015, 0.01, 0.005, 0.002, 0.001, 0.0001] {
            let start = State::at([angle.sin(), -angle.cos()]);
            let mut simulation = scene.simulate(start, Rattle::new(h)).unwrap();
            let failure = simulation.run(1_000_000).unwrap_err();
            let Error::Step {
                time, cause: StepFailure::Linked(LinkedFailure::CannotAct { share, .. }), ..
            } = &failure
            else {
                panic!("from {angle} with h = {h}: {failure}");
            };
            assert!(*time < bottom && *time > bottom - 0.1, "from {angle} with h = {h}: {time} and {bottom}");
            assert!(*share < 0.3, "from {angle} with h = {h}: {share}");
        }
    }
}

/// Long steps of double pendulums fail, and shorter ones pass: their rods do not come to depend on each other.
#[test]
fn long_steps_do_not_make_rods_dependent() {
    let scene = Scene::points(3)
        .pin(0, [0.0, 0.0])
        .link(Rod { length: 1.0 }, [[0, 1], [1, 2]])
        .with(Gravity { g: 1.0 });
    let mut draw = SmallRng::seed_from_u64(1);
    let mut failed = 0;
    for _ in 0..300 {
        let [a, b, u, w] = [(); 4].map(|()| draw.random_range(-3.0_f64..3.0));
        let (first, second) = ([a.sin(), -a.cos()], [b.sin(), -b.cos()]);
        let (v, relative) = ([u * a.cos(), u * a.sin()], [w * b.cos(), w * b.sin()]);
        let positions = [[0.0; 2], first, [first[0] + second[0], first[1] + second[1]]];
        let momenta = [[0.0; 2], v, [v[0] + relative[0], v[1] + relative[1]]];
        let start = State::of(positions).with_momenta(momenta);
        let mut simulation = scene.simulate(start, Rattle::new(0.15)).unwrap();
        match simulation.run(100) {
            Ok(()) => {}
            Err(Error::Step { cause: StepFailure::Linked(LinkedFailure::NotSolved { .. }), .. }) => {
                failed += 1
            }
            Err(other) => panic!("{other}"),
        }
    }
    assert!(failed > 50, "{failed}");
}

/// Masses of different size make the sines between normals small: where a step is too long for a net of them, that is
/// told, and which one passes.
#[test]
fn unequal_masses_do_not_make_rods_dependent() {
    const N: usize = 6;
    let places: Vec<[f64; 3]> = (0..N * N)
        .map(|k| {
            let (x, y) = ((k % N) as f64, (k / N) as f64);
            [x, y, 0.3 * (0.7 * x).sin() * (0.5 * y).cos()]
        })
        .collect();
    let rows = (0..N * N).filter(|k| k % N + 1 < N).map(|k| [k, k + 1]);
    let rods: Vec<[usize; 2]> = rows.chain((0..N * (N - 1)).map(|k| [k, k + N])).collect();
    let length =
        |[a, b]: [usize; 2]| (0..3).map(|d| (places[a][d] - places[b][d]).powi(2)).sum::<f64>().sqrt();
    let masses: Vec<f64> = (0..N * N).map(|i| 10_f64.powi(i as i32 % 4)).collect();
    for algebra in [LinearAlgebra::Automatic, LinearAlgebra::Orthogonal] {
        let scene = Scene::points(N * N)
            .link_each(rods.iter().map(|&rod| (Rod3 { length: length(rod) }, rod)))
            .pin(0, places[0])
            .pin(N - 1, places[N - 1])
            .masses(masses.clone())
            .linear_algebra(algebra)
            .with(rattle::potentials::weights(1.0, masses.clone()));
        let shaken = |k: usize| [0.0, 0.0, 0.2 * masses[k] * (7.0 * k as f64).sin()];
        let start = State::of(places.clone()).with_momenta((0..N * N).map(shaken));
        let start = scene.project(&start).unwrap();
        let error = scene.simulate(start.clone(), Rattle::new(0.01)).unwrap().run(10).unwrap_err();
        let Error::Step { cause: StepFailure::Linked(LinkedFailure::NotSolved { passing, .. }), .. } = &error
        else {
            panic!("{algebra:?}: {error}");
        };
        assert_eq!(passing.0, Some(0.005), "{algebra:?}: {error}");
        scene.simulate(start, Rattle::new(0.005)).unwrap().run(20).unwrap();
    }
}
