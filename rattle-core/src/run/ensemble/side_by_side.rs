//! A group of trajectories in lanes: failures, replacements of failed lanes, and observations.

use crate::error::Error;
use crate::motion::bodies::Body;
use crate::motion::failure::Failure;
use crate::motion::record::{Reading, Record};
use crate::motion::state::State;
use crate::number::clock::{after_steps, passed};
use crate::number::vectors::LANES;
use crate::run::bill::{Bill, Item, time};
use crate::run::ensemble::engine::{Draws, Engine, Leg, Moved, OwnSteps, Stuck, Tour, Written};
use crate::run::ensemble::group::Group;
use crate::run::ensemble::look::{Onlooker, Watched};
use crate::run::simulation::MOST_HALVINGS;
use crate::run::watch::seen::Page;
use crate::run::watch::sight::Source;
use rayon::prelude::*;
use std::array::from_fn;
use std::hint::black_box;
use std::mem::take;

/// Steps after which lanes are put back: what is gone through again when one fails.
pub(in crate::run) const STRETCH: u64 = 1024;

/// Steps that some lanes go side by side while others go by themselves.
const LEG: u64 = 64;

/// Steps that one goes by itself where other sheets were near, at most.
const CROWDED: u64 = 16 * STRETCH;

/// Steps of a copy that are timed for the bill.
const BILLED: u32 = 256;

/// Trajectories in the lanes of an engine.
#[derive(Clone)]
pub(super) struct SideBySide<const D: usize> {
    pub(super) engine: Box<dyn Engine<D>>,
    /// An engine whose lanes obey what they did at first: once trajectories have ended, their lanes obey what others
    /// do.
    pub(super) at_first: Option<Box<dyn Engine<D>>>,
    pub(super) h: f64,
    pub(super) steps: u64,
    /// Times of the starts, and what rounding took from them.
    pub(super) start_time: Vec<(f64, f64)>,
    /// By lane: where in the random numbers a trajectory starts.
    pub(super) draws: [Draws; LANES],
    /// By lane: whether a trajectory moves in it, else the lane that it is a copy of.
    pub(super) moving: [bool; LANES],
    pub(super) copy_of: [usize; LANES],
    pub(super) ended: Vec<Ended<D>>,
    /// By lane: whether it goes by itself, since other sheets are near or the lane cannot hold it, and where it is
    /// then; and when that ends.
    pub(super) crowded: [bool; LANES],
    pub(super) own: Vec<(usize, Vec<Body<f64, D>>)>,
    pub(super) crowded_until: u64,
    /// How often a step that cannot be taken is halved.
    pub(super) halvings: u32,
    /// If every step is to be taken back and compared, to which tolerance. Then all go by themselves: lanes look less
    /// closely at a step, so that a step that is taken might be refused on the way back.
    pub(super) checked: Option<f64>,
}

/// The trajectories that start so in the lanes of an engine, the first of which has this number; as many of them as
/// there are lanes.
#[inline(never)]
pub(super) fn side_by_side<const D: usize>(
    engine: Box<dyn Engine<D>>,
    first: usize,
    starts: &[State<D>],
) -> Box<dyn Group<D>> {
    Box::new(SideBySide::new(engine, first, starts))
}

/// A trajectory that goes on no more.
#[derive(Clone)]
pub(super) struct Ended<const D: usize> {
    pub(super) lane: usize,
    pub(super) steps: u64,
    pub(super) bodies: Vec<Body<f64, D>>,
    pub(super) work: f64,
    pub(super) failure: Error,
}

