//! Whether a step has passed a singular point: straight on, with a normal that reverses.
//!
//! On a smooth surface a normal reverses only together with the motion, or gradually on the way, as along a twisted
//! strip. Through the apex of a cone the motion goes straight on, and the normal is constant up to the apex and
//! opposite after it. So a part of the step with opposite normals at its ends is halved; at a singular point one of the
//! halves always has opposite normals again.

use crate::error::StepFailure;
use crate::kernel::functions::ConstraintKernel;
use crate::motion::bodies::Body;
use crate::motion::failure::{Failure, numbers};
use crate::number::real::Scalar;
use crate::number::vector::dot;
use std::array::from_fn;

/// Halvings of a step: a singular point is passed within a sixteenth of it. A strip may twist four times in one.
const HALVINGS: usize = 4;

/// Looks for a singular point between two places of a body, a time h apart, at which normals are opposed.
#[cold]
#[inline(never)]
pub(super) fn check<T: Scalar, K: ConstraintKernel<T, D, 1>, const D: usize>(
    constraint: &K,
    h: f64,
    body: usize,
    ends: [Body<T, D>; 2],
) -> Result<(), Failure> {
    let ([from, to], zero) = (&ends, T::from_f64(0.0));
    let place = |s: f64| between(h, from, to, s);
    let normal = |s: f64| {
        let [gradient] = constraint.jacobian(&place(s));
        gradient
    };
    let (mut start, mut end) = ((0.0, normal(0.0)), (1.0, normal(1.0)));
    for _ in 0..HALVINGS {
        let middle = 0.5 * (start.0 + end.0);
        let there = (middle, normal(middle));
        if dot(&start.1, &there.1).le(zero) {
            end = there;
        } else if dot(&there.1, &end.1).le(zero) {
            start = there;
        } else {
            return Ok(());
        }
    }
    let (share, gradient) = if dot(&start.1, &start.1).lt(dot(&end.1, &end.1)) { start } else { end };
    let (position, gradient) = (numbers(&place(share)), numbers(&gradient));
    Err(Failure { body, cause: StepFailure::NoNormal { position, gradient } })
}

/// Hermite's cubic through places and momenta at the two ends of a step.
#[inline(always)]
pub(super) fn between<T: Scalar, const D: usize>(
    h: f64,
    from: &Body<T, D>,
    to: &Body<T, D>,
    s: f64,
) -> [T; D] {
    let r = 1.0 - s;
    let [a, b, c, d] =
        [r * r * (1.0 + 2.0 * s), s * s * (1.0 + 2.0 * r), h * s * r * r, -h * r * s * s].map(T::from_f64);
    from_fn(|i| a * from.q[i] + b * to.q[i] + c * from.p[i] + d * to.p[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cubic is fixed by its places and slopes at two ends. All numbers are binary fractions, so equality is exact.
    #[test]
    fn the_curve_is_a_cubic_where_the_way_is_one() {
        let way = |t: f64| ([1.0 + t * (2.0 + t * (3.0 + t * 5.0))], [2.0 + t * (6.0 + t * 15.0)]);
        let [from, to] = [0.0, 0.5].map(|t| {
            let (q, p) = way(t);
            Body { q, q_low: [0.0], p, p_low: [0.0] }
        });
        for s in [0.0, 0.25, 0.5, 0.75, 1.0] {
            assert_eq!(between(0.5, &from, &to, s), way(0.5 * s).0, "at {s} of the step");
        }
    }
}
