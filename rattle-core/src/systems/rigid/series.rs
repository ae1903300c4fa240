//! The turning of rigid bodies as a power series in time.
//!
//! ```text
//! (k + 1) Qₖ₊₁ = u (Q Ω̂)ₖ,   (k + 1) mₖ₊₁ = u (m × Ω + τ)ₖ      Ω = J⁻¹m,   τ = −Σ rows of Q × rows of F
//! ```
//!
//! u is the unit of time.

use crate::effect::list::Forces;
use crate::kernel::series::{Order, Products, blocks, unit_near};
use crate::motion::bodies::Count;
use crate::motion::capability::Series;
use crate::motion::witness::Witness;
use crate::number::vector::{add_scaled, scaled};
use crate::systems::rigid::body::spread;
use crate::systems::rigid::kept::{BodiesOf, Kept, Turning};
use crate::systems::rigid::room::SeriesRoom;
use std::array::from_fn;

/// Six cross products of six products each, and the three of two components of Ω.
const BLOCKS: usize = blocks(6 * 6 + 3);

impl<F: Forces<f64, 9>, N: Count> Series<N, Kept<F>, f64, 9> for Turning<F, N> {
    fn reserve_series(&self, bodies: &mut BodiesOf<F, N>, orders: usize, h: f64) {
        bodies.kept.series = Some(self.room_for_series(orders, h));
    }

    fn unit(&self, bodies: &BodiesOf<F, N>) -> f64 {
        bodies.kept.series.as_ref().map_or(1.0, |room| room.unit)
    }

    fn expand<W: Witness<f64>>(&self, bodies: &mut BodiesOf<F, N>, series: &mut [[f64; 9]], _: &mut W) {
        self.expand_motion(bodies, series);
    }

    fn expanded_impulse(&self, bodies: &BodiesOf<F, N>, body: usize, h: f64) -> Option<[f64; 9]> {
        let room = bodies.kept.series.as_ref()?;
        Some(spread(&room.impulse(body, h).into()))
    }

    fn expanded_rate(&self, bodies: &BodiesOf<F, N>, body: usize, h: f64) -> Option<[f64; 9]> {
        let room = bodies.kept.series.as_ref()?;
        Some(spread(&room.rate(body, h).into()))
    }
}

impl<F: Forces<f64, 9>, N: Count> Turning<F, N> {
    /// Room for so many coefficients of functions that all have series.
    fn room_for_series(&self, orders: usize, h: f64) -> Box<SeriesRoom> {
        let n = self.count.number();
        let products = Products::new(n * BLOCKS + self.effects.series_blocks(n).unwrap_or(0), orders);
        let (force, m) = (vec![[0.0; 9]; n], vec![[0.0; 3]; n * orders]);
        Box::new(SeriesRoom { products, force, m, unit: unit_near(h) })
    }

    /// Writes Q₀, Q₁, … of all bodies in turn, as many as `series` has room for. Not part of
    /// [`expand`](Series::expand), so that it is compiled once and not for each witness: a step takes 3 % fewer
    /// instructions.
    fn expand_motion(&self, bodies: &mut BodiesOf<F, N>, series: &mut [[f64; 9]]) {
        let n = self.count.number();
        let orders = series.len() / n.max(1);
        let room = bodies.kept.series.get_or_insert_with(|| self.room_for_series(orders, 1.0));
        let SeriesRoom { products, force, m, unit } = &mut **room;
        series[..n].copy_from_slice(bodies.q.as_ref());
        for (m, p) in m.iter_mut().zip(bodies.p.as_ref()) {
            *m = from_fn(|i| p[i]);
        }
        self.next_coefficients((0, *unit), &mut products.first(), series, m, force);
        for k in 1..orders.saturating_sub(1) {
            self.next_coefficients((k, *unit), &mut products.next(k), series, m, force);
        }
    }

    fn next_coefficients<const FIRST: bool>(
        &self,
        (k, unit): (usize, f64),
        order: &mut Order<'_, f64, FIRST>,
        series: &mut [[f64; 9]],
        m: &mut [[f64; 3]],
        force: &mut [[f64; 9]],
    ) {
        let (n, share) = (self.count.number(), unit / (k + 1) as f64);
        force.fill([0.0; 9]);
        self.effects.contribute_series(&series[k * n..][..n], force, order);
        for body in 0..n {
            let own = &mut order.take(BLOCKS);
            let mut cross = |first: usize, a: [f64; 3], b: [f64; 3]| -> [f64; 3] {
                from_fn(|i| {
                    let (j, l) = ((i + 1) % 3, (i + 2) % 3);
                    let at = first + 2 * i;
                    own.product(at, a[j], b[l]) - own.product(at + 1, a[l], b[j])
                })
            };
            let row = |matrix: &[f64; 9], i: usize| -> [f64; 3] { from_fn(|j| matrix[3 * i + j]) };
            let (q, moment) = (series[k * n + body], m[k * n + body]);
            let rate = self.moments.rate(&moment);
            let turned: [[f64; 3]; 3] = from_fn(|i| cross(6 * i, row(&q, i), rate));
            let torques: [[f64; 3]; 3] = from_fn(|i| cross(18 + 6 * i, row(&q, i), row(&force[body], i)));
            let others = from_fn(|i| own.product(36 + i, rate[(i + 1) % 3], rate[(i + 2) % 3]));
            let mut change = self.moments.gyration(&others);
            for torque in &torques {
                change = add_scaled(&change, -1.0, torque);
            }
            series[(k + 1) * n + body] = from_fn(|entry| share * turned[entry / 3][entry % 3]);
            m[(k + 1) * n + body] = scaled(share, &change);
        }
    }
}
