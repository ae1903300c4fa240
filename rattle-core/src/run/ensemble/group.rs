//! Groups: trajectories of an ensemble that are computed together.

use crate::error::Error;
use crate::motion::record::{Reading, Record};
use crate::motion::state::State;
use crate::run::bill::Bill;
use crate::run::ensemble::look::{Onlooker, Watched};

/// Some trajectories of an ensemble.
pub(crate) trait Group<const D: usize>: Watched<D> + Send + Sync {
    /// Takes `steps` steps, and shows the group to `onlooker` at each multiple of its interval. A trajectory that fails
    /// stays at the state before the failed step.
    fn run(&mut self, steps: u64, onlooker: Option<&mut Onlooker<'_, D>>);
    /// From now on a step that fails is repeated in 2, 4, … 2^`halvings` parts.
    fn retry(&mut self, halvings: u32);
    /// From now on every step is taken back and compared, which has a way back.
    ///
    /// # Errors
    /// Those of a simulation.
    fn check_reversal(&mut self, tolerance: f64) -> Result<(), Error>;
    /// The state of one trajectory.
    fn state(&self, trajectory: usize) -> State<D>;
    /// The work done on the bodies of one trajectory since the start.
    fn work(&self, trajectory: usize) -> f64;
    /// What a step of a trajectory that has not failed costs.
    ///
    /// # Errors
    /// Those of the steps that are tried.
    fn bill(&self) -> Result<Bill, Error>;
    /// Writes everything needed to continue.
    fn record(&self, to: &mut Record);
    /// A copy of this group, at the states of a record.
    ///
    /// # Errors
    /// [`Error::Record`] for the record of another group.
    fn recalled(&self, from: &mut Reading<'_>) -> Result<Box<dyn Group<D>>, Error>;
    /// Why a trajectory has failed.
    fn failure(&self, trajectory: usize) -> Option<&Error>;
}
