//! A potential between every two bodies.

use crate::effect::moment::Moment;
use crate::effect::one::{Acting, Effect};
use crate::effect::tiles;
use crate::error::{Error, refuse_nan};
use crate::kernel::functions::{PairKernel, PairPotential};
use crate::kernel::series::Order;
use crate::kernel::series::blocks;
#[cfg(doc)]
use crate::number::instructions::InstructionSet;
use crate::number::lanes::{Fused, Lane};
use crate::number::real::Real;
use crate::number::vector::{add_scaled, dot};

/// The kind of effect of every [`PairPotential`]: between every two bodies.
#[derive(Debug, Clone, Copy)]
pub struct BetweenPairs;

/// A potential between every two bodies, over a scalar.
///
/// In `f64`, pairs are computed [several at a time](InstructionSet), with [functions for lanes](crate::number::lanes),
/// unless there are only few bodies or the processor lacks fused multiply-add. Results of the two ways differ by
/// rounding. Forces between 1000 or more bodies are formed on the threads of the [rayon](https://docs.rs/rayon) pool
/// that they are asked for in; any number of threads gives the same bits.
#[derive(Debug, Clone, Copy)]
pub struct ActsBetweenPairs<K, L> {
    kernel: K,
    in_lanes: L,
}

impl<P: PairPotential, const D: usize> Effect<D, BetweenPairs> for P {
    type Acting<T: Real> = ActsBetweenPairs<P::Kernel<T>, P::Kernel<Fused<f64>>>;
    fn acting<T: Real>(&self) -> Self::Acting<T> {
        ActsBetweenPairs { kernel: self.kernel(), in_lanes: self.kernel() }
    }

    type Swept<S: Lane, const L: usize> = [Self::Acting<S>; L];

    fn check(&self, what: &'static str, _: usize) -> Result<(), Error> {
        refuse_nan(what, self.nan_parameter())
    }
}

impl<T: Real, K: PairKernel<T>, L: PairKernel<Fused<f64>>, const D: usize> Acting<T, D>
    for ActsBetweenPairs<K, L>
{
    type Room = ();
    fn room(&self, _: usize) {}

    #[inline(always)]
    fn add_forces(&self, at: Moment<'_, T, D>, (): &mut (), forces: &mut [[T; D]]) {
        let positions = at.positions;
        if positions.len() >= tiles::MANY
            && let (Some(positions), Some(forces)) = (T::doubles(positions), T::doubles_mut(forces))
            && tiles::add_forces(&self.in_lanes, positions, forces)
        {
            return;
        }
        for i in 1..positions.len() {
            let mut on_i = forces[i];
            for j in 0..i {
                let apart = add_scaled(&positions[i], T::from_f64(-1.0), &positions[j]);
                let pull = T::from_f64(-2.0) * self.kernel.slope(dot(&apart, &apart)); // −U′(r)/r
                on_i = add_scaled(&on_i, pull, &apart);
                forces[j] = add_scaled(&forces[j], -pull, &apart);
            }
            forces[i] = on_i;
        }
    }
    fn energy(&self, Moment { positions, .. }: Moment<'_, T, D>) -> T {
        if positions.len() >= tiles::MANY
            && let Some(positions) = T::doubles(positions)
            && let Some(energy) = tiles::energy(&self.in_lanes, positions)
        {
            return T::from_f64(energy);
        }
        let mut energy = T::from_f64(-0.0);
        for i in 1..positions.len() {
            for j in 0..i {
                let apart = add_scaled(&positions[i], T::from_f64(-1.0), &positions[j]);
                energy = energy + self.kernel.value(dot(&apart, &apart));
            }
        }
        energy
    }
    fn series_blocks(&self, bodies: usize) -> Option<usize> {
        Some(bodies * bodies.saturating_sub(1) / 2 * (blocks(2 * D) + self.kernel.series()?))
    }
    #[inline(always)]
    fn add_series<const FIRST: bool>(
        &self,
        positions: &[[T; D]],
        forces: &mut [[T; D]],
        order: &mut Order<'_, T, FIRST>,
    ) {
        for i in 1..positions.len() {
            for j in 0..i {
                // Loops: of many lanes `array::from_fn` is a call, compiled for no instruction set.
                let mut apart = positions[i];
                let mut own = order.take(blocks(2 * D));
                let mut s = T::from_f64(0.0);
                for d in 0..D {
                    apart[d] = apart[d] - positions[j][d];
                    s = s + own.square(d, apart[d]);
                }
                let slope = self.kernel.slope_series(s, order);
                for d in 0..D {
                    let pull = T::from_f64(-2.0) * own.product(D + d, apart[d], slope);
                    forces[i][d] = forces[i][d] + pull;
                    forces[j][d] = forces[j][d] - pull;
                }
            }
        }
    }
}
