//! Numbers that are one but for rounding.

/// Whether numbers between these are constant: they differ by so small a part of them that it is rounding.
pub(crate) fn is_constant(low: f64, high: f64) -> bool {
    high - low <= 1e-13 * low.abs().max(high.abs())
}
