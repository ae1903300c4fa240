//! The motion of linked bodies as a power series in time.
//!
//! With aₖ the coefficient of tᵏ of a, n a row of G and r of ∂g/∂t, and λ from G v + r = 0, order by order:
//!
//! ```text
//! k M vₖ = u (fₖ₋₁ + Σⱼ λⱼ₋₁ nₖ₋ⱼ),   Σⱼ nⱼ·vₖ₋ⱼ + rₖ = 0,   qₖ₊₁ = u vₖ/(k + 1)
//! ```
//!
//! u is the unit of time, in which t is counted here.
//! nₖ and rₖ are known from q₀ … qₖ. The only unknown of the first sum is G₀ᵀλₖ₋₁, so the second one gives λₖ₋₁ by the
//! factors of G₀M⁻¹G₀ᵀ from the last step: one solve for each order.

use crate::effect::list::Forces;
use crate::kernel::recurrences::Recurrences;
use crate::kernel::series::{AnyOrder, Products, blocks, unit_near};
use crate::motion::bodies::Count;
use crate::motion::capability::Series;
use crate::motion::witness::Witness;
use crate::number::vector::{scaled, sum};
use crate::systems::linked::kept::{BodiesOf, Kept, Linked, Tied};
use crate::systems::linked::pull::Pull;
use crate::systems::linked::room::SeriesRoom;
use crate::systems::network::shape::Shape;
use std::array::from_fn;

impl<F: Forces<f64, D>, N: Count, const D: usize> Series<N, Kept<F, D>, f64, D> for Linked<F, N, D> {
    fn reserve_series(&self, bodies: &mut BodiesOf<F, N, D>, orders: usize, h: f64) {
        bodies.kept.series = Some(self.room_for_series(orders, h));
    }

    fn unit(&self, bodies: &BodiesOf<F, N, D>) -> f64 {
        bodies.kept.series.as_ref().map_or(1.0, |room| room.unit)
    }

    fn expand<W: Witness<f64>>(
        &self,
        bodies: &mut BodiesOf<F, N, D>,
        series: &mut [[f64; D]],
        witness: &mut W,
    ) {
        let (shape, n) = (&*self.shape, self.count.number());
        bodies.kept.tied.lend_normals(shape, bodies.time, bodies.q.as_ref());
        let Kept { series: expansion, tied, .. } = &mut bodies.kept;
        let Tied { solvers, blocks, rates, room, .. } = tied;
        let expansion = expansion.get_or_insert_with(|| self.room_for_series(series.len() / n, 1.0));
        let SeriesRoom {
            products,
            normals,
            acting,
            rates: moves,
            force,
            pull,
            push,
            velocity,
            lambda,
            work,
            unit,
        } = &mut **expansion;
        let unit = *unit;
        series[..n].copy_from_slice(bodies.q.as_ref());
        for (body, root) in shape.roots.iter().enumerate() {
            velocity[body] = root.velocity(&bodies.p.as_ref()[body]);
            series[n + body] = scaled(unit, &velocity[body]);
        }

        let order = &mut products.first();
        shape.series(bodies.time, &series[..n], normals, acting, moves, &mut AnyOrder::First(order));
        lambda.fill(0.0);
        note(shape, &mut order.take(self.own_blocks()), lambda, [normals, acting], moves, velocity);
        force.fill([0.0; D]);
        self.effects.contribute_series(&series[..n], force, order);

        let last = (series.len() / n.max(1)).saturating_sub(1); // 0 without bodies
        for k in 1..last {
            let (number, now) = (k as f64, k * n..(k + 1) * n);
            let order = &mut products.next(k);
            let time = if k == 1 { unit } else { 0.0 };
            shape.series(time, &series[now.clone()], normals, acting, moves, &mut AnyOrder::Next(order));
            let mut own = order.take(self.own_blocks());
            pull.copy_from_slice(force);
            for component in &shape.components {
                let (rows, (_, block)) = (&component.rows, component.first);
                for row in 0..rows.equations() {
                    for (at, body) in rows.touched_by(row) {
                        let pulled = from_fn(|d| own.sum(lambda_normal::<D>(block + at) + d));
                        pull[body] = sum(&pull[body], &pulled);
                    }
                }
            }
            for (body, root) in shape.roots.iter().enumerate() {
                push[body] = root.velocity(&pull[body]);
            }
            work[k] = 0.0;
            for (c, component) in shape.components.iter().enumerate() {
                let (rows, solver, (first, block)) = (&component.rows, &mut solvers[c], component.first);
                let m = rows.equations();
                let normals = &normals[block..block + rows.blocks()];
                let start = &blocks[block..block + rows.blocks()];
                let (changes, x) = (&mut room.g[..m], &mut room.x[first..first + m]);
                for (row, change) in changes.iter_mut().enumerate() {
                    let mut turn = moves[first + row];
                    for (at, body) in rows.touched_by(row) {
                        for d in 0..D {
                            let known = own.sum(normal_velocity::<D>(block + at) + d);
                            turn += known + normals[at][d] * series[n + body][d] / unit;
                        }
                    }
                    *change = -number / unit * turn;
                }
                let of_rows = [&mut *x, &mut room.guess[..m], &mut room.dx[..m]];
                Pull { rows, roots: &shape.roots, blocks: start, changes }.add(solver, pull, push, of_rows);
                let lambda = &mut lambda[first..first + m];
                solver.multipliers(x, lambda);
                for (row, &lambda) in lambda.iter().enumerate() {
                    let known = own.sum(lambda_rate::<D>(shape, first + row));
                    work[k] -= (known + lambda * rates[first + row]) * unit / number;
                    if k == 1 {
                        witness.position_multiplier(rows.equation(row), lambda);
                    }
                }
            }
            for (body, root) in shape.roots.iter().enumerate() {
                velocity[body] = scaled(unit / number, &root.velocity(&pull[body]));
                series[(k + 1) * n + body] = scaled(unit / (number + 1.0), &velocity[body]);
            }
            note(shape, &mut own, lambda, [normals, acting], moves, velocity);
            if k + 1 < last {
                force.fill([0.0; D]);
                self.effects.contribute_series(&series[now], force, order);
            }
        }
    }

