//! The two halves of a step on a surface: drift to where g(q′) = 0, settle to where ∇g·p′ = 0.

use crate::effect::force::Force;
use crate::effect::list::Forces;
use crate::kernel::functions::ConstraintKernel;
use crate::motion::bodies::{Bodies, Count};
use crate::motion::failure::Failure;
use crate::motion::iteration::Iteration;
use crate::motion::start::MAX_PROJECTION_STEPS;
use crate::motion::witness::Witness;
use crate::number::real::{Mask, Real};
use crate::number::vector::{dot, largest, scaled, sum, two_sum};
use crate::solve::nearing::Nearing;
use crate::solve::root::FAR_GUESS;
use crate::solve::stop::NOISE;
use crate::systems::surface::diagnosis::FailureAt;
use crate::systems::surface::kept::Kept;
use crate::systems::surface::normal::{Normal, multiplier_from_curvature};
use crate::systems::surface::position::{Departure, Landing};

/// First half: kick, drift, and the position multiplier. Lanes that have landed already stay there.
#[inline(always)]
pub(crate) fn drift<T, K, F, N, W, const D: usize>(
    kick: f64,
    h: f64,
    constraint: &K,
    bodies: &mut Bodies<N, T, Kept<N, T, F, D>, D>,
    body: usize,
    landed: Option<(Landing<T, D>, T::Mask)>,
    witness: &mut W,
) -> Result<(), Failure>
where
    T: Real,
    K: ConstraintKernel<T, D, 1>,
    F: Forces<T, D>,
    N: Count,
    W: Witness<T>,
{
    let step = T::from_f64(h);
    let (pushed, half_square) = (T::from_f64(h * kick), T::from_f64(0.5 * h * h));
    let share = T::from_f64(2.0 * kick / h); // of the force in the motion: 1 for RATTLE
    let (q, q_low) = (&bodies.q.as_ref()[body], &bodies.q_low.as_ref()[body]);
    let (p, p_low) = (&bodies.p.as_ref()[body], &bodies.p_low.as_ref()[body]);
    let normal = &bodies.kept.normal.as_ref()[body];
    let force = bodies.kept.force.as_ref()[body];

    let (_, _, [bend]) = constraint.jet(q, p); // pᵀ∇²g p = ∓κ |∇g| |p|²
    let path = sum(&scaled(step, p), &scaled(step, p_low));
    let departure = Departure {
        q,
        q_low,
        normal,
        free: force.add_to(path, pushed),
        guess: half_square * multiplier_from_curvature(bend, force.dot(&normal.gradient, share), normal),
    };
    let landing = land(constraint, h, body, &departure, p, bend, &path, &force, pushed, landed)?;

    arrive(kick, h, bodies, body, &landing, witness);
    Ok(())
}

/// Where a body lands by any iteration and from any guess of λ, which also tells h·κ·|v|; and in which lanes that is good enough
/// to tell that the root is the right one.
#[inline(always)]
pub(crate) fn try_to_land<X, T, K, F, N, const D: usize>(
    kick: f64,
    h: f64,
    lambda: Option<T>,
    constraint: &K,
    bodies: &Bodies<N, T, Kept<N, T, F, D>, D>,
    body: usize,
) -> (Landing<T, D>, T::Mask)
where
    X: Iteration,
    T: Real,
    K: ConstraintKernel<T, D, 1>,
    F: Forces<T, D>,
    N: Count,
{
    let (step, pushed) = (T::from_f64(h), T::from_f64(h * kick));
    let (q, q_low) = (&bodies.q.as_ref()[body], &bodies.q_low.as_ref()[body]);
    let (p, p_low) = (&bodies.p.as_ref()[body], &bodies.p_low.as_ref()[body]);
    let (normal, force) = (&bodies.kept.normal.as_ref()[body], bodies.kept.force.as_ref()[body]);
    let along = force.dot(&normal.gradient, T::from_f64(2.0 * kick / h));
    let (lambda, bend) = if let Some(lambda) = lambda {
        (lambda, lambda * dot(&normal.gradient, &normal.gradient) + along)
    } else {
        let [bend] = constraint.jet(q, p).2;
        (multiplier_from_curvature(bend, along, normal), bend)
    };
    let speed_square = dot(p, p);
    let gentle = (T::from_f64(4.0) * step * step * bend * bend * normal.inverse_square).le(speed_square);
    let departure = Departure {
        q,
        q_low,
        normal,
        free: force.add_to(sum(&scaled(step, p), &scaled(step, p_low)), pushed),
        guess: T::from_f64(0.5 * h * h) * lambda,
    };
    let path_square = step * step * speed_square + force.square(pushed);
    let (landing, trusted) = departure.try_to_land::<X, K>(constraint, path_square);
    (landing, gentle.and(trusted))
}

