//! A potential between bodies that are near each other.

use crate::effect::laws::{Alike, ByKind, Laws};
use crate::effect::moment::Moment;
use crate::effect::near;
use crate::effect::neighbours::Neighbours;
use crate::effect::one::{Acting, Effect};
use crate::error::{Error, PairMistake, refuse_nan};
use crate::kernel::cut_off::CutOff;
use crate::kernel::functions::{PairKernel, PairPotential};
use crate::kernel::kinds::Kinds;
use crate::kernel::space::Space;
use crate::kernel::within::{Ending, Within};
#[cfg(doc)]
use crate::number::instructions::InstructionSet;
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::{Fused, Lane};
use crate::number::real::Real;
use std::marker::PhantomData;

/// The kind of effect of every [`Within`]: between every two bodies within a cut-off distance.
#[derive(Debug, Clone, Copy)]
pub struct BetweenNear;

/// The kind of effect of [`Kinds`] of [`Within`]: between every two bodies within a cut-off distance, by their kinds.
#[derive(Debug, Clone, Copy)]
pub struct BetweenNearKinds;

/// Potentials with cut-offs between every two bodies, over a scalar.
///
/// For `f64` they use a [list of near pairs](Neighbours), several pairs [at a time](InstructionSet) where the processor
/// has fused multiply-add; for other scalars they go through all pairs.
#[derive(Debug, Clone)]
pub struct ActsBetweenNear<L, F, B> {
    laws: L,
    in_lanes: F,
    space: B,
    reach: f64,
    skin: f64,
}

impl<P: PairPotential, B: Space<D>, const D: usize> Effect<D, BetweenNear> for Within<P, B> {
    type Acting<T: Real> =
        ActsBetweenNear<Alike<CutOff<P::Kernel<T>, T>>, Alike<CutOff<P::Kernel<Fused<f64>>, Fused<f64>>>, B>;
    fn acting<T: Real>(&self) -> Self::Acting<T> {
        let (laws, in_lanes) = (Alike(self.cut_off()), Alike(self.cut_off()));
        ActsBetweenNear { laws, in_lanes, space: self.space, reach: self.reach, skin: self.skin }
    }

    type Swept<S: Lane, const L: usize> = [Self::Acting<S>; L];

    fn check(&self, what: &'static str, bodies: usize) -> Result<(), Error> {
        check_within(self, 1.0, what, bodies)
    }
}

impl<P: PairPotential, B: Space<D>, const D: usize> Effect<D, BetweenNearKinds> for Kinds<Within<P, B>> {
    type Acting<T: Real> = ActsBetweenNear<
        ByKind<T, CutOff<P::Kernel<T>, T>>,
        ByKind<Fused<f64>, CutOff<P::Kernel<Fused<f64>>, Fused<f64>>>,
        B,
    >;
    fn acting<T: Real>(&self) -> Self::Acting<T> {
        let largest = |of: fn(&Within<P, B>) -> f64| self.table.iter().map(of).fold(0.0, f64::max);
        ActsBetweenNear {
            laws: ByKind::new(&self.of, self.square(Within::cut_off)),
            in_lanes: ByKind::new(&self.of, self.square(Within::cut_off)),
            space: self.table[0].space,
            reach: largest(|within| within.reach),
            skin: largest(|within| within.skin),
        }
    }

    type Swept<S: Lane, const L: usize> = [Self::Acting<S>; L];

    fn check(&self, what: &'static str, bodies: usize) -> Result<(), Error> {
        self.check_kinds(what, bodies)?;
        for within in &self.table {
            check_within(within, 1.0, what, bodies)?;
            if within.space != self.table[0].space {
                return Err(Error::Pairs(PairMistake::Boxes { what }));
            }
        }
        Ok(())
    }
}

