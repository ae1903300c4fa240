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
//! once the next would be below 1/256 of the rounding of the positions (with 1/16 energy drifts by 1e-16 a step, with 1/256 by 1e-18). **Which root.** Normals of successive stages must
//! not be turned over.

use super::{BodiesOf, Normal, OnSurface, pull};
use crate::bodies::Count;
use crate::effect::{Field, Force};
use crate::kernel::ConstraintKernel;
use crate::lobatto::Table;
use crate::real::{Mask, Real};
use crate::stepper::{Failure, Witness};
use crate::system::System;
use crate::vector::{add_scaled, dot, largest, sum, two_sum};
use std::array::from_fn;

/// Iterations after which a step is given up; six to ten suffice where there is a solution.
const MAX_ITERATIONS: usize = 60;

/// Room for the stages of all bodies: positions and forces stage by stage, the rest body by body.
#[derive(Debug, Clone, Default)]
pub(crate) struct Stages<T, F, const D: usize> {
    q: Vec<[T; D]>,
    force: Vec<F>,
    normal: Vec<[T; D]>,
    /// f + ∇g λ.
    total: Vec<[T; D]>,
    lambda: Vec<T>,
    /// Qᵢ − q.
    increment: Vec<[T; D]>,
    /// The factored matrix, S × S.
    factor: Vec<T>,
}

impl<T: Real, F: Force<T, D>, const D: usize> Stages<T, F, D> {
    pub(super) fn new(stages: usize, bodies: usize) -> Self {
        let (n, zero) = (stages * bodies, T::from_f64(0.0));
        Self {
            q: vec![[zero; D]; n],
            force: vec![F::zero(); n],
            normal: vec![[zero; D]; n],
            total: vec![[zero; D]; n],
            lambda: vec![zero; n],
            increment: vec![[zero; D]; n],
            factor: vec![zero; stages * n],
        }
    }
}

impl<K, F, N: Count> OnSurface<K, F, N> {
    /// One step of the collocation method with this table.
    #[inline(always)]
    pub(super) fn collocate<T, W, const D: usize, const S: usize>(
        &self,
        table: &Table<S>,
        h: f64,
        bodies: &mut BodiesOf<N, T, F, D>,
        witness: &mut W,
    ) -> Result<(), Failure>
    where
        T: Real,
        K: ConstraintKernel<T, D, 1>,
        F: Field<T, D>,
        W: Witness<T>,
    {
        let n = self.count.number();
        let mut stages = match bodies.kept.stages.take() {
            Some(stages) if stages.q.len() == S * n => stages,
            _ => Box::new(Stages::new(S, n)),
        };
        for body in 0..n {
            let (lambda, total) = pull(&self.constraint, bodies, body);
            stages.lambda[body * S..][..S].fill(lambda);
            stages.total[body * S..][..S].fill(total);
            stages.normal[body * S] = bodies.kept.normal.as_ref()[body].gradient;
        }
        let mut solved = self.solve(table, h, bodies, &mut stages);
        if solved.is_err() && self.guess_by_steps(table, h, bodies, &mut stages).is_ok() {
            solved = self.solve(table, h, bodies, &mut stages);
        }
        if solved.is_ok() {
            self.arrive(table, h, bodies, &stages, witness);
        }
        bodies.kept.stages = Some(stages);
        solved?;
        self.evaluate_forces(bodies);
        let last = h * table.weights[S - 1];
        self.settle(last, 2.0 * last, bodies, witness)
    }

