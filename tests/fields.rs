//! Magnetic fields beside forces: turns around the field, and the drift across it, at steps of any length.

use crate::common::order;
use rattle::bodies::{Alone, Count};
use rattle::effect::{Effects, MagneticField};
use rattle::nalgebra::{Matrix3, SVector, Vector3};
use rattle::potentials::ConstantForce;
use rattle::prelude::*;
use rattle::scene::Hold;
use rattle::surfaces::Plane;
use std::f64::consts::PI;

const FORCE: [f64; 3] = [1.0, 0.5, 0.0];

/// h ω: steps that resolve the rotation, and such that do not.
const TURNS: [f64; 7] = [0.25, 0.5, 1.0, 2.0, 5.0, 8.0, 200.0];

/// f × B/B², the drift across a field B under a force f ⟂ B.
fn drift(field: Vector3<f64>) -> Vector3<f64> {
    Vector3::from(FORCE).cross(&field) / field.norm_squared()
}

/// Bodies that start with the momentum of the drift v have that drift, on average over many turns of h ω each.
fn drifts<C: Hold<3>, E: Effects<3>, N: Count + Alone, S: Method>(
    what: &str,
    scene: &Scene<C, E, N, 3>,
    method: S,
    p: Vector3<f64>,
    (v, turn): (Vector3<f64>, f64),
) {
    let start = State::at([0.0; 3]).with_momenta([p]);
    let mut simulation = scene.simulate(start, method).unwrap();
    simulation.run(5000).unwrap();
    let mean = simulation.position() / simulation.time();
    let off = (mean - v).norm() / v.norm();
    // Circles of radius |v| (1/ω + h/2) and some more come to this part of the way.
    assert!(off < (1.0 + turn) / 5000.0 + 1e-4, "{what}: {mean} instead of {v}");
}

/// The drift under a force is f × B/B² at any h ω, free and on a surface, by methods with the flow at the ends and in
/// the middle of a step, forwards and backwards. Two halves of 2 arctan(h ω/4) had 0.94 of it at h ω = 1, and −0.56 of
/// it at 5.
#[test]
fn bodies_drift_across_a_field_and_a_force() {
    let h = 0.1;
    for turn in TURNS {
        let field = Vector3::new(0.0, 0.0, turn / h);
        let (free, v) = (Scene::point().with(ConstantForce { force: FORCE }), drift(field));
        let free = free.with(MagneticField::new(field.into()));
        drifts(&format!("RATTLE, {turn}"), &free, Rattle::new(h), v, (v, turn));
        drifts(&format!("backwards, {turn}"), &free, Rattle::new(-h), v, (v, turn));
        drifts(&format!("BAOAB, {turn}"), &free, Baoab::new(h), v, (v, turn));
        drifts(&format!("position Verlet, {turn}"), &free, PositionVerlet::new(h), v, (v, turn));
        let floor = Scene::on(Plane { a: 0.0, b: 0.0, c: 1.0, d: 0.0 }).with(ConstantForce { force: FORCE });
        // What of a field is along the floor does not count there.
        let tilted = floor.with(MagneticField::new([0.0, 0.0, turn / h]));
        drifts(&format!("on a plane, {turn}"), &tilted, Rattle::new(h), v, (v, turn));
    }
}

/// A mass that differs by direction, or is a matrix, changes the turn and not the drift; charges change both.
#[test]
fn masses_and_charges_drift_as_they_should() {
    let h = 0.1;
    let matrix = Matrix3::new(2.0, 0.9, 0.3, 0.9, 1.0, -0.2, 0.3, -0.2, 0.5);
    let diagonal = [1.0, 3.0, 0.4];
    for strength in [1.0, 20.0, 400.0] {
        let b = Vector3::new(0.5, -1.0, 2.0) * strength;
        let (force, field) = (ConstantForce { force: FORCE }, MagneticField::new(b.into()));
        let free = || Scene::point().with(force).with(field.clone());
        let turn = |mass: Matrix3<f64>| h * f64::sqrt((mass * b).dot(&b) / mass.determinant());
        let v = drift(b);
        let mass = Matrix3::from_diagonal(&Vector3::from(diagonal));
        drifts("directions", &free().mass(diagonal), Rattle::new(h), mass * v, (v, turn(mass)));
        drifts("a matrix", &free().mass(matrix), Rattle::new(h), matrix * v, (v, turn(matrix)));
        let charged = Scene::point().mass(0.3).with(force).with(field.clone().charges([-2.0]));
        let turn = 2.0 * h * b.norm() / 0.3;
        drifts("a charge of −2", &charged, Rattle::new(h), -0.15 * v, (-0.5 * v, turn));
    }
}

