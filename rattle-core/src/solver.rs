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
//! **Stopping.** Corrections are measured as displacements δ = |ΔΛ| |∇g(q)|, so the rule does not
//! know how g is scaled, and their floor is the rounding error ε·ℓ of the sum that forms q′, with ℓ
//! the larger of |q|∞ and |free|∞. With γ = δ₂/δ₁ the next correction is about γ²δ₂. Once that is below
//! a sixteenth of the floor the solve ends without another evaluation of g; otherwise it goes on until
//! a correction is at the floor, or no longer shrinks within 10⁴ of it (an expression that rounds badly).
//!
//! **Which root.** The line may meet the surface more than once; the motion continues on the root that starts
//! from Λ = 0 at h = 0. The root found is taken for that one if the guess was off by less than a fiftieth of the
//! path, and the path is short against the length on which g bends along the line, δ₁/(g₁/g₀). Otherwise, or where no
//! root was found, the root is followed from h = 0 in small steps, and found that way or not at all.

use crate::bodies::Normal;
use crate::kernel::ConstraintKernel;
use crate::real::{Mask, Real};
use crate::vector::{add_scaled, dot, largest, scaled, sum};
use std::array::from_fn;

/// A start may lie this far off the surface, relative to its largest coordinate, and its momentum this
/// far off the tangent plane, as a sine: well above rounding, well below any error of a method.
pub const START_TOLERANCE: f64 = 1e-10;

/// A first correction longer than this part of the path makes the root be followed from h = 0 …
const FAR_GUESS: f64 = 0.02;

/// … and so does a path longer than this part of the length on which g bends. With both, none of 110 000 steps from
/// random states with h·κ·|v| up to 3 went astray (`tests/hard_cases.rs` repeats 10 000); with the first alone, 5 did.
const LONG_PATH: f64 = 0.25;

/// Steps in which a root is followed.
const FOLLOWED_STEPS: u32 = 256;

/// Cycles of two corrections after which a solve is given up; four suffice where one exists.
const MAX_CYCLES: usize = 12;

/// One body at the start of a step, and where it would go without the constraint.
#[derive(Clone, Copy)]
pub(crate) struct Departure<'a, T, const D: usize> {
    pub(crate) q: &'a [T; D],
    pub(crate) q_low: &'a [T; D],
    pub(crate) normal: &'a Normal<T, D>,
    /// q′ − q without the constraint.
    pub(crate) free: [T; D],
    /// First guess of Λ.
    pub(crate) guess: T,
}

/// Where the body lands on the constraint.
pub(crate) struct Landing<T: Real, const D: usize> {
    /// q′ − q.
    pub(crate) increment: [T; D],
    /// Λ.
    pub(crate) multiplier: T,
    /// ∇g(q′).
    pub(crate) gradient: [T; D],
    /// Length δ₁ of the first correction: how far off the guess was.
    pub(crate) first_correction: T,
    /// |g₁/g₀| for that correction; zero where g₁ was rounding.
    pub(crate) first_ratio: T,
    /// Corrections at or below this length count as converged.
    pub(crate) floor: T,
    /// Whether the equation was solved to the floor.
    pub(crate) converged: T::Mask,
}

