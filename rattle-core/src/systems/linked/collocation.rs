//! Collocation of linked bodies: the stages of [`lobatto`](crate::methods::lobatto) solved together.
//!
//! An iteration evaluates g, its gradients and the forces once at every stage and forms the new sums. The linearised
//! constraints are solved with the normals of the start instead of those of the stages, so that one factorisation, that
//! of the end of the last step, serves all stages:
//!
//! ```text
//! δλⱼ = −Σᵢ (h² a)⁻¹ⱼᵢ (G₀M⁻¹G₀ᵀ)⁻¹ rᵢ
//! ```
//!
//! This contracts by about the angle that normals turn within the step, relative to a right angle, times √(M/m) where
//! links join a body of mass m to bodies of mass M, and divided by the sine of a normal to the others: fast for
//! accurate steps of bodies that are about as heavy, and not at all for a light body with many heavy arms.
//!
//! What rounding makes of a displacement is larger by 1 over that sine. Where displacements do not become smaller above
//! the rounding of coordinates, they are measured by that.

use crate::effect::force::Force;
use crate::effect::list::Forces;
use crate::effect::moment::Moment;
use crate::error::{LinkedFailure, MethodFailure};
use crate::kernel::rounding::SHIFTS;
use crate::motion::bodies::Count;
use crate::motion::capability::{Collocation, Rates};
use crate::motion::failure::Failure;
use crate::motion::system::System;
use crate::motion::table::Table;
use crate::motion::witness::Witness;
use crate::number::vector::{add_scaled, dot, largest, scaled, sum, two_sum};
use crate::solve::aim::noise_of_terms;
use crate::solve::stop::{LAST_OF_STAGES, NOISE, OFF_AT_END, Stalling};
use crate::systems::linked::kept::{BodiesOf, Furthest, Kept, Linked, Tied, along};
use crate::systems::linked::room::Stages;
use crate::systems::network::rows::Rows;
use crate::systems::network::solver::CLEARLY;

/// Iterations after which a step is given up …
const MAX_ITERATIONS: usize = 100;

/// … and after which it is begun again with the acceleration at its start.
const PATIENCE: usize = 20;

/// Where displacements still do not become smaller after so many, they may be rounding, see
/// [`allow_for_angles`](Linked::allow_for_angles); before, they may do so on the way to the stages.
const SETTLED: usize = 12;

/// Iterations after which displacements that hardly shrink will not become small: by then it is asked whether they
/// stay.
const LOST: usize = 3 * Stalling::MOVES - 1;

impl<F: Forces<f64, D>, N: Count, const D: usize> Collocation<N, Kept<F, D>, f64, D> for Linked<F, N, D> {
    fn reserve(&self, bodies: &mut BodiesOf<F, N, D>, stages: usize) {
        let room = || Box::new(Stages::new(stages, self.count.number(), &self.shape, &self.effects));
        bodies.kept.stages = (stages > 0).then(room);
    }

    fn collocate<W: Witness<f64>, const S: usize>(
        &self,
        table: &Table<S>,
        h: f64,
        bodies: &mut BodiesOf<F, N, D>,
        memory: &mut [f64],
        witness: &mut W,
    ) -> Result<(), Failure> {
        let shape = &*self.shape;
        bodies.kept.tied.leave_rows(shape, bodies.time, bodies.q.as_ref());
        let (n, m) = (self.count.number(), shape.equations);
        let mut stages = match bodies.kept.stages.take() {
            Some(stages) if stages.q.len() == S * n => stages,
            _ => Box::new(Stages::new(S, n, shape, &self.effects)),
        };
        self.guess::<S>(bodies, &mut stages);
        let past = memory.split_first().filter(|(filled, _)| **filled == 1.0);
        let near = past.is_some_and(|(_, past)| {
            stages.extrapolate(table, past, n, m);
            self.iterate(table, h, bodies, &mut stages, PATIENCE).is_ok()
        });
        let mut solved = Ok(());
        if !near {
            self.guess::<S>(bodies, &mut stages);
            solved = self.iterate(table, h, bodies, &mut stages, MAX_ITERATIONS);
        }
        if let (true, Some((filled, past))) = (solved.is_ok(), memory.split_first_mut()) {
            *filled = 1.0;
            let (total, lambda) = past.split_at_mut(S * n * D);
            total.copy_from_slice(stages.total.as_flattened());
            lambda.copy_from_slice(&stages.lambda);
        }
        if solved.is_ok() {
            self.arrive(table, h, bodies, &stages, witness);
        }
        bodies.kept.stages = Some(stages);
        solved?;
        for c in 0..shape.components.len() {
            let (q, time) = (bodies.q.as_ref(), bodies.time);
            let found = bodies.kept.tied.normals(shape, c, time, q);
            self.check_residuals(c, h, bodies)?;
            bodies.kept.tied.check_rank(shape, c, bodies.q.as_ref(), found)?;
        }
        self.evaluate_forces(bodies);
        let last = h * table.weights[S - 1];
        self.settle(last, 2.0 * last, bodies, witness)
    }
}