/// [`drift`], out of the way of what is hoped for.
#[cold]
#[inline(never)]
pub(crate) fn drift_again<T, K, F, N, W, const D: usize>(
    kick: f64,
    h: f64,
    constraint: &K,
    bodies: &mut Bodies<N, T, Kept<N, T, F, D>, D>,
    body: usize,
    landed: (Landing<T, D>, T::Mask),
    witness: &mut W,
) -> Result<(), Failure>
where
    T: Real,
    K: ConstraintKernel<T, D, 1>,
    F: Forces<T, D>,
    N: Count,
    W: Witness<T>,
{
    drift(kick, h, constraint, bodies, body, Some(landed), witness)
}

/// Takes a body to where it lands.
#[inline(always)]
pub(crate) fn arrive<T, F, N, W, const D: usize>(
    kick: f64,
    h: f64,
    bodies: &mut Bodies<N, T, Kept<N, T, F, D>, D>,
    body: usize,
    landing: &Landing<T, D>,
    witness: &mut W,
) where
    T: Real,
    F: Forces<T, D>,
    N: Count,
    W: Witness<T>,
{
    let (q, q_low) = (&mut bodies.q.as_mut()[body], &mut bodies.q_low.as_mut()[body]);
    let (p, p_low) = (&mut bodies.p.as_mut()[body], &mut bodies.p_low.as_mut()[body]);
    let (normal, force) = (&mut bodies.kept.normal.as_mut()[body], bodies.kept.force.as_ref()[body]);
    let per_step = landing.multiplier / T::from_f64(h);
    witness.position_multiplier(body, per_step / T::from_f64(0.5 * h));
    let change = force.add_to(sum(p_low, &scaled(per_step, &normal.gradient)), T::from_f64(kick));
    (*p, *p_low) = two_sum(p, &change);
    (*q, *q_low) = two_sum(q, &sum(q_low, &landing.increment));
    *normal = Normal::new(landing.gradient);
}

/// Where the departing body lands: on the root that its motion, by `path` and under `pushed` times the force, leads to. Lanes
/// that have landed already stay there.
#[allow(clippy::too_many_arguments, reason = "what a step knows when it departs")]
#[inline(always)]
pub(crate) fn land<T: Real, K: ConstraintKernel<T, D, 1>, F: Force<T, D>, const D: usize>(
    constraint: &K,
    h: f64,
    body: usize,
    departure: &Departure<'_, T, D>,
    p: &[T; D],
    bend: T,
    path: &[T; D],
    force: &F,
    pushed: T,
    landed: Option<(Landing<T, D>, T::Mask)>,
) -> Result<Landing<T, D>, Failure> {
    let step = T::from_f64(h);
    let (speed_square, bent_square) =
        (dot(p, p), step * step * bend * bend * departure.normal.inverse_square);
    let within_reach = bent_square.le(speed_square); // (h·κ·|v|)² ≤ 1, times |v|²
    let zero = T::from_f64(0.0);
    let done = landed.as_ref().map_or(zero.lt(zero), |&(_, done)| done);
    if !within_reach.or(done).all() {
        return Err(FailureAt::of(body, within_reach.or(done)).too_long(h, departure, p, bend));
    }
    let mut landing = departure.land(constraint, |_| ());
    if let Some((before, done)) = landed {
        landing = before.or(done, landing);
    }
    let path_square = step * step * speed_square + force.square(pushed);
    let gentle = (T::from_f64(4.0) * bent_square).le(speed_square); // h·κ·|v| ≤ ½
    let trusted = done.or(gentle.and(departure.trusts(&landing, path_square, FAR_GUESS)));
    if !trusted.all() {
        let push = scaled(pushed, &force.components());
        landing = landing.or(trusted, departure.follow(constraint, path, &push));
        if !landing.converged.all() {
            return Err(FailureAt::of(body, landing.converged).lost(h, constraint, departure, p, bend));
        }
    }
    Ok(landing)
}

