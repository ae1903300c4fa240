//! Functions of single precision. Those that surfaces have most are the same formulas with shorter polynomials, angles
//! reduced in double precision; the others those of double precision, rounded.

use crate::number::functions::arithmetic::ROUNDER;
use crate::number::functions::circular::{FARTHEST_ANGLE, HALF_PI};

/// 1.5·2²³: a number below 2²² that is added to it is rounded to an integer, which is then in its last digits.
const ROUNDER_SINGLE: f32 = 12_582_912.0;

/// ln 2, and what rounding took from it.
const LN_2: [f32; 2] = [std::f32::consts::LN_2, -1.904_654_2e-9];

/// (eʳ − 1 − r)/r².
const EXP: [f32; 5] = [0.5, 0.166_665_2, 0.041_666_213, 0.008_368_882, 0.001_395_010_7];
/// (2 artanh s − 2s)/s³, in s².
const ARTANH: [f32; 3] = [0.666_667_76, 0.399_777_65, 0.298_666_33];
/// (sin r − r)/r³, in r².
const SIN: [f32; 3] = [-0.166_666_55, 0.008_332_18, -0.000_195_175_07];
/// (cos r − 1 + r²/2)/r⁴, in r².
const COS: [f32; 3] = [0.041_666_646, -0.001_388_737_8, 2.443_949_8e-5];

#[inline(always)]
fn select(choice: bool, a: f32, b: f32) -> f32 {
    if choice { a } else { b }
}

#[inline(always)]
fn polynomial<const N: usize>(c: &[f32; N], x: f32) -> f32 {
    let mut sum = c[N - 1];
    for i in (0..N - 1).rev() {
        sum = sum.mul_add(x, c[i]);
    }
    sum
}

/// k, in the last digits of a float, r and eʳ − 1 − r, for x = k ln 2 + r.
#[inline(always)]
fn powers(x: f32) -> (f32, f32, f32) {
    let rounded = x.mul_add(std::f32::consts::LOG2_E, ROUNDER_SINGLE);
    let k = rounded - ROUNDER_SINGLE;
    let near = (-k).mul_add(LN_2[0], x); // exact
    let r = (-k).mul_add(LN_2[1], near);
    let low = (-k).mul_add(LN_2[1], near - r);
    (rounded, r, (r * r).mul_add(polynomial(&EXP, r), low))
}

/// 2^−`less` eˣ.
#[inline(always)]
fn exp_over(less: u32, x: f32) -> f32 {
    let x = select(x > 91.0, 91.0, x); // not a number stays so
    let (rounded, r, curved) = powers(select(x < -105.0, -105.0, x));
    let exponents = rounded.to_bits().wrapping_sub(ROUNDER_SINGLE.to_bits()).wrapping_add(2 * 127 - less);
    let half = exponents >> 1;
    let power = |exponent: u32| f32::from_bits(exponent << 23);
    (1.0 + (r + curved)) * power(half) * power(exponents.wrapping_sub(half))
}

/// eˣ − 1 for 0 ≤ x < 80, and what rounding took from it.
#[inline(always)]
fn exp_less_one(x: f32) -> [f32; 2] {
    let (rounded, r, curved) = powers(x);
    let p = r + curved;
    let p_low = (r - p) + curved;
    let power = f32::from_bits(rounded.to_bits().wrapping_add(127) << 23);
    let (whole, part) = (power - 1.0, p * power);
    let t = whole + part;
    [t, p_low.mul_add(power, (whole - t) + part)]
}

/// eˣ.
#[inline(always)]
pub(in crate::number) fn exp(x: f32) -> f32 {
    exp_over(0, x)
}

/// cosh x.
#[inline(always)]
pub(in crate::number) fn cosh(x: f32) -> f32 {
    let half = exp_over(1, x.abs());
    half + 0.25 / half
}

/// sinh x.
#[inline(always)]
pub(in crate::number) fn sinh(x: f32) -> f32 {
    let size = x.abs();
    let large = size > 10.0; // e⁻²ˣ is lost
    let [t, low] = exp_less_one(select(large, 10.0, size));
    let inverse = 1.0 / (t + 1.0);
    let low = (inverse * inverse).mul_add(low, low);
    select(large, exp_over(1, size), 0.5 * (t + t.mul_add(inverse, low))).copysign(x)
}

