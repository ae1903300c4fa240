//! What a group of trajectories shows of itself while it runs.

use crate::number::instructions::InstructionSet;
use crate::run::watch::seen::{Page, Seen};
use crate::run::watch::sight::Source;

/// Trajectories that can be looked at.
#[allow(clippy::len_without_is_empty, reason = "there is one at least")]
pub trait Watched<const D: usize>: Source<D> {
    /// How many there are.
    fn len(&self) -> usize;
    /// Bodies of each.
    fn bodies(&self) -> usize;
    /// Writes all of them.
    fn look(&self, page: Page<'_, D>, set: InstructionSet);
    /// Of each, whether it goes on; there may be more numbers than trajectories.
    fn moving(&self) -> &[bool];
}

/// Who is shown a group after every so many steps.
pub struct Onlooker<'a, const D: usize> {
    /// The steps after which it is shown next, counted from the start of the ensemble. A stretch of steps that is gone
    /// through again, because a lane fails in it, shows nothing twice.
    pub(crate) next: u64,
    pub(crate) every: u64,
    pub(crate) now: Seen<D>,
    /// Is given what is seen, and may put other such memory in its place.
    pub(crate) show: &'a mut (dyn FnMut(&mut Seen<D>, &dyn Watched<D>) + Send),
}

impl<const D: usize> Onlooker<'_, D> {
    /// Shows a group, which is to be written already.
    pub(crate) fn show(&mut self, group: &dyn Watched<D>) {
        self.now.steps = self.next;
        self.next = self.next.saturating_add(self.every);
        (self.show)(&mut self.now, group);
    }
}
