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
    /// Makes a body beside x = −20 fast, soon or late, and one at −30 not at all.
    struct Hill { s }
    |x, _y| s * exp(-(x + 20)^2 / 2)
}

force! {
    /// Along velocities.
    struct Push { c }
    |_q: [f64; 2], v: [f64; 2]| [c * v[0], c * v[1]]
}

const HEAT: Langevin = Langevin { friction: 0.1, temperature: 0.01, seed: 7 };
const LANES: usize = 40;

/// On their way to where sheets are near, at this speed, and in the last lane at rest here.
fn starts(speed: f64, last: f64) -> impl Iterator<Item = State<2>> {
    (0..LANES).map(move |i| match i + 1 {
        LANES => State::at([last, 0.0]),
        _ => State::at([-0.6 + 0.03 * i as f64, 0.0]).moving([speed, 0.0]),
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

/// The same beside a neighbour at rest and beside one that becomes fast from here on.
fn alike(from: f64, what: &str, ensemble: impl Fn(f64) -> Ensemble<2>) {
    let [slow, fast] = [-30.0, from].map(|last| bits(ensemble(last)));
    let others: Vec<_> = (0..LANES - 1).filter(|&i| slow[i] != fast[i]).collect();
    assert!(others.is_empty(), "{what}: trajectories {others:?} go otherwise beside a fast one");
}

#[test]
fn no_lane_is_looked_at_for_its_neighbour() {
    let linked = Scene::on(Waves {}).mass(1.0).with(Hill { s: 50.0 }).with(HEAT);
    alike(-19.5, "linked", |last| linked.ensemble(starts(0.3, last), Rattle::new(0.01)).unwrap());
    let pushed = Scene::on(Waves {}).with(Hill { s: 50.0 }).with(Push { c: 0.1 });
    alike(-20.001, "on a surface", |last| pushed.ensemble(starts(0.6, last), Rattle::new(0.01)).unwrap());
}
