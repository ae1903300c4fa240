//! sin x, cos x and tan x.
//!
//! ```text
//! sin x = ± sin r  or  ± cos r     k = x/(π/2) rounded, |r| ≤ π/4, and what is below the last digit of r
//! tan x = sin r / cos r  or  −cos r / sin r, of pairs
//! ```
//!
//! Multiples of π/2 are taken off in parts, as those of ln 2 from x in eˣ.

use crate::number::functions::arithmetic::{Pair, ROUNDER, polynomial, quotient, select, sum};

/// π/2 in parts of 53, 33 and 53 digits: products of the second with integers below 2¹⁸ have no rounding error.
pub(super) const HALF_PI: [f64; 3] =
    [std::f64::consts::FRAC_PI_2, 6.123_233_995_384_61e-17, 3.521_559_865_183_2e-27];

/// Beyond it the functions are not a number: neighbours are 2⁻¹² apart there, too far for any motion along a wave.
pub(super) const FARTHEST_ANGLE: f64 = 1_099_511_627_776.0;

/// (sin r − r)/r³, in r².
const SIN: [f64; 6] = [
    -0.166_666_666_666_666_32, 0.008_333_333_333_322_32, -0.000_198_412_698_297_273_5,
    2.755_731_366_249_118_5e-6, -2.505_075_329_641_207_4e-8, 1.589_650_526_061_127_2e-10,
];

/// (cos r − 1 + r²/2)/r⁴, in r².
const COS: [f64; 6] = [
    0.041_666_666_666_666_6, -0.001_388_888_888_887_4, 2.480_158_728_939_928e-5, -2.755_731_432_723_796_4e-7,
    2.087_571_971_602_966_8e-9, -1.135_945_648_791_087_1e-11,
];

/// k, in the last digits of a float's bits, with a large and a small part of sin r and of cos r; not a number beyond
/// [`FARTHEST_ANGLE`].
#[inline(always)]
fn of_the_rest(x: f64) -> (u64, Pair, Pair) {
    let x = select(x.abs() <= FARTHEST_ANGLE, x, f64::NAN);
    let rounded = x.mul_add(std::f64::consts::FRAC_2_PI, ROUNDER);
    let k = rounded - ROUNDER;
    let near = (-k).mul_add(HALF_PI[0], x); // exact
    let r = (-k).mul_add(HALF_PI[1], near);
    let low = (-k).mul_add(HALF_PI[2], (-k).mul_add(HALF_PI[1], near - r));
    let square = r * r;
    let half = 0.5 * r;
    let most = (-half).mul_add(r, 1.0);
    let small = (r * square).mul_add(polynomial(&SIN, square), low * most);
    let rest = (-half).mul_add(r, 1.0 - most); // exact
    let cosine = (square * square).mul_add(polynomial(&COS, square), (-(r + small)).mul_add(low, rest));
    (rounded.to_bits(), [r, small], [most, cosine])
}

/// (sin x, cos x); not a number beyond [`FARTHEST_ANGLE`].
#[inline(always)]
pub(in crate::number) fn sin_cos(x: f64) -> (f64, f64) {
    let (turns, [r, small], [most, rest]) = of_the_rest(x); // quarters of a turn
    let sine = select(r == 0.0, r, r + small); // the sign of zero
    let cosine = most + rest;
    let odd = turns & 1 != 0;
    let signed = |x: f64, sign: u64| f64::from_bits(x.to_bits() ^ ((sign & 2) << 62));
    (signed(select(odd, cosine, sine), turns), signed(select(odd, sine, cosine), turns.wrapping_add(1)))
}

/// sin x.
#[inline(always)]
pub(in crate::number) fn sin(x: f64) -> f64 {
    sin_cos(x).0
}

/// cos x.
#[inline(always)]
pub(in crate::number) fn cos(x: f64) -> f64 {
    sin_cos(x).1
}

/// tan x.
#[inline(always)]
pub(in crate::number) fn tan(x: f64) -> f64 {
    let (turns, [r, small], [most, rest]) = of_the_rest(x);
    let ([sine, sine_low], [cosine, cosine_low]) = (sum(r, small), sum(most, rest));
    let odd = turns & 1 != 0;
    let above = [select(odd, -cosine, sine), select(odd, -cosine_low, sine_low)];
    let below = [select(odd, sine, cosine), select(odd, sine_low, cosine_low)];
    let [tangent, low] = quotient(above, below);
    select(x == 0.0, x, tangent + low) // the sign of zero
}
