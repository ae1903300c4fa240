//! Progress of a long run.

use crate::run::watch::observer::Observer;
use crate::run::watch::sight::Sight;

/// Calls a closure after every `every` sights with the number of sights since the last call, and when it is dropped
/// with the rest.
///
/// A sight is one observation: a simulation that is observed after every k-th step has steps/k sights, an ensemble as
/// many for each trajectory that does not fail. In a run of 10⁸ steps with a hundred sights the cost was too small to
/// be measured.
///
/// ```
/// # use rattle::{Rattle, Scene, State, watch::Progress};
/// # let mut simulation = Scene::point().simulate(State::at([0.0]), Rattle::new(0.1))?;
/// let mut done = 0; // of 100; a bar on the screen moves on by so much
/// simulation.observe(100_000, 1000, &mut Progress::of(1, |sights| done += sights))?;
/// assert_eq!(done, 100);
/// # Ok::<(), rattle::Error>(())
/// ```
#[derive(Debug)]
pub struct Progress<F: FnMut(u64)> {
    every: u64,
    since: u64,
    tell: F,
}

impl<F: FnMut(u64)> Progress<F> {
    /// Calls `tell` after every `every` sights with the number of sights since the last call.
    pub fn of(every: u64, tell: F) -> Self {
        Self { every, since: 0, tell }
    }

    fn tell(&mut self) {
        let since = std::mem::take(&mut self.since);
        if since > 0 {
            (self.tell)(since);
        }
    }
}

impl<F: FnMut(u64), const D: usize> Observer<D> for Progress<F> {
    #[inline(always)]
    fn see(&mut self, _: &Sight<'_, D>, _: &Sight<'_, D>) {
        self.since += 1;
        if self.since >= self.every {
            self.tell();
        }
    }

    fn join(&mut self, _next: Self) {} // which tells its rest where it ends
}

impl<F: FnMut(u64)> Drop for Progress<F> {
    fn drop(&mut self) {
        self.tell();
    }
}
