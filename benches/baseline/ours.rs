//! What the library makes of the same tasks. This is the one place where it is plugged in.

use crate::conversation::{H, Run, start};
use rattle::Counted;
use rattle::bodies::{Many, One};
use rattle::counted::Counts;
use rattle::ensemble::{Compensated, Double, Ensemble};
use rattle::potentials::{Gravity, Ricker};
use rattle::prelude::*;
use rattle::surfaces::Lemniscate;
use rattle::system::System;
use std::path::Path;

pub(crate) const SURFACE: Lemniscate = Lemniscate { a: 1.0, r: 1.0 / 6.0 };
const GRAVITY: Gravity = Gravity { g: 1.0 };
const RICKER: Ricker = Ricker { depth: 0.5, radius: 1.0 / 6.0 };

/// The rows that there are.
pub(crate) const ROWS: [&str; 8] =
    [SIMULATION, SCALAR, ENSEMBLE, SWEEP, COMPENSATED, THREADS_2, LOBATTO, LOBATTO_APART];
/// One simulation after the other: compensated sums, to the rounding floor, a first guess from the present state alone.
pub(crate) const SIMULATION: &str = "simulation";
/// Ensembles of one trajectory, one after the other …
pub(crate) const SCALAR: &str = "one_lane";
/// … and the variants of `scalar.c` whose first guess is theirs: as RATTLE is written, and as they write it.
pub(crate) const SCALAR_GUESS: [&str; 2] = ["bend", "bend_verlet"];
/// All side by side.
pub(crate) const ENSEMBLE: &str = "ensemble";
/// The same as a sweep, each with parameters of its own; they are equal, so that all do the same work.
pub(crate) const SWEEP: &str = "ensemble_sweep";
/// The same with positions and momenta as compensated sums.
pub(crate) const COMPENSATED: &str = "ensemble_compensated";
/// The same on two threads.
pub(crate) const THREADS_2: &str = "ensemble_on_2_threads";
/// By Lobatto of five stages, in steps of [`LOBATTO_H`], side by side …
pub(crate) const LOBATTO: &str = "lobatto";
/// … and as simulations, one after the other.
pub(crate) const LOBATTO_APART: &str = "lobatto_simulations";
/// The step that `lobatto.c` takes too.
const LOBATTO_H: f64 = 0.025;

/// The row of this name, with so many trajectories; counted if it is not timed.
pub(crate) fn ours(row: &str, n: usize, counted: bool) -> Option<Box<dyn Run>> {
    if counted {
        let surface = Counted::new(SURFACE);
        let counts = surface.counts();
        of_scene(&Scene::on(surface).with(GRAVITY), row, n, Some(counts))
    } else {
        of_scene(&Scene::on(SURFACE).with(GRAVITY), row, n, None)
    }
}

fn of_scene<C, E>(
    scene: &Scene<C, E, One, 3>,
    row: &str,
    n: usize,
    counts: Option<Counts>,
) -> Option<Box<dyn Run>>
where
    C: Constraint<3, 1> + 'static,
    E: rattle::effect::Effects<3> + 'static,
{
    let starts = (0..n).map(|i| {
        let (q, p) = start(i, n);
        State::at(q).moving(p)
    });
    let threads = if row == THREADS_2 { 2 } else { 1 };
    let ensemble =
        |ensemble: Result<Ensemble<3>, rattle::Error>| Some(vec![ensemble.expect("starts on the surface")]);
    let ensembles = match row {
        SIMULATION => None,
        LOBATTO => ensemble(scene.ensemble(starts.clone(), Lobatto::<5>::new(LOBATTO_H))),
        LOBATTO_APART => return Some(one_by_one(scene, starts, Lobatto::<5>::new(LOBATTO_H), counts)),
        SCALAR => Some(
            starts.clone().map(|start| scene.ensemble([start], Rattle::new(H)).expect("a start")).collect(),
        ),
        ENSEMBLE | THREADS_2 => ensemble(scene.ensemble(starts.clone(), Rattle::new(H))),
        SWEEP => {
            let trajectories = starts.clone().map(|start| (scene, start));
            ensemble(Ensemble::sweep(Double, trajectories, Rattle::new(H)))
        }
        COMPENSATED => ensemble(scene.ensemble_in(Compensated, starts.clone(), Rattle::new(H))),
        _ => return None,
    };
    if let Some(counts) = &counts {
        counts.reset(); // what the starts evaluated
    }
    let Some(ensembles) = ensembles else { return Some(one_by_one(scene, starts, Rattle::new(H), counts)) };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    Some(Box::new(Together { ensembles, pool, threads, counts, evaluations: [0; 2] }))
}

/// Ensembles, one after the other.
struct Together {
    ensembles: Vec<Ensemble<3>>,
    pool: rayon::ThreadPool,
    threads: usize,
    counts: Option<Counts>,
    evaluations: [u64; 2],
}

