//! How wide rows of rigid bodies are, and their steps as they are compiled here and not wherever an ensemble is made.

use crate::run::ensemble::engine::Stuck;
use crate::run::ensemble::linked_going::Width;
use crate::run::ensemble::rigid_projected::ProjectedSteps;
use crate::run::ensemble::rigid_row::Steps;
use crate::run::ensemble::rigid_stirring::StirredSteps;
use crate::systems::network::in_lanes::{FEW, ROW};

/// Rows of so many lanes.
pub(super) trait Turns<const W: usize> {
    /// Takes steps.
    fn turn(steps: Steps<'_, '_, W>) -> Result<(), Stuck>;
    /// Takes steps with flows.
    fn stir(steps: StirredSteps<'_, '_, W>) -> Result<(), Stuck>;
}

impl Turns<ROW> for Width {
    fn turn(steps: Steps<'_, '_, ROW>) -> Result<(), Stuck> {
        steps.course.set.run(steps)
    }
    fn stir(steps: StirredSteps<'_, '_, ROW>) -> Result<(), Stuck> {
        steps.course.set.run(steps)
    }
}

impl Turns<FEW> for Width {
    fn turn(steps: Steps<'_, '_, FEW>) -> Result<(), Stuck> {
        steps.course.set.run(steps)
    }
    fn stir(steps: StirredSteps<'_, '_, FEW>) -> Result<(), Stuck> {
        steps.course.set.run(steps)
    }
}

/// Takes steps that are projected.
#[inline(never)]
pub(super) fn project(steps: ProjectedSteps<'_, '_>) -> Result<(), Vec<Stuck>> {
    steps.desk.stand.set.run(steps)
}
