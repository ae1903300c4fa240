//! Momenta of a row of components that are alike, kicked and made tangent.

use crate::number::instructions::Work;
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::systems::linked::abreast::{Lanes, RowUnderWay, add_up, places, square};
use crate::systems::network::few_in_lanes::{
    Normals, by_coordinate, grid, lifted, of_few, of_size, sized, solve, sum_of,
};
use crate::systems::network::in_lanes::{Number, Numbers, ROW, at, zeros};
use std::array::from_fn;

impl RowUnderWay<'_> {
    /// Kicks the momenta of plain lanes, and makes them tangent.
    pub(super) fn settle(&mut self, kick: f64) {
        macro_rules! run {
            ($m:expr, $k:expr) => {
                self.set.run(Settle::<$m, $k> { row: self, kick: Fused(kick) })
            };
        }
        sized!(self.sizes, run, ());
    }
}

struct Settle<'a, 'b, const M: usize, const K: usize> {
    row: &'a mut RowUnderWay<'b>,
    kick: Number,
}

impl<const M: usize, const K: usize> Work for Settle<'_, '_, M, K> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { row: RowUnderWay { links, kept, lanes, .. }, kick } = self;
        let (places, zero) = (places::<M, K>(links), zeros());
        let normals = by_coordinate(&places, &kept.normals, &zero);
        let Lanes { p, p_low, force, x, plain, path, trial: change, .. } = &mut **lanes;
        let (p, p_low, change) = (of_size::<K, ROW>(p), of_size(p_low), of_size(change));
        let (over, matrix, x) = (of_few(&kept.over), square::<M>(&kept.matrix), of_size(x));
        add_kick(of_few(force), kick, p_low, change);
        make_tangent::<false, M, K>(&normals, over, matrix, p, change, x);
        // The second time takes what rounding left, if it left more than comes from forming the rates.
        make_tangent::<true, M, K>(&normals, over, matrix, p, change, x);
        add_up(plain, change, p, p_low);
        *path = zeros();
        for p in p {
            add_square(p, path);
        }
    }
}

/// Adds the square of each number.
#[inline(always)]
fn add_square(numbers: &Numbers<ROW>, sum: &mut Numbers<ROW>) {
    for l in 0..ROW {
        sum.0[l] = numbers.0[l].multiply_add(numbers.0[l], sum.0[l]);
    }
}

/// What momenta change by without the constraints.
#[inline(always)]
fn add_kick<const K: usize>(
    force: &[Numbers<ROW>; K],
    kick: Number,
    p_low: &[Numbers<ROW>; K],
    change: &mut [Numbers<ROW>; K],
) {
    for k in 0..K {
        for l in 0..ROW {
            change[k].0[l] = kick.multiply_add(force[k].0[l], p_low[k].0[l]);
        }
    }
}

/// Makes momenta tangent, of lanes in which they are not, to rounding; writes the multipliers, or adds to them.
#[inline(always)]
fn make_tangent<const AGAIN: bool, const M: usize, const K: usize>(
    normals: &Normals<M, K, ROW>,
    over: &[Numbers<ROW>; K],
    matrix: &[[Numbers<ROW>; M]; M],
    p: &[Numbers<ROW>; K],
    change: &mut [Numbers<ROW>; K],
    x: &mut [Numbers<ROW>; M],
) {
    for l in 0..ROW {
        let (normals, lifted) = (grid(normals, l), lifted(normals, &at(over, l), l));
        let (mut small, mut needed) = (AGAIN, [Fused(0.0); M]);
        for i in 0..M {
            let (mut rate, mut size) = (Fused(0.0), Fused(0.0));
            for k in 0..K {
                let p = p[k].0[l] + change[k].0[l];
                rate = lifted[i][k].multiply_add(p, rate);
                if AGAIN {
                    size = size + (lifted[i][k] * p).abs();
                }
            }
            if AGAIN {
                small &= rate.abs().le(Fused(2.0 * f64::EPSILON) * size);
            }
            needed[i] = -rate;
        }
        let mut by = solve(&from_fn(|i| at(&matrix[i], l)), needed);
        for i in 0..M {
            by[i] = Real::select(small, Fused(0.0), by[i]);
            x[i].0[l] = if AGAIN { x[i].0[l] + by[i] } else { by[i] };
        }
        for k in 0..K {
            change[k].0[l] = sum_of(change[k].0[l], &normals, &by, k);
        }
    }
}
