//! What a group of trajectories shows of itself while it runs.

use crate::number::instructions::InstructionSet;
use crate::run::ensemble::sight::{Energies, Sight};
use nalgebra::SVector;

/// Trajectories that can be looked at.
#[allow(clippy::len_without_is_empty, reason = "there is one at least")]
pub trait Watched<const D: usize>: Energies<D> {
    /// How many there are.
    fn len(&self) -> usize;
    /// Bodies of each.
    fn bodies(&self) -> usize;
    /// Writes all of them.
    fn look(&self, page: Page<'_, D>, set: InstructionSet);
    /// Of each, whether it goes on; there may be more numbers than trajectories.
    fn moving(&self) -> &[bool];
}

/// Times, positions and momenta of a group's trajectories in turn, in memory that is used again and again.
#[derive(Debug, Clone)]
pub(crate) struct Seen<const D: usize> {
    times: Vec<f64>,
    positions: Vec<SVector<f64, D>>,
    momenta: Vec<SVector<f64, D>>,
    /// Of a trajectory.
    bodies: usize,
}

impl<const D: usize> Seen<D> {
    /// The group as it is.
    pub(crate) fn of(group: &dyn Watched<D>, set: InstructionSet) -> Self {
        let (trajectories, bodies) = (group.len(), group.bodies());
        let zeros = vec![SVector::zeros(); trajectories * bodies];
        let mut seen =
            Self { times: vec![0.0; trajectories], positions: zeros.clone(), momenta: zeros, bodies };
        group.look(seen.page(), set);
        seen
    }

    /// Where the group is to be written.
    pub(crate) fn page(&mut self) -> Page<'_, D> {
        Page { times: &mut self.times, positions: &mut self.positions, momenta: &mut self.momenta }
    }

    /// The trajectories of the group in turn, the first of which has this number.
    #[inline(always)]
    pub(crate) fn sights<'a>(
        &'a self,
        energies: &'a dyn Energies<D>,
        first: usize,
    ) -> impl Iterator<Item = Sight<'a, D>> {
        let (mut places, mut ways) = (&self.positions[..], &self.momenta[..]);
        self.times.iter().enumerate().map(move |(own, &time)| {
            let (positions, momenta);
            ((positions, places), (momenta, ways)) =
                (places.split_at(self.bodies), ways.split_at(self.bodies));
            Sight { trajectory: first + own, time, positions, momenta, scene: (energies, own) }
        })
    }
}

/// Where times, and positions and momenta of all bodies, of a group's trajectories in turn, are written.
#[derive(Debug)]
pub struct Page<'a, const D: usize> {
    pub(crate) times: &'a mut [f64],
    pub(crate) positions: &'a mut [SVector<f64, D>],
    pub(crate) momenta: &'a mut [SVector<f64, D>],
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
        self.next = self.next.saturating_add(self.every);
        (self.show)(&mut self.now, group);
    }
}
