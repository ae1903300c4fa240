//! A block of trajectories side by side, and the RATTLE step that moves all of them on.
//!
//! ```text
//! q′ = q + h p + Λ ∇g(q)                          Λ such that g(q′) = 0
//! p′ = p + Λ/h ∇g(q) − k ∇U(q′) + ∇g(q′) η        η such that ∇g(q′)·p′ = 0
//! ```
//!
//! Momenta are kept *ahead*: after the first kick of the step to come, and made tangent again. The second kick of a step
//! and the first of the next are then one, of length k. What the projection takes away Λ puts back, so positions are those
//! of RATTLE; [`Block::momentum`] takes the kick back.
//!
//! **The step in four loops**, each short enough that a processor overlaps the latencies of several of its iterations,
//! and plain enough that a compiler vectorises it: [`guess`] evaluates g and ∇g at Λ extrapolated from the last steps;
//! [`improve`] takes a Newton step Λ₁ = Λ₀ − g₀/s, s = ∇g(q′)·∇g(q), evaluates g₁ there, and goes on to the root of the
//! parabola through g₀, s and g₁,
//!
//! ```text
//! Λ₂ = Λ₁ − (g₁/s) (1 + 2t + 5t² + …),   t = g₁/g₀         (the coefficients: binomials of Catalan's numbers)
//! ```
//!
//! [`examine`] evaluates g and ∇g at Λ₂; and [`finish`] makes the last small correction −g₂/s and the new momentum.
//! Without the third term of the series three times as many steps need a further correction.
//!
//! **Stopping.** A displacement |g|/|∇g| of at most 256 ε|q|∞ is left to `finish`, which leaves what chord steps leave of
//! it, less than rounding does. Where it is larger, eight lanes together are corrected again. The normal is then that of a
//! point less than 256 ε|q|∞ away.
//!
//! **Which root.** The slope s at the guess must be within half of |∇g(q)|². Lanes where it is not, or that three corrections
//! do not bring to rest, are solved one by one, as a [`Simulation`](crate::simulation::Simulation) does. Sheets of a surface
//! that lie closer to each other than guesses are off, some part of κ(h|p|)², can still be taken for one another.
//!
//! Every lane is a function of its own past alone: lanes at rest are not moved when others are corrected.

use crate::effect::Field;
use crate::kernel::ConstraintKernel;
use crate::lanes::Lane;
use crate::solver::Departure;
use crate::stepper::Failure;
use crate::surface::{Normal, land};
use crate::vector::{add_scaled, dot, largest, scaled, sum, two_sum};
use std::array::from_fn;

/// Lanes that are examined, and corrected again, together: one register of the widest kind.
const EIGHT: usize = 8;

/// Left to the last correction: so many ε of the largest coordinate.
const AT_REST: f64 = 256.0;

/// Corrections of a lane before it is solved by itself.
const CORRECTIONS: usize = 3;

/// D coordinates of L trajectories.
type Vectors<S, const L: usize, const D: usize> = [[S; L]; D];

/// Trajectories side by side. `SUMS` is 1 if positions and momenta are compensated sums, else 0.
#[derive(Clone)]
#[repr(C, align(64))]
pub(crate) struct Block<S, const L: usize, const D: usize, const SUMS: usize> {
    q: Vectors<S, L, D>,
    /// Momenta, ahead by the first kick of the step to come.
    p: Vectors<S, L, D>,
    /// ∇g(q): the one of the two that `even` says.
    normal: [Vectors<S, L, D>; 2],
    /// |∇g(q)|².
    square: [S; L],
    /// What |g| may be at rest.
    rest: [S; L],
    /// Λ of the last two steps, the last one first if `even`.
    multiplier: [[S; L]; 2],
    /// How far the last step's Λ was from its linear extrapolation.
    bend: [S; L],
    q_low: [Vectors<S, L, D>; SUMS],
    p_low: [Vectors<S, L, D>; SUMS],
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
    /// Λ extrapolated linearly.
    linear: [S; L],
    multiplier: [S; L],
    /// s.
    slope: [S; L],
    /// 1/s.
    over_slope: [S; L],
    g: [S; L],
    rest: [S; L],
}

