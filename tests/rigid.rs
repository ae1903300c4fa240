//! Rigid bodies in three formulations: nine equations, six, and none.

use crate::common::*;
use rattle::bodies::One;
use rattle::effect::{Acting, Effect, Moment};
use rattle::error::{EffectMistake, Error, MethodFailure, StartFailure, StepFailure};
use rattle::lanes::Lane;
use rattle::links::RotationMatrix;
use rattle::nalgebra::{Matrix3, Rotation3, SVector, Vector3};
use rattle::prelude::*;
use rattle::real::Real;
use rattle::system::System;

constraint! {
    /// QᵀQ = 1, the mixed equations twice.
    struct OrthogonalTwice {}
    |m: [[f64; 3]; 3]| for i in 0..3, j in 0..3 { sum(k in 0..3, m[k][i] * m[k][j]) - delta(i, j) }
}

potential! {
    /// A top's weight: its centre of mass lies on its third axis.
    struct Top { weight }
    |q: [[f64; 3]; 3]| weight * q[2][2]
}

const MOMENTS: [f64; 3] = [0.6, 0.8, 1.0];

fn angular_momentum() -> Vector3<f64> {
    Vector3::new(1.8, 0.4, -0.9)
}

fn masses(body: Rigid) -> [f64; 9] {
    let d = body.column_masses();
    std::array::from_fn(|k| d[k % 3])
}

#[test]
fn a_free_body_keeps_energy_and_angular_momentum() {
    let body = Rigid::new(MOMENTS);
    let mut simulation = Scene::rigid(body)
        .simulate(Rigid::start(&Matrix3::identity(), &angular_momentum()), Rattle::new(0.05))
        .unwrap();
    let (mut energy, mut turning) = (0.0_f64, 0.0_f64);
    let in_space = |q: [f64; 9], p: SVector<f64, 9>| Rigid::attitude(&q) * Vector3::new(p[0], p[1], p[2]);
    let before = angular_momentum();
    simulation
        .run_with(20_000, |now| {
            let change = in_space(now.position().into(), now.momentum()) - before;
            turning = turning.max(change.amax());
            energy = energy.max(now.energy_error().abs());
        })
        .unwrap();
    println!("{energy:e} {turning:e}");
    assert!(energy < 1e-13 && turning < 1e-13, "energy {energy:e}, angular momentum {turning:e}");
}

/// Attitude and angular momentum after so many steps, with momenta read by `turning`.
fn last<Y: System<f64, 9, Count = One>>(
    mut simulation: Simulation<Y, Rattle, 9>,
    n: u64,
    turning: impl Fn(&Matrix3<f64>, &[f64; 9]) -> Vector3<f64>,
) -> [f64; 12] {
    simulation.run(n).unwrap();
    let (q, p): ([f64; 9], [f64; 9]) = (simulation.position().into(), simulation.momentum().into());
    let m = turning(&Rigid::attitude(&q), &p);
    std::array::from_fn(|i| if i < 9 { q[i] } else { m[i - 9] })
}

#[test]
fn three_formulations_are_one_motion() {
    let (body, upright) = (Rigid::new(MOMENTS), Matrix3::identity());
    let turning = Rigid::start(&upright, &angular_momentum());
    let moving =
        State::at(Rigid::coordinates(&upright)).moving(body.matrix_momenta(&upright, &angular_momentum()));
    for weight in [0.0, 0.7] {
        let method = Rattle::new(0.05);
        let reduced = Scene::rigid(body).with(Top { weight }).simulate(turning.clone(), method).unwrap();
        let reduced = last(reduced, 200, |_, p| Vector3::new(p[0], p[1], p[2]));
        let six = Scene::on(RotationMatrix {}).mass(masses(body)).with(Top { weight });
        let nine = Scene::on(OrthogonalTwice {}).mass(masses(body)).with(Top { weight });
        let six = last(six.simulate(moving.clone(), method).unwrap(), 200, Rigid::angular_momentum_of_matrix);
        let nine =
            last(nine.simulate(moving.clone(), method).unwrap(), 200, Rigid::angular_momentum_of_matrix);
        println!("{:e} {:e}", distance(six, reduced), distance(nine, six));
        assert!(distance(six, reduced) < 1e-12, "{:e}", distance(six, reduced));
        assert!(distance(nine, six) < 1e-12, "{:e}", distance(nine, six));
    }
}

