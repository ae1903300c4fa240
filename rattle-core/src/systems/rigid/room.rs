//! Working memory for methods: power series.

use crate::kernel::series::Products;
use crate::number::vector::{add_scaled, scaled, sum};

/// Room for the products of all functions and bodies, for forces, and for the series of m.
#[derive(Debug, Clone)]
pub(super) struct SeriesRoom {
    pub(super) products: Products<f64>,
    pub(super) force: Vec<[f64; 9]>,
    pub(super) m: Vec<[f64; 3]>,
    /// The unit of time.
    pub(super) unit: f64,
}

impl SeriesRoom {
    /// Σ mₖ (h/u)ᵏ from k = 1 on, with the unit u.
    pub(super) fn impulse(&self, body: usize, h: f64) -> [f64; 3] {
        let h = h / self.unit;
        self.later(body).rev().fold([0.0; 3], |rest, m| scaled(h, &sum(m, &rest)))
    }

    /// Σ k mₖ (h/u)ᵏ⁻¹/u.
    pub(super) fn rate(&self, body: usize, h: f64) -> [f64; 3] {
        let h = h / self.unit;
        let later = self.later(body).enumerate().rev();
        let sum = later.fold([0.0; 3], |rest, (k, m)| add_scaled(&scaled(h, &rest), (k + 1) as f64, m));
        scaled(1.0 / self.unit, &sum)
    }

    /// m₁, m₂, …
    fn later(&self, body: usize) -> impl DoubleEndedIterator<Item = &[f64; 3]> + ExactSizeIterator {
        self.m.iter().skip(body).step_by(self.force.len()).skip(1)
    }
}
