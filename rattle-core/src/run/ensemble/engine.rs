//! Engines: they move the trajectories of a group in lanes. The group itself handles failures, replacements of failed
//! lanes, and observers.

use crate::error::{Error, StepFailure};
use crate::motion::bodies::Body;
use crate::motion::failure::Failure;
use crate::motion::record::{Hallmark, Reading, Record};
use crate::number::clock::later;
use crate::run::fingerprint::Looks;
use crate::run::trouble::Trouble;
use crate::run::watch::seen::Page;
use crate::run::watch::sight::Source;
use std::any::Any;

/// Bodies, and the work of flows on them since the start.
pub(crate) type Moved<const D: usize> = (Vec<Body<f64, D>>, f64);

/// Where in the random numbers, and when, a trajectory starts.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Draws {
    /// The trajectory's number, and whether its start was given that.
    pub(crate) trajectory: u64,
    pub(crate) numbered: bool,
    /// Steps taken before its start.
    pub(crate) steps: u64,
    /// The time of its start, and what rounding took from that.
    pub(crate) time: (f64, f64),
}

/// A lane that cannot be moved, and why; without a failure where other sheets are near, and each step has to be looked
/// at.
pub(crate) struct Stuck {
    pub(crate) lane: usize,
    pub(crate) failure: Option<Failure>,
}

impl Stuck {
    /// A lane that ends where numbers end. It says by itself which ones.
    #[cold]
    #[inline(never)]
    pub(crate) fn not_finite(lane: usize) -> Self {
        let cause = StepFailure::MomentumNotFinite { position: Vec::new() };
        Self { lane, failure: Some(Failure { body: 0, cause }) }
    }
}

impl From<Stuck> for Vec<Stuck> {
    fn from(stuck: Stuck) -> Self {
        vec![stuck]
    }
}

/// Where all lanes are to be written, and what is needed for their times: those of the starts, the time since then, and
/// what rounding took from each.
pub(crate) struct Written<'a, const D: usize> {
    pub(crate) page: Page<'a, D>,
    pub(crate) starts: &'a [(f64, f64)],
    pub(crate) passed: (f64, f64),
}

impl<const D: usize> Written<'_, D> {
    /// Writes times, and so many positions and momenta: those of the bodies of a lane in turn, lane by lane.
    #[inline(always)]
    pub(crate) fn fill(self, number: usize, q: impl Fn(usize) -> [f64; D], p: impl Fn(usize) -> [f64; D]) {
        let Self { page: Page { times, positions, momenta }, starts, passed } = self;
        for (i, place) in positions.iter_mut().enumerate().take(number) {
            *place = q(i).into();
        }
        for (i, way) in momenta.iter_mut().enumerate().take(number) {
            *way = p(i).into();
        }
        times.iter_mut().zip(starts).for_each(|(time, &start)| *time = later(start, passed).0);
    }
}

/// So many steps, after so many since the start, and where all lanes are to be written after them, if they are. Of no
/// steps it is not asked whether lanes are where they should be: one that goes by itself may hold no numbers.
pub(crate) struct Leg<'a, const D: usize> {
    pub(crate) from: u64,
    pub(crate) steps: u64,
    pub(crate) written: Option<Written<'a, D>>,
    /// Whether what was written up to there is shown next, and cannot be taken back: whether all lanes are where they
    /// should be is asked before.
    pub(crate) shown: bool,
}

/// Steps that a lane takes by itself.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OwnSteps {
    /// Steps since the start, before these.
    pub(crate) from: u64,
    pub(crate) number: u64,
    /// Equal parts of each.
    pub(crate) parts: u32,
    /// Whether each is taken back, and to which tolerance it is compared; by symmetric methods alone.
    pub(crate) checked: Option<f64>,
}