/// The nine entries of a matrix that is a rotation but for 5 % of its own, times a number.
fn nearly_a_rotation(size: f64) -> State<9> {
    let turn = Rotation3::from_euler_angles(0.3, 0.5, -1.0);
    let skewed = Matrix3::new(1.0, 0.1, 0.0, 0.0, 1.0, -0.1, 0.05, 0.0, 1.1) * turn.matrix();
    State::at(Rigid::coordinates(&(skewed * size)))
}

/// What is straightened is the direction of the axes: squares of entries may be beyond the numbers.
#[test]
fn attitudes_of_any_size_are_straightened() {
    let body = Scene::rigid(Rigid::new(MOMENTS));
    let attitude = |size: f64| body.project(&nearly_a_rotation(size)).unwrap().positions().next().unwrap();
    for size in [1e-300, 1e-160, 1e-100, 1e100, 1e154, 1e200, 1e307] {
        let off = (attitude(size) - attitude(1.0)).amax();
        assert!(off < 1e-15, "{size:e}: {off:e}");
    }
    let mirrored = nearly_a_rotation(-1e200);
    for state in [mirrored, State::at([0.0; 9]), State::at([1e200; 9]), State::at([1e-200; 9])] {
        let error = body.project(&state).unwrap_err();
        let Error::Start { body: 0, cause: StartFailure::NoAttitude { determinant, deviation } } = error
        else {
            panic!("{error}");
        };
        assert!(!determinant.is_nan() && deviation > 0.9, "{determinant} {deviation}");
    }
}

/// `project` makes no angular momentum of the first three entries of another momentum.
#[test]
fn momenta_of_a_matrix_are_refused() {
    let (body, upright) = (Rigid::new(MOMENTS), Matrix3::identity());
    let moving =
        State::at(Rigid::coordinates(&upright)).moving(body.matrix_momenta(&upright, &angular_momentum()));
    let scene = Scene::rigid(body);
    for error in
        [scene.project(&moving).unwrap_err(), scene.simulate(moving.clone(), Rattle::new(0.1)).unwrap_err()]
    {
        let cause = StartFailure::NoAngularMomentum;
        assert!(error.to_string().contains("angular_momentum_of_matrix"), "{error}");
        assert_eq!(error, Error::Start { body: 0, cause });
    }
}

force! {
    /// A pull on the last entry of the attitude, as if a force on a rigid body were one on its coordinates.
    struct Pull { f }
    |_q: [f64; 9]| [0, 0, 0, 0, 0, 0, 0, 0, -f]
}

force! {
    /// A torque about the third axis, and what is none at the identity alone.
    struct Stray { torque, f }
    |q: [f64; 9], v: [f64; 9]| [0, 0, torque - v[2], f * q[1], 0, 0, f * q[5], 0, -v[8]]
}

/// The first three components of a force are a torque. What else there is at the start is refused, and moves nothing
/// later: the motion is that of the torque alone, and its states are starts.
#[test]
fn torques_have_three_components() {
    let body = Scene::rigid(Rigid::new(MOMENTS));
    let start = || Rigid::start(&Matrix3::identity(), &angular_momentum());
    let pulled = body.with(Pull { f: 0.7 });
    let alone = pulled.simulate(start(), Rattle::new(0.05)).unwrap_err();
    assert!(alone.to_string().contains("`Pull`: on body 0 it is [0.0, 0.0, 0.0, 0.0,"), "{alone}");
    let several = pulled.ensemble(vec![start(); 2], Rattle::new(0.05)).unwrap_err();
    assert_eq!(several.to_string(), format!("trajectory 0: {alone}"));
    let mistake =
        EffectMistake::NoTorque { body: 0, force: vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -0.7] };
    assert_eq!(alone, Error::Effect { effect: "Pull", mistake });
    assert!(body.with(Pull { f: f64::INFINITY }).simulate(start(), Rattle::new(0.05)).is_err());
    assert!(body.with(Pull { f: 0.0 }).simulate(start(), Rattle::new(0.05)).is_ok());

    let end = |f: f64| {
        let scene = body.with(Stray { torque: 0.3, f });
        let mut simulation = scene.simulate(start(), Rattle::new(0.05)).unwrap();
        simulation.run(40).unwrap();
        assert_eq!(simulation.momentum().as_slice()[3..], [0.0; 6]);
        let again = scene.simulate(simulation.state(), Rattle::new(0.05));
        assert_eq!(again.is_err(), f != 0.0); // it is no torque there
        assert!(body.simulate(simulation.state(), Rattle::new(0.05)).is_ok());
        [simulation.position(), simulation.momentum()]
    };
    let (stray, torque) = (end(0.8), end(0.0));
    let off = [0, 1].map(|i| (stray[i] - torque[i]).amax());
    assert!(off.iter().all(|off| *off < 1e-14), "{off:?}");
}

