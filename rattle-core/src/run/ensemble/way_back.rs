//! Steps in lanes that are taken back, and compared with where they came from.

use crate::motion::bodies::Body;
use crate::number::clock::after_steps;
use crate::run::ensemble::engine::{Draws, Engine, Leg, Moved, Stuck, Tour};
use crate::run::ensemble::side_by_side::SideBySide;
use crate::run::reversal::compare;
use crate::run::trouble::Trouble;

/// What it takes to take steps in lanes back.
pub(super) struct WayBack<const D: usize> {
    pub(super) tolerance: f64,
    /// An engine of the same laws in steps of −h, made where it is asked for.
    backwards: Option<Box<dyn Engine<D>>>,
}

/// A lane about which a step by itself decides.
fn doubtful(lane: usize) -> Stuck {
    Stuck { lane, failure: None }
}

impl<const D: usize> Clone for WayBack<D> {
    fn clone(&self) -> Self {
        Self::new(self.tolerance)
    }
}

impl<const D: usize> WayBack<D> {
    pub(super) fn new(tolerance: f64) -> Self {
        Self { tolerance, backwards: None }
    }

    /// Has it forget what lanes obeyed.
    pub(super) fn forget(&mut self) {
        self.backwards = None;
    }
}

/// One step, after so many.
struct OneStep(Option<u64>);

impl<const D: usize> Tour<D> for OneStep {
    fn next(&mut self) -> Option<Leg<'_, D>> {
        let from = self.0.take()?;
        Some(Leg { from, steps: 1, written: None, shown: false })
    }
}

impl<const D: usize> SideBySide<D> {
    /// Takes the step to there back in lanes, if that is asked for.
    ///
    /// Lanes look closely at a step only where they begin anew, and so they do on the way back. Whether a step is
    /// taken must not depend on which of its ends it begins at: so it is made anew before it is taken back.
    ///
    /// # Errors
    /// The lanes that are not led to where they are now. A step by itself says whether it can be taken back.
    pub(super) fn look_back(&mut self, there: &dyn Engine<D>) -> Result<(), Vec<Stuck>> {
        let Some(WayBack { tolerance, mut backwards }) = self.way_back.take() else { return Ok(()) };
        match &mut backwards {
            Some(back) => self.date(&mut **back),
            none => *none = self.backwards(),
        }
        let mut anew = self.engine.boxed();
        let mut led = self.leads(&mut *anew, self.steps, [&*self.engine, there], tolerance);
        if led.is_ok() {
            led = match &mut backwards {
                Some(back) => self.leads(&mut **back, 0, [there, &*self.engine], tolerance),
                None => Err(self.own().map(doubtful).collect()),
            };
        }
        self.way_back = Some(WayBack { tolerance, backwards });
        led
    }

    /// The lanes that are copies of none.
    fn own(&self) -> impl Iterator<Item = usize> {
        (0..self.engine.width()).filter(|&lane| self.copy_of[lane] == lane)
    }

    /// Has lanes go the step after so many from one place, where they begin, to another.
    ///
    /// # Errors
    /// Those that do not get there.
    fn leads(
        &self,
        lanes: &mut dyn Engine<D>,
        from: u64,
        [begin, end]: [&dyn Engine<D>; 2],
        tolerance: f64,
    ) -> Result<(), Vec<Stuck>> {
        let lost = self.own().filter(|&lane| !lanes.set(lane, &begin.bodies(lane)));
        let mut lost = lost.map(doubtful).collect::<Vec<_>>();
        if lost.is_empty() {
            for lane in (0..lanes.width()).filter(|&lane| self.copy_of[lane] != lane) {
                lanes.copy(self.copy_of[lane], lane);
            }
            let off = |lanes: &dyn Engine<D>, lane: usize| {
                let (was, is) = (end.bodies(lane), lanes.bodies(lane));
                compare(was.len(), |i| [was[i], is[i]], true, tolerance).is_err()
            };
            lost = match lanes.go(&mut OneStep(Some(from))) {
                Ok(lanes) => self.own().filter(|&lane| off(&*lanes, lane)).map(doubtful).collect(),
                Err(stuck) => stuck.into_iter().map(|of| doubtful(of.lane)).collect(),
            };
        }
        if lost.is_empty() { Ok(()) } else { Err(lost) }
    }

    /// Takes the step of a lane that went by itself, in so many parts, back by itself, if that is asked for.
    ///
    /// # Errors
    /// [`Trouble::NotReversed`].
    pub(super) fn come_back(
        &self,
        lane: usize,
        was: &[Body<f64, D>],
        moved: Moved<D>,
        parts: u32,
    ) -> Result<Moved<D>, Trouble> {
        let Some(WayBack { tolerance, .. }) = self.way_back else { return Ok(moved) };
        let back = self.backwards();
        let is = back.and_then(|back| back.by_itself(lane, &moved.0, 0, 1, parts, &mut 0).ok());
        let at = |i: usize| [was[i], is.as_ref().map_or(was[i], |is| is.0[i])];
        compare(was.len(), at, is.is_some(), tolerance)?;
        Ok(moved)
    }

    /// An engine that leads lanes back from the end of the next step.
    fn backwards(&self) -> Option<Box<dyn Engine<D>>> {
        let mut back = self.engine.backwards()?;
        self.date(&mut *back);
        Some(back)
    }

    /// Says when the end of the next step is, to flows.
    fn date(&self, back: &mut dyn Engine<D>) {
        if back.work(0).is_none() {
            return;
        }
        for lane in 0..back.width() {
            let of = self.copy_of[lane];
            let time = after_steps(self.start_time[of], self.steps + 1, self.h);
            back.draw_as(lane, Draws { time, ..self.draws[of] });
        }
    }
}
