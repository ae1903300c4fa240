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

/// One step, after none.
struct OneStep(bool);

impl<const D: usize> Tour<D> for OneStep {
    fn next(&mut self) -> Option<Leg<'_, D>> {
        let goes = std::mem::take(&mut self.0);
        goes.then_some(Leg { from: 0, steps: 1, written: None, shown: false })
    }
}

impl<const D: usize> SideBySide<D> {
    /// Takes the step to there back in lanes, if that is asked for.
    ///
    /// Lanes look closely at a step where they begin anew, as they do on the way back, and not within a run. Whether a
    /// step is taken must not depend on which of its ends it begins at, so it is looked at as a first one, too.
    ///
    /// # Errors
    /// The lanes that cannot begin here, or are not led back. A step by itself says whether it can be taken back.
    pub(super) fn look_back(&mut self, there: &dyn Engine<D>) -> Result<(), Vec<Stuck>> {
        let Some(WayBack { tolerance, mut backwards }) = self.way_back.take() else { return Ok(()) };
        match &mut backwards {
            Some(back) => self.date(&mut **back),
            none => *none = self.backwards(),
        }
        let led = match &mut backwards {
            Some(back) => self.leads_back(&mut **back, there, tolerance),
            None => Err(self.own().map(doubtful).collect()),
        };
        self.way_back = Some(WayBack { tolerance, backwards });
        led
    }

    /// The lanes that are copies of none.
    fn own(&self) -> impl Iterator<Item = usize> {
        (0..self.engine.width()).filter(|&lane| self.copy_of[lane] == lane)
    }

    fn leads_back(
        &self,
        back: &mut dyn Engine<D>,
        there: &dyn Engine<D>,
        tolerance: f64,
    ) -> Result<(), Vec<Stuck>> {
        let (mut anew, mut begin, mut lost) = (self.engine.boxed(), Vec::new(), Vec::new());
        for lane in self.own() {
            let bodies = self.engine.bodies(lane);
            if !(anew.set(lane, &bodies) && back.set(lane, &there.bodies(lane))) {
                lost.push(doubtful(lane));
            }
            begin.push(bodies);
        }
        if lost.is_empty() {
            for lane in (0..back.width()).filter(|&lane| self.copy_of[lane] != lane) {
                back.copy(self.copy_of[lane], lane);
            }
            let off = |back: &dyn Engine<D>, lane: usize, was: &[Body<f64, D>]| {
                let is = back.bodies(lane);
                compare(was.len(), |i| [was[i], is[i]], true, tolerance).is_err()
            };
            lost = match back.go(&mut OneStep(true)) {
                Ok(back) => {
                    let off = self.own().zip(&begin).filter(|(lane, was)| off(&*back, *lane, was));
                    off.map(|(lane, _)| doubtful(lane)).collect()
                }
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
