//! Flows of momenta on a row of trajectories of linked bodies.
//!
//! ```text
//! linear     δ = B v + noise          B = M⁻¹A M, a block for each body
//! any other  δ = M⁻¹(Φₕ(M v) − M v)   asked of the flow, lane by lane
//!
//! random     v ← v + δ(v) + n         n = M⁻¹Gᵀμ such that G v = 0
//! symmetric  v ← v + δ(v + n/2) + n
//! ```
//!
//! For linear flows μ solves G (1 + B/2) M⁻¹Gᵀ μ = −G (v + δ(v)): the [plan](crate::run::ensemble::linked_plan)
//! eliminates it with (1 + B/2) M⁻¹Gᵀ in the place of M⁻¹Gᵀ. The symmetric part of that matrix is positive for drags
//! and fields, so no search for pivots is needed. For other flows n is found by repetition and secants, as
//! [`crate::motion::stir`] does. A lane for which it is not found goes by itself.

use crate::effect::interval::{Inertia, Rule};
use crate::effect::list::Forces;
use crate::motion::method::Renewal;
use crate::motion::system::System;
use crate::number::instructions::Work;
use crate::number::lanes::{Fused, Lanes};
use crate::number::real::Real;
use crate::run::ensemble::linked_plan::Places;
use crate::run::ensemble::linked_row::{Course, PIVOT};
use crate::run::ensemble::rhythm::{Bath, Rhythm, Turn, When};
use crate::run::ensemble::splits::Splits;
use crate::run::ensemble::stirring::{DEVIATIONS, MOST_ROUNDS};
use crate::systems::network::in_lanes::{Number, Numbers, Which, zeros};
use std::array::from_fn;

/// What stirs the lanes of a row.
#[derive(Clone)]
pub(super) struct RowStirring<const W: usize> {
    flows: Vec<Stir<W>>,
    pub(super) rhythm: Rhythm<W>,
    /// Coordinates of a body.
    dimension: usize,
    /// Mass and 1 over it by coordinate; both 0 where pinned.
    masses: Vec<[Numbers<W>; 2]>,
    /// The largest velocity to expect of each coordinate.
    pub(super) least: Vec<Numbers<W>>,
}

/// A flow.
#[derive(Clone)]
enum Stir<const W: usize> {
    /// By the same share of all velocities, with noise.
    Bath(Rule, Bath<W>),
    /// By B, body by body and row by row.
    Matrix(Rule, Vec<Numbers<W>>),
    /// By asking it.
    Asked(Rule),
}

/// What is asked of a flow: what velocities change by, in these lanes.
pub(super) struct Question<'a, const W: usize> {
    pub(super) turn: Turn,
    pub(super) lanes: &'a Which<W>,
    pub(super) q: &'a [Numbers<W>],
    pub(super) v: &'a [Numbers<W>],
}

/// Who answers.
pub(super) type Answer<'a, const W: usize> = dyn FnMut(Question<'_, W>, &mut [Numbers<W>]) + 'a;