impl<F: Forces<f64, D>, N: Count, const D: usize> Linked<F, N, D> {
    /// Whether the equations hold at the end of the step, whose gradients were just evaluated: what dependent equations
    /// ask for beyond what the normals of the start can give moves nothing, and is not seen by the iteration.
    fn check_residuals(&self, c: usize, h: f64, bodies: &mut BodiesOf<F, N, D>) -> Result<(), Failure> {
        let rows = &self.shape.components[c].rows;
        let Furthest { distance, of_all: roundings, row, .. } = self.furthest(c, h, bodies);
        if roundings <= OFF_AT_END * (rows.equations() as f64).sqrt() {
            return Ok(());
        }
        if self.is_rounding(c, row, distance, bodies) {
            return Ok(());
        }
        let equation = self.shape.equation_at(c, row);
        let body = equation.bodies[0];
        let cause = if bodies.kept.tied.solvers[c].rank(rows) < rows.equations() {
            LinkedFailure::Contradictory { equation, residuals: [distance].into_iter().collect() }
        } else {
            LinkedFailure::LeftOff { equation, distance, roundings, h }
        };
        Err(Failure { body, cause: cause.into() })
    }

    /// Whether an equation that is so far off, by gradients as just evaluated, is so by the rounding of its own terms,
    /// which may be larger than the coordinates.
    #[cold]
    #[inline(never)]
    pub(super) fn is_rounding(
        &self,
        c: usize,
        row: usize,
        distance: f64,
        bodies: &mut BodiesOf<F, N, D>,
    ) -> bool {
        let (shape, time, q) = (&*self.shape, bodies.time, bodies.q.as_ref());
        let component = &shape.components[c];
        let Tied { room, blocks, .. } = &mut bodies.kept.tied;
        let normals = || {
            let of = component.rows.touched_by(row);
            of.map(|(block, body)| (body, blocks[component.first.1 + block]))
        };
        let length = normals().map(|(_, n)| dot(&n, &n)).sum::<f64>().sqrt();
        let size = normals().fold(0.0, |most: f64, (body, _)| most.max(largest(&q[body])));
        shape.values(c, time, q, &mut room.g);
        let value = room.g[row];
        room.trial.copy_from_slice(q);
        let mut bent = |shift: f64| {
            normals().for_each(|(body, n)| room.trial[body] = add_scaled(&q[body], shift / length, &n));
            shape.values(c, time, &room.trial, &mut room.g);
            ((room.g[row] - value) / length - shift).abs()
        };
        let rounding =
            |size: f64| SHIFTS.into_iter().map(|share| bent(share * f64::EPSILON * size)).fold(0.0, f64::max);
        let noise = noise_of_terms::<f64>(size, rounding);
        shape.values(c, time, q, &mut room.g);
        distance <= noise
    }

    /// Whether displacements by so many roundings of these sizes, which stay, are those of the terms of an equation.
    #[cold]
    #[inline(never)]
    fn are_rounding(&self, roundings: f64, sizes: &[f64], bodies: &mut BodiesOf<F, N, D>) -> bool {
        let size = sizes.iter().fold(0.0, |most: f64, &size| most.max(size));
        let moved = roundings * f64::EPSILON * size;
        self.shape.components.iter().enumerate().any(|(c, component)| {
            (0..component.rows.equations()).any(|row| self.is_rounding(c, row, moved, bodies))
        })
    }

    /// Constant acceleration, that with g̈ = 0 at the start.
    fn guess<const S: usize>(&self, bodies: &mut BodiesOf<F, N, D>, stages: &mut Stages<F, D>) {
        let (shape, n, m) = (&*self.shape, self.count.number(), self.shape.equations);
        self.evaluate_rates(bodies, &mut stages.total[..n], &mut ());
        let kept = &mut bodies.kept.tied;
        for (c, component) in shape.components.iter().enumerate() {
            let row = component.first.0;
            let rows = row..row + component.rows.equations();
            kept.solvers[c].multipliers(&kept.room.x[rows.clone()], &mut stages.lambda[rows]);
        }
        for stage in 1..S {
            stages.total.copy_within(..n, stage * n);
            stages.lambda.copy_within(..m, stage * m);
        }
        stages.blocks[..shape.blocks].copy_from_slice(&kept.blocks);
        stages.rates[..m].copy_from_slice(&kept.rates);
        stages.force[..n].copy_from_slice(&kept.force);
    }

