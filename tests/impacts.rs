//! Impacts where constraints move, or act along other directions than their gradients: the gap parts with e times the
//! speed at which it closed, and the energy changes by the work that is booked.

use rattle::Error;
use rattle::effect::{HardSpheres, Stop};
use rattle::error::StepFailure;
use rattle::prelude::*;

constraint! {
    /// A piston on a line.
    struct Piston { u }
    |x, t| x - u * t
}

constraint! {
    /// A rod that rises, at 45°.
    struct Rising { w }
    |x, y, t| x + y - w * t
}

constraint! {
    /// A table whose height is twice x.
    struct Twice {}
    |x, _y, z| z - 2 * x
}

constraint! {
    /// To the left of x = 1.
    struct Wall {}
    |x, _y| 1 - x
}

constraint! {
    /// On this side of a slanted wall.
    struct Slanted {}
    |x, y, _z| 1 - x - y
}

constraint! {
    /// Below a ceiling.
    struct Ceiling {}
    |_x, _y, z| 1 - z
}

fn near(found: &[f64], exact: &[f64]) {
    let off = found.iter().zip(exact).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
    assert!(off < 1e-13, "{found:?} for {exact:?}");
}

/// A ball that meets a piston of speed u with the velocity v leaves it with u + e (u − v), and no recoil.
#[test]
fn a_piston_drives_a_ball() {
    for (u, v, e, h) in
        [(0.3, -1.0, 1.0, 0.1), (1.0, 0.0, 1.0, 0.03), (-0.2, -1.5, 0.5, 0.1), (0.4, 0.1, 0.0, 0.07)]
    {
        let scene = Scene::points::<1>(2).link_moving(Piston { u }, [[0]]);
        let start = State::of([[0.0], [1.0]]).with_momenta([[u], [v]]);
        let balls = HardSpheres::new(0.5).restitution(e);
        let mut simulation = scene.simulate(start, Rattle::new(h)).unwrap().collide(balls).unwrap();
        simulation.run((0.5 / (u - v) / h) as u64 + 3).unwrap();
        let (after, state) = (u + e * (u - v), simulation.state());
        let momenta: Vec<f64> = state.momenta().map(|p| p.x).collect();
        near(&momenta, &[u, after]);
        near(&[simulation.work(), simulation.energy_error()], &[0.5 * (after * after - v * v), 0.0]);
    }
}

/// What moves along the rod is turned so that x̊ is.
#[test]
fn a_bead_on_a_rod_that_rises_meets_a_wall() {
    for (w, s, e) in [(1.0, 1.0, 1.0), (0.1, 1.0, 1.0), (-0.5, 1.2, 1.0), (1.0, 0.0, 1.0), (1.0, 1.0, 0.5)] {
        let part = s * 0.5_f64.sqrt();
        let v = [0.5 * w + part, 0.5 * w - part];
        let scene = Scene::point().link_moving(Rising { w }, [[0]]);
        let start = State::at([0.0, 0.0]).moving(v);
        let mut simulation = scene
            .simulate(start, Rattle::new(0.01))
            .unwrap()
            .collide(Stop::above(Wall {}).over([[0]]).restitution(e))
            .unwrap();
        simulation.run((100.0 / v[0]) as u64 + 20).unwrap();
        let (x, y) = (-e * v[0], w + e * v[0]);
        let p = simulation.momentum();
        near(&[p.x, p.y], &[x, y]);
        let work = 0.5 * (x * x + y * y - v[0] * v[0] - v[1] * v[1]);
        near(&[simulation.work(), simulation.energy_error()], &[work, 0.0]);
        assert_eq!(simulation.events(), 1);
    }
}

/// The height follows x without holding it: in x and y the body is free.
#[test]
fn who_is_led_along_meets_a_wall_as_if_free() {
    for (e, after) in [(1.0, [0.0, -1.0, 0.0]), (0.0, [0.5, -0.5, 1.0]), (0.5, [0.25, -0.75, 0.5])] {
        let scene = Scene::point().link_acting(Twice {}, [[0]], [[false, false, true]]);
        let start = State::at([0.0, 0.0, 0.0]).moving([1.0, 0.0, 2.0]);
        let mut simulation = scene
            .simulate(start, Rattle::new(0.3))
            .unwrap()
            .collide(Stop::above(Slanted {}).over([[0]]).restitution(e))
            .unwrap();
        simulation.run(6).unwrap();
        let p = simulation.momentum();
        near(&[p.x, p.y, p.z], &after);
        let work = 0.5 * (after.iter().map(|v| v * v).sum::<f64>() - 5.0);
        near(&[simulation.work(), simulation.energy_error()], &[work, 0.0]);
    }
}

/// A ceiling cannot keep what is led there.
#[test]
fn who_cannot_part_is_told() {
    let scene = Scene::point().link_acting(Twice {}, [[0]], [[false, false, true]]);
    let start = State::at([0.0, 0.0, 0.0]).moving([1.0, 0.0, 2.0]);
    let mut simulation =
        scene.simulate(start, Rattle::new(0.3)).unwrap().collide(Stop::above(Ceiling {})).unwrap();
    let error = simulation.run(6).unwrap_err();
    assert!(matches!(&error, Error::Step { cause: StepFailure::NoWayApart { .. }, step: 2, .. }), "{error}");
}
