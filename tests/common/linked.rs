//! Links, weights and starts that several tests of linked bodies use.

use super::*;
use rand::{RngExt, rngs::StdRng};
use rattle::effect::Over;
pub use rattle::links::Rod as Rod3;
pub use rattle::links::planar::Rod;

constraint! {
    /// Both rods of a double pendulum as equations of one body.
    pub struct BothRods { first, second }
    |a: [f64; 2], b: [f64; 2]| [
        sum(i in 0..2, a[i]^2) - first^2,
        sum(i in 0..2, (b[i] - a[i])^2) - second^2,
    ]
}

potential! {
    /// The weights of both.
    pub struct BothWeights { first, second }
    |_x1, y1, _x2, y2| first * y1 + second * y2
}

/// Bodies 1, 2, … hang one below the other from body 0.
pub fn chain(rods: usize) -> Vec<[usize; 2]> {
    (0..rods).map(|i| [i, i + 1]).collect()
}

/// Gravity 1 on bodies of these masses.
pub fn weights(masses: &[f64]) -> Over<PlanarGravity, 1> {
    rattle::potentials::planar::weights(1.0, masses.iter().copied())
}

/// The start of `double_pendulum.csv`, body 0 being the pivot.
pub fn double_pendulum() -> State<2> {
    State::of([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
}

/// All coordinates of all bodies.
pub fn coordinates<const D: usize>(state: &State<D>) -> Vec<f64> {
    state.positions().flat_map(<[f64; D]>::from).collect()
}

/// Positions, then momenta.
pub fn phase<const D: usize>(state: &State<D>) -> Vec<f64> {
    let momenta = state.momenta().flat_map(<[f64; D]>::from);
    coordinates(state).into_iter().chain(momenta).collect()
}

/// maxᵢ |aᵢ − bᵢ|; NaN counts as far.
pub fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, |worst, x| if x <= worst { worst } else { x })
}

/// Checks that errors at h, h/2, h/4 fall by 2^order each, to 7 % (the next term of the error).
pub fn check_ratios(what: &str, errors: [f64; 3], order: i32) {
    let expected = 2.0_f64.powi(order);
    for ratio in [errors[0] / errors[1], errors[1] / errors[2]] {
        assert!((ratio / expected - 1.0).abs() <= 0.075, "{what}: ratio {ratio:.3}, errors {errors:?}");
    }
}

/// Numbers in (−1, 1).
pub fn random<const D: usize>(rng: &mut StdRng) -> [f64; D] {
    std::array::from_fn(|_| rng.random_range(-1.0..1.0))
}

/// The simulation at time t, after so many steps.
pub fn after<Y: rattle::system::System<f64, D>, S: Method, const D: usize>(
    simulate: impl Fn(f64) -> Result<Simulation<Y, S, D>, rattle::Error>,
    t: f64,
    steps: u32,
) -> Simulation<Y, S, D> {
    let mut simulation = simulate(t / f64::from(steps)).unwrap();
    simulation.run(u64::from(steps)).unwrap();
    assert_eq!(simulation.steps(), u64::from(steps));
    simulation
}
