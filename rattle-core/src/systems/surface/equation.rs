//! The equation of one body, as what solves it sees it.

use crate::kernel::functions::ConstraintKernel;
use crate::number::real::Real;

/// g(q) = 0. Steps that find their root at once are compiled for each surface; what is rarely done is compiled once,
/// and given a
/// `&dyn Equation`.
pub(crate) trait Equation<T, const D: usize> {
    /// g.
    fn value(&self, q: &[T; D]) -> T;
    /// ∇g.
    fn gradient(&self, q: &[T; D]) -> [T; D];
    /// Both.
    fn value_and_gradient(&self, q: &[T; D]) -> (T, [T; D]);
    /// pᵀ∇²g p.
    fn bend(&self, q: &[T; D], p: &[T; D]) -> T;
}

impl<T: Real, K: ConstraintKernel<T, D, 1>, const D: usize> Equation<T, D> for K {
    #[inline(always)]
    fn value(&self, q: &[T; D]) -> T {
        let [g] = ConstraintKernel::value(self, q);
        g
    }

    #[inline(always)]
    fn gradient(&self, q: &[T; D]) -> [T; D] {
        let [gradient] = self.jacobian(q);
        gradient
    }

    #[inline(always)]
    fn value_and_gradient(&self, q: &[T; D]) -> (T, [T; D]) {
        let ([g], [gradient]) = self.value_and_jacobian(q);
        (g, gradient)
    }

    #[inline(always)]
    fn bend(&self, q: &[T; D], p: &[T; D]) -> T {
        let [bend] = self.jet(q, p).2;
        bend
    }
}
