//! Which root of a position equation continues the motion, and how that root is followed.
//!
//! A path may meet the constraints more than once; the motion continues on the root that starts from Λ = 0 at h = 0.
//! The root found by an iteration is trusted to be this one if
//!
//! * normals are not turned over ("upright"), and either
//! * the error of the first guess is a small part of the path, and the path is short compared with the length on which
//!   normals change; or
//! * normals do not change at all ("straight").
//!
//! A root that is not trusted is followed from h = 0: the position equation is solved for parts of the step, which are
//! halved until each root found is trusted. Where even very short parts do not suffice, the root ends, or turns too
//! sharply to be followed. `optimised/tests/hard_cases.rs` takes random steps with h·κ·|v| up to 3 on several surfaces,
//! and `optimised/tests/linked_roots.rs` of double pendulums: none ends on another root.

use crate::number::real::{Real, Scalar};
use crate::number::vector::dot;

/// A first correction longer than this part of the path is too far …
pub(crate) const FAR_GUESS: f64 = 0.02;

/// … and while a root is followed, longer than this part of the path: first guesses are then extrapolations.
pub(crate) const FAR_EXTRAPOLATION: f64 = 0.1;

/// A path is short up to this part of the length on which normals change.
pub(crate) const SHORT_PATH: f64 = 0.5;

/// What [`straight`] is in double precision: well above rounding, and 10⁷ corrections make a bend.
const STRAIGHT: f64 = 1e-7;

/// A slope at a root differs by less than this factor from that where the step began. Where forces displace a body by
/// more than 10¹² of its place, the rounding of that way is all that a solve can tell, and it may end anywhere.
const ALIKE: f64 = 1e3;

/// The smallest part of a step in which a root is followed.
const SMALLEST_PART: f64 = 1.0 / 4096.0;

/// Parts, taken or halved, after which a root is given up.
const MAX_PARTS: usize = 200;

/// A relative change of normals below this is none: 1e-7, or what is well above rounding where that is coarser.
pub(crate) const fn straight<T: Scalar>() -> f64 {
    if STRAIGHT > 64.0 * T::EPSILON { STRAIGHT } else { 64.0 * T::EPSILON }
}

/// Whether a slope is that of a surface upright, and no other surface altogether than where it was `square`.
#[inline(always)]
pub(crate) fn is_upright<T: Scalar>(slope: T, square: T) -> bool {
    (T::from_f64(1.0 / ALIKE) * square).lt(slope) & slope.le(T::from_f64(ALIKE) * square)
}

/// Whether the root found along a line is trusted, from the slopes g′ = ∇g·∇g(q) where the step began, at the first
/// guess, and at the root.
///
/// `off_square` is the square of the first correction, `path_square` that of the path, both lengths; `far` is
/// [`FAR_GUESS`] or [`FAR_EXTRAPOLATION`].
#[inline(always)]
pub(crate) fn is_the_root<T: Scalar>(
    off_square: T,
    [square, first, slope]: [T; 3],
    path_square: T,
    far: f64,
) -> bool {
    let change = (slope - first) / slope; // of no unit: g may be scaled by any number
    let change_square = change * change;
    let near_guess = off_square.le(T::from_f64(far * far) * path_square);
    let short_path = (change_square * path_square).le(T::from_f64(SHORT_PATH * SHORT_PATH) * off_square);
    let straight = change_square.le(T::from_f64(straight::<T>() * straight::<T>()));
    is_upright(slope, square) & (straight | (near_guess & short_path))
}

/// A part of a step, from one share of the step to another.
#[derive(Clone, Copy)]
pub(crate) struct Part<T> {
    /// The share of the step where the part ends: s in q + s·drift + s²·push.
    pub(crate) end: T,
    /// How much of the step the part is.
    pub(crate) length: T,
}

impl<T: Scalar> Part<T> {
    /// The first share of it.
    #[inline(always)]
    pub(crate) fn until(&self, share: f64) -> Self {
        let length = T::from_f64(share) * self.length;
        Self { end: self.end - self.length + length, length }
    }
}

/// Follows a root from h = 0 to the end of the step. `attempt` solves for one part, and remembers what it finds if it
/// trusts that, which it says. True if the end is reached.
#[inline(always)]
pub(crate) fn follow<T: Scalar>(mut attempt: impl FnMut(&Part<T>) -> bool) -> bool {
    let (zero, one, half) = (T::from_f64(0.0), T::from_f64(1.0), T::from_f64(0.5));
    let (mut s, mut part) = (zero, half);
    for _ in 0..MAX_PARTS {
        if one.le(s) || part.lt(T::from_f64(SMALLEST_PART)) {
            break;
        }
        let end = (s + part).min(one);
        if attempt(&Part { end, length: end - s }) {
            (s, part) = (end, part + part);
        } else {
            part = half * part;
        }
    }
    one.le(s)
}

/// A number sought along the step: Λ(s) = guess·s² + excess, the excess extrapolated linearly from part to part.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Course<T> {
    excess: T,
    rate: T,
}

impl<T: Scalar> Course<T> {
    /// Before the first part: the excess is 0 and stays so.
    pub(crate) fn start() -> Self {
        Self { excess: T::from_f64(0.0), rate: T::from_f64(0.0) }
    }

    /// What is to be expected at the end of a part.
    pub(crate) fn ahead(&self, guess: T, part: &Part<T>) -> T {
        guess * part.end * part.end + self.excess + self.rate * part.length
    }

    /// Notes what was found there.
    pub(crate) fn note(&mut self, guess: T, part: &Part<T>, found: T) {
        let excess = found - guess * part.end * part.end;
        self.rate = (excess - self.excess) / part.length;
        self.excess = excess;
    }
}

/// cos² of the angle between two normals; 0 where it is obtuse. However they are scaled, it is a number.
#[inline(always)]
pub(crate) fn alike<T: Real, const D: usize>(a: &[T; D], b: &[T; D]) -> T {
    let product = dot(a, b);
    let square = (product / dot(a, a)) * (product / dot(b, b));
    T::select(T::from_f64(0.0).lt(product), square, T::from_f64(0.0))
}

/// Normals of neighbouring stages are more [alike] than that: they turn by less than 60°. Else there is an edge between
/// them, sharp or not, of which the stages know nothing.
pub(crate) const STAGES_ALIKE: f64 = 0.25;
