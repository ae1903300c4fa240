//! The two halves of a step on a surface: drift to g(q′) = 0, settle to ∇g·p′ = 0.

use crate::effect::force::Force;
use crate::effect::list::Forces;
use crate::kernel::functions::ConstraintKernel;
use crate::kernel::rounding::size_along;
use crate::motion::bodies::Count;
use crate::motion::failure::Failure;
use crate::motion::iteration::{Iteration, Kind};
use crate::motion::start::MAX_PROJECTION_STEPS;
use crate::motion::witness::{Hears, Whoever, Witness};
use crate::number::real::Scalar;
use crate::number::vector::{dot, largest, scaled, sum, two_sum};
use crate::solve::nearing::Nearing;
use crate::solve::stop::NOISE;
use crate::systems::surface::diagnosis::FailureAt;
use crate::systems::surface::equation::{Equation, is_rounding};
use crate::systems::surface::kept::BodiesOf;
use crate::systems::surface::landing::Attempt;
use crate::systems::surface::normal::{Normal, multiplier_from_curvature};
use crate::systems::surface::position::{Departure, Landing};
use std::array::from_fn;

impl<N: Count, T: Scalar, F: Forces<T, D>, const D: usize> BodiesOf<N, T, F, D> {
    /// A body that departs: its path, force and, where a guess of λ is given, h·κ·|v| from that instead of second
    /// derivatives.
    #[inline(always)]
    fn departure(
        &self,
        kick: f64,
        h: f64,
        lambda: Option<T>,
        equation: &(impl Equation<T, D> + ?Sized),
        body: usize,
    ) -> Departure<'_, T, D> {
        let (step, pushed) = (T::from_f64(h), T::from_f64(h * kick));
        let share = T::from_f64(2.0 * kick / h); // of the force in the motion: 1 for RATTLE
        let (q, q_low) = (&self.q.as_ref()[body], &self.q_low.as_ref()[body]);
        let (p, p_low) = (&self.p.as_ref()[body], &self.p_low.as_ref()[body]);
        let (normal, force) = (&self.kept.normal.as_ref()[body], self.kept.force.as_ref()[body]);
        let along = force.dot(&normal.gradient, share);
        let (lambda, bend) = if let Some(lambda) = lambda {
            (lambda, lambda * dot(&normal.gradient, &normal.gradient) + along)
        } else {
            let bend = equation.bend(q, p);
            (multiplier_from_curvature(bend, along, normal), bend)
        };
        let path = sum(&scaled(step, p), &scaled(step, p_low));
        Departure {
            h,
            body,
            q,
            q_low,
            p,
            normal,
            bend,
            path,
            push: scaled(pushed, &force.components()),
            push_square: force.square(pushed),
            free: force.add_to(path, pushed),
            guess: T::from_f64(0.5 * h * h) * lambda,
        }
    }

    /// First half: kick, drift, and the position multiplier, by any iteration and from any guess of λ, or from g̈ = 0.
    /// `weights` are those of what guesses [were off by](crate::solve::aim::Pace).
    #[allow(clippy::too_many_arguments, reason = "what a step knows when it departs")]
    #[inline(always)]
    pub(super) fn drift<X: Iteration, K: ConstraintKernel<T, D, 1>, W: Witness<T>>(
        &mut self,
        kick: f64,
        h: f64,
        lambda: Option<T>,
        weights: [f64; 2],
        constraint: &K,
        body: usize,
        witness: &mut W,
    ) -> Result<(), Failure> {
        let departure = self.departure(kick, h, lambda, constraint, body);
        let aim = &self.kept.aim.as_ref()[body];
        let attempt = departure.attempt::<X>(constraint, aim, weights);
        if !attempt.certain {
            let way = (X::KIND, lambda.is_none());
            let copy = attempt; // what is given away by reference would else be kept in memory by all steps
            return self.drift_rarely(kick, h, constraint, body, &copy, way, witness);
        }
        let off = attempt.landing.multiplier - attempt.guess;
        self.arrive(kick, h, body, &attempt.landing, off, witness);
        Ok(())
    }

    /// The same where an attempt, by this iteration and from g̈ = 0 or not, may have found another root.
    #[allow(clippy::too_many_arguments, reason = "as above")]
    #[cold]
    #[inline(never)]
    fn drift_rarely(
        &mut self,
        kick: f64,
        h: f64,
        equation: &dyn Equation<T, D>,
        body: usize,
        attempt: &Attempt<T, D>,
        (kind, from_state): (Kind, bool),
        witness: &mut dyn Hears<T>,
    ) -> Result<(), Failure> {
        let by_default = from_state && kind == Kind::Newton;
        let lambda = from_state.then(|| attempt.guess / T::from_f64(0.5 * h * h)); // as known as second derivatives
        let mut departure = self.departure(kick, h, lambda, equation, body);
        if from_state {
            (departure.guess, departure.bend) = (attempt.guess, attempt.bend);
        }
        let (landing, other) = if by_default {
            departure.look_again(equation, attempt)?
        } else {
            departure.land_instead(equation, attempt, matches!(kind, Kind::Newton | Kind::Symmetric))?
        };
        let off = if other { T::from_f64(f64::NAN) } else { landing.multiplier - attempt.guess };
        self.arrive(kick, h, body, &landing, off, &mut Whoever(witness));
        Ok(())
    }

    /// Takes a body to where it lands, after a guess that was off by `off`.
    #[inline(always)]
    fn arrive<W: Witness<T>>(
        &mut self,
        kick: f64,
        h: f64,
        body: usize,
        landing: &Landing<T, D>,
        off: T,
        witness: &mut W,
    ) {
        let (q, q_low) = (&mut self.q.as_mut()[body], &mut self.q_low.as_mut()[body]);
        let (p, p_low) = (&mut self.p.as_mut()[body], &mut self.p_low.as_mut()[body]);
        let (normal, force) = (&mut self.kept.normal.as_mut()[body], self.kept.force.as_ref()[body]);
        let per_step = landing.multiplier / T::from_f64(h);
        witness.position_multiplier(body, per_step / T::from_f64(0.5 * h));
        let change = force.add_to(sum(p_low, &scaled(per_step, &normal.gradient)), T::from_f64(kick));
        (*p, *p_low) = two_sum(p, &change);
        (*q, *q_low) = two_sum(q, &sum(q_low, &landing.increment));
        *normal = Normal::new(landing.gradient);
        self.kept.aim.as_mut()[body].note(off);
    }

    /// Second half: kick with the new force, and the momentum multiplier. False where p is not finite.
    #[inline(always)]
    pub(super) fn settle<W: Witness<T>>(&mut self, kick: f64, h: f64, body: usize, witness: &mut W) -> bool {
        let kicked = T::from_f64(kick);
        let (p, p_low) = (&mut self.p.as_mut()[body], &mut self.p_low.as_mut()[body]);
        let change = self.kept.force.as_ref()[body].add_to(*p_low, kicked);
        let (eta, normal_part) = self.kept.normal.as_ref()[body].projection(&sum(p, &change));
        witness.momentum_multiplier(body, eta / T::from_f64(0.5 * h));
        (*p, *p_low) = two_sum(p, &sum(&change, &normal_part));
        is_finite(p)
    }

    /// λ at a body's place, and the sum of force and constraint.
    #[inline(always)]
    pub(super) fn pull<K: ConstraintKernel<T, D, 1>>(&self, constraint: &K, body: usize) -> (T, [T; D]) {
        let (q, p) = (&self.q.as_ref()[body], &self.p.as_ref()[body]);
        let (normal, force) = (&self.kept.normal.as_ref()[body], self.kept.force.as_ref()[body]);
        let [bend] = constraint.jet(q, p).2;
        let along = force.dot(&normal.gradient, T::from_f64(1.0));
        let lambda = multiplier_from_curvature(bend, along, normal);
        (lambda, force.add_to(scaled(lambda, &normal.gradient), T::from_f64(1.0)))
    }

    /// Newton's iteration q ← q − ∇g g/|∇g|² until it no longer gets nearer.
    #[inline(always)]
    pub(super) fn project<K: ConstraintKernel<T, D, 1>>(
        &mut self,
        h: f64,
        constraint: &K,
        body: usize,
    ) -> Result<(), Failure> {
        let (q, q_low) = (&mut self.q.as_mut()[body], &mut self.q_low.as_mut()[body]);
        let zero = T::from_f64(0.0);
        let path = scaled(T::from_f64(h), &self.p.as_ref()[body]);
        let rounding = T::from_f64(T::EPSILON) * largest(q).max(largest(&path));
        let places: [T; D] = from_fn(|i| q[i].abs().max(path[i].abs()));
        let (mut nearing, mut left) = (Nearing::leaving(1.0), zero);
        for _ in 0..MAX_PROJECTION_STEPS {
            let ([g], [gradient]) = constraint.value_and_jacobian(q);
            let normal = Normal::new(gradient);
            let shift = scaled(-g * normal.inverse_square, &gradient);
            let distance = dot(&shift, &shift).sqrt();
            let near = distance.le(T::from_f64(NOISE) * rounding);
            let floor =
                T::from_f64(T::EPSILON) * size_along(&gradient, dot(&gradient, &gradient).sqrt(), &places);
            let (arrived, lost) = nearing.look(distance, distance.le(floor), near);
            let off = g * normal.inverse_square;
            if arrived || (lost && is_rounding(constraint, q, &gradient, largest(&places), off)) {
                self.kept.normal.as_mut()[body] = normal;
                return Ok(());
            }
            if lost {
                return Err(FailureAt::of(body).not_projected(distance, &path, q));
            }
            (*q, *q_low) = two_sum(q, &sum(q_low, &shift));
            left = distance;
        }
        Err(FailureAt::of(body).not_projected(left, &path, q))
    }
}

/// Whether a momentum, and what is made of its square, is a number.
#[inline(always)]
pub(crate) fn is_finite<T: Scalar, const D: usize>(p: &[T; D]) -> bool {
    dot(p, p).le(T::from_f64(f64::MAX))
}
