//! What the functions are made of: exact sums and products of pairs, selection and polynomials.

/// 1.5·2⁵²: a number below 2⁵¹ that is added to it is rounded to an integer, which is then in its last digits.
pub(super) const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// ln 2.
pub(super) const LN_2: Pair = [std::f64::consts::LN_2, 2.319_046_813_846_299_6e-17];

/// A number and what rounding took from it: their sum is the value.
pub(super) type Pair = [f64; 2];

/// a + b for |a| ≥ |b| or a = 0, exactly (Dekker 1971).
#[inline(always)]
pub(super) fn sum(a: f64, b: f64) -> Pair {
    let sum = a + b;
    [sum, (a - sum) + b]
}

/// a + b, exactly (Knuth 1969).
#[inline(always)]
pub(super) fn sum_in_any_order(a: f64, b: f64) -> Pair {
    let sum = a + b;
    let part = sum - a;
    [sum, (a - (sum - part)) + (b - part)]
}

/// a·b, exactly.
#[inline(always)]
pub(super) fn product(a: f64, b: f64) -> Pair {
    let product = a * b;
    [product, a.mul_add(b, -product)]
}

/// a/b to twice as many digits as a float has, by one division.
#[inline(always)]
pub(super) fn quotient([a, a_low]: Pair, [b, b_low]: Pair) -> Pair {
    let inverse = 1.0 / b;
    let quotient = a * inverse;
    let rest = (-quotient).mul_add(b, a); // exact
    [quotient, (-quotient).mul_add(b_low, rest + a_low) * inverse]
}

#[inline(always)]
pub(super) fn select(choice: bool, a: f64, b: f64) -> f64 {
    if choice { a } else { b }
}

/// The smaller one; not a number where x is none.
#[inline(always)]
pub(super) fn at_most(most: f64, x: f64) -> f64 {
    select(x > most, most, x)
}

/// A polynomial, in pairs and pairs of pairs (Estrin 1960): half as long a way to the result as term by term.
#[inline(always)]
pub(super) fn polynomial<const N: usize>(c: &[f64; N], x: f64) -> f64 {
    let square = x * x;
    let fourth = square * square;
    let pair = |i: usize| if i + 1 < N { c[i + 1].mul_add(x, c[i]) } else { c[i] };
    let four = |i: usize| if i + 2 < N { pair(i + 2).mul_add(square, pair(i)) } else { pair(i) };
    let eight = |i: usize| if i + 4 < N { four(i + 4).mul_add(fourth, four(i)) } else { four(i) };
    let eighth = fourth * fourth;
    let sixteen = if N > 8 { eight(8).mul_add(eighth, eight(0)) } else { eight(0) };
    if N > 16 { eight(16).mul_add(eighth * eighth, sixteen) } else { sixteen }
}
