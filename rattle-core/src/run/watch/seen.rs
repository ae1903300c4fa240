//! Memory for what observers are shown, used again and again.

use crate::run::watch::sight::{Sight, Source};
use nalgebra::SVector;

/// Times, positions and momenta of trajectories in turn, after so many steps.
#[derive(Debug, Clone)]
pub(crate) struct Seen<const D: usize> {
    pub(crate) steps: u64,
    /// Corrections in position equations by then, where there is one trajectory that counts them.
    pub(crate) corrections: Option<u64>,
    times: Vec<f64>,
    positions: Vec<SVector<f64, D>>,
    momenta: Vec<SVector<f64, D>>,
    /// Of a trajectory.
    bodies: usize,
}

/// Where times, and positions and momenta of all bodies, of some trajectories in turn, are written.
#[derive(Debug)]
pub(crate) struct Page<'a, const D: usize> {
    pub(crate) times: &'a mut [f64],
    pub(crate) positions: &'a mut [SVector<f64, D>],
    pub(crate) momenta: &'a mut [SVector<f64, D>],
}

impl<const D: usize> Seen<D> {
    /// For so many trajectories of so many bodies; with what is written there.
    pub(crate) fn new(
        steps: u64,
        trajectories: usize,
        bodies: usize,
        write: impl FnOnce(Page<'_, D>),
    ) -> Self {
        let zeros = vec![SVector::zeros(); trajectories * bodies];
        let times = vec![0.0; trajectories];
        let mut seen =
            Self { steps, corrections: None, times, positions: zeros.clone(), momenta: zeros, bodies };
        write(seen.page());
        seen
    }

    /// How many numbers there are.
    pub(crate) fn numbers(&self) -> usize {
        self.times.len() + 2 * D * self.positions.len()
    }

    /// Counts its times from this one on, after so many steps.
    pub(crate) fn date(&mut self, steps: u64, time: f64) {
        self.steps = steps;
        self.times.iter_mut().for_each(|passed| *passed += time);
    }

    /// Where it is to be written.
    pub(crate) fn page(&mut self) -> Page<'_, D> {
        Page { times: &mut self.times, positions: &mut self.positions, momenta: &mut self.momenta }
    }

    /// The only trajectory.
    #[inline(always)]
    pub(crate) fn sight<'a>(&'a self, source: &'a dyn Source<D>) -> Sight<'a, D> {
        let Self { steps, corrections, ref times, ref positions, ref momenta, .. } = *self;
        let (time, source) = (times[0], (source, 0));
        Sight { trajectory: 0, step: steps, time, positions, momenta, corrections, source }
    }

    /// The trajectories in turn, the first of which has this number.
    #[inline(always)]
    pub(crate) fn sights<'a>(
        &'a self,
        source: &'a dyn Source<D>,
        first: usize,
    ) -> impl Iterator<Item = Sight<'a, D>> {
        let (mut places, mut ways) = (&self.positions[..], &self.momenta[..]);
        self.times.iter().enumerate().map(move |(own, &time)| {
            let (positions, momenta);
            ((positions, places), (momenta, ways)) =
                (places.split_at(self.bodies), ways.split_at(self.bodies));
            let (trajectory, step, corrections) = (first + own, self.steps, self.corrections);
            Sight { trajectory, step, time, positions, momenta, corrections, source: (source, own) }
        })
    }
}

/// Writes vectors there.
pub(crate) fn write<const D: usize>(list: &[[f64; D]], to: &mut [SVector<f64, D>]) {
    to.iter_mut().zip(list).for_each(|(to, &x)| *to = x.into());
}