impl Run for Together {
    fn advance(&mut self, steps: u64) {
        let ensembles = &mut self.ensembles;
        if let Some(counts) = &self.counts {
            counts.reset(); // what looking evaluated
        }
        self.pool.install(|| ensembles.iter_mut().for_each(|ensemble| ensemble.run(steps)));
        if let Some(counts) = &self.counts {
            self.evaluations[0] += counts.values();
            self.evaluations[1] += counts.gradients();
        }
        assert!(
            self.ensembles.iter().all(|ensemble| ensemble.failures().next().is_none()),
            "steps within reach"
        );
    }

    fn body(&self, i: usize) -> ([f64; 3], [f64; 3]) {
        let (ensemble, own) = if self.ensembles.len() == 1 { (0, i) } else { (i, 0) };
        let state = self.ensembles[ensemble].state(own);
        let (q, p) = (state.positions().next(), state.momenta().next());
        (q.expect("a body").into(), p.expect("a body").into())
    }

    fn evaluations(&self) -> [u64; 2] {
        self.evaluations
    }

    fn by_the_clock(&self) -> bool {
        self.threads > 1
    }
}

/// Trajectories one after the other.
struct OneByOne<Y: System<f64, 3>, S: Method> {
    simulations: Vec<Simulation<Y, S, 3>>,
    counts: Option<Counts>,
}

fn one_by_one<C, E, S>(
    scene: &Scene<C, E, One, 3>,
    starts: impl Iterator<Item = State<3>>,
    method: S,
    counts: Option<Counts>,
) -> Box<dyn Run>
where
    C: Constraint<3, 1>,
    E: rattle::effect::Effects<3> + 'static,
    S: Method,
{
    let simulation = |start| scene.simulate(start, method.clone()).expect("a start on the surface");
    let simulations: Vec<_> = starts.map(simulation).collect();
    if let Some(counts) = &counts {
        counts.reset(); // what the starts evaluated
    }
    Box::new(OneByOne { simulations, counts })
}

impl<Y: System<f64, 3>, S: Method> Run for OneByOne<Y, S> {
    fn advance(&mut self, steps: u64) {
        for simulation in &mut self.simulations {
            simulation.run(steps).expect("steps within reach");
        }
    }

    fn body(&self, i: usize) -> ([f64; 3], [f64; 3]) {
        body(&self.simulations[i], 0)
    }

    fn evaluations(&self) -> [u64; 2] {
        self.counts.as_ref().map_or([0; 2], |counts| [counts.values(), counts.gradients()])
    }
}

/// A gas.
struct Gas<Y: System<f64, 3>>(Simulation<Y, Rattle, 3>);

/// The gas that starts at rest in these positions.
pub(crate) fn gas(h: f64, positions: &[[f64; 3]]) -> Box<dyn Run> {
    let scene: Scene<_, _, Many, 3> = Scene::on(SURFACE).bodies(positions.len()).with(RICKER);
    let start = State::of(positions.iter().copied());
    Box::new(Gas(scene.simulate(start, Rattle::new(h)).expect("a start on the surface")))
}

impl<Y: System<f64, 3>> Run for Gas<Y> {
    fn advance(&mut self, steps: u64) {
        self.0.run(steps).expect("steps within reach");
    }

    fn body(&self, i: usize) -> ([f64; 3], [f64; 3]) {
        body(&self.0, i)
    }

    fn evaluations(&self) -> [u64; 2] {
        [0; 2]
    }

    fn energy(&self) -> Option<f64> {
        Some(self.0.energy())
    }
}

fn body<Y: System<f64, 3>, S: Method>(simulation: &Simulation<Y, S, 3>, i: usize) -> ([f64; 3], [f64; 3]) {
    let q = simulation.positions().nth(i).expect("a body of that number");
    let p = simulation.momenta().nth(i).expect("a body of that number");
    (q.into(), p.into())
}

/// Writes where a gas starts: the step size, then points of one path, each so many steps after the one before.
pub(crate) fn write_gas(file: &Path, particles: usize, every: u64, h: f64) -> std::io::Result<()> {
    let angle = std::f64::consts::TAU * 3.0 / 24.0;
    let start = State::at([0.0, 0.0, SURFACE.r]).moving([angle.cos(), angle.sin(), 0.0]);
    let scene = Scene::on(SURFACE).with(GRAVITY);
    let mut simulation = scene.simulate(start, Rattle::new(H)).expect("a start on the surface");
    let mut text = format!("{h:?}\n");
    for _ in 0..particles {
        let [x, y, z]: [f64; 3] = simulation.position().into();
        text += &format!("{x:?} {y:?} {z:?}\n");
        simulation.run(every).expect("steps within reach");
    }
    std::fs::write(file, text)
}

/// Reads it.
pub(crate) fn read_gas(file: &Path) -> (f64, Vec<[f64; 3]>) {
    let text = std::fs::read_to_string(file).expect("a file that was written");
    let mut numbers = text.split_whitespace().map(|word| word.parse::<f64>().expect("a number"));
    let h = numbers.next().expect("a step size");
    let positions: Vec<f64> = numbers.collect();
    (h, positions.as_chunks().0.to_vec())
}
