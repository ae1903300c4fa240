//! How a group of trajectories is shown to an observer while it runs.

use crate::number::instructions::InstructionSet;
use crate::run::watch::seen::{Page, Seen};
use crate::run::watch::sight::Source;

/// Trajectories that can be shown.
#[allow(clippy::len_without_is_empty, reason = "there is one at least")]
pub(crate) trait Watched<const D: usize>: Source<D> {
    /// The number of trajectories.
    fn len(&self) -> usize;
    /// The number of bodies of each trajectory.
    fn bodies(&self) -> usize;
    /// Writes times, positions and momenta of all trajectories to `page`.
    fn look(&self, page: Page<'_, D>, set: InstructionSet);
    /// Whether each trajectory is still moving, that is, has not failed. There may be more entries than trajectories.
    fn moving(&self) -> &[bool];
}

/// An observer of a group, and the steps at which it is shown the group.
pub(crate) struct Onlooker<'a, const D: usize> {
    /// The number of steps, counted from the start of the ensemble, after which the group is shown next. Where a
    /// stretch of steps is repeated because a lane failed in it, this number keeps the observer from being shown
    /// anything twice.
    pub(crate) next: u64,
    pub(crate) every: u64,
    pub(crate) now: &'a mut Seen<D>,
    /// Is given what is seen, and may put other such memory in its place.
    pub(crate) show: &'a mut (dyn FnMut(&mut Seen<D>, &dyn Watched<D>) + Send),
}

impl<const D: usize> Onlooker<'_, D> {
    /// Shows a group, which is to be written already.
    pub(crate) fn show(&mut self, group: &dyn Watched<D>) {
        self.now.steps = self.next;
        self.next = self.next.saturating_add(self.every);
        (self.show)(self.now, group);
    }
}