impl<const W: usize> RowStirring<W> {
    /// What stirs lanes that obey these systems by this method, or draws their momenta anew; none where nothing does.
    pub(super) fn of<'a, F: Forces<f64, D>, Y: System<f64, D>, const D: usize>(
        lane: impl Fn(usize) -> (&'a F, &'a Y, &'a [[f64; 2]]),
        method: &Splits,
    ) -> Option<Box<Self>> {
        if let Some(renewal) = method.renewal {
            return Some(Self::renewing(renewal, method.h, D, by_coordinate(&|l| lane(l).2)));
        }
        if const { F::FLOWS == 0 } {
            return None;
        }
        let rule = |number| lane(0).0.manner(number).0.rule;
        let once = F::FLOWS == 1 && rule(0) == Rule::Random;
        let rhythm =
            Rhythm::of(method.stirs_after, method.h, once, (0..W).any(|l| lane(l).0.changes_with_time()));
        let time = rhythm.time;
        let n = lane(0).2.len();
        let masses = by_coordinate(&|l| lane(l).2);
        let mut least = vec![zeros::<W>(); n];
        let mut stir = |flow: usize| {
            let processes: Option<Vec<_>> =
                (0..W).map(|l| lane(l).0.ornstein_uhlenbeck(flow, time)).collect();
            if let Some(of) = processes {
                for (c, least) in least.iter_mut().enumerate() {
                    for l in 0..W {
                        let most = DEVIATIONS * (of[l].temperature() * lane(l).2[c][1]).sqrt();
                        least.0[l] = least.0[l].max(Fused(most));
                    }
                }
                return Stir::Bath(rule(flow), Bath::of(&of));
            }
            let mut matrix = vec![zeros::<W>(); n * D];
            for (body, rows) in matrix.chunks_mut(D * D).enumerate() {
                for l in 0..W {
                    let (effects, system, masses) = lane(l);
                    let inertia: &dyn Inertia<f64, D> = system.inertia();
                    let Some(a) = effects.linear(flow, time, body, inertia) else {
                        return Stir::Asked(rule(flow));
                    };
                    for (to, (i, k)) in rows.iter_mut().zip((0..D * D).map(|at| (at / D, at % D))) {
                        let (own, other) = (masses[body * D + i][1], masses[body * D + k][0]);
                        to.0[l] = Fused(if i == k { a[i][k] } else { own * a[i][k] * other });
                    }
                }
            }
            Stir::Matrix(rule(flow), matrix)
        };
        let flows = (0..F::FLOWS).map(&mut stir).collect();
        Some(Box::new(Self { flows, rhythm, dimension: D, masses, least }))
    }

    /// What draws the momenta of lanes of bodies of so many coordinates and with these masses anew. Momenta are
    /// forgotten before.
    fn renewing(renewal: Renewal, h: f64, dimension: usize, masses: Vec<[Numbers<W>; 2]>) -> Box<Self> {
        let most = DEVIATIONS * renewal.deviation;
        let least = |[_, over]: &[Numbers<W>; 2]| Lanes(over.0.map(|over| Fused(most * over.0.sqrt())));
        Box::new(Self {
            flows: vec![Stir::Bath(Rule::Random, Bath::of(&[renewal.process(); W]))],
            rhythm: Rhythm::renewing(h),
            dimension,
            least: masses.iter().map(least).collect(),
            masses,
        })
    }

    /// Has lane `to` be stirred as lane `from` is.
    pub(super) fn copy(&mut self, from: usize, to: usize) {
        self.rhythm.copy(from, to);
        self.masses.iter_mut().flatten().chain(&mut self.least).for_each(|row| row.0[to] = row.0[from]);
        for flow in &mut self.flows {
            match flow {
                Stir::Bath(_, bath) => bath.copy(from, to),
                Stir::Matrix(_, matrix) => matrix.iter_mut().for_each(|row| row.0[to] = row.0[from]),
                Stir::Asked(_) => {}
            }
        }
    }

    /// The largest component of the velocity of each lane, or of what is to be expected.
    #[inline(always)]
    pub(super) fn fastest(&self, v: &[Numbers<W>], expected: bool) -> [f64; W] {
        let mut most = [0.0; W];
        for (v, least) in v.iter().zip(&self.least) {
            for l in 0..W {
                let x = v.0[l].0.abs();
                most[l] = if x > most[l] { x } else { most[l] };
                let x = least.0[l].0;
                most[l] = if expected && x > most[l] { x } else { most[l] };
            }
        }
        most
    }

    /// Twice the kinetic energy of each lane.
    #[inline(always)]
    fn energy(&self, course: &Course<'_, W>, numbers: &[Numbers<W>]) -> Numbers<W> {
        let Places { way, way_low, .. } = course.plan.places;
        let mut sum = zeros::<W>();
        for (c, [mass, _]) in self.masses.iter().enumerate() {
            let v = &numbers[way + c];
            for l in 0..W {
                let mut square = v.0[l] * v.0[l];
                if course.sums {
                    square = (Fused(2.0) * v.0[l]).multiply_add(numbers[way_low + c].0[l], square);
                }
                sum.0[l] = mass.0[l].multiply_add(square, sum.0[l]);
            }
        }
        sum
    }

