//! A block of trajectories in lanes, in the form that suits the [RATTLE step](crate::run::ensemble::loops).
//!
//! ```text
//! q′ = q + h p + Λ ∇g(q)                          Λ such that g(q′) = 0
//! p′ = p + Λ/h ∇g(q) − k ∇U(q′) + ∇g(q′) η        η such that ∇g(q′)·p′ = 0
//! ```
//!
//! Momenta are stored *ahead*: after the first kick of the next step, projected to be tangent. So the second kick of a
//! step and the first kick of the next are one kick, of length k. Λ restores the normal component that the projection
//! removes, so positions are those of RATTLE; [`Block::momentum`] undoes the kick. Momenta are also stored multiplied
//! by the step length, as the *way* h p of the step: with equal steps the products h p and Λ/h vanish.
//!
//! **Equal steps need no projection.** The way h p + Λ ∇g(q) of a step is tangent to second order without projection,
//! and the next Λ corrects its normal component: η is 0, and Λ twice as large. This is the Störmer–Verlet method with
//! constraints (SHAKE: Ryckaert, Ciccotti, Berendsen 1977); positions are those of RATTLE to rounding.
//!
//! Every lane depends on its own past alone.

use crate::effect::moment::Moment;
use crate::error::Error;
use crate::kernel::functions::ConstraintKernel;
use crate::motion::bodies::Body;
use crate::motion::failure::Failure;
use crate::motion::method::Stage;
use crate::motion::record::{Reading, Record};
use crate::number::instructions::Work;
use crate::number::lanes::{Lane, is_finite};
use crate::number::vector::{add_scaled, dot, largest, scaled, sum, two_sum};
use crate::number::vectors::{Vectors, at, put};
use crate::run::ensemble::engine::Stuck;
use crate::run::ensemble::lane_record::{self, Rows};
use crate::run::ensemble::laws::Laws;
use crate::run::ensemble::rest::{measured_every, rest_square, squares_tell};
use crate::solve::crowd::{self, PATH, REACH, ROOT_3};
use crate::systems::surface::diagnosis::FailureAt;
use crate::systems::surface::normal::Normal;
use std::borrow::Borrow;

/// Less than any square: a lane is not at rest, and lost in any case.
pub(super) const LOST: f64 = -1.0;

/// The name of the row of [`Block::rest`] in checkpoints.
const REST: &str = "displacement at rest, squared";

/// The row that was written before in its place: what |g| may be, or [`LOST`].
const OLD_REST: &str = "rest";

/// Trajectories side by side. `SUMS` is 1 if positions and momenta are compensated sums, else 0; `EQUAL` says that a
/// step
/// is one stage.
#[derive(Clone)]
#[repr(C, align(64))]
pub(crate) struct Block<S, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool> {
    pub(super) q: Vectors<S, L, D>,
    /// Momenta, ahead by the first kick of the step to come, times [`Part::unit`].
    pub(super) way: Vectors<S, L, D>,
    /// ∇g(q).
    pub(super) normal: Vectors<S, L, D>,
    /// |∇g(q)|².
    pub(super) square: [S; L],
    /// What the displacement |g|/|∇g| may be at rest, squared, as [measured](Block::measure) last; [`LOST`] where the
    /// next step is to be made by the lane itself.
    pub(super) rest: [S; L],
    /// Λ₀ of the step to come.
    pub(super) guess: [S; L],
    /// Λ of the last two steps, the last one first, in units of the step to come.
    pub(super) past: [[S; L]; 2],
    pub(super) q_low: [Vectors<S, L, D>; SUMS],
    pub(super) way_low: [Vectors<S, L, D>; SUMS],
    /// The part of the method's step that comes next.
    pub(super) part: usize,
}

