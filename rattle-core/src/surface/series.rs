//! The motion of bodies on surfaces as a power series in time.
//!
//! With aₖ the coefficient of tᵏ of a, n = ∇g and λ from n·v = 0, order by order:
//!
//! ```text
//! qₖ₊₁ = vₖ/(k + 1),   vₖ₊₁ = (fₖ + Σⱼ λⱼ nₖ₋ⱼ)/(k + 1),   Σⱼ nⱼ·vₖ₊₁₋ⱼ = 0
//! ```
//!
//! nₖ₊₁ is known from q₀ … qₖ₊₁, so that the last sum gives λₖ. No second derivative of g is needed.

use super::{BodiesOf, OnSurface};
use crate::bodies::Count;
use crate::effect::{Effects, Field, Force};
use crate::error::StepFailure;
use crate::kernel::{Constraint, ConstraintKernel};
use crate::real::Real;
use crate::series::{Program, Recorded, record};
use crate::stepper::{Failure, Witness};
use crate::vector::{add_scaled, dot, scaled, sum};
use std::array::from_fn;

/// ∇g of a body, and the forces on all.
#[derive(Debug, Clone)]
pub(crate) struct Motion {
    normal: Program,
    force: Program,
}

impl Motion {
    /// The functions of a scene, recorded; none if they go different ways by their values.
    pub(crate) fn of<C: Constraint<D, 1>, E: Effects<D>, const D: usize>(
        constraint: &C,
        effects: &E,
        bodies: usize,
    ) -> Option<Self> {
        let normal = record(D, |q| {
            let [gradient] = constraint.kernel::<Recorded>().jacobian(&from_fn(|i| q[i]));
            gradient.to_vec()
        })?;
        let force = record(D * bodies, |q| {
            let positions: Vec<[Recorded; D]> = q.chunks(D).map(|q| from_fn(|i| q[i])).collect();
            let mut forces = vec![Force::zero(); bodies];
            effects.field::<Recorded>().evaluate(&positions, &mut forces);
            forces.iter().flat_map(Force::components).collect()
        })?;
        Some(Self { normal, force })
    }
}

/// Room for the coefficients of every operation, and of λ, body by body.
#[derive(Debug, Clone)]
pub(crate) struct Tapes<T> {
    normal: Vec<T>,
    force: Vec<T>,
    lambda: Vec<T>,
}

impl<T: Real> Tapes<T> {
    pub(super) fn new(motion: &Motion, bodies: usize, orders: usize) -> Self {
        let zeros = |n| vec![T::from_f64(0.0); n];
        Self {
            normal: zeros(bodies * motion.normal.room(orders)),
            force: zeros(motion.force.room(orders)),
            lambda: zeros(bodies * orders),
        }
    }
}

impl<K, F, N: Count> OnSurface<K, F, N> {
    /// Writes q₀, q₁, … of all bodies in turn, as many as `series` has room for.
    pub(super) fn expand_motion<T, W, const D: usize>(
        &self,
        bodies: &mut BodiesOf<N, T, F, D>,
        series: &mut [[T; D]],
        witness: &mut W,
    ) -> Result<(), Failure>
    where
        T: Real,
        K: ConstraintKernel<T, D, 1>,
        F: Field<T, D>,
        W: Witness<T>,
    {
        let n = self.count.number();
        let orders = series.len() / n;
        let (Some(motion), Some(tapes)) = (&self.motion, &mut bodies.kept.tapes) else {
            return Err(Failure { body: 0, cause: StepFailure::NoSeries });
        };
        let Tapes { normal, force, lambda } = &mut **tapes;
        let part = motion.normal.room(orders);
        series[..n].copy_from_slice(bodies.q.as_ref());
        series[n..2 * n].copy_from_slice(bodies.p.as_ref());
        for body in 0..n {
            let tape = &mut normal[body * part..][..part];
            motion.normal.extend(0, orders, tape, |i| series[body][i]);
        }
        for k in 0..orders - 2 {
            motion.force.extend(k, orders, force, |i| series[k * n + i / D][i % D]);
            let next = T::from_f64((k + 1) as f64);
            for body in 0..n {
                let tape = &mut normal[body * part..][..part];
                motion.normal.extend(k + 1, orders, tape, |i| series[(k + 1) * n + body][i]);
                let n_of = |j: usize| -> [T; D] { from_fn(|i| motion.normal.output(i, orders, tape)[j]) };
                let v_of = |j: usize| scaled(T::from_f64((j + 1) as f64), &series[(j + 1) * n + body]);
                let mut turn = T::from_f64(0.0);
                for j in 1..=k + 1 {
                    turn = turn + dot(&n_of(j), &v_of(k + 1 - j));
                }
                let lambda = &mut lambda[body * orders..][..orders];
                let mut pull = from_fn(|i| motion.force.output(body * D + i, orders, force)[k]);
                for j in 0..k {
                    pull = add_scaled(&pull, lambda[j], &n_of(k - j));
                }
                let normal = &bodies.kept.normal.as_ref()[body];
                lambda[k] = -(next * turn + dot(&normal.gradient, &pull)) * normal.inverse_square;
                pull = sum(&pull, &scaled(lambda[k], &normal.gradient));
                let share = T::from_f64(1.0 / ((k + 1) * (k + 2)) as f64);
                series[(k + 2) * n + body] = scaled(share, &pull);
            }
        }
        for body in 0..n {
            witness.position_multiplier(body, lambda[body * orders]);
        }
        Ok(())
    }
}
