//! Drag of free bodies, against exact motions: whatever the masses, forwards and backwards.

use crate::common::order;
use rattle::Mass;
use rattle::effect::{Flow, LinearDrag, QuadraticDrag};
use rattle::nalgebra::Vector2 as Vector;
use rattle::prelude::*;
use rattle::surfaces::Sphere;

/// Momenta of free bodies have formulas, also for masses that are matrices: to rounding.
#[test]
fn drag_of_free_bodies_is_exact() {
    let masses = [2.0, 0.5];
    let free = Scene::points::<2>(2).masses(masses).with(LinearDrag::along([0.5, 2.0]).times([1.0, 0.1]));
    let start = State::of([[0.0; 2]; 2]).moving([1.0, 1.0]);
    let mut simulation = free.simulate(start, Rattle::new(0.25)).unwrap();
    simulation.run(8).unwrap();
    for (body, p) in simulation.momenta().enumerate() {
        let factor = [1.0, 0.1][body] * 2.0 / masses[body];
        let exact = [(-0.5 * factor).exp(), (-2.0 * factor).exp()];
        assert!((p.x - exact[0]).abs() < 2e-15 && (p.y - exact[1]).abs() < 2e-15, "{p}");
    }
    // M = [[2, 1], [1, 2]] has the axes (1, 1) and (1, −1) with masses 3 and 1.
    let mass = rattle::nalgebra::matrix![2.0, 1.0; 1.0, 2.0];
    for h in [0.25, 10.0] {
        let heavy = Scene::point().mass(mass).with(LinearDrag::new(0.6));
        let mut simulation = heavy.simulate(State::at([0.0; 2]).moving([1.0, 0.0]), Rattle::new(h)).unwrap();
        let steps = 4;
        simulation.run(steps).unwrap();
        let time = steps as f64 * h;
        let (slow, fast) = (0.5 * (-0.2 * time).exp(), 0.5 * (-0.6 * time).exp());
        let off = (simulation.momentum() - Vector::new(slow + fast, slow - fast)).norm();
        assert!(off < 2e-15, "h = {h}: {off:e}"); // roundings of some 8 changes
    }
    let quadratic = Scene::point().mass(4.0).with(QuadraticDrag { coefficient: 2.0 });
    let start = State::at([0.0; 3]).moving([4.0, 0.0, 0.0]);
    let mut simulation = quadratic.simulate(start, Rattle::new(0.1)).unwrap();
    simulation.run(100).unwrap();
    assert!((simulation.velocity().x - 1.0 / 6.0).abs() < 1e-15, "v = 1/(1 + t/2)");
}

/// Masses that are matrices, or one for each coordinate: a step back undoes a step, to some roundings of momenta of
/// size 1.
#[test]
fn drag_is_undone_whatever_the_masses() {
    fn check(mass: impl Into<Mass<2>>, drag: impl Flow<2>) {
        let scene = Scene::point().mass(mass).with(drag);
        let start = State::at([0.0; 2]).moving([1.0, 1.5]);
        let simulation = scene.simulate(start, Rattle::new(0.1)).unwrap();
        simulation.check_reversal(1e-14).unwrap().run(30).unwrap();
    }
    let matrix = rattle::nalgebra::matrix![2.0, 1.0; 1.0, 2.0];
    check(matrix, LinearDrag::new(0.6));
    check(matrix, LinearDrag::along([0.6, 0.0]));
    check(matrix, QuadraticDrag { coefficient: 2.0 });
    check([1.0, 4.0], QuadraticDrag { coefficient: 2.0 });
}

/// Drag by the square of masses that are matrices: of second order, as for the number that all masses are near to, and
/// it stops a body without turning it round, however strong it is.
#[test]
fn drag_by_the_square_along_axes() {
    let mass = rattle::nalgebra::matrix![2.0, 0.5; 0.5, 1.0];
    let after = |mass: Mass<2>, c: f64, h: f64, time: f64| {
        let scene = Scene::point().mass(mass).with(QuadraticDrag { coefficient: c });
        let start = State::at([0.0; 2]).moving([1.0, -0.7]);
        let mut simulation = scene.simulate(start, Rattle::new(h)).unwrap();
        simulation.run((time / h).round() as u64).unwrap();
        simulation.momentum()
    };
    // ṗ = −c|v|v, by the classical Runge–Kutta method in 10⁴ steps: to 1e-15.
    let over = mass.try_inverse().unwrap();
    let rate = |p: Vector<f64>| -2.0 * (over * p).norm() * (over * p);
    let (mut p, h) = (Vector::new(1.0, -0.7), 1e-4);
    for _ in 0..10_000 {
        let first = rate(p);
        let second = rate(p + 0.5 * h * first);
        let third = rate(p + 0.5 * h * second);
        p += h / 6.0 * (first + 2.0 * second + 2.0 * third + rate(p + h * third));
    }
    let order = order(&[0.2, 0.1, 0.05].map(|h| (after(mass.into(), 2.0, h, 1.0) - p).norm()));
    assert!((1.8..2.3).contains(&order), "{order}");
    // Where masses are the same but for 1e-9 only as much differs: p/(1 + hc|v|).
    let near = after([1.0, 1.0 + 1e-9].into(), 2.0, 0.1, 1.0);
    let start: Vector<f64> = Vector::new(1.0, -0.7);
    assert!((near - start / (1.0 + 2.0 * start.norm())).norm() < 2e-9, "{near}");
    for c in [1e2, 1e4, 1e8] {
        for mass in [[1.0, 4.0], [1.0, 1e6]] {
            let p = after(mass.into(), c, 0.1, 0.1);
            assert!(p.x >= 0.0 && p.x < 1.0 && p.y < 0.0 && p.y > -0.7, "{c}, {mass:?}: {p}");
        }
    }
}

