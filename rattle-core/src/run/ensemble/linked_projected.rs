//! Steps of linked bodies in lanes that disregard the constraints until their end is projected onto them, by the stages
//! of [`Dop853`]; each lane with inner steps of its own where there is a tolerance. As on surfaces
//! ([`crate::run::ensemble::projected`]) a row waits for its slowest lane, and what becomes of a lane depends on itself
//! alone.
//!
//! ```text
//! v̇ = M⁻¹(f − Gᵀλ)     λ such that G v̇ + v·∇²g·v = 0            at each stage
//! q′ = q̂ − M⁻¹Gᵀ x      Newton's method, with G where it is
//! v′ = v̂ − M⁻¹Gᵀ(q′) η  η such that G(q′) v′ = 0
//! ```
//!
//! **Whether a step can be believed** is asked of each inner one, as a simulation asks it
//! ([`crate::motion::course`]): on the quintic of places, velocities and accelerations at both ends all equations must
//! be as small as along one sheet, no normal may turn over, nor may all of them together ([`crate::systems::linked`]),
//! links must not come to depend on each other, bodies must go where their velocities lead, and kinetic energy must not
//! change by what forces did not give. A lane for which one of these does not hold takes the whole step by itself.

use crate::methods::dop853::Dop853;
use crate::methods::dop853_table::STAGES;
use crate::motion::course::{ASTRAY, ROUNDINGS_OF_WAYS};
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::run::ensemble::dop853_row::{
    ARRIVED, BY_ITSELF, MOST_NEWTON_STEPS, MOST_PASSES, MOVES, Pace, Track, choose, one_by_one, put, state,
};
use crate::run::ensemble::engine::Stuck;
use crate::run::ensemble::forces_in_lanes::Pulling;
use crate::run::ensemble::linked_plan::{Places, add_product};
use crate::run::ensemble::linked_projected_row::{
    Kept, Landed, Sums, bent, between, furthest, may_be, move_by, shift, terms,
};
use crate::run::ensemble::linked_row::{Course, LinkedRow, PIVOT};
use crate::solve::aim::{INSIDE, ROUNDINGS};
use crate::solve::crowd::{EVERY, OF_RADIUS, RISES, reach, shares};
use crate::solve::stop::NOISE;
use crate::systems::network::in_lanes::{Numbers, Which, any, zeros};
use std::array::from_fn;

/// A Newton step leaves less than this part of the distance.
const NEARER: f64 = 0.25;

/// Finds where the step of this number leads a lane by itself.
pub(super) type Apart<'a, const W: usize> = dyn FnMut(usize, u64, &Kept<W>) -> Result<Landed, Stuck> + 'a;

/// Effects that pull bodies, if any do.
type Pulls<'a, 'b, const W: usize> = Option<&'a mut (dyn Pulling<LinkedRow, W> + 'b)>;

/// Some steps of a row, after so many.
pub(super) struct ProjectedSteps<'a, 'b, const W: usize> {
    pub(super) pulling: Pulls<'a, 'b, W>,
    pub(super) apart: &'a mut Apart<'b, W>,
    /// Which lane each is a copy of.
    pub(super) copy_of: &'a [usize; W],
    pub(super) desk: &'a mut Desk<'b, W>,
    pub(super) kept: &'a mut Kept<W>,
    pub(super) from: u64,
    pub(super) steps: u64,
}

impl<const W: usize> Work for ProjectedSteps<'_, '_, W> {
    type Done = Result<(), Vec<Stuck>>;

    #[inline(always)]
    fn run(self) -> Result<(), Vec<Stuck>> {
        let Self { mut pulling, apart, copy_of, desk, kept, from, steps } = self;
        if !desk.there {
            kept.state.iter().zip(state(&mut desk.tracks)).for_each(|(from, to)| to.copy_from_slice(from));
            desk.be_there(&mut pulling);
        }
        for number in from..from + steps {
            desk.step(&mut pulling);
            if desk.pace.going.contains(&BY_ITSELF) {
                let (going, put) =
                    (desk.pace.going, &mut |lane, landed: &Landed| desk.take_over(lane, landed));
                one_by_one(&going, copy_of, &mut |lane| apart(lane, number, kept), put)?;
                desk.be_there(&mut pulling);
            }
            kept.state
                .iter_mut()
                .zip(state(&mut desk.tracks))
                .for_each(|(to, from)| to.copy_from_slice(from));
            desk.look_around(number + 1, kept)?;
        }
        Ok(())
    }
}