impl<const D: usize> SideBySide<D> {
    /// See [`side_by_side`].
    fn new(engine: Box<dyn Engine<D>>, first: usize, starts: &[State<D>]) -> Self {
        let number = starts.len().min(engine.width());
        let start_time = starts.iter().map(|start| (start.time, start.time_low)).collect();
        let draws = from_fn(|lane| {
            let start = starts.get(lane).or(starts.first());
            let (number, steps) = start.map_or((None, 0), |start| (start.number, start.steps));
            let trajectory = number.unwrap_or((first + lane) as u64);
            let time = start.map_or((0.0, 0.0), |start| (start.time, start.time_low));
            Draws { trajectory, numbered: number.is_some(), steps, time }
        });
        let mut group = Self {
            h: engine.step_size(),
            engine,
            at_first: None,
            steps: 0,
            start_time,
            draws,
            moving: from_fn(|lane| lane < number),
            copy_of: from_fn(|lane| if lane < number { lane } else { 0 }),
            ended: Vec::new(),
            crowded: [false; LANES],
            own: Vec::new(),
            crowded_until: 1,
            halvings: 0,
            checked: None,
        };
        for (lane, start) in starts.iter().enumerate().take(number) {
            group.engine.draw_as(lane, group.draws[lane]);
            group.set(lane, &start.bodies);
        }
        for lane in number..group.engine.width() {
            group.put_copy(0, lane);
        }
        group
    }

    /// Puts bodies, which are along the constraint, into a lane; and beside it where other sheets are near, or where
    /// the lane cannot hold them.
    fn set(&mut self, lane: usize, bodies: &[Body<f64, D>]) {
        let holds = self.engine.set(lane, bodies);
        self.own.retain(|own| own.0 != lane);
        self.crowded[lane] |= !holds;
        if self.crowded[lane] {
            self.own.push((lane, bodies.to_vec()));
        }
    }

    /// Has lane `to` be where lane `from` is, and obey what that does.
    fn put_copy(&mut self, from: usize, to: usize) {
        self.engine.copy(from, to);
        self.engine.obey(from, to);
    }

    /// Has all go side by side again that lanes have a place for.
    fn disperse(&mut self) {
        self.crowded.fill(false);
        for (lane, bodies) in std::mem::take(&mut self.own) {
            self.set(lane, &bodies);
        }
    }

    /// Takes so many steps, or none if a lane fails on the way; but what was shown on the way was shown. `shown` says
    /// that the end will be.
    fn attempt(
        &mut self,
        steps: u64,
        shown: bool,
        mut onlooker: Option<&mut Onlooker<'_, D>>,
    ) -> Result<(), Vec<Stuck>> {
        let (now, end) = (self.steps, self.steps + steps);
        let seen = onlooker.as_deref_mut();
        let gone = self.engine.go(&mut Stretch { group: self, onlooker: seen, now, end, shown });
        if let (Err(_), Some(onlooker)) = (&gone, onlooker) {
            onlooker.forget();
        }
        self.engine = gone?;
        self.steps = end;
        Ok(())
    }

    /// Where a trajectory is.
    pub(super) fn bodies_in(&self, lane: usize) -> Vec<Body<f64, D>> {
        let own = self.own.iter().find(|own| own.0 == lane);
        own.map_or_else(|| self.engine.bodies(lane), |own| own.1.clone())
    }

    /// Writes those that go by themselves, and those that go on no more.
    fn write_apart(&self, Page { times, positions, momenta }: Page<'_, D>) {
        let mut write = |lane: usize, bodies: &[Body<f64, D>]| {
            for (i, Body { q, p, .. }) in (bodies.len() * lane..).zip(bodies) {
                (positions[i], momenta[i]) = ((*q).into(), (*p).into());
            }
        };
        self.own.iter().for_each(|(lane, bodies)| write(*lane, bodies));
        for Ended { lane, bodies, .. } in &self.ended {
            times[*lane] = self.time(*lane).0;
            write(*lane, bodies);
        }
    }

    /// Takes so many steps with all lanes that can be moved, be it by themselves or in parts.
    fn go_on(&mut self, steps: u64, mut onlooker: Option<&mut Onlooker<'_, D>>) {
        let end = self.steps + steps;
        while self.steps < end {
            let next = onlooker.as_ref().map(|onlooker| onlooker.next);
            let leg = (LEG - self.steps % LEG).min(next.map_or(end, |next| next.min(end)) - self.steps);
            let shown = |after: u64| next == Some(after);
            if !self.leg(leg, shown(self.steps + leg)) {
                for _ in 0..leg {
                    self.leg(1, shown(self.steps + 1)); // who cannot take it ends
                }
            }
            if let Some(onlooker) = &mut onlooker
                && onlooker.next == self.steps
            {
                self.look(onlooker.write());
                onlooker.show(self, |_| ());
            }
        }
    }

