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
//! be as small as along one sheet, no normal may turn over, links must not come to depend on each other, bodies must go
//! where their velocities lead, and kinetic energy must not change by what forces did not give. A lane for which one of
//! these does not hold takes the whole step by itself.

use crate::methods::dop853::{Dop853, SMALLEST_PART};
use crate::methods::dop853_table::{ERROR_3, ERROR_5, STAGES, STEPS, WEIGHTS};
use crate::motion::method::Method;
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::run::ensemble::dop853_lanes::{error, fit};
use crate::run::ensemble::engine::Stuck;
use crate::run::ensemble::forces_in_lanes::Pulling;
use crate::run::ensemble::linked_plan::{Places, add_product};
use crate::run::ensemble::linked_projected_row::{
    Kept, Landed, State, Sums, arrive, bent, between, choose, combine, copy, furthest, length, may_be,
    move_by, reach_for, shift, terms,
};
use crate::run::ensemble::linked_row::{Course, LinkedRow, PIVOT};
use crate::solve::aim::{INSIDE, ROUNDINGS};
use crate::solve::crowd::{EVERY, OF_RADIUS, RISES, reach, shares};
use crate::solve::stop::NOISE;
use crate::systems::network::in_lanes::{Number, Numbers, Which, any, zeros};
use std::array::from_fn;

/// Inner steps, those that are repeated among them, after which a lane goes by itself.
const MOST_PASSES: usize = 1024;

/// Newton steps onto the constraints after which a lane goes by itself.
const MOST_NEWTON_STEPS: usize = 12;

/// A Newton step leaves less than this part of the distance.
const NEARER: f64 = 0.25;

/// A lane is moved, has arrived, or has to take the step by itself.
const MOVES: u64 = 1;
const ARRIVED: u64 = 0;
const BY_ITSELF: u64 = 2;

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
            copy(&kept.state, &mut desk.now);
            desk.be_there(&mut pulling);
        }
        for number in from..from + steps {
            desk.step(&mut pulling);
            if desk.going.contains(&BY_ITSELF) {
                desk.go_apart(number, kept, copy_of, apart)?;
                desk.be_there(&mut pulling);
            }
            copy(&desk.now, &mut kept.state);
            desk.look_around(number + 1, kept)?;
        }
        Ok(())
    }
}

