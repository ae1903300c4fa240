//! Working memory for methods: stages that are solved together, and power series.

use crate::effect::force::Force;
use crate::effect::list::Forces;
use crate::motion::table::Table;
use crate::number::real::Scalar;
use crate::number::vector::{add_scaled, scaled};

use crate::kernel::series::Products;

/// Room for the stages of all bodies: positions and forces stage by stage, the rest body by body.
#[derive(Clone)]
pub(crate) struct Stages<T: Scalar, F: Forces<T, D>, const D: usize> {
    pub(super) q: Vec<[T; D]>,
    pub(super) force: Vec<F::Force>,
    /// Room of the effects, for places away from those of the bodies.
    pub(super) of_effects: F::Room,
    pub(super) normal: Vec<[T; D]>,
    /// f + ∇g λ.
    pub(super) total: Vec<[T; D]>,
    pub(super) lambda: Vec<T>,
    /// Qᵢ − q by the first guess; what rounding took from it, and how far stages have moved since.
    pub(super) increment: Vec<[T; D]>,
    pub(super) rest: Vec<[T; D]>,
    /// The inverse of the matrix, S × S.
    pub(super) inverse: Vec<T>,
}

impl<T: Scalar, F: Forces<T, D>, const D: usize> Stages<T, F, D> {
    pub(super) fn new(stages: usize, bodies: usize, effects: &F) -> Self {
        let (n, zero) = (stages * bodies, T::from_f64(0.0));
        Self {
            q: vec![[zero; D]; n],
            force: vec![Force::zero(); n],
            of_effects: effects.room(bodies),
            normal: vec![[zero; D]; n],
            total: vec![[zero; D]; n],
            lambda: vec![zero; n],
            increment: vec![[zero; D]; n],
            rest: vec![[zero; D]; n],
            inverse: vec![zero; stages * n],
        }
    }

    /// Every stage as the first: constant acceleration.
    pub(crate) fn fill<const S: usize>(&mut self) {
        for (lambda, total) in self.lambda.chunks_exact_mut(S).zip(self.total.chunks_exact_mut(S)) {
            lambda.fill(lambda[0]);
            total.fill(total[0]);
        }
    }

    /// What the polynomials through the stages of the step before and the start of this one lead to.
    #[inline(always)]
    pub(crate) fn extrapolate<const S: usize>(&mut self, table: &Table<S>, past: &[T]) {
        let (total, lambda) = past.split_at(self.total.len() * D);
        let past = lambda.chunks_exact(S).zip(total.as_chunks().0.chunks_exact(S));
        let now = self.lambda.chunks_exact_mut(S).zip(self.total.chunks_exact_mut(S));
        for ((lambda, total), (past_lambda, past_total)) in now.zip(past) {
            for stage in 1..S {
                let weights = table.ahead[stage].map(T::from_f64);
                let mut to_lambda = weights[S - 1] * lambda[0];
                let mut to_total = scaled(weights[S - 1], &total[0]);
                for j in 0..S - 1 {
                    to_lambda = to_lambda + weights[j] * past_lambda[j];
                    to_total = add_scaled(&to_total, weights[j], &past_total[j]);
                }
                (lambda[stage], total[stage]) = (to_lambda, to_total);
            }
        }
    }
}

/// Room for the products of all functions, and of λ and n and of n and v; and the forces of the order under way.
#[derive(Debug, Clone)]
pub(crate) struct SeriesRoom<T, const D: usize> {
    pub(super) products: Products<T>,
    pub(super) force: Vec<[T; D]>,
    /// The unit of time.
    pub(crate) unit: f64,
}
