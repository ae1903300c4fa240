//! Collocation on surfaces: the stages of [`lobatto`](crate::methods::lobatto) solved together, body by body.
//!
//! An iteration evaluates g, ∇g and the force once at every stage, forms the new sums, and solves the linearised
//! constraints for the changes of λ:
//!
//! ```text
//! Σⱼ h² aᵢⱼ (∇g(Qᵢ)·∇g(Qⱼ)) δλⱼ = −rᵢ,     rᵢ = g(Qᵢ) + ∇g(Qᵢ)·h² Σⱼ aᵢⱼ (Fⱼ − Fⱼ before),   F = f + ∇g λ
//! ```
//!
//! **First guess.** If wanted, the polynomial through the stages of the step before and the exact start of this one.
//! Else constant acceleration, from g̈ = 0 at the start. Where that does not converge, steps of RATTLE from node to
//! node. **Matrix.** Inverted where normals are first evaluated, and again while they move by more than 1e-7 of the
//! positions. **Stopping.** The solve ends after a displacement below half a rounding, or where these no longer shrink
//! ([`crate::solve::stop`]). **Sums.** What rounding takes from coefficients is smaller than half a digit of the sums
//! that it belongs to, and would be lost there each time. So it is added up by itself, with what rounding takes from
//! the sums. **Which root.** Normals of successive stages must not be turned over.

use crate::effect::force::Force;
use crate::effect::list::Forces;
use crate::effect::moment::Moment;
use crate::kernel::functions::ConstraintKernel;
use crate::kernel::rounding::size_along;
use crate::motion::bodies::Count;
use crate::motion::capability::Collocation;
use crate::motion::failure::Failure;
use crate::motion::system::System;
use crate::motion::table::Table;
use crate::motion::witness::Witness;
use crate::number::lanes::Fused;
use crate::number::real::Scalar;
use crate::number::vector::{add_scaled, dot, largest, scaled, sum, two_sum};
use crate::solve::root::{STAGES_ALIKE, alike};
use crate::solve::stop::{LAST_OF_STAGES, NOISE, Stalling};
use crate::systems::surface::diagnosis::FailureAt;
use crate::systems::surface::equation::{Equation, is_rounding};
use crate::systems::surface::kept::{BodiesOf, Kept, OnSurface};
use crate::systems::surface::normal::Normal;
use crate::systems::surface::room::Stages;
use std::array::from_fn;

/// Iterations after which a step is given up; six to ten suffice where there is a solution.
const MAX_ITERATIONS: usize = 60;

/// A guess from the step before is given up if it is off by more than this part of the path: it may lead to another
/// root.
const FAR_GUESS: f64 = 1e-2;

/// Displacements of this many roundings move normals enough for another matrix.
const NORMALS_MOVE: f64 = 1e9;

/// After a displacement by more than this part of the way, or of the place, stages are led to by their sums again. What
/// they are moved by is added up, iteration after iteration, and is rounded by as much as is added: after stages that
/// ran off by 10⁵ and came back the places held g = 0, and the sums, by which the step ends, were 6e-12 beside them. Of
/// smaller displacements, 60 of them, less than a tenth of a rounding is lost. Steps that are not long never have one.
const FAR_OFF: f64 = 1e-3;

impl<T, K, F, N, L, const D: usize> Collocation<N, Kept<N, T, F, D>, T, D> for OnSurface<K, F, N, L>
where
    T: Scalar,
    K: ConstraintKernel<T, D, 1>,
    F: Forces<T, D>,
    N: Count,
    L: ConstraintKernel<Fused<f64>, D, 1>,
{
    fn reserve(&self, bodies: &mut BodiesOf<N, T, F, D>, stages: usize) {
        bodies.kept.stages =
            (stages > 0).then(|| Box::new(Stages::new(stages, self.count.number(), &self.effects)));
    }

    fn collocate<W: Witness<T>, const S: usize>(
        &self,
        table: &Table<S>,
        h: f64,
        bodies: &mut BodiesOf<N, T, F, D>,
        memory: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        let n = self.count.number();
        let mut stages = match bodies.kept.stages.take() {
            Some(stages) if stages.q.len() == S * n => stages,
            _ => Box::new(Stages::new(S, n, &self.effects)),
        };
        let solved = self.solve_from_guesses(table, h, bodies, memory, &mut stages);
        if let (true, Some((filled, past))) = (solved.is_ok(), memory.split_first_mut()) {
            *filled = T::from_f64(1.0);
            let (total, lambda) = past.split_at_mut(S * n * D);
            total.copy_from_slice(stages.total.as_flattened());
            lambda.copy_from_slice(&stages.lambda);
        }
        let solved = solved.and_then(|()| self.arrive(table, h, bodies, &stages, witness));
        bodies.kept.stages = Some(stages);
        solved?;
        self.pass(h, bodies);
        self.evaluate_forces(bodies);
        let last = h * table.weights[S - 1];
        self.settle(last, 2.0 * last, bodies, witness)
    }
}

