//! Where a row of linked bodies stands at the start of an inner step, and how a method tells where such a step leads
//! regardless of the constraints. What becomes of that is the same for all
//! ([`linked_projected`](crate::run::ensemble::linked_projected)).

use crate::motion::method::Method;
use crate::number::instructions::Work;
use crate::run::ensemble::forces_in_lanes::Pulling;
use crate::run::ensemble::linked_plan::Places;
use crate::run::ensemble::linked_row::{Course, LinkedRow};
use crate::run::ensemble::pace::Pace;
use crate::run::ensemble::track::{Track, choose};
use crate::systems::network::in_lanes::{Numbers, Which, zeros};
use std::array::from_fn;

/// Effects that pull bodies, if any do.
pub(super) type Pulls<'a, 'b, const W: usize> = Option<&'a mut (dyn Pulling<LinkedRow, W> + 'b)>;

/// A method whose steps are projected, in rows of linked bodies.
pub(super) trait Departs<const W: usize> {
    /// Writes where inner steps of all lanes lead regardless of the constraints, with what rounding takes from that, to
    /// `q` and `way` of the [numbers](Stand::numbers). Says how long these steps are and whether they are taken.
    fn depart(&mut self, stand: &mut Stand<'_, W>, pulling: &mut Pulls<'_, '_, W>);

    /// Whether where it leads is on the constraints but for rounding, which is then left as it is: moved, places would
    /// be of other multipliers than velocities are, and energies drift. Lanes that are farther off go by themselves.
    fn lands(&self) -> bool {
        false
    }

    /// Kicks velocities where inner steps led, before these are projected there.
    fn kick(&mut self, _: &mut Stand<'_, W>, _: &mut Pulls<'_, '_, W>) {}

    /// Has lanes go by themselves in which the accelerations at the end are not those that the method knows; the
    /// numbers are those of the end.
    fn compare(&mut self, _: &mut Stand<'_, W>) {}
}

/// Where the bodies of a row are.
pub(super) struct Stand<'a, const W: usize> {
    pub(super) course: Course<'a, W>,
    pub(super) pace: Pace<W>,
    /// Coordinates of a body.
    pub(super) dimension: usize,
    /// Numbers of the plan: bodies at a stage, or on trial.
    pub(super) numbers: Vec<Numbers<W>>,
    /// Places and velocities; and accelerations and G where they are, once they have been evaluated.
    pub(super) tracks: [Track<W>; 2],
    pub(super) there: bool,
    pub(super) pull: Vec<Numbers<W>>,
    pub(super) normals: Vec<Numbers<W>>,
    /// What a method remembers from step to step, and λ where bodies are; nothing where it remembers nothing. The first
    /// number is 0 in lanes that have no step to remember.
    pub(super) past: Vec<Numbers<W>>,
    pub(super) multipliers: Vec<Numbers<W>>,
    /// M⁻¹f of places on trial, and whether it was evaluated there.
    pub(super) pulled: Vec<Numbers<W>>,
    is_pulled: bool,
    /// Two numbers of each equation.
    pub(super) of_equations: [Vec<Numbers<W>>; 2],
}

impl<'a, const W: usize> Stand<'a, W> {
    /// For bodies of so many coordinates, and steps of this method, which remembers so many numbers.
    pub(super) fn new(
        course: Course<'a, W>,
        method: &impl Method,
        dimension: usize,
        remembered: usize,
    ) -> Self {
        let plan = course.plan;
        let (n, m, entries) = (plan.coordinates, plan.equations, plan.of_entry.len());
        let rows = |number: usize| vec![zeros::<W>(); number];
        Self {
            course,
            pace: Pace::new(method),
            dimension,
            numbers: rows(plan.places.end),
            tracks: from_fn(|_| Track::new(n)),
            there: false,
            pull: rows(n),
            normals: rows(entries),
            past: rows(remembered),
            multipliers: rows(if remembered == 0 { 0 } else { m }),
            pulled: rows(if remembered == 0 { 0 } else { n }),
            is_pulled: false,
            of_equations: [rows(m), rows(m)],
        }
    }

    /// Has coordinate `c` be on trial where these changes of its place and its velocity lead.
    #[inline(always)]
    pub(super) fn arrive(&mut self, c: usize, changes: [&Numbers<W>; 2]) {
        let Places { q, q_low, way, way_low, .. } = self.course.plan.places;
        for ((track, by), [high, low]) in self.tracks.iter().zip(changes).zip([[q, q_low], [way, way_low]]) {
            let (mut sum, mut rest) = (zeros(), zeros());
            track.arrive(c, by, &mut sum, &mut rest);
            (self.numbers[high + c], self.numbers[low + c]) = (sum, rest);
        }
    }

    /// Accelerations and normals where all bodies are.
    #[inline(always)]
    pub(super) fn be_there(&mut self, pulling: &mut Pulls<'_, '_, W>) {
        let Places { q, way, gradient, change, .. } = self.course.plan.places;
        let (n, entries) = (self.pull.len(), self.normals.len());
        self.numbers[q..q + n].copy_from_slice(&self.tracks[0].now);
        self.numbers[way..way + n].copy_from_slice(&self.tracks[1].now);
        self.respond(true, pulling);
        self.there = true;
        self.pull.copy_from_slice(&self.numbers[change..change + n]);
        self.normals.copy_from_slice(&self.numbers[gradient..gradient + entries]);
        self.take_multipliers(&[1; W]);
    }

    /// Takes over λ of these lanes, from accelerations that were just evaluated.
    #[inline(always)]
    pub(super) fn take_multipliers(&mut self, lanes: &Which<W>) {
        let x = self.course.plan.places.x;
        for (i, multiplier) in self.multipliers.iter_mut().enumerate() {
            choose(lanes, &-self.numbers[x + i], multiplier);
        }
    }

    /// Writes accelerations at the places and velocities on trial to `change`; `afresh` with the normals and the matrix
    /// of these places, which else are known.
    #[inline(always)]
    pub(super) fn respond(&mut self, afresh: bool, pulling: &mut Pulls<'_, '_, W>) {
        let Self { course, numbers, of_equations, pulled, .. } = self;
        let known = std::mem::take(&mut self.is_pulled).then_some(&pulled[..]);
        course.set.run(Respond { course, numbers, of_equations, pulling, afresh, known });
    }

    /// Evaluates M⁻¹f at places on trial, for the accelerations there as well.
    #[inline(always)]
    pub(super) fn pull_there(&mut self, pulling: &mut Pulls<'_, '_, W>) {
        let Self { course, numbers, pulled, .. } = self;
        let (Places { change, .. }, n) = (course.plan.places, course.plan.coordinates);
        numbers[change..change + n].fill(zeros());
        course.kick(1.0, change, numbers, pulling);
        pulled.copy_from_slice(&numbers[change..change + n]);
        self.is_pulled = true;
    }
}

/// See [`Stand::respond`].
struct Respond<'a, 'b, 'c, 'd, const W: usize> {
    course: &'a Course<'b, W>,
    numbers: &'a mut [Numbers<W>],
    of_equations: &'a mut [Vec<Numbers<W>>; 2],
    pulling: &'a mut Pulls<'c, 'd, W>,
    afresh: bool,
    /// M⁻¹f, where it is known.
    known: Option<&'a [Numbers<W>]>,
}

impl<const W: usize> Work for Respond<'_, '_, '_, '_, W> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { course, numbers, of_equations: [bends, turns], pulling, afresh, known } = self;
        let Course { plan, links, over, set, .. } = *course;
        let (Places { q, way, change, g, .. }, n) = (plan.places, plan.coordinates);
        if afresh {
            links.gradients(plan, set, q, numbers);
            plan.lift(over, numbers);
            plan.factor.carry_out(numbers);
        }
        if let Some(known) = known {
            numbers[change..change + n].copy_from_slice(known);
        } else {
            numbers[change..change + n].fill(zeros());
            course.kick(1.0, change, numbers, pulling);
        }
        plan.rates.carry_out(numbers);
        links.bends(set, [&numbers[q..q + n], &numbers[way..way + n]], bends, turns);
        for (i, bend) in bends.iter().enumerate() {
            for l in 0..W {
                numbers[g + i].0[l] = numbers[g + i].0[l] + bend.0[l];
            }
        }
        plan.solve(numbers);
        plan.push.carry_out(numbers);
    }
}
