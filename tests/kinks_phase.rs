//! Kinks of constraints on phase space: where ∇g(q, p) jumps, no step leads across.

use rattle::Error;
use rattle::ensemble::NotInLanes;
use rattle::error::StepFailure;
use rattle::kernel::{Hamiltonian, PhaseConstraint};
use rattle::prelude::*;

phase_constraint! {
    /// Two planes that meet in a ridge, and two bowls that meet in a seam; momenta are free.
    struct Roof { slope, bowls }
    |q: [f64; 3], p: [f64; 3]| q[2] + slope * abs(q[0]) + bowls * abs(q[0])^3 + 0 * p[0]
}
phase_constraint! {
    /// Two lenses of positions and momenta, with a ridge in the positions, and in the momenta.
    struct Lenses { of_place, of_momentum }
    |q: [f64; 2], p: [f64; 2]|
        dot(q, q) + dot(p, p) + of_place * abs(q[0]) + of_momentum * abs(p[0]) - 1
}
hamiltonian! {
    struct Free {}
    |q: [f64; 3], p: [f64; 3]| dot(p, p) / 2 + 0 * q[0]
}
hamiltonian! {
    /// A spring along x, and weight along −y.
    struct Pulled { g, k }
    |q: [f64; 2], p: [f64; 2]| dot(p, p) / 2 + g * q[1] + k * q[0]^2 / 2
}

/// The argument that changes its sign, and where, if that ends so many steps.
fn kink<G, H, const D: usize>(law: (G, H), start: State<D>, h: f64, steps: u64) -> Option<(&'static str, f64)>
where
    G: PhaseConstraint<D, 1> + Clone + 'static,
    H: Hamiltonian<D> + Clone + 'static,
{
    let scene = Scene::in_phase_space(law.0, law.1);
    let start = scene.project(&start).unwrap();
    let mut simulation = scene.simulate(start, Rattle::new(h)).unwrap();
    match simulation.run(steps) {
        Ok(()) => {
            assert!(simulation.energy_error().abs() < 1e-3, "h = {h}: {:e}", simulation.energy_error());
            None
        }
        Err(Error::Step { cause: StepFailure::Kink { argument, position, .. }, .. }) => {
            assert!(simulation.energy_error().abs() < 1e-3, "h = {h}: {:e}", simulation.energy_error());
            Some((argument, position[0]))
        }
        Err(other) => panic!("h = {h}: {other}"),
    }
}

#[test]
fn the_step_across_a_ridge_is_an_error() {
    let start = State::at([-0.55, 0.1, -0.275]).moving([1.0, 0.2, 0.5]);
    for h in [0.05, 0.02, 0.03] {
        let roof = Roof { slope: 0.5, bowls: 0.0 };
        let (argument, x) = kink((roof, Free {}), start.clone(), h, 60).unwrap();
        assert!(argument == "q[0]" && x.abs() < 1e-5, "{argument} at {x:e}");
        let bowls = Roof { slope: 0.0, bowls: 1.0 };
        assert_eq!(kink((bowls, Free {}), start.clone(), h, 20), None); // x³ has no ridge
    }
}

#[test]
fn ridges_of_positions_and_of_momenta() {
    for h in [0.05, 0.02, 0.01] {
        let steps = (3.0 / h) as u64;
        let of_place = Lenses { of_place: 0.5, of_momentum: 0.0 };
        let start = State::at([-0.55, -0.63]).moving([0.3, 0.02]);
        let (argument, x) = kink((of_place, Pulled { g: 0.3, k: 0.0 }), start, h, steps).unwrap();
        assert!(argument == "q[0]" && x.abs() < 1e-5, "h = {h}: {argument} at {x:e}");
        let of_momentum = Lenses { of_place: 0.0, of_momentum: 0.5 };
        let start = State::at([0.3, -0.63]).moving([0.2, 0.02]);
        let (argument, x) = kink((of_momentum, Pulled { g: 0.3, k: 2.0 }), start, h, 4 * steps).unwrap();
        assert!(argument == "p[0]" && x > 0.3, "h = {h}: {argument} at {x:e}");
    }
}

/// Rows are not looked at for kinks, so trajectories go by themselves.
#[test]
fn ensembles_end_as_simulations_do() {
    let scene = Scene::in_phase_space(Roof { slope: 0.5, bowls: 0.0 }, Free {});
    let start = scene.project(&State::at([-0.55, 0.1, -0.275]).moving([1.0, 0.2, 0.5])).unwrap();
    let mut ensemble = scene.ensemble(vec![start.clone(); 20], Rattle::new(0.05)).unwrap();
    let plan = ensemble.plan();
    assert_eq!(plan.alone, 20);
    assert!(
        matches!(plan.reason, Some(NotInLanes::System | NotInLanes::Instructions(_))),
        "{:?}",
        plan.reason
    );
    ensemble.run(60);
    let mut simulation = scene.simulate(start, Rattle::new(0.05)).unwrap();
    let failure = simulation.run(60).unwrap_err().to_string();
    assert_eq!(ensemble.failures().count(), 20);
    assert!(ensemble.failures().all(|(_, error)| error.to_string() == failure), "{failure}");
}