impl<K, F, N: Count, L> OnSurface<K, F, N, L> {
    /// Steps of RATTLE from node to node.
    #[cold]
    #[inline(never)]
    fn guess_by_steps<T, const D: usize, const S: usize>(
        &self,
        table: &Table<S>,
        h: f64,
        bodies: &BodiesOf<N, T, F, D>,
        stages: &mut Stages<T, F, D>,
    ) -> Result<(), Failure>
    where
        T: Scalar,
        K: ConstraintKernel<T, D, 1>,
        L: ConstraintKernel<Fused<f64>, D, 1>,
        F: Forces<T, D>,
    {
        let mut ahead = bodies.clone();
        for stage in 0..S {
            if stage > 0 {
                let part = h * (table.nodes[stage] - table.nodes[stage - 1]);
                self.drift(0.5 * part, part, &mut ahead, &mut ())?;
                self.evaluate_forces(&mut ahead);
                self.settle(0.5 * part, part, &mut ahead, &mut ())?;
            }
            for body in 0..self.count.number() {
                let at = body * S + stage;
                (stages.lambda[at], stages.total[at]) = ahead.pull(&self.constraint, body);
            }
        }
        Ok(())
    }

    /// The first stage, at the start.
    #[inline(always)]
    fn begin<T, const D: usize, const S: usize>(
        &self,
        bodies: &BodiesOf<N, T, F, D>,
        stages: &mut Stages<T, F, D>,
    ) where
        T: Scalar,
        K: ConstraintKernel<T, D, 1>,
        F: Forces<T, D>,
    {
        for body in 0..self.count.number() {
            (stages.lambda[body * S], stages.total[body * S]) = bodies.pull(&self.constraint, body);
            stages.normal[body * S] = bodies.kept.normal.as_ref()[body].gradient;
        }
    }

    /// Solves with one guess after the other.
    fn solve_from_guesses<T, const D: usize, const S: usize>(
        &self,
        table: &Table<S>,
        h: f64,
        bodies: &BodiesOf<N, T, F, D>,
        memory: &[T],
        stages: &mut Stages<T, F, D>,
    ) -> Result<(), Failure>
    where
        T: Scalar,
        K: ConstraintKernel<T, D, 1>,
        L: ConstraintKernel<Fused<f64>, D, 1>,
        F: Forces<T, D>,
    {
        self.begin::<T, D, S>(bodies, stages);
        if let Some((filled, past)) = memory.split_first()
            && filled.to_f64() == 1.0
        {
            stages.extrapolate(table, past);
            if self.solve(table, h, bodies, stages, FAR_GUESS).is_ok() {
                return Ok(());
            }
            self.begin::<T, D, S>(bodies, stages);
        }
        stages.fill::<S>();
        let solved = self.solve(table, h, bodies, stages, f64::INFINITY);
        if solved.is_ok() || self.guess_by_steps(table, h, bodies, stages).is_err() {
            return solved;
        }
        self.solve(table, h, bodies, stages, f64::INFINITY)
    }

