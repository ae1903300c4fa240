//! The position equation g(q′) = 0, solved for the position multiplier to the rounding floor.
//!
//! ```text
//! q′(Λ) = q + (free + ∇g(q) Λ)      Λ = (h²/2) λ, the constraint's displacement per unit of ∇g
//! ```
//!
//! Along that line g is a function of one number, and Ostrowski's iteration (1960) applies: a Newton
//! step and a second one with the slope corrected from the two values, fourth order from two
//! evaluations of g and one of ∇g:
//!
//! ```text
//! Λ₁ = Λ₀ − g₀/s₀            s₀ = ∇g(q′(Λ₀))·∇g(q)
//! Λ₂ = Λ₁ − g₁/(s₀ (1 − 2 g₁/g₀))
//! ```
//!
//! **Stopping.** Corrections are measured as displacements δ = |ΔΛ| |∇g(q)|, so the rule does not depend on the scale
//! of g. Their floor is the rounding error ε·ℓ of the sum that forms q′ along the normal: ℓ is the larger of |q|∞ and
//! |free|∞, of coordinates on which g depends. With γ
//! = δ₂/δ₁ the next correction is about γ²δ₂, if third derivatives of g are negligible. Once that is negligible
//! ([`crate::solve::stop`]), the slope s there is evaluated, which the end of the step needs anyway. Its difference
//! from the slope s̃ of the parabola shows the effect of third derivatives: the remaining error is (1 − s̃/s) δ₂. If
//! that is negligible too, the solve ends. Otherwise it continues until a correction is at the floor, or a Newton step
//! below √ε of the position is no longer half the one before although the slope no longer changes: then it is the
//! rounding of g itself. (Where g jumps, Newton steps do not shrink either, but are long.)
//!
//! **Other slopes** than the newest ([`crate::motion::iteration`]) leave gradients out, [`Departure::chords`]. The rule
//! is the same: the next correction is about (δₖ/δₖ₋₁) δₖ, by the secant method (δₖ/δₖ₋₂) δₖ. Once that is spare, the
//! slope s there is evaluated, and
//! |1 − s/s̃| δₖ is left with the slope s̃ that was used. They are on their own only while each correction is at most half the one
//! before: else, and where the root found is not trusted, Newton's method makes the step.
//!
//! **Which root**: see [`crate::systems::surface::landing`].

use crate::kernel::rounding::size_along;
use crate::motion::iteration::{Iteration, Kind};
use crate::number::real::Scalar;
use crate::number::vector::{add_scaled, dot, largest, scaled, sum};
use crate::solve::root::straight;
use crate::solve::stop::SPARE;
use crate::systems::surface::equation::Equation;
use crate::systems::surface::normal::Normal;
use std::array::from_fn;

/// Corrections with a slope that is not the newest are given up where they do not shrink by half, at the latest here.
const MAX_CHORDS: usize = 60;

/// Cycles of two corrections after which a solve is given up; four suffice where one exists.
const MAX_CYCLES: usize = 12;

/// One body at the start of a step of length `h`, and where it would go without the constraint.
#[derive(Clone, Copy)]
pub(crate) struct Departure<'a, T, const D: usize> {
    pub(crate) h: f64,
    pub(crate) body: usize,
    pub(crate) q: &'a [T; D],
    pub(crate) q_low: &'a [T; D],
    pub(crate) p: &'a [T; D],
    pub(crate) normal: &'a Normal<T, D>,
    /// pᵀ∇²g p = ∓κ |∇g| |p|², or what a guess says about it.
    pub(crate) bend: T,
    /// h·p, to the last bit.
    pub(crate) path: [T; D],
    /// What the force displaces, and the square of that.
    pub(crate) push: [T; D],
    pub(crate) push_square: T,
    /// q′ − q without the constraint.
    pub(crate) free: [T; D],
    /// First guess of Λ.
    pub(crate) guess: T,
}

