//! What becomes of a trajectory does not depend on its neighbours where one of them is faster than expected: it is
//! asked at once whether other sheets are near that one, and none of the others.

use rattle::effect::Langevin;
use rattle::ensemble::{Ensemble, InstructionSet};
use rattle::prelude::*;

constraint! {
    /// Sheets that come near each other as x grows.
    struct Waves {}
    |x, y| sin((2 + 700 * exp(x)) * y)
}

potential! {
    /// Makes a body at x = −19.5 fast, and one at −30 none.
    struct Hill { s }
    |x, _y| s * exp(-(x + 20)^2 / 2)
}

const HEAT: Langevin = Langevin { friction: 0.1, temperature: 0.01, seed: 7 };
const LANES: usize = 40;

/// On their way to where sheets are near, and in the last lane at rest here.
fn starts(last: f64) -> impl Iterator<Item = State<2>> {
    (0..LANES).map(move |i| match i + 1 {
        LANES => State::at([last, 0.0]),
        _ => State::at([-0.6 + 0.03 * i as f64, 0.0]).moving([0.3, 0.0]),
    })
}

/// The bits of all but the last trajectory; the first run ends just before it is asked around as ever.
fn bits(mut ensemble: Ensemble<2>) -> Vec<Vec<u64>> {
    let plan = ensemble.plan();
    assert_eq!(plan.in_lanes == LANES, InstructionSet::widest().fuses(), "{plan:?}");
    ensemble.run(63);
    ensemble.run(300);
    let of = |i| {
        let state: State<2> = ensemble.state(i);
        let numbers = state.positions().chain(state.momenta()).flat_map(|x| [x[0], x[1]]);
        numbers.map(f64::to_bits).collect()
    };
    (0..LANES - 1).map(of).collect()
}

/// The same beside a neighbour at rest and beside a fast one.
fn alike(ensemble: impl Fn(f64) -> Ensemble<2>, what: &str) {
    let [slow, fast] = [-30.0, -19.5].map(|last| bits(ensemble(last)));
    let others: Vec<_> = (0..LANES - 1).filter(|&i| slow[i] != fast[i]).collect();
    assert!(others.is_empty(), "{what}: trajectories {others:?} go otherwise beside a fast one");
}

#[test]
fn no_lane_is_looked_at_for_its_neighbour() {
    let body = || Scene::on(Waves {}).with(Hill { s: 50.0 });
    let heated = body().with(HEAT);
    alike(|last| heated.ensemble(starts(last), Rattle::new(0.01)).unwrap(), "on a surface");
    let linked = Scene::on(Waves {}).mass(1.0).with(Hill { s: 50.0 }).with(HEAT);
    alike(|last| linked.ensemble(starts(last), Rattle::new(0.01)).unwrap(), "linked");
    let drawn = Brownian::new(1.0, 0.05, 7, 0.01);
    alike(|last| body().ensemble(starts(last), drawn).unwrap(), "Brownian");
}
