//! Whether a step of a lane that did not follow its root may have ended on another sheet.

use crate::kernel::functions::ConstraintKernel;
use crate::motion::course::JUMP;
use crate::number::lanes::Lane;
use crate::number::vector::{add_scaled, dot, largest, scaled, sum};
use crate::run::ensemble::laws::Laws;
use crate::solve::aim::{INSIDE, OFF_INSIDE, ROUNDINGS};
use std::borrow::Borrow;

/// What the quintic of places, velocities and accelerations at both ends of a step is made of at the share s of the
/// step: shares of the way, of both velocities times h, and of half of what both accelerations times h² are beyond
/// those of the cubic.
#[inline(always)]
pub(super) fn quintic(s: f64) -> [f64; 5] {
    let r = 1.0 - s;
    [s * s * (3.0 - 2.0 * s), s * r * r, -r * s * s, s * s * r * r * r, s * s * s * r * r]
}

/// How far a step may have led astray, and whether g is as small as along one sheet on the curve through both ends with
/// their momenta and accelerations, see [`check_sheets`](crate::motion::guarded::Guarded::check_sheets). From a place
/// with its momentum and acceleration; the way from there, momentum, normal and acceleration at the end; the size of
/// places along the normal. A step whose energy may have [jumped](crate::motion::course), if forces work as at its two
/// ends, is none along a sheet either.
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
    let (mut at_first, mut at_last) = (way, way);
    for d in 0..D {
        at_first[d] = two.multiply_add(first[d], last[d]) - three * way[d];
        at_last[d] = three * way[d] - two.multiply_add(last[d], first[d]);
    }
    let at_first = add_scaled(&at_first, half_square, &pull);
    let at_last = add_scaled(&at_last, half_square, &pull_end);
    let most = S::from_f64(OFF_INSIDE).multiply_add(off, S::from_f64(ROUNDINGS * S::EPSILON) * size);
    let most = most * most * dot(&normal, &normal);
    let mut plain = true;
    for s in INSIDE {
        let [a, b, c, d, e] = quintic(s).map(S::from_f64);
        let place = add_scaled(&add_scaled(&add_scaled(&from, a, &way), b, &first), c, &last);
        let place = add_scaled(&add_scaled(&place, d, &at_first), e, &at_last);
        let [g] = laws.constraint(lane).borrow().value(&place);
        plain &= (g * g).le(most);
    }
    let (was, is) = (dot(&p, &p), dot(&p_end, &p_end));
    let given = h * (dot(&pull, &p) + dot(&pull_end, &p_end));
    plain &= (is - was - given).abs().le(S::from_f64(JUMP) * (was + is + given.abs()));
    (off, plain)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::ensemble::laws::Same;
    use std::f64::consts::PI;

    /// sin(k y): lines at distances of π/k, each second one of the same orientation.
    #[derive(Clone)]
    struct Lines {
        k: f64,
    }

    impl ConstraintKernel<f64, 2, 1> for Lines {
        fn value(&self, [_, y]: &[f64; 2]) -> [f64; 1] {
            [(self.k * y).sin()]
        }
        fn value_and_jacobian(&self, q: &[f64; 2]) -> ([f64; 1], [[f64; 2]; 1]) {
            (self.value(q), [[0.0, self.k * (self.k * q[1]).cos()]])
        }
        fn hessian_vector(&self, q: &[f64; 2], v: &[f64; 2]) -> [[f64; 2]; 1] {
            [[0.0, -self.k * self.k * self.value(q)[0] * v[1]]]
        }
        fn jet(&self, q: &[f64; 2], v: &[f64; 2]) -> ([f64; 1], [f64; 1], [f64; 1]) {
            let ([g], [gradient]) = self.value_and_jacobian(q);
            ([g], [dot(&gradient, v)], [dot(v, &self.hessian_vector(q, v)[0])])
        }
    }

    /// A step along x that ends on its line is plain; on one of the next two of the same orientation it is not. (A step
    /// over three, at whose two places g happens to be small, has led so far astray that sheets are asked for.)
    #[test]
    fn a_way_to_another_sheet_is_not_plain() {
        let (h, along, still) = (0.1, [1.0, 0.0], [0.0; 2]);
        for k in [30.0, 1e3, 1e6, 1e9] {
            for line in -2..=2 {
                let y = 2.0 * PI * f64::from(line) / k;
                let normal = [0.0, k];
                let (from, to) = ([[0.3, 0.0], along, still], [[h, y], along, normal, still]);
                let (off, plain) = follows(&Same(Lines { k }, ()), 0, h, from, to, 1.0);
                assert_eq!((off, plain), (y.abs(), line == 0), "k = {k}, line {line}");
            }
        }
    }
}