    /// Has all flows act in all lanes. G and M⁻¹Gᵀ are those where bodies are; ways, whose unit is 1, are along the
    /// constraints then. An error for the first lane in which a flow cannot act so.
    pub(super) fn act(
        &self,
        course: &Course<'_, W>,
        when: When,
        numbers: &mut [Numbers<W>],
        work: &mut [f64],
        answer: &mut Answer<'_, W>,
    ) -> Result<(), usize> {
        course.set.run(Acting { stirring: self, course, when, numbers, work, answer })
    }

    /// Adds noise of covariance M⁻¹.
    #[inline(always)]
    fn draw(&self, bath: &Bath<W>, turn: Turn, changes: &mut [Numbers<W>]) {
        let d = self.dimension;
        let of_body = d.div_ceil(4) as u64;
        for (first, body) in (0..self.masses.len()).step_by(d).zip(0_u64..) {
            for (four, draw) in (0..d).step_by(4).zip(body * of_body..) {
                let mut drawn = [[Fused(0.0); W]; 4];
                let drawn = &mut drawn[..(d - four).min(4)];
                self.rhythm.draw(&bath.seed, turn, draw, drawn);
                for (c, drawn) in (first + four..first + d).zip(drawn) {
                    let (over, to) = (&self.masses[c][1], &mut changes[c]);
                    for l in 0..W {
                        let size = bath.deviation.0[l] * over.0[l].sqrt();
                        to.0[l] = size.multiply_add(drawn[l], to.0[l]);
                    }
                }
            }
        }
    }

    /// Adds the changes of a linear flow, and what constraints give: with `entry(c, k)` of B in row c and column k of
    /// the body, or on the diagonal alone.
    #[inline(always)]
    fn finish(
        &self,
        course: &Course<'_, W>,
        rule: Rule,
        diagonal: bool,
        entry: impl Fn(usize, usize) -> Numbers<W>,
        numbers: &mut [Numbers<W>],
    ) -> Result<(), usize> {
        let plan = course.plan;
        let (d, half) = (self.dimension, Fused(0.5));
        let Places { free, lifted, diagonal: slopes, inverse, .. } = plan.places;
        add(course, free, numbers);
        if rule == Rule::Random || plan.equations == 0 {
            course.project(numbers);
            return Ok(());
        }
        for (block, of) in plan.of_entry.chunks(d).enumerate() {
            let from = lifted + block * d;
            for (i, &[c, _]) in of.iter().enumerate() {
                let mut turned = numbers[from + i];
                for k in 0..d {
                    if !diagonal || i == k {
                        let (b, of) = (entry(c, k), &numbers[from + k]);
                        for l in 0..W {
                            turned.0[l] = (half * b.0[l]).multiply_add(of.0[l], turned.0[l]);
                        }
                    }
                }
                numbers[free + i] = turned; // changes are added, and their place is free
            }
            numbers.copy_within(free..free + d, from);
        }
        course.project(numbers);
        let mut clear = [true; W];
        for i in 0..plan.equations {
            let (slope, inverse) = (&numbers[slopes + i], &numbers[inverse + i]);
            for l in 0..W {
                let (slope, inverse) = (slope.0[l].0, inverse.0[l].0);
                clear[l] &= (0.0 < inverse) & (inverse * slope <= PIVOT);
            }
        }
        plan.lift(course.over, numbers);
        clear.iter().position(|&clear| !clear).map_or(Ok(()), Err)
    }
}

/// See [`RowStirring::act`]. Work by itself: it is long, and a step asks for it more than once.
struct Acting<'a, 'b, 'c, const W: usize> {
    stirring: &'a RowStirring<W>,
    course: &'a Course<'b, W>,
    when: When,
    numbers: &'a mut [Numbers<W>],
    work: &'a mut [f64],
    answer: &'a mut Answer<'c, W>,
}