potential! {
    /// A pendulum's weight, which rests where the third axis points up.
    struct Hang { k }
    |q: [[f64; 3]; 3]| k * (1 - q[2][2])
}

/// A torque about the first axis that has no potential.
#[derive(Debug, Clone, Copy)]
struct Motor(f64);

/// The kind of effect that a motor is.
struct Drives;

impl Effect<9, Drives> for Motor {
    type Acting<T: Real> = Self;
    fn acting<T: Real>(&self) -> Self {
        *self
    }
    type Swept<S: Lane, const L: usize> = [Self; L];
}

impl<T: Real> Acting<T, 9> for Motor {
    type Room = ();
    fn room(&self, _: usize) {}
    fn add_forces(&self, at: Moment<'_, T, 9>, (): &mut (), forces: &mut [[T; 9]]) {
        for (q, force) in at.positions.iter().zip(forces) {
            for row in [0, 3, 6] {
                // Half of the torque by what the second axis is pushed, half by the third.
                force[row + 1] = force[row + 1] + T::from_f64(0.5 * self.0) * q[row + 2];
                force[row + 2] = force[row + 2] - T::from_f64(0.5 * self.0) * q[row + 1];
            }
        }
    }
    fn energy(&self, _: Moment<'_, T, 9>) -> T {
        T::from_f64(0.0)
    }
}

/// What torques give is energy: a body that begins to swing where its potential is rounded to more than it moves by, or
/// that is turned by what has no potential, is no jump of the energy.
#[test]
fn what_torques_give_is_no_jump() {
    fn swings(tilt: f64, h: f64) {
        let scene = Scene::rigid(Rigid::new([1.0; 3])).with(Hang { k: 1.0 });
        let attitude = Rotation3::from_axis_angle(&Vector3::x_axis(), tilt);
        let start = || Rigid::start(attitude.matrix(), &Vector3::zeros());
        let check = |method: &str, m: SVector<f64, 9>| {
            let off = (m[0] + tilt * (4.0 * h).sin()).abs();
            assert!(off < 1e-3 * tilt * h, "{method} of {h} from {tilt:e}: {m}");
        };
        let mut simulation = scene.simulate(start(), Dop853::new(h)).unwrap();
        simulation.run(4).unwrap();
        check("Dop853", simulation.momentum());
        let mut simulation = scene.simulate(start(), Taylor::new(12, h)).unwrap();
        simulation.run(4).unwrap();
        check("Taylor", simulation.momentum());
    }
    for (tilt, h) in [(1e-8, 0.05), (1e-6, 5e-3), (1e-5, 1e-3), (1e-4, 1e-4)] {
        swings(tilt, h);
    }
    let motor = Scene::rigid(Rigid::new(MOMENTS)).with(Motor(0.5));
    let start = Rigid::start(&Matrix3::identity(), &Vector3::new(0.01, 0.0, 0.0));
    let mut driven = motor.simulate(start, Dop853::new(0.1)).unwrap();
    driven.run(10).unwrap();
    assert!((driven.momentum()[0] - 0.51).abs() < 1e-12, "{}", driven.momentum());
}

potential! {
    /// A ridge where the third axis is level.
    struct Rise { height, width }
    |q: [[f64; 3]; 3]| height * exp(-(q[2][2] / width)^2)
}

/// A jump of the energy is told of the body that has most of it.
#[test]
fn jumps_are_told_of_the_fastest() {
    let scene = Scene::rigid(Rigid::new(MOMENTS)).bodies(2).with(Rise { height: 1.0, width: 0.1 });
    let flank = Rotation3::from_axis_angle(&Vector3::x_axis(), 1.5);
    let slow = (Matrix3::identity(), Vector3::new(0.0, 0.02, 0.03));
    let start = Rigid::starts([slow, (*flank.matrix(), Vector3::zeros())]);
    let error = scene.simulate(start, Dop853::new(0.45)).unwrap().step().unwrap_err();
    let Error::Step { body, cause: StepFailure::Method(MethodFailure::EnergyJump { .. }), .. } = error else {
        panic!("{error}");
    };
    assert_eq!(body, 1);
}