impl<S: Lane, const L: usize, const D: usize> Scratch<S, L, D> {
    pub(crate) fn new() -> Self {
        let zero = [S::default(); L];
        Self {
            free: [zero; D],
            linear: zero,
            multiplier: zero,
            slope: zero,
            over_slope: zero,
            g: zero,
            rest: zero,
        }
    }
}

/// One RATTLE step of a method: its length, the kick after it, and the weights that extrapolate Λ.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Part {
    pub(crate) h: f64,
    over_h: f64,
    pub(crate) kick: f64,
    pub(crate) weights: [f64; 3],
}

impl Part {
    /// The parts of a method that takes RATTLE steps of these lengths in turn, again and again.
    ///
    /// Λ/h² is a smooth function of time. In steps of one length it is extrapolated linearly from the last two, plus what the
    /// last extrapolation was off: quadratically. In steps of different lengths linearly, Λ taken to be that of a third of the
    /// step, unless that lies far away.
    pub(crate) fn of(lengths: &[f64]) -> Vec<Part> {
        let n = lengths.len();
        let at = |i: usize| lengths[i % n];
        let part = |i: usize| {
            let (h, before, first) = (at(i), at(i + n - 1), at(i + 2 * n - 2));
            let (last, earlier) = (before + h / 3.0 - before / 3.0, first + before / 3.0 - first / 3.0);
            let far = last / earlier;
            let far = if far.abs() <= 2.0 { far } else { 0.0 };
            let again = if n == 1 { 1.0 } else { 0.0 };
            let weights = [(1.0 + far) * (h / before).powi(2), -far * (h / first).powi(2), again];
            Part { h, over_h: 1.0 / h, kick: 0.5 * (h + at(i + 1)), weights }
        };
        (0..n).map(part).collect()
    }
}

/// A lane that cannot be moved, and why.
pub(crate) struct Stuck {
    pub(crate) lane: usize,
    pub(crate) failure: Failure,
}

/// What each lane obeys: one constraint and field for all, or one each.
pub(crate) trait Laws<K, F> {
    fn constraint(&self, lane: usize) -> &K;
    fn field(&self, lane: usize) -> &F;
}

/// The same for all lanes.
#[derive(Clone)]
pub(crate) struct Same<K, F>(pub(crate) K, pub(crate) F);

/// Each lane its own.
#[derive(Clone)]
pub(crate) struct Each<K, F, const L: usize>(pub(crate) [(K, F); L]);

impl<K, F> Laws<K, F> for Same<K, F> {
    #[inline(always)]
    fn constraint(&self, _: usize) -> &K {
        &self.0
    }
    #[inline(always)]
    fn field(&self, _: usize) -> &F {
        &self.1
    }
}

impl<K, F, const L: usize> Laws<K, F> for Each<K, F, L> {
    #[inline(always)]
    fn constraint(&self, lane: usize) -> &K {
        &self.0[lane].0
    }
    #[inline(always)]
    fn field(&self, lane: usize) -> &F {
        &self.0[lane].1
    }
}

/// Laws as a group keeps them. Loops read a copy of their own: what is elsewhere may be, for all that a compiler knows,
/// what the loop writes.
pub(crate) trait Kept<K, F>: Laws<K, F> + Clone {
    /// Has lane `to` obey what lane `from` does.
    fn copy(&mut self, from: usize, to: usize);
}

impl<K: Clone, F: Clone> Kept<K, F> for Same<K, F> {
    fn copy(&mut self, _: usize, _: usize) {}
}