/// Second half: kick with the new force, and the momentum multiplier. False where p is not finite.
#[inline(always)]
pub(crate) fn settle<T, F, N, W, const D: usize>(
    kick: f64,
    h: f64,
    bodies: &mut Bodies<N, T, Kept<N, T, F, D>, D>,
    body: usize,
    witness: &mut W,
) -> T::Mask
where
    T: Real,
    F: Forces<T, D>,
    N: Count,
    W: Witness<T>,
{
    let kicked = T::from_f64(kick);
    let (p, p_low) = (&mut bodies.p.as_mut()[body], &mut bodies.p_low.as_mut()[body]);
    let change = bodies.kept.force.as_ref()[body].add_to(*p_low, kicked);
    let (eta, normal_part) = bodies.kept.normal.as_ref()[body].projection(&sum(p, &change));
    witness.momentum_multiplier(body, eta / T::from_f64(0.5 * h));
    (*p, *p_low) = two_sum(p, &sum(&change, &normal_part));
    is_finite(p)
}

/// Whether a momentum, and what is made of its square, is a number.
#[inline(always)]
pub(crate) fn is_finite<T: Real, const D: usize>(p: &[T; D]) -> T::Mask {
    dot(p, p).le(T::from_f64(f64::MAX))
}

/// λ at a body's place, and the sum of force and constraint.
#[inline(always)]
pub(crate) fn pull<T, K, F, N, const D: usize>(
    constraint: &K,
    bodies: &Bodies<N, T, Kept<N, T, F, D>, D>,
    body: usize,
) -> (T, [T; D])
where
    T: Real,
    K: ConstraintKernel<T, D, 1>,
    F: Forces<T, D>,
    N: Count,
{
    let (q, p) = (&bodies.q.as_ref()[body], &bodies.p.as_ref()[body]);
    let (normal, force) = (&bodies.kept.normal.as_ref()[body], bodies.kept.force.as_ref()[body]);
    let [bend] = constraint.jet(q, p).2;
    let along = force.dot(&normal.gradient, T::from_f64(1.0));
    let lambda = multiplier_from_curvature(bend, along, normal);
    (lambda, force.add_to(normal.gradient.map(|n| lambda * n), T::from_f64(1.0)))
}

/// Newton's iteration q ← q − ∇g g/|∇g|² until it no longer gets nearer; lanes that are there wait for the others.
#[inline(always)]
pub(crate) fn project<T, K, F, N, const D: usize>(
    h: f64,
    constraint: &K,
    bodies: &mut Bodies<N, T, Kept<N, T, F, D>, D>,
    body: usize,
) -> Result<(), Failure>
where
    T: Real,
    K: ConstraintKernel<T, D, 1>,
    F: Forces<T, D>,
    N: Count,
{
    let (q, q_low) = (&mut bodies.q.as_mut()[body], &mut bodies.q_low.as_mut()[body]);
    let zero = T::from_f64(0.0);
    let path = scaled(T::from_f64(h), &bodies.p.as_ref()[body]);
    let rounding = T::from_f64(f64::EPSILON) * largest(q).max(largest(&path));
    let (mut nearing, mut left) = (Nearing::leaving(1.0), zero);
    for _ in 0..MAX_PROJECTION_STEPS {
        let ([g], [gradient]) = constraint.value_and_jacobian(q);
        let normal = Normal::new(gradient);
        let shift = scaled(-g * normal.inverse_square, &gradient);
        let distance = dot(&shift, &shift).sqrt();
        let near = distance.le(T::from_f64(NOISE) * rounding);
        let (arrived, lost) = nearing.look(distance, distance.le(rounding), near);
        if arrived.all() {
            bodies.kept.normal.as_mut()[body] = normal;
            return Ok(());
        }
        if !lost.not().all() {
            return Err(FailureAt::of(body, lost.not()).not_projected(distance, &path, q));
        }
        let shift = shift.map(|shift| T::select(arrived, zero, shift));
        (*q, *q_low) = two_sum(q, &sum(q_low, &shift));
        left = distance;
    }
    Err(FailureAt::of(body, false).not_projected(left, &path, q))
}