/// Lanes drift as bodies alone do: 20 trajectories in fields of their own strengths, on a plane.
#[test]
fn lanes_drift_as_bodies_alone() {
    let h = 0.1;
    let scene = |turn: f64| {
        Scene::on(Plane { a: 0.0, b: 0.0, c: 1.0, d: 0.0 })
            .with(ConstantForce { force: FORCE })
            .with(MagneticField::new([0.0, 0.0, turn / h]))
    };
    for turn in TURNS {
        let v = drift(Vector3::new(0.0, 0.0, turn / h));
        let start = State::at([0.0; 3]).moving(v);
        for method in [h, -h] {
            let mut lanes = scene(turn).ensemble(vec![start.clone(); 20], Rattle::new(method)).unwrap();
            lanes.run(1000);
            let mut alone = scene(turn).simulate(start.clone(), Rattle::new(method)).unwrap();
            alone.run(1000).unwrap();
            for number in 0..20 {
                let state = lanes.state(number);
                let (q, p) = (state.positions().next().unwrap(), state.momenta().next().unwrap());
                let off = (q - alone.position()).norm() / alone.position().norm()
                    + (p - alone.momentum()).norm() / v.norm();
                assert!(off < 1e-10, "{turn}: {off:e}");
            }
        }
    }
}

/// A step turns by 2 arctan(h ω/2), whatever the mass: ω² = BᵀMB/det M, and N steps of 2π/N close a circle.
#[test]
fn turns_are_those_of_boris() {
    let matrix = Matrix3::new(2.0, 0.9, 0.3, 0.9, 1.0, -0.2, 0.3, -0.2, 0.5);
    let diagonal = Matrix3::from_diagonal(&Vector3::new(1.0, 3.0, 0.4));
    for (mass, field) in [
        (matrix, [0.5, -1.0, 2.0]),
        (diagonal, [0.5, -1.0, 2.0]),
        (4.0 * Matrix3::identity(), [0.0, 7.0, 1.0]),
    ] {
        let b = Vector3::from(field);
        let omega = f64::sqrt((mass * b).dot(&b) / mass.determinant());
        for steps in [3_u32, 4, 7, 100] {
            let h = 2.0 / omega * (PI / f64::from(steps)).tan();
            let scene = Scene::point().mass(mass).with(MagneticField::new(field));
            let p = Vector3::new(0.3, -0.8, 0.5);
            // No mean velocity along the field: p along it stays.
            let p = p - mass * b * (b.dot(&p) / b.dot(&(mass * b)));
            let start = State::at([0.0; 3]).with_momenta([p]);
            let mut simulation = scene.simulate(start, Rattle::new(h)).unwrap();
            simulation.run(steps.into()).unwrap();
            let off = (simulation.momentum() - p).norm() + simulation.position().norm() / h;
            assert!(off < 1e-12, "{mass}{steps} steps: {off:e}");
            assert!(simulation.energy_error().abs() < 1e-13 && simulation.work().abs() < 1e-13);
        }
    }
}