    /// Qᵢ − q of a body, drift and the sum over the stages, and what rounding took from it.
    fn increment<const S: usize>(
        &self,
        table: &Table<S>,
        h: f64,
        bodies: &BodiesOf<F, N, D>,
        stages: &Stages<F, D>,
        stage: usize,
        body: usize,
    ) -> ([f64; D], [f64; D]) {
        let n = self.count.number();
        let p = sum(&bodies.p.as_ref()[body], &bodies.p_low.as_ref()[body]);
        let (drift, rest) = table.drift(h, stage);
        let (mut impulse, mut low) = ([0.0; D], p.map(|p| rest * p));
        for j in 0..S - 1 {
            let ((factor, rest), total) = (table.push(h, stage, j), &stages.total[j * n + body]);
            impulse = add_scaled(&impulse, factor, total);
            low = add_scaled(&low, rest, total);
        }
        let (increment, rest) = two_sum(&scaled(drift, &p), &impulse);
        let rest = sum(&rest, &low);
        let root = &self.shape.roots[body];
        (root.velocity(&increment), root.velocity(&rest))
    }

    /// Iterates until the stages hold to rounding.
    fn iterate<const S: usize>(
        &self,
        table: &Table<S>,
        h: f64,
        bodies: &mut BodiesOf<F, N, D>,
        stages: &mut Stages<F, D>,
        patience: usize,
    ) -> Result<(), Failure> {
        let (shape, n, m) = (&*self.shape, self.count.number(), self.shape.equations);
        let long = (m as f64).sqrt().max(1.0); // roundings of a chain add up along it
        let start = &bodies.kept.tied.blocks;
        for (component, size) in shape.components.iter().zip(&mut stages.sizes) {
            *size = size_along_normals(&component.rows, &start[component.first.1..], bodies.q.as_ref());
        }
        let (mut last, mut allowed, mut stalling) = (f64::INFINITY, false, Stalling::START);
        for iteration in 0..patience {
            for stage in 1..S {
                for body in 0..n {
                    let (increment, rest) = self.increment(table, h, bodies, stages, stage, body);
                    let (q, q_low) = (&bodies.q.as_ref()[body], &bodies.q_low.as_ref()[body]);
                    stages.q[stage * n + body] = sum(q, &sum(&increment, &sum(q_low, &rest)));
                }
                let q = &stages.q[stage * n..][..n];
                let force = &mut stages.force[stage * n..][..n];
                let at = Moment { time: bodies.time + h * table.nodes[stage], positions: q };
                self.forces(at, &mut stages.of_effects, force);
                let total = &mut stages.change[stage * n..][..n];
                total.iter_mut().zip(force).for_each(|(total, force)| *total = force.components());
                for (c, component) in shape.components.iter().enumerate() {
                    let (rows, (row, block)) = (&component.rows, component.first);
                    let (row, block) = (stage * m + row, stage * shape.blocks + block);
                    let blocks = &mut stages.blocks[block..block + rows.blocks()];
                    let g = &mut stages.right[row..row + rows.equations()];
                    let rates = &mut stages.rates[row..row + rows.equations()];
                    shape.gradients(c, bodies.time + h * table.nodes[stage], q, g, blocks, rates);
                    pull(rows, blocks, &stages.lambda[row..], total);
                }
                for (total, change) in stages.total[stage * n..][..n].iter_mut().zip(total) {
                    (*total, *change) = (*change, add_scaled(change, -1.0, total));
                }
            }
            stages.change[..n].fill([0.0; D]);

            // rᵢ = g(Qᵢ) + G(Qᵢ) h² Σⱼ aᵢⱼ M⁻¹(change of stage j), and what the start's normals answer.
            let mut worst = 0.0_f64;
            for stage in 1..S {
                self.shift(table, h, stages, stage);
                for (c, component) in shape.components.iter().enumerate() {
                    let (rows, (row, block)) = (&component.rows, component.first);
                    let blocks = &stages.blocks[stage * shape.blocks + block..][..rows.blocks()];
                    let right = &mut stages.right[stage * m + row..][..rows.equations()];
                    for (i, right) in right.iter_mut().enumerate() {
                        *right += along(rows, i, blocks, &stages.shift);
                    }
                    let x = &mut stages.x[..rows.equations()];
                    let start = &bodies.kept.tied.blocks[block..block + rows.blocks()];
                    bodies.kept.tied.solvers[c].respond(rows, start, &shape.roots, right, x);
                    bodies.kept.tied.solvers[c].multipliers(x, right);
                }
            }
            for j in 0..S - 1 {
                stages.multipliers.fill(0.0);
                for i in 1..S {
                    let factor = -table.inverse[j][i] / (h * h);
                    for (sum, answer) in stages.multipliers.iter_mut().zip(&stages.right[i * m..]) {
                        *sum += factor * answer;
                    }
                }
                let lambda = &mut stages.lambda[j * m..][..m];
                lambda.iter_mut().zip(&stages.multipliers).for_each(|(lambda, change)| *lambda += change);
                for component in &shape.components {
                    let (rows, (row, block)) = (&component.rows, component.first);
                    let blocks = &stages.blocks[j * shape.blocks + block..][..rows.blocks()];
                    pull(rows, blocks, &stages.multipliers[row..], &mut stages.total[j * n..][..n]);
                    pull(rows, blocks, &stages.multipliers[row..], &mut stages.change[j * n..][..n]);
                }
            }
            for stage in 1..S {
                self.shift(table, h, stages, stage);
                let q = &stages.q[stage * n..][..n];
                // Roundings of linked bodies reach each other, those of others do not.
                // The way with constraints, and what forces alone would add: the sum of both is rounded.
                let from = bodies.q.as_ref();
                let way = |&body: &usize| {
                    let pushed = shape.pushed(body, h, &stages.force[stage * n + body].components());
                    largest(&add_scaled(&q[body], -1.0, &from[body])).max(largest(&pushed))
                };
                for (component, size) in shape.components.iter().zip(&stages.sizes) {
                    let linked = &component.rows.bodies;
                    let size = linked.iter().map(way).fold(*size, f64::max);
                    for &body in linked {
                        worst = if largest(&q[body]) <= size {
                            slower(worst, largest(&stages.shift[body]), size)
                        } else {
                            slowest(worst, &stages.shift[body], &q[body], size)
                        };
                    }
                }
                for &body in &shape.loose {
                    worst = slower(worst, largest(&stages.shift[body]), largest(&q[body]).max(way(&body)));
                }
            }
            let contraction = worst / last;
            let stalled = iteration > 3 && contraction >= 0.9;
            let rests = worst.is_finite()
                && stalling.note(worst, iteration)
                && self.are_rounding(worst, &stages.sizes, bodies);
            if worst <= LAST_OF_STAGES || (stalled && worst < NOISE * long) || rests {
                return Ok(());
            }
            if stalled && iteration > SETTLED && !allowed && worst.is_finite() {
                (last, allowed) = (f64::INFINITY, true);
                if self.allow_for_angles(bodies, &mut stages.sizes) {
                    continue;
                }
            }
            if !worst.is_finite() || (iteration > LOST && contraction > 0.95) {
                for stage in 1..S {
                    let q = &stages.q[stage * n..][..n];
                    let reached = q.iter().flatten().all(|q| q.is_finite());
                    let at = Moment { time: bodies.time + h * table.nodes[stage], positions: q };
                    if let (true, Some(failure)) = (reached, Failure::of_force(&self.effects, at, 0..n)) {
                        return Err(failure);
                    }
                }
                let cause =
                    MethodFailure::StagesNotSolved { h, stages: S, iterations: iteration + 1, left: worst }
                        .into();
                return Err(Failure { body: 0, cause });
            }
            last = worst;
        }
        let cause = MethodFailure::StagesNotSolved { h, stages: S, iterations: patience, left: last }.into();
        Err(Failure { body: 0, cause })
    }