    /// Steps of RATTLE from node to node.
    #[cold]
    #[inline(never)]
    fn guess_by_steps<T, const D: usize, const S: usize>(
        &self,
        table: &Table<S>,
        h: f64,
        bodies: &BodiesOf<N, T, F, D>,
        stages: &mut Stages<T, F::Force, D>,
    ) -> Result<(), Failure>
    where
        T: Real,
        K: ConstraintKernel<T, D, 1>,
        F: Field<T, D>,
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
                (stages.lambda[at], stages.total[at]) = pull(&self.constraint, &ahead, body);
            }
        }
        Ok(())
    }

    /// Iterates until the stages hold to rounding.
    #[inline(always)]
    fn solve<T, const D: usize, const S: usize>(
        &self,
        table: &Table<S>,
        h: f64,
        bodies: &BodiesOf<N, T, F, D>,
        stages: &mut Stages<T, F::Force, D>,
    ) -> Result<(), Failure>
    where
        T: Real,
        K: ConstraintKernel<T, D, 1>,
        F: Field<T, D>,
    {
        let n = self.count.number();
        let zero = T::from_f64(0.0);
        let positions: [[T; S]; S] = table.positions.map(|row| row.map(|a| T::from_f64(h * h * a)));
        let drift: [T; S] = table.nodes.map(|c| T::from_f64(h * c));
        for body in 0..n {
            let v = sum(&bodies.p.as_ref()[body], &bodies.p_low.as_ref()[body]);
            let total: &[[T; D]; S] = part(&stages.total, body);
            for stage in 1..S {
                stages.increment[body * S + stage] = increment(&positions[stage], drift[stage], &v, total);
            }
        }
        let (mut last, mut last_contraction) = (f64::INFINITY, 0.0);
        for iteration in 0..MAX_ITERATIONS {
            for body in 0..n {
                let (q, q_low) = (&bodies.q.as_ref()[body], &bodies.q_low.as_ref()[body]);
                for stage in 1..S {
                    stages.q[stage * n + body] = sum(q, &sum(q_low, &stages.increment[body * S + stage]));
                }
            }
            // Normals hardly move any more after two iterations: their matrix is kept, unless that contracts badly.
            let renew = iteration < 2 || last_contraction > 0.1;
            for stage in 1..S {
                self.field.evaluate(&stages.q[stage * n..][..n], &mut stages.force[stage * n..][..n]);
            }
            let (mut worst, mut slowest, mut upright) = (0.0_f64, 0, None);
            for body in 0..n {
                let normal: &mut [[T; D]; S] = part_mut(&mut stages.normal, body);
                let total: &mut [[T; D]; S] = part_mut(&mut stages.total, body);
                let lambda: &mut [T; S] = part_mut(&mut stages.lambda, body);
                let increment: &mut [[T; D]; S] = part_mut(&mut stages.increment, body);
                let factor = &mut stages.factor[body * S * S..][..S * S];
                let mut change = [[zero; D]; S];
                let mut right = [zero; S];
                for stage in 1..S {
                    let at = stage * n + body;
                    let ([g], [gradient]) = self.constraint.value_and_jacobian(&stages.q[at]);
                    normal[stage] = gradient;
                    right[stage] = -g;
                    let sum = stages.force[at].add_to(gradient.map(|n| lambda[stage] * n), T::from_f64(1.0));
                    change[stage] = add_scaled(&sum, T::from_f64(-1.0), &total[stage]);
                    total[stage] = sum;
                    if !zero.lt(dot(&gradient, &normal[stage - 1])).all() {
                        upright = Some(body);
                    }
                }
                let mut shift = [[zero; D]; S];
                for i in 1..S {
                    for j in 0..S - 1 {
                        shift[i] = add_scaled(&shift[i], positions[i][j], &change[j]);
                    }
                    right[i] = right[i] - dot(&normal[i], &shift[i]);
                }
                if renew {
                    for i in 1..S {
                        for j in 0..S - 1 {
                            factor[i * S + j] = positions[i][j] * dot(&normal[i], &normal[j]);
                        }
                    }
                    eliminate::<T, S>(factor);
                }
                let correction = substitute::<T, S>(factor, right);
                for j in 0..S - 1 {
                    lambda[j] = lambda[j] + correction[j];
                    let push = normal[j].map(|n| correction[j] * n);
                    total[j] = sum(&total[j], &push);
                    for i in 1..S {
                        shift[i] = add_scaled(&shift[i], positions[i][j], &push);
                    }
                }
                for i in 1..S {
                    increment[i] = sum(&increment[i], &shift[i]);
                }
                let moved = shift[1..].iter().map(largest).fold(zero, select_larger);
                let far = increment[1..].iter().map(largest).fold(zero, select_larger);
                let size = largest(&bodies.q.as_ref()[body]).max(far);
                let ratio = moved / (size * T::from_f64(f64::EPSILON));
                for lane in T::select(moved.le(zero), zero, ratio).lanes() {
                    if lane > worst || lane.is_nan() {
                        (worst, slowest) = (lane, body);
                    }
                }
            }
            if !worst.is_finite() {
                return Err(self.not_finite(h, stages, slowest, S, iteration));
            }
            let contraction = worst / last;
            let rate = contraction.max(last_contraction); // a lucky iteration is not the rate
            let small = iteration > 1 && rate < 0.5 && rate * worst <= 1.0 / 256.0;
            let stalled = iteration > 3 && contraction >= 0.5 && worst < 64.0;
            if worst <= 1.0 || small || stalled {
                return upright.map_or(Ok(()), |body| Err(Failure::at(body, false).turned_over(h, S)));
            }
            if iteration + 1 == MAX_ITERATIONS {
                return Err(Failure::at(slowest, false).unsolved(h, S, MAX_ITERATIONS, worst));
            }
            (last, last_contraction) = (worst, contraction);
        }
        Ok(()) // not reached: the last iteration returns
    }

    /// A force or the constraint is not a number at a stage, or the stages ran away.
    #[cold]
    #[inline(never)]
    fn not_finite<T, const D: usize>(
        &self,
        h: f64,
        stages: &Stages<T, F::Force, D>,
        body: usize,
        count: usize,
        iterations: usize,
    ) -> Failure
    where
        T: Real,
        K: ConstraintKernel<T, D, 1>,
        F: Field<T, D>,
    {
        let n = self.count.number();
        for stage in 1..count {
            let q = &stages.q[stage * n..][..n];
            let reached = q[body].iter().all(|q| q.lanes().all(f64::is_finite));
            if reached && self.field.culprit(q, body).is_some() {
                let normal = self.count.each(Normal::new(stages.normal[body * count]));
                return Failure::at(body, false).not_finite(&self.field, q, normal.as_ref());
            }
        }
        Failure::at(body, false).unsolved(h, count, iterations, f64::NAN)
    }

    /// Takes the bodies to the end of the step, their momenta without the last kick.
    #[inline(always)]
    fn arrive<T, W, const D: usize, const S: usize>(
        &self,
        table: &Table<S>,
        h: f64,
        bodies: &mut BodiesOf<N, T, F, D>,
        stages: &Stages<T, F::Force, D>,
        witness: &mut W,
    ) where
        T: Real,
        K: ConstraintKernel<T, D, 1>,
        F: Field<T, D>,
        W: Witness<T>,
    {
        let n = self.count.number();
        let row = table.positions[S - 1].map(|a| T::from_f64(h * h * a));
        for body in 0..n {
            let (q, q_low) = (&mut bodies.q.as_mut()[body], &mut bodies.q_low.as_mut()[body]);
            let v = sum(&bodies.p.as_ref()[body], &bodies.p_low.as_ref()[body]);
            let increment = increment(&row, T::from_f64(h), &v, part(&stages.total, body));
            (*q, *q_low) = two_sum(q, &sum(q_low, &increment));
            let [gradient] = self.constraint.jacobian(q);
            bodies.kept.normal.as_mut()[body] = Normal::new(gradient);
            witness.position_multiplier(body, stages.lambda[body * S]);
        }
        for body in 0..n {
            let (p, p_low) = (&mut bodies.p.as_mut()[body], &mut bodies.p_low.as_mut()[body]);
            let total: &[[T; D]; S] = part(&stages.total, body);
            let mut impulse = [T::from_f64(0.0); D];
            for j in 0..S - 1 {
                impulse = add_scaled(&impulse, T::from_f64(h * table.weights[j]), &total[j]);
            }
            (*p, *p_low) = two_sum(p, &sum(p_low, &impulse));
        }
    }
}

