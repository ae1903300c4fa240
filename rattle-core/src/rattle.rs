//! RATTLE: the symplectic integrator of constrained mechanics (Andersen 1983).
//!
//! ```text
//! p½ = p  + h/2 (∇g(q) λ − ∇U(q))         λ such that g(q′) = 0
//! q′ = q  + h p½
//! p′ = p½ + h/2 (∇g(q′) μ − ∇U(q′))       μ such that ∇g(q′)·p′ = 0
//! ```
//!
//! Second order, symplectic, and reversible while the step is short enough to have one clear solution, h·κ·|v| ≲ ½.
//! λ and μ are on one scale, that of q̈ = −∇U + ∇g λ; each is
//! first order, their mean (μₙ + λₙ₊₁)/2 at tₙ second.
//!
//! The step is formed as an increment and added once, q and p are compensated sums (Kahan 1965):
//! rounding in the energy then grows like √n steps instead of like n. The first guess of λ comes
//! from the second derivative of g along the motion, so that a step is a pure function of the state.
//!
//! Source: E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, VII.1.4.

use crate::bodies::{Bodies, Count, Normal};
use crate::effect::{Field, Force};
use crate::kernel::ConstraintKernel;
use crate::real::{Mask, Real};
use crate::solver::{Departure, FAR_GUESS, multiplier_from_curvature};
use crate::stepper::{Failure, Stepper, System, Witness};
use crate::vector::{dot, scaled, sum, two_sum};

/// RATTLE with a constant step size, second order.
///
/// A negative step size runs backwards in time. A step needs h·κ·|v| < 1, with κ the normal curvature of the
/// surface along the velocity v, and is an error otherwise; accurate runs stay below a fifth of that.
///
/// ```
/// # use rattle_core::rattle::Rattle;
/// let method = Rattle::new(0.01);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rattle {
    h: f64,
}

impl Rattle {
    /// RATTLE with step size `h`, in the unit of time.
    #[must_use]
    pub fn new(h: f64) -> Self {
        Self { h }
    }
}

impl Stepper for Rattle {
    fn step_size(&self) -> f64 {
        self.h
    }
    fn order(&self) -> u32 {
        2
    }
    fn name(&self) -> &'static str {
        "RATTLE"
    }

    #[inline(always)]
    fn step<T, K, F, N, W, const D: usize>(
        &self,
        system: &System<K, F>,
        bodies: &mut Bodies<N, T, F::Force, D>,
        witness: &mut W,
    ) -> Result<(), Failure>
    where
        T: Real,
        K: ConstraintKernel<T, D, 1>,
        F: Field<T, D>,
        N: Count,
        W: Witness<T>,
    {
        step(self.h, system, bodies, witness)
    }
}

/// One step of size `h`; on failure `bodies` are left half way.
#[inline(always)]
pub(crate) fn step<T, K, F, N, W, const D: usize>(
    h: f64,
    system: &System<K, F>,
    bodies: &mut Bodies<N, T, F::Force, D>,
    witness: &mut W,
) -> Result<(), Failure>
where
    T: Real,
    K: ConstraintKernel<T, D, 1>,
    F: Field<T, D>,
    N: Count,
    W: Witness<T>,
{
    for body in 0..bodies.q.as_ref().len() {
        drift(h, &system.constraint, bodies, body, witness)?;
    }
    system.field.evaluate(bodies.q.as_ref(), bodies.force.as_mut());
    for body in 0..bodies.q.as_ref().len() {
        let finite = settle(h, bodies, body, witness);
        if !finite.all() {
            return Err(Failure::at(body, finite).not_finite(
                system,
                bodies.q.as_ref(),
                bodies.normal.as_ref(),
            ));
        }
    }
    Ok(())
}

/// First half: kick, drift, and the position multiplier.
#[inline(always)]
fn drift<T, K, F, N, W, const D: usize>(
    h: f64,
    constraint: &K,
    bodies: &mut Bodies<N, T, F, D>,
    body: usize,
    witness: &mut W,
) -> Result<(), Failure>
where
    T: Real,
    K: ConstraintKernel<T, D, 1>,
    F: Force<T, D>,
    N: Count,
    W: Witness<T>,
{
    let (step, half, half_square) = (T::from_f64(h), T::from_f64(0.5 * h), T::from_f64(0.5 * h * h));
    let (q, q_low) = (&mut bodies.q.as_mut()[body], &mut bodies.q_low.as_mut()[body]);
    let (p, p_low) = (&mut bodies.p.as_mut()[body], &mut bodies.p_low.as_mut()[body]);
    let normal = &mut bodies.normal.as_mut()[body];
    let force = bodies.force.as_ref()[body];

    let (_, _, [bend]) = constraint.jet(q, p); // pᵀ∇²g p = ∓κ |∇g| |p|²
    let path = sum(&scaled(step, p), &scaled(step, p_low));
    let departure = Departure {
        q,
        q_low,
        normal,
        free: force.add_to(path, half_square),
        guess: half_square * multiplier_from_curvature(bend, force.dot(&normal.gradient), normal),
    };
    let (speed_square, bent_square) = (dot(p, p), step * step * bend * bend * normal.inverse_square);
    let within_reach = bent_square.le(speed_square); // (h·κ·|v|)² ≤ 1, times |v|²
    if !within_reach.all() {
        return Err(Failure::at(body, within_reach).too_long(h, &departure, p, bend));
    }
    let mut landing = departure.land(constraint, |_| ());
    let path_square = step * step * speed_square + force.square(half_square);
    let gentle = (T::from_f64(4.0) * bent_square).le(speed_square); // h·κ·|v| ≤ ½
    let trusted = gentle.and(departure.trusts(&landing, path_square, FAR_GUESS));
    if !trusted.all() {
        let push = scaled(half_square, &force.components());
        landing = landing.or(trusted, departure.follow(constraint, &path, &push));
        if !landing.converged.all() {
            return Err(Failure::at(body, landing.converged).lost(h, constraint, &departure, p, bend));
        }
    }

    let per_step = landing.multiplier / step;
    witness.position_multiplier(body, per_step / half);
    let kick = force.add_to(sum(p_low, &scaled(per_step, &normal.gradient)), half);
    (*p, *p_low) = two_sum(p, &kick);
    (*q, *q_low) = two_sum(q, &sum(q_low, &landing.increment));
    *normal = Normal::new(landing.gradient);
    Ok(())
}

/// Second half: kick with the new force, and the momentum multiplier. False where p is not finite.
#[inline(always)]
fn settle<T, F, N, W, const D: usize>(
    h: f64,
    bodies: &mut Bodies<N, T, F, D>,
    body: usize,
    witness: &mut W,
) -> T::Mask
where
    T: Real,
    F: Force<T, D>,
    N: Count,
    W: Witness<T>,
{
    let half = T::from_f64(0.5 * h);
    let (p, p_low) = (&mut bodies.p.as_mut()[body], &mut bodies.p_low.as_mut()[body]);
    let kick = bodies.force.as_ref()[body].add_to(*p_low, half);
    let (eta, normal_part) = bodies.normal.as_ref()[body].projection(&sum(p, &kick));
    witness.momentum_multiplier(body, eta / half);
    (*p, *p_low) = two_sum(p, &sum(&kick, &normal_part));
    dot(p, p).le(T::from_f64(f64::MAX))
}
