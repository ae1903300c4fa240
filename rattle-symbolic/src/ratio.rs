//! Exact constants: exponents such as 3/2, and indices.

use std::cmp::Ordering;
use std::fmt::{self, Display, Formatter};

/// A fraction in lowest terms. What does not fit is no fraction.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Ratio {
    above: i64,
    below: i64,
}

impl Ratio {
    fn new(above: i128, below: i128) -> Option<Ratio> {
        let divisor = gcd(above.unsigned_abs(), below.unsigned_abs());
        let divisor = i128::try_from(divisor).ok().filter(|&divisor| divisor != 0)?;
        let sign = below.signum();
        let (above, below) = (sign * above / divisor, sign * below / divisor);
        Some(Ratio {
            above: i64::try_from(above).ok()?,
            below: i64::try_from(below).ok().filter(|&n| n > 0)?,
        })
    }
    /// Reads `2`, `0.5` or `1e3`.
    pub(crate) fn parse(digits: &str) -> Option<Ratio> {
        let (digits, exponent) = match digits.split_once(['e', 'E']) {
            Some((digits, exponent)) => (digits, exponent.parse::<i32>().ok()?),
            None => (digits, 0),
        };
        let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
        let above: i128 = format!("0{whole}{fraction}").parse().ok()?;
        let shift = exponent.checked_sub(i32::try_from(fraction.len()).ok()?)?;
        let power = 10_i128.checked_pow(shift.unsigned_abs())?;
        if shift < 0 { Ratio::new(above, power) } else { Ratio::new(above.checked_mul(power)?, 1) }
    }
    /// The whole number, if it is one.
    pub(crate) fn whole(self) -> Option<i64> {
        (self.below == 1).then_some(self.above)
    }
    /// The whole number of n-ths, if it is one.
    pub(crate) fn parts(self, n: i64) -> Option<i64> {
        (n % self.below == 0).then(|| self.above.checked_mul(n / self.below))?
    }
    /// The nearest number.
    pub(crate) fn value(self) -> f64 {
        const EXACT: u64 = 1 << f64::MANTISSA_DIGITS;
        if self.above.unsigned_abs() <= EXACT && self.below.unsigned_abs() <= EXACT {
            return self.above as f64 / self.below as f64;
        }
        // 64 bits of the quotient or more, the last of them set if any were to follow: rounded once.
        let (above, below) = (u128::from(self.above.unsigned_abs()), u128::from(self.below.unsigned_abs()));
        let shift = above.leading_zeros();
        let quotient = ((above << shift) / below) | u128::from((above << shift) % below != 0);
        let size = quotient as f64 / 2_f64.powi(shift as i32);
        if self.above < 0 { -size } else { size }
    }
    pub(crate) fn negative(self) -> Option<Ratio> {
        Ratio::new(-i128::from(self.above), i128::from(self.below))
    }
    pub(crate) fn reciprocal(self) -> Option<Ratio> {
        Ratio::new(i128::from(self.below), i128::from(self.above))
    }
    pub(crate) fn plus(self, other: Ratio) -> Option<Ratio> {
        let (a, b, c, d) = self.crossed(other);
        Ratio::new(a * d + c * b, b * d)
    }
    pub(crate) fn times(self, other: Ratio) -> Option<Ratio> {
        let (a, b, c, d) = self.crossed(other);
        Ratio::new(a * c, b * d)
    }
    pub(crate) fn power(self, exponent: i64) -> Option<Ratio> {
        let base = if exponent < 0 { self.reciprocal()? } else { self };
        let exponent = u32::try_from(exponent.unsigned_abs()).ok()?;
        Some(Ratio { above: base.above.checked_pow(exponent)?, below: base.below.checked_pow(exponent)? })
    }
    pub(crate) fn compare(self, other: Ratio) -> Ordering {
        let (a, b, c, d) = self.crossed(other);
        (a * d).cmp(&(c * b))
    }
    fn crossed(self, other: Ratio) -> (i128, i128, i128, i128) {
        (self.above.into(), self.below.into(), other.above.into(), other.below.into())
    }
}

impl From<i64> for Ratio {
    fn from(whole: i64) -> Ratio {
        Ratio { above: whole, below: 1 }
    }
}

impl Display for Ratio {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.below {
            1 => write!(f, "{}", self.above),
            below => write!(f, "{}/{below}", self.above),
        }
    }
}

fn gcd(a: u128, b: u128) -> u128 {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_and_reduces() {
        for (text, expected) in
            [("2", "2"), ("0.5", "1/2"), ("1.50", "3/2"), ("1e3", "1000"), ("25e-1", "5/2")]
        {
            assert_eq!(Ratio::parse(text).map(|ratio| ratio.to_string()).as_deref(), Some(expected));
        }
        for text in [
            "0.3", "1.94109590902704654", "0.97367621259556569", "0.18993407926227499", "0.97297597543396552",
        ] {
            let value = Ratio::parse(text).map(|ratio| ratio.value());
            assert_eq!(value, text.parse().ok(), "{text}");
        }
        assert_eq!(Ratio::parse("1e40"), None);
        assert_eq!(Ratio::from(0).reciprocal(), None);
        assert_eq!(Ratio::parse("1.5").and_then(|ratio| ratio.parts(2)), Some(3));
    }
}
