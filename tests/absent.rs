//! Pay for what you use: an effect that is absent, and one whose strength is zero, give the same motion to the bit; a
//! program of a scene without pairs and heat has no code of them; and what a particle takes in memory is counted.

use rattle::bodies::Many;
use rattle::effect::{
    Andersen, DryFriction, Effect, Effects, Langevin, LinearDrag, MagneticField, QuadraticDrag,
};
use rattle::potentials::{ConstantForce, Gravity, LennardJones};
use rattle::prelude::*;
use rattle::surfaces::Torus;

/// Positions and momenta of three particles after some steps, to the bit.
fn bits<E: Effects<3>>(scene: &Scene<Torus, E, Many, 3>) -> Vec<u64> {
    let start = State::of([[1.5, 0.0, 0.0], [-1.5, 0.0, 0.0], [0.0, 1.5, 0.0]]).with_momenta([
        [0.0, 1.0, 0.3],
        [0.0, 0.2, -0.7],
        [0.4, 0.0, 0.1],
    ]);
    let mut simulation = scene.simulate(start, Rattle::new(0.01)).unwrap();
    simulation.run(100).unwrap();
    let numbers = simulation.positions().chain(simulation.momenta()).flat_map(<[f64; 3]>::from);
    numbers.map(f64::to_bits).collect()
}

fn plain() -> Scene<Torus, impl Effects<3>, Many, 3> {
    Scene::on(Torus { major: 1.0, minor: 0.5 }).bodies(3).with(Gravity { g: 1.0 })
}

/// Of no strength, and of some: the one as if it were not there, the other not.
fn on_and_off<P: Effect<3, Kind>, Kind>(name: &str, off: P, on: P) {
    let absent = bits(&plain());
    assert_eq!(bits(&plain().with(off)), absent, "{name} of no strength");
    assert_ne!(bits(&plain().with(on)), absent, "{name} does nothing");
}

#[test]
fn the_matrix_of_effects() {
    let heat = |friction, temperature| Langevin { friction, temperature, seed: 1 };
    let bath = |rate| Andersen { rate, temperature: 1.0, seed: 1 };
    let pairs = |epsilon| LennardJones { epsilon, sigma: 0.5 };
    on_and_off("drag", LinearDrag::new(0.0), LinearDrag::new(0.1));
    on_and_off("drag by direction", LinearDrag::along([0.0; 3]), LinearDrag::along([0.1, 0.0, 0.0]));
    on_and_off("quadratic drag", QuadraticDrag { coefficient: 0.0 }, QuadraticDrag { coefficient: 0.1 });
    on_and_off("dry friction", DryFriction { coefficient: 0.0 }, DryFriction { coefficient: 0.1 });
    on_and_off("a field", MagneticField::new([0.0; 3]), MagneticField::new([0.0, 0.0, 1.0]));
    on_and_off("heat", heat(0.0, 1.0), heat(1.0, 1.0));
    on_and_off("a bath", bath(0.0), bath(10.0));
    on_and_off("pairs", pairs(0.0), pairs(1e-3));
    let force = |z| ConstantForce { force: [0.0, 0.0, z] };
    on_and_off("a force", force(0.0), force(0.1));
}