/// Against the exact motion, a circle of radius |v − u|/ω around a place that moves with the drift u: of second order.
#[test]
fn circles_with_a_drift_are_of_second_order() {
    let (b, v) = (3.0, Vector3::new(0.4, -0.7, 0.2));
    let u = drift(Vector3::new(0.0, 0.0, b));
    let exact = |t: f64| {
        let (s, c) = (b * t).sin_cos();
        let w = v - u - Vector3::new(0.0, 0.0, v.z);
        // ẇ = w × B turns clockwise.
        let turned = Vector3::new(w.x * s + w.y * (1.0 - c), w.y * s - w.x * (1.0 - c), 0.0) / b;
        u * t + turned + Vector3::new(0.0, 0.0, v.z * t)
    };
    let scene = Scene::point().with(ConstantForce { force: FORCE }).with(MagneticField::new([0.0, 0.0, b]));
    let time = 5.0;
    let errors = [100_u64, 200, 400, 800].map(|steps| {
        let start = State::at([0.0; 3]).moving(v);
        let mut simulation = scene.simulate(start, Rattle::new(time / steps as f64)).unwrap();
        simulation.run(steps).unwrap();
        (simulation.position() - SVector::from(exact(time))).norm()
    });
    let order = order(&errors);
    assert!((1.9..2.1).contains(&order) && errors[3] < 1e-3, "{errors:?}");
}

/// A field that no number holds turns nothing: an error, not a straight way.
#[test]
fn a_field_beyond_all_numbers_is_an_error() {
    let scene = Scene::point().with(MagneticField::new([0.0, 0.0, 1e200]));
    let mut simulation =
        scene.simulate(State::at([0.0; 3]).moving([1.0, 0.0, 0.0]), Rattle::new(0.1)).unwrap();
    let told = simulation.run(1).unwrap_err().to_string();
    assert!(told.contains("MagneticField"), "{told}");
}

/// Steps far longer than a turn, on a sphere: back and forth to rounding, without work.
#[test]
fn long_steps_on_a_sphere_are_reversible() {
    use rattle::surfaces::Sphere;
    for strength in [1.0, 10.0, 100.0, 1e4] {
        let ball = Scene::on(Sphere { r: 1.0 }).with(MagneticField::new([0.3 * strength, 0.2, strength]));
        let start = State::at([0.0, 0.0, 1.0]).moving([1.0, 0.0, 0.0]);
        let there = ball.simulate(start, Rattle::new(0.05)).unwrap();
        let mut there = there.check_reversal(1e-12).unwrap();
        there.run(200).unwrap();
        let off = there.kinetic_energy() - 0.5;
        assert!(off.abs() < 1e-12, "{strength}: {off:e}");
    }
}

/// A heavy body, or a fast one, that nothing joins to others takes no digit from what a magnetic field does to these.
#[test]
fn light_bodies_beside_a_heavy_one() {
    let end = |mass: f64, far: f64| {
        let scene = Scene::points(3)
            .link(rattle::links::Rod { length: 1.0 }, [[0, 1]])
            .masses([1.0, 1.0, mass])
            .with(MagneticField::new([0.0, 0.0, 2.0]));
        let start = State::of([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [9.0, 0.0, 0.0]]);
        let start = start.with_momenta([[0.3, 0.5, 0.2], [0.3, -0.4, 0.1], [0.0, 0.0, far]]); // along the field
        let mut run = scene.simulate(start, Rattle::new(0.1)).unwrap();
        run.run(50).unwrap();
        run.positions().take(2).collect::<Vec<_>>()
    };
    for (mass, far) in [(1e15, 1e15), (1e-15, 1.0)] {
        let both = end(mass, 0.0).into_iter().zip(end(mass, far));
        let off = both.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(off < 1e-13, "{mass:e}: {off:e}");
    }
    // Six in a chain, in a field that turns them by a radian in half of a step, which takes many rounds.
    let chain = |far: f64| {
        let scene = Scene::points(7)
            .link(rattle::links::Rod { length: 1.0 }, (0..5).map(|i| [i, i + 1]))
            .masses([1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1e15])
            .with(MagneticField::new([0.0, 0.0, 20.0]));
        let places = (0..6).map(|i| [f64::from(i), 0.0, 0.0]).chain([[0.0, 9.0, 0.0]]);
        let momenta = (0..6).map(|i| [0.3, 0.1 * f64::from(i) - 0.2, 0.1]).chain([[0.0, 0.0, far]]);
        let mut run = scene.simulate(State::of(places).with_momenta(momenta), Rattle::new(0.1)).unwrap();
        run.run(5).unwrap();
        run.positions().take(6).collect::<Vec<_>>()
    };
    let off = chain(0.0).iter().zip(chain(1e15)).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    assert!(off < 1e-11, "{off:e}");
}
