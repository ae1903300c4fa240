//! Trajectories that are moved on together.

use crate::error::Error;
use crate::motion::record::{Reading, Record};
use crate::motion::state::State;
use crate::number::instructions::InstructionSet;
use crate::run::bill::Bill;
use crate::run::ensemble::look::{Onlooker, Watched};

/// Some trajectories of an ensemble.
pub trait Group<const D: usize>: Watched<D> + Send + Sync {
    /// Takes so many steps, and shows the group to an onlooker when it is time; trajectories that fail rest where they were
    /// before the step.
    fn run(&mut self, steps: u64, set: InstructionSet, onlooker: Option<&mut Onlooker<'_, D>>);
    /// Takes steps that cannot be taken in 2, 4, … 2^`halvings` parts.
    fn retry(&mut self, halvings: u32);
    /// The state of one.
    fn state(&self, trajectory: usize) -> State<D>;
    /// What a step of one that moves costs.
    ///
    /// # Errors
    /// Those of the steps that are tried.
    fn bill(&self) -> Result<Bill, Error>;
    /// Writes all that is needed to go on.
    fn record(&self, to: &mut Record);
    /// The same group where another was.
    ///
    /// # Errors
    /// [`Error::Record`] where that was another group.
    fn recalled(&self, from: &mut Reading<'_>) -> Result<Box<dyn Group<D>>, Error>;
    /// Why one goes on no more.
    fn failure(&self, trajectory: usize) -> Option<&Error>;
}