/// What a thread works on.
pub(super) struct Desk<'a, const W: usize> {
    course: Course<'a, W>,
    pace: Pace<W>,
    dimension: usize,
    /// Numbers of the plan: bodies at a stage, or on trial.
    numbers: Vec<Numbers<W>>,
    /// The mass of each coordinate, 0 where pinned.
    masses: Vec<Numbers<W>>,
    /// Places and velocities; and accelerations and G where they are, once they have been evaluated.
    tracks: [Track<W>; 2],
    there: bool,
    pull: Vec<Numbers<W>>,
    normals: Vec<Numbers<W>>,
    /// Two numbers of each equation, and one of each entry of G.
    of_equations: [Vec<Numbers<W>>; 2],
    of_entries: Vec<Numbers<W>>,
    /// Places beside those of bodies, and how far off them a step may lead.
    beside: Vec<Numbers<W>>,
    off: Vec<Numbers<W>>,
    /// Places and velocities to which the inner step led regardless of the constraints; with a tolerance.
    departed: [Vec<Numbers<W>>; 2],
    /// Whether a lane [seeks](MOVES) the constraints, and the distance that it began its last Newton step at.
    seeking: Which<W>,
    distance: Numbers<W>,
    /// How far inner steps may have led astray, and the radius that the path of that one is bent in.
    strays: Numbers<W>,
    radius: Numbers<W>,
}

impl<'a, const W: usize> Desk<'a, W> {
    /// For bodies of so many coordinates.
    #[inline(never)]
    pub(super) fn new(course: Course<'a, W>, method: Dop853, dimension: usize) -> Self {
        let plan = course.plan;
        let (n, m, entries) = (plan.coordinates, plan.equations, plan.of_entry.len());
        let rows = |number: usize| vec![zeros::<W>(); number];
        let mut masses = rows(n);
        for (c, mass) in masses.iter_mut().enumerate() {
            for l in 0..W {
                let over = course.over.map_or(plan.masses[c][1], |over| over[c].0[l].0);
                mass.0[l] = Fused(if over == 0.0 { 0.0 } else { 1.0 / over });
            }
        }
        Self {
            course,
            pace: Pace::new(method),
            dimension,
            numbers: rows(plan.places.end),
            masses,
            tracks: from_fn(|_| Track::new(n)),
            there: false,
            pull: rows(n),
            normals: rows(entries),
            of_equations: [rows(m), rows(m)],
            of_entries: rows(entries),
            beside: rows(n),
            off: rows(n),
            departed: [rows(n), rows(n)],
            seeking: [ARRIVED; W],
            distance: zeros(),
            strays: zeros(),
            radius: zeros(),
        }
    }

    /// The instructions that it works by.
    pub(super) fn set(&self) -> Fusing {
        self.course.set
    }

    /// Accelerations and normals where all bodies are.
    #[inline(always)]
    fn be_there(&mut self, pulling: &mut Pulls<'_, '_, W>) {
        let Places { q, way, gradient, change, .. } = self.course.plan.places;
        let (n, entries) = (self.pull.len(), self.normals.len());
        self.numbers[q..q + n].copy_from_slice(&self.tracks[0].now);
        self.numbers[way..way + n].copy_from_slice(&self.tracks[1].now);
        self.respond(true, pulling);
        self.there = true;
        self.pull.copy_from_slice(&self.numbers[change..change + n]);
        self.normals.copy_from_slice(&self.numbers[gradient..gradient + entries]);
    }