/// Numbers of one step, which need no keeping.
#[derive(Clone)]
#[repr(C, align(64))]
pub(crate) struct Scratch<S, const L: usize, const D: usize> {
    /// q + h p.
    pub(super) free: Vectors<S, L, D>,
    /// ∇g(q), when that of the block is already ∇g(q′).
    pub(super) old: Vectors<S, L, D>,
    /// ∇g at Λ₀.
    pub(super) first: Vectors<S, L, D>,
    /// Λ₁, Λ₂, and at last Λ.
    pub(super) multiplier: [S; L],
    /// 1/s.
    pub(super) over_slope: [S; L],
    /// g₀, 1/g₀, and then how far off Λ₂ is, squared, or not a number where the slope says that the surface may have
    /// been left.
    pub(super) g: [S; L],
}

impl<S: Lane, const L: usize, const D: usize> Scratch<S, L, D> {
    pub(crate) fn new() -> Self {
        let zero = [S::default(); L];
        Self {
            free: [zero; D],
            old: [zero; D],
            first: [zero; D],
            multiplier: zero,
            over_slope: zero,
            g: zero,
        }
    }
}

/// What a thread works on: all in one place, at a place of the same kind each time.
///
/// Processors take a number that is read for one that is still being written where the addresses differ by a multiple
/// of 4096, and wait. On a Zen 4 they do so depending on the pages of memory that happen to be used. Of doubles, rows
/// are an eighth of that long, so that lanes of the scratch that are written lie there with lanes of the block that are
/// read soon. `apart` and the end of the block have that be three vectors later, when the numbers are written. Where it
/// was the next vector, one process in six took 1.8 to 2.5 times as long.
#[repr(C, align(4096))]
pub(super) struct Desk<S, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool> {
    pub(super) block: Block<S, L, D, SUMS, EQUAL>,
    apart: [u8; 128],
    pub(super) scratch: Scratch<S, L, D>,
}

impl<S: Lane, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool>
    Desk<S, L, D, SUMS, EQUAL>
{
    /// With this block.
    #[inline(always)]
    pub(super) fn of(block: Block<S, L, D, SUMS, EQUAL>) -> Self {
        Self { block, apart: [0; 128], scratch: Scratch::new() }
    }
}

/// One RATTLE step of a method.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Part {
    /// Its length.
    pub(super) h: f64,
    /// What momenta are kept times: h where all steps are equal, else 1.
    pub(super) unit: f64,
    /// The unit over the length, and what rounding took from that: it is the same in each step, so that energy would
    /// drift.
    pub(super) over: [f64; 2],
    /// The kick before it, by which momenta are ahead.
    pub(super) lead: f64,
    /// The kick after it, and that before the next one.
    pub(super) kick: f64,
    /// Λ of the step before it in terms of its own.
    pub(super) before: f64,
    /// By which |Λ| of this step is multiplied to be that of the longest, [`REACH`] times.
    pub(super) reach: f64,
    /// By which Λ of this step and the last ones are extrapolated to the next, that of this one first.
    pub(super) weights: [f64; 3],
}

impl Part {
    /// The parts of a method that consists of these stages, taken in turn again and again.
    ///
    /// In steps of one stage Λ/h² is a smooth function of time and extrapolated quadratically. In others linearly, Λ
    /// taken to be that
    /// of a third of the stage, unless that lies far away; where a kick stands between two drifts that is a coarser
    /// guess.
    #[inline(never)]
    pub(crate) fn of<const EQUAL: bool>(stages: &[Stage]) -> Vec<Part> {
        let n = stages.len();
        let at = |i: usize| stages[i % n].h;
        let part = |i: usize| {
            let (before, h, next) = (at(i + n - 1), at(i), at(i + 1));
            let (last, earlier) = (h + next / 3.0 - h / 3.0, before + h / 3.0 - before / 3.0);
            let far = last / earlier;
            let far = if far.abs() <= 2.0 { far } else { 0.0 };
            let linear = [(1.0 + far) * (next / h).powi(2), -far * (next / before).powi(2), 0.0];
            let weights = if n == 1 { [3.0, -3.0, 1.0] } else { linear };
            let unit = if EQUAL { h } else { 1.0 };
            let Stage { before: lead, after, .. } = stages[i];
            let kick = after + stages[(i + 1) % n].before;
            let reach = REACH * stages.iter().map(|stage| (stage.h / h).powi(2)).fold(1.0, f64::max);
            let over = unit / h;
            let over = [over, (-over).mul_add(h, unit) / h];
            Part { h, unit, over, lead, kick, before: (before / h).powi(2), reach, weights }
        };
        (0..n).map(part).collect()
    }

