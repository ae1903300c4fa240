//! What chance allows.

/// Deviations that a mean of so many independent samples may have: once in 150 000 tests.
pub const DEVIATIONS: f64 = 4.5;

/// χ² of numbers in bins against their probabilities, and the bound for its bins: the mean of χ² is their number less
/// one, its variance twice that.
pub fn fits(counts: &[f64], probabilities: &[f64]) {
    let (n, bins) = (counts.iter().sum::<f64>(), (counts.len() - 1) as f64);
    let term = |(count, p): (&f64, &f64)| (count - n * p).powi(2) / (n * p);
    let chi = counts.iter().zip(probabilities).map(term).sum::<f64>();
    assert!(chi < bins + DEVIATIONS * (2.0 * bins).sqrt(), "χ² = {chi} of {bins} bins: {counts:?}");
    assert!(chi > bins - DEVIATIONS * (2.0 * bins).sqrt(), "too good: χ² = {chi}");
}
