//! Sweeps over parameters of surfaces and effects: each trajectory is as in a scene of its own.

use crate::common::*;
use rattle::ensemble::{Compensated, Double, Ensemble, Precision, Single};
use rattle::prelude::*;

constraint! {
    /// Much of it depends on parameters alone.
    pub struct Dented { axes: [f64; 3], depth, width }
    |x, y, z| x^2 / (axes[0]^2 + axes[1]^2) + y^2 * exp(-axes[1] / axes[2]) + z^2 / axes[2]^2 - depth * tanh(width) * x * y
        + sqrt(depth^2 + width^2) * z * x / (axes[0] * axes[1]) - cos(width) * (1 + depth / axes[0])
}

potential! {
    /// A trap whose strength depends on a scale.
    pub struct Trap { stiffness, scale, g }
    |x, y, z| stiffness / (1 + scale^2) * (x^2 + y^2) / 2 + g * exp(-scale) * z
}

/// Each trajectory of a sweep is as in an ensemble of its own scene, bit for bit, failures too; returns how many fail.
fn check_sweep<P: Precision, C: rattle::scene::Hold<3> + 'static, E: rattle::effect::Effects<3> + 'static>(
    precision: P,
    trajectories: &[(Scene<C, E, rattle::bodies::One, 3>, State<3>)],
    method: &impl Method,
    steps: u64,
) -> usize {
    let each = trajectories.iter().map(|(scene, start)| (scene, start.clone()));
    let mut sweep = Ensemble::sweep(precision, each, method.clone()).unwrap();
    sweep.run(steps);
    let mut ends = Vec::new();
    for (i, (scene, start)) in trajectories.iter().enumerate() {
        let mut own = scene.ensemble_in(precision, [start.clone()], method.clone()).unwrap();
        own.run(steps);
        assert_eq!(bits(&own.state(0)), bits(&sweep.state(i)), "trajectory {i}");
        let failures = [own.failure(0), sweep.failure(i)].map(|failure| failure.map(ToString::to_string));
        assert_eq!(failures[0], failures[1], "trajectory {i}");
        ends.push(bits(&own.state(0)));
    }
    let number = ends.len();
    ends.sort();
    ends.dedup();
    assert_eq!(ends.len(), number, "each trajectory has an end of its own");
    sweep.failures().count()
}

/// 70 of them: a whole group, and one of which most lanes are copies.
fn swept<C, E>(
    scene: impl Fn(f64) -> Scene<C, E, rattle::bodies::One, 3>,
    start: impl Fn(f64) -> State<3>,
) -> Vec<(Scene<C, E, rattle::bodies::One, 3>, State<3>)> {
    (0..70).map(|i| f64::from(i) / 70.0).map(|t| (scene(t), start(t))).collect()
}

#[test]
fn a_sweep_is_its_scenes() {
    let tube = |t: f64| Lemniscate { a: 1.0 + 0.1 * t, r: 0.15 + 0.05 * t };
    let scene = |t: f64| Scene::on(tube(t)).with(Gravity { g: 0.5 + t });
    let lemniscates = swept(scene, |t| State::at([0.0, 0.0, tube(t).r]).moving([0.6, 0.8, 0.0]));
    let rattle = Rattle::new(0.01);
    let mut failures = check_sweep(Double, &lemniscates, &rattle, 200);
    failures += check_sweep(Compensated, &lemniscates, &rattle, 200);
    failures += check_sweep(Single, &lemniscates, &rattle, 200);
    failures += check_sweep(Double, &lemniscates, &PositionVerlet::new(0.01), 200);
    failures += check_sweep(Double, &lemniscates, &Composition::new(SUZUKI_1990_ORDER_4, 0.02), 50);
    failures += check_sweep(Double, &lemniscates, &Dop853::adaptive(0.05, 1e-9), 20);
    failures += check_sweep(Compensated, &lemniscates, &Taylor::new(7, 0.02), 50);

    let dent = |t: f64| Dented { axes: [1.0 + t, 1.2 - 0.1 * t, 0.9], depth: 0.1 + 0.1 * t, width: 0.3 };
    let start = |t: f64| {
        let near = State::at([0.0, 0.0, 0.9]).moving([0.6 - t, 0.8, 0.0]);
        Scene::on(dent(t)).project(&near).unwrap()
    };
    let trap = |t: f64| Trap { stiffness: 1.0 + t, scale: 0.3 + t, g: 1.0 - t };
    let two = swept(|t| Scene::on(dent(t)).with(trap(t)).with(Gravity { g: t }), start);
    failures += check_sweep(Double, &two, &rattle, 200);
    failures += check_sweep(Single, &two, &rattle, 200);
    failures += check_sweep(Double, &two, &Taylor::adaptive(12, 0.05, 1e-11), 20);
    failures += check_sweep(Double, &swept(|t| Scene::on(dent(t)), start), &rattle, 200);
    assert_eq!(failures, 0);
}

/// Effects that are more than numbers: over members, of which scenes may have different numbers, and between pairs, of
/// which one body has none.
#[test]
fn a_sweep_over_members_and_pairs_is_its_scenes() {
    let scene = |t: f64| {
        let members = vec![[0]; 1 + (3.0 * t) as usize];
        Scene::on(Lemniscate { a: 1.0, r: 0.1 + 0.1 * t })
            .with(Gravity { g: 0.5 + t }.over(members))
            .with(Ricker { depth: 1.0 + t, radius: 1.0 })
    };
    let trajectories = swept(scene, |t| State::at([0.0, 0.0, 0.1 + 0.1 * t]).moving([0.6, 0.8, 0.0]));
    assert_eq!(check_sweep(Double, &trajectories, &Rattle::new(0.01), 100), 0);
}

/// A lane whose trajectory has ended goes on as a copy of another, with the other's parameters: with its own, by which
/// every third trajectory falls too fast, the copy would end too, and the other with it.
#[test]
fn who_fails_in_a_sweep_rests_and_the_others_go_on() {
    let heavy = |t: f64| (70.0 * t).round() % 3.0 == 0.0; // the first one too, of which empty lanes are copies
    let weight = |t: f64| Gravity { g: if heavy(t) { 2000.0 + t } else { 5.0 + t } };
    let ball = |t: f64| Scene::on(Sphere { r: 1.0 + 2.0 * t });
    let start = |t: f64| State::at([1.0 + 2.0 * t, 0.0, 0.0]).moving([0.0, 0.8, 0.6]);
    let method = Rattle::new(0.1);
    let potentials = swept(|t| ball(t).with(weight(t)).with(Gravity { g: t }), start);
    assert_eq!(check_sweep(Double, &potentials, &method, 300), 24);
    assert_eq!(check_sweep(Double, &potentials, &Taylor::new(6, 0.1), 300), 24);
    let members = swept(|t| ball(t).with(Gravity { g: t }).with(weight(t).over([[0]])), start);
    assert_eq!(check_sweep(Double, &members, &method, 300), 24);
    // Too fast for a small sphere, not for a large one.
    let radius = |t: f64| if heavy(t) { 1.0 + 0.1 * t } else { 30.0 + t };
    let start = |t: f64| State::at([radius(t), 0.0, 0.0]).moving([0.0, 5.0, 7.5]);
    let surfaces = swept(|t| Scene::on(Sphere { r: radius(t) }).with(Gravity { g: 40.0 }), start);
    assert_eq!(check_sweep(Double, &surfaces, &method, 300), 24);
}
