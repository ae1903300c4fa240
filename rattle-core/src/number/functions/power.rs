//! xʸ = exp(y ln x), with the logarithm and the product as pairs.

use crate::number::functions::arithmetic::{product, select};
use crate::number::functions::exponential::exp_of_pair;
use crate::number::functions::logarithm::ln_to_a_pair;

/// Beyond it on either side eˣ is 0 or infinite.
const FAR: f64 = 800.0;

/// xʸ, with the exceptions of IEEE 754's pow: 1 for y = 0 and for x = 1 whatever the other is, and a negative x has
/// powers where y is a whole number.
#[inline(always)]
pub(in crate::number) fn powf(x: f64, y: f64) -> f64 {
    let size = x.abs();
    let [ln, ln_low] = ln_to_a_pair(size);
    let [inside, rest] = product(y, ln);
    let upwards = select(y > 0.0, FAR, -FAR);
    let ends = select(size == 0.0, -upwards, select(size == 1.0, 0.0, upwards));
    let end = (size == 0.0) | (size == 1.0) | (size == f64::INFINITY);
    let exponent = select(end, ends, inside);
    let near = !end & (exponent.abs() < FAR);
    let power = exp_of_pair([exponent, select(near, y.mul_add(ln_low, rest), 0.0)]);

    let whole = y.floor() == y;
    let half = 0.5 * y;
    let odd = whole & (half.floor() != half);
    let signed = select(odd, power.copysign(x), power);
    let wrong = ((x < 0.0) & (x > f64::NEG_INFINITY) & !whole) | x.is_nan() | y.is_nan();
    select((y == 0.0) | (x == 1.0), 1.0, select(wrong, f64::NAN, signed))
}
