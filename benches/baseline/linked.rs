//! Linked bodies by the library, as `linked.c` has them by hand: a double pendulum, a chain, a heavy top.

use crate::conversation::Run;
use rattle::links::planar::Rod;
use rattle::nalgebra::{Matrix3, Vector3};
use rattle::potentials::planar::Gravity;
use rattle::prelude::*;
use rattle::system::System;

potential! {
    /// The weight of a top whose centre of mass lies on its third axis; z points up in space.
    pub(crate) struct Weight { mgl }
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

/// Double pendulums, as `pendulums.c` has them: so many [side by side](PENDULUMS), with sums [compensated](SUMS), or
/// one after the other [as simulations](APART).
pub(crate) const PENDULUMS: &str = "pendulums";
pub(crate) const SUMS: &str = "pendulums_compensated";
pub(crate) const APART: &str = "pendulums_simulations";

pub(crate) fn pendulums(row: &str, n: usize) -> Option<Box<dyn Run>> {
    let scene = Scene::points(3)
        .link(Rod { length: 1.0 }, [[0, 1], [1, 2]])
        .pin(0, [0.0, 0.0])
        .with(Gravity { g: 1.0 });
    let starts = (0..n).map(|i| {
        let (sin, cos) = (0.5 + 1.5 * i as f64 / n as f64).sin_cos();
        State::of([[0.0, 0.0], [sin, -cos], [2.0 * sin, -2.0 * cos]])
    });
    let method = Rattle::new(0.005);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    match row {
        PENDULUMS => {
            Some(Box::new(Pendulums { pool, ensemble: scene.ensemble(starts, method).expect("starts") }))
        }
        SUMS => {
            let ensemble = scene.ensemble_in(Compensated, starts, method).expect("starts");
            Some(Box::new(Pendulums { pool, ensemble }))
        }
        APART => {
            let simulations = starts.map(|start| scene.simulate(start, method).expect("a start"));
            Some(Box::new(ApartPendulums(simulations.collect())))
        }
        _ => None,
    }
}

/// Energies, kinetic energies and residuals of double pendulums: mean, mean and largest.
fn of_all(states: impl Iterator<Item = State<2>>) -> [f64; 3] {
    let (mut energy, mut kinetic, mut worst, mut number) = (0.0, 0.0, 0.0_f64, 0.0);
    for state in states {
        let q = state.positions().collect::<Vec<_>>();
        let own = state.momenta().map(|p| 0.5 * p.norm_squared()).sum::<f64>();
        (energy, kinetic, number) = (energy + own + q[1].y + q[2].y, kinetic + own, number + 1.0);
        worst = worst.max((q[1].norm_squared() - 1.0).abs()).max(((q[2] - q[1]).norm_squared() - 1.0).abs());
    }
    [energy / number, kinetic / number, worst]
}

struct Pendulums {
    pool: rayon::ThreadPool,
    ensemble: Ensemble<2>,
}

struct ApartPendulums<Y: System<f64, 2>>(Vec<Simulation<Y, Rattle, 2>>);

/// The lower body.
fn lower(state: &State<2>) -> ([f64; 3], [f64; 3]) {
    let (q, p) = (state.positions().nth(2), state.momenta().nth(2));
    let (q, p) = (q.expect("three bodies"), p.expect("three bodies"));
    ([q.x, q.y, 0.0], [p.x, p.y, 0.0])
}

macro_rules! run_of_all {
    ($($generics:tt)*) => {
        $($generics)* {
            fn advance(&mut self, steps: u64) {
                self.go(steps);
            }
            fn body(&self, i: usize) -> ([f64; 3], [f64; 3]) {
                lower(&self.state(i))
            }
            fn evaluations(&self) -> [u64; 2] {
                [0; 2]
            }
            fn energy(&self) -> Option<f64> {
                Some(of_all(self.states())[0])
            }
            fn kinetic(&self) -> Option<f64> {
                Some(of_all(self.states())[1])
            }
            fn residual(&self) -> Option<f64> {
                Some(of_all(self.states())[2])
            }
        }
    };
}
run_of_all!(impl Run for Pendulums);
run_of_all!(impl<Y: System<f64, 2>> Run for ApartPendulums<Y>);

impl Pendulums {
    fn go(&mut self, steps: u64) {
        let Self { pool, ensemble } = self;
        pool.install(|| ensemble.run(steps));
        assert!(self.ensemble.failures().next().is_none(), "steps within reach");
    }
    fn state(&self, i: usize) -> State<2> {
        self.ensemble.state(i)
    }
    fn states(&self) -> impl Iterator<Item = State<2>> + '_ {
        self.ensemble.states()
    }
}

impl<Y: System<f64, 2>> ApartPendulums<Y> {
    fn go(&mut self, steps: u64) {
        self.0.iter_mut().for_each(|simulation| simulation.run(steps).expect("steps within reach"));
    }
    fn state(&self, i: usize) -> State<2> {
        self.0[i].state()
    }
    fn states(&self) -> impl Iterator<Item = State<2>> + '_ {
        self.0.iter().map(Simulation::state)
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
