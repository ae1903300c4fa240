//! Logarithms, and the inverse hyperbolic functions, which are logarithms of pairs.
//!
//! ```text
//! ln x     = k ln 2 + ln(1 + f)              √½ ≤ 1 + f < √2, ln(1 + f) = 2 artanh(f/(2 + f))
//! arsinh x = ln(1 + x + x²/(1 + √(1 + x²)))  of the size of x; the sign is that of x
//! arcosh x = ln(1 + t + √(2t + t²))          t = x − 1
//! artanh x = ½ ln(1 + 2x/(1 − x))            of the size of x
//! ```

use crate::number::functions::arithmetic::{
    LN_2, Pair, ROUNDER, polynomial, product, quotient, select, sum, sum_in_any_order,
};

const LOG2_E: Pair = [std::f64::consts::LOG2_E, 2.035_527_374_093_103_3e-17];
const LOG10_E: Pair = [std::f64::consts::LOG10_E, 1.098_319_650_216_765e-17];
const LOG10_2: Pair = [std::f64::consts::LOG10_2, -2.803_728_127_785_170_4e-18];

/// (2 artanh s − 2s)/s³, in s².
const ARTANH: [f64; 7] = [
    0.666_666_666_666_673_5, 0.399_999_999_994_076_37, 0.285_714_287_441_287_6, 0.222_221_983_781_505_8,
    0.181_835_752_436_225_2, 0.153_137_526_323_140_76, 0.147_991_055_965_647_43,
];

/// k and f of x = 2ᵏ (1 + f), √½ ≤ 1 + f < √2; x is positive and finite, or what comes is of no use.
#[inline(always)]
pub(super) fn split(x: f64) -> (f64, f64) {
    let root_half = std::f64::consts::FRAC_1_SQRT_2.to_bits();
    let tiny = x < f64::MIN_POSITIVE;
    let scaled = select(tiny, x * 18_014_398_509_481_984.0, x); // by 2⁵⁴
    let bits = scaled.to_bits().wrapping_add(1.0_f64.to_bits() - root_half);
    // An integer below 2⁵² in the last digits of 2⁵².
    let k = f64::from_bits((bits >> 52) | 4_503_599_627_370_496.0_f64.to_bits()) - 4_503_599_627_370_496.0;
    let f = f64::from_bits((bits & ((1 << 52) - 1)).wrapping_add(root_half)) - 1.0;
    (k - select(tiny, 1023.0 + 54.0, 1023.0), f)
}

/// f − f²/2, rounded, and what is missing to ln(1 + f) + `low`, for s = f/(2 + f).
#[inline(always)]
fn curved(f: f64, s: f64, low: f64) -> (f64, f64) {
    let square = s * s;
    let half = 0.5 * f * f;
    (half, s.mul_add(square.mul_add(polynomial(&ARTANH, square), half), low))
}

/// The logarithm at the ends of its range, and elsewhere `inside`.
#[inline(always)]
fn with_ends(x: f64, inside: f64) -> f64 {
    let finite = select(x == 0.0, f64::NEG_INFINITY, select(x < 0.0, f64::NAN, inside));
    select(x < f64::INFINITY, finite, x)
}

/// ln x.
#[inline(always)]
pub(in crate::number) fn ln(x: f64) -> f64 {
    let (k, f) = split(x);
    let (half, curved) = curved(f, f / (2.0 + f), k * LN_2[1]);
    with_ends(x, k.mul_add(LN_2[0], f - (half - curved)))
}

/// ln(1 + f) times a number, as a pair.
#[inline(always)]
fn scaled(f: f64, [scale, scale_low]: Pair) -> Pair {
    let (half, curved) = curved(f, f / (2.0 + f), 0.0);
    let high = f - half;
    let low = (f - high - half) + curved;
    let [scaled, rest] = product(high, scale);
    [scaled, low.mul_add(scale, high.mul_add(scale_low, rest))]
}

/// log₂ x: exact at powers of 2.
#[inline(always)]
pub(in crate::number) fn log2(x: f64) -> f64 {
    let (k, f) = split(x);
    let [part, low] = scaled(f, LOG2_E);
    let [total, rest] = sum(k, part);
    with_ends(x, total + (rest + low))
}

/// log₁₀ x: exact at powers of 10.
#[inline(always)]
pub(in crate::number) fn log10(x: f64) -> f64 {
    let (k, f) = split(x);
    let [part, low] = scaled(f, LOG10_E);
    let [whole, whole_low] = product(k, LOG10_2[0]);
    let [total, rest] = sum(whole, part);
    with_ends(x, total + (rest + (k.mul_add(LOG10_2[1], whole_low) + low)))
}

