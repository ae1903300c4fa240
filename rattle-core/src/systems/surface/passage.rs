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
use crate::solve::curve::cubic;

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
    let place = |s: f64| cubic(h, s, [&from.q, &to.q], [&from.p, &to.p]);
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
