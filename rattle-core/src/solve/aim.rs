//! The errors of the first guesses in earlier steps, which show whether a step has jumped over a sheet of the
//! constraint.
//!
//! Where g oscillates, sheets of {g = 0} with the same orientation lie next to each other, and a guess whose error is
//! the distance of two sheets lands on the wrong one. There g, ∇g and second derivatives are like those of the right
//! sheet, and the first correction is nearly zero: nothing at the two ends of the step shows the mistake. But the error
//! of a guess changes smoothly from step to step, like (λ₁ − λ₀) h²/6. So a step is accepted if the error of its guess
//! is as expected from the steps before. Any other step, the first one too, is examined *inside*: at the fraction s of
//! the step the error of the guess must be between s³ and s⁴ of the error at the end. Otherwise the root is followed
//! from h = 0.
//!
//! Examining a step changes no bit of a root that is right. So steps remain functions of the state, whatever errors are
//! remembered here, and a state need not hold them. But a root that was right and looked wrong is followed to the same
//! point with other rounding errors, and alike components of links go side by side only where errors are remembered; so
//! a checkpoint, from which a run continues to the last bit, holds the remembered errors.

use crate::error::Error;
use crate::kernel::rounding::{FOLLOWED, GROWS, NOISY};
use crate::motion::record::{Reading, Record};
use crate::number::real::Scalar;
use crate::solve::crowd::there;

/// A guess is off as usual if what it is off by differs from what the last two let expect by at most this part of
/// the larger of them.
/// Of sheets at a distance d, those two were off by less than d/2, or the root would have been another. So a step is
/// taken at its word if it is off what is expected by less than d/4: and one on the next sheet is off by d.
const CHANGE: f64 = 0.5;

/// Where the slope of g at the guess is not known, nor by more than this part, divided by the angle by which the normal
/// turns: in long steps what guesses are off by changes by as much as sheets are apart, and may be as expected by
/// chance.
const CHANGE_BY_TURN: f64 = 0.05;

/// Where it turns by more than this angle nothing is taken for usual.
const MOST_TURN: f64 = 0.3;

/// Where normals turn by more than this angle in a step, the steps before say little of what is usual.
pub(crate) const SMOOTH: f64 = 0.1;

/// What is off by less than so many roundings of the position is off by rounding: no sheets lie so close.
pub(crate) const ROUNDINGS: f64 = 64.0;

/// What is off by more than so many times the rounding of positions is off by more than that of g.
pub(crate) const LITTLE: f64 = 1e4;

/// Where nothing is known of how large a surface is, terms of g are taken to be at most so many times as large as
/// places on it.
pub(crate) const LARGER: f64 = 4_294_967_296.0;

/// What may be taken for the rounding of g, as a distance, where nothing is known of its terms, which may be larger
/// than places of this size: as near the origin of a large sphere through it. `rounding` tells what it is where places
/// are moved by some roundings of a size, which grows until g follows. Nothing where it never does, as that of waves,
/// which is bent too much.
pub(crate) fn noise_of_terms<T: Scalar>(size: f64, mut rounding: impl FnMut(f64) -> f64) -> f64 {
    let mut times = 1.0;
    while times <= LARGER {
        let (size, found) = (times * size, rounding(times * size));
        if found <= FOLLOWED * T::EPSILON * size {
            return (NOISY * found).min(there::<T>() * size);
        }
        times *= GROWS;
    }
    0.0
}

/// Where it is looked inside a step: two places far apart in phase, for sheets at any distance.
pub(crate) const INSIDE: [f64; 2] = [std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::SQRT_2 - 1.0];

/// What a guess for a whole step is off by there, as a part of what it is off by at the end, is between these powers of
/// the share.
pub(crate) const GROWTH: [u32; 2] = [3, 4];

/// The same for a part of a step. What is not smooth at one place grows late; that it grows at all is asked at one
/// share, or halving would never end.
pub(crate) const INSIDE_PARTS: [(f64, [u32; 2]); 2] = [(INSIDE[0], [1, 4]), (INSIDE[1], [1, 64])];

/// Where a root is followed, what is off by less than this part of what the guess for the whole step was off by is off
/// by nothing.
pub(crate) const LITTLE_OFF: f64 = 1.0 / 64.0;

/// Of a method that has no guess: on a curve through the two ends of a step g is, as a length, less than this part of
/// what the step may have led astray. Between two sheets, side by side, it is a tenth.
pub(crate) const OFF_INSIDE: f64 = 1.0 / 64.0;

/// Such a step that led astray by more than this part of its path is walked. On a circle that are steps of more than
/// 1.1 radians.
pub(crate) const BOLD: f64 = 0.1;