    /// Iterates until the stages hold to rounding, unless the first guess is off by more than this part of the path.
    fn solve<T, const D: usize, const S: usize>(
        &self,
        table: &Table<S>,
        h: f64,
        bodies: &BodiesOf<N, T, F, D>,
        stages: &mut Stages<T, F, D>,
        far_guess: f64,
    ) -> Result<(), Failure>
    where
        T: Scalar,
        K: ConstraintKernel<T, D, 1>,
        F: Forces<T, D>,
    {
        let n = self.count.number();
        let zero = T::from_f64(0.0);
        let positions: [[T; S]; S] = from_fn(|i| from_fn(|j| T::from_f64(table.push(h, i, j).0)));
        let pushes: [[_; S]; S] = from_fn(|i| from_fn(|j| pair(table.push(h, i, j))));
        let drift: [_; S] = from_fn(|stage| pair(table.drift(h, stage)));
        lead(bodies.p.as_ref(), &pushes, &drift, stages);
        let times = |stage: usize| bodies.time + h * table.nodes[stage];
        let (mut last, mut last_contraction, mut stalling) = (f64::INFINITY, 0.0, Stalling::START);
        for iteration in 0..MAX_ITERATIONS {
            for body in 0..n {
                let (q, q_low) = (&bodies.q.as_ref()[body], &bodies.q_low.as_ref()[body]);
                for stage in 1..S {
                    let at = body * S + stage;
                    let increment = sum(&stages.increment[at], &sum(q_low, &stages.rest[at]));
                    stages.q[stage * n + body] = sum(q, &increment);
                }
            }
            let renew = iteration == 0 || last > NORMALS_MOVE || last_contraction > 0.1;
            for stage in 1..S {
                let at = Moment { time: times(stage), positions: &stages.q[stage * n..][..n] };
                self.effects.evaluate(at, &mut stages.of_effects, &mut stages.force[stage * n..][..n]);
            }
            let (mut worst, mut slowest, mut slowest_size) = (0.0_f64, 0, zero);
            for body in 0..n {
                let (moved, far) = improve(
                    &self.constraint,
                    (&bodies.q.as_ref()[body], &bodies.q_low.as_ref()[body]),
                    &positions,
                    (&stages.q[body..], &stages.force[body..], n),
                    part_mut(&mut stages.normal, body),
                    part_mut(&mut stages.total, body),
                    part_mut(&mut stages.lambda, body),
                    (part(&stages.increment, body), part_mut(&mut stages.rest, body)),
                    &mut stages.inverse[body * S * S..][..S * S],
                    renew,
                );
                if iteration == 0 && far_guess < 1.0 && !largest(&moved).le(T::from_f64(far_guess) * far) {
                    return Err(FailureAt::of(body).unsolved(h, S, 1, f64::NAN));
                }
                let n = &bodies.kept.normal.as_ref()[body].gradient;
                let q = &bodies.q.as_ref()[body];
                let size = size_along(n, dot(n, n).sqrt(), q).max(far);
                // Coordinates that are larger than what matters are rounded to more.
                let (moved, size) =
                    if largest(q).le(size) { (largest(&moved), size) } else { rounded(&moved, q, size) };
                let ratio = moved / (size * T::from_f64(T::EPSILON));
                let ratio = if moved.le(zero) { 0.0 } else { ratio.to_f64() };
                if ratio > worst || ratio.is_nan() {
                    (worst, slowest, slowest_size) = (ratio, body, size);
                }
            }
            if !worst.is_finite() {
                return Err(self.not_finite(h, times, stages, slowest, S, iteration));
            }
            let contraction = worst / last;
            let rounded = || {
                let (q, n) = (&bodies.q.as_ref()[slowest], &bodies.kept.normal.as_ref()[slowest].gradient);
                let normals = T::from_f64(worst * T::EPSILON) * slowest_size / dot(n, n).sqrt();
                is_rounding(&self.constraint, q, n, slowest_size, normals)
            };
            let stalled = (iteration > 3 && contraction >= 0.5 && worst < NOISE)
                || (stalling.note(worst, iteration) && rounded());
            if worst <= LAST_OF_STAGES || stalled {
                return self.upright::<T, D, S>(h, stages);
            }
            if iteration + 1 == MAX_ITERATIONS {
                return Err(FailureAt::of(slowest).unsolved(h, S, MAX_ITERATIONS, worst));
            }
            if worst > FAR_OFF / T::EPSILON {
                lead(bodies.p.as_ref(), &pushes, &drift, stages);
            }
            (last, last_contraction) = (worst, contraction);
        }
        Ok(()) // not reached: the last iteration returns
    }

