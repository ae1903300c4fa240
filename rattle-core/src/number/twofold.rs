//! Sums of products in twice the digits, where their last bit would add up: high + low, |low| ≤ ε |high| / 2.
//!
//! Source: T. Ogita, S. M. Rump, S. Oishi, “Accurate sum and dot product”, SIAM J. Sci. Comput. 26 (2005), algorithm
//! 5.3.

/// A number of twice the digits.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Twofold {
    pub(crate) high: f64,
    pub(crate) low: f64,
}

impl Twofold {
    /// This, and a b more.
    pub(crate) fn plus_product(self, a: f64, b: f64) -> Self {
        let product = a * b;
        let sum = self.high + product;
        let part = sum - self.high;
        let lost = (self.high - (sum - part)) + (product - part);
        Self { high: sum, low: self.low + (lost + a.mul_add(b, -product)) }
    }

    /// This, and a b more, where b has twice the digits.
    pub(crate) fn plus_multiple(self, a: f64, b: Self) -> Self {
        self.plus_product(a, b.high).plus_product(a, b.low)
    }

    /// This over another.
    pub(crate) fn over(self, other: Self) -> Self {
        let high = (self.high + self.low) / (other.high + other.low);
        let rest = self.plus_multiple(-high, other);
        Self { high, low: (rest.high + rest.low) / other.high }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cancels_leaves_the_low_part() {
        let e = f64::EPSILON;
        let square = Twofold::default().plus_product(1.0 + e, 1.0 + e).plus_product(-1.0, 1.0 + 2.0 * e);
        assert_eq!(square.high + square.low, e * e);
        let third = Twofold::default().plus_product(1.0, 1.0).over(Twofold::default().plus_product(3.0, 1.0));
        // 1/3 − fl(1/3) = 2⁻⁵⁴/3.
        assert_eq!((third.high, third.low), (1.0 / 3.0, e / 12.0));
    }
}
