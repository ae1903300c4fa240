//! Snapshots of an ensemble for a consumer that works on another thread while the ensemble goes on.

use crate::run::ensemble::trajectories::Ensemble;
use crate::run::watch::seen::Page;
use nalgebra::SVector;
use rayon::prelude::*;
use std::sync::mpsc::sync_channel;

/// Positions and momenta of all trajectories of an ensemble after some step.
#[derive(Debug, Clone, Default)]
pub struct Snapshot<const D: usize> {
    /// Steps taken so far.
    pub steps: u64,
    /// The time of each trajectory. Times differ where starts do, and where a trajectory has failed: its time stays
    /// that of its last step.
    pub times: Vec<f64>,
    /// Positions: all bodies of the first trajectory, then of the second, and so on; in a sweep over networks of
    /// several sizes, as many as each has.
    pub positions: Vec<SVector<f64, D>>,
    /// Momenta, in the same order.
    pub momenta: Vec<SVector<f64, D>>,
}

/// Snapshots on the way; with more a slow consumer would fill the memory.
const ON_THE_WAY: usize = 2;

impl<const D: usize> Ensemble<D> {
    /// Takes `steps` steps, and passes a snapshot to `consume` after every `every` steps (0 counts as 1).
    ///
    /// `consume` runs on a thread of its own while the ensemble goes on. Where `consume` falls two snapshots behind,
    /// the ensemble waits, so memory does not grow. A trajectory that has failed appears in each snapshot with its last
    /// state.
    ///
    /// # Errors
    /// The first error of `consume`; no further steps are then begun.
    ///
    /// # Panics
    /// If `consume` does.
    pub fn stream<X: Send>(
        &mut self,
        steps: u64,
        every: u64,
        mut consume: impl FnMut(&Snapshot<D>) -> Result<(), X> + Send,
    ) -> Result<(), X> {
        let every = every.max(1);
        let (full, to_consume) = sync_channel::<Snapshot<D>>(ON_THE_WAY);
        let (empty, to_fill) = sync_channel::<Snapshot<D>>(ON_THE_WAY + 2);
        std::thread::scope(|scope| {
            let consumer = scope.spawn(move || {
                for snapshot in to_consume {
                    consume(&snapshot)?;
                    empty.try_send(snapshot).ok(); // to be used again, if anybody still wants it
                }
                Ok(())
            });
            for part in (0..steps).step_by(usize::try_from(every).unwrap_or(usize::MAX)) {
                self.run(every.min(steps - part));
                if steps - part < every {
                    break;
                }
                let mut snapshot = to_fill.try_recv().unwrap_or_default();
                self.fill(&mut snapshot);
                if full.send(snapshot).is_err() {
                    break; // the consumer has ended, with an error
                }
            }
            drop(full);
            consumer.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        })
    }

    /// The present positions and momenta.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot<D> {
        let mut snapshot = Snapshot::default();
        self.fill(&mut snapshot);
        snapshot
    }

    fn fill(&self, snapshot: &mut Snapshot<D>) {
        let bodies: usize = self.groups.iter().map(|group| group.len() * group.bodies()).sum();
        let Snapshot { steps, times, positions, momenta } = snapshot;
        *steps = self.steps;
        times.resize(self.len, 0.0);
        positions.resize(bodies, SVector::zeros());
        momenta.resize(bodies, SVector::zeros());
        let (mut times, mut positions, mut momenta) = (&mut times[..], &mut positions[..], &mut momenta[..]);
        let mut pages = Vec::with_capacity(self.groups.len());
        for group in &self.groups {
            let (trajectories, all) = (group.len(), group.len() * group.bodies());
            let page = Page {
                times: times.split_off_mut(..trajectories).unwrap_or_default(),
                positions: positions.split_off_mut(..all).unwrap_or_default(),
                momenta: momenta.split_off_mut(..all).unwrap_or_default(),
            };
            pages.push((group, page));
        }
        pages.into_par_iter().for_each(|(group, page)| group.look(page));
    }
}