/// What is found inside may be so many times as much, or as little, as it should be.
const TIMES: f64 = 3.0;

/// What is expected of a step, from the last two: their offs go with h³, along a straight line.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pace {
    /// The lengths of the last two steps.
    pub(crate) steps: [f64; 2],
}

impl Pace {
    /// Before the first step.
    pub(crate) fn unknown() -> Self {
        Self { steps: [f64::NAN; 2] }
    }

    /// Writes the lengths of the last two steps, and what so many guesses were off by.
    #[inline(never)]
    pub(crate) fn record<T: Scalar>(
        &self,
        number: usize,
        aims: &mut dyn Iterator<Item = &Aim<T>>,
        to: &mut Record,
    ) {
        to.list("lengths of the last steps", &self.steps);
        let mut offs = Vec::with_capacity(2 * number);
        for aim in aims {
            offs.extend([aim.last, aim.before].map(|off| off.to_f64()));
        }
        to.numbers("guesses were off by", &[number, 2], offs);
    }

    /// Reads both.
    #[inline(never)]
    pub(crate) fn recall<T: Scalar>(
        number: usize,
        aims: &mut dyn Iterator<Item = &mut Aim<T>>,
        from: &mut Reading<'_>,
    ) -> Result<Self, Error> {
        let steps = from.array("lengths of the last steps")?;
        let offs: &[[f64; 2]] = from.vectors("guesses were off by", number)?;
        for (aim, off) in aims.zip(offs) {
            let [last, before] = off.map(T::from_f64);
            *aim = Aim { last, before };
        }
        Ok(Self { steps })
    }

    /// Of a step of length h: by how much the last off, and the one before, count.
    #[inline(always)]
    pub(crate) fn weights(&self, h: f64) -> [f64; 2] {
        let [last, before] = self.steps.map(|step| h / step);
        [2.0 * (last * last * last), -(before * before * before)]
    }

    /// Notes the length of a step.
    #[inline(always)]
    pub(crate) fn note(&mut self, h: f64) {
        self.steps = [h, self.steps[0]];
    }
}

/// How far first guesses of one body were off in the last two steps; NaN where the root had to be followed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Aim<T> {
    pub(crate) last: T,
    pub(crate) before: T,
}

impl<T: Scalar> Aim<T> {
    /// Nothing is known: the next steps are looked at.
    pub(crate) fn unknown() -> Self {
        let nan = T::from_f64(f64::NAN);
        Self { last: nan, before: nan }
    }

    /// Whether the guess of this step was off as usual, with these [weights](Pace::weights).
    #[inline(always)]
    pub(crate) fn is_usual(&self, off: T, weights: [f64; 2]) -> bool {
        let (change, most) = self.change(off, weights);
        change.abs().le(T::from_f64(CHANGE) * most)
    }

    /// The same, where the slope of g at the guess is not known, and the normal turns by an angle of this square.
    #[inline(always)]
    pub(crate) fn is_usual_after_turn(&self, off: T, weights: [f64; 2], angle_square: T) -> bool {
        let (change, most) = self.change(off, weights);
        let most = T::from_f64(CHANGE_BY_TURN) * most;
        let is_short = angle_square.le(T::from_f64(MOST_TURN * MOST_TURN));
        self.is_usual(off, weights) & is_short & (angle_square * change * change).le(most * most)
    }

    /// By how much what a guess was off by differs from what is expected, and the larger one of the two before.
    #[inline(always)]
    fn change(&self, off: T, weights: [f64; 2]) -> (T, T) {
        let (Self { last, before }, [a, b]) = (*self, weights.map(T::from_f64));
        (off - (a * last + b * before), last.abs().max(before.abs()))
    }

    /// Notes what a guess was off by.
    #[inline(always)]
    pub(crate) fn note(&mut self, off: T) {
        *self = Self { last: off, before: self.last };
    }
}

/// Whether what a guess is off by after the share `s` of a way is what it should be, if it is off by `end` at the
/// end and that grows
/// with a power of s between these; give or take `rounding`.
#[inline(always)]
pub(crate) fn grows_to<T: Scalar>(inside: T, end: T, s: f64, [least, most]: [u32; 2], rounding: T) -> bool {
    let (inside, size) = (T::select(end.lt(T::from_f64(0.0)), -inside, inside), end.abs());
    let power = |n: u32| (0..n).fold(1.0, |product, _| product * s);
    let [low, high] = [power(most) / TIMES, power(least) * TIMES].map(T::from_f64);
    (low * size - rounding).le(inside) & inside.le(high * size + rounding)
}
