//! eˣ, ln x, sin x, cos x, sinh x, cosh x and tanh x without branches, calls or tables, so that loops over them vectorise.
//!
//! The functions of the system's library are calls, and one call keeps a compiler from vectorising a whole loop. No crate serves
//! on stable Rust: of those that have these functions in double precision, `sleef` needs the unstable `portable_simd`, and
//! `wide` chooses instructions when it is compiled.
//!
//! All is made of operations that round once and of bits of floats. So every instruction set gives the same numbers.
//!
//! ```text
//! eˣ     = 2ᵏ eʳ                    k = x/ln 2 rounded, |r| ≤ ½ ln 2
//! sin x  = ± sin r  or  ± cos r     k = x/(π/2) rounded, |r| ≤ π/4, and what is below the last digit of r
//! ln x   = k ln 2 + ln(1 + f)       √½ ≤ 1 + f < √2, ln(1 + f) = 2 artanh(f/(2 + f))
//! tanh x = t/(t + 2)                t = exp(2x) − 1
//! ```
//!
//! Multiples of ln 2 and π/2 are taken off in parts (Cody and Waite, Software Manual for the Elementary Functions, 1980);
//! with fused multiply-add the first part may have all its digits. Polynomials are the best ones on their intervals, by
//! the exchange algorithm of Remez, rounded to double precision.
//!
//! The largest errors seen, in units of the last place, are in `tests/functions.rs`.

/// 1.5·2⁵²: a number below 2⁵¹ that is added to it is rounded to an integer, which is then in its last digits.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// Below it eˣ is less than the normal numbers, and taken for 0; …
const SMALLEST_POWER: f64 = -708.396_418_532_264_1;

/// … and beyond it infinite.
const LARGEST_POWER: f64 = 709.782_712_893_384;

const LN_2: [f64; 2] = [std::f64::consts::LN_2, 2.319_046_813_846_299_6e-17];
/// π/2 in parts of 53, 33 and 53 digits: products of the second with integers below 2¹⁸ have no rounding error.
const HALF_PI: [f64; 3] = [std::f64::consts::FRAC_PI_2, 6.123_233_995_384_61e-17, 3.521_559_865_183_2e-27];

/// Beyond it sin and cos are not a number: neighbours are 2⁻¹² apart there, too far for any motion along a wave.
pub(super) const FARTHEST_ANGLE: f64 = 1_099_511_627_776.0;

/// (eʳ − 1 − r)/r².
const EXP: [f64; 10] = [
    0.500_000_000_000_001_1,
    0.166_666_666_666_664_13,
    0.041_666_666_666_530_155,
    0.008_333_333_333_494_463,
    0.001_388_888_894_363_007,
    0.000_198_412_695_065_763_98,
    2.480_149_309_894_754_3e-5,
    2.755_758_637_599_077_3e-6,
    2.763_024_836_611_497e-7,
    2.500_006_091_337_583_8e-8,
];

/// (sin r − r)/r³, in r².
const SIN: [f64; 6] = [
    -0.166_666_666_666_666_32,
    0.008_333_333_333_322_32,
    -0.000_198_412_698_297_273_5,
    2.755_731_366_249_118_5e-6,
    -2.505_075_329_641_207_4e-8,
    1.589_650_526_061_127_2e-10,
];

/// (cos r − 1 + r²/2)/r⁴, in r².
const COS: [f64; 6] = [
    0.041_666_666_666_666_6,
    -0.001_388_888_888_887_4,
    2.480_158_728_939_928e-5,
    -2.755_731_432_723_796_4e-7,
    2.087_571_971_602_966_8e-9,
    -1.135_945_648_791_087_1e-11,
];

/// (2 artanh s − 2s)/s³, in s².
const ARTANH: [f64; 7] = [
    0.666_666_666_666_673_5,
    0.399_999_999_994_076_37,
    0.285_714_287_441_287_6,
    0.222_221_983_781_505_8,
    0.181_835_752_436_225_2,
    0.153_137_526_323_140_76,
    0.147_991_055_965_647_43,
];

/// A polynomial, in pairs and pairs of pairs (Estrin 1960): half as long a way to the result as term by term.
#[inline(always)]
fn polynomial<const N: usize>(c: &[f64; N], x: f64) -> f64 {
    let square = x * x;
    let fourth = square * square;
    let pair = |i: usize| if i + 1 < N { c[i + 1].mul_add(x, c[i]) } else { c[i] };
    let four = |i: usize| if i + 2 < N { pair(i + 2).mul_add(square, pair(i)) } else { pair(i) };
    let eight = |i: usize| if i + 4 < N { four(i + 4).mul_add(fourth, four(i)) } else { four(i) };
    if N > 8 { eight(8).mul_add(fourth * fourth, eight(0)) } else { eight(0) }
}

#[inline(always)]
fn select(choice: bool, a: f64, b: f64) -> f64 {
    if choice { a } else { b }
}

/// k, in the last digits of a float, r, and what rounding took from it, for x = k ln 2 + r.
#[inline(always)]
fn reduced(x: f64) -> (f64, f64, f64) {
    let rounded = x.mul_add(std::f64::consts::LOG2_E, ROUNDER);
    let k = rounded - ROUNDER;
    let near = (-k).mul_add(LN_2[0], x); // exact
    let r = (-k).mul_add(LN_2[1], near);
    (rounded, r, (-k).mul_add(LN_2[1], near - r))
}

