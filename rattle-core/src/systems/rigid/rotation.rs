//! The rotation of a rigid body in a step, from its momentum.
//!
//! ```text
//! r(e) = e₀ J e + e × J e − h/2 m = 0,     e₀ = √(1 − |e|²)
//! r′   = e₀ J − J e eᵀ/e₀ + ê J − (J e)̂
//! ```
//!
//! Solved by Newton's method, from the first two terms of the power series of e in h where e is short, and from the
//! first term elsewhere: so e is a function of the momentum alone. A solve ends with a correction at the rounding
//! floor, or one that no longer shrinks. Ending by an estimate of the next correction made the energy of a needle drift
//! by a relative 4e-19 per step.

use crate::number::vector::{add_scaled, dot, largest, scaled};
use std::array::from_fn;

/// Newton steps after which the rotation of a step is given up; five suffice where there is one.
const MOST_CORRECTIONS: usize = 30;

/// Up to this |e|² powers of h are a better first guess than J⁻¹ h/2 m alone.
const SHORT: f64 = 0.0625;

/// a × b.
#[inline(always)]
pub(super) fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The vector of QᵀX − XᵀQ, of matrices by rows: minus the sum of the cross products of their rows.
#[inline(always)]
pub(super) fn turning(q: &[f64; 9], x: &[f64; 9]) -> [f64; 3] {
    let row = |matrix: &[f64; 9], i: usize| -> [f64; 3] { from_fn(|j| matrix[3 * i + j]) };
    let [a, b, c] = from_fn(|i| cross(&row(x, i), &row(q, i)));
    from_fn(|i| a[i] + b[i] + c[i])
}

/// The quaternion (e₀, e) for h/2 m = `target` and these moments of inertia. None if the body turns too far.
#[inline(always)]
pub(super) fn rotation(inertia: &[f64; 3], target: &[f64; 3]) -> Option<(f64, [f64; 3])> {
    let over = inertia.map(|moment| 1.0 / moment);
    let mut e: [f64; 3] = from_fn(|i| over[i] * target[i]);
    let short = dot(&e, &e);
    if short <= SHORT {
        let bend = cross(&e, target);
        let next: [f64; 3] = from_fn(|i| e[i] - over[i] * bend[i]);
        let bend = cross(&next, &from_fn(|i| inertia[i] * next[i]));
        let length = 1.0 + 0.5 * short;
        e = from_fn(|i| length * (e[i] - over[i] * bend[i]));
    }
    let mut last = f64::INFINITY;
    for _ in 0..MOST_CORRECTIONS {
        let square = 1.0 - dot(&e, &e);
        let e0 = square.sqrt(); // NaN where there is no such rotation
        let over = -e0 * (1.0 / square); // the division does not wait for the root
        let je: [f64; 3] = from_fn(|i| inertia[i] * e[i]);
        let bend = cross(&e, &je);
        let residual: [f64; 3] = from_fn(|i| e0 * je[i] + bend[i] - target[i]);
        let slope: [f64; 3] = scaled(over, &je);
        // By columns: column k is Jₖ (e₀ uₖ + e × uₖ) − eₖ/e₀ J e − J e × uₖ.
        let column = |k: usize| -> [f64; 3] {
            let (j, l) = ((k + 1) % 3, (k + 2) % 3);
            let mut column = scaled(e[k], &slope);
            column[k] += inertia[k] * e0;
            column[j] += inertia[k] * e[l] - je[l];
            column[l] -= inertia[k] * e[j] - je[j];
            column
        };
        let [a, b, c] = [column(0), column(1), column(2)];
        let (bc, ca, ab) = (cross(&b, &c), cross(&c, &a), cross(&a, &b));
        let over = 1.0 / dot(&a, &bc);
        let correction = scaled(over, &[dot(&bc, &residual), dot(&ca, &residual), dot(&ab, &residual)]);
        e = add_scaled(&e, -1.0, &correction);
        let (size, all) = (largest(&correction), largest(&e));
        if !size.is_finite() {
            return None;
        }
        let floor = f64::EPSILON * all;
        let stalled = size >= 0.5 * last && size <= 1e-12 * all;
        if size <= floor || stalled {
            let square = 1.0 - dot(&e, &e);
            return (square > 0.0).then(|| (square.sqrt(), e));
        }
        last = size;
    }
    None
}
