//! A potential between near bodies, as a function of the length of the geodesic between them on the surface g = 0.
//!
//! ```text
//! U(d),   −∂U/∂qᵢ = U′(d) uᵢ,   −∂U/∂qⱼ = −U′(d) uⱼ        u: unit vectors along the geodesic from i to j, at its ends
//! ```
//!
//! By the first variation of length the unit vectors are the gradient of the distance, so energy is conserved as
//! exactly as the distance is known: to rounding. Each pair within reach takes some 30 µs for
//! [shooting](crate::kernel::geodesic): for few bodies, or to compare with the [expansion](crate::effect::along).

use crate::effect::along::along_its_surface;
use crate::effect::between_near::check_within;
use crate::effect::interval::Interval;
use crate::effect::moment::Moment;
use crate::effect::neighbours::Neighbours;
use crate::effect::one::{Acting, Effect};
use crate::error::{EffectMistake, Error};
use crate::kernel::cut_off::CutOff;
use crate::kernel::functions::{Constraint, ConstraintKernel, PairKernel, PairPotential};
use crate::kernel::geodesic::{Shot, shoot};
use crate::kernel::over::refuse_nan_in;
use crate::kernel::space::Space;
use crate::kernel::within::{AlongGeodesics, Within};
use crate::number::lanes::Lane;
use crate::number::real::Real;
use crate::number::vector::{add_scaled, dot};

/// The kind of effect of every [`AlongGeodesics`]: a potential of lengths of geodesics.
#[derive(Debug, Clone, Copy)]
pub struct ByGeodesics;

/// [`AlongGeodesics`] over a scalar: a potential of lengths of geodesics.
#[derive(Debug, Clone)]
pub struct ActsByGeodesics<X, C, B> {
    law: X,
    surface: C,
    space: B,
    reach: f64,
    skin: f64,
}

impl<P: PairPotential, C: Constraint<D, 1>, B: Space<D>, const D: usize> Effect<D, ByGeodesics>
    for AlongGeodesics<P, C, B>
{
    type Acting<T: Real> = ActsByGeodesics<CutOff<P::Kernel<f64>, f64>, C::Kernel<f64>, B>;
    fn acting<T: Real>(&self) -> Self::Acting<T> {
        let Within { reach, skin, space, .. } = self.within;
        ActsByGeodesics { law: self.within.cut_off(), surface: self.surface.kernel(), space, reach, skin }
    }

    type Swept<S: Lane, const L: usize> = [Self::Acting<S>; L];

    fn check(&self, what: &'static str, bodies: usize) -> Result<(), Error> {
        refuse_nan_in::<C>(self.surface.nan_parameter())?;
        check_within(&self.within, 1.0, what, bodies)
    }
}

impl<X: PairKernel<f64>, C, B> ActsByGeodesics<X, C, B> {
    /// Tells, of each pair within reach, i, j, and the geodesic from i to j; false where one is not found.
    fn pairs<const D: usize>(
        &self,
        positions: &[[f64; D]],
        list: &Neighbours<D>,
        mut told: impl FnMut(usize, usize, &Shot<D>),
    ) -> bool
    where
        C: ConstraintKernel<f64, D, 1>,
        B: Space<D>,
    {
        for i in 1..positions.len() {
            for j in list.row(i).iter().map(|&j| j as usize) {
                let way = self.space.apart(&positions[j], &positions[i]);
                if dot(&way, &way) >= self.reach * self.reach {
                    continue; // a chord is shorter than any way along the surface
                }
                // Far from the origin places are rounded by more.
                match shoot(&self.surface, &self.space.apart(&positions[i], &[0.0; D]), &way) {
                    Ok(shot) if shot.distance < self.reach => told(i, j, &shot),
                    Ok(_) => {}
                    Err(_) => return false,
                }
            }
        }
        true
    }

    /// Adds the forces at these positions; false where they are not known.
    fn push<const D: usize>(
        &self,
        positions: &[[f64; D]],
        list: &mut Neighbours<D>,
        forces: &mut [[f64; D]],
    ) -> bool
    where
        C: ConstraintKernel<f64, D, 1>,
        B: Space<D>,
    {
        list.renew(positions, &self.space, self.reach, self.skin)
            && self.pairs(positions, list, |i, j, Shot { distance, from, to }| {
                let slope = 2.0 * distance * self.law.slope(distance * distance); // U′(d)
                forces[i] = add_scaled(&forces[i], slope, from);
                forces[j] = add_scaled(&forces[j], -slope, to);
            })
    }

    /// The energy at these positions; not a number where it is not known.
    fn energy_at<const D: usize>(&self, positions: &[[f64; D]]) -> f64
    where
        C: ConstraintKernel<f64, D, 1>,
        B: Space<D>,
    {
        let (mut list, mut energy) = (Neighbours::new(positions.len()), -0.0);
        let known = list.renew(positions, &self.space, self.reach, 0.0)
            && self.pairs(positions, &list, |_, _, shot| {
                energy += self.law.value(shot.distance * shot.distance)
            });
        if known { energy } else { f64::NAN }
    }
}

impl<T, X, C, B, const D: usize> Acting<T, D> for ActsByGeodesics<X, C, B>
where
    T: Real,
    X: PairKernel<f64>,
    C: ConstraintKernel<f64, D, 1>,
    B: Space<D>,
{
    type Room = Neighbours<D>;
    const LOOKS: bool = true;
    fn room(&self, bodies: usize) -> Neighbours<D> {
        Neighbours::new(bodies)
    }

    fn fits(&self, during: &Interval<'_, T, D>) -> Result<(), EffectMistake> {
        let at = |q: &[f64; D]| {
            let ([value], [gradient]) = self.surface.value_and_jacobian(q);
            let [bend] = self.surface.hessian_vector(q, &gradient);
            (value, gradient, bend)
        };
        let near = |way: &[f64; D], _| dot(way, way) < self.reach * self.reach;
        along_its_surface(during, &self.space, at, near, self.reach, false)
    }

    fn add_forces(&self, at: Moment<'_, T, D>, room: &mut Neighbours<D>, forces: &mut [[T; D]]) {
        let known = match (T::doubles(at.positions), T::doubles_mut(forces)) {
            (Some(positions), Some(forces)) => self.push(positions, room, forces),
            _ => false, // numbers side by side: one body each, which has no pair
        };
        if !known && forces.len() > 1 {
            forces.fill([T::from_f64(f64::NAN); D]);
        }
    }

    fn energy(&self, at: Moment<'_, T, D>) -> T {
        match T::doubles(at.positions) {
            Some(positions) => T::from_f64(self.energy_at(positions)),
            None => T::from_f64(if at.positions.len() > 1 { f64::NAN } else { 0.0 }),
        }
    }
}
