//! Checkpoints of sweeps: a file of other scenes is refused, whichever trajectory has the other scene.

use crate::common::PlanarGravity;
use crate::common::linked::Rod;
use rattle::bodies::Count;
use rattle::checkpoint::Checkpoint;
use rattle::effect::Effects;
use rattle::nalgebra::{Matrix3, Vector3};
use rattle::prelude::*;
use rattle::scene::Hold;
use rattle::surfaces::{Lemniscate, Sphere};

potential! {
    /// A top's weight: its centre of mass lies on its third axis.
    struct Top { weight }
    |q: [[f64; 3]; 3]| weight * q[2][2]
}
phase_constraint! {
    /// The three-sphere.
    struct Hopf {}
    |q: [f64; 2], p: [f64; 2]| dot(q, q) + dot(p, p) - 1
}
hamiltonian! {
    /// Free fall.
    struct Falling { g }
    |q: [f64; 2], p: [f64; 2]| dot(p, p) / 2 + g * q[1]
}

/// Sweeps of five, of which the fourth has another parameter.
fn refused<C: Hold<D> + 'static, E: Effects<D> + 'static, N: Count, const D: usize>(
    scene: impl Fn(f64) -> Scene<C, E, N, D>,
    start: &State<D>,
    words: &str,
) {
    let of = |odd: f64| {
        let parameter = |i: u32| 0.3 + 0.1 * f64::from(i) + if i == 3 { odd } else { 0.0 };
        let scenes: Vec<_> = (0..5).map(|i| scene(parameter(i))).collect();
        let each = scenes.iter().map(|scene| (scene, scene.project(start).unwrap()));
        Ensemble::sweep(Double, each, Rattle::new(0.01)).unwrap()
    };
    let mut file = of(0.0);
    file.run(10);
    assert_eq!(file.failures().count(), 0);
    of(0.0).resume(&file.checkpoint()).unwrap();
    let error = of(1e-3).resume(&file.checkpoint()).unwrap_err().to_string();
    assert!(error.contains(words), "{error}");
}

#[test]
fn a_sweep_is_told_from_one_in_which_one_scene_is_another() {
    let ball = |g: f64| Scene::on(Sphere { r: 1.0 }).with(rattle::potentials::Gravity { g });
    refused(ball, &State::at([1.0, 0.0, 0.0]), "(effect 0)");
    let pendulum = |g: f64| {
        let rods = Scene::points(3).link(Rod { length: 1.0 }, [[0, 1], [1, 2]]).pin(0, [0.0; 2]);
        rods.with(PlanarGravity { g })
    };
    refused(pendulum, &State::of([[0.0, 0.0], [0.6, 0.8], [1.4, 0.2]]), "(effect 0)");
    let top = |weight: f64| Scene::rigid(Rigid::new([0.6, 0.8, 1.0])).with(Top { weight });
    let start = Rigid::start(&Matrix3::identity(), &Vector3::new(0.3, 0.1, 2.0));
    refused(top, &start, "(effect 0)");
    let falling = |g: f64| Scene::in_phase_space(Hopf {}, Falling { g });
    refused(falling, &State::at([-0.55, -0.83]), "(kinetic energy)");
}

/// Of 130, one of the second row is another.
#[test]
fn one_of_many_is_another() {
    let scene = |r: f64, g: f64| Scene::on(Lemniscate { a: 1.0, r }).with(rattle::potentials::Gravity { g });
    let of = |odd: [f64; 2]| {
        let [r, g] = odd;
        let radii = (0..130).map(|i| 0.1 + 1e-3 * f64::from(i));
        let mut scenes: Vec<_> = radii.map(|r| (r, scene(r, 0.1))).collect();
        scenes[77] = (r, scene(r, g));
        let start = |r: f64| State::at([0.0, 0.0, r]).moving([2.0, 0.0, 0.0]);
        let each = scenes.iter().map(|(r, scene)| (scene, start(*r)));
        Ensemble::sweep(Double, each, Rattle::new(0.01)).unwrap().retry(4)
    };
    let mut file = of([0.177, 0.1]);
    file.run(300);
    of([0.177, 0.1]).resume(&file.checkpoint()).unwrap();
    for (odd, part) in [([0.177, 0.100_001], "(effect 0)"), ([0.177_000_1, 0.1], "(constraints)")] {
        let error = of(odd).resume(&file.checkpoint()).unwrap_err().to_string();
        assert!(error.contains(&format!("another run {part}")), "{error}");
    }
}