    /// Takes over where a lane is that went by itself.
    fn take_over(&mut self, lane: usize, Landed { state, strays, path }: &Landed) {
        put(&mut self.tracks, lane, state);
        let [strays, path] = [*strays, *path].map(Fused);
        (self.strays.0[lane], self.radius.0[lane]) = (strays, bent(path, strays));
    }

    /// Writes accelerations at the places and velocities on trial to `change`; `afresh` with the normals and the matrix
    /// of these places, which else are known.
    #[inline(always)]
    fn respond(&mut self, afresh: bool, pulling: &mut Pulls<'_, '_, W>) {
        let Self { course, numbers, of_equations, .. } = self;
        course.set.run(Respond { course, numbers, of_equations, pulling, afresh });
    }

    /// Finds where one step leads all lanes. Those that it cannot lead there are [`BY_ITSELF`] then.
    #[inline(always)]
    fn step(&mut self, pulling: &mut Pulls<'_, '_, W>) {
        self.pace.begin();
        (self.strays, self.radius.0) = (zeros(), [Fused(f64::INFINITY); W]);
        for pass in 0..MOST_PASSES {
            self.evaluate(pulling);
            if self.pace.tolerance().is_some() {
                for first in (0..self.pull.len()).step_by(self.dimension) {
                    let own = first..first + self.dimension;
                    let places = self.tracks[0].squares(own.clone());
                    let velocities = self.tracks[1].squares(own);
                    self.pace.note(&places, &velocities);
                }
            }
            self.pace.judge();
            self.depart();
            for l in 0..W {
                self.seeking[l] = if self.pace.takes(l) { MOVES } else { ARRIVED };
                self.distance.0[l] = Fused(f64::INFINITY);
            }
            for _ in 0..MOST_NEWTON_STEPS {
                if !self.approach() {
                    break;
                }
            }
            self.course.project(&mut self.numbers);
            self.respond(false, pulling);
            self.look();
            self.weigh();
            if !self.take(pass + 1) {
                return;
            }
        }
    }

    /// The stages of an inner step.
    #[inline(always)]
    fn evaluate(&mut self, pulling: &mut Pulls<'_, '_, W>) {
        let plan = self.course.plan;
        let (Places { q, way, change, .. }, n) = (plan.places, plan.coordinates);
        self.pace.begin_inner();
        let [places, velocities] = &mut self.tracks;
        places.note(0, &velocities.now);
        velocities.note(0, &self.pull);
        for stage in 1..STAGES {
            let [places, velocities] = &mut self.tracks;
            for (track, from) in [(&*places, q), (&*velocities, way)] {
                let to = &mut self.numbers[from..from + n];
                track.stage(stage, plan.moving.iter().copied(), &self.pace.inner, to);
            }
            places.note(stage, &self.numbers[way..way + n]);
            self.respond(true, pulling);
            self.tracks[1].note(stage, &self.numbers[change..change + n]);
        }
    }

    /// Where inner steps lead regardless of the constraints.
    #[inline(always)]
    fn depart(&mut self) {
        let plan = self.course.plan;
        let Places { q, q_low, way, way_low, .. } = plan.places;
        for &c in &plan.moving {
            for (track, [high, low]) in self.tracks.iter().zip([[q, q_low], [way, way_low]]) {
                let (mut sum, mut rest) = (zeros(), zeros());
                track.arrive(c, &self.pace.inner, &mut sum, &mut rest);
                (self.numbers[high + c], self.numbers[low + c]) = (sum, rest);
            }
        }
        if self.pace.tolerance().is_some() {
            for (departed, from) in self.departed.iter_mut().zip([q, way]) {
                departed.copy_from_slice(&self.numbers[from..from + plan.coordinates]);
            }
        }
    }

