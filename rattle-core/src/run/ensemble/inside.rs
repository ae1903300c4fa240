//! Whether a step of a lane that did not follow its root may have ended on another sheet.

use crate::kernel::functions::ConstraintKernel;
use crate::number::lanes::Lane;
use crate::number::vector::{add_scaled, dot, largest, scaled, sum};
use crate::run::ensemble::laws::Laws;
use crate::solve::aim::{INSIDE, OFF_INSIDE, ROUNDINGS};
use std::array::from_fn;
use std::borrow::Borrow;

/// How far a step may have led astray, and whether g is as small as along one sheet on the curve through both ends with
/// their momenta and accelerations, see [`check_sheets`](crate::motion::system::System::check_sheets). From a place
/// with its momentum and acceleration; the way from there, momentum, normal and acceleration at the end; the size of
/// places.
#[inline(always)]
pub(super) fn follows<S: Lane, const D: usize>(
    laws: &impl Laws<S, D>,
    lane: usize,
    h: S,
    [from, p, pull]: [[S; D]; 3],
    [way, p_end, normal, pull_end]: [[S; D]; 4],
    size: S,
) -> (S, bool) {
    let [half, two, three] = [0.5, 2.0, 3.0].map(S::from_f64);
    let half_square = half * h * h;
    let [first, last] = [scaled(h, &p), scaled(h, &p_end)];
    let off = largest(&add_scaled(&way, -half, &sum(&first, &last)));
    // Half of what the accelerations at both ends are beyond those of the cubic.
    let at_first: [S; D] = from_fn(|d| two.multiply_add(first[d], last[d]) - three * way[d]);
    let at_last: [S; D] = from_fn(|d| three * way[d] - two.multiply_add(last[d], first[d]));
    let at_first = add_scaled(&at_first, half_square, &pull);
    let at_last = add_scaled(&at_last, half_square, &pull_end);
    let most = S::from_f64(OFF_INSIDE).multiply_add(off, S::from_f64(ROUNDINGS * S::EPSILON) * size);
    let most = most * most * dot(&normal, &normal);
    let mut plain = true;
    for s in INSIDE {
        let r = 1.0 - s;
        let [a, b, c, d, e] =
            [s * s * (3.0 - 2.0 * s), s * r * r, -r * s * s, s * s * r * r * r, s * s * s * r * r]
                .map(S::from_f64);
        let place = add_scaled(&add_scaled(&add_scaled(&from, a, &way), b, &first), c, &last);
        let place = add_scaled(&add_scaled(&place, d, &at_first), e, &at_last);
        let [g] = laws.constraint(lane).borrow().value(&place);
        plain &= (g * g).le(most);
    }
    (off, plain)
}