/// Backwards, drag by the square comes from infinite velocities at t = −m/(c v): steps up to there are exact, others
/// fail, where they ended at velocities that are turned around.
#[test]
fn drag_comes_from_no_farther_than_infinity() {
    let mass = rattle::nalgebra::matrix![2.0, 0.5; 0.5, 1.0];
    for c in [5.0, 9.9, 10.1, 15.0, 25.0, 60.0] {
        let scene = Scene::point().with(QuadraticDrag { coefficient: c });
        let mut alone = scene.simulate(State::at([0.0]).moving([1.0]), Rattle::new(-0.1)).unwrap();
        let told = alone.run(1);
        assert_eq!(told.is_ok(), c < 10.0, "{c}: {}", alone.momentum());
        match told {
            Ok(()) => assert!((alone.momentum().x * (1.0 - 0.1 * c) - 1.0).abs() < 1e-12, "{c}"),
            Err(told) => assert!(told.to_string().contains("QuadraticDrag"), "{told}"),
        }
        let ball = Scene::on(Sphere { r: 1.0 }).with(QuadraticDrag { coefficient: c });
        let start = State::at([0.0, 0.0, 1.0]).moving([1.0, 0.0, 0.0]);
        let mut lanes = ball.ensemble(vec![start; 20], Rattle::new(-0.1)).unwrap();
        lanes.run(1);
        assert_eq!(lanes.failures().count() == 0, c < 10.0, "{c}");
        if !(9.0..20.0).contains(&c) {
            let heavy = Scene::point().mass(mass).with(QuadraticDrag { coefficient: 2.0 * c });
            let start = State::at([0.0; 2]).moving([1.0, 0.0]);
            let mut heavy = heavy.simulate(start, Rattle::new(-0.1)).unwrap();
            assert_eq!(heavy.run(1).is_ok(), c < 9.0, "{c}: {}", heavy.momentum());
        }
    }
}

/// Of three masses steps of any strength end, turn no component round, and leave less the stronger drag is: here also
/// where Newton's method goes to and fro between two places.
#[test]
fn strong_drag_of_three_masses_ends() {
    for (mass, p, most) in [
        ([1.0, 12.0, 2000.0], [1.0, 2.0, 0.2], 3800.0),
        ([1.0, 10.0, 1000.0], [1.0, 3.0, 0.02], 28_000.0),
        ([1.0, 20.0, 5000.0], [0.2, 1.0, 0.1], 6500.0),
    ] {
        let mut before = p;
        for share in [1e-6, 1e-4, 1e-3, 1e-2, 0.03, 0.1, 0.2, 0.3, 0.5, 0.7, 0.8, 0.9, 1.0, 10.0, 1e4] {
            // A half step of 1, where the free body then is does not matter.
            let scene = Scene::point().mass(mass).with(QuadraticDrag { coefficient: share * most });
            let mut run = scene.simulate(State::at([0.0; 3]).moving(p), Rattle::new(2.0)).unwrap();
            run.run(1).unwrap_or_else(|error| panic!("{mass:?}, {share}: {error}"));
            let after: [f64; 3] = run.momentum().into();
            for i in 0..3 {
                let is_less = after[i] < before[i] || after[i] == 0.0; // of e^-τ/m nothing may be left
                assert!(after[i] >= 0.0 && is_less, "{mass:?}, {share}: {after:?}, {before:?}");
            }
            before = after;
        }
    }
}

/// A body that moves along one axis of its masses goes as one whose mass is a number, back in time too, however light
/// it is along others.
#[test]
fn drag_along_one_axis_is_that_of_a_number() {
    for (light, c) in [(1e-3, 0.3), (1e-4, 0.05), (1e-6, 0.001), (1e-2, 0.98)] {
        let scene = Scene::point().mass([1.0, light]).with(QuadraticDrag { coefficient: c });
        let start = State::at([0.0; 2]).moving([1.0, 0.0]);
        let mut run = scene.simulate(start, Rattle::new(-1.0)).unwrap();
        run.run(1).unwrap();
        let expected = 1.0 / (1.0 - c); // of two halves that are exact
        assert!((run.momentum().x / expected - 1.0).abs() < 1e-12, "{light:e}: {}", run.momentum());
        assert_eq!(run.momentum().y, 0.0);
    }
}