/// ln(2^`more` (x + `low`)), for x ≥ 1 and a `low` below its last digit.
#[inline(always)]
fn ln_of_pair(more: f64, [x, low]: Pair) -> f64 {
    let (k, f) = split(x);
    let s = f / (2.0 + f);
    let unit = f64::from_bits((ROUNDER - k).to_bits().wrapping_add(1023) << 52); // 2⁻ᵏ
    let slope = (s + s).mul_add((1.0 - s).mul_add(s, -1.0), 1.0); // (1 − s)/(1 + s) = 1/(1 + f), to 2s⁴
    let k = k + more;
    let (half, curved) = curved(f, s, (low * unit).mul_add(slope, k * LN_2[1]));
    k.mul_add(LN_2[0], f - (half - curved))
}

/// 1 + (a + b), and what rounding takes from it, for a ≥ b ≥ 0.
#[inline(always)]
fn one_and(a: f64, b: f64) -> Pair {
    let [more, low] = sum(a, b);
    let [all, rest] = sum_in_any_order(1.0, more);
    [all, rest + low]
}

/// Beyond it 1/x² is lost against ln x.
const LARGE: f64 = 1_073_741_824.0;

/// ln(2x) where x is [`LARGE`], ln of the pair elsewhere.
#[inline(always)]
fn unless_large(x: f64, [high, low]: Pair) -> f64 {
    let large = x > LARGE; // infinite too, of which split makes ln 2¹⁰²⁴
    let found = ln_of_pair(select(large, 2.0, 0.0), [select(large, 0.5 * x, high), select(large, 0.0, low)]);
    select(x < f64::INFINITY, found, x)
}

/// arsinh x.
#[inline(always)]
pub(in crate::number) fn asinh(x: f64) -> f64 {
    let size = x.abs();
    let square = size * size;
    let more = square / (1.0 + (1.0 + square).sqrt());
    unless_large(size, one_and(size, more)).copysign(x)
}

/// arcosh x.
#[inline(always)]
pub(in crate::number) fn acosh(x: f64) -> f64 {
    let t = x - 1.0;
    let found = unless_large(x, one_and(t.mul_add(t, t + t).sqrt(), t));
    select(x < 1.0, f64::NAN, found)
}

/// artanh x.
#[inline(always)]
pub(in crate::number) fn atanh(x: f64) -> f64 {
    let size = x.abs();
    let inside = select(size < 1.0, size, 0.0);
    let [more, low] = quotient([inside + inside, 0.0], sum(1.0, -inside));
    let [all, rest] = sum_in_any_order(1.0, more);
    let found = 0.5 * ln_of_pair(0.0, [all, rest + low]);
    let ends = select(size == 1.0, f64::INFINITY, f64::NAN);
    select(size < 1.0, found, ends).copysign(x)
}

/// (2 artanh s − 2s − 2s³/3)/s⁵, in s².
const ARTANH_FIFTH: [f64; 8] = [
    0.399_999_999_999_999_8, 0.285_714_285_714_450_6, 0.222_222_222_175_473_74, 0.181_818_188_691_213_47,
    0.153_845_569_444_179_74, 0.133_363_148_423_938_26, 0.116_748_667_081_403_6, 0.119_886_399_579_702_1,
];

/// 2/3.
const TWO_THIRDS: Pair = [2.0 / 3.0, 3.700_743_415_417_188e-17];

/// ln x to 66 digits, x positive and finite.
#[inline(always)]
pub(super) fn ln_to_a_pair(x: f64) -> Pair {
    let (k, f) = split(x);
    let below = [2.0 + f, (1.0 - ((1.0 + f) + 1.0)) + (1.0 + f)];
    let [s, s_low] = quotient([f, 0.0], below);
    let [square, rest] = product(s, s);
    let square_low = (s + s).mul_add(s_low, rest);
    let [cube, rest] = product(s, square);
    let cube_low = s.mul_add(square_low, s_low.mul_add(square, rest));
    let [third, rest] = product(cube, TWO_THIRDS[0]);
    let third_low = cube.mul_add(TWO_THIRDS[1], cube_low.mul_add(TWO_THIRDS[0], rest));
    let fifth = cube * square * polynomial(&ARTANH_FIFTH, square);
    let [whole, rest] = product(k, LN_2[0]);
    let whole_low = k.mul_add(LN_2[1], rest);
    let [high, first] = sum(whole, s + s);
    let [high, second] = sum(high, third);
    let low = fifth + (third_low + (second + (first + (whole_low + (s_low + s_low)))));
    sum(high, low)
}
