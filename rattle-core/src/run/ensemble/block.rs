//! A block of trajectories side by side, and the RATTLE step that moves all of them on.
//!
//! ```text
//! q′ = q + h p + Λ ∇g(q)                          Λ such that g(q′) = 0
//! p′ = p + Λ/h ∇g(q) − k ∇U(q′) + ∇g(q′) η        η such that ∇g(q′)·p′ = 0
//! ```
//!
//! Momenta are kept *ahead*: after the first kick of the step to come, and made tangent again. The second kick of a step
//! and the first of the next are then one, of length k. What the projection takes away Λ puts back, so positions are those
//! of RATTLE; [`Block::momentum`] takes the kick back. And they are kept times the length of a step, as the *way* that they
//! lead in it: in a method of equal steps no product is left of h p and Λ/h.
//!
//! **Equal steps need no projection.** The way that is left of a step, h p + Λ ∇g(q), leads along the surface to second
//! order as it is, and what it leads off Λ puts back at once: η is 0, a Λ twice as large. This is how Störmer's and Verlet's
//! method is written with constraints (SHAKE: Ryckaert, Ciccotti, Berendsen 1977); places are those of RATTLE to rounding.
//!
//! **The step in four loops**, plain enough that a compiler vectorises them, and each short: what a processor has in flight
//! at a time is some two hundred instructions, so that a loop takes a time of (its instructions) × (the latency of its longest
//! chain), until its arithmetic alone takes longer. [`guess`] evaluates g and ∇g at Λ₀, extrapolated from the last steps;
//! [`improve`] evaluates g₁ after the Newton step Λ₁ = Λ₀ − g₀/s, s = ∇g(q′)·∇g(q), and goes on to the root of the parabola
//! through g₀, s and g₁,
//!
//! ```text
//! Λ₂ = Λ₁ − (g₁/s) (1 + 2t + 5t² + …),   t = g₁/g₀         (the coefficients: binomials of Catalan's numbers)
//! ```
//!
//! [`examine`] evaluates g and ∇g at Λ₂, and makes the last small correction −g₂/s; [`finish`] makes the new way. Without the
//! third term of the series three times as many steps need a further correction.
//!
//! **Extrapolation** is of Λ|∇g(q)|², a second derivative of g along the path, since Λ itself varies with |∇g| too: with it
//! a third as many steps need a further correction. The last Λ are kept in units of the step to come. What |∇g|² changes by is
//! not waited for: it is (|∇g(q)|²/s)², but for a factor near 1 that is taken from the step before.
//!
//! **Stopping.** A displacement |g|/|∇g| of at most 256 ε|q|∞ is left to the last correction, which leaves what chord steps
//! leave of it, less than rounding does. Where it is larger, the lane is corrected again by itself. The normal is then that
//! of a point less than 256 ε|q|∞ away.
//!
//! **Which root.** |∇g(q)|²/s must be between 2/3 and 2. Lanes where it is not, or that three corrections do not bring to
//! rest, are solved as a [`Simulation`](crate::run::simulation::Simulation) does. Sheets of a surface that lie closer to each
//! other than guesses are off, some part of κ(h|p|)², can still be taken for one another.
//!
//! Every lane is a function of its own past alone.

use crate::effect::moment::Moment;
use crate::kernel::functions::ConstraintKernel;
use crate::motion::failure::Failure;
use crate::number::lanes::Lane;
use crate::number::vector::{add_scaled, dot, largest, scaled, sum, two_sum};
use crate::run::ensemble::laws::Laws;
use crate::systems::surface::diagnosis::FailureAt;
use crate::systems::surface::normal::Normal;
use crate::systems::surface::position::Departure;
use crate::systems::surface::step::land;
use std::array::from_fn;
use std::borrow::Borrow;

/// Left to the last correction: so many ε of the largest coordinate.
const AT_REST: f64 = 256.0;

/// Corrections of a lane, beyond those that all lanes have, before it is solved by itself.
const CORRECTIONS: usize = 3;

/// Steps that are shorter would take digits from momenta that are kept times h.
const SHORT: f64 = 1e-15;

/// D coordinates of L trajectories.
type Vectors<S, const L: usize, const D: usize> = [[S; L]; D];