impl<T: Real, const D: usize> Departure<'_, T, D> {
    #[inline(always)]
    fn increment(&self, multiplier: T) -> [T; D] {
        add_scaled(&self.free, multiplier, &self.normal.gradient)
    }

    #[inline(always)]
    pub(crate) fn point(&self, multiplier: T) -> [T; D] {
        sum(self.q, &sum(self.q_low, &self.increment(multiplier)))
    }

    /// Whether the root found is without doubt the one that the motion continues on.
    #[inline(always)]
    pub(crate) fn trusts(&self, landing: &Landing<T, D>) -> T::Mask {
        let path_square = dot(&self.free, &self.free);
        let slack = T::from_f64(START_TOLERANCE) * largest(self.q);
        let off_square = landing.first_correction * landing.first_correction;
        let near_guess = off_square.le(T::from_f64(FAR_GUESS * FAR_GUESS) * path_square + slack * slack);
        let bend_square = landing.first_ratio * landing.first_ratio * path_square;
        let short_path = bend_square.le(T::from_f64(LONG_PATH * LONG_PATH) * off_square);
        let upright = T::from_f64(0.0).lt(dot(&self.normal.gradient, &landing.gradient));
        landing.converged.and(near_guess).and(short_path).and(upright)
    }

    /// The landing that is reached from h = 0 without leaving the root: the position equation with `drift` s and
    /// `push` s², solved for s = 0 … 1 in turn. Not converged where the root ends on the way: where the normal turns
    /// over, or the correction to the extrapolated root is longer than half the path between.
    #[cold]
    #[inline(never)]
    pub(crate) fn follow<K: ConstraintKernel<T, D, 1>>(
        &self,
        constraint: &K,
        drift: &[T; D],
        push: &[T; D],
    ) -> Landing<T, D> {
        let n = &self.normal.gradient;
        let (zero, part) = (T::from_f64(0.0), T::from_f64(1.0 / f64::from(FOLLOWED_STEPS)));
        let half_path = T::from_f64(0.5) * part * dot(&self.free, &self.free).sqrt();
        let allowed = half_path + T::from_f64(START_TOLERANCE) * largest(self.q);
        let length = dot(n, n).sqrt();
        let (mut multiplier, mut change) = (zero, zero);
        let mut on_root = zero.le(zero);
        for step in 1..=FOLLOWED_STEPS {
            let s = part * T::from_f64(f64::from(step));
            let on_the_way = Self { free: add_scaled(&scaled(s, drift), s * s, push), ..*self };
            let before = multiplier;
            multiplier = multiplier + change;
            for _ in 0..2 {
                let ([g], [gradient]) = constraint.value_and_jacobian(&on_the_way.point(multiplier));
                let slope = dot(&gradient, n);
                let correction = -g / slope;
                multiplier = multiplier + correction;
                on_root = on_root.and(zero.lt(slope)).and((correction.abs() * length).le(allowed));
            }
            change = multiplier - before;
        }
        let mut landing = Self { guess: multiplier, ..*self }.land(constraint, |_| ());
        on_root = on_root.and(zero.lt(dot(&landing.gradient, n)));
        landing.converged = landing.converged.and(on_root);
        landing
    }

    /// Solves for Λ; `correction` is told every correction's length.
    #[inline(always)]
    pub(crate) fn land<K: ConstraintKernel<T, D, 1>>(
        &self,
        constraint: &K,
        mut correction: impl FnMut(T),
    ) -> Landing<T, D> {
        let n = &self.normal.gradient;
        let length = dot(n, n).sqrt();
        let floor = T::from_f64(f64::EPSILON) * largest(self.q).max(largest(&self.free));
        let (zero, half) = (T::from_f64(0.0), T::from_f64(0.5));

        let mut multiplier = self.guess;
        let mut last = T::from_f64(f64::INFINITY);
        let mut converged = zero.lt(zero);
        let mut gradient = *n;
        let mut first_cycle = None;
        for _ in 0..MAX_CYCLES {
            let ([g], [at_point]) = constraint.value_and_jacobian(&self.point(multiplier));
            gradient = at_point;
            let slope = dot(&gradient, n);
            let newton = -g / slope;
            let first = newton.abs() * length;
            correction(first);
            let stalled = (half * last).le(first).and(first.le(T::from_f64(1e4) * floor));
            converged = converged.or(first.le(floor)).or(stalled);
            if converged.all() {
                break;
            }
            multiplier = multiplier + T::select(converged, zero, newton);

            let [g_next] = constraint.value(&self.point(multiplier));
            let ratio = g_next / g;
            first_cycle.get_or_insert((first, ratio.abs()));
            let near = ratio.abs().lt(T::from_f64(0.25)); // else the parabola says nothing yet
            let ostrowski = -g_next / (slope * (T::from_f64(1.0) - T::from_f64(2.0) * ratio));
            let ostrowski = T::select(near.and(converged.not()), ostrowski, zero);
            multiplier = multiplier + ostrowski;
            let second = ostrowski.abs() * length;
            correction(second);
            let shrinking = second / first;
            let next = second * shrinking * shrinking;
            converged = converged.or(near.and((T::from_f64(16.0) * next).le(floor)));
            if converged.all() {
                [gradient] = constraint.jacobian(&self.point(multiplier));
                break;
            }
            last = T::select(near, second, first);
            if !first.le(T::from_f64(f64::MAX)).or(converged).all() {
                break; // NaN or infinite: no cycle can mend it
            }
        }
        // Converged at the guess itself: nothing was corrected.
        let (first_correction, ratio) = first_cycle.unwrap_or((zero, zero));
        let above_rounding = (T::from_f64(16.0) * floor).lt(ratio * first_correction);
        let first_ratio = T::select(above_rounding, ratio, zero);
        let increment = self.increment(multiplier);
        Landing { increment, multiplier, gradient, first_correction, first_ratio, floor, converged }
    }
}

/// λ from the second derivative of g along the motion, g̈ = vᵀ∇²g v + ∇g·q̈ = 0 with q̈ = f + ∇g λ.
#[inline(always)]
pub(crate) fn multiplier_from_curvature<T: Real, const D: usize>(
    bend: T,
    force_along_normal: T,
    normal: &Normal<T, D>,
) -> T {
    -(bend + force_along_normal) * normal.inverse_square
}

impl<T: Real, const D: usize> Landing<T, D> {
    /// This landing where the mask is true, `other` elsewhere.
    pub(crate) fn or(self, mask: T::Mask, other: Self) -> Self {
        let choose = |a: T, b: T| T::select(mask, a, b);
        Self {
            increment: from_fn(|i| choose(self.increment[i], other.increment[i])),
            multiplier: choose(self.multiplier, other.multiplier),
            gradient: from_fn(|i| choose(self.gradient[i], other.gradient[i])),
            first_correction: choose(self.first_correction, other.first_correction),
            first_ratio: choose(self.first_ratio, other.first_ratio),
            floor: self.floor,
            converged: mask.or(other.converged),
        }
    }
}

impl<T: Real, const D: usize> Normal<T, D> {
    /// The normal with gradient ∇g.
    #[inline(always)]
    pub(crate) fn new(gradient: [T; D]) -> Self {
        Self { gradient, inverse_square: T::from_f64(1.0) / dot(&gradient, &gradient) }
    }

    /// η and ∇g η such that p + ∇g η is tangent.
    #[inline(always)]
    pub(crate) fn projection(&self, p: &[T; D]) -> (T, [T; D]) {
        let eta = -dot(&self.gradient, p) * self.inverse_square;
        (eta, scaled(eta, &self.gradient))
    }
}