    /// Refuses stages whose normals are turned far against those before.
    #[inline(always)]
    fn upright<T, const D: usize, const S: usize>(
        &self,
        h: f64,
        stages: &Stages<T, F, D>,
    ) -> Result<(), Failure>
    where
        T: Scalar,
        F: Forces<T, D>,
    {
        for body in 0..self.count.number() {
            let normal: &[[T; D]; S] = part(&stages.normal, body);
            if !(1..S).all(|i| T::from_f64(STAGES_ALIKE).lt(alike(&normal[i - 1], &normal[i]))) {
                return Err(FailureAt::of(body).turned_over(h, S));
            }
        }
        Ok(())
    }

    /// A force or the constraint is not a number at a stage, or the stages ran away.
    #[cold]
    #[inline(never)]
    fn not_finite<T, const D: usize>(
        &self,
        h: f64,
        times: impl Fn(usize) -> f64,
        stages: &Stages<T, F, D>,
        body: usize,
        count: usize,
        iterations: usize,
    ) -> Failure
    where
        T: Scalar,
        K: ConstraintKernel<T, D, 1>,
        F: Forces<T, D>,
    {
        let n = self.count.number();
        for stage in 1..count {
            let at = Moment { time: times(stage), positions: &stages.q[stage * n..][..n] };
            let reached = at.positions[body].iter().all(|q| q.to_f64().is_finite());
            if let (true, Some(failure)) = (reached, Failure::of_force(&self.effects, at, [body])) {
                return failure;
            }
        }
        FailureAt::of(body).unsolved(h, count, iterations, f64::NAN)
    }

    /// Takes the bodies to the end of the step, their momenta without the last kick. An error where g = 0, the last of
    /// the equations, does not hold there.
    #[inline(always)]
    fn arrive<T, W, const D: usize, const S: usize>(
        &self,
        table: &Table<S>,
        h: f64,
        bodies: &mut BodiesOf<N, T, F, D>,
        stages: &Stages<T, F, D>,
        witness: &mut W,
    ) -> Result<(), Failure>
    where
        T: Scalar,
        K: ConstraintKernel<T, D, 1>,
        L: ConstraintKernel<Fused<f64>, D, 1>,
        F: Forces<T, D>,
        W: Witness<T>,
    {
        let n = self.count.number();
        if self.effects.changes_with_time() {
            let mut power = T::from_f64(table.weights[0]) * bodies.power;
            for j in 1..S - 1 {
                let time = bodies.time + h * table.nodes[j];
                let at = Moment { time, positions: &stages.q[j * n..][..n] };
                power = power + T::from_f64(table.weights[j]) * self.effects.power(at);
            }
            bodies.work = bodies.work + T::from_f64(h) * power; // the last kick books its own
        }
        let row: [_; S] = from_fn(|j| pair(table.push(h, S - 1, j)));
        let kicks: [_; S] = from_fn(|j| pair(table.kick(h, j)));
        for body in 0..n {
            let (q, q_low) = (&mut bodies.q.as_mut()[body], &mut bodies.q_low.as_mut()[body]);
            let (p, p_low) = (&bodies.p.as_ref()[body], &bodies.p_low.as_ref()[body]);
            let (bend, low) = weighted(&row, part(&stages.total, body));
            let path = scaled(T::from_f64(h), p);
            let far = largest(&path).max(largest(&bend));
            let (high, lost) = two_sum(&path, &bend);
            let low = add_scaled(&sum(&low, &lost), T::from_f64(h), p_low);
            let (high, lost) = two_sum(q, &high);
            (*q, *q_low) = two_sum(&high, &sum(&lost, &sum(q_low, &low)));
            let ([g], [gradient]) = self.constraint.value_and_jacobian(q);
            let length = dot(&gradient, &gradient).sqrt();
            let before = &bodies.kept.normal.as_ref()[body].gradient;
            let size =
                size_along(&gradient, length, q).max(size_along(before, dot(before, before).sqrt(), q));
            let size = size.max(far);
            if !g.abs().le(T::from_f64(NOISE * T::EPSILON) * size * length) {
                let kernel = &self.constraint;
                holds(kernel, q, (g, &gradient), size)
                    .map_err(|left| FailureAt::of(body).unsolved(h, S, MAX_ITERATIONS, left))?;
            }
            bodies.kept.normal.as_mut()[body] = Normal::new(gradient);
            witness.position_multiplier(body, stages.lambda[body * S]);
        }
        self.fuse_normals(bodies);
        for body in 0..n {
            let (p, p_low) = (&mut bodies.p.as_mut()[body], &mut bodies.p_low.as_mut()[body]);
            let (high, low) = weighted(&kicks, part(&stages.total, body));
            let (change, lost) = two_sum(&high, &sum(p_low, &low));
            let (moved, rest) = two_sum(p, &change);
            (*p, *p_low) = (moved, sum(&rest, &lost));
        }
        Ok(())
    }
}