/// Where lanes are to go, leg by leg.
pub(crate) trait Tour<const D: usize> {
    /// Shows what was written after the leg before, and says what the next one is.
    fn next(&mut self) -> Option<Leg<'_, D>>;
    /// Which lane this one is a copy of; itself if of none.
    fn copy_of(&self, lane: usize) -> usize {
        lane
    }
}

/// Trajectories in lanes, which know nothing of each other. It is also what tells of a lane what a sight asks.
///
/// An object, so that keeping account of lanes is compiled once, whatever moves them.
pub(in crate::run) trait Engine<const D: usize>:
    Copied<D> + Source<D> + Any + Send + Sync
{
    /// How many lanes there are.
    fn width(&self) -> usize;
    /// How many bodies a lane has.
    fn bodies_of_each(&self) -> usize {
        1
    }
    /// The engine where its lanes are after a tour, or one or more lanes that cannot go on it; never any if the tour is
    /// of no steps.
    fn go(&self, tour: &mut dyn Tour<D>) -> Result<Box<dyn Engine<D>>, Vec<Stuck>>;

    /// Puts bodies, which are along the constraint, into a lane. False where the lane cannot hold them, or their
    /// momenta would be no numbers there.
    fn set(&mut self, lane: usize, bodies: &[Body<f64, D>]) -> bool;
    /// Has lane `to` be where lane `from` is.
    fn copy(&mut self, from: usize, to: usize);
    /// Has it obey what that does.
    fn obey(&mut self, from: usize, to: usize);
    /// Has each lane obey what it does in another engine of this kind.
    fn obey_as_in(&mut self, engine: &dyn Engine<D>);

    /// The bodies of a lane.
    fn bodies(&self, lane: usize) -> Vec<Body<f64, D>>;
    /// Where bodies that obey what a lane does are after these steps by themselves: each step is looked at, and sums
    /// are compensated. `place` is how many flows acted where the first of these was tried before, and after it too.
    ///
    /// # Errors
    /// Says why they cannot be moved.
    fn by_itself(
        &self,
        lane: usize,
        bodies: &[Body<f64, D>],
        steps: OwnSteps,
        place: &mut u64,
    ) -> Result<Moved<D>, Trouble>;
    /// Whether steps can be repeated in parts.
    fn divides(&self) -> bool {
        true
    }
    /// Says of which trajectory a lane draws the random numbers, and where and when that starts.
    fn draw_as(&mut self, _lane: usize, _draws: Draws) {}
    /// The work of flows on a lane since the start, which is copied with it; none where there are no flows.
    fn work(&self, _lane: usize) -> Option<f64> {
        None
    }
    /// Says what that is.
    fn book(&mut self, _lane: usize, _work: f64) {}
    /// Evaluates the forces on all lanes, as often as a step does, for so many steps: for the [bill](crate::run::bill).
    fn kick_alone(&self, steps: u32);
    /// The names of the types of all forces.
    fn forces(&self) -> Vec<&'static str>;
    /// Writes the lanes, number by number.
    fn record(&self, to: &mut Record);
    /// An engine of the same laws that goes on from there.
    ///
    /// # Errors
    /// [`Error::Record`] where other lanes were written.
    fn recalled(&self, from: &mut Reading<'_>) -> Result<Box<dyn Engine<D>>, Error>;
    /// What tells what a lane obeys from other laws, asked there.
    fn hallmarks(&self, lane: usize, looks: &Looks<D>) -> Vec<Hallmark>;
    /// What tells the method from others.
    fn method(&self) -> Hallmark;
}

/// Engines are copied as objects.
pub(in crate::run) trait Copied<const D: usize> {
    /// A copy.
    fn boxed(&self) -> Box<dyn Engine<D>>;
}

impl<E: Engine<D> + Clone, const D: usize> Copied<D> for E {
    fn boxed(&self) -> Box<dyn Engine<D>> {
        Box::new(self.clone())
    }
}

impl<const D: usize> Clone for Box<dyn Engine<D>> {
    fn clone(&self) -> Self {
        (**self).boxed()
    }
}