/// Where the body lands on the constraint.
#[derive(Clone, Copy)]
pub(crate) struct Landing<T: Scalar, const D: usize> {
    /// q′ − q.
    pub(crate) increment: [T; D],
    /// Λ.
    pub(crate) multiplier: T,
    /// ∇g(q′).
    pub(crate) gradient: [T; D],
    /// Length δ₁ of the first correction: how far off the guess was.
    pub(crate) first_correction: T,
    /// ∇g·∇g(q) where it was made, and where the body lands.
    pub(crate) slopes: [T; 2],
    /// Corrections at or below this length count as converged.
    pub(crate) floor: T,
    /// Whether the equation was solved to the floor.
    pub(crate) converged: bool,
}

impl<'a, T: Scalar, const D: usize> Departure<'a, T, D> {
    /// Without a force, and with the guess from g̈ = 0.
    pub(crate) fn coasting(
        equation: &(impl Equation<T, D> + ?Sized),
        h: f64,
        body: usize,
        [q, q_low, p]: [&'a [T; D]; 3],
        normal: &'a Normal<T, D>,
    ) -> Self {
        let (zero, step) = (T::from_f64(0.0), T::from_f64(h));
        let (bend, path) = (equation.bend(q, p), scaled(step, p));
        let guess = T::from_f64(-0.5) * step * step * bend * normal.inverse_square;
        Self {
            h,
            body,
            q,
            q_low,
            p,
            normal,
            bend,
            path,
            push: [zero; D],
            push_square: zero,
            free: path,
            guess,
        }
    }
}

impl<T: Scalar, const D: usize> Departure<'_, T, D> {
    #[inline(always)]
    fn increment(&self, multiplier: T) -> [T; D] {
        add_scaled(&self.free, multiplier, &self.normal.gradient)
    }

    #[inline(always)]
    pub(crate) fn point(&self, multiplier: T) -> [T; D] {
        sum(self.q, &sum(self.q_low, &self.increment(multiplier)))
    }

    /// The larger ones of |q| and |free|, coordinate by coordinate.
    #[inline(always)]
    pub(crate) fn places(&self) -> [T; D] {
        from_fn(|i| self.q[i].abs().max(self.free[i].abs()))
    }

    /// Solves for Λ; `correction` is told every correction's length.
    #[inline(always)]
    pub(crate) fn solve(
        &self,
        equation: &(impl Equation<T, D> + ?Sized),
        mut correction: impl FnMut(T),
    ) -> Landing<T, D> {
        let n = &self.normal.gradient;
        let length = dot(n, n).sqrt();
        let floor = T::from_f64(T::EPSILON) * size_along(n, length, &self.places());
        let (zero, half) = (T::from_f64(0.0), T::from_f64(0.5));

        let mut multiplier = self.guess;
        let (mut last, mut last_slope) = (T::from_f64(f64::INFINITY), zero);
        let mut converged = false;
        let (mut gradient, mut slope) = (*n, zero);
        let mut first_cycle = None;
        for _ in 0..MAX_CYCLES {
            let (g, at_point) = equation.value_and_gradient(&self.point(multiplier));
            gradient = at_point;
            slope = dot(&gradient, n);
            let newton = -g / slope;
            let first = newton.abs() * length;
            correction(first);
            first_cycle.get_or_insert((first, slope));
            let mut stalled = false;
            if (half * last).le(first) {
                let straight = (slope - last_slope).abs().le(T::from_f64(straight::<T>()) * slope.abs());
                let size = largest(self.q).max(largest(&self.free));
                let small = (first * first).le(T::from_f64(T::EPSILON) * size * size);
                stalled = straight & small;
            }
            last_slope = slope;
            converged = first.le(floor) | stalled;
            if converged {
                break;
            }
            multiplier = multiplier + newton;

            let g_next = equation.value(&self.point(multiplier));
            let ratio = g_next / g;
            let near = ratio.abs().lt(T::from_f64(0.25)); // else the parabola says nothing yet
            let bend = T::from_f64(1.0) - T::from_f64(2.0) * ratio;
            let share = if near { ratio / bend } else { zero }; // of Newton's step
            multiplier = multiplier + share * newton;
            let second = share.abs() * first;
            correction(second);
            let next = share * share * second;
            let spare = near & (T::from_f64(1.0 / SPARE) * next).le(floor);
            if spare {
                gradient = equation.gradient(&self.point(multiplier));
                let of_parabola = slope * (bend - T::from_f64(2.0) * ratio * (T::from_f64(1.0) - ratio));
                slope = dot(&gradient, n);
                let found = bend * slope; // as much larger as that of the parabola
                let left = (found - of_parabola).abs() * second;
                converged = (T::from_f64(1.0 / SPARE) * left).le(floor * found.abs());
                if converged {
                    break;
                }
            }
            last = first;
            if !first.le(T::from_f64(f64::MAX)) {
                break; // NaN or infinite: no cycle can mend it
            }
        }
        let (first_correction, first_slope) = first_cycle.unwrap_or((zero, zero));
        let (increment, slopes) = (self.increment(multiplier), [first_slope, slope]);
        Landing { increment, multiplier, gradient, first_correction, slopes, floor, converged }
    }

