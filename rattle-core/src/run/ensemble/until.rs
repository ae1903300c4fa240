//! Ensembles that run until a time, or as long as they are asked to.

use crate::error::Error;
use crate::number::clock::steps_to;
use crate::run::ensemble::trajectories::Ensemble;

impl<const D: usize> Ensemble<D> {
    /// Takes as many steps as lead every trajectory that has not failed to `time`, or less than one step beyond it.
    ///
    /// All take the same number of steps: where starts have different times, the trajectory that is farthest away says
    /// how many, as [`Simulation::run_until`](crate::run::simulation::Simulation::run_until) would. Where a method
    /// chooses the lengths of its steps, some may end farther beyond.
    ///
    /// ```
    /// # use rattle::{Scene, State, Rattle};
    /// let starts = (0..100).map(|i| State::at([0.0]).moving([f64::from(i)]));
    /// let mut ensemble = Scene::points::<1>(1).ensemble(starts, Rattle::new(0.1))?;
    /// ensemble.run_until(0.3)?;
    /// assert_eq!(ensemble.steps(), 3);
    /// # Ok::<(), rattle::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::EndTime`] for a time that is not finite. Trajectories that fail are told by
    /// [`failures`](Self::failures).
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a whole number, which is above 0"
    )]
    #[doc(alias = "end time")]
    #[inline(never)]
    pub fn run_until(&mut self, time: f64) -> Result<(), Error> {
        if !time.is_finite() {
            return Err(Error::EndTime(time));
        }
        loop {
            let going = self.groups.iter().flat_map(|group| {
                (0..group.len())
                    .filter(|&own| group.failure(own).is_none())
                    .map(|own| group.state(own).time())
            });
            let left = going.map(|now| steps_to(time, now, self.h)).fold(0.0, f64::max);
            if left <= 0.0 {
                return Ok(());
            }
            self.run(left as u64);
        }
    }

    /// Takes steps as long as `go_on` returns true for the ensemble, at most `steps`; returns how many were taken. It
    /// is asked before the first step and after every `every` steps (0 counts as 1).
    ///
    /// ```
    /// # use rattle::{Scene, State, Rattle};
    /// let starts = (1..100).map(|i| State::at([0.0]).moving([f64::from(i)]));
    /// let mut ensemble = Scene::points::<1>(1).ensemble(starts, Rattle::new(0.1))?;
    /// let steps = ensemble.run_while(1_000_000, 10, |now| now.state(0).positions().all(|q| q.x < 4.5));
    /// assert_eq!(steps, 50);
    /// # Ok::<(), rattle::Error>(())
    /// ```
    #[doc(alias = "stop early")]
    pub fn run_while(&mut self, steps: u64, every: u64, mut go_on: impl FnMut(&Self) -> bool) -> u64 {
        let every = every.max(1);
        let begun = self.steps;
        while self.steps - begun < steps && go_on(self) {
            self.run(every.min(steps - (self.steps - begun)));
        }
        self.steps - begun
    }
}
