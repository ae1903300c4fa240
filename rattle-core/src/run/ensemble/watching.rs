//! Observers of the groups of an ensemble.

use crate::error::Error;
use crate::run::ensemble::group::Group;
use crate::run::ensemble::look::{Onlooker, Watched};
use crate::run::watch::observer::Observer;
use crate::run::watch::seen::Seen;

/// An observer of any type, as an object: what runs a group and shows it is compiled once for all observers.
pub(super) trait AnyObserver<const D: usize> {
    /// Sees those of a group that move, the first of which has this number.
    fn see_group(&mut self, group: &dyn Watched<D>, first: usize, before: &Seen<D>, now: &Seen<D>);
    /// As [`Observer::failure`].
    fn failure(&self) -> Option<Error>;
}

impl<O: Observer<D>, const D: usize> AnyObserver<D> for O {
    fn see_group(&mut self, group: &dyn Watched<D>, first: usize, before: &Seen<D>, now: &Seen<D>) {
        let sights = before.sights(group.source(), first).zip(now.sights(group.source(), first));
        for ((before, now), &moves) in sights.zip(group.moving()) {
            if moves {
                self.see(&before, &now);
            }
        }
    }

    fn failure(&self) -> Option<Error> {
        Observer::failure(self)
    }
}

/// An observer of a group, what it saw, and after how many steps it is shown the group again.
pub(super) struct Watching<'a, const D: usize> {
    pub(super) observer: &'a mut (dyn AnyObserver<D> + Send),
    pub(super) before: Seen<D>,
    pub(super) pages: Vec<Seen<D>>,
    pub(super) next: u64,
}

/// Pages that are written before they are shown, at most: whether lanes are where they should be is asked once for all.
const MOST_PAGES: usize = 8;

/// So many numbers are on them, at most, where more than one is: as many as a processor has at hand.
const AT_HAND: usize = 1 << 13;

impl<'a, const D: usize> Watching<'a, D> {
    /// From the steps on after which the group is as on this page, where a whole group has so many numbers on it; it is
    /// to be shown so many times, after each `every` steps.
    pub(super) fn new(
        observer: &'a mut (dyn AnyObserver<D> + Send),
        now: Seen<D>,
        numbers: usize,
        every: u64,
        times: u64,
    ) -> Self {
        let most = usize::try_from(times).map_or(MOST_PAGES, |times| times.clamp(1, MOST_PAGES));
        let pages = (AT_HAND / numbers.max(1)).clamp(1, most);
        let next = now.steps.saturating_add(every);
        Self { observer, before: now.clone(), pages: vec![now; pages], next }
    }
}

impl<const D: usize> Watching<'_, D> {
    pub(super) fn run(&mut self, group: &mut Box<dyn Group<D>>, first: usize, steps: u64, every: u64) {
        let Self { observer, before, pages, next } = self;
        let mut show = |now: &mut Seen<D>, group: &dyn Watched<D>| {
            observer.see_group(group, first, before, now);
            std::mem::swap(before, now);
        };
        let mut onlooker = Onlooker { next: *next, every, pages, written: 0, show: &mut show };
        group.run(steps, Some(&mut onlooker));
        *next = onlooker.next;
    }
}