    /// A Newton step towards the constraints, as [`Nearing`](crate::solve::nearing::Nearing) judges it. Returns whether
    /// a lane is still seeking.
    #[inline(always)]
    fn approach(&mut self) -> bool {
        let Self { course, numbers, seeking, distance, .. } = self;
        let Course { plan, links, over, set, .. } = *course;
        let Places { q, q_low, g, gradient, change, .. } = plan.places;
        links.gradients(plan, set, q, numbers);
        plan.lift(over, numbers);
        let (mut far, mut roundings) = (zeros::<W>(), zeros::<W>());
        for (i, entries) in plan.of_row.iter().enumerate() {
            let (mut square, mut along, mut most) = (zeros::<W>(), zeros::<W>(), zeros::<W>());
            for &[entry, c] in entries {
                terms(&numbers[gradient + entry], &numbers[q + c], &mut square, &mut along, &mut most);
            }
            furthest(&numbers[g + i], &square, &along, &most, &mut far, &mut roundings);
        }
        let mut moves = [0; W];
        let long = NOISE * (plan.equations as f64).sqrt(); // roundings of a chain add up along it
        for l in 0..W {
            let (far, last, roundings) = (far.0[l].0, distance.0[l].0, roundings.0[l].0);
            let near = roundings <= long;
            let arrived = (roundings <= 1.0) | (near & (last <= 2.0 * far));
            let nearer = near | (far < NEARER * last);
            let seeks = seeking[l] == MOVES;
            moves[l] = u64::from(seeks & !arrived & nearer);
            let on = if arrived {
                ARRIVED
            } else if nearer {
                MOVES
            } else {
                BY_ITSELF
            };
            seeking[l] = if seeks { on } else { seeking[l] };
            distance.0[l] = Fused(far);
        }
        if !any(&moves) {
            return false;
        }
        plan.factor.carry_out(numbers);
        plan.solve(numbers);
        numbers[change..change + plan.coordinates].fill(zeros());
        plan.push.carry_out(numbers);
        for &c in &plan.moving {
            let (by, mut place, mut low) = (numbers[change + c], numbers[q + c], numbers[q_low + c]);
            move_by(&moves, &by, &mut place, &mut low);
            (numbers[q + c], numbers[q_low + c]) = (place, low);
        }
        true
    }

    /// Has lanes go by themselves whose inner step cannot be believed.
    #[inline(always)]
    fn look(&mut self) {
        let Self { course, numbers, tracks: [places, velocities], pull, normals, .. } = self;
        let Self { of_equations: [g, allowed], of_entries, beside, off, pace, .. } = self;
        let (now, inner) = ([&places.now, &velocities.now], &pace.inner);
        let Course { plan, links, set, .. } = *course;
        let Places { q, way, gradient, lifted, change, diagonal, inverse, .. } = plan.places;
        let mut sums = Sums::default();
        for &c in &plan.moving {
            let from = [&now[0][c], &now[1][c], &pull[c]];
            let to = [q, way, change].map(|of| &numbers[of + c]);
            sums.add(inner, from, to, &self.masses[c], &mut off[c]);
        }
        let mut plain: Which<W> = [1; W];
        for (i, entries) in plan.of_row.iter().enumerate() {
            let (mut slope, mut square, mut most) = (zeros::<W>(), zeros::<W>(), zeros::<W>());
            for &[entry, c] in entries {
                let (n, size) = (&numbers[gradient + entry], &numbers[q + c]);
                may_be(n, &off[c], size, &mut square, &mut most);
                add_product(&mut slope, &normals[entry], &numbers[lifted + entry]);
            }
            let (pivot, over) = (&numbers[diagonal + i], &numbers[inverse + i]);
            for l in 0..W {
                allowed[i].0[l] = most.0[l] * most.0[l] * square.0[l];
                let (over, pivot) = (over.0[l].0, pivot.0[l].0);
                let clear = (0.0 < over) & (over * pivot <= PIVOT);
                plain[l] = if clear & (0.0 < slope.0[l].0) { plain[l] } else { 0 };
            }
        }
        // Whether all normals together turn over: by those of both ends.
        numbers[gradient..gradient + normals.len()].swap_with_slice(normals);
        plan.factor.carry_out(numbers);
        numbers[gradient..gradient + normals.len()].swap_with_slice(normals);
        for over in &numbers[inverse..inverse + plan.equations] {
            for l in 0..W {
                plain[l] = if 0.0 < over.0[l].0 { plain[l] } else { 0 };
            }
        }
        for s in INSIDE {
            beside.copy_from_slice(now[0]);
            for &c in &plan.moving {
                let from = [&now[0][c], &now[1][c], &pull[c]];
                let to = [q, way, change].map(|of| &numbers[of + c]);
                between(s, inner, from, to, &mut beside[c]);
            }
            links.gradients_at(set, beside, g, of_entries);
            for (g, allowed) in g.iter().zip(&*allowed) {
                for l in 0..W {
                    let small = (g.0[l] * g.0[l]).0 <= allowed.0[l].0;
                    plain[l] = if small { plain[l] } else { 0 };
                }
            }
        }
        for l in 0..W {
            let Sums { astray, path, size, .. } = &sums;
            let (astray, rounding) = (astray.0[l], Fused(ROUNDINGS * f64::EPSILON) * size.0[l]);
            let believed = (plain[l] != 0) & sums.is_plain(l, rounding) & (self.seeking[l] == ARRIVED);
            if self.pace.takes(l) & (self.strays.0[l].0 < astray.0) {
                (self.strays.0[l], self.radius.0[l]) = (astray, bent(path.0[l], astray));
            }
            self.pace.doubt(l, believed);
        }
    }

