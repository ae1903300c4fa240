//! A trajectory that is computed as a simulation, not in lanes.

use crate::error::Error;
use crate::motion::method::Method;
use crate::motion::record::{Reading, Record};
use crate::motion::state::State;
use crate::motion::system::System;
use crate::run::bill::Bill;
use crate::run::ensemble::group::Group;
use crate::run::ensemble::look::{Onlooker, Watched};
use crate::run::simulation::Simulation;
use crate::run::watch::seen::Page;
use crate::run::watch::sight::Source;

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
    fn run(&mut self, steps: u64, mut onlooker: Option<&mut Onlooker<'_, D>>) {
        let end = self.simulation.steps().saturating_add(steps);
        while self.failure.is_none() && self.simulation.steps() < end {
            let stop = onlooker.as_ref().map_or(end, |onlooker| onlooker.next.min(end));
            self.failure = self.simulation.run(stop - self.simulation.steps()).err();
            self.moving = [self.failure.is_none()];
            if let Some(onlooker) = &mut onlooker
                && self.simulation.steps() == onlooker.next
            {
                self.look(onlooker.write());
                onlooker.show(self, |_| ());
            }
        }
    }

    fn retry(&mut self, halvings: u32) {
        self.simulation.halve(halvings);
    }

    fn check_reversal(&mut self, tolerance: f64) -> Result<(), Error> {
        self.simulation.reverse(tolerance)
    }

    fn state(&self, _: usize) -> State<D> {
        self.simulation.state()
    }

    fn work(&self, _: usize) -> f64 {
        self.simulation.work()
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

    fn look(&self, page: Page<'_, D>) {
        self.simulation.look(page);
    }

    fn moving(&self) -> &[bool] {
        &self.moving
    }

    fn source(&self) -> &dyn Source<D> {
        &self.simulation
    }
}
