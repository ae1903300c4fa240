//! Angles: arctan x, that of a point, arcsin x and arccos x.
//!
//! ```text
//! arctan y/x = k π/4 + arctan t     t = y/x, (y − x)/(y + x) or −x/y, |t| ≤ tan π/8
//! arcsin x   = x + x³ P(x²)         |x| ≤ ½
//! arccos x   = 2 arcsin s           s² = (1 − x)/2, x > ½
//! ```

use crate::number::functions::arithmetic::{
    Pair, at_most, polynomial, product, quotient, select, sum, sum_in_any_order,
};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

const QUARTER_PI: Pair = [FRAC_PI_4, 3.061_616_997_868_383e-17];
const HALF_PI: Pair = [FRAC_PI_2, 6.123_233_995_736_766e-17];
const WHOLE_PI: Pair = [PI, 1.224_646_799_147_353_2e-16];
const TAN_EIGHTH_PI: f64 = 0.414_213_562_373_095_03;

/// (arctan t − t)/t³, in t².
const ATAN: [f64; 11] = [
    -0.333_333_333_333_332, 0.199_999_999_999_541_02, -0.142_857_142_802_500_34, 0.111_111_107_862_077_33,
    -0.090_908_978_383_756_74, 0.076_920_616_705_449_31, -0.066_631_207_564_551_96,
    0.058_480_115_739_414_765, -0.050_398_572_263_721_436, 0.038_078_611_301_176_894,
    -0.017_922_588_539_492_63,
];

/// (arcsin s − s)/s³, in s².
const ASIN: [f64; 13] = [
    0.166_666_666_666_667_63, 0.074_999_999_999_702_51, 0.044_642_857_175_131_466, 0.030_381_942_683_123_518,
    0.022_372_215_673_380_217, 0.017_351_599_872_483_15, 0.013_980_963_911_131_215,
    0.011_397_757_056_154_282, 0.010_786_629_600_255_228, 0.003_682_679_288_897_819,
    0.021_764_348_318_671_238, -0.021_078_456_834_056_465, 0.032_677_600_152_728_664,
];

/// The angle of (x, y), or of (−x, y) on the `left`; x and y are not negative, finite and not both zero, and neither
/// their sum nor the inverse of the larger one is beyond the floats.
#[inline(always)]
fn angle(y: f64, x: f64, left: bool) -> f64 {
    let (flat, steep) = (y <= TAN_EIGHTH_PI * x, x < TAN_EIGHTH_PI * y);
    let ([less, less_low], [more, more_low]) = (sum_in_any_order(y, -x), sum_in_any_order(y, x));
    let of = |flatly, between, steeply| select(flat, flatly, select(steep, steeply, between));
    let above = [of(y, less, -x), of(0.0, less_low, 0.0)];
    let below = [of(x, more, y), of(0.0, more_low, 0.0)];
    let [t, t_low] = quotient(above, below);
    let signed = |x: f64| select(left, -x, x);
    let eighths = of(0.0, 1.0, 2.0);
    let eighths = select(left, 4.0 - eighths, eighths);
    let square = t * t;
    let [round, rest] = product(eighths, QUARTER_PI[0]);
    let [angle, low] = sum(round, signed(t));
    let curved = signed((t * square).mul_add(polynomial(&ATAN, square), t_low));
    angle + (low + (eighths.mul_add(QUARTER_PI[1], rest) + curved))
}

/// arctan x.
#[inline(always)]
pub(in crate::number) fn atan(x: f64) -> f64 {
    angle(at_most(1e300, x.abs()), 1.0, false).copysign(x)
}

/// The angle of (x, y) in [−π, π]; of zeros and infinities as IEEE 754 has it.
#[inline(always)]
pub(in crate::number) fn atan2(y: f64, x: f64) -> f64 {
    let (up, side) = (y.abs(), x.abs());
    let larger = select(side <= up, up, side);
    // Infinities count as ones, beside which all that is finite is zero; not a number stays so.
    let infinite = larger == f64::INFINITY;
    let beside = |x: f64| select(infinite, select(x == f64::INFINITY, 1.0, 0.0 * x), x);
    let scale = select(larger < 1.0, 2.0_f64.powi(900), select(larger > 1e300, 0.0625, 1.0));
    let (up, side) = (beside(up) * scale, beside(side) * scale);
    let side = select(larger == 0.0, 1.0, side);
    angle(up, side, x.is_sign_negative()).copysign(y)
}

/// Whether |x| > ½, and s and s³ P(s²) of it or of √((1 − |x|)/2).
#[inline(always)]
fn of_chord(size: f64) -> (bool, f64, f64) {
    let large = size > 0.5;
    let square = select(large, (-0.5_f64).mul_add(size, 0.5), size * size);
    let s = select(large, square.sqrt(), size);
    (large, s, s * square * polynomial(&ASIN, square))
}

/// arcsin x.
#[inline(always)]
pub(in crate::number) fn asin(x: f64) -> f64 {
    let (large, s, curved) = of_chord(x.abs());
    let [most, rest] = sum(HALF_PI[0], -2.0 * s);
    let from_above = most + (rest + (-2.0_f64).mul_add(curved, HALF_PI[1]));
    select(large, from_above, s + curved).copysign(x)
}

/// arccos x.
#[inline(always)]
pub(in crate::number) fn acos(x: f64) -> f64 {
    let (large, s, curved) = of_chord(x.abs());
    // π/2 − x − …, or 2s + … from 0, or π − 2s − … .
    let left = x < 0.0;
    let [from, from_low] = [0, 1].map(|i| select(large, select(left, WHOLE_PI[i], 0.0), HALF_PI[i]));
    let sign = select(large ^ left, select(large, 2.0, 1.0), select(large, -2.0, -1.0));
    let [most, rest] = sum(from, sign * s);
    most + (rest + sign.mul_add(curved, from_low))
}