/// Trajectories side by side. `SUMS` is 1 if positions and momenta are compensated sums, else 0.
#[derive(Clone)]
#[repr(C, align(64))]
pub(crate) struct Block<S, const L: usize, const D: usize, const SUMS: usize> {
    q: Vectors<S, L, D>,
    /// Momenta, ahead by the first kick of the step to come, times [`Part::unit`].
    way: Vectors<S, L, D>,
    /// ∇g(q): the one of the two that `even` says.
    normal: [Vectors<S, L, D>; 2],
    /// |∇g(q)|².
    square: [S; L],
    /// |∇g(q)|²/|∇g(q′)|² of the last step, by (|∇g(q)|²/s)².
    bias: [S; L],
    /// What |g| may be at rest.
    rest: [S; L],
    /// Λ₀ of the step to come.
    guess: [S; L],
    /// Λ of the last two steps, the last one first, in units of the step to come.
    past: [[S; L]; 2],
    q_low: [Vectors<S, L, D>; SUMS],
    way_low: [Vectors<S, L, D>; SUMS],
    even: bool,
    /// The part of the method's step that comes next.
    part: usize,
}

/// Numbers of one step, which need no keeping.
#[derive(Clone)]
#[repr(C, align(64))]
pub(crate) struct Scratch<S, const L: usize, const D: usize> {
    /// q + h p.
    free: Vectors<S, L, D>,
    /// Λ₁, Λ₂, and at last Λ.
    multiplier: [S; L],
    /// 1/s.
    over_slope: [S; L],
    /// g₀, and then g₂, or not a number where the slope says that the surface may have been left.
    g: [S; L],
}

impl<S: Lane, const L: usize, const D: usize> Scratch<S, L, D> {
    pub(crate) fn new() -> Self {
        let zero = [S::default(); L];
        Self { free: [zero; D], multiplier: zero, over_slope: zero, g: zero }
    }
}

/// One RATTLE step of a method.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Part {
    /// Its length.
    h: f64,
    /// What momenta are kept times: h where all steps are equal, else 1.
    unit: f64,
    /// The kick after it.
    kick: f64,
    /// Λ of the step before it in terms of its own.
    before: f64,
    /// By which Λ of this step and the last ones are extrapolated to the next, that of this one first.
    weights: [f64; 3],
}

impl Part {
    pub(crate) fn length(&self) -> f64 {
        self.h
    }

    /// Whether all steps are of one length, and momenta kept times it.
    pub(crate) fn are_equal(parts: &[Part]) -> bool {
        parts.len() == 1 && parts[0].unit == parts[0].h
    }

    /// The parts of a method that takes RATTLE steps of these lengths in turn, again and again.
    ///
    /// Λ/h² is a smooth function of time. In steps of one length it is extrapolated quadratically. In steps of different
    /// lengths linearly, Λ taken to be that of a third of the step, unless that lies far away.
    pub(crate) fn of(lengths: &[f64]) -> Vec<Part> {
        let n = lengths.len();
        let at = |i: usize| lengths[i % n];
        let part = |i: usize| {
            let (before, h, next) = (at(i + n - 1), at(i), at(i + 1));
            let (last, earlier) = (h + next / 3.0 - h / 3.0, before + h / 3.0 - before / 3.0);
            let far = last / earlier;
            let far = if far.abs() <= 2.0 { far } else { 0.0 };
            let linear = [(1.0 + far) * (next / h).powi(2), -far * (next / before).powi(2), 0.0];
            let equal = n == 1 && h.abs() >= SHORT;
            let weights = if n == 1 { [3.0, -3.0, 1.0] } else { linear };
            let unit = if equal { h } else { 1.0 };
            Part { h, unit, kick: 0.5 * (h + next), before: (before / h).powi(2), weights }
        };
        (0..n).map(part).collect()
    }
}

