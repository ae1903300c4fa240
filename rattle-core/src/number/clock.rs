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

/// How many steps of h lead from here to that time or less than one beyond it, which is none where this is not above 0.
/// A time that is a whole number of steps away, to a millionth of a step or the rounding of both times, is reached by
/// that number; to half a step where steps are shorter than times are rounded.
pub(crate) fn steps_to(time: f64, now: f64, h: f64) -> f64 {
    let rounding = 4.0 * f64::EPSILON * (time.abs().max(now.abs()) / h).abs();
    let near = 1e-6_f64.max(rounding).min(0.5);
    ((time - now) / h - near).ceil()
}