    /// How many times as far as momenta that are kept the longest of these parts leads.
    pub(super) fn longest(parts: &[Self]) -> f64 {
        parts.iter().map(|part| (part.h / part.unit).abs()).fold(0.0, f64::max)
    }

    /// By how much forces are multiplied to be what they push in a step, as far as it is asked for that.
    #[inline(always)]
    pub(super) fn push<S: Lane>(&self) -> S {
        S::from_f64(self.reach * self.h * self.kick)
    }

    /// How far it is asked whether other sheets are near, in normals: where Λ is this, the momentum no less than that,
    /// and forces [push](Self::push) so.
    #[inline(always)]
    pub(super) fn furthest<S: Lane, const D: usize>(
        &self,
        back: S,
        way: &[S; D],
        pushed: &[S; D],
        normal: &[S; D],
        square: S,
        least: f64,
    ) -> S {
        let &Self { h, unit, reach, .. } = self;
        let [reach, path] = [reach, reach * PATH * (h / unit).abs()].map(S::from_f64);
        // Lengths by their largest coordinate: roots take long.
        let over = S::from_f64(ROOT_3) * largest(normal) / square;
        let along = over * path * largest(way).max(S::from_f64(unit * least));
        crowd::furthest(reach * back, along, over * largest(pushed))
    }

    /// Λ of a step that is guessed from g̈ alone, in a lane that is there and goes so: after one that was lost, and
    /// moved by itself. |∇g| may have changed by any factor there, and what is extrapolated from Λ before may lead to
    /// any sheet. Also whether other sheets have come near, or the step is too long for the curvature.
    #[cold]
    #[inline(never)]
    pub(super) fn guess_anew<S: Lane, const D: usize>(
        &self,
        laws: &impl Laws<S, D>,
        lane: usize,
        (q, way, normal, square): ([S; D], [S; D], [S; D], S),
    ) -> (S, bool) {
        let constraint = laws.constraint(lane);
        let path = scaled(S::from_f64(self.h / self.unit), &way);
        let [bend] = constraint.borrow().jet(&q, &path).2;
        let guess = -S::from_f64(0.5).multiply_add(bend, dot(&normal, &path)) / square;
        let pushed = laws.kick(lane, &q, self.push(), [S::default(); D]);
        let furthest = self.furthest(guess.abs(), &way, &pushed, &normal, square, 0.0);
        // As a simulation asks, h·κ·|v| ≤ 1.
        let turns_little = (bend * bend).le(square * dot(&path, &path));
        let alone = crowd::is_alone(constraint.borrow(), 0, [&q, &normal], square, furthest);
        (guess, !(turns_little & alone))
    }

    /// What the kick before it makes of something, if there is one; this way or that.
    #[inline(always)]
    fn led<S: Lane, X>(&self, way: f64, kicked: impl FnOnce(S) -> X, still: X) -> X {
        if self.lead == 0.0 { still } else { kicked(S::from_f64(way * self.lead)) }
    }
}

/// The sum of the components.
#[inline(always)]
fn total<S: Lane, const D: usize>(x: &[S; D]) -> S {
    let mut sum = x[0];
    for &component in &x[1..] {
        sum = sum + component;
    }
    sum
}

/// The first guess for the next step from what the last three found: by the [weights](Part::weights), which are 3, −3
/// and 1 where all steps are equal.
#[inline(always)]
pub(super) fn extrapolated<S: Lane>(equal: bool, [a, b, c]: [S; 3], found: S, last: S, earlier: S) -> S {
    if equal {
        S::from_f64(3.0).multiply_add(found - last, earlier)
    } else {
        a.multiply_add(found, b.multiply_add(last, c * earlier))
    }
}

