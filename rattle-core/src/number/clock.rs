//! Times as compensated sums: each with its rounding error.

use crate::number::vector::two_sum;

/// How long so many steps of length h take, and what rounding took from that.
#[allow(clippy::cast_precision_loss, reason = "exact up to 2⁵³ steps")]
pub(crate) fn passed(steps: u64, h: f64) -> (f64, f64) {
    let passed = steps as f64 * h;
    (passed, (steps as f64).mul_add(h, -passed))
}

/// The time so many steps after another.
pub(crate) fn after_steps(start: (f64, f64), steps: u64, h: f64) -> (f64, f64) {
    later(start, passed(steps, h))
}

/// A time and what rounding took from it, and another, added.
#[inline(always)]
pub(crate) fn later(time: (f64, f64), passed: (f64, f64)) -> (f64, f64) {
    let ([high], [low]) = two_sum(&[time.0], &[passed.0]);
    let ([high], [low]) = two_sum(&[high], &[low + (time.1 + passed.1)]);
    (high, low)
}

/// A step that is gone in parts: the time that has come, and how much is left. Both are compensated sums: parts of one
/// length are rounded alike, and what each of them loses would add up.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Parts {
    time: (f64, f64),
    left: (f64, f64),
}

impl Parts {
    /// Of a step h from this time on, none of which is gone.
    pub(crate) fn of(h: f64, time: f64) -> Self {
        Self { time: (time, 0.0), left: (h, 0.0) }
    }

    /// The time that has come.
    pub(crate) fn time(&self) -> f64 {
        self.time.0
    }

    /// How much of the step is left.
    pub(crate) fn left(&self) -> f64 {
        self.left.0
    }

    /// Goes a part of this length.
    pub(crate) fn go(&mut self, part: f64) {
        self.time = later(self.time, (part, 0.0));
        self.left = later(self.left, (-part, 0.0));
    }
}

/// How many steps of h lead from here to that time or less than one beyond it, which is none where this is not above 0.
/// A time that is a whole number of steps away, to a millionth of a step or the rounding of both times, is reached by
/// that number; to half a step where steps are shorter than times are rounded.
pub(crate) fn steps_to(time: f64, now: f64, h: f64) -> f64 {
    let rounding = 4.0 * f64::EPSILON * (time.abs().max(now.abs()) / h).abs();
    let near = 1e-6_f64.max(rounding).min(0.5);
    ((time - now) / h - near).ceil()
}
