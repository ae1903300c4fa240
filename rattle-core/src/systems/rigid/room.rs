//! Working memory for methods: power series.

use crate::kernel::series::Products;
use crate::number::vector::{scaled, sum};

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
        let bodies = self.force.len();
        let later = self.m.iter().skip(body).step_by(bodies).skip(1);
        later.rev().fold([0.0; 3], |rest, m| scaled(h, &sum(m, &rest)))
    }
}