    /// Takes so many steps with all lanes that can be moved: side by side, or by themselves where other sheets are
    /// near, or, if it is a single step, in parts. False, and as if none were taken, where one of several cannot.
    /// `shown` says that the end will be.
    fn leg(&mut self, steps: u64, shown: bool) -> bool {
        let before = (self.engine.clone(), self.copy_of);
        let (now, end, mut together) = (self.steps, self.steps + steps, self.moving);
        let (mut apart, mut fails) = (Vec::new(), false);
        let alone: Vec<_> =
            (0..self.engine.width()).filter(|&lane| together[lane] && self.crowded[lane]).collect();
        let mut stuck: Vec<_> = alone.into_iter().map(|lane| Stuck { lane, failure: None }).collect();
        loop {
            let mut own = Vec::new();
            for of in stuck.drain(..) {
                if take(&mut together[of.lane]) {
                    self.crowded[of.lane] |= of.failure.is_none();
                    own.push(of);
                } // else told of a copy, too
            }
            for (lane, moved) in self.by_themselves(own, steps) {
                match moved {
                    Ok(moved) => apart.push((lane, moved)),
                    Err(_) if steps > 1 => fails = true, // but it is still seen who else is in a crowd
                    Err(failure) => self.end(lane, failure),
                }
            }
            self.stand_in(&together);
            if !together.contains(&true) {
                break;
            }
            match self.attempt(steps, shown, None) {
                Ok(()) => break,
                Err(some) => {
                    stuck.extend(some.into_iter().map(|of| Stuck { lane: self.copy_of[of.lane], ..of }))
                }
            }
        }
        if fails {
            (self.engine, self.copy_of, self.steps) = (before.0, before.1, now);
            return false;
        }
        if !apart.is_empty() {
            self.engine.obey_as_in(&*before.0);
            for (lane, (bodies, work)) in apart {
                self.set(lane, &bodies);
                self.engine.book(lane, work);
            }
            self.stand_in(&self.moving.clone());
        }
        if self.at_first.is_none() && !self.ended.is_empty() {
            self.at_first = Some(before.0);
        }
        self.steps = end;
        true
    }

    /// Fills the lanes that are not among these with copies of one that is.
    fn stand_in(&mut self, among: &[bool; LANES]) {
        let Some(other) = among.iter().position(|&is| is) else { return };
        self.copy_of = from_fn(|lane| if among[lane] { lane } else { other });
        for lane in (0..self.engine.width()).filter(|&lane| !among[lane]) {
            self.put_copy(other, lane);
        }
    }

    /// Has a trajectory rest where it is.
    fn end(&mut self, lane: usize, failure: Error) {
        let (bodies, work) = (self.bodies_in(lane), self.engine.work(lane).unwrap_or(0.0));
        self.ended.push(Ended { lane, steps: self.steps, bodies, work, failure });
        (self.moving[lane], self.crowded[lane]) = (false, false);
        self.own.retain(|own| own.0 != lane);
    }

    /// Where these trajectories are after so many steps by themselves; on all cores where that is what all do.
    fn by_themselves(&self, stuck: Vec<Stuck>, steps: u64) -> Vec<(usize, Result<Moved<D>, Error>)> {
        let moved = |Stuck { lane, failure }| (lane, self.by_itself(lane, failure, steps));
        match self.checked {
            Some(_) => stuck.into_par_iter().map(moved).collect(),
            None => stuck.into_iter().map(moved).collect(),
        }
    }

