//! Steps of rows of linked bodies with flows of momenta, compiled once here.
//!
//! Kicks of two steps are not merged where flows act between them, and first guesses after a flow are Λ = 0: what flows
//! have changed is not extrapolated. Normals are evaluated again before flows act at the start of a step, so that bits
//! depend on no division of a run.

use crate::number::instructions::Work;
use crate::run::ensemble::block::Part;
use crate::run::ensemble::engine::Stuck;
use crate::run::ensemble::forces_in_lanes::Pulling;
use crate::run::ensemble::linked_plan::{LinkedPlan, Places};
use crate::run::ensemble::linked_row::{Apart, Course, LinkedRow};
use crate::run::ensemble::linked_stirring::{Answer, RowStirring};
use crate::run::ensemble::rhythm::{InRhythm, When};
use crate::run::ensemble::stirred::LARGER;
use crate::solve::crowd::EVERY;
use crate::systems::network::in_lanes::{Numbers, Which, lost, ran_away, zeros};
use std::array::from_fn;

/// Some steps of a row with flows, after so many.
pub(super) struct StirredSteps<'a, 'b, const W: usize> {
    pub(super) course: &'a Course<'b, W>,
    pub(super) stirring: &'a RowStirring<W>,
    /// The kick that follows the half of flows before a step.
    pub(super) kick: f64,
    pub(super) pulling: Option<&'a mut (dyn Pulling<LinkedRow, W> + 'b)>,
    pub(super) apart: &'a mut Apart<'b, W>,
    pub(super) answer: &'a mut Answer<'b, W>,
    /// All numbers, those of one step too.
    pub(super) numbers: &'a mut [Numbers<W>],
    /// The work of flows on each lane, and the speed beyond which it is asked at once whether other sheets are near.
    pub(super) work: &'a mut [f64],
    pub(super) limits: &'a mut [f64],
    pub(super) from: u64,
    pub(super) steps: u64,
    /// Whether it is to be asked at the end whether other sheets are near.
    pub(super) looks: bool,
}

impl<const W: usize> Work for StirredSteps<'_, '_, W> {
    type Done = Result<(), Stuck>;

    #[inline(always)]
    fn run(mut self) -> Result<(), Stuck> {
        if self.steps == 0 {
            return Ok(());
        }
        let (from, end, looks) = (self.from, self.from + self.steps, self.looks);
        let Places { q, trial, .. } = self.course.plan.places;
        let (stirring, n, parts) = (self.stirring, self.course.plan.coordinates, self.course.parts.len());
        self.numbers.copy_within(q..q + n, trial); // where pinned bodies stay
        if from == 0 {
            if self.stirring.rhythm.renews {
                self.forget();
            }
            self.look_around(0, &[1; W])?;
        }
        self.evaluate();
        for now in from..end {
            stirring.rhythm.step(&mut self, now, parts)?;
            let taken = now + 1;
            if taken % EVERY == 0 {
                self.course.rest(self.numbers);
            }
            if taken % EVERY == 0 || (looks && taken == end) {
                self.look_around(taken, &[1; W])?;
                self.evaluate();
            }
        }
        if stirring.rhythm.renews {
            return self.check();
        }
        self.course.check(self.numbers)
    }
}

impl<const W: usize> InRhythm for StirredSteps<'_, '_, W> {
    #[inline(always)]
    fn act(&mut self, when: When) -> Result<(), Stuck> {
        let Self { course, stirring, numbers, work, answer, .. } = self;
        let acted = stirring.act(course, when, numbers, work, answer);
        acted.map_err(|lane| Stuck { lane, failure: None })
    }

    #[inline(always)]
    fn lead(&mut self) -> Result<(), Stuck> {
        let Self { course, kick, numbers, pulling, .. } = self;
        if *kick != 0.0 && pulling.is_some() {
            let Places { way, way_low, .. } = course.plan.places;
            course.kick(*kick, if course.sums { way_low } else { way }, numbers, pulling);
            course.project(numbers);
        }
        self.guess(0)
    }

    #[inline(always)]
    fn advance(&mut self, part: usize, _: u64) -> Result<(), Stuck> {
        let Self { course, numbers, pulling, apart, .. } = self;
        course.advance(&course.parts[part], numbers, pulling, *apart)
    }

    #[inline(always)]
    fn guess(&mut self, _: usize) -> Result<(), Stuck> {
        let guess = self.course.plan.places.guess;
        self.numbers[guess..guess + self.course.plan.equations].fill(zeros());
        self.heed()
    }

    #[inline(always)]
    fn forget(&mut self) {
        let LinkedPlan { coordinates, equations, places, .. } = self.course.plan;
        let &Places { way, way_low, guess, last, earlier, .. } = places;
        self.numbers[way..way + coordinates].fill(zeros());
        if self.course.sums {
            self.numbers[way_low..way_low + coordinates].fill(zeros());
        }
        for numbers in [guess, last, earlier] {
            self.numbers[numbers..numbers + equations].fill(zeros());
        }
    }
}

impl<const W: usize> StirredSteps<'_, '_, W> {
    /// Evaluates G where bodies are, as each step leaves it.
    #[inline(always)]
    fn evaluate(&mut self) {
        let Self { course, numbers, .. } = self;
        course.links.gradients(course.plan, course.set, course.plan.places.q, numbers);
        course.plan.lift(course.over, numbers);
    }

    /// Whether places and the forces there are numbers, momenta being forgotten.
    #[inline(always)]
    fn check(&mut self) -> Result<(), Stuck> {
        let (Places { q, way, .. }, n) = (self.course.plan.places, self.course.plan.coordinates);
        if self.pulling.is_some() {
            self.course.kick(self.kick, way, self.numbers, &mut self.pulling);
        }
        let rows = self.numbers[q..q + n].iter().chain(&self.numbers[way..way + n]);
        let lost = lost(rows).or_else(|| ran_away(&self.numbers[q..q + n]));
        self.forget();
        lost.map_or(Ok(()), |lane| Err(Stuck::not_finite(lane)))
    }

    /// Asks whether other sheets are near these lanes, after so many steps, and sets their limits.
    #[inline(always)]
    fn look_around(&mut self, steps: u64, lanes: &Which<W>) -> Result<(), Stuck> {
        let Self { course, stirring, kick, numbers, pulling, limits, .. } = self;
        let part = Part { kick: course.parts[0].kick.max(*kick), ..course.parts[0] };
        course.look_around((steps, lanes), &part, &stirring.least, numbers, pulling)?;
        let way = course.plan.places.way;
        let fastest = stirring.fastest(&numbers[way..way + course.plan.coordinates], true);
        for (l, limit) in limits.iter_mut().enumerate().filter(|&(l, _)| lanes[l] != 0) {
            *limit = LARGER * fastest[l];
        }
        Ok(())
    }

    /// The same at once, at as many places as at first, for lanes that are faster than their limits; for no others, so
    /// that what becomes of a lane depends on that lane alone.
    #[inline(always)]
    fn heed(&mut self) -> Result<(), Stuck> {
        let way = self.course.plan.places.way;
        let fastest = self.stirring.fastest(&self.numbers[way..way + self.course.plan.coordinates], false);
        let mut within = true;
        for (limit, fastest) in self.limits.iter().zip(fastest) {
            within &= fastest <= *limit;
        }
        if within {
            return Ok(());
        }
        let beyond = from_fn(|l| u64::from(self.limits[l] < fastest[l]));
        self.look_around(0, &beyond)
    }
}
