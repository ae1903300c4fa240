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

use super::{LN_2, Pair, ROUNDER, at_most, polynomial, select, sum};

/// (eʳ − 1 − r)/r².
const EXP: [f64; 11] = [
    0.5,
    0.166_666_666_666_666_85,
    0.041_666_666_666_666_73,
    0.008_333_333_333_316_742,
    0.001_388_888_888_885_840_4,
    0.000_198_412_698_970_548_46,
    2.480_158_737_383_274e-5,
    2.755_723_423_856_042e-6,
    2.755_723_328_159_900_5e-7,
    2.511_223_981_596_869_6e-8,
    2.092_696_584_647_189e-9,
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

/// 2^(k − `less`) x. That power may be beyond the floats on either side where the result is not, so in two factors; the first
/// is exact.
#[inline(always)]
fn times_power(x: f64, rounded: f64, less: u64) -> f64 {
    let exponents = rounded.to_bits().wrapping_sub(ROUNDER.to_bits()).wrapping_add(2 * 1023 - less);
    let half = exponents >> 1;
    let power = |exponent: u64| f64::from_bits(exponent << 52);
    x * power(half) * power(exponents.wrapping_sub(half))
}

/// x, or where eˣ is beyond the floats a number that is near; not a number stays so.
#[inline(always)]
fn within_reach(x: f64) -> f64 {
    let x = at_most(712.0, x);
    select(x < -746.0, -746.0, x)
}

/// 2^−`less` eˣ.
#[inline(always)]
fn exp_over(less: u64, x: f64) -> f64 {
    let (rounded, r) = reduced(within_reach(x));
    times_power(1.0 + (r[0] + curved(r)), rounded, less)
}

/// eˣ of a pair.
#[inline(always)]
pub(super) fn exp_of_pair([x, low]: Pair) -> f64 {
    let (rounded, [r, rest]) = reduced(within_reach(x));
    let r = sum(r, rest + low);
    let [all, rest] = sum(1.0, r[0]);
    times_power(all + (rest + curved(r)), rounded, 0)
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
pub(in crate::lanes) fn exp(x: f64) -> f64 {
    exp_over(0, x)
}

/// cosh x.
#[inline(always)]
pub(in crate::lanes) fn cosh(x: f64) -> f64 {
    let half = exp_over(1, x.abs());
    half + 0.25 / half
}

/// sinh x.
#[inline(always)]
pub(in crate::lanes) fn sinh(x: f64) -> f64 {
    let size = x.abs();
    let large = size > 22.0; // e⁻²ˣ is lost
    let [t, low] = exp_less_one(select(large, 22.0, size));
    let inverse = 1.0 / (t + 1.0);
    let low = (inverse * inverse).mul_add(low, low);
    select(large, exp_over(1, size), 0.5 * (t + t.mul_add(inverse, low))).copysign(x)
}

/// tanh x.
#[inline(always)]
pub(in crate::lanes) fn tanh(x: f64) -> f64 {
    let [t, low] = exp_less_one(2.0 * at_most(22.0, x.abs()));
    let below = t + 2.0;
    let below_low = (2.0 - below) + t;
    let tanh = t / below;
    // To t, over t + 2 = 2/(1 − tanh), of which no digits are left near 1.
    let missing = select(below < 1e12, (-tanh).mul_add(low + below_low, low), 0.0);
    missing.mul_add((-0.5_f64).mul_add(tanh, 0.5), tanh).copysign(x)
}
