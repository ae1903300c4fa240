//! The normal at a body's position, and quantities that follow from it alone.

use crate::effect::interval::Normals;
use crate::number::real::Scalar;
use crate::number::vector::{dot, scaled};

/// ∇g and 1/|∇g|² at a body's position.
#[derive(Debug, Clone, Copy)]
pub struct Normal<T, const D: usize> {
    /// ∇g(q).
    pub gradient: [T; D],
    /// 1/(∇g·∇g).
    pub inverse_square: T,
}

impl<T: Scalar, const D: usize> Normal<T, D> {
    /// The normal with gradient ∇g.
    #[inline(always)]
    pub(crate) fn new(gradient: [T; D]) -> Self {
        Self { gradient, inverse_square: T::from_f64(1.0) / dot(&gradient, &gradient) }
    }

    /// η and ∇g η such that p + ∇g η is tangent.
    #[inline(always)]
    pub(crate) fn projection(&self, p: &[T; D]) -> (T, [T; D]) {
        let eta = -dot(&self.gradient, p) * self.inverse_square;
        (eta, scaled(eta, &self.gradient))
    }
}

impl<T: Scalar, const D: usize> Normals<T, D> for &[Normal<T, D>] {
    fn normal(&self, body: usize) -> [T; D] {
        let Normal { gradient, inverse_square } = &self[body];
        scaled(inverse_square.sqrt(), gradient)
    }
}

/// λ from the second derivative of g along the motion, g̈ = vᵀ∇²g v + ∇g·q̈ = 0 with q̈ = f + ∇g λ.
#[inline(always)]
pub(crate) fn multiplier_from_curvature<T: Scalar, const D: usize>(
    bend: T,
    force_along_normal: T,
    normal: &Normal<T, D>,
) -> T {
    -(bend + force_along_normal) * normal.inverse_square
}