/// Whether g at the end of a step, where it is more than some roundings of places of this size, is its own rounding: on
/// a sphere around a far centre its terms are larger than the coordinates. If not, by how many roundings it is off.
#[cold]
#[inline(never)]
fn holds<T: Scalar, const D: usize>(
    equation: &dyn Equation<T, D>,
    q: &[T; D],
    (g, gradient): (T, &[T; D]),
    size: T,
) -> Result<(), f64> {
    let (square, rounding) = (dot(gradient, gradient), T::from_f64(T::EPSILON) * size);
    if is_rounding(equation, q, gradient, size, g / square) {
        return Ok(());
    }
    Err((g.abs() / (square.sqrt() * rounding)).to_f64())
}

/// One iteration for one body: the largest change of each coordinate, and the largest distance from the start.
///
/// `positions` are h² aᵢⱼ; of places and forces the body's own and every `stride`-th after it, stage by stage.
#[allow(
    clippy::too_many_arguments,
    reason = "slices that are arguments do not overlap, which is a fifth of the time"
)]
#[inline(always)]
fn improve<T, K, F, const D: usize, const S: usize>(
    constraint: &K,
    start: (&[T; D], &[T; D]),
    positions: &[[T; S]; S],
    (q, force, stride): (&[[T; D]], &[F], usize),
    normal: &mut [[T; D]; S],
    total: &mut [[T; D]; S],
    lambda: &mut [T; S],
    (increment, rest): (&[[T; D]; S], &mut [[T; D]; S]),
    inverse: &mut [T],
    renew: bool,
) -> ([T; D], T)
where
    T: Scalar,
    K: ConstraintKernel<T, D, 1>,
    F: Force<T, D>,
{
    let zero = T::from_f64(0.0);
    let mut change = [[zero; D]; S];
    let mut right = [zero; S];
    for stage in 1..S {
        let at = &q[stage * stride];
        let ([g], [gradient]) = constraint.value_and_jacobian(at);
        normal[stage] = gradient;
        // What rounding took from the place.
        let way = sum(&increment[stage], &sum(start.1, &rest[stage]));
        let off: [T; D] = from_fn(|d| (start.0[d] - at[d]) + way[d]);
        right[stage] = -g - dot(&gradient, &off);
        let sum = force[stage * stride].add_to(gradient.map(|n| lambda[stage] * n), T::from_f64(1.0));
        change[stage] = add_scaled(&sum, T::from_f64(-1.0), &total[stage]);
        total[stage] = sum;
    }
    let mut shift = [[zero; D]; S];
    for i in 1..S {
        for j in 1..S - 1 {
            shift[i] = add_scaled(&shift[i], positions[i][j], &change[j]);
        }
        right[i] = right[i] - dot(&normal[i], &shift[i]);
    }
    if renew {
        for i in 1..S {
            for j in 0..S - 1 {
                inverse[i * S + j] = positions[i][j] * dot(&normal[i], &normal[j]);
            }
        }
        invert::<T, S>(inverse);
    }
    let mut correction = [zero; S];
    for j in 0..S - 1 {
        for i in 0..S - 1 {
            correction[j] = correction[j] + inverse[(j + 1) * S + i] * right[i + 1];
        }
    }
    for j in 0..S - 1 {
        lambda[j] = lambda[j] + correction[j];
        let push = normal[j].map(|n| correction[j] * n);
        total[j] = sum(&total[j], &push);
        for i in 1..S {
            shift[i] = add_scaled(&shift[i], positions[i][j], &push);
        }
    }
    for i in 1..S {
        rest[i] = sum(&rest[i], &shift[i]);
    }
    let moved = from_fn(|d| shift[1..].iter().map(|shift| shift[d].abs()).fold(zero, select_larger));
    let far = (1..S).map(|i| largest(&sum(&increment[i], &rest[i]))).fold(zero, select_larger);
    (moved, far)
}

