//! eˣ and the hyperbolic functions.
//!
//! ```text
//! eˣ     = 2ᵏ eʳ         k = x/ln 2 rounded, |r| ≤ ½ ln 2
//! tanh x = t/(t + 2)     t = exp(2x) − 1
//! sinh x = (t + t/(t + 1))/2     t = eˣ − 1
//! ```
//!
//! Multiples of ln 2 are taken off in parts (Cody and Waite, Software Manual for the Elementary Functions, 1980); with
//! fused multiply-add the first part may have all its digits.

use crate::number::functions::arithmetic::{LN_2, Pair, ROUNDER, at_most, polynomial, select, sum};

/// Below it eˣ is less than the normal numbers, and taken for 0; …
const SMALLEST_POWER: f64 = -708.396_418_532_264_1;

/// … and beyond it infinite.
const LARGEST_POWER: f64 = 709.782_712_893_384;

/// (eʳ − 1 − r)/r².
const EXP: [f64; 10] = [
    0.500_000_000_000_001_1, 0.166_666_666_666_664_13, 0.041_666_666_666_530_13, 0.008_333_333_333_494_265,
    0.001_388_888_894_363_912_6, 0.000_198_412_695_070_894_1, 2.480_149_308_925_221_8e-5,
    2.755_758_587_617_778_6e-6, 2.763_025_191_165_915e-7, 2.500_022_639_223_220_8e-8,
];

/// k, in the last digits of a float, and r as a pair, for x = k ln 2 + r.
#[inline(always)]
fn reduced(x: f64) -> (f64, Pair) {
    let rounded = x.mul_add(std::f64::consts::LOG2_E, ROUNDER);
    let k = rounded - ROUNDER;
    let near = (-k).mul_add(LN_2[0], x); // exact
    let r = (-k).mul_add(LN_2[1], near);
    (rounded, [r, (-k).mul_add(LN_2[1], near - r)])
}

/// eʳ − 1 − r.
#[inline(always)]
fn curved([r, low]: Pair) -> f64 {
    (r * r).mul_add(polynomial(&EXP, r), low)
}

/// 2^−`less` eˣ, for `less` 0 or 1.
#[inline(always)]
fn exp_over(less: u64, x: f64) -> f64 {
    let (rounded, [r, _]) = reduced(x);
    let p = (r * r).mul_add(polynomial(&EXP, r), r);
    // Times 2ᵏ: k is added to the exponent.
    let power = f64::from_bits((1.0 + p).to_bits().wrapping_add(rounded.to_bits().wrapping_sub(less) << 52));
    let power = select(x < SMALLEST_POWER, 0.0, power);
    let largest = LARGEST_POWER + if less == 0 { 0.0 } else { LN_2[0] };
    select(x <= largest, power, x + f64::INFINITY) // also where x is not a number
}

/// eˣ of a pair. The power of two may be beyond the floats on either side where the result is not, so in two factors;
/// the first is exact.
#[inline(always)]
pub(super) fn exp_of_pair([x, low]: Pair) -> f64 {
    let x = at_most(712.0, x);
    let (rounded, [r, rest]) = reduced(select(x < -746.0, -746.0, x));
    let r = sum(r, rest + low);
    let [all, rest] = sum(1.0, r[0]);
    let exponents = rounded.to_bits().wrapping_sub(ROUNDER.to_bits()).wrapping_add(2 * 1023);
    let half = exponents >> 1;
    let power = |exponent: u64| f64::from_bits(exponent << 52);
    (all + (rest + curved(r))) * power(half) * power(exponents.wrapping_sub(half))
}

/// eˣ − 1 for 0 ≤ x < 700.
#[inline(always)]
fn exp_less_one(x: f64) -> Pair {
    let (rounded, r) = reduced(x);
    let [p, p_low] = sum(r[0], curved(r));
    let power = f64::from_bits(rounded.to_bits().wrapping_add(1023) << 52);
    let [t, low] = sum(power - 1.0, p * power);
    [t, p_low.mul_add(power, low)]
}

/// eˣ.
#[inline(always)]
pub(in crate::number) fn exp(x: f64) -> f64 {
    exp_over(0, x)
}

/// cosh x.
#[inline(always)]
pub(in crate::number) fn cosh(x: f64) -> f64 {
    let half = exp_over(1, x.abs());
    half + 0.25 / half
}

/// sinh x.
#[inline(always)]
pub(in crate::number) fn sinh(x: f64) -> f64 {
    let size = x.abs();
    let large = size > 22.0; // e⁻²ˣ is lost
    let [t, low] = exp_less_one(select(large, 22.0, size));
    let inverse = 1.0 / (t + 1.0);
    let low = (inverse * inverse).mul_add(low, low);
    select(large, exp_over(1, size), 0.5 * (t + t.mul_add(inverse, low))).copysign(x)
}

/// tanh x.
#[inline(always)]
pub(in crate::number) fn tanh(x: f64) -> f64 {
    let [t, low] = exp_less_one(2.0 * at_most(22.0, x.abs()));
    let below = t + 2.0;
    let below_low = (2.0 - below) + t;
    let tanh = t / below;
    // To t, over t + 2 = 2/(1 − tanh), of which no digits are left near 1.
    let missing = select(below < 1e12, (-tanh).mul_add(low + below_low, low), 0.0);
    missing.mul_add((-0.5_f64).mul_add(tanh, 0.5), tanh).copysign(x)
}
