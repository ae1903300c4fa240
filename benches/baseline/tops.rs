//! Heavy tops side by side by the library, as `tops.c` has them by hand.

use crate::conversation::Run;
use crate::linked::Weight;
use rattle::nalgebra::{Matrix3, Vector3};
use rattle::prelude::*;
use rattle::system::System;

/// Side by side, with sums compensated, or one after the other as simulations.
pub(crate) const TOPS: &str = "tops";
pub(crate) const SUMS: &str = "tops_compensated";
pub(crate) const APART: &str = "tops_simulations";

const MOMENTS: [f64; 3] = [1.0, 1.0, 0.4];

pub(crate) fn tops(row: &str, n: usize) -> Option<Box<dyn Run>> {
    let (sin, cos) = (0.5, 0.75_f64.sqrt());
    let attitude = Matrix3::new(1.0, 0.0, 0.0, 0.0, cos, -sin, 0.0, sin, cos);
    let spin = |i: usize| 2.4 + 4.8 * i as f64 / n as f64;
    let starts = (0..n).map(|i| Rigid::start(&attitude, &Vector3::new(0.0, 0.0, spin(i))));
    let (scene, method) = (Scene::rigid(Rigid::new(MOMENTS)).with(Weight { mgl: 1.0 }), Rattle::new(0.02));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let together = |ensemble: Result<Ensemble<9>, _>| -> Option<Box<dyn Run>> {
        Some(Box::new(Together { pool, ensemble: ensemble.expect("starts") }))
    };
    match row {
        TOPS => together(scene.ensemble(starts, method)),
        SUMS => together(scene.ensemble_in(Compensated, starts, method)),
        APART => {
            let simulations = starts.map(|start| scene.simulate(start, method).expect("a start"));
            Some(Box::new(Apart(simulations.collect())))
        }
        _ => None,
    }
}

struct Together {
    pool: rayon::ThreadPool,
    ensemble: Ensemble<9>,
}

struct Apart<Y: System<f64, 9>>(Vec<Simulation<Y, Rattle, 9>>);

/// Attitude and momentum in the body's frame.
fn place(state: &State<9>) -> (Matrix3<f64>, [f64; 3]) {
    let (q, m) = (state.positions().next(), state.momenta().next());
    let (q, m) = (q.expect("a body"), m.expect("a body"));
    (Rigid::attitude(&q.into()), [m[0], m[1], m[2]])
}

/// Mean energy, mean kinetic energy, and the largest entry of QᵀQ − 1.
fn of_all(states: impl Iterator<Item = State<9>>) -> [f64; 3] {
    let (mut energy, mut kinetic, mut worst, mut number) = (0.0, 0.0, 0.0_f64, 0.0);
    for state in states {
        let (q, m) = place(&state);
        let own: f64 = (0..3).map(|i| 0.5 * m[i] * m[i] / MOMENTS[i]).sum();
        (energy, kinetic, number) = (energy + own + q[(2, 2)], kinetic + own, number + 1.0);
        worst = worst.max((q.transpose() * q - Matrix3::identity()).amax());
    }
    [energy / number, kinetic / number, worst]
}

macro_rules! run_of_all {
    ($($generics:tt)*) => {
        $($generics)* {
            fn advance(&mut self, steps: u64) {
                self.go(steps);
            }
            fn body(&self, i: usize) -> ([f64; 3], [f64; 3]) {
                let (q, m) = place(&self.state(i));
                (q.column(2).into(), m)
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
run_of_all!(impl Run for Together);
run_of_all!(impl<Y: System<f64, 9>> Run for Apart<Y>);

impl Together {
    fn go(&mut self, steps: u64) {
        let Self { pool, ensemble } = self;
        pool.install(|| ensemble.run(steps));
        assert!(self.ensemble.failures().next().is_none(), "steps within reach");
    }
    fn state(&self, i: usize) -> State<9> {
        self.ensemble.state(i)
    }
    fn states(&self) -> impl Iterator<Item = State<9>> + '_ {
        self.ensemble.states()
    }
}

impl<Y: System<f64, 9>> Apart<Y> {
    fn go(&mut self, steps: u64) {
        self.0.iter_mut().for_each(|simulation| simulation.run(steps).expect("steps within reach"));
    }
    fn state(&self, i: usize) -> State<9> {
        self.0[i].state()
    }
    fn states(&self) -> impl Iterator<Item = State<9>> + '_ {
        self.0.iter().map(Simulation::state)
    }
}
