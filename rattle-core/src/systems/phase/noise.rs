//! What is taken for rounding of g and of {g, H}, where a residual no longer falls: only there is it asked for.
//!
//! It may be more than the rounding of coordinates. Terms may be larger than slopes times coordinates: near the bottom
//! of q₀² + (q₁ − 1)² = 1 they are as large as 1. And coordinates may be what is left of what a step gives and takes,
//! whose rounding they have: those of a pendulum that hangs nearly still.

use crate::kernel::functions::{HamiltonianKernel, PhaseConstraintKernel};
use crate::kernel::rounding::SHIFTS;
use crate::number::vector::dot;
use crate::solve::aim::{LARGER, noise_of_terms};
use crate::systems::phase::point::{Hidden, Level, Point, bracket};
use std::array::from_fn;

/// A residual below this many roundings of coordinates may be rounding, once it no longer shrinks.
pub(crate) const NOISE: f64 = 1e3;

impl<const D: usize, const M: usize> Level<D, M> {
    /// The noise of each gᵢ at the point where this is, where coordinates were as large as those of `reach`.
    #[cold]
    #[inline(never)]
    pub(super) fn noise<K>(&self, constraint: &K, at: &Point<D>, reach: &Point<D>) -> [f64; M]
    where
        K: PhaseConstraintKernel<f64, D, M>,
    {
        let values = |at: &Point<D>| constraint.value(&at.q, &at.p);
        from_fn(|i| {
            let value = Value { of: &|at| values(at)[i], gradient: self.gradients[i], at };
            value.noise(reach, || self.distances(constraint, at, i))
        })
    }

    /// How far away gᵢ has no gradient, in positions and in momenta; infinite or no number where nothing tells.
    fn distances<K>(&self, constraint: &K, at: &Point<D>, i: usize) -> [f64; 2]
    where
        K: PhaseConstraintKernel<f64, D, M>,
    {
        let Point { q, p } = &self.gradients[i];
        let bend = |q: &[f64; D], p: &[f64; D]| constraint.hessian_vector(&at.q, &at.p, q, p);
        let ((by_q, _), (_, by_p)) = (bend(q, &[0.0; D]), bend(&[0.0; D], p));
        let distance = |slopes: &[f64; D], bend: &[f64; D]| dot(slopes, slopes) / dot(bend, bend).sqrt();
        [distance(q, &by_q[i]), distance(p, &by_p[i])]
    }
}

impl<const D: usize, const M: usize> Hidden<D, M> {
    /// The same of each {gᵢ, H}.
    #[cold]
    #[inline(never)]
    pub(super) fn noise<K, H>(&self, constraint: &K, energy: &H, at: &Point<D>, reach: &Point<D>) -> [f64; M]
    where
        K: PhaseConstraintKernel<f64, D, M>,
        H: HamiltonianKernel<f64, D>,
    {
        let values = |at: &Point<D>| {
            let (g_q, g_p) = constraint.jacobians(&at.q, &at.p);
            let (q, p) = energy.gradients(&at.q, &at.p);
            from_fn::<_, M, _>(|i| bracket(&Point { q: g_q[i], p: g_p[i] }, &Point { q, p }).0)
        };
        from_fn(|i| {
            let value = Value { of: &|at| values(at)[i], gradient: self.gradients[i], at };
            value.noise(reach, || self.level.distances(constraint, at, i))
        })
    }
}

/// A function of phase space, and its gradient at a point.
struct Value<'a, const D: usize> {
    of: &'a dyn Fn(&Point<D>) -> f64,
    gradient: Point<D>,
    at: &'a Point<D>,
}

impl<const D: usize> Value<'_, D> {
    /// Some roundings of the coordinates, or if that is more, by how much the value does not follow small shifts of the
    /// point along the gradient.
    ///
    /// Shifts are some roundings of a size that grows until the value follows. It begins with the coordinates of
    /// `reach` on which the value depends. Where these are next to nothing, it begins with a small part of `distances`.
    fn noise(&self, reach: &Point<D>, distances: impl FnOnce() -> [f64; 2]) -> f64 {
        let near = reach.most_along(&self.gradient).sizes();
        let mut noise = self.noise_in(near);
        if noise == 0.0 {
            let far = distances().map(|distance| distance / LARGER);
            let further = |k: usize| if far[k].is_finite() { near[k].max(far[k]) } else { near[k] };
            noise = self.noise_in(from_fn(further));
        }
        noise.max(NOISE * f64::EPSILON * self.gradient.size_along(reach))
    }

    /// The latter, with positions and momenta in these units.
    fn noise_in(&self, [q, p]: [f64; 2]) -> f64 {
        let slopes = self.gradient.weighted(q, p);
        let (length, here) = (slopes.along(&slopes).sqrt(), (self.of)(self.at));
        if length == 0.0 {
            return 0.0;
        }
        let way = slopes.times(1.0 / length).weighted(q, p);
        let bent = |shift: f64| {
            let there = (self.of)(&self.at.plus(&way.times(shift)));
            ((there - here) / length - shift).abs()
        };
        let rounding = |size: f64| {
            let shifts = SHIFTS.into_iter().map(|share| share * f64::EPSILON * size);
            shifts.map(bent).fold(0.0, f64::max)
        };
        length * noise_of_terms::<f64>(1.0, rounding)
    }
}

/// Those values that are more than noise; the others are 0.
pub(super) fn beyond<const M: usize>(value: &[f64; M], noise: &[f64; M]) -> [f64; M] {
    from_fn(|i| if value[i].abs() <= noise[i] { 0.0 } else { value[i] })
}
