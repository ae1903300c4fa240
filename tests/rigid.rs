//! Rigid bodies in three formulations: nine equations, six, and none.

use crate::common::*;
use rattle::bodies::One;
use rattle::links::RotationMatrix;
use rattle::nalgebra::{Matrix3, SVector, Vector3};
use rattle::prelude::*;
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
