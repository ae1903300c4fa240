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
use crate::kernel::series::{Order, Products, blocks, unit_near};
use crate::motion::bodies::Count;
use crate::motion::capability::Series;
use crate::motion::witness::Witness;
use crate::number::lanes::Fused;
use crate::number::real::{Real, Scalar};
use crate::number::vector::{dot, scaled};
use crate::systems::surface::kept::{BodiesOf, Kept, OnSurface};
use crate::systems::surface::room::SeriesRoom;

impl<T, K, F, N, L, const D: usize> Series<N, Kept<N, T, F, D>, T, D> for OnSurface<K, F, N, L>
where
    T: Scalar,
    K: ConstraintKernel<T, D, 1>,
    F: Forces<T, D>,
    N: Count,
    L: ConstraintKernel<Fused<f64>, D, 1>,
{
    fn reserve_series(&self, bodies: &mut BodiesOf<N, T, F, D>, orders: usize, h: f64) {
        bodies.kept.series = Some(self.room_for_series(orders, h));
    }

    fn unit(&self, bodies: &BodiesOf<N, T, F, D>) -> f64 {
        bodies.kept.series.as_ref().map_or(1.0, |room| room.unit)
    }

    fn expand<W: Witness<T>>(
        &self,
        bodies: &mut BodiesOf<N, T, F, D>,
        series: &mut [[T; D]],
        witness: &mut W,
    ) {
        let n = self.count.number();
        if n == 0 {
            return;
        }
        let room = bodies.kept.series.get_or_insert_with(|| self.room_for_series(series.len() / n, 1.0));
        series[..n].copy_from_slice(bodies.q.as_ref());
        for (v, p) in series[n..2 * n].iter_mut().zip(bodies.p.as_ref()) {
            *v = scaled(T::from_f64(room.unit), p);
        }
        let normals = bodies.kept.normal.as_ref();
        let start = |body: usize| (normals[body].gradient, normals[body].inverse_square);
        let tell = |body, lambda| witness.position_multiplier(body, lambda);
        let effects = Together(&self.effects);
        expand::<false, _, _, D>(&self.constraint, &effects, room, n, start, series, tell);
    }
}

impl<K, F, N: Count, L> OnSurface<K, F, N, L> {
    /// Room for so many coefficients of functions that all have series.
    fn room_for_series<T: Scalar, const D: usize>(&self, orders: usize, h: f64) -> Box<SeriesRoom<T, D>>
    where
        K: ConstraintKernel<T, D, 1>,
        F: Forces<T, D>,
    {
        let n = self.count.number();
        let of_forces = self.effects.series_blocks(n).unwrap_or(0);
        Box::new(room(n * self.constraint.series().unwrap_or(0) + of_forces, n, orders, h))
    }
}

/// What adds the next coefficient of the forces on bodies, from that of their positions.
pub(crate) trait Contributes<T: Real, const D: usize> {
    /// The blocks of products for `n` bodies; none without a power series.
    fn blocks(&self, n: usize) -> Option<usize>;
    fn contribute<const FIRST: bool>(
        &self,
        positions: &[[T; D]],
        forces: &mut [[T; D]],
        order: &mut Order<'_, T, FIRST>,
    );
}

/// The effects of a scene.
pub(crate) struct Together<'a, F>(pub(crate) &'a F);

impl<T: Real, F: Forces<T, D>, const D: usize> Contributes<T, D> for Together<'_, F> {
    fn blocks(&self, n: usize) -> Option<usize> {
        self.0.series_blocks(n)
    }
    #[inline(always)]
    fn contribute<const FIRST: bool>(
        &self,
        positions: &[[T; D]],
        forces: &mut [[T; D]],
        order: &mut Order<'_, T, FIRST>,
    ) {
        self.0.contribute_series(positions, forces, order);
    }
}

/// Writes q₂, q₃, … of `n` bodies in turn, as many as `series` has room for, from q₀ and q₁; ∇g and 1/|∇g|² of each
/// body are those of `start`. Tells λ at the start. `WITHIN` where the code that asks is compiled for its instructions
/// already.
#[inline(always)]
pub(crate) fn expand<const WITHIN: bool, T, K, const D: usize>(
    constraint: &K,
    effects: &impl Contributes<T, D>,
    room: &mut SeriesRoom<T, D>,
    n: usize,
    start: impl Fn(usize) -> ([T; D], T),
    series: &mut [[T; D]],
    mut tell: impl FnMut(usize, T),
) where
    T: Real,
    K: ConstraintKernel<T, D, 1>,
{
    let number = |x: f64| T::from_f64(x);
    let SeriesRoom { products, force, unit } = room;
    let (square, over_square) = (number(*unit * *unit), number(1.0 / (*unit * *unit)));
    let order = &mut products.first();
    for body in 0..n {
        let [normal] = constraint.jacobian_series(&series[body], order);
        let mut own = order.take(blocks(2 * D));
        for i in 0..D {
            own.note(i, number(0.0), normal[i]);
            own.note(D + i, normal[i], series[n + body][i]);
        }
    }
    force.fill([number(0.0); D]);
    effects.contribute(&series[..n], force, order);

    let last = series.len() / n - 1;
    for k in 1..last {
        let order = &mut if WITHIN { products.next_within(k) } else { products.next(k) };
        let (share, next_share) = (number(1.0 / k as f64), number(1.0 / (k * (k + 1)) as f64));
        for body in 0..n {
            let [normal] = constraint.jacobian_series(&series[k * n + body], order);
            let mut own = order.take(blocks(2 * D));
            // Loops: of many lanes in many dimensions `array::from_fn` is a call, compiled for no instruction set.
            let mut pull = force[body];
            for (i, pull) in pull.iter_mut().enumerate() {
                *pull = square.multiply_add(*pull, own.sum(i));
            }
            let turn = (1..D).fold(own.sum(D), |turn, i| turn + own.sum(D + i));
            let (first, inverse_square) = start(body);
            // All that can be done before nₖ is known.
            let scale = -(number(k as f64) * inverse_square);
            let known = scale * turn - dot(&first, &pull) * inverse_square;
            let (mut away, mut step, mut pulled) = (series[n + body], first, pull);
            for i in 0..D {
                (away[i], step[i]) = (scale * away[i], next_share * step[i]);
                pulled[i] = next_share * pulled[i];
            }
            let lambda = dot(&normal, &away) + known;
            for i in 0..D {
                series[(k + 1) * n + body][i] = lambda.multiply_add(step[i], pulled[i]);
                own.note(i, lambda, normal[i]);
                own.note(D + i, normal[i], share * lambda.multiply_add(first[i], pull[i]));
            }
            if k == 1 {
                tell(body, over_square * lambda);
            }
        }
        if k + 1 < last {
            force.fill([number(0.0); D]);
            effects.contribute(&series[k * n..][..n], force, order);
        }
    }
}

/// Room for so many coefficients in steps of about `h`, with so many blocks of products for functions of `n` bodies.
pub(crate) fn room<T: Real, const D: usize>(
    functions: usize,
    n: usize,
    orders: usize,
    h: f64,
) -> SeriesRoom<T, D> {
    let products = Products::new(functions + n * blocks(2 * D), orders);
    let unit = unit_near(h);
    SeriesRoom { products, force: vec![[T::from_f64(0.0); D]; n], unit }
}