    /// Divides the size of what is rounded by the sine of the least independent normal, in components whose normals are
    /// not clearly independent at the start of the step. Returns whether there are any.
    #[cold]
    #[inline(never)]
    fn allow_for_angles(&self, bodies: &mut BodiesOf<F, N, D>, sizes: &mut [f64]) -> bool {
        let (tied, q, time) = (&mut bodies.kept.tied, bodies.q.as_ref(), bodies.time);
        let mut some = false;
        for (c, (component, size)) in self.shape.components.iter().zip(sizes).enumerate() {
            let (sine, _) = tied.normals(&self.shape, c, time, q);
            let independent = tied.solvers[c].rank(&component.rows) == component.rows.equations();
            if independent && 0.0 < sine && sine < CLEARLY {
                *size /= sine;
                some = true;
            }
        }
        some
    }

    /// h² Σⱼ aᵢⱼ M⁻¹(change of stage j) of every body.
    fn shift<const S: usize>(&self, table: &Table<S>, h: f64, stages: &mut Stages<F, D>, stage: usize) {
        let n = self.count.number();
        for (body, root) in self.shape.roots.iter().enumerate() {
            let mut shift = [0.0; D];
            for j in 0..S - 1 {
                let factor = h * h * table.positions[stage][j];
                shift = add_scaled(&shift, factor, &stages.change[j * n + body]);
            }
            stages.shift[body] = root.velocity(&shift);
        }
    }

