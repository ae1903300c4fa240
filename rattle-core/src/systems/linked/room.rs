//! Working memory for methods: stages that are solved together, and power series.

use crate::effect::force::Force;
use crate::effect::list::Forces;
use crate::kernel::series::Products;
use crate::motion::table::Table;
use crate::number::vector::scaled;
use crate::systems::network::shape::Shape;
use std::array::from_fn;

/// Room for the stages: stage by stage; within a stage by body, or by row and block of all components.
#[derive(Clone)]
pub(super) struct Stages<F: Forces<f64, D>, const D: usize> {
    pub(super) q: Vec<[f64; D]>,
    pub(super) force: Vec<F::Force>,
    /// Room of the effects, for places away from those of the bodies.
    pub(super) of_effects: F::Room,
    /// f + Gᵀλ, and its change in the last evaluation.
    pub(super) total: Vec<[f64; D]>,
    pub(super) change: Vec<[f64; D]>,
    pub(super) blocks: Vec<[f64; D]>,
    pub(super) rates: Vec<f64>,
    pub(super) lambda: Vec<f64>,
    /// Residuals, then the answers of the start's normals to them.
    pub(super) right: Vec<f64>,
    /// Of one body, or one component.
    pub(super) shift: Vec<[f64; D]>,
    pub(super) x: Vec<f64>,
    pub(super) multipliers: Vec<f64>,
    /// How large coordinates are along the normals of each component.
    pub(super) sizes: Vec<f64>,
}

impl<F: Forces<f64, D>, const D: usize> Stages<F, D> {
    pub(super) fn new(stages: usize, bodies: usize, shape: &Shape<D>, effects: &F) -> Self {
        let Shape { equations, blocks, .. } = *shape;
        let zero = [0.0; D];
        Self {
            q: vec![zero; stages * bodies],
            force: vec![Force::zero(); stages * bodies],
            of_effects: effects.room(bodies),
            total: vec![zero; stages * bodies],
            change: vec![zero; stages * bodies],
            blocks: vec![zero; stages * blocks],
            rates: vec![0.0; stages * equations],
            lambda: vec![0.0; stages * equations],
            right: vec![0.0; stages * equations],
            shift: vec![zero; bodies],
            x: vec![0.0; equations],
            multipliers: vec![0.0; equations],
            sizes: vec![0.0; shape.components.len()],
        }
    }

    /// What the polynomials through the stages of the step before and the start of this one lead to.
    pub(crate) fn extrapolate<const S: usize>(&mut self, table: &Table<S>, past: &[f64], n: usize, m: usize) {
        let (total, lambda) = past.split_at(S * n * D);
        let last = S - 1;
        for stage in 1..S {
            let weights = &table.ahead[stage];
            for body in 0..n {
                let mut sum = scaled(weights[last], &self.total[body]);
                for j in 0..last {
                    let total = &total[(j * n + body) * D..][..D];
                    sum = from_fn(|d| sum[d] + weights[j] * total[d]);
                }
                self.total[stage * n + body] = sum;
            }
            for equation in 0..m {
                let before = (0..last).map(|j| weights[j] * lambda[j * m + equation]);
                self.lambda[stage * m + equation] =
                    weights[last] * self.lambda[equation] + before.sum::<f64>();
            }
        }
    }
}

/// Room for the products of all functions, of λ with n and r, and of n with v; and for coefficients of the order under
/// way.
#[derive(Debug, Clone)]
pub(super) struct SeriesRoom<const D: usize> {
    pub(super) products: Products<f64>,
    /// n in blocks, what of it multipliers act along, and r.
    pub(super) normals: Vec<[f64; D]>,
    pub(super) acting: Vec<[f64; D]>,
    pub(super) rates: Vec<f64>,
    pub(super) force: Vec<[f64; D]>,
    /// k M vₖ, M⁻¹ of what is known of it, and vₖ.
    pub(super) pull: Vec<[f64; D]>,
    pub(super) push: Vec<[f64; D]>,
    pub(super) velocity: Vec<[f64; D]>,
    pub(super) lambda: Vec<f64>,
    /// The unit of time.
    pub(super) unit: f64,
    /// Work done by moving constraints: all coefficients but the first, which is 0.
    pub(super) work: Vec<f64>,
}