impl<K: Clone, F: Clone, const L: usize> Kept<K, F> for Each<K, F, L> {
    fn copy(&mut self, from: usize, to: usize) {
        self.0[to] = self.0[from].clone();
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

/// q′ − q without the constraint, beyond h p: what sums have kept back.
#[inline(always)]
fn kept_back<S: Lane, const L: usize, const D: usize, const SUMS: usize>(
    h: S,
    q_low: &[Vectors<S, L, D>; SUMS],
    p_low: &[Vectors<S, L, D>; SUMS],
    lane: usize,
) -> [S; D] {
    from_fn(|d| h.multiply_add(p_low[0][d][lane], q_low[0][d][lane]))
}

impl<S: Lane, const L: usize, const D: usize, const SUMS: usize> Block<S, L, D, SUMS> {
    /// A block in which no lane is set.
    pub(crate) fn new() -> Self {
        let zero = [S::default(); L];
        let vectors = [zero; D];
        Self {
            q: vectors,
            p: vectors,
            normal: [vectors; 2],
            square: zero,
            rest: zero,
            multiplier: [zero; 2],
            bend: zero,
            q_low: [vectors; SUMS],
            p_low: [vectors; SUMS],
            even: true,
            part: 0,
        }
    }

    /// Puts a trajectory at q with momentum p, which are along the constraint, into a lane; `parts` are those of the
    /// method, of which the block's is to come.
    pub(crate) fn set<K: ConstraintKernel<S, D, 1>, F: Field<S, D>>(
        &mut self,
        lane: usize,
        (constraint, field): (&K, &F),
        parts: &[Part],
        q: [[S; D]; 2],
        p: [[S; D]; 2],
    ) {
        let h = S::from_f64(parts[self.part].h);
        let [gradient] = constraint.jacobian(&q[0]);
        let normal = Normal::new(gradient);
        let pushed = field.kick(&q[0], S::from_f64(0.5) * h, p[1]);
        let (_, back) = normal.projection(&sum(&p[0], &pushed));
        let (ahead, ahead_low) = two_sum(&p[0], &sum(&pushed, &back));
        put(&mut self.q, lane, q[0]);
        put(&mut self.p, lane, ahead);
        for (low, x) in self.q_low.iter_mut().zip([q[1]]).chain(self.p_low.iter_mut().zip([ahead_low])) {
            put(low, lane, x);
        }
        put(&mut self.normal[usize::from(!self.even)], lane, gradient);
        self.square[lane] = dot(&gradient, &gradient);
        self.rest[lane] = at_rest(&gradient, &q[0]);
        let [bend] = constraint.jet(&q[0], &ahead).2;
        let guess = S::from_f64(-0.5) * h * h * bend * normal.inverse_square;
        // Both such that the extrapolation gives this: its weights add up to the square of a ratio of steps.
        let [a, b, _] = parts[self.part].weights;
        let same = guess / S::from_f64(a + b);
        (self.multiplier[0][lane], self.multiplier[1][lane]) = (same, same);
        self.bend[lane] = S::default();
    }

    /// Copies a lane.
    pub(crate) fn copy(&mut self, from: usize, to: usize) {
        let vectors = [&mut self.q, &mut self.p].into_iter().chain(&mut self.normal);
        let vectors = vectors.chain(&mut self.q_low).chain(&mut self.p_low).flatten();
        for numbers in
            vectors.chain([&mut self.square, &mut self.rest, &mut self.bend]).chain(&mut self.multiplier)
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
    pub(crate) fn momentum<K: ConstraintKernel<S, D, 1>, F: Field<S, D>>(
        &self,
        lane: usize,
        (constraint, field): (&K, &F),
        parts: &[Part],
    ) -> [[S; D]; 2] {
        let ahead = at(&self.p, lane);
        let low = self.p_low.first().map_or([S::default(); D], |low| at(low, lane));
        let q = at(&self.q, lane);
        let [gradient] = constraint.jacobian(&q);
        let normal = Normal::new(gradient);
        let kick = S::from_f64(-0.5 * parts[self.part].h);
        let change = field.kick(&q, kick, low);
        let (_, back) = normal.projection(&sum(&ahead, &change));
        let (p, low) = two_sum(&ahead, &sum(&change, &back));
        [p, low.map(|x| if SUMS == 0 { S::default() } else { x })]
    }

    /// Whether all momenta are numbers.
    #[inline(always)]
    pub(crate) fn check<K: ConstraintKernel<S, D, 1>, F: Field<S, D>>(
        &self,
        laws: &impl Laws<K, F>,
    ) -> Result<(), Stuck> {
        for lane in 0..L {
            let (q, p) = (at(&self.q, lane), at(&self.p, lane));
            if !is_finite(total(&p)) {
                return Err(Stuck { lane, failure: not_finite(laws.constraint(lane), laws.field(lane), q) });
            }
        }
        Ok(())
    }

    /// Moves all lanes through the next part of a step. Where one cannot be moved the block is left half way.
    #[inline(always)]
    pub(crate) fn advance<K: ConstraintKernel<S, D, 1>, F: Field<S, D>>(
        &mut self,
        laws: &impl Laws<K, F>,
        parts: &[Part],
        scratch: &mut Scratch<S, L, D>,
    ) -> Result<(), Stuck> {
        let part = parts[self.part];
        let [even, odd] = &mut self.normal;
        let [even_multiplier, odd_multiplier] = &mut self.multiplier;
        let (q, p, low) = (&mut self.q, &mut self.p, (&mut self.q_low, &mut self.p_low));
        let (square, rest, bend) = (&mut self.square, &mut self.rest, &mut self.bend);
        // Written out twice, since compilers must see which of the two is read and which is written.
        if self.even {
            let multiplier = (&*even_multiplier, odd_multiplier);
            advance(laws, &part, q, p, low, (&*even, odd), square, rest, bend, multiplier, scratch)?;
        } else {
            let multiplier = (&*odd_multiplier, even_multiplier);
            advance(laws, &part, q, p, low, (&*odd, even), square, rest, bend, multiplier, scratch)?;
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
fn not_finite<S: Lane, K: ConstraintKernel<S, D, 1>, F: Field<S, D>, const D: usize>(
    constraint: &K,
    field: &F,
    q: [S; D],
) -> Failure {
    let [gradient] = constraint.jacobian(&q);
    Failure::at(0, false).not_finite(field, &[q], &[Normal::new(gradient)])
}

/// One part of a step. What it works on are arguments one by one, since compilers then know that no two overlap.
#[allow(clippy::too_many_arguments, clippy::type_complexity, reason = "see above")]
#[inline(always)]
fn advance<S, K, F, const L: usize, const D: usize, const SUMS: usize>(
    laws: &impl Laws<K, F>,
    part: &Part,
    q: &mut Vectors<S, L, D>,
    p: &mut Vectors<S, L, D>,
    (q_low, p_low): Of<'_, S, L, D, SUMS>,
    (normal, next): (&Vectors<S, L, D>, &mut Vectors<S, L, D>),
    square: &mut [S; L],
    rest: &mut [S; L],
    bend: &mut [S; L],
    (last, earlier): (&[S; L], &mut [S; L]),
    scratch: &mut Scratch<S, L, D>,
) -> Result<(), Stuck>
where
    S: Lane,
    K: ConstraintKernel<S, D, 1>,
    F: Field<S, D>,
{
    let Scratch { free, linear, multiplier, slope, over_slope, g, rest: allowed } = scratch;
    guess(
        laws, part, q, p, q_low, p_low, normal, last, earlier, bend, free, linear, multiplier, slope,
        over_slope, g,
    );
    let width = EIGHT.min(L);
    let mut astir = 0_u64;
    if L == 1 {
        // Nothing waits for this lane: it looks at once whether Newton's step was enough.
        let first = g[0];
        examine(laws, 0..1, normal, free, multiplier, rest, g, next);
        let newton = Newton { first, residual: g[0], slope: slope[0], over_slope: over_slope[0] };
        allowed[0] = newton.allows(square[0], rest[0]);
        (multiplier[0], over_slope[0]) = newton.improved(multiplier[0], allowed[0]);
        if !g[0].abs().le(allowed[0]) {
            astir = u64::from(examine(laws, 0..1, normal, free, multiplier, allowed, g, next));
        }
    } else {
        improve(laws, normal, free, square, rest, slope, g, over_slope, multiplier, allowed);
        // All lanes in one loop: a loop over groups of eight would be vectorised across the groups.
        if examine(laws, 0..L, normal, free, multiplier, allowed, g, next) {
            for group in 0..L / width {
                let mut lanes = group * width..(group + 1) * width;
                astir |= u64::from(lanes.any(|lane| !g[lane].abs().le(allowed[lane]))) << group;
            }
        }
    }
    while astir != 0 {
        let group = astir.trailing_zeros() as usize % (L / width); // the remainder: what a bounds check costs is vectors
        astir &= astir - 1;
        let lanes = group * width..(group + 1) * width;
        let mut unrest = true;
        let corrections =
            if lanes.clone().all(|lane| g[lane].abs().le(rest[lane])) { 0 } else { CORRECTIONS };
        for _ in 0..corrections {
            correct(lanes.clone(), g, over_slope, allowed, multiplier);
            unrest = examine(laws, lanes.clone(), normal, free, multiplier, allowed, g, next);
            if !unrest {
                break;
            }
        }
        if unrest {
            for lane in lanes {
                if g[lane].abs().le(allowed[lane]) {
                    continue;
                }
                let back = if SUMS == 1 {
                    kept_back(S::from_f64(part.h), q_low, p_low, lane)
                } else {
                    [S::default(); D]
                };
                let departure = (at(q, lane), at(p, lane), back, at(normal, lane), square[lane]);
                let (found, gradient) = alone(laws.constraint(lane), part.h, departure)
                    .map_err(|failure| Stuck { lane, failure })?;
                (multiplier[lane], g[lane], over_slope[lane]) = (found, S::default(), S::default());
                put(next, lane, gradient);
            }
        }
    }
    finish(
        laws, part, normal, next, free, multiplier, g, over_slope, q, p, q_low, p_low, square, rest, linear,
        bend, earlier,
    );
    Ok(())
}

#[allow(clippy::too_many_arguments, reason = "see `advance`")]
#[inline(always)]
fn guess<S, K, F, const L: usize, const D: usize, const SUMS: usize>(
    laws: &impl Laws<K, F>,
    part: &Part,
    q: &Vectors<S, L, D>,
    p: &Vectors<S, L, D>,
    q_low: &[Vectors<S, L, D>; SUMS],
    p_low: &[Vectors<S, L, D>; SUMS],
    normal: &Vectors<S, L, D>,
    last: &[S; L],
    earlier: &[S; L],
    bend: &[S; L],
    free: &mut Vectors<S, L, D>,
    linear: &mut [S; L],
    multiplier: &mut [S; L],
    slope: &mut [S; L],
    over_slope: &mut [S; L],
    g: &mut [S; L],
) where
    S: Lane,
    K: ConstraintKernel<S, D, 1>,
{
    let (h, one) = (S::from_f64(part.h), S::from_f64(1.0));
    let [a, b, c] = part.weights.map(S::from_f64);
    for i in 0..L {
        let mut start = at(q, i);
        if SUMS == 1 {
            start = sum(&start, &kept_back(h, q_low, p_low, i));
        }
        let (start, n) = (add_scaled(&start, h, &at(p, i)), at(normal, i));
        linear[i] = a.multiply_add(last[i], b * earlier[i]);
        let extrapolated = c.multiply_add(bend[i], linear[i]);
        let point = add_scaled(&start, extrapolated, &n);
        let ([residual], [gradient]) = laws.constraint(i).value_and_jacobian(&point);
        let along = dot(&gradient, &n);
        let over = one / along;
        put(free, i, start);
        (g[i], slope[i], over_slope[i]) = (residual, along, over);
        multiplier[i] = (-residual).multiply_add(over, extrapolated);
    }
}

#[allow(clippy::too_many_arguments, reason = "see `advance`")]
#[inline(always)]
fn improve<S, K, F, const L: usize, const D: usize>(
    laws: &impl Laws<K, F>,
    normal: &Vectors<S, L, D>,
    free: &Vectors<S, L, D>,
    square: &[S; L],
    rest: &[S; L],
    slope: &[S; L],
    g: &[S; L],
    over_slope: &mut [S; L],
    multiplier: &mut [S; L],
    allowed: &mut [S; L],
) where
    S: Lane,
    K: ConstraintKernel<S, D, 1>,
{
    for i in 0..L {
        let point = add_scaled(&at(free, i), multiplier[i], &at(normal, i));
        let [residual] = laws.constraint(i).value(&point);
        let newton = Newton { first: g[i], residual, slope: slope[i], over_slope: over_slope[i] };
        allowed[i] = newton.allows(square[i], rest[i]);
        (multiplier[i], over_slope[i]) = newton.improved(multiplier[i], allowed[i]);
    }
}

/// Newton's step from the guess.
struct Newton<S> {
    /// g at the guess, g₀.
    first: S,
    /// g after it, g₁.
    residual: S,
    slope: S,
    over_slope: S,
}

impl<S: Lane> Newton<S> {
    /// What |g| may be at rest; nothing where the slope says that the surface may have been left.
    #[inline(always)]
    fn allows(&self, square: S, rest: S) -> S {
        let off = (self.slope - square).abs();
        S::select((off + off).le(square), rest, S::from_f64(-1.0))
    }

    /// Λ₂ from Λ₁, and 1/s there; Λ₁ itself where it is at rest.
    #[inline(always)]
    fn improved(&self, newton: S, allowed: S) -> (S, S) {
        let [zero, one, two, five, sixteenth] = [0.0, 1.0, 2.0, 5.0, 0.0625].map(S::from_f64);
        let ratio = self.residual * (one / self.first);
        let ratio = S::select(ratio.abs().le(sixteenth), ratio, zero); // also where g₀ is 0: there is nothing to learn
        let bent = two.multiply_add(ratio, one);
        let series = (five * ratio).multiply_add(ratio, bent);
        let improved = (-(self.residual * self.over_slope)).multiply_add(series, newton);
        let rests = self.residual.abs().le(allowed);
        (S::select(rests, newton, improved), self.over_slope * bent)
    }
}

/// Whether a lane is not at rest.
#[allow(clippy::too_many_arguments, reason = "see `advance`")]
#[inline(always)]
fn examine<S, K, F, const L: usize, const D: usize>(
    laws: &impl Laws<K, F>,
    lanes: std::ops::Range<usize>,
    normal: &Vectors<S, L, D>,
    free: &Vectors<S, L, D>,
    multiplier: &[S; L],
    allowed: &[S; L],
    g: &mut [S; L],
    next: &mut Vectors<S, L, D>,
) -> bool
where
    S: Lane,
    K: ConstraintKernel<S, D, 1>,
{
    let mut unrest = 0_u64;
    for i in lanes {
        let point = add_scaled(&at(free, i), multiplier[i], &at(normal, i));
        let ([residual], [gradient]) = laws.constraint(i).value_and_jacobian(&point);
        g[i] = residual;
        put(next, i, gradient);
        unrest |= u64::from(!residual.abs().le(allowed[i])); // also where it is not a number
    }
    unrest != 0
}

#[inline(always)]
fn correct<S: Lane, const L: usize>(
    lanes: std::ops::Range<usize>,
    g: &[S; L],
    over_slope: &[S; L],
    allowed: &[S; L],
    multiplier: &mut [S; L],
) {
    for i in lanes {
        let rests = g[i].abs().le(allowed[i]);
        multiplier[i] = S::select(rests, multiplier[i], (-g[i]).multiply_add(over_slope[i], multiplier[i]));
    }
}

#[allow(clippy::too_many_arguments, reason = "see `advance`")]
#[inline(always)]
fn finish<S, K, F, const L: usize, const D: usize, const SUMS: usize>(
    laws: &impl Laws<K, F>,
    part: &Part,
    normal: &Vectors<S, L, D>,
    next: &Vectors<S, L, D>,
    free: &Vectors<S, L, D>,
    multiplier: &[S; L],
    g: &[S; L],
    over_slope: &[S; L],
    q: &mut Vectors<S, L, D>,
    p: &mut Vectors<S, L, D>,
    q_low: &mut [Vectors<S, L, D>; SUMS],
    p_low: &mut [Vectors<S, L, D>; SUMS],
    square: &mut [S; L],
    rest: &mut [S; L],
    linear: &[S; L],
    bend: &mut [S; L],
    earlier: &mut [S; L],
) where
    S: Lane,
    F: Field<S, D>,
{
    let (h, over_h, kick) = (S::from_f64(part.h), S::from_f64(part.over_h), S::from_f64(part.kick));
    let one = S::from_f64(1.0);
    for i in 0..L {
        let (n, m, old) = (at(normal, i), at(next, i), at(p, i));
        let found = (-g[i]).multiply_add(over_slope[i], multiplier[i]);
        let place = if SUMS == 0 {
            add_scaled(&at(free, i), found, &n)
        } else {
            let way = add_scaled(&add_scaled(&kept_back(h, q_low, p_low, i), h, &old), found, &n);
            let (place, low) = two_sum(&at(q, i), &way);
            put(&mut q_low[0], i, low);
            place
        };
        let length = dot(&m, &m);
        let over_length = one / length; // while other sums are on their way
        let new = if SUMS == 0 {
            let pushed = laws.field(i).kick(&place, kick, add_scaled(&old, found * over_h, &n));
            add_scaled(&pushed, -(dot(&m, &pushed) * over_length), &m)
        } else {
            let change = laws.field(i).kick(&place, kick, add_scaled(&at(&p_low[0], i), found * over_h, &n));
            let back = dot(&m, &sum(&old, &change)) * over_length;
            let (new, low) = two_sum(&old, &add_scaled(&change, -back, &m));
            put(&mut p_low[0], i, low);
            new
        };
        put(q, i, place);
        put(p, i, new);
        square[i] = length;
        rest[i] = at_rest(&m, &place);
        earlier[i] = found;
        bend[i] = found - linear[i];
    }
}

/// Λ and ∇g(q′) of a lane by itself, as [`Simulation`](crate::simulation::Simulation) finds them.
#[cold]
#[inline(never)]
fn alone<S: Lane, K: ConstraintKernel<S, D, 1>, const D: usize>(
    constraint: &K,
    h: f64,
    (q, p, back, gradient, square): ([S; D], [S; D], [S; D], [S; D], S),
) -> Result<(S, [S; D]), Failure> {
    let step = S::from_f64(h);
    let normal = Normal { gradient, inverse_square: S::from_f64(1.0) / square };
    let [bend] = constraint.jet(&q, &p).2;
    let guess = S::from_f64(-0.5) * step * step * bend * normal.inverse_square;
    let path = scaled(step, &p);
    let departure = Departure { q: &q, q_low: &back, normal: &normal, free: path, guess };
    let landing =
        land(constraint, h, 0, &departure, &p, bend, &path, &crate::effect::Absent, S::from_f64(0.0), None)?;
    Ok((landing.multiplier, landing.gradient))
}
