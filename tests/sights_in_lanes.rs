//! What sights in lanes tell where it is not zero, and what is found by it: residuals of starts beside their surface,
//! crossings and shadow energies with masses, of rigid bodies and in phase space.

use crate::common::larger;
use crate::lanes_phase::{Charge, Hopf};
use crate::lanes_rigid::Field;
use rattle::bodies::Count;
use rattle::effect::Effects;
use rattle::ensemble::InstructionSet;
use rattle::links::{Rod, planar};
use rattle::nalgebra::{Matrix3, Vector3};
use rattle::potentials::planar::Gravity;
use rattle::prelude::*;
use rattle::scene::Hold;
use rattle::surfaces::Sphere;

potential! {
    struct Springs {}
    |x| x^2 / 2
}

/// g of the first sight.
struct First(Vec<f64>);

impl<const D: usize> Observer<D> for First {
    fn see(&mut self, before: &Sight<'_, D>, _: &Sight<'_, D>) {
        self.0.extend(before.residuals());
    }
    fn join(&mut self, next: Self) {
        self.0.extend(next.0);
    }
}

/// An ensemble of one, which goes in lanes.
fn of_one<C: Hold<D> + 'static, E: Effects<D>, N: Count, const D: usize>(
    scene: &Scene<C, E, N, D>,
    start: &State<D>,
    method: &impl Method,
) -> Ensemble<D> {
    let ensemble = scene.ensemble([start.clone()], method.clone()).unwrap();
    assert_eq!(ensemble.plan().in_lanes == 1, InstructionSet::widest().fuses(), "{:?}", ensemble.plan());
    ensemble
}

/// A start may be 1e-10 beside its surface: |g| is told to a hundredth, by all who tell it.
fn beside<C: Hold<D> + 'static, E: Effects<D> + 'static, N: Count, const D: usize>(
    scene: &Scene<C, E, N, D>,
    start: &State<D>,
) {
    let near = |who: &str, told: &[f64]| {
        let off = told.iter().map(|g| (g / 1e-10 - 1.0).abs()).fold(0.0, larger);
        assert!(!told.is_empty() && off < 0.01, "{who}: {told:?}");
    };
    let method = Rattle::new(0.01);
    let mut alone = scene.simulate(start.clone(), method).unwrap();
    near("g", &alone.residuals());
    near("the largest |g|", &[alone.constraint_residual()]);
    near("the largest |g|, boxed", &[alone.clone().boxed().constraint_residual()]);
    let mut seen = First(vec![]);
    alone.observe(1, 1, &mut seen).unwrap();
    near("a sight alone", &seen.0);
    near("a sight in lanes", &of_one(scene, start, &method).observe(1, 1, || First(vec![])).0);
}

#[test]
fn residuals_are_those_of_starts() {
    let x = 1.0 + 5e-11; // x² − 1 = 1e-10
    beside(&Scene::on(Sphere { r: 1.0 }), &State::at([x, 0.0, 0.0]).moving([0.0, 1.0, 0.0]));
    let rod = Scene::points(2).link(Rod { length: 1.0 }, [[0, 1]]);
    beside(&rod, &State::of([[0.0; 3], [x, 0.0, 0.0]]).with_momenta([[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]]));
    let charge = Scene::in_phase_space(Hopf { r: 1.0 }, Charge { b: 0.2, g: 0.0 });
    beside(&charge, &State::at([0.6 * x, 0.0]).moving([0.0, 0.8 * x]));
}

/// Crossings of an ensemble of one are those of a simulation, but for rounding.
fn crosses_alike<C: Hold<D> + 'static, E: Effects<D>, N: Count, const D: usize>(
    scene: &Scene<C, E, N, D>,
    start: &State<D>,
    method: &impl Method,
    steps: u64,
) {
    let place = |now: &Sight<'_, D>| now.positions[0][0];
    let mut alone = scene.simulate(start.clone(), method.clone()).unwrap();
    let mut section = Section::of(place);
    alone.observe(steps, 1, &mut section).unwrap();
    let in_lanes = of_one(scene, start, method).observe(steps, 1, || Section::of(place));
    let (found, exact) = (in_lanes.crossings(), section.crossings());
    assert!(!exact.is_empty() && found.len() == exact.len(), "{found:?} for {exact:?}");
    for (found, exact) in found.iter().zip(exact) {
        let places = found.positions.iter().zip(&exact.positions).map(|(a, b)| (a - b).norm());
        let ways = found.momenta.iter().zip(&exact.momenta).map(|(a, b)| (a - b).norm());
        let off = places.chain(ways).fold((found.time - exact.time).abs(), larger);
        assert!(off < 1e-12, "{off:e}: {found:?} for {exact:?}");
    }
}

#[test]
fn crossings_are_those_of_simulations() {
    let springs = Scene::points::<1>(2).masses([2.0, 0.1]).with(Springs {});
    let start = State::of([[-1.0], [0.3]]).with_momenta([[0.0], [0.2]]);
    crosses_alike(&springs, &start, &Rattle::new(0.05), 200);
    crosses_alike(&springs, &start, &Lobatto::<4>::new(0.05), 200);
    let body = Scene::rigid(Rigid::new([1.0, 1.5, 2.0])).with(Field { weight: 1.0, pull: 0.5 });
    let start = Rigid::start(&Matrix3::identity(), &Vector3::new(0.3, 0.1, 2.0));
    crosses_alike(&body, &start, &Rattle::new(0.1), 60);
    crosses_alike(&body, &start, &Dop853::new(0.1), 60);
    let charge = Scene::in_phase_space(Hopf { r: 1.0 }, Charge { b: 0.2, g: 0.3 });
    let start = charge.project(&State::at([-0.55, -0.83]).moving([0.03, 0.02])).unwrap();
    crosses_alike(&charge, &start, &Rattle::new(0.05), 300);
}

/// Shadow energies of an ensemble of one are those of a simulation, but for rounding.
fn shadows_alike<C: Hold<D> + 'static, E: Effects<D>, N: Count, const D: usize>(
    scene: &Scene<C, E, N, D>,
    start: &State<D>,
) {
    let (method, steps) = (Rattle::new(0.05), 60);
    let begin = || [4, 6].map(|order| ShadowEnergy::new(order).unwrap());
    let mut exact = begin();
    scene.simulate(start.clone(), method).unwrap().observe(steps, 1, &mut exact).unwrap();
    let found = of_one(scene, start, &method).observe(steps, 1, begin);
    for (found, exact) in found.iter().zip(&exact) {
        let (found, exact) = (found.values(), exact.values());
        assert!(exact.len() > 50 && found.len() == exact.len() && exact.iter().all(|e| e.is_finite()));
        let off = found.iter().zip(exact).map(|(a, b)| (a - b).abs()).fold(0.0, larger);
        assert!(off < 1e-11, "{off:e}"); // of momenta by differences of places
    }
}

#[test]
fn shadow_energies_are_those_of_simulations() {
    let linked = Scene::points(3)
        .masses([1.0, 2.0, 0.5])
        .link(planar::Rod { length: 1.0 }, [[0, 1], [1, 2]])
        .pin(0, [0.0, 0.0])
        .with(Gravity { g: 1.0 });
    shadows_alike(&linked, &State::of([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]));
    let top = Scene::rigid(Rigid::new([0.6, 0.8, 1.0])).with(Field { weight: 0.7, pull: 0.0 });
    shadows_alike(&top, &Rigid::start(&Matrix3::identity(), &Vector3::new(1.8, 0.4, -0.9)));
}
