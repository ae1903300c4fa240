//! Collocation on surfaces: the stages of [`lobatto`](crate::lobatto) solved together, body by body.
//!
//! An iteration evaluates g, ∇g and the force once at every stage, forms the new sums, and solves the linearised
//! constraints for the changes of λ:
//!
//! ```text
//! Σⱼ h² aᵢⱼ (∇g(Qᵢ)·∇g(Qⱼ)) δλⱼ = −rᵢ,     rᵢ = g(Qᵢ) + ∇g(Qᵢ)·h² Σⱼ aᵢⱼ (Fⱼ − Fⱼ before),   F = f + ∇g λ
//! ```
//!
//! **First guess.** Constant acceleration, from g̈ = 0 at the start. Where that does not converge, steps of RATTLE from
//! node to node. **Stopping.** Displacements of an iteration shrink by a factor that the last two tell; the solve ends
//! once the next would be below 1/16 of the rounding of the positions. **Which root.** Normals of successive stages must
//! not be turned over.

use super::{BodiesOf, Kept, Normal, OnSurface};
use crate::bodies::{Bodies, Count};
use crate::effect::{Field, Force};
use crate::kernel::ConstraintKernel;
use crate::lobatto::Table;
use crate::real::{Mask, Real};
use crate::solver::multiplier_from_curvature;
use crate::stepper::{Failure, Witness};
use crate::system::System;
use crate::vector::{add_scaled, dot, largest, sum, two_sum};
use std::array::from_fn;

/// Iterations after which a step is given up; six to ten suffice where there is a solution.
const MAX_ITERATIONS: usize = 60;

/// Room for the stages of all bodies: stage by stage, body by body.
#[derive(Debug, Clone, Default)]
pub(crate) struct Stages<T, F, const D: usize> {
    q: Vec<[T; D]>,
    force: Vec<F>,
    normal: Vec<[T; D]>,
    /// f + ∇g λ.
    total: Vec<[T; D]>,
    /// The change of `total` in the last evaluation.
    change: Vec<[T; D]>,
    lambda: Vec<T>,
    /// Right sides, then δλ.
    right: Vec<T>,
    /// The matrix of one body, by rows.
    matrix: Vec<T>,
}

impl<T: Real, F: Force<T, D>, const D: usize> Stages<T, F, D> {
    pub(super) fn new(stages: usize, bodies: usize) -> Self {
        let (n, zero) = (stages * bodies, T::from_f64(0.0));
        Self {
            q: vec![[zero; D]; n],
            force: vec![F::zero(); n],
            normal: vec![[zero; D]; n],
            total: vec![[zero; D]; n],
            change: vec![[zero; D]; n],
            lambda: vec![zero; n],
            right: vec![zero; stages],
            matrix: vec![zero; stages * stages],
        }
    }
}

impl<K, F, N> OnSurface<K, F, N> {
    /// One step of the collocation method with this table.
    pub(super) fn collocate<T, W, const D: usize>(
        &self,
        table: &Table,
        h: f64,
        bodies: &mut BodiesOf<N, T, F, D>,
        witness: &mut W,
    ) -> Result<(), Failure>
    where
        T: Real,
        K: ConstraintKernel<T, D, 1>,
        F: Field<T, D>,
        N: Count,
        W: Witness<T>,
    {
        let (n, s) = (self.count.number(), table.stages());
        let mut stages = match bodies.kept.stages.take() {
            Some(stages) if stages.q.len() == s * n => stages,
            _ => Box::new(Stages::new(s, n)),
        };
        self.guess(bodies, &mut stages, s);
        let mut solved = self.solve(table, h, bodies, &mut stages);
        if solved.is_err() && self.guess_by_steps(table, h, bodies, &mut stages).is_ok() {
            solved = self.solve(table, h, bodies, &mut stages);
        }
        if solved.is_ok() {
            self.arrive(table, h, bodies, &stages, witness);
        }
        bodies.kept.stages = Some(stages);
        solved?;
        for (body, p) in bodies.p.as_ref().iter().enumerate() {
            let finite = dot(p, p).le(T::from_f64(f64::MAX));
            if !finite.all() {
                let (q, kept) = (bodies.q.as_ref(), &bodies.kept);
                return Err(Failure::at(body, finite).not_finite(&self.field, q, kept.normal.as_ref()));
            }
        }
        Ok(())
    }

