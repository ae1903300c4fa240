//! What moves trajectories on, side by side. Which of them fail, what stands in for them and what is shown is not its
//! concern.

use crate::error::Error;
use crate::motion::bodies::Body;
use crate::motion::failure::Failure;
use crate::motion::record::{Hallmark, Reading, Record};
use crate::number::clock::later;
use crate::number::lanes::Lane;
use crate::run::ensemble::laws::Laws;
use crate::run::watch::seen::Page;

/// A lane that cannot be moved, and why; without a failure where other sheets are near, and each step has to be looked
/// at.
pub(crate) struct Stuck {
    pub(crate) lane: usize,
    pub(crate) failure: Option<Failure>,
}

/// Where all lanes are to be written, and what is needed for their times: those of the starts, the time since then, and
/// what rounding took from each.
pub(crate) struct Written<'a, const D: usize> {
    pub(crate) page: Page<'a, D>,
    pub(crate) starts: &'a [(f64, f64)],
    pub(crate) passed: (f64, f64),
}

impl<const D: usize> Written<'_, D> {
    /// Writes times, and positions and momenta of L lanes in turn.
    #[inline(always)]
    pub(crate) fn fill<const L: usize>(self, q: impl Fn(usize) -> [f64; D], p: impl Fn(usize) -> [f64; D]) {
        let Self { page: Page { times, positions, momenta }, starts, passed } = self;
        for (lane, place) in positions.iter_mut().enumerate().take(L) {
            *place = q(lane).into();
        }
        for (lane, way) in momenta.iter_mut().enumerate().take(L) {
            *way = p(lane).into();
        }
        times.iter_mut().zip(starts).for_each(|(time, &start)| *time = later(start, passed).0);
    }
}

/// So many steps, after so many since the start, and where all lanes are to be written after them, if they are.
pub(crate) struct Leg<'a, const D: usize> {
    pub(crate) from: u64,
    pub(crate) steps: u64,
    pub(crate) written: Option<Written<'a, D>>,
}

/// Where lanes are to go, leg by leg.
pub(crate) trait Tour<const D: usize> {
    /// Shows what was written after the leg before, and says what the next one is.
    fn next(&mut self) -> Option<Leg<'_, D>>;
}

/// Trajectories of one body each in lanes, which know nothing of each other.
pub(crate) trait Engine<const D: usize>: Clone + Send + Sync {
    /// How many lanes there are.
    const WIDTH: usize;
    /// What moves.
    type Lanes;
    /// What they are numbers of.
    type Scalar: Lane;
    /// What the lanes obey.
    type Laws: Laws<Self::Scalar, D>;

    /// Where the lanes are after a tour, on which the engine itself stays where it is.
    fn go(&self, tour: &mut dyn Tour<D>) -> Result<Self::Lanes, Stuck>;
    /// Where they are now.
    fn lanes(&self) -> Self::Lanes;
    /// Goes on from there.
    fn keep(&mut self, lanes: Self::Lanes);

    /// Puts a body, which is along the constraint, into a lane. False where the lane cannot hold it.
    fn set(&mut self, lane: usize, body: &Body<f64, D>) -> bool;
    /// Has lane `to` be, and obey, what lane `from` does.
    fn copy(&mut self, from: usize, to: usize);
    /// What the lanes obey.
    fn laws(&self) -> &Self::Laws;
    /// The same, to be changed.
    fn laws_mut(&mut self) -> &mut Self::Laws;

    /// The body of a lane.
    fn body(&self, lane: usize) -> Body<f64, D>;
    /// Where a body that obeys what a lane does is after so many steps, each in so many equal parts, by itself: each is
    /// looked at, and sums are compensated.
    ///
    /// # Errors
    /// Says why it cannot be moved.
    fn by_itself(
        &self,
        lane: usize,
        body: &Body<f64, D>,
        steps: u64,
        parts: u32,
    ) -> Result<Body<f64, D>, Failure>;
    /// Evaluates the forces on all lanes, as often as a step does, for so many steps: for the [bill](crate::run::bill).
    fn kick_alone(&self, steps: u32);
    /// Writes the lanes, number by number.
    fn record(&self, to: &mut Record);
    /// An engine of the same laws that goes on from there.
    ///
    /// # Errors
    /// [`Error::Record`] where other lanes were written.
    fn recalled(&self, from: &mut Reading<'_>) -> Result<Self, Error>
    where
        Self: Sized;
    /// What tells the method from others.
    fn method(&self) -> Hallmark;
}