    /// Has lanes go by themselves in which constraints [moved](crate::motion::course::moved) a body too far from where
    /// its inner step led.
    #[inline(always)]
    fn weigh(&mut self) {
        let Some(tolerance) = self.pace.tolerance() else { return };
        let (plan, h) = (self.course.plan, self.pace.h().0.abs());
        let Places { q, way, .. } = plan.places;
        for own in plan.moving.chunk_by(|a, b| a / self.dimension == b / self.dimension) {
            let [mut off, mut turned, mut size, mut speed] = [[0.0_f64; W]; 4];
            for &c in own {
                let (place, velocity) = (&self.numbers[q + c], &self.numbers[way + c]);
                for l in 0..W {
                    let (place, velocity) = (place.0[l].0, velocity.0[l].0);
                    let [way, change] =
                        [place - self.departed[0][c].0[l].0, velocity - self.departed[1][c].0[l].0];
                    (off[l], turned[l]) = (off[l] + way * way, turned[l] + change * change);
                    (size[l], speed[l]) = (size[l].max(place.abs()), speed[l].max(velocity.abs()));
                }
            }
            for l in 0..W {
                let rounding = ROUNDINGS_OF_WAYS * f64::EPSILON * (size[l] + h * speed[l]);
                let moved = off[l].sqrt() + h * turned[l].sqrt();
                self.pace.doubt(l, moved <= ASTRAY * tolerance + rounding);
            }
        }
    }

    /// Takes the inner steps that are taken, after so many. Returns whether a lane has still some way to go.
    #[inline(always)]
    fn take(&mut self, passes: usize) -> bool {
        let plan = self.course.plan;
        let Places { q, q_low, way, way_low, gradient, change, .. } = plan.places;
        let (moves, any) = self.pace.advance(passes);
        for &c in &plan.moving {
            for (track, [high, low]) in self.tracks.iter_mut().zip([[q, q_low], [way, way_low]]) {
                track.take(&moves, c, [&self.numbers[high + c], &self.numbers[low + c]]);
            }
            choose(&moves, &self.numbers[change + c], &mut self.pull[c]);
        }
        for (entry, normal) in self.normals.iter_mut().enumerate() {
            choose(&moves, &self.numbers[gradient + entry], normal);
        }
        any
    }

    /// Looks for other sheets around lanes that may have gone farther astray than was looked, and now and then around
    /// all, as a simulation does.
    #[inline(always)]
    fn look_around(&mut self, steps: u64, kept: &mut Kept<W>) -> Result<(), Vec<Stuck>> {
        let (due, mut farther) = (steps.is_multiple_of(EVERY), [0; W]);
        for l in 0..W {
            let (strays, asked, astray) = (self.strays.0[l], &mut kept.asked.0[l], &mut kept.astray.0[l]);
            *astray = astray.max(strays);
            let within = strays.0 <= asked.0; // not where it is no number
            farther[l] = u64::from(!within);
            if due | !within {
                (*asked, *astray) = (reach(*astray, *asked), Fused(0.0));
            }
        }
        if any(&farther) {
            self.look_for_others(0, &farther, &kept.asked)?;
        }
        if due { self.look_for_others(steps, &[1; W], &kept.asked) } else { Ok(()) }
    }

