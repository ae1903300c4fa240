//! What the loops of a block read and write: parts of a step, numbers that need no keeping, and vectors by lane.

use crate::effect::moment::Moment;
use crate::kernel::functions::ConstraintKernel;
use crate::motion::failure::Failure;
use crate::number::lanes::Lane;
use crate::number::vector::{add_scaled, largest, sum};
use crate::run::ensemble::laws::Laws;
use crate::systems::surface::diagnosis::FailureAt;
use crate::systems::surface::normal::Normal;
use std::array::from_fn;
use std::borrow::Borrow;

/// Left to the last correction: so many ε of the largest coordinate.
pub(super) const AT_REST: f64 = 256.0;

/// Corrections of a lane, beyond those that all lanes have, before it is solved by itself.
pub(super) const CORRECTIONS: usize = 3;

/// Steps that are shorter would take digits from momenta that are kept times h.
pub(super) const SHORT: f64 = 1e-15;

/// D coordinates of L trajectories.
pub(super) type Vectors<S, const L: usize, const D: usize> = [[S; L]; D];

/// Numbers of one step, which need no keeping.
#[derive(Clone)]
#[repr(C, align(64))]
pub(crate) struct Scratch<S, const L: usize, const D: usize> {
    /// q + h p.
    pub(super) free: Vectors<S, L, D>,
    /// Λ₁, Λ₂, and at last Λ.
    pub(super) multiplier: [S; L],
    /// 1/s.
    pub(super) over_slope: [S; L],
    /// g₀, and then g₂, or not a number where the slope says that the surface may have been left.
    pub(super) g: [S; L],
}

impl<S: Lane, const L: usize, const D: usize> Scratch<S, L, D> {
    pub(crate) fn new() -> Self {
        let zero = [S::default(); L];
        Self { free: [zero; D], multiplier: zero, over_slope: zero, g: zero }
    }
}

/// One RATTLE step of a method.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Part {
    /// Its length.
    pub(super) h: f64,
    /// What momenta are kept times: h where all steps are equal, else 1.
    pub(super) unit: f64,
    /// The kick after it.
    pub(super) kick: f64,
    /// Λ of the step before it in terms of its own.
    pub(super) before: f64,
    /// By which Λ of this step and the last ones are extrapolated to the next, that of this one first.
    pub(super) weights: [f64; 3],
}

impl Part {
    pub(crate) fn length(&self) -> f64 {
        self.h
    }

    /// Whether all steps are of one length, and momenta kept times it.
    pub(crate) fn are_equal(parts: &[Part]) -> bool {
        parts.len() == 1 && parts[0].unit == parts[0].h
    }

    /// The parts of a method that takes RATTLE steps of these lengths in turn, again and again.
    ///
    /// Λ/h² is a smooth function of time. In steps of one length it is extrapolated quadratically. In steps of different
    /// lengths linearly, Λ taken to be that of a third of the step, unless that lies far away.
    pub(crate) fn of(lengths: &[f64]) -> Vec<Part> {
        let n = lengths.len();
        let at = |i: usize| lengths[i % n];
        let part = |i: usize| {
            let (before, h, next) = (at(i + n - 1), at(i), at(i + 1));
            let (last, earlier) = (h + next / 3.0 - h / 3.0, before + h / 3.0 - before / 3.0);
            let far = last / earlier;
            let far = if far.abs() <= 2.0 { far } else { 0.0 };
            let linear = [(1.0 + far) * (next / h).powi(2), -far * (next / before).powi(2), 0.0];
            let equal = n == 1 && h.abs() >= SHORT;
            let weights = if n == 1 { [3.0, -3.0, 1.0] } else { linear };
            let unit = if equal { h } else { 1.0 };
            Part { h, unit, kick: 0.5 * (h + next), before: (before / h).powi(2), weights }
        };
        (0..n).map(part).collect()
    }
}

/// A lane that cannot be moved, and why.
pub(crate) struct Stuck {
    pub(crate) lane: usize,
    pub(crate) failure: Failure,
}

/// The sum of the components.
#[inline(always)]
pub(super) fn total<S: Lane, const D: usize>(x: &[S; D]) -> S {
    let mut sum = x[0];
    for &component in &x[1..] {
        sum = sum + component;
    }
    sum
}

/// Neither infinite nor NaN.
#[inline(always)]
pub(super) fn is_finite<S: Lane>(x: S) -> bool {
    let zero = x * S::default(); // or NaN
    zero.le(zero)
}

#[inline(always)]
pub(super) fn at<S: Copy, const L: usize, const D: usize>(vectors: &Vectors<S, L, D>, lane: usize) -> [S; D] {
    from_fn(|d| vectors[d][lane])
}

#[inline(always)]
pub(super) fn put<S: Copy, const L: usize, const D: usize>(
    vectors: &mut Vectors<S, L, D>,
    lane: usize,
    x: [S; D],
) {
    for d in 0..D {
        vectors[d][lane] = x[d];
    }
}

/// x + c·y; x + y where steps are equal.
#[inline(always)]
pub(super) fn plus<S: Lane, const D: usize, const EQUAL: bool>(x: &[S; D], c: S, y: &[S; D]) -> [S; D] {
    if EQUAL { sum(x, y) } else { add_scaled(x, c, y) }
}

/// q′ − q without the constraint, beyond the way of a step: what sums have kept back.
#[inline(always)]
pub(super) fn kept_back<S: Lane, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool>(
    share: S,
    q_low: &[Vectors<S, L, D>; SUMS],
    way_low: &[Vectors<S, L, D>; SUMS],
    lane: usize,
) -> [S; D] {
    if SUMS == 0 {
        return [S::default(); D];
    }
    plus::<S, D, EQUAL>(&at(&q_low[0], lane), share, &at(&way_low[0], lane))
}

/// What |g| may be at rest: `AT_REST` ε |q|∞ |∇g|∞, for |∇g| and |q| to a factor of √3 in space.
#[inline(always)]
pub(super) fn at_rest<S: Lane, const D: usize>(gradient: &[S; D], q: &[S; D]) -> S {
    S::from_f64(AT_REST * S::EPSILON) * largest(gradient) * largest(q)
}

pub(super) type Of<'a, S, const L: usize, const D: usize, const SUMS: usize> =
    (&'a mut [Vectors<S, L, D>; SUMS], &'a mut [Vectors<S, L, D>; SUMS]);

/// Why a lane's momentum is not finite.
#[cold]
#[inline(never)]
pub(super) fn not_finite<S: Lane, const D: usize>(laws: &impl Laws<S, D>, lane: usize, q: [S; D]) -> Failure {
    let [gradient] = laws.constraint(lane).borrow().jacobian(&q);
    let at = Moment { time: 0.0, positions: &[q] };
    FailureAt::of(0, false).not_finite(laws.effects(lane).borrow(), at, &[Normal::new(gradient)])
}
