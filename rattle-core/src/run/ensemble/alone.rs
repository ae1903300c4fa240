//! A trajectory that is computed as a simulation, not in lanes.

use crate::error::Error;
use crate::motion::method::Method;
use crate::motion::record::{Reading, Record};
use crate::motion::state::State;
use crate::motion::system::System;
use crate::number::instructions::InstructionSet;
use crate::run::bill::Bill;
use crate::run::ensemble::group::Group;
use crate::run::ensemble::look::{Onlooker, Watched};
use crate::run::simulation::Simulation;
use crate::run::watch::seen::Page;
use crate::run::watch::sight::{Sight, Source};
use nalgebra::SVector;

/// A simulation by itself.
pub(crate) struct Alone<Y: System<f64, D>, S: Method, const D: usize> {
    simulation: Simulation<Y, S, D>,
    failure: Option<Error>,
    moving: [bool; 1],
}

impl<Y: System<f64, D>, S: Method, const D: usize> Alone<Y, S, D> {
    pub(crate) fn new(simulation: Simulation<Y, S, D>) -> Self {
        Self { simulation, failure: None, moving: [true] }
    }
}

impl<Y: System<f64, D>, S: Method, const D: usize> Group<D> for Alone<Y, S, D> {
    fn run(&mut self, steps: u64, set: InstructionSet, mut onlooker: Option<&mut Onlooker<'_, D>>) {
        let end = self.simulation.steps().saturating_add(steps);
        while self.failure.is_none() && self.simulation.steps() < end {
            let stop = onlooker.as_ref().map_or(end, |onlooker| onlooker.next.min(end));
            self.failure = self.simulation.run(stop - self.simulation.steps()).err();
            self.moving = [self.failure.is_none()];
            if let Some(onlooker) = &mut onlooker
                && self.simulation.steps() == onlooker.next
            {
                self.look(onlooker.write(), set);
                onlooker.show(self, |_| ());
            }
        }
    }

    fn retry(&mut self, halvings: u32) {
        self.simulation.halve(halvings);
    }

    fn state(&self, _: usize) -> State<D> {
        self.simulation.state()
    }

    fn bill(&self) -> Result<Bill, Error> {
        self.simulation.bill()
    }

    fn record(&self, to: &mut Record) {
        to.text("what", "a trajectory by itself");
        to.text("failure", &self.failure.as_ref().map_or(String::new(), Error::to_string));
        self.simulation.record(to);
    }

    fn recalled(&self, from: &mut Reading<'_>) -> Result<Box<dyn Group<D>>, Error> {
        from.expect("a trajectory by itself")?;
        let failure = from.text("failure")?;
        let failure = (!failure.is_empty()).then(|| Error::Before(failure.into()));
        let simulation = self.simulation.recalled(from)?;
        Ok(Box::new(Self { moving: [failure.is_none()], simulation, failure }))
    }

    fn failure(&self, _: usize) -> Option<&Error> {
        self.failure.as_ref()
    }
}

impl<Y: System<f64, D>, S: Method, const D: usize> Watched<D> for Alone<Y, S, D> {
    fn len(&self) -> usize {
        1
    }

    fn bodies(&self) -> usize {
        self.simulation.bodies()
    }

    fn look(&self, page: Page<'_, D>, _: InstructionSet) {
        self.simulation.look(page);
    }

    fn moving(&self) -> &[bool] {
        &self.moving
    }
}

impl<Y: System<f64, D>, S: Method, const D: usize> Source<D> for Alone<Y, S, D> {
    fn energies(&self, _: usize, sight: &Sight<'_, D>) -> [f64; 2] {
        self.simulation.energies(0, sight)
    }

    fn constraints(&self, _: usize, sight: &Sight<'_, D>) -> (Vec<f64>, Vec<SVector<f64, D>>) {
        self.simulation.constraints(0, sight)
    }

    fn effect_energies(&self, _: usize, sight: &Sight<'_, D>) -> Vec<f64> {
        Source::effect_energies(&self.simulation, 0, sight)
    }

    fn residuals(&self, _: usize, sight: &Sight<'_, D>) -> Vec<f64> {
        Source::residuals(&self.simulation, 0, sight)
    }

    fn temperature(&self, _: usize, sight: &Sight<'_, D>) -> f64 {
        Source::temperature(&self.simulation, 0, sight)
    }

    fn corrections(&self) -> Option<u64> {
        self.simulation.corrections()
    }

    fn mass_product(&self, _: usize, body: usize, a: &[f64; D], b: &[f64; D]) -> f64 {
        self.simulation.mass_product(0, body, a, b)
    }

    fn step_size(&self) -> f64 {
        self.simulation.step_size()
    }
}