/// 2^−`less` eˣ, for `less` 0 or 1.
#[inline(always)]
fn exp_over(less: u64, x: f64) -> f64 {
    let (rounded, r, _) = reduced(x);
    let p = (r * r).mul_add(polynomial(&EXP, r), r);
    // Times 2ᵏ: k is added to the exponent.
    let power = f64::from_bits((1.0 + p).to_bits().wrapping_add(rounded.to_bits().wrapping_sub(less) << 52));
    let power = select(x < SMALLEST_POWER, 0.0, power);
    let largest = LARGEST_POWER + if less == 0 { 0.0 } else { LN_2[0] };
    select(x <= largest, power, x + f64::INFINITY) // also where x is not a number
}

/// eˣ − 1 for 0 ≤ x < 700.
#[inline(always)]
fn exp_less_one(x: f64) -> f64 {
    let (rounded, r, low) = reduced(x);
    let p = r + (r * r).mul_add(polynomial(&EXP, r), low);
    let power = f64::from_bits(rounded.to_bits().wrapping_add(1023) << 52);
    p.mul_add(power, power - 1.0)
}

/// eˣ.
#[inline(always)]
pub(super) fn exp(x: f64) -> f64 {
    exp_over(0, x)
}

/// cosh x.
#[inline(always)]
pub(super) fn cosh(x: f64) -> f64 {
    let half = exp_over(1, x.abs());
    half + 0.25 / half
}

/// sinh x.
#[inline(always)]
pub(super) fn sinh(x: f64) -> f64 {
    let size = x.abs();
    let large = size > 22.0; // e⁻²ˣ is lost
    let t = exp_less_one(select(large, 22.0, size));
    select(large, exp_over(1, size), 0.5 * (t + t / (t + 1.0))).copysign(x)
}

/// tanh x.
#[inline(always)]
pub(super) fn tanh(x: f64) -> f64 {
    let size = x.abs();
    let t = exp_less_one(2.0 * select(size > 22.0, 22.0, size));
    (t / (t + 2.0)).copysign(x)
}

/// (sin x, cos x); not a number beyond [`FARTHEST_ANGLE`].
#[inline(always)]
pub(super) fn sin_cos(x: f64) -> (f64, f64) {
    let x = select(x.abs() <= FARTHEST_ANGLE, x, f64::NAN);
    let rounded = x.mul_add(std::f64::consts::FRAC_2_PI, ROUNDER);
    let k = rounded - ROUNDER;
    let near = (-k).mul_add(HALF_PI[0], x); // exact
    let r = (-k).mul_add(HALF_PI[1], near);
    let low = (-k).mul_add(HALF_PI[2], (-k).mul_add(HALF_PI[1], near - r));
    let square = r * r;
    let half = 0.5 * r;
    let most = (-half).mul_add(r, 1.0);
    let sine = r + (r * square).mul_add(polynomial(&SIN, square), low * most);
    let sine = select(r == 0.0, r, sine); // the sign of zero
    let rest = (-half).mul_add(r, 1.0 - most); // exact
    let cosine = most + (square * square).mul_add(polynomial(&COS, square), (-sine).mul_add(low, rest));
    let turns = rounded.to_bits(); // quarters of a turn
    let odd = turns & 1 != 0;
    let signed = |x: f64, sign: u64| f64::from_bits(x.to_bits() ^ ((sign & 2) << 62));
    (signed(select(odd, cosine, sine), turns), signed(select(odd, sine, cosine), turns.wrapping_add(1)))
}

/// sin x.
#[inline(always)]
pub(super) fn sin(x: f64) -> f64 {
    sin_cos(x).0
}

/// cos x.
#[inline(always)]
pub(super) fn cos(x: f64) -> f64 {
    sin_cos(x).1
}

/// ln x.
#[inline(always)]
pub(super) fn ln(x: f64) -> f64 {
    let root_half = std::f64::consts::FRAC_1_SQRT_2.to_bits();
    let tiny = x < f64::MIN_POSITIVE;
    let scaled = select(tiny, x * 18_014_398_509_481_984.0, x); // by 2⁵⁴
    let bits = scaled.to_bits().wrapping_add(1.0_f64.to_bits() - root_half);
    // An integer below 2⁵² in the last digits of 2⁵².
    let k = f64::from_bits((bits >> 52) | 4_503_599_627_370_496.0_f64.to_bits()) - 4_503_599_627_370_496.0;
    let k = k - select(tiny, 1023.0 + 54.0, 1023.0);
    let f = f64::from_bits((bits & ((1 << 52) - 1)).wrapping_add(root_half)) - 1.0;
    let s = f / (2.0 + f);
    let square = s * s;
    let half = 0.5 * f * f;
    let curved = s.mul_add(square.mul_add(polynomial(&ARTANH, square), half), k * LN_2[1]);
    let finite = k.mul_add(LN_2[0], f - (half - curved));
    let finite = select(x == 0.0, f64::NEG_INFINITY, select(x < 0.0, f64::NAN, finite));
    select(x < f64::INFINITY, finite, x)
}