/// A lane that cannot be moved, and why.
pub(crate) struct Stuck {
    pub(crate) lane: usize,
    pub(crate) failure: Failure,
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

/// Neither infinite nor NaN.
#[inline(always)]
fn is_finite<S: Lane>(x: S) -> bool {
    let zero = x * S::default(); // or NaN
    zero.le(zero)
}

#[inline(always)]
fn at<S: Copy, const L: usize, const D: usize>(vectors: &Vectors<S, L, D>, lane: usize) -> [S; D] {
    from_fn(|d| vectors[d][lane])
}

#[inline(always)]
fn put<S: Copy, const L: usize, const D: usize>(vectors: &mut Vectors<S, L, D>, lane: usize, x: [S; D]) {
    for d in 0..D {
        vectors[d][lane] = x[d];
    }
}

/// x + c·y; x + y where steps are equal.
#[inline(always)]
fn plus<S: Lane, const D: usize, const EQUAL: bool>(x: &[S; D], c: S, y: &[S; D]) -> [S; D] {
    if EQUAL { sum(x, y) } else { add_scaled(x, c, y) }
}

/// q′ − q without the constraint, beyond the way of a step: what sums have kept back.
#[inline(always)]
fn kept_back<S: Lane, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool>(
    share: S,
    q_low: &[Vectors<S, L, D>; SUMS],
    way_low: &[Vectors<S, L, D>; SUMS],
    lane: usize,
) -> [S; D] {
    if SUMS == 0 {
        return [S::default(); D];
    }
    plus::<S, D, EQUAL>(&at(&q_low[0], lane), share, &at(&way_low[0], lane))
}

impl<S: Lane, const L: usize, const D: usize, const SUMS: usize> Block<S, L, D, SUMS> {
    /// A block in which no lane is set.
    pub(crate) fn new() -> Self {
        let zero = [S::default(); L];
        let vectors = [zero; D];
        Self {
            q: vectors,
            way: vectors,
            normal: [vectors; 2],
            square: zero,
            bias: zero,
            rest: zero,
            guess: zero,
            past: [zero; 2],
            q_low: [vectors; SUMS],
            way_low: [vectors; SUMS],
            even: true,
            part: 0,
        }
    }

    /// Puts a trajectory at q with momentum p, which are along the constraint, into a lane; `parts` are those of the
    /// method, of which the block's is to come.
    pub(crate) fn set(
        &mut self,
        lane: usize,
        laws: &impl Laws<S, D>,
        parts: &[Part],
        q: [[S; D]; 2],
        p: [[S; D]; 2],
    ) {
        let (part, constraint) = (&parts[self.part], laws.constraint(lane));
        let (h, unit) = (S::from_f64(part.h), S::from_f64(part.unit));
        let [gradient] = constraint.borrow().jacobian(&q[0]);
        let normal = Normal::new(gradient);
        let pushed = laws.kick(lane, &q[0], S::from_f64(0.5) * h, p[1]);
        let (_, back) = normal.projection(&sum(&p[0], &pushed));
        let (ahead, ahead_low) = two_sum(&p[0], &sum(&pushed, &back));
        let [bend] = constraint.borrow().jet(&q[0], &ahead).2;
        let guess = S::from_f64(-0.5) * h * h * bend * normal.inverse_square;
        // Equal steps: as if one had led here, which would have left half of Λ in the way.
        let equal = Part::are_equal(parts);
        let ahead = if equal { add_scaled(&ahead, -guess / h, &gradient) } else { ahead };
        let guess = if equal { guess + guess } else { guess };
        put(&mut self.q, lane, q[0]);
        put(&mut self.way, lane, scaled(unit, &ahead));
        let way_low = scaled(unit, &ahead_low);
        for (low, x) in self.q_low.iter_mut().zip([q[1]]).chain(self.way_low.iter_mut().zip([way_low])) {
            put(low, lane, x);
        }
        put(&mut self.normal[usize::from(!self.even)], lane, gradient);
        self.square[lane] = dot(&gradient, &gradient);
        self.bias[lane] = S::from_f64(1.0);
        self.rest[lane] = at_rest(&gradient, &q[0]);
        self.guess[lane] = guess;
        for past in &mut self.past {
            past[lane] = S::from_f64(part.before) * guess;
        }
    }

    /// Copies a lane.
    pub(crate) fn copy(&mut self, from: usize, to: usize) {
        let vectors = [&mut self.q, &mut self.way].into_iter().chain(&mut self.normal);
        let vectors = vectors.chain(&mut self.q_low).chain(&mut self.way_low).flatten();
        for numbers in vectors
            .chain([&mut self.square, &mut self.bias, &mut self.rest, &mut self.guess])
            .chain(&mut self.past)
        {
            numbers[to] = numbers[from];
        }
    }

    /// Position of a lane, and what rounding took from it.
    #[inline(always)]
    pub(crate) fn position(&self, lane: usize) -> [[S; D]; 2] {
        [at(&self.q, lane), self.q_low.first().map_or([S::default(); D], |low| at(low, lane))]
    }

