//! ∛x and √(x² + y²).

use crate::number::functions::arithmetic::{ROUNDER, polynomial, product, select};
use crate::number::functions::logarithm::split;

/// (1 + f)^−⅓.
const CBRT: [f64; 6] = [
    1.000_003_877_040_742_7, -0.333_260_455_339_132_73, 0.221_602_888_581_728_94, -0.175_828_099_017_949_02,
    0.160_440_110_654_951_78, -0.108_048_844_754_803_47,
];
/// ∛2 and its inverse.
const CBRT_2: [f64; 2] = [1.259_921_049_894_873_2, 0.793_700_525_984_099_8];

/// ∛x: 2^q ∛m with m = 2^(k − 3q) (1 + f), from an approximation of 1/∛m of 17 digits. One correction is of third
/// order, the last one adds what is missing to m.
#[inline(always)]
pub(in crate::number) fn cbrt(x: f64) -> f64 {
    let size = x.abs();
    let (k, f) = split(size);
    let rounded = k.mul_add(1.0 / 3.0, ROUNDER);
    let left = (rounded - ROUNDER).mul_add(-3.0, k); // −1, 0 or 1
    let of = |below: f64, at: f64, above: f64| select(left < 0.0, below, select(left > 0.0, above, at));
    let m = (1.0 + f) * of(0.5, 1.0, 2.0);
    let inverse = polynomial(&CBRT, f) * of(CBRT_2[0], 1.0, CBRT_2[1]);
    let error = (-m * inverse).mul_add(inverse * inverse, 1.0);
    let inverse = (inverse * error).mul_add((2.0 / 9.0_f64).mul_add(error, 1.0 / 3.0), inverse);
    let slope = inverse * inverse;
    let root = m * slope;
    let [square, rest] = product(root, root);
    let missing = (-root).mul_add(rest, (-root).mul_add(square, m));
    let root = (missing * slope).mul_add(1.0 / 3.0, root);
    let power = f64::from_bits(rounded.to_bits().wrapping_add(1023) << 52);
    let found = (root * power).copysign(x);
    select((size > 0.0) & (size < f64::INFINITY), found, x)
}

/// √(x² + y²).
#[inline(always)]
pub(in crate::number) fn hypot(x: f64, y: f64) -> f64 {
    let (x, y) = (x.abs(), y.abs());
    let (more, less) = (select(x < y, y, x), select(x < y, x, y));
    let (far, near) = (2.0_f64.powi(600), 2.0_f64.powi(-600));
    let (scale, back) = (
        select(more > 1e150, near, select(more < 1e-140, far, 1.0)),
        select(more > 1e150, far, select(more < 1e-140, near, 1.0)),
    );
    let (more, less) = (more * scale, less * scale);
    let found = more.mul_add(more, less * less).sqrt() * back;
    let infinite = (x == f64::INFINITY) | (y == f64::INFINITY);
    select(infinite, f64::INFINITY, found)
}