impl<S: Lane, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool>
    Block<S, L, D, SUMS, EQUAL>
{
    /// A block in which no lane is set.
    pub(crate) fn new() -> Self {
        let zero = [S::default(); L];
        let vectors = [zero; D];
        Self {
            q: vectors,
            way: vectors,
            normal: vectors,
            square: zero,
            rest: zero,
            guess: zero,
            past: [zero; 2],
            q_low: [vectors; SUMS],
            way_low: [vectors; SUMS],
            part: 0,
        }
    }

    /// Puts a trajectory at q with momentum p, which are along the constraint, into a lane; `parts` are those of the
    /// method, of which the block's is to come. False where the lane cannot hold it: where the first guess is farther
    /// off than twice the path of the step, which then has no end on the surface, it takes the digits of the way; where
    /// either is no number; and where all is so small that [squares](squares_tell) of rounding are nothing.
    #[inline(always)]
    fn set(
        &mut self,
        lane: usize,
        laws: &impl Laws<S, D>,
        parts: &[Part],
        q: [[S; D]; 2],
        p: [[S; D]; 2],
    ) -> bool {
        let (part, constraint) = (&parts[self.part], laws.constraint(lane));
        let (h, unit) = (S::from_f64(part.h), S::from_f64(part.unit));
        let [gradient] = constraint.borrow().jacobian(&q[0]);
        let normal = Normal::new(gradient);
        let pushed = part.led(1.0, |kick| laws.kick(lane, &q[0], kick, p[1]), p[1]);
        let (_, back) = normal.projection(&sum(&p[0], &pushed));
        let (ahead, ahead_low) = two_sum(&p[0], &sum(&pushed, &back));
        let [bend] = constraint.borrow().jet(&q[0], &ahead).2;
        let guess = S::from_f64(-0.5) * h * h * bend * normal.inverse_square;
        let (path, off) = (h * h * dot(&ahead, &ahead), guess * guess * dot(&gradient, &gradient));
        let holds = (S::from_f64(4.0) * off).le(path) && is_finite(path) // h·κ·|v| ≤ 1
            && squares_tell(largest(&q[0]).max((h * largest(&ahead)).abs()));
        // Equal steps: as if one had led here, which would have left half of Λ in the way.
        let ahead = if EQUAL { add_scaled(&ahead, -guess / h, &gradient) } else { ahead };
        let guess = if EQUAL { guess + guess } else { guess };
        put(&mut self.q, lane, q[0]);
        put(&mut self.way, lane, scaled(unit, &ahead));
        for (low, x) in [(&mut self.q_low, q[1]), (&mut self.way_low, scaled(unit, &ahead_low))] {
            if let Some(low) = low.first_mut() {
                put(low, lane, x);
            }
        }
        put(&mut self.normal, lane, gradient);
        self.square[lane] = dot(&gradient, &gradient);
        self.rest[lane] = rest_square(&gradient, self.square[lane], &q[0]);
        self.guess[lane] = guess;
        for past in &mut self.past {
            past[lane] = S::from_f64(part.before) * guess;
        }
        holds
    }

    /// [Measures](Self::measure) after so many steps, if it is time to.
    #[inline(always)]
    pub(super) fn measure_after(&mut self, steps: u64) {
        if steps.is_multiple_of(const { measured_every::<S>() }) {
            self.measure();
        }
    }

    /// Measures what displacements may be at rest. How large places are changes little from time to time, and how large
    /// |∇g| is takes no part.
    #[inline(always)]
    fn measure(&mut self) {
        let Self { q, normal, square, rest, .. } = self;
        for i in 0..L {
            let measured = rest_square(&at(normal, i), square[i], &at(q, i));
            rest[i] = S::select(rest[i].lt(S::default()), rest[i], measured);
        }
    }

    /// Copies a lane.
    pub(crate) fn copy(&mut self, from: usize, to: usize) {
        self.rows().into_iter().for_each(|(_, numbers)| numbers[to] = numbers[from]);
    }

    /// Position of a lane, and what rounding took from it.
    #[inline(always)]
    fn position(&self, lane: usize) -> [[S; D]; 2] {
        [at(&self.q, lane), self.q_low.first().map_or([S::default(); D], |low| at(low, lane))]
    }

    /// Momentum of a lane, and what rounding took from it: with the kick of the step to come taken back, and along the
    /// surface where the trajectory is, not where it was before the last correction.
    #[inline(always)]
    fn momentum(&self, lane: usize, laws: &impl Laws<S, D>, parts: &[Part]) -> [[S; D]; 2] {
        let part = &parts[self.part];
        let over = S::from_f64(1.0 / part.unit);
        let ahead = scaled(over, &at(&self.way, lane));
        let low = match self.way_low.first() {
            Some(low) => scaled(over, &at(low, lane)),
            None => [S::default(); D],
        };
        let q = at(&self.q, lane);
        let [gradient] = laws.constraint(lane).borrow().jacobian(&q);
        let normal = Normal::new(gradient);
        let change = part.led(-1.0, |kick| laws.kick(lane, &q, kick, low), low);
        let (_, back) = normal.projection(&sum(&ahead, &change));
        let (p, low) = two_sum(&ahead, &sum(&change, &back));
        [p, if const { SUMS == 0 } { [S::default(); D] } else { low }]
    }

    /// The body of a lane.
    #[inline(always)]
    fn body(&self, lane: usize, laws: &impl Laws<S, D>, parts: &[Part]) -> Body<S, D> {
        let ([q, q_low], [p, p_low]) = (self.position(lane), self.momentum(lane, laws, parts));
        Body { q, q_low, p, p_low }
    }

    /// Positions and momenta of all lanes, see [`momentum`](Self::momentum).
    #[inline(always)]
    pub(crate) fn all(&self, laws: &impl Laws<S, D>, parts: &[Part]) -> (Vectors<S, L, D>, Vectors<S, L, D>) {
        let mut momenta = [[S::default(); L]; D];
        for lane in 0..L {
            let [p, _] = self.momentum(lane, laws, parts);
            put(&mut momenta, lane, p);
        }
        (self.q, momenta)
    }

    /// Writes all lanes.
    pub(crate) fn record(&self, to: &mut Record) {
        lane_record::write(self.clone().rows(), to);
        to.counts("part", [self.part as u64]);
    }

    /// The block that was written, of a method of so many parts.
    pub(crate) fn recalled(from: &mut Reading<'_>, parts: usize) -> Result<Self, Error> {
        let mut block = Self::new();
        let mut rows = block.rows();
        let first = rows.iter().position(|(name, _)| *name == REST).unwrap_or(0);
        let mut then = rows.split_off(first);
        lane_record::read(rows, from)?;
        from.pass_over("bias");
        let is_old = from.is_next(OLD_REST);
        if is_old {
            then[0].0 = OLD_REST;
        }
        lane_record::read(then, from)?;
        if is_old {
            block.measure();
        }
        let [part] = from.counted("part")?;
        block.part = part as usize % parts;
        Ok(block)
    }

    /// Each row of numbers, one of each lane.
    #[inline(never)]
    pub(super) fn rows(&mut self) -> Rows<'_, S> {
        let Self { q, way, normal, square, rest, guess, past: [last, earlier], q_low, way_low, .. } = self;
        let mut rows: Rows<'_, S> = Vec::new();
        for (name, vectors) in [("q", &mut q[..]), ("way", way), ("normal", normal)] {
            vectors.iter_mut().for_each(|numbers| rows.push((name, numbers)));
        }
        for (name, vectors) in [("q rounding", q_low), ("way rounding", way_low)] {
            vectors.as_flattened_mut().iter_mut().for_each(|numbers| rows.push((name, numbers)));
        }
        let numbers = [("square", &mut square[..]), (REST, rest), ("guess", guess)];
        rows.extend(numbers.into_iter().chain([("last", &mut last[..]), ("earlier", earlier)]));
        rows
    }

    /// Whether all momenta are numbers, as they are kept and as they are shown.
    #[inline(always)]
    pub(crate) fn check(&self, laws: &impl Laws<S, D>, parts: &[Part]) -> Result<(), Stuck> {
        for lane in 0..L {
            let [shown, _] = self.momentum(lane, laws, parts);
            if !is_finite(total(&at(&self.way, lane)) + total(&shown)) {
                let failure = not_finite(laws, lane, at(&self.q, lane));
                return Err(Stuck { lane, failure: Some(failure) });
            }
        }
        Ok(())
    }
}