/// The change of the coordinate that moves by most of its roundings, and the size of that coordinate, or this one if it
/// is larger.
#[cold]
fn rounded<T: Scalar, const D: usize>(moved: &[T; D], q: &[T; D], size: T) -> (T, T) {
    let each = moved.iter().zip(q).map(|(&moved, q)| (moved, size.max(q.abs())));
    each.reduce(|most, next| if (next.0 * most.1).le(most.0 * next.1) { most } else { next })
        .unwrap_or((size, size))
}

/// The larger one, NaN if one is.
#[inline(always)]
fn select_larger<T: Scalar>(a: T, b: T) -> T {
    T::select(b.le(a), a, b)
}

/// Where the sums over stages lead all bodies, and what rounding took from it.
fn lead<T: Scalar, F: Forces<T, D>, const D: usize, const S: usize>(
    p: &[[T; D]],
    pushes: &[[(T, T); S]; S],
    drift: &[(T, T); S],
    stages: &mut Stages<T, F, D>,
) {
    for (body, v) in p.iter().enumerate() {
        let total: &[[T; D]; S] = part(&stages.total, body);
        for stage in 1..S {
            let at = body * S + stage;
            (stages.increment[at], stages.rest[at]) = increment(&pushes[stage], drift[stage], v, total);
        }
    }
}

/// The stages of one body.
#[inline(always)]
fn part<X, const S: usize>(all: &[X], body: usize) -> &[X; S] {
    let stages = &all[body * S..][..S];
    stages.first_chunk().expect("a slice of S is an array of S")
}

/// The stages of one body, to be changed.
#[inline(always)]
fn part_mut<X, const S: usize>(all: &mut [X], body: usize) -> &mut [X; S] {
    let stages = &mut all[body * S..][..S];
    stages.first_chunk_mut().expect("a slice of S is an array of S")
}

/// Qᵢ − q of one body, drift and the sum over the stages; and what rounding took from it.
#[inline(always)]
fn increment<T: Scalar, const D: usize, const S: usize>(
    row: &[(T, T); S],
    (drift, rest): (T, T),
    velocity: &[T; D],
    total: &[[T; D]; S],
) -> ([T; D], [T; D]) {
    let (bend, low) = weighted(row, total);
    let (increment, lost) = two_sum(&scaled(drift, velocity), &bend);
    (increment, sum(&lost, &add_scaled(&low, rest, velocity)))
}

/// The sum over all stages but the last, and by itself that of what rounding took from the weights: added one by one to
/// the larger numbers it would be lost each time, and energy would drift.
#[inline(always)]
fn weighted<T: Scalar, const D: usize, const S: usize>(
    weights: &[(T, T); S],
    total: &[[T; D]; S],
) -> ([T; D], [T; D]) {
    let zero = [T::from_f64(0.0); D];
    (0..S - 1).fold((zero, zero), |(high, low), j| {
        (add_scaled(&high, weights[j].0, &total[j]), add_scaled(&low, weights[j].1, &total[j]))
    })
}

#[inline(always)]
fn pair<T: Scalar>((high, low): (f64, f64)) -> (T, T) {
    (T::from_f64(high), T::from_f64(low))
}

/// Inverts the matrix of rows 1 … S − 1 and columns 0 … S − 2 in place, by Gauss and Jordan without exchanges: leading
/// minors of the tables are positive, and normals of successive stages do not turn over. Row i + 1, column j is then
/// that of unknown i and equation j + 1. (With rows from 0 on the compiler makes it slower by a quarter of a step.)
#[inline(always)]
fn invert<T: Scalar, const S: usize>(a: &mut [T]) {
    for k in 0..S - 1 {
        let pivot = T::from_f64(1.0) / a[(k + 1) * S + k];
        a[(k + 1) * S + k] = T::from_f64(1.0);
        for j in 0..S - 1 {
            a[(k + 1) * S + j] = pivot * a[(k + 1) * S + j];
        }
        for i in 0..S - 1 {
            if i != k {
                let factor = a[(i + 1) * S + k];
                a[(i + 1) * S + k] = T::from_f64(0.0);
                for j in 0..S - 1 {
                    a[(i + 1) * S + j] = a[(i + 1) * S + j] - factor * a[(k + 1) * S + j];
                }
            }
        }
    }
}
