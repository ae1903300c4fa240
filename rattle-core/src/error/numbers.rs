//! Numbers that messages show.

use std::fmt;

/// A step size that works where a longer one failed, found by trying; `None` if none was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passing(pub Option<f64>);

impl fmt::Display for Passing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(h) => write!(f, "a step of {h:.3e} passes here"),
            None => f.write_str("no shorter step passes here either"),
        }
    }
}

/// A list of numbers; the first eight are printed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct History(Vec<f64>);

impl History {
    /// The numbers in order.
    #[must_use]
    pub fn as_slice(&self) -> &[f64] {
        &self.0
    }
    /// The number of numbers.
    #[must_use]
    pub fn len(&self) -> usize {
        self.0.len()
    }
    /// Whether the list is empty.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl FromIterator<f64> for History {
    fn from_iter<I: IntoIterator<Item = f64>>(numbers: I) -> Self {
        Self(numbers.into_iter().collect())
    }
}

impl fmt::Display for History {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("[")?;
        for (i, x) in self.0.iter().take(8).enumerate() {
            write!(f, "{}{x:.1e}", if i == 0 { "" } else { ", " })?;
        }
        f.write_str(if self.0.len() > 8 { ", …]" } else { "]" })
    }
}

/// So many of them, in words.
pub(crate) fn many(number: usize, one: &str, more: &str) -> String {
    format!("{number} {}", if number == 1 { one } else { more })
}

/// A number with so many digits after the point; a very large one with its power of ten, not with all its digits.
pub(crate) struct Digits(pub(crate) f64, pub(crate) usize);

impl fmt::Display for Digits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(x, digits) = *self;
        if x.abs() < 1e6 { write!(f, "{x:.digits$}") } else { write!(f, "{x:.digits$e}") }
    }
}

/// A number with all its digits; a very large or very small one with its power of ten, not with its zeros.
pub(crate) struct Short(pub(crate) f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(x) = *self;
        let plain = x == 0.0 || !x.is_finite() || (1e-4..1e16).contains(&x.abs());
        if plain { write!(f, "{x}") } else { write!(f, "{x:e}") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_however_large() {
        let texts = [0.0104, 999_999.0, -1e200, f64::INFINITY].map(|x| Digits(x, 3).to_string());
        assert_eq!(texts, ["0.010", "999999.000", "-1.000e200", "inf"]);
    }
}