    /// Constant acceleration.
    fn guess<T, const D: usize>(
        &self,
        bodies: &BodiesOf<N, T, F, D>,
        stages: &mut Stages<T, F::Force, D>,
        s: usize,
    ) where
        T: Real,
        K: ConstraintKernel<T, D, 1>,
        F: Field<T, D>,
        N: Count,
    {
        let n = self.count.number();
        for body in 0..n {
            let (q, p) = (&bodies.q.as_ref()[body], &bodies.p.as_ref()[body]);
            let (normal, force) = (&bodies.kept.normal.as_ref()[body], bodies.kept.force.as_ref()[body]);
            let [bend] = self.constraint.jet(q, p).2;
            let along = force.dot(&normal.gradient, T::from_f64(1.0));
            let lambda = multiplier_from_curvature(bend, along, normal);
            let pull = normal.gradient.map(|n| lambda * n);
            for stage in 0..s {
                let at = stage * n + body;
                stages.lambda[at] = lambda;
                stages.total[at] = force.add_to(pull, T::from_f64(1.0));
            }
            stages.normal[body] = normal.gradient;
            stages.force[body] = force;
        }
    }

    /// Steps of RATTLE from node to node.
    #[cold]
    #[inline(never)]
    fn guess_by_steps<T, const D: usize>(
        &self,
        table: &Table,
        h: f64,
        bodies: &BodiesOf<N, T, F, D>,
        stages: &mut Stages<T, F::Force, D>,
    ) -> Result<(), Failure>
    where
        T: Real,
        K: ConstraintKernel<T, D, 1>,
        F: Field<T, D>,
        N: Count,
    {
        let n = self.count.number();
        self.guess(bodies, stages, 1);
        let mut ahead: Bodies<N, T, Kept<N, T, F::Force, D>, D> = bodies.clone();
        for stage in 1..table.stages() {
            let part = h * (table.nodes[stage] - table.nodes[stage - 1]);
            self.drift(0.5 * part, part, &mut ahead, &mut ())?;
            self.evaluate_forces(&mut ahead);
            self.settle(0.5 * part, &mut ahead, &mut ())?;
            for body in 0..n {
                let (q, p) = (&ahead.q.as_ref()[body], &ahead.p.as_ref()[body]);
                let (normal, force) = (&ahead.kept.normal.as_ref()[body], ahead.kept.force.as_ref()[body]);
                let [bend] = self.constraint.jet(q, p).2;
                let along = force.dot(&normal.gradient, T::from_f64(1.0));
                let lambda = multiplier_from_curvature(bend, along, normal);
                let at = stage * n + body;
                stages.lambda[at] = lambda;
                stages.total[at] = force.add_to(normal.gradient.map(|n| lambda * n), T::from_f64(1.0));
            }
        }
        Ok(())
    }

    /// Qᵢ − q of one body: drift and the sum over the stages.
    #[inline(always)]
    fn increment<T: Real, X, const D: usize>(
        table: &Table,
        h: f64,
        velocity: &[T; D],
        stages: &Stages<T, X, D>,
        stage: usize,
        body: usize,
        n: usize,
    ) -> [T; D] {
        let mut acceleration = [T::from_f64(0.0); D];
        for (j, a) in table.positions[stage - 1].iter().enumerate() {
            acceleration = add_scaled(&acceleration, T::from_f64(*a), &stages.total[j * n + body]);
        }
        let (drift, push) = (T::from_f64(h * table.nodes[stage]), T::from_f64(h * h));
        from_fn(|d| drift * velocity[d] + push * acceleration[d])
    }