impl<const W: usize> Work for Acting<'_, '_, '_, W> {
    type Done = Result<(), usize>;

    #[inline(always)]
    fn run(self) -> Result<(), usize> {
        let Self { stirring, course, when, numbers, work, answer } = self;
        let before = stirring.energy(course, numbers);
        for turn in stirring.rhythm.turns(stirring.flows.len(), when) {
            match &stirring.flows[turn.number] {
                Stir::Bath(rule, bath) => {
                    let changes = course.plan.places.free;
                    for c in 0..stirring.masses.len() {
                        let mut change = numbers[course.plan.places.way + c];
                        for l in 0..W {
                            change.0[l] = bath.lost.0[l] * change.0[l];
                        }
                        numbers[changes + c] = change;
                    }
                    if bath.draws {
                        stirring.draw(bath, turn, &mut numbers[changes..]);
                    }
                    let half = |_: usize, _: usize| bath.lost;
                    stirring.finish(course, *rule, true, half, numbers)?;
                }
                Stir::Matrix(rule, matrix) => {
                    let Places { way, free: changes, .. } = course.plan.places;
                    let d = stirring.dimension;
                    for c in 0..stirring.masses.len() {
                        let (first, mut change) = (c - c % d, zeros::<W>());
                        for k in 0..d {
                            let (b, v) = (&matrix[c * d + k], &numbers[way + first + k]);
                            for l in 0..W {
                                change.0[l] = b.0[l].multiply_add(v.0[l], change.0[l]);
                            }
                        }
                        numbers[changes + c] = change;
                    }
                    let entry = |c: usize, k: usize| matrix[c * d + k];
                    stirring.finish(course, *rule, false, entry, numbers)?;
                }
                &Stir::Asked(rule) => {
                    course.set.run(Asking { stirring, course, rule, turn, numbers, answer })?;
                }
            }
        }
        let after = stirring.energy(course, numbers);
        for (l, work) in work.iter_mut().enumerate() {
            *work += 0.5 * (after.0[l] - before.0[l]).0;
        }
        Ok(())
    }
}

/// Has a flow that is asked act in all lanes.
struct Asking<'a, 'b, 'c, const W: usize> {
    stirring: &'a RowStirring<W>,
    course: &'a Course<'b, W>,
    rule: Rule,
    turn: Turn,
    numbers: &'a mut [Numbers<W>],
    answer: &'a mut Answer<'c, W>,
}