    /// Takes the bodies to the end of the step, their momenta without the last kick.
    fn arrive<W: Witness<f64>, const S: usize>(
        &self,
        table: &Table<S>,
        h: f64,
        bodies: &mut BodiesOf<F, N, D>,
        stages: &Stages<F, D>,
        witness: &mut W,
    ) {
        let (shape, n, m) = (&*self.shape, self.count.number(), self.shape.equations);
        if self.effects.changes_with_time() {
            let mut power = table.weights[0] * bodies.power;
            for j in 1..S - 1 {
                let time = bodies.time + h * table.nodes[j];
                let at = Moment { time, positions: &stages.q[j * n..][..n] };
                power += table.weights[j] * self.effects.power(at);
            }
            bodies.work += h * power; // the last kick books its own
        }
        for body in 0..n {
            let (increment, rest) = self.increment(table, h, bodies, stages, S - 1, body);
            let (q, q_low) = (&mut bodies.q.as_mut()[body], &mut bodies.q_low.as_mut()[body]);
            let (high, low) = two_sum(q, &increment);
            (*q, *q_low) = two_sum(&high, &sum(&low, &sum(q_low, &rest)));
        }
        for body in 0..n {
            let (p, p_low) = (&mut bodies.p.as_mut()[body], &mut bodies.p_low.as_mut()[body]);
            let (mut impulse, mut low) = ([0.0; D], *p_low);
            for j in 0..S - 1 {
                let ((kick, rest), total) = (table.kick(h, j), &stages.total[j * n + body]);
                impulse = add_scaled(&impulse, kick, total);
                low = add_scaled(&low, rest, total);
            }
            let (change, lost) = two_sum(&impulse, &low);
            let (moved, rest) = two_sum(p, &change);
            (*p, *p_low) = (moved, sum(&rest, &lost));
        }
        for component in &shape.components {
            let (rows, row) = (&component.rows, component.first.0);
            for i in 0..rows.equations() {
                witness.position_multiplier(rows.equation(i), stages.lambda[row + i]);
                for j in 0..S - 1 {
                    let at = j * m + row + i;
                    bodies.work -= h * table.weights[j] * stages.lambda[at] * stages.rates[at];
                }
            }
        }
        bodies.time += h;
    }
}

/// How large the coordinates are whose rounding moves bodies along these normals: the largest of all equations.
fn size_along_normals<const D: usize>(rows: &Rows, blocks: &[[f64; D]], q: &[[f64; D]]) -> f64 {
    let size = |row| {
        let terms = rows.terms(row, blocks, q);
        terms.size(terms.length()) / terms.length()
    };
    (0..rows.equations()).map(size).fold(0.0, f64::max)
}

/// The larger one of `worst` and `moved` in roundings of `size`; NaN if one is.
fn slower(worst: f64, moved: f64, size: f64) -> f64 {
    let ratio = if moved == 0.0 { 0.0 } else { moved / (f64::EPSILON * size) };
    if ratio > worst || ratio.is_nan() { ratio } else { worst }
}

/// The same where coordinates are larger than what matters, and are rounded to more.
#[cold]
fn slowest<const D: usize>(worst: f64, moved: &[f64; D], q: &[f64; D], size: f64) -> f64 {
    let each = moved.iter().zip(q);
    each.fold(worst, |worst, (moved, q)| slower(worst, moved.abs(), size.max(q.abs())))
}

/// Adds Gᵀλ to the force on each body of a component.
fn pull<const D: usize>(rows: &Rows, blocks: &[[f64; D]], lambda: &[f64], force: &mut [[f64; D]]) {
    for row in 0..rows.equations() {
        for (block, body) in rows.blocks_of(row) {
            let body = rows.bodies[body];
            force[body] = add_scaled(&force[body], lambda[row], &blocks[block]);
        }
    }
}
