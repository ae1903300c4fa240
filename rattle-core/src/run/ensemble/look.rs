//! How a group of trajectories is shown to an observer while it runs.

use crate::run::watch::seen::{Page, Seen};
use crate::run::watch::sight::Source;

/// Trajectories that can be shown.
#[allow(clippy::len_without_is_empty, reason = "there is one at least")]
pub(crate) trait Watched<const D: usize> {
    /// The number of trajectories.
    fn len(&self) -> usize;
    /// The number of bodies of each trajectory.
    fn bodies(&self) -> usize;
    /// Writes times, positions and momenta of all trajectories to `page`.
    fn look(&self, page: Page<'_, D>);
    /// Whether each trajectory is still moving, that is, has not failed. There may be more entries than trajectories.
    fn moving(&self) -> &[bool];
    /// What tells of a trajectory that is moving what a sight asks.
    fn source(&self) -> &dyn Source<D>;
}

/// An observer of a group, and the steps at which it is shown the group.
pub(crate) struct Onlooker<'a, const D: usize> {
    /// The number of steps, counted from the start of the ensemble, after which the group is shown next. Where a
    /// stretch of steps is repeated because a lane failed in it, this number keeps the observer from being shown
    /// anything twice.
    pub(crate) next: u64,
    pub(crate) every: u64,
    /// What is seen, in turn; the first so many are written, and not shown.
    pub(crate) pages: &'a mut [Seen<D>],
    pub(crate) written: usize,
    /// Is given what is seen, and may put other such memory in its place.
    pub(crate) show: &'a mut (dyn FnMut(&mut Seen<D>, &dyn Watched<D>) + Send),
}

impl<const D: usize> Onlooker<'_, D> {
    /// After how many steps the next page is to be written.
    pub(crate) fn due(&self) -> u64 {
        self.due_after(self.written)
    }

    fn due_after(&self, pages: usize) -> u64 {
        self.next.saturating_add(self.every.saturating_mul(pages as u64))
    }

    /// Whether pages are to be shown after so many steps, when those that are due are written: when there is room for
    /// no more, or none is due before the end.
    pub(crate) fn shows(&self, now: u64, end: u64) -> bool {
        let written = self.written + usize::from(self.due() == now);
        written > 0 && (written == self.pages.len() || now == end || self.due_after(written) > end)
    }

    /// The next page, which is written now.
    pub(crate) fn write(&mut self) -> Page<'_, D> {
        self.written += 1;
        self.pages[self.written - 1].page()
    }

    /// Forgets what was not shown.
    pub(crate) fn forget(&mut self) {
        self.written = 0;
    }

    /// Shows a group as it was when pages were written; on each of them `finish` writes what was not.
    pub(crate) fn show(&mut self, group: &dyn Watched<D>, finish: impl Fn(Page<'_, D>)) {
        for page in &mut self.pages[..self.written] {
            finish(page.page());
            (page.steps, page.corrections) = (self.next, group.source().corrections());
            self.next = self.next.saturating_add(self.every);
            (self.show)(page, group);
        }
        self.written = 0;
    }
}