impl<const W: usize> Work for Asking<'_, '_, '_, W> {
    type Done = Result<(), usize>;

    #[inline(always)]
    fn run(self) -> Result<(), usize> {
        let Self { stirring, course, rule, turn, numbers, answer } = self;
        let Places { q, way, way_low, free, .. } = course.plan.places;
        let (n, one_half) = (stirring.masses.len(), Fused(0.5));
        let vectors = || vec![zeros::<W>(); n];
        let first = numbers[way..way + n].to_vec();
        let low = if course.sums { numbers[way_low..way_low + n].to_vec() } else { vectors() };
        let [mut changes, mut impulses, mut lacks, mut impulses_before, mut lacks_before, mut tried] =
            from_fn(|_| vectors());
        let mut going: Which<W> = [1; W];
        for round in 0..MOST_ROUNDS {
            for c in 0..n {
                for l in 0..W {
                    tried[c].0[l] = one_half.multiply_add(impulses[c].0[l], first[c].0[l]);
                }
            }
            let lanes = &going;
            let question = Question { turn, lanes, q: &numbers[q..q + n], v: &tried };
            answer(question, &mut changes);
            if rule == Rule::Random {
                for (c, change) in changes.iter().enumerate() {
                    numbers[free + c] = *change;
                }
                add(course, free, numbers);
                course.project(numbers);
                let fine = |l: usize| changes.iter().all(|change| change.0[l].0.is_finite());
                return (0..W).find(|&l| !fine(l)).map_or(Ok(()), Err);
            }
            for c in 0..n {
                numbers[way + c] = first[c];
                if course.sums {
                    numbers[way_low + c] = low[c];
                }
                let (change, impulse) = (&changes[c], &impulses[c]);
                for l in 0..W {
                    numbers[free + c].0[l] = change.0[l] + impulse.0[l];
                }
            }
            add(course, free, numbers);
            course.project(numbers);
            let (mut lack, mut size) = ([Fused(0.0); W], [Fused(f64::MIN_POSITIVE); W]);
            for c in 0..n {
                let (new, change) = (numbers[way + c], &changes[c]);
                let new_low = if course.sums { numbers[way_low + c] } else { low[c] };
                for l in 0..W {
                    let total = change.0[l] + impulses[c].0[l];
                    let own = (new.0[l] - first[c].0[l]) + (new_low.0[l] - low[c].0[l]) - total;
                    lacks[c].0[l] = own;
                    // NaN is told by what is not at rest: `max` may pass it over.
                    lack[l] = if own.abs().0 <= lack[l].0 { lack[l] } else { own.abs() };
                    size[l] = size[l].max(new.0[l].abs()).max(total.abs());
                }
            }
            for l in 0..W {
                let rests = lack[l].0 <= 8.0 * f64::EPSILON * size[l].0;
                going[l] = if rests || course.plan.equations == 0 && lack[l].0.is_finite() { 0 } else { 1 };
            }
            if going == [0; W] {
                return Ok(());
            }
            let (mut along, mut square) = ([Fused(0.0); W], [Fused(0.0); W]);
            for (now, then) in lacks.iter().zip(&lacks_before).take(if round > 0 { n } else { 0 }) {
                for l in 0..W {
                    let change = now.0[l] - then.0[l];
                    along[l] = change.multiply_add(now.0[l], along[l]);
                    square[l] = change.multiply_add(change, square[l]);
                }
            }
            for c in 0..n {
                for l in 0..W {
                    let gamma = if square[l].0 > 0.0 { along[l] / square[l] } else { Fused(0.0) };
                    let (impulse, lack) = (impulses[c].0[l], lacks[c].0[l]);
                    let next = impulse + lack;
                    let back = next - (impulses_before[c].0[l] + lacks_before[c].0[l]);
                    let next = if round > 0 { (-gamma).multiply_add(back, next) } else { next };
                    (impulses_before[c].0[l], lacks_before[c].0[l]) = (impulse, lack);
                    impulses[c].0[l] = if going[l] == 0 { impulse } else { next };
                }
            }
        }
        going.iter().position(|&going| going != 0).map_or(Ok(()), Err)
    }
}

/// Mass and 1 over it of each lane, by coordinate.
fn by_coordinate<'a, const W: usize>(lane: &dyn Fn(usize) -> &'a [[f64; 2]]) -> Vec<[Numbers<W>; 2]> {
    let number = |c: usize, of: usize| Lanes(from_fn(|l| Fused(lane(l)[c][of])));
    (0..lane(0).len()).map(|c| [number(c, 0), number(c, 1)]).collect()
}

/// Adds changes to ways; where sums are compensated, to their low digits.
#[inline(always)]
fn add<const W: usize>(course: &Course<'_, W>, changes: usize, numbers: &mut [Numbers<W>]) {
    let Places { way, way_low, .. } = course.plan.places;
    let to = if course.sums { way_low } else { way };
    for &c in &course.plan.moving {
        let (mut sum, change): (Numbers<W>, Numbers<W>) = (numbers[to + c], numbers[changes + c]);
        for l in 0..W {
            sum.0[l] = sum.0[l] + change.0[l];
        }
        numbers[to + c] = sum;
    }
}

/// The momenta or velocities of a lane, as flows are shown them.
#[inline(always)]
pub(super) fn vectors<const D: usize, const W: usize>(
    rows: &[Numbers<W>],
    lane: usize,
    times: impl Fn(usize, Number) -> f64,
) -> Vec<[f64; D]> {
    (0..rows.len() / D).map(|body| from_fn(|d| times(body * D + d, rows[body * D + d].0[lane]))).collect()
}