/// A block and what its lanes obey, of which one lane is set or shown: as narrow work, which fuses.
pub(super) struct OfLane<'a, B, X> {
    pub(super) block: B,
    pub(super) lane: usize,
    pub(super) laws: &'a X,
    pub(super) parts: &'a [Part],
}

/// Shows the body there.
impl<S, X, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool> Work
    for OfLane<'_, &Block<S, L, D, SUMS, EQUAL>, X>
where
    S: Lane,
    X: Laws<S, D>,
{
    type Done = Body<f64, D>;

    #[inline(always)]
    fn run(self) -> Body<f64, D> {
        let Self { block, lane, laws, parts } = self;
        block.body(lane, laws, parts).map(S::to_f64)
    }
}

/// Puts a body there; returns whether the lane can hold it, and whether what is shown of its momentum are numbers.
impl<S, X, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool> Work
    for (OfLane<'_, &mut Block<S, L, D, SUMS, EQUAL>, X>, Body<S, D>)
where
    S: Lane,
    X: Laws<S, D>,
{
    type Done = [bool; 2];

    #[inline(always)]
    fn run(self) -> [bool; 2] {
        let (OfLane { block, lane, laws, parts }, Body { q, q_low, p, p_low }) = self;
        let holds = block.set(lane, laws, parts, [q, q_low], [p, p_low]);
        let mut numbers = true;
        for p in block.momentum(lane, laws, parts)[0] {
            numbers &= is_finite(p);
        }
        [holds, numbers]
    }
}

/// Why a lane's momentum is not finite.
#[cold]
#[inline(never)]
pub(super) fn not_finite<S: Lane, const D: usize>(laws: &impl Laws<S, D>, lane: usize, q: [S; D]) -> Failure {
    let [gradient] = laws.constraint(lane).borrow().jacobian(&q);
    let at = Moment { time: 0.0, positions: &[q] };
    FailureAt::of(0).not_finite(laws.effects(lane).borrow(), at, &[Normal::new(gradient)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::lanes::Fused;

    #[test]
    fn a_record_with_rows_that_are_gone_is_read() {
        let mut block = Block::<Fused<f64>, 2, 3, 1, true>::new();
        for (row, (_, numbers)) in block.rows().into_iter().enumerate() {
            numbers.iter_mut().enumerate().for_each(|(i, x)| *x = Fused((2 * row + i) as f64));
        }
        block.measure();
        block.rest[1] = Fused(LOST);
        for (biased, old) in [(false, false), (false, true), (true, true)] {
            let mut record = Record::default();
            for (name, numbers) in block.rows() {
                if name == REST && biased {
                    record.numbers("bias", &[2], [0.5; 2]);
                }
                match name {
                    REST if old => record.numbers(OLD_REST, &[2], [1e-14, LOST]),
                    _ => record.numbers(name, &[2], numbers.iter().map(|x| x.0)),
                }
            }
            record.counts("part", [0]);
            let mut read = Block::<Fused<f64>, 2, 3, 1, true>::recalled(&mut record.read(), 1).unwrap();
            assert!(read.rows() == block.rows(), "{biased} {old}");
        }
    }
}