    /// Momentum of a lane, and what rounding took from it: with the kick of the step to come taken back, and along the
    /// surface where the trajectory is, not where it was before the last correction.
    #[inline(always)]
    pub(crate) fn momentum(&self, lane: usize, laws: &impl Laws<S, D>, parts: &[Part]) -> [[S; D]; 2] {
        let part = &parts[self.part];
        let over = S::from_f64(1.0 / part.unit);
        let ahead = scaled(over, &at(&self.way, lane));
        let low = self.way_low.first().map_or([S::default(); D], |low| scaled(over, &at(low, lane)));
        let q = at(&self.q, lane);
        let [gradient] = laws.constraint(lane).borrow().jacobian(&q);
        let normal = Normal::new(gradient);
        let kick = S::from_f64(-0.5 * part.h);
        let change = laws.kick(lane, &q, kick, low);
        let (_, back) = normal.projection(&sum(&ahead, &change));
        let (p, low) = two_sum(&ahead, &sum(&change, &back));
        [p, low.map(|x| if SUMS == 0 { S::default() } else { x })]
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

    /// Whether all momenta are numbers.
    #[inline(always)]
    pub(crate) fn check(&self, laws: &impl Laws<S, D>) -> Result<(), Stuck> {
        for lane in 0..L {
            if !is_finite(total(&at(&self.way, lane))) {
                return Err(Stuck { lane, failure: not_finite(laws, lane, at(&self.q, lane)) });
            }
        }
        Ok(())
    }

    /// Moves all lanes through the next part of a step; `EQUAL` says that all parts are of one length. Where one cannot be
    /// moved the block is left half way.
    #[inline(always)]
    pub(crate) fn advance<const EQUAL: bool>(
        &mut self,
        laws: &impl Laws<S, D>,
        parts: &[Part],
        scratch: &mut Scratch<S, L, D>,
    ) -> Result<(), Stuck> {
        let part = &parts[self.part];
        let [even, odd] = &mut self.normal;
        let (q, way, low) = (&mut self.q, &mut self.way, (&mut self.q_low, &mut self.way_low));
        let (square, bias, rest) = (&mut self.square, &mut self.bias, &mut self.rest);
        let (guess, past) = (&mut self.guess, &mut self.past);
        // Written out twice, since compilers must see which of the two is read and which is written.
        if self.even {
            let normal = (&*even, odd);
            advance::<S, L, D, SUMS, EQUAL>(
                laws, part, q, way, low, normal, square, bias, rest, guess, past, scratch,
            )?;
        } else {
            let normal = (&*odd, even);
            advance::<S, L, D, SUMS, EQUAL>(
                laws, part, q, way, low, normal, square, bias, rest, guess, past, scratch,
            )?;
        }
        self.even = !self.even;
        self.part = if self.part + 1 == parts.len() { 0 } else { self.part + 1 };
        Ok(())
    }
}

/// What |g| may be at rest: `AT_REST` ε |q|∞ |∇g|∞, for |∇g| and |q| to a factor of √3 in space.
#[inline(always)]
fn at_rest<S: Lane, const D: usize>(gradient: &[S; D], q: &[S; D]) -> S {
    S::from_f64(AT_REST * S::EPSILON) * largest(gradient) * largest(q)
}

type Of<'a, S, const L: usize, const D: usize, const SUMS: usize> =
    (&'a mut [Vectors<S, L, D>; SUMS], &'a mut [Vectors<S, L, D>; SUMS]);

/// Why a lane's momentum is not finite.
#[cold]
#[inline(never)]
fn not_finite<S: Lane, const D: usize>(laws: &impl Laws<S, D>, lane: usize, q: [S; D]) -> Failure {
    let [gradient] = laws.constraint(lane).borrow().jacobian(&q);
    let at = Moment { time: 0.0, positions: &[q] };
    FailureAt::of(0, false).not_finite(laws.effects(lane).borrow(), at, &[Normal::new(gradient)])
}

/// One part of a step. What it works on are arguments one by one, since compilers then know that no two overlap.
#[allow(clippy::too_many_arguments, reason = "see above")]
#[inline(always)]
fn advance<S, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool>(
    laws: &impl Laws<S, D>,
    part: &Part,
    q: &mut Vectors<S, L, D>,
    way: &mut Vectors<S, L, D>,
    (q_low, way_low): Of<'_, S, L, D, SUMS>,
    (normal, next): (&Vectors<S, L, D>, &mut Vectors<S, L, D>),
    square: &mut [S; L],
    bias: &mut [S; L],
    rest: &mut [S; L],
    first: &mut [S; L],
    past: &mut [[S; L]; 2],
    scratch: &mut Scratch<S, L, D>,
) -> Result<(), Stuck>
where
    S: Lane,
{
    let Scratch { free, multiplier, over_slope, g } = scratch;
    let share = S::from_f64(part.h / part.unit);
    guess::<S, L, D, SUMS, EQUAL>(
        laws, share, q, way, q_low, way_low, normal, first, free, multiplier, over_slope, g,
    );
    let unrest;
    if L == 1 {
        // Nothing waits for this lane: it looks at once whether Newton's step was enough.
        let newton = Newton { first: g[0], over_slope: over_slope[0], multiplier: multiplier[0] };
        let n = at(normal, 0);
        let point = add_scaled(&at(free, 0), newton.multiplier, &n);
        let ([residual], [gradient]) = laws.constraint(0).borrow().value_and_jacobian(&point);
        if residual.abs().le(rest[0]) {
            put(next, 0, gradient);
            (multiplier[0], g[0]) =
                last_correction(square[0], residual, newton.multiplier, newton.over_slope);
            unrest = !g[0].abs().le(rest[0]);
        } else {
            (multiplier[0], over_slope[0]) = newton.improved(residual, rest[0]);
            unrest = examine(laws, normal, free, square, rest, over_slope, multiplier, g, next);
        }
    } else {
        improve(laws, normal, free, rest, g, multiplier, over_slope);
        unrest = examine(laws, normal, free, square, rest, over_slope, multiplier, g, next);
    }
    if unrest {
        for lane in 0..L {
            if g[lane].abs().le(rest[lane]) {
                continue;
            }
            let n = at(normal, lane);
            let path = (&at(free, lane), &n, square[lane], rest[lane]);
            let astray = !is_finite(g[lane]);
            let landing =
                if astray { None } else { again(laws.constraint(lane).borrow(), path, multiplier[lane]) };
            let (found, gradient) = match landing {
                Some(landing) => landing,
                None => {
                    let back = kept_back::<S, L, D, SUMS, EQUAL>(share, q_low, way_low, lane);
                    let p = scaled(S::from_f64(1.0 / part.unit), &at(way, lane));
                    alone(laws, lane, part.h, (at(q, lane), p, back, n, square[lane]))
                        .map_err(|failure| Stuck { lane, failure })?
                }
            };
            multiplier[lane] = found;
            // For the next guess only, which a slope across the surface must not spoil.
            let (slope, least) = (dot(&gradient, &n), S::from_f64(0.25) * square[lane]);
            over_slope[lane] = S::from_f64(1.0) / S::select(least.lt(slope), slope, least);
            let turn = over_slope[lane] * square[lane];
            bias[lane] = square[lane] / (dot(&gradient, &gradient) * (turn * turn));
            put(next, lane, gradient);
        }
    }
    finish::<S, L, D, SUMS, EQUAL>(
        laws, part, normal, next, free, multiplier, over_slope, q, way, q_low, way_low, square, bias, rest,
        first, past,
    );
    Ok(())
}

/// Evaluates g at Λ₀ in all lanes and takes Newton's step from there.
#[allow(clippy::too_many_arguments, reason = "see `advance`")]
#[inline(always)]
fn guess<S, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool>(
    laws: &impl Laws<S, D>,
    share: S,
    q: &Vectors<S, L, D>,
    way: &Vectors<S, L, D>,
    q_low: &[Vectors<S, L, D>; SUMS],
    way_low: &[Vectors<S, L, D>; SUMS],
    normal: &Vectors<S, L, D>,
    guess: &[S; L],
    free: &mut Vectors<S, L, D>,
    multiplier: &mut [S; L],
    over_slope: &mut [S; L],
    g: &mut [S; L],
) where
    S: Lane,
{
    for i in 0..L {
        let mut start = at(q, i);
        if SUMS == 1 {
            start = sum(&start, &kept_back::<S, L, D, SUMS, EQUAL>(share, q_low, way_low, i));
        }
        let (start, n) = (plus::<S, D, EQUAL>(&start, share, &at(way, i)), at(normal, i));
        let ([residual], [gradient]) =
            laws.constraint(i).borrow().value_and_jacobian(&add_scaled(&start, guess[i], &n));
        let over = S::from_f64(1.0) / dot(&gradient, &n);
        put(free, i, start);
        multiplier[i] = (-residual).multiply_add(over, guess[i]);
        (over_slope[i], g[i]) = (over, residual);
    }
}

/// Evaluates g after Newton's step in all lanes, and finds Λ₂.
#[inline(always)]
fn improve<S, const L: usize, const D: usize>(
    laws: &impl Laws<S, D>,
    normal: &Vectors<S, L, D>,
    free: &Vectors<S, L, D>,
    rest: &[S; L],
    g: &[S; L],
    multiplier: &mut [S; L],
    over_slope: &mut [S; L],
) where
    S: Lane,
{
    for i in 0..L {
        let newton = Newton { first: g[i], over_slope: over_slope[i], multiplier: multiplier[i] };
        let point = add_scaled(&at(free, i), newton.multiplier, &at(normal, i));
        let [residual] = laws.constraint(i).borrow().value(&point);
        (multiplier[i], over_slope[i]) = newton.improved(residual, rest[i]);
    }
}

/// Newton's step from the guess.
struct Newton<S> {
    /// g at the guess, g₀.
    first: S,
    /// 1/s.
    over_slope: S,
    /// Λ₁.
    multiplier: S,
}

impl<S: Lane> Newton<S> {
    /// Λ₂ and 1/s there, from g₁; Λ₁ and 1/s where it is at rest.
    #[inline(always)]
    fn improved(&self, residual: S, rest: S) -> (S, S) {
        let [one, two, five, most] = [1.0, 2.0, 5.0, 0.0625].map(S::from_f64);
        let ratio = residual * (one / self.first);
        let ratio = S::select(ratio.lt(most), ratio, most);
        let ratio = S::select((-most).lt(ratio), ratio, -most); // also where g₀ is 0, and the ratio not a number
        let series = five.multiply_add(ratio, two).multiply_add(ratio, one);
        let over_slope = self.over_slope * series;
        let improved = (-residual).multiply_add(over_slope, self.multiplier);
        let rests = residual.abs().le(rest);
        (S::select(rests, self.multiplier, improved), S::select(rests, self.over_slope, over_slope))
    }
}

/// Evaluates g and ∇g at Λ₂ and makes the last correction. Returns whether a lane is not at rest.
#[allow(clippy::too_many_arguments, reason = "see `advance`")]
#[inline(always)]
fn examine<S, const L: usize, const D: usize>(
    laws: &impl Laws<S, D>,
    normal: &Vectors<S, L, D>,
    free: &Vectors<S, L, D>,
    square: &[S; L],
    rest: &[S; L],
    over_slope: &[S; L],
    multiplier: &mut [S; L],
    g: &mut [S; L],
    next: &mut Vectors<S, L, D>,
) -> bool
where
    S: Lane,
{
    let mut unrest = false;
    for i in 0..L {
        let n = at(normal, i);
        let point = add_scaled(&at(free, i), multiplier[i], &n);
        let ([residual], [gradient]) = laws.constraint(i).borrow().value_and_jacobian(&point);
        put(next, i, gradient);
        (multiplier[i], g[i]) = last_correction(square[i], residual, multiplier[i], over_slope[i]);
        unrest |= !g[i].abs().le(rest[i]); // also where it is not a number
    }
    unrest
}

/// Λ after the last correction, and g before it, or not a number where the surface may have been left.
#[inline(always)]
fn last_correction<S: Lane>(square: S, residual: S, multiplier: S, over_slope: S) -> (S, S) {
    let [middle, off, nan] = [4.0 / 3.0, 2.0 / 3.0, f64::NAN].map(S::from_f64);
    let near = over_slope.multiply_add(square, -middle).abs().le(off);
    ((-residual).multiply_add(over_slope, multiplier), S::select(near, residual, nan))
}

/// Λ and ∇g of a lane that is corrected again, unless it goes astray.
#[inline(always)]
fn again<S: Lane, K: ConstraintKernel<S, D, 1>, const D: usize>(
    constraint: &K,
    (free, n, square, rest): (&[S; D], &[S; D], S, S),
    mut multiplier: S,
) -> Option<(S, [S; D])> {
    for _ in 0..CORRECTIONS {
        let ([residual], [gradient]) = constraint.value_and_jacobian(&add_scaled(free, multiplier, n));
        let slope = dot(&gradient, n);
        let off = (slope - square).abs();
        if !(off + off).le(square) {
            return None;
        }
        multiplier = multiplier - residual / slope;
        if residual.abs().le(rest) {
            return Some((multiplier, gradient));
        }
    }
    None
}

/// Makes the new positions and ways, and the next guess.
#[allow(clippy::too_many_arguments, reason = "see `advance`")]
#[inline(always)]
fn finish<S, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool>(
    laws: &impl Laws<S, D>,
    part: &Part,
    normal: &Vectors<S, L, D>,
    next: &Vectors<S, L, D>,
    free: &Vectors<S, L, D>,
    multiplier: &[S; L],
    over_slope: &[S; L],
    q: &mut Vectors<S, L, D>,
    way: &mut Vectors<S, L, D>,
    q_low: &mut [Vectors<S, L, D>; SUMS],
    way_low: &mut [Vectors<S, L, D>; SUMS],
    square: &mut [S; L],
    bias: &mut [S; L],
    rest: &mut [S; L],
    guess: &mut [S; L],
    [last, earlier]: &mut [[S; L]; 2],
) where
    S: Lane,
{
    let [share, over_share, kick] =
        [part.h / part.unit, part.unit / part.h, part.unit * part.kick].map(S::from_f64);
    let [a, b, c] = part.weights.map(S::from_f64);
    for i in 0..L {
        let (n, m, old, found) = (at(normal, i), at(next, i), at(way, i), multiplier[i]);
        let place = if SUMS == 0 {
            add_scaled(&at(free, i), found, &n)
        } else {
            let back = kept_back::<S, L, D, SUMS, EQUAL>(share, q_low, way_low, i);
            let change = add_scaled(&plus::<S, D, EQUAL>(&back, share, &old), found, &n);
            let (place, low) = two_sum(&at(q, i), &change);
            put(&mut q_low[0], i, low);
            place
        };
        let push = if EQUAL { found } else { over_share * found };
        let length = dot(&m, &m);
        // Equal steps: Λ of the next one projects.
        let project = |change: [S; D], along: S| {
            if EQUAL { change } else { add_scaled(&change, -along / length, &m) }
        };
        let new = if SUMS == 0 {
            let pushed = laws.kick(i, &place, kick, add_scaled(&old, push, &n));
            project(pushed, dot(&m, &pushed))
        } else {
            let change = laws.kick(i, &place, kick, add_scaled(&at(&way_low[0], i), push, &n));
            let (new, low) = two_sum(&old, &project(change, dot(&m, &sum(&old, &change))));
            put(&mut way_low[0], i, low);
            new
        };
        put(q, i, place);
        put(way, i, new);
        rest[i] = at_rest(&m, &place);
        let extrapolated = if EQUAL {
            S::from_f64(3.0).multiply_add(found - last[i], earlier[i])
        } else {
            a.multiply_add(found, b.multiply_add(last[i], c * earlier[i]))
        };
        let turn = over_slope[i] * square[i];
        let turn = turn * turn;
        let ratio = turn * bias[i];
        bias[i] = square[i] / (length * turn);
        square[i] = length;
        guess[i] = ratio * extrapolated;
        earlier[i] = ratio * last[i];
        last[i] = ratio * found;
    }
}

/// Λ and ∇g(q′) of a lane by itself, as [`Simulation`](crate::run::simulation::Simulation) finds them: from a tangent momentum.
/// What p leads off the surface, and Λ puts back, is added in the end.
#[cold]
#[inline(never)]
fn alone<S: Lane, const D: usize>(
    laws: &impl Laws<S, D>,
    lane: usize,
    h: f64,
    (q, p, back, gradient, square): ([S; D], [S; D], [S; D], [S; D], S),
) -> Result<(S, [S; D]), Failure> {
    let step = S::from_f64(h);
    let normal = Normal { gradient, inverse_square: S::from_f64(1.0) / square };
    let (eta, back_on) = normal.projection(&p);
    let p = sum(&p, &back_on);
    let constraint = laws.constraint(lane);
    let constraint = constraint.borrow();
    let [bend] = constraint.jet(&q, &p).2;
    let guess = S::from_f64(-0.5) * step * step * bend * normal.inverse_square;
    let path = scaled(step, &p);
    let departure = Departure { q: &q, q_low: &back, normal: &normal, free: path, guess };
    let landing = land(
        constraint,
        h,
        0,
        &departure,
        &p,
        bend,
        &path,
        &crate::effect::force::Absent,
        S::from_f64(0.0),
        None,
    )?;
    Ok((landing.multiplier + step * eta, landing.gradient))
}
