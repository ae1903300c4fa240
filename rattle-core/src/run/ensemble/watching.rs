//! Observers of the groups of an ensemble.

use crate::error::Error;
use crate::number::instructions::InstructionSet;
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
        let sights = before.sights(group, first).zip(now.sights(group, first));
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
    pub(super) now: Seen<D>,
    pub(super) next: u64,
}

impl<const D: usize> Watching<'_, D> {
    pub(super) fn run(
        &mut self,
        group: &mut Box<dyn Group<D>>,
        first: usize,
        steps: u64,
        every: u64,
        set: InstructionSet,
    ) {
        let Self { observer, before, now, next } = self;
        let mut show = |now: &mut Seen<D>, group: &dyn Watched<D>| {
            observer.see_group(group, first, before, now);
            std::mem::swap(before, now);
        };
        let mut onlooker = Onlooker { next: *next, every, now, show: &mut show };
        group.run(steps, set, Some(&mut onlooker));
        *next = onlooker.next;
    }
}