/// The larger one, NaN if one is.
#[inline(always)]
fn select_larger<T: Real>(a: T, b: T) -> T {
    T::select(b.le(a), a, b)
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

/// Qᵢ − q of one body: drift and the sum over the stages.
#[inline(always)]
fn increment<T: Real, const D: usize, const S: usize>(
    row: &[T; S],
    drift: T,
    velocity: &[T; D],
    total: &[[T; D]; S],
) -> [T; D] {
    let mut push = [T::from_f64(0.0); D];
    for j in 0..S - 1 {
        push = add_scaled(&push, row[j], &total[j]);
    }
    from_fn(|d| drift * velocity[d] + push[d])
}

/// Factors rows 1 … S − 1 and columns 0 … S − 2 in place, pivots inverted, without exchanges: leading minors of the tables
/// are positive, and normals of successive stages do not turn over.
#[inline(always)]
fn eliminate<T: Real, const S: usize>(a: &mut [T]) {
    for k in 0..S - 1 {
        let inverse = T::from_f64(1.0) / a[(k + 1) * S + k];
        a[(k + 1) * S + k] = inverse;
        for i in k + 1..S - 1 {
            let factor = a[(i + 1) * S + k] * inverse;
            a[(i + 1) * S + k] = factor;
            for j in k + 1..S - 1 {
                a[(i + 1) * S + j] = a[(i + 1) * S + j] - factor * a[(k + 1) * S + j];
            }
        }
    }
}

/// Solves with the factors of [`eliminate`], for x₀ … x_{S−2} from right sides 1 … S − 1.
#[inline(always)]
fn substitute<T: Real, const S: usize>(a: &[T], mut right: [T; S]) -> [T; S] {
    let mut x = [T::from_f64(0.0); S];
    for k in 0..S - 1 {
        for i in k + 1..S - 1 {
            right[i + 1] = right[i + 1] - a[(i + 1) * S + k] * right[k + 1];
        }
    }
    for i in (0..S - 1).rev() {
        let mut rest = right[i + 1];
        for j in i + 1..S - 1 {
            rest = rest - a[(i + 1) * S + j] * x[j];
        }
        x[i] = rest * a[(i + 1) * S + i];
    }
    x
}