    /// Solves for Λ with the slope at the guess or that of the start, as it is or corrected by each two values. Not
    /// converged where corrections do not shrink by half.
    #[inline(always)]
    pub(crate) fn chords<X: Iteration>(&self, equation: &(impl Equation<T, D> + ?Sized)) -> Landing<T, D> {
        let n = &self.normal.gradient;
        let square = dot(n, n);
        let length = square.sqrt();
        let floor = T::from_f64(T::EPSILON) * size_along(n, length, &self.places());
        let (zero, half) = (T::from_f64(0.0), T::from_f64(0.5));

        let mut multiplier = self.guess;
        let (mut g, first_slope) = if X::KIND == Kind::Symmetric {
            let (g, gradient) = equation.value_and_gradient(&self.point(multiplier));
            (g, dot(&gradient, n))
        } else {
            let g = equation.value(&self.point(multiplier));
            (g, square)
        };
        let mut slope = first_slope;
        let (mut first_correction, mut before, mut last) = (zero, zero, zero);
        let mut converged = false;
        let mut at_end = None;
        for step in 0..MAX_CHORDS {
            let chord = -g / slope;
            let size = chord.abs() * length;
            let shrinks = if step == 0 { size.lt(T::from_f64(f64::INFINITY)) } else { size.le(half * last) };
            let mut arrived = size.le(floor);
            if !(shrinks | arrived) {
                break;
            }
            multiplier = multiplier + chord;
            first_correction = if step == 0 { size } else { first_correction };
            let earlier = if X::KIND == Kind::Broyden { before } else { last };
            let next = size * size / earlier; // none without an earlier one: 1/0, or 0/0
            at_end = None;
            if next.le(T::from_f64(SPARE) * floor) {
                let gradient = equation.gradient(&self.point(multiplier));
                let left = (T::from_f64(1.0) - dot(&gradient, n) / slope).abs() * size;
                arrived |= left.le(T::from_f64(SPARE) * floor);
                at_end = Some(gradient);
            }
            converged = arrived;
            if converged {
                break;
            }
            (before, last) = (last, size);
            let g_before = g;
            g = equation.value(&self.point(multiplier));
            if X::KIND == Kind::Broyden {
                slope = (g - g_before) / chord;
            }
        }
        let gradient = at_end.unwrap_or_else(|| equation.gradient(&self.point(multiplier)));
        let (increment, slopes) = (self.increment(multiplier), [first_slope, dot(&gradient, n)]);
        Landing { increment, multiplier, gradient, first_correction, slopes, floor, converged }
    }
}
