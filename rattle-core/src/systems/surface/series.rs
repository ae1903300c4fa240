//! The motion of bodies on surfaces as a power series in time.
//!
//! With aₖ the coefficient of tᵏ of a, n = ∇g and λ from n·v = 0, order by order:
//!
//! ```text
//! k vₖ = fₖ₋₁ + Σⱼ λⱼ₋₁ nₖ₋ⱼ,   Σⱼ nⱼ·vₖ₋ⱼ = 0,   qₖ₊₁ = vₖ/(k + 1)
//! ```
//!
//! nₖ is known from q₀ … qₖ, so that the second sum gives λₖ₋₁. No second derivative of g is needed.

use crate::effect::list::Forces;
use crate::kernel::functions::ConstraintKernel;
use crate::kernel::series::{Products, blocks};
use crate::motion::bodies::Count;
use crate::motion::witness::Witness;
use crate::number::real::Scalar;
use crate::number::vector::{dot, scaled, sum};
use crate::systems::surface::kept::{BodiesOf, OnSurface};
use crate::systems::surface::room::SeriesRoom;
use std::array::from_fn;

impl<K, F, N: Count, L> OnSurface<K, F, N, L> {
    /// Room for so many coefficients of functions that all have series.
    pub(super) fn room_for_series<T: Scalar, const D: usize>(&self, orders: usize) -> Box<SeriesRoom<T, D>>
    where
        K: ConstraintKernel<T, D, 1>,
        F: Forces<T, D>,
    {
        let n = self.count.number();
        let of_forces = self.effects.series_blocks(n).unwrap_or(0);
        let blocks = n * (self.constraint.series().unwrap_or(0) + blocks(2 * D)) + of_forces;
        let products = Products::new(blocks, orders);
        Box::new(SeriesRoom { products, force: vec![[T::from_f64(0.0); D]; n] })
    }

    /// Writes q₀, q₁, … of all bodies in turn, as many as `series` has room for.
    pub(super) fn expand_motion<T, W, const D: usize>(
        &self,
        bodies: &mut BodiesOf<N, T, F, D>,
        series: &mut [[T; D]],
        witness: &mut W,
    ) where
        T: Scalar,
        K: ConstraintKernel<T, D, 1>,
        F: Forces<T, D>,
        W: Witness<T>,
    {
        let (n, zero) = (self.count.number(), T::from_f64(0.0));
        if n == 0 {
            return;
        }
        let room = bodies.kept.series.get_or_insert_with(|| self.room_for_series(series.len() / n));
        let SeriesRoom { products, force } = &mut **room;
        let (start, v) = (bodies.kept.normal.as_ref(), bodies.p.as_ref());
        series[..n].copy_from_slice(bodies.q.as_ref());
        series[n..2 * n].copy_from_slice(v);

        let order = &mut products.first();
        for body in 0..n {
            let [normal] = self.constraint.jacobian_series(&series[body], order);
            let mut own = order.take(blocks(2 * D));
            for i in 0..D {
                own.note(i, zero, normal[i]);
                own.note(D + i, normal[i], v[body][i]);
            }
        }
        force.fill([zero; D]);
        self.effects.contribute_series(&series[..n], force, order);

        let last = series.len() / n - 1;
        for k in 1..last {
            let order = &mut products.next(k);
            let number = |x: f64| T::from_f64(x);
            let (share, next_share) = (number(1.0 / k as f64), number(1.0 / (k * (k + 1)) as f64));
            for body in 0..n {
                let [normal] = self.constraint.jacobian_series(&series[k * n + body], order);
                let mut own = order.take(blocks(2 * D));
                let pull = sum(&force[body], &from_fn(|i| own.sum(i)));
                let turn = (1..D).fold(own.sum(D), |turn, i| turn + own.sum(D + i));
                let first = &start[body].gradient;
                // All that can be done before nₖ is known.
                let scale = -(number(k as f64) * start[body].inverse_square);
                let known = scale * turn - dot(first, &pull) * start[body].inverse_square;
                let (away, step, pulled) =
                    (scaled(scale, &v[body]), scaled(next_share, first), scaled(next_share, &pull));
                let lambda = dot(&normal, &away) + known;
                series[(k + 1) * n + body] = from_fn(|i| lambda.multiply_add(step[i], pulled[i]));
                for i in 0..D {
                    own.note(i, lambda, normal[i]);
                    own.note(D + i, normal[i], share * lambda.multiply_add(first[i], pull[i]));
                }
                if k == 1 {
                    witness.position_multiplier(body, lambda);
                }
            }
            if k + 1 < last {
                force.fill([zero; D]);
                self.effects.contribute_series(&series[k * n..][..n], force, order);
            }
        }
    }
}