/// What a thread works on.
pub(super) struct Desk<'a, const W: usize> {
    course: Course<'a, W>,
    method: Dop853,
    dimension: usize,
    /// Numbers of the plan: bodies at a stage, or on trial.
    numbers: Vec<Numbers<W>>,
    /// The mass of each coordinate, 0 where pinned.
    masses: Vec<Numbers<W>>,
    /// Where inner steps have led; and accelerations and G there, once they have been evaluated.
    there: bool,
    now: State<W>,
    pull: Vec<Numbers<W>>,
    normals: Vec<Numbers<W>>,
    /// Rates of places and of velocities, stage by stage.
    rates: [Vec<Numbers<W>>; 2],
    /// Two numbers of each equation, and one of each entry of G.
    of_equations: [Vec<Numbers<W>>; 2],
    of_entries: Vec<Numbers<W>>,
    /// Places beside those of bodies, and how far off them a step may lead.
    beside: Vec<Numbers<W>>,
    off: Vec<Numbers<W>>,
    /// How much of the step is left, and the lengths of the inner step and of the next one.
    left: Numbers<W>,
    inner: Numbers<W>,
    next: Numbers<W>,
    /// Whether the inner step is within the tolerance.
    taken: [bool; W],
    going: Which<W>,
    /// The same for a lane that seeks the constraints, and the distance that it began its last Newton step at.
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
            method,
            dimension,
            numbers: rows(plan.places.end),
            masses,
            there: false,
            now: from_fn(|_| rows(n)),
            pull: rows(n),
            normals: rows(entries),
            rates: [rows(STAGES * n), rows(STAGES * n)],
            of_equations: [rows(m), rows(m)],
            of_entries: rows(entries),
            beside: rows(n),
            off: rows(n),
            left: zeros(),
            inner: zeros(),
            next: zeros(),
            taken: [true; W],
            going: [ARRIVED; W],
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
        self.numbers[q..q + n].copy_from_slice(&self.now[0]);
        self.numbers[way..way + n].copy_from_slice(&self.now[1]);
        self.respond(true, pulling);
        self.there = true;
        self.pull.copy_from_slice(&self.numbers[change..change + n]);
        self.normals.copy_from_slice(&self.numbers[gradient..gradient + entries]);
    }

    /// Has lanes go by themselves, copies with what they are copies of. All that cannot are told of at once: each is
    /// left out before this is tried again.
    #[cold]
    #[inline(never)]
    fn go_apart(
        &mut self,
        number: u64,
        kept: &Kept<W>,
        copy_of: &[usize; W],
        apart: &mut Apart<'_, W>,
    ) -> Result<(), Vec<Stuck>> {
        let (mut stuck, going) = (Vec::new(), self.going);
        for of in (0..W).filter(|&of| copy_of[of] == of && going[of] == BY_ITSELF) {
            match apart(of, number, kept) {
                Ok(landed) => {
                    (0..W).filter(|&lane| copy_of[lane] == of).for_each(|lane| self.take_over(lane, &landed));
                }
                Err(why) => stuck.push(why),
            }
        }
        if stuck.is_empty() { Ok(()) } else { Err(stuck) }
    }

    /// Takes over where a lane is that went by itself.
    fn take_over(&mut self, lane: usize, Landed { state, strays, path }: &Landed) {
        for (now, landed) in self.now.iter_mut().zip(state) {
            now.iter_mut().zip(landed).for_each(|(now, &landed)| now.0[lane] = Fused(landed));
        }
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
        let h = Fused(self.method.step_size());
        (self.left.0, self.inner.0, self.going) = ([h; W], [h; W], [MOVES; W]);
        (self.strays, self.radius.0) = (zeros(), [Fused(f64::INFINITY); W]);
        for pass in 0..MOST_PASSES {
            self.evaluate(pulling);
            self.estimate();
            self.depart();
            for l in 0..W {
                let seeks = self.going[l] == MOVES && self.taken[l];
                self.seeking[l] = if seeks { MOVES } else { ARRIVED };
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
            if !self.take(pass, h) {
                return;
            }
        }
    }

    /// The stages of an inner step.
    #[inline(always)]
    fn evaluate(&mut self, pulling: &mut Pulls<'_, '_, W>) {
        let plan = self.course.plan;
        let (Places { q, way, change, .. }, n) = (plan.places, plan.coordinates);
        for l in 0..W {
            let [left, inner] = [self.left.0[l], self.inner.0[l]];
            self.inner.0[l] = Real::select(left.0.abs() <= inner.0.abs(), left, inner);
        }
        self.rates[0][..n].copy_from_slice(&self.now[1]);
        self.rates[1][..n].copy_from_slice(&self.pull);
        for stage in 1..STAGES {
            for &c in &plan.moving {
                let (mut x, mut y) = (zeros(), zeros());
                combine(STEPS[stage], c, n, &self.rates[0], &mut x);
                combine(STEPS[stage], c, n, &self.rates[1], &mut y);
                let [place, velocity, place_low, velocity_low] = self.now.each_ref().map(|of| &of[c]);
                reach_for(&self.inner, &x, [place, place_low], &mut self.numbers[q + c]);
                reach_for(&self.inner, &y, [velocity, velocity_low], &mut self.numbers[way + c]);
                self.rates[0][stage * n + c] = self.numbers[way + c];
            }
            self.respond(true, pulling);
            self.rates[1][stage * n..][..n].copy_from_slice(&self.numbers[change..change + n]);
        }
    }

    /// Which inner steps are within the tolerance, and how long the next ones are to be.
    #[inline(always)]
    fn estimate(&mut self) {
        let Some(tolerance) = self.method.tolerance() else {
            (self.next, self.taken) = (self.inner, [true; W]);
            return;
        };
        let (n, whole) = (self.course.plan.coordinates, Fused(self.method.step_size().abs()));
        let mut worst = zeros::<W>();
        for first in (0..n).step_by(self.dimension) {
            let body = first..first + self.dimension;
            let (mut fifth, mut third) = (zeros(), zeros());
            length(ERROR_5, body.clone(), n, whole, &self.rates, &mut fifth);
            length(ERROR_3, body, n, whole, &self.rates, &mut third);
            let error = error(&fifth.0, &third.0, &self.inner.0);
            for l in 0..W {
                let (error, most) = (error[l], worst.0[l]);
                worst.0[l] = Real::select((error.0 <= most.0) | most.0.is_nan(), most, error);
            }
        }
        fit(&[Fused(tolerance); W], &worst.0, &self.inner.0, &mut self.next.0, &mut self.taken);
    }

    /// Where inner steps lead regardless of the constraints.
    #[inline(always)]
    fn depart(&mut self) {
        let plan = self.course.plan;
        let (Places { q, q_low, way, way_low, .. }, n) = (plan.places, plan.coordinates);
        for &c in &plan.moving {
            for (i, [high, low]) in [[q, q_low], [way, way_low]].into_iter().enumerate() {
                let (mut rate, mut sum, mut rest) = (zeros(), zeros(), zeros());
                combine(WEIGHTS, c, n, &self.rates[i], &mut rate);
                arrive(&self.inner, &rate, [&self.now[i][c], &self.now[2 + i][c]], &mut sum, &mut rest);
                (self.numbers[high + c], self.numbers[low + c]) = (sum, rest);
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
        let Self { course, numbers, now, pull, normals, .. } = self;
        let Self { of_equations: [g, allowed], of_entries, beside, off, inner, .. } = self;
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
        for s in INSIDE {
            beside.copy_from_slice(&now[0]);
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
            let moves = (self.going[l] == MOVES) & self.taken[l];
            if moves & (self.strays.0[l].0 < astray.0) {
                (self.strays.0[l], self.radius.0[l]) = (astray, bent(path.0[l], astray));
            }
            self.going[l] = if moves & !believed { BY_ITSELF } else { self.going[l] };
        }
    }

    /// Takes the inner steps that are taken. Returns whether a lane has still some way to go.
    #[inline(always)]
    fn take(&mut self, pass: usize, h: Number) -> bool {
        let plan = self.course.plan;
        let Places { q, q_low, way, way_low, gradient, change, .. } = plan.places;
        let (shortest, end) = (SMALLEST_PART * h.0.abs(), pass + 1 == MOST_PASSES);
        let (mut moves, mut any) = ([0; W], false);
        for l in 0..W {
            let goes = self.going[l] == MOVES;
            let (takes, left) = (goes & self.taken[l], self.left.0[l]);
            moves[l] = u64::from(takes);
            let left = if takes { left - self.inner.0[l] } else { left };
            let collapsed = !self.taken[l] & (self.next.0[l].0.abs() < shortest);
            let arrived = left.0 == 0.0;
            let on = if arrived { ARRIVED } else { MOVES };
            let on = if collapsed | (end & !arrived) { BY_ITSELF } else { on };
            (self.left.0[l], self.inner.0[l]) = (left, self.next.0[l]);
            self.going[l] = if goes { on } else { self.going[l] };
            any |= self.going[l] == MOVES;
        }
        for &c in &plan.moving {
            for (to, from) in self.now.iter_mut().zip([q, way, q_low, way_low]) {
                choose(&moves, &self.numbers[from + c], &mut to[c]);
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
        let Desk { course: Course { plan, links, set, .. }, now, normals, radius, .. } = desk;
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
            beside.copy_from_slice(&now[0]);
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