    fn expanded_work(&self, bodies: &BodiesOf<F, N, D>, h: f64) -> f64 {
        let step = h / self.unit(bodies);
        let work = bodies.kept.series.iter().flat_map(|room| room.work.iter().rev());
        work.fold(0.0, |sum, coefficient| coefficient + step * sum)
    }
}

impl<F: Forces<f64, D>, N: Count, const D: usize> Linked<F, N, D> {
    /// Blocks of products of all functions together; none where one has no series.
    pub(super) fn series_blocks(&self) -> Option<usize> {
        let shape = &*self.shape;
        let runs = shape.components.iter().flat_map(|component| &component.rows.runs);
        let links: Option<usize> =
            runs.map(|run| shape.groups[run.group].series_blocks(run.members.clone())).sum();
        Some(links? + self.effects.series_blocks(self.count.number())?)
    }

    /// The products of λ with n and of n with v for each block, then of λ with r for each row.
    fn own_blocks(&self) -> usize {
        blocks(2 * D * self.shape.blocks + self.shape.equations)
    }

    /// Room for so many coefficients of functions that all have series.
    fn room_for_series(&self, orders: usize, h: f64) -> Box<SeriesRoom<D>> {
        let (shape, n) = (&*self.shape, self.count.number());
        Box::new(SeriesRoom {
            unit: unit_near(h),
            products: Products::new(self.series_blocks().unwrap_or(0) + self.own_blocks(), orders),
            normals: vec![[0.0; D]; shape.blocks],
            acting: vec![[0.0; D]; shape.blocks],
            rates: vec![0.0; shape.equations],
            force: vec![[0.0; D]; n],
            pull: vec![[0.0; D]; n],
            push: vec![[0.0; D]; n],
            velocity: vec![[0.0; D]; n],
            lambda: vec![0.0; shape.equations],
            work: vec![0.0; orders],
        })
    }
}

/// Where the products of a block, and of a row, begin.
fn lambda_normal<const D: usize>(block: usize) -> usize {
    2 * D * block
}
fn normal_velocity<const D: usize>(block: usize) -> usize {
    2 * D * block + D
}
fn lambda_rate<const D: usize>(shape: &Shape<D>, row: usize) -> usize {
    2 * D * shape.blocks + row
}

/// Notes the factors: λₖ₋₁, nₖ, rₖ and vₖ.
fn note<const FIRST: bool, const D: usize>(
    shape: &Shape<D>,
    own: &mut Recurrences<'_, f64, FIRST>,
    lambda: &[f64],
    [normals, acting]: [&[[f64; D]]; 2],
    moves: &[f64],
    velocity: &[[f64; D]],
) {
    for component in &shape.components {
        let (rows, (first, block)) = (&component.rows, component.first);
        for row in 0..rows.equations() {
            let lambda = lambda[first + row];
            for (at, body) in rows.touched_by(row) {
                for d in 0..D {
                    own.note(lambda_normal::<D>(block + at) + d, lambda, acting[block + at][d]);
                    let (n, v) = (normals[block + at][d], velocity[body][d]);
                    own.note(normal_velocity::<D>(block + at) + d, n, v);
                }
            }
            own.note(lambda_rate(shape, first + row), lambda, moves[first + row]);
        }
    }
}

impl<const D: usize> Shape<D> {
    /// The next coefficients of all gradients, of what of them multipliers act along, and of ∂g/∂t; `time` is that of
    /// t.
    fn series(
        &self,
        time: f64,
        q: &[[f64; D]],
        normals: &mut [[f64; D]],
        acting: &mut [[f64; D]],
        rates: &mut [f64],
        order: &mut AnyOrder<'_, '_, f64>,
    ) {
        for (c, component) in self.components.iter().enumerate() {
            let (rows, (row, block)) = (&component.rows, component.first);
            for run in &rows.runs {
                let (blocks, rates) = (&mut normals[block + run.block..], &mut rates[row + run.row..]);
                self.groups[run.group].gradients_series(run.members.clone(), time, q, blocks, rates, order);
            }
            let blocks = block..block + rows.blocks();
            acting[blocks.clone()].copy_from_slice(&normals[blocks.clone()]);
            self.mask(c, &mut acting[blocks]);
        }
    }
}