    /// Iterates until the stages hold to rounding.
    fn solve<T, const D: usize>(
        &self,
        table: &Table,
        h: f64,
        bodies: &BodiesOf<N, T, F, D>,
        stages: &mut Stages<T, F::Force, D>,
    ) -> Result<(), Failure>
    where
        T: Real,
        K: ConstraintKernel<T, D, 1>,
        F: Field<T, D>,
        N: Count,
    {
        let (n, s) = (self.count.number(), table.stages());
        let push = T::from_f64(h * h);
        let zero = T::from_f64(0.0);
        let mut last = f64::INFINITY;
        for iteration in 0..MAX_ITERATIONS {
            for stage in 1..s {
                for body in 0..n {
                    let (q, q_low) = (&bodies.q.as_ref()[body], &bodies.q_low.as_ref()[body]);
                    let v = sum(&bodies.p.as_ref()[body], &bodies.p_low.as_ref()[body]);
                    let increment = Self::increment(table, h, &v, stages, stage, body, n);
                    stages.q[stage * n + body] = sum(q, &sum(q_low, &increment));
                }
                self.field.evaluate(&stages.q[stage * n..][..n], &mut stages.force[stage * n..][..n]);
            }
            let (mut worst, mut at_floor) = (0.0_f64, true);
            for body in 0..n {
                let floor = largest(&bodies.q.as_ref()[body]) * T::from_f64(f64::EPSILON);
                let mut moved = zero;
                for stage in 1..s {
                    let at = stage * n + body;
                    let ([g], [gradient]) = self.constraint.value_and_jacobian(&stages.q[at]);
                    stages.normal[at] = gradient;
                    stages.right[stage - 1] = -g;
                    let pull = gradient.map(|n| stages.lambda[at] * n);
                    let total = stages.force[at].add_to(pull, T::from_f64(1.0));
                    stages.change[at] = add_scaled(&total, T::from_f64(-1.0), &stages.total[at]);
                    stages.total[at] = total;
                }
                stages.change[body] = [zero; D];
                let m = s - 1;
                for i in 0..m {
                    let normal = stages.normal[(i + 1) * n + body];
                    let mut shift = [zero; D];
                    for (j, a) in table.positions[i].iter().enumerate() {
                        let factor = push * T::from_f64(*a);
                        shift = add_scaled(&shift, factor, &stages.change[j * n + body]);
                        stages.matrix[i * m + j] = factor * dot(&normal, &stages.normal[j * n + body]);
                    }
                    moved = moved.max(largest(&shift));
                    stages.right[i] = stages.right[i] - dot(&normal, &shift);
                }
                eliminate(&mut stages.matrix, &mut stages.right, m);
                for j in 0..m {
                    let at = j * n + body;
                    let change = stages.right[j];
                    let normal = stages.normal[at];
                    stages.lambda[at] = stages.lambda[at] + change;
                    stages.total[at] = add_scaled(&stages.total[at], change, &normal);
                    stages.change[at] = normal.map(|n| change * n);
                }
                for i in 0..m {
                    let mut shift = [zero; D];
                    for (j, a) in table.positions[i].iter().enumerate() {
                        shift = add_scaled(&shift, push * T::from_f64(*a), &stages.change[j * n + body]);
                    }
                    moved = moved.max(largest(&shift));
                }
                let ratio = moved / floor;
                for lane in ratio.lanes() {
                    worst = if lane > worst || lane.is_nan() { lane } else { worst };
                }
                at_floor &= moved.le(floor).all();
            }
            if !worst.is_finite() {
                return Err(Failure::at(0, false).unsolved(h, table.stages(), iteration, worst));
            }
            let contraction = worst / last;
            let small = iteration > 0 && contraction < 0.5 && contraction * worst <= 1.0 / 16.0;
            let stalled = iteration > 3 && contraction >= 0.5 && worst < 64.0;
            if at_floor || small || stalled {
                return self.check_normals(h, table, stages);
            }
            last = worst;
        }
        Err(Failure::at(0, false).unsolved(h, table.stages(), MAX_ITERATIONS, last))
    }

