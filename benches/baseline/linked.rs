//! Linked bodies by the library, as `linked.c` has them by hand: a double pendulum, a chain, a heavy top.

use crate::conversation::Run;
use rattle::links::planar::Rod;
use rattle::nalgebra::{Matrix3, Vector3};
use rattle::potentials::planar::Gravity;
use rattle::prelude::*;
use rattle::system::System;

potential! {
    /// The weight of a top whose centre of mass lies on its third axis; z points up in space.
    struct Weight { mgl }
    |q: [[f64; 3]; 3]| mgl * q[2][2]
}

/// The task of this name; of a chain with so many links.
pub(crate) fn linked(task: &str, n: usize) -> Option<Box<dyn Run>> {
    match task {
        "double_pendulum" => Some(rods(2, 1.0, 0.005, vec![2])),
        "chain" => {
            let length = 1.0 / n as f64;
            Some(rods(n, length, 0.2 * length, (1..=n).collect()))
        }
        "top" => {
            let (sin, cos) = (0.5, 0.75_f64.sqrt());
            let attitude = Matrix3::new(1.0, 0.0, 0.0, 0.0, cos, -sin, 0.0, sin, cos);
            let start = Rigid::start(&attitude, &Vector3::new(0.0, 0.0, 4.8));
            let scene = Scene::rigid(Rigid::new([1.0, 1.0, 0.4])).with(Weight { mgl: 1.0 });
            Some(Box::new(Top(scene.simulate(start, Rattle::new(0.02)).expect("a rotation"))))
        }
        _ => None,
    }
}

/// Rods in the plane from a pin, horizontal and at rest.
fn rods(n: usize, length: f64, h: f64, told: Vec<usize>) -> Box<dyn Run> {
    let scene = Scene::points(n + 1)
        .link(Rod { length }, (0..n).map(|i| [i, i + 1]))
        .pin(0, [0.0, 0.0])
        .with(Gravity { g: 1.0 });
    let start = State::of((0..=n).map(|i| [i as f64 * length, 0.0]));
    let start = scene.project(&start).expect("a start near by");
    Box::new(Rods { simulation: scene.simulate(start, Rattle::new(h)).expect("a start"), told })
}

struct Rods<Y: System<f64, 2>> {
    simulation: Simulation<Y, Rattle, 2>,
    /// Which bodies are told.
    told: Vec<usize>,
}

impl<Y: System<f64, 2>> Run for Rods<Y> {
    fn advance(&mut self, steps: u64) {
        self.simulation.run(steps).expect("steps within reach");
    }
    fn body(&self, i: usize) -> ([f64; 3], [f64; 3]) {
        let q = self.simulation.positions().nth(self.told[i]).expect("a body of that number");
        let p = self.simulation.momenta().nth(self.told[i]).expect("a body of that number");
        ([q.x, q.y, 0.0], [p.x, p.y, 0.0])
    }
    fn evaluations(&self) -> [u64; 2] {
        [0; 2]
    }
    fn energy(&self) -> Option<f64> {
        Some(self.simulation.energy())
    }
    fn residual(&self) -> Option<f64> {
        Some(self.simulation.constraint_residual())
    }
    fn kinetic(&self) -> Option<f64> {
        Some(self.simulation.momenta().map(|p| 0.5 * p.norm_squared()).sum())
    }
}

struct Top<Y: System<f64, 9>>(Simulation<Y, Rattle, 9>);

impl<Y: System<f64, 9, Count = rattle::bodies::One>> Run for Top<Y> {
    fn advance(&mut self, steps: u64) {
        self.0.run(steps).expect("steps within reach");
    }
    fn body(&self, _: usize) -> ([f64; 3], [f64; 3]) {
        let (q, m) = (self.0.position(), self.0.momentum());
        ([q[2], q[5], q[8]], [m[0], m[1], m[2]])
    }
    fn evaluations(&self) -> [u64; 2] {
        [0; 2]
    }
    fn energy(&self) -> Option<f64> {
        Some(self.0.energy())
    }
    fn residual(&self) -> Option<f64> {
        let q = Rigid::attitude(&self.0.position().into());
        Some((q.transpose() * q - Matrix3::identity()).amax())
    }
    fn kinetic(&self) -> Option<f64> {
        Some(self.0.energy() - self.0.position()[8])
    }
}