    /// Where a trajectory is after so many steps by itself, or if it failed in one, after that in parts, as often
    /// halved as is allowed; and the work on it since the start.
    #[cold]
    fn by_itself(&self, lane: usize, failure: Option<Failure>, steps: u64) -> Result<Moved<D>, Error> {
        if let (Some(Failure { body, cause }), true) = (&failure, steps > 1) {
            // Who cannot go on takes that one step by itself, wherever the run is divided.
            let (step, time) = (self.steps + 1, self.time(lane).0);
            return Err(Error::Step { step, time, body: *body, cause: cause.clone() });
        }
        let (bodies, mut place) = (self.bodies_in(lane), 0);
        let mut moved = |parts| {
            let steps = OwnSteps { from: self.steps, number: steps, parts, checked: self.checked };
            self.engine.by_itself(lane, &bodies, steps, &mut place)
        };
        // Flows that act in parts of a step draw what comes after that of the whole step. Of momenta that are drawn it
        // is said by itself why they lead nowhere.
        let failure = failure.filter(|_| self.engine.work(lane).is_none() && self.engine.divides());
        let mut trouble = match failure.map_or_else(|| moved(1), |failure| Err(failure.into())) {
            Ok(moved) => return Ok(moved),
            Err(trouble) => trouble,
        };
        for halved in 1..=if steps == 1 { self.halvings } else { 0 } {
            match moved(1 << halved) {
                Ok(moved) => return Ok(moved),
                Err(again) => trouble = again,
            }
        }
        Err(trouble.halved(self.halvings).told(self.steps + 1, self.time(lane).0))
    }

    /// The time of a trajectory, and what rounding took from it.
    fn time(&self, lane: usize) -> (f64, f64) {
        after_steps(self.start_time[lane], self.steps_of(lane), self.h)
    }

    /// The steps of a trajectory since its start here.
    fn steps_of(&self, lane: usize) -> u64 {
        self.ended(lane).map_or(self.steps, |ended| ended.steps)
    }

    fn ended(&self, lane: usize) -> Option<&Ended<D>> {
        self.ended.iter().find(|ended| ended.lane == lane)
    }
}

/// Some steps, with stops where an onlooker wants to see.
struct Stretch<'a, 'b, const D: usize> {
    group: &'a SideBySide<D>,
    onlooker: Option<&'a mut Onlooker<'b, D>>,
    now: u64,
    end: u64,
    /// Whether the onlooker is to be shown what is written; without one, whether the end will be shown.
    shown: bool,
}

impl<const D: usize> Tour<D> for Stretch<'_, '_, D> {
    fn next(&mut self) -> Option<Leg<'_, D>> {
        let Self { group, onlooker, now, end, shown } = self;
        if let Some(onlooker) = onlooker
            && *shown
        {
            onlooker.show(*group, |page| group.write_apart(page));
        }
        let (from, due) = (*now, onlooker.as_ref().map(|onlooker| onlooker.due()));
        let stop = due.map_or(*end, |due| due.min(*end));
        if from == *end {
            return None;
        }
        *now = stop;
        if let Some(onlooker) = onlooker {
            *shown = onlooker.shows(stop, *end);
        }
        let passed = passed(stop, group.h);
        let page = onlooker.as_mut().filter(|_| due == Some(stop)).map(|onlooker| onlooker.write());
        let written = page.map(|page| Written { page, starts: &group.start_time, passed });
        Some(Leg { from, steps: stop - from, written, shown: *shown })
    }

    fn copy_of(&self, lane: usize) -> usize {
        self.group.copy_of[lane]
    }
}

/// No step at all.
struct Look<'a, const D: usize>(Option<Written<'a, D>>);

impl<const D: usize> Tour<D> for Look<'_, D> {
    fn next(&mut self) -> Option<Leg<'_, D>> {
        self.0.take().map(|written| Leg { from: 0, steps: 0, written: Some(written), shown: true })
    }
}