    /// Looks for other sheets around these lanes.
    #[inline(always)]
    fn look_for_others(&mut self, turn: u64, lanes: &Which<W>, asked: &Numbers<W>) -> Result<(), Vec<Stuck>> {
        self.course.set.run(Others { desk: self, turn, lanes, asked })
    }
}

/// Whether an equation's gradient, where bodies are moved along gradients up to this far, is less than half of what it
/// was, in some of these lanes.
struct Others<'a, 'b, const W: usize> {
    desk: &'a mut Desk<'b, W>,
    turn: u64,
    lanes: &'a Which<W>,
    asked: &'a Numbers<W>,
}

impl<const W: usize> Work for Others<'_, '_, W> {
    type Done = Result<(), Vec<Stuck>>;

    #[inline(always)]
    fn run(self) -> Result<(), Vec<Stuck>> {
        let Self { desk, turn, lanes, asked } = self;
        let Desk { course: Course { plan, links, set, .. }, tracks, normals, radius, .. } = desk;
        let Desk { of_equations: [g, shifts], of_entries, beside, .. } = desk;
        for (i, entries) in plan.of_row.iter().enumerate() {
            let mut square = zeros::<W>();
            entries.iter().for_each(|&[e, _]| add_product(&mut square, &normals[e], &normals[e]));
            for l in 0..W {
                let far = asked.0[l].min(Fused(OF_RADIUS) * radius.0[l]);
                shifts[i].0[l] = far / square.0[l].sqrt();
            }
        }
        let mut crowded = [0; W];
        for share in shares(turn) {
            beside.copy_from_slice(&tracks[0].now);
            for (i, entries) in plan.of_row.iter().enumerate() {
                for &[entry, c] in entries.iter().filter(|&&[_, c]| plan.masses[c][1] != 0.0) {
                    shift(Fused(share), &shifts[i], &normals[entry], &mut beside[c]);
                }
            }
            links.gradients_at(*set, beside, g, of_entries);
            for entries in &plan.of_row {
                let (mut square, mut along) = (zeros::<W>(), zeros::<W>());
                for &[e, _] in entries {
                    add_product(&mut square, &normals[e], &normals[e]);
                    add_product(&mut along, &normals[e], &of_entries[e]);
                }
                for l in 0..W {
                    let rises = RISES * square.0[l].0 <= along.0[l].0; // not where it is no number
                    crowded[l] = if rises { crowded[l] } else { lanes[l] };
                }
            }
        }
        if !any(&crowded) {
            return Ok(());
        }
        let lanes = (0..W).filter(|&lane| crowded[lane] != 0);
        Err(lanes.map(|lane| Stuck { lane, failure: None }).collect())
    }
}

/// See [`Desk::respond`].
struct Respond<'a, 'b, 'c, 'd, const W: usize> {
    course: &'a Course<'b, W>,
    numbers: &'a mut [Numbers<W>],
    of_equations: &'a mut [Vec<Numbers<W>>; 2],
    pulling: &'a mut Pulls<'c, 'd, W>,
    afresh: bool,
}

impl<const W: usize> Work for Respond<'_, '_, '_, '_, W> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { course, numbers, of_equations: [bends, turns], pulling, afresh } = self;
        let Course { plan, links, over, set, .. } = *course;
        let (Places { q, way, change, g, .. }, n) = (plan.places, plan.coordinates);
        if afresh {
            links.gradients(plan, set, q, numbers);
            plan.lift(over, numbers);
            plan.factor.carry_out(numbers);
        }
        numbers[change..change + n].fill(zeros());
        course.kick(1.0, change, numbers, pulling);
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