    /// Whether no normal is turned over between successive stages.
    fn check_normals<T, X, const D: usize>(
        &self,
        h: f64,
        table: &Table,
        stages: &Stages<T, X, D>,
    ) -> Result<(), Failure>
    where
        T: Real,
        N: Count,
    {
        let n = self.count.number();
        for stage in 1..table.stages() {
            for body in 0..n {
                let upright = T::from_f64(0.0)
                    .lt(dot(&stages.normal[stage * n + body], &stages.normal[(stage - 1) * n + body]));
                if !upright.all() {
                    return Err(Failure::at(body, upright).turned_over(h, table.stages()));
                }
            }
        }
        Ok(())
    }

    /// Takes the bodies to the end of the step.
    fn arrive<T, W, const D: usize>(
        &self,
        table: &Table,
        h: f64,
        bodies: &mut BodiesOf<N, T, F, D>,
        stages: &Stages<T, F::Force, D>,
        witness: &mut W,
    ) where
        T: Real,
        K: ConstraintKernel<T, D, 1>,
        F: Field<T, D>,
        N: Count,
        W: Witness<T>,
    {
        let (n, s) = (self.count.number(), table.stages());
        let last_weight = T::from_f64(h * table.weights[s - 1]);
        for body in 0..n {
            let (q, q_low) = (&mut bodies.q.as_mut()[body], &mut bodies.q_low.as_mut()[body]);
            let v = sum(&bodies.p.as_ref()[body], &bodies.p_low.as_ref()[body]);
            let increment = Self::increment(table, h, &v, stages, s - 1, body, n);
            (*q, *q_low) = two_sum(q, &sum(q_low, &increment));
            let [gradient] = self.constraint.jacobian(q);
            bodies.kept.normal.as_mut()[body] = Normal::new(gradient);
            witness.position_multiplier(body, stages.lambda[body]);
        }
        self.field.evaluate(bodies.q.as_ref(), bodies.kept.force.as_mut());
        for body in 0..n {
            let (p, p_low) = (&mut bodies.p.as_mut()[body], &mut bodies.p_low.as_mut()[body]);
            let mut impulse = [T::from_f64(0.0); D];
            for (j, b) in table.weights[..s - 1].iter().enumerate() {
                impulse = add_scaled(&impulse, T::from_f64(h * b), &stages.total[j * n + body]);
            }
            let change = bodies.kept.force.as_ref()[body].add_to(sum(p_low, &impulse), last_weight);
            let (eta, normal_part) = bodies.kept.normal.as_ref()[body].projection(&sum(p, &change));
            witness.momentum_multiplier(body, eta / last_weight);
            (*p, *p_low) = two_sum(p, &sum(&change, &normal_part));
        }
    }
}

/// Solves the m × m system by elimination without exchanges, the solution in place of the right sides. Leading minors of
/// the tables are positive, and normals of successive stages do not turn over.
#[inline(always)]
fn eliminate<T: Real>(matrix: &mut [T], right: &mut [T], m: usize) {
    for k in 0..m {
        let inverse = T::from_f64(1.0) / matrix[k * m + k];
        for i in k + 1..m {
            let factor = matrix[i * m + k] * inverse;
            for j in k + 1..m {
                matrix[i * m + j] = matrix[i * m + j] - factor * matrix[k * m + j];
            }
            right[i] = right[i] - factor * right[k];
        }
        matrix[k * m + k] = inverse;
    }
    for i in (0..m).rev() {
        let mut rest = right[i];
        for j in i + 1..m {
            rest = rest - matrix[i * m + j] * right[j];
        }
        right[i] = rest * matrix[i * m + i];
    }
}