impl<const D: usize> Group<D> for SideBySide<D> {
    fn run(&mut self, steps: u64, mut onlooker: Option<&mut Onlooker<'_, D>>) {
        let end = self.steps.saturating_add(steps);
        while self.steps < end && self.moving.contains(&true) {
            let stretch = STRETCH.min(end - self.steps);
            if self.steps / CROWDED >= self.crowded_until && self.checked.is_none() {
                self.crowded_until = self.steps / CROWDED + 1;
                self.disperse();
            }
            if self.crowded.contains(&true) || self.attempt(stretch, false, onlooker.as_deref_mut()).is_err()
            {
                self.go_on(stretch, onlooker.as_deref_mut());
            }
        }
        self.steps = end;
    }

    fn retry(&mut self, halvings: u32) {
        self.halvings = if self.engine.divides() { halvings.min(MOST_HALVINGS) } else { 0 };
    }

    fn state(&self, trajectory: usize) -> State<D> {
        let ended = self.ended(trajectory).map(|ended| ended.bodies.clone());
        let bodies = ended.unwrap_or_else(|| self.bodies_in(trajectory));
        let ((time, time_low), draws) = (self.time(trajectory), self.draws[trajectory]);
        let steps = draws.steps.wrapping_add(self.steps_of(trajectory));
        let number = draws.numbered.then_some(draws.trajectory);
        let none: [[f64; D]; 0] = [];
        State { bodies, time, time_low, steps, number, ..State::of(none) }
    }

    fn record(&self, to: &mut Record) {
        self.write_record(to);
    }

    fn recalled(&self, from: &mut Reading<'_>) -> Result<Box<dyn Group<D>>, Error> {
        Ok(Box::new(self.read_record(from)?))
    }

    fn check_reversal(&mut self, tolerance: f64) -> Result<(), Error> {
        self.checked = Some(tolerance);
        for lane in
            (0..self.len()).filter(|&lane| self.moving[lane] && !self.crowded[lane]).collect::<Vec<_>>()
        {
            self.own.push((lane, self.engine.bodies(lane)));
            self.crowded[lane] = true;
        }
        Ok(())
    }

    fn failure(&self, trajectory: usize) -> Option<&Error> {
        self.ended(trajectory).map(|ended| &ended.failure)
    }

    fn work(&self, trajectory: usize) -> f64 {
        let ended = self.ended(trajectory).map(|ended| ended.work);
        ended.or_else(|| self.engine.work(trajectory)).unwrap_or(0.0)
    }

    fn bill(&self) -> Result<Bill, Error> {
        let trajectories = self.moving.iter().filter(|&&moves| moves).count();
        let each = 1.0 / (trajectories as f64 * f64::from(BILLED));
        let copying = time(&mut || drop(black_box(self.clone())));
        let running = time(&mut || self.clone().run(u64::from(BILLED), None));
        let step = each * (running - copying).max(0.0);
        let mut items = Vec::new();
        if self.checked.is_some() {
            return Ok(Bill::new(step, items, "steps by themselves, that are taken back".to_string(), 1));
        }
        let names = self.engine.forces();
        if !names.is_empty() {
            let nanoseconds = each * time(&mut || self.engine.kick_alone(BILLED));
            items.push(Item::of_force(&names.join("`, `"), nanoseconds));
        }
        let rest = "places and constraints, side by side".to_string();
        Ok(Bill { side_by_side: trajectories, ..Bill::new(step, items, rest, 1) })
    }
}

impl<const D: usize> Watched<D> for SideBySide<D> {
    fn len(&self) -> usize {
        self.start_time.len()
    }

    fn bodies(&self) -> usize {
        self.engine.bodies_of_each()
    }

    fn look(&self, Page { times, positions, momenta }: Page<'_, D>) {
        let page = Page { times: &mut *times, positions: &mut *positions, momenta: &mut *momenta };
        let (starts, passed) = (&self.start_time[..], passed(self.steps, self.h));
        let stayed = self.engine.go(&mut Look(Some(Written { page, starts, passed })));
        debug_assert!(stayed.is_ok(), "no step is taken that could fail");
        self.write_apart(Page { times, positions, momenta });
    }

    fn moving(&self) -> &[bool] {
        &self.moving
    }

    fn source(&self) -> &dyn Source<D> {
        &*self.engine
    }
}
