//! A scene with its start, and the simulations that it makes.

use crate::effect::list::{Effects, Forces};
use crate::error::{Error, PriceMistake};
use crate::motion::bodies::Count;
use crate::motion::hold::{Hold, Kind};
use crate::motion::state::State;
use crate::run::boxed::BoxedSimulation;
use crate::run::price::beside::Beside;
use crate::run::price::candidate::Candidate;
use crate::run::price::moving::{Movable, Moving, Rung};
use crate::scene::Scene;
use std::iter::zip;

/// What is observed: a name and a number of the present state.
pub(super) type Observed<'a, const D: usize> = (String, Box<dyn Fn(&BoxedSimulation<D>) -> f64 + 'a>);

/// A scene with its start.
pub(super) struct Set<'a, C, E, N, const D: usize> {
    pub(super) scene: &'a Scene<C, E, N, D>,
    pub(super) start: &'a State<D>,
    pub(super) observed: &'a [Observed<'a, D>],
    pub(super) beside: Option<Beside<C, E, N, D>>,
    /// As [`Movable::works`].
    pub(super) works: bool,
}

struct Observing<'a, const D: usize> {
    simulation: BoxedSimulation<D>,
    observed: &'a [Observed<'a, D>],
    has_masses: bool,
}

impl<C: Hold<D>, E: Effects<D>, N: Count, const D: usize> Movable for Set<'_, C, E, N, D> {
    fn begin(&self, rung: Rung) -> Result<Box<dyn Moving + '_>, Error> {
        match rung.candidate {
            Candidate::InLanes(&method, numbers) => {
                let beside = self.beside.as_ref().ok_or(Error::Price(PriceMistake::OneByOne))?;
                let rung = Rung { candidate: method, ..rung };
                let alone = self.begin_from(rung, self.start.clone())?;
                beside.begin(self.scene, rung, numbers, alone.energy())
            }
            _ => self.begin_from(rung, self.start.clone()),
        }
    }
    fn begin_beside(&self, rung: Rung, off: f64) -> Result<Box<dyn Moving + '_>, Error> {
        let beside = aside(self.start, off);
        self.begin_from(rung, self.scene.project(&beside)?)
    }
    fn names(&self) -> Vec<String> {
        self.observed.iter().map(|(name, _)| name.clone()).collect()
    }
    fn dimension(&self) -> usize {
        D
    }
    fn flows(&self) -> bool {
        E::Forces::<f64>::FLOWS > 0
    }
    fn works(&self) -> bool {
        self.works
    }
    fn trajectories(&self) -> usize {
        self.beside.as_ref().map_or(0, |beside| beside.starts.len())
    }
}

impl<C: Hold<D>, E: Effects<D>, N: Count, const D: usize> Set<'_, C, E, N, D> {
    fn begin_from(&self, rung: Rung, start: State<D>) -> Result<Box<dyn Moving + '_>, Error> {
        let Rung { candidate, h, tolerance } = rung;
        let simulation = candidate.simulation(self.scene, start, h, tolerance, 0)?;
        let has_masses = const { !matches!(C::KIND, Kind::Phase) };
        Ok(Box::new(Observing { simulation, observed: self.observed, has_masses }))
    }
}

/// The state with every momentum off by at most this much, in directions without a pattern: multiples of the golden
/// ratio.
fn aside<const D: usize>(state: &State<D>, off: f64) -> State<D> {
    let number = |i: usize| (0.618_033_988_749_895 * (i + 1) as f64).fract() - 0.5;
    let momenta = zip(state.momenta(), 0..).map(|(mut p, body): (_, usize)| {
        zip(p.iter_mut(), 0..).for_each(|(p, i)| *p += 2.0 * off * number(body * D + i));
        p
    });
    state.clone().with_momenta(momenta)
}

impl<const D: usize> Moving for Observing<'_, D> {
    fn again(&self) -> Result<Box<dyn Moving + '_>, Error> {
        Ok(Box::new(Observing { simulation: self.simulation.clone(), ..*self }))
    }
    fn run(&mut self, steps: u64) -> Result<(), Error> {
        self.simulation.run(steps)
    }
    fn positions(&self) -> Vec<f64> {
        self.simulation.positions().flat_map(<[f64; D]>::from).collect()
    }
    fn largest_momentum(&self) -> f64 {
        self.simulation.momenta().map(|p| p.amax()).fold(0.0, f64::max)
    }
    fn energy(&self) -> f64 {
        self.simulation.energy()
    }
    fn energy_error(&self) -> f64 {
        self.simulation.energy_error()
    }
    fn kinetic_energy(&self) -> f64 {
        let now = &self.simulation;
        if self.has_masses {
            return now.kinetic_energy();
        }
        zip(now.momenta(), now.velocities()).map(|(p, v)| 0.5 * p.component_mul(&v).abs().sum()).sum()
    }
    fn iterations(&self) -> Option<u64> {
        self.simulation.corrections()
    }
    fn observed(&self) -> Vec<f64> {
        self.observed.iter().map(|(_, of)| of(&self.simulation)).collect()
    }
}