/// Says what is wrong with a cut-off for which bodies are looked for so many times as far through space.
pub(super) fn check_within<P: PairPotential, B: Space<D>, const D: usize>(
    within: &Within<P, B>,
    farther: f64,
    what: &'static str,
    bodies: usize,
) -> Result<(), Error> {
    refuse_nan(what, within.potential.nan_parameter())?;
    check_numbers(within, farther, what, bodies).map_err(Error::Pairs)
}

fn check_numbers<P: PairPotential, B: Space<D>, const D: usize>(
    within: &Within<P, B>,
    farther: f64,
    what: &'static str,
    bodies: usize,
) -> Result<(), PairMistake> {
    let Within { ref potential, reach, ending, skin, ref space } = *within;
    if !(reach > 0.0 && (reach * reach).is_normal()) {
        return Err(PairMistake::Reach { what, reach });
    }
    let (kernel, square) = (potential.kernel::<f64>(), reach * reach);
    let last = match ending {
        Ending::Shifted => vec![kernel.value(square)],
        Ending::ForceShifted => vec![kernel.value(square), kernel.slope(square)],
        Ending::Switched { from } if (0.0..reach).contains(&from) => Vec::new(),
        Ending::Switched { from } => return Err(PairMistake::Switch { what, from, reach }),
    };
    if let Some(&value) = last.iter().find(|value| !value.is_finite()) {
        return Err(PairMistake::Value { what, reach, value });
    }
    if !(skin >= 0.0 && ((reach + skin) * (reach + skin)).is_finite()) {
        return Err(PairMistake::Skin { what, skin });
    }
    let (periods, through) = (space.periods(), farther * reach);
    let serves = |period: &f64| *period >= 2.0 * through; // not so for NaN
    if let Some(coordinate) = periods.iter().position(|period| !serves(period)) {
        return Err(PairMistake::Period { what, coordinate, period: periods[coordinate], reach, through });
    }
    let most = u32::MAX as usize;
    if bodies > most { Err(PairMistake::TooMany { what, bodies, most }) } else { Ok(()) }
}

impl<T: Real, L: Laws<T>, F: Laws<Fused<f64>>, B: Space<D>, const D: usize> Acting<T, D>
    for ActsBetweenNear<L, F, B>
{
    type Room = Neighbours<D>;
    fn room(&self, bodies: usize) -> Neighbours<D> {
        Neighbours::new(bodies)
    }

    fn add_forces(&self, at: Moment<'_, T, D>, list: &mut Neighbours<D>, forces: &mut [[T; D]]) {
        if let (Some(positions), Some(forces)) = (T::doubles(at.positions), T::doubles_mut(forces)) {
            if list.renew(positions, &self.space, self.reach, self.skin) {
                let list = &*list;
                match Fusing::widest() {
                    Some(set) => set.run(self.push(&self.in_lanes, list, positions, forces)),
                    None => self.push(&self.laws, list, positions, forces).run(),
                }
            } else if positions.len() > 1 {
                forces.fill([f64::NAN; D]);
            }
            return;
        }
        near::push_all(&self.laws, &self.space, at.positions, forces);
    }

    fn energy(&self, at: Moment<'_, T, D>) -> T {
        if let Some(positions) = T::doubles(at.positions) {
            let mut list = Neighbours::new(positions.len());
            if list.renew(positions, &self.space, self.reach, 0.0) {
                return near::energy(&self.laws, &self.space, &list, at.positions);
            }
        }
        near::energy_of_all(&self.laws, &self.space, at.positions)
    }
}

impl<L, F, B: Copy> ActsBetweenNear<L, F, B> {
    #[inline(always)]
    fn push<'a, T, X, const D: usize>(
        &self,
        laws: &'a X,
        list: &'a Neighbours<D>,
        positions: &'a [[f64; D]],
        forces: &'a mut [[f64; D]],
    ) -> near::Push<'a, T, X, B, D> {
        let reach_square = self.reach * self.reach;
        near::Push { laws, space: self.space, reach_square, list, positions, forces, number: PhantomData }
    }
}