/// tanh x.
#[inline(always)]
pub(in crate::number) fn tanh(x: f32) -> f32 {
    let size = x.abs();
    let [t, low] = exp_less_one(2.0 * select(size > 10.0, 10.0, size));
    let below = t + 2.0;
    let below_low = (2.0 - below) + t;
    let tanh = t / below;
    // To t, over t + 2 = 2/(1 − tanh), of which no digits are left near 1.
    let missing = select(below < 1e5, (-tanh).mul_add(low + below_low, low), 0.0);
    missing.mul_add((-0.5_f32).mul_add(tanh, 0.5), tanh).copysign(x)
}

/// (sin x, cos x); not a number beyond [`FARTHEST_ANGLE`].
#[inline(always)]
pub(in crate::number) fn sin_cos(x: f32) -> (f32, f32) {
    let far = f64::from(x);
    let far = if far.abs() <= FARTHEST_ANGLE { far } else { f64::NAN };
    let rounded = far.mul_add(std::f64::consts::FRAC_2_PI, ROUNDER);
    let k = rounded - ROUNDER;
    let r = (-k).mul_add(HALF_PI[1], (-k).mul_add(HALF_PI[0], far)) as f32;
    let square = r * r;
    let sine = (r * square).mul_add(polynomial(&SIN, square), r);
    let sine = select(r == 0.0, r, sine); // the sign of zero
    let half = 0.5 * r;
    let most = (-half).mul_add(r, 1.0);
    let rest = (-half).mul_add(r, 1.0 - most); // exact
    let cosine = most + (square * square).mul_add(polynomial(&COS, square), rest);
    let turns = rounded.to_bits() as u32; // quarters of a turn
    let odd = turns & 1 != 0;
    let signed = |x: f32, sign: u32| f32::from_bits(x.to_bits() ^ ((sign & 2) << 30));
    (signed(select(odd, cosine, sine), turns), signed(select(odd, sine, cosine), turns.wrapping_add(1)))
}

/// sin x.
#[inline(always)]
pub(in crate::number) fn sin(x: f32) -> f32 {
    sin_cos(x).0
}

/// cos x.
#[inline(always)]
pub(in crate::number) fn cos(x: f32) -> f32 {
    sin_cos(x).1
}

/// ln x.
#[inline(always)]
pub(in crate::number) fn ln(x: f32) -> f32 {
    let root_half = std::f32::consts::FRAC_1_SQRT_2.to_bits();
    let tiny = x < f32::MIN_POSITIVE;
    let scaled = select(tiny, x * 33_554_432.0, x); // by 2²⁵
    let bits = scaled.to_bits().wrapping_add(1.0_f32.to_bits() - root_half);
    // An integer below 2²³ in the last digits of 2²³.
    let k = f32::from_bits((bits >> 23) | 8_388_608.0_f32.to_bits()) - 8_388_608.0;
    let k = k - select(tiny, 127.0 + 25.0, 127.0);
    let f = f32::from_bits((bits & ((1 << 23) - 1)).wrapping_add(root_half)) - 1.0;
    let s = f / (2.0 + f);
    let square = s * s;
    let half = 0.5 * f * f;
    let curved = s.mul_add(square.mul_add(polynomial(&ARTANH, square), half), k * LN_2[1]);
    let finite = k.mul_add(LN_2[0], f - (half - curved));
    let finite = select(x == 0.0, f32::NEG_INFINITY, select(x < 0.0, f32::NAN, finite));
    select(x < f32::INFINITY, finite, x)
}

macro_rules! rounded {
    ($($name:ident($($x:ident),*))*) => {$(
        #[inline(always)]
        pub(in crate::number) fn $name($($x: f32),*) -> f32 {
            super::$name($(f64::from($x)),*) as f32
        }
    )*};
}
rounded! {
    tan(x) asin(x) acos(x) atan(x) asinh(x) acosh(x) atanh(x) log2(x) log10(x) cbrt(x) erf(x)
    powf(x, y) atan2(y, x) hypot(x, y)
}
