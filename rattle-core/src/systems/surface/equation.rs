//! The equation of one body, as the solver sees it.

use crate::kernel::functions::ConstraintKernel;
use crate::kernel::kinks::{first_kink, sign_changes};
use crate::kernel::rounding::SHIFTS;
use crate::number::real::Scalar;
use crate::number::vector::{add_scaled, dot};
use crate::solve::aim::noise_of_terms;

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
    /// Whether a kink lies between two places.
    fn kinks(&self, from: &[T; D], to: &[T; D]) -> bool;
    /// pᵀ∇²g p.
    fn bend(&self, q: &[T; D], p: &[T; D]) -> T;
}

impl<T: Scalar, K: ConstraintKernel<T, D, 1>, const D: usize> Equation<T, D> for K {
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

    fn kinks(&self, from: &[T; D], to: &[T; D]) -> bool {
        if const { K::KINKS.is_empty() } {
            return false;
        }
        let exact = |place: &[T; D]| [place.map(T::to_f64)];
        sign_changes(self, &[*from], &[*to])
            && first_kink::<T, _, D, 1, 1>(self, &exact(from), &exact(to)).is_some()
    }

    #[inline(always)]
    fn bend(&self, q: &[T; D], p: &[T; D]) -> T {
        let [bend] = self.jet(q, p).2;
        bend
    }
}

/// The rounding of g itself at a place, as a multiple of ∇g = n: by how much g is no parabola along the normal where
/// the place is moved by some roundings of this size. The farthest move tells how the surface bends.
#[cold]
#[inline(never)]
pub(crate) fn rounding_of<T: Scalar, const D: usize>(
    equation: &dyn Equation<T, D>,
    q: &[T; D],
    n: &[T; D],
    size: T,
) -> T {
    let over = T::from_f64(1.0) / dot(n, n);
    let unit = T::from_f64(T::EPSILON) * size * over.sqrt();
    let off = |share: f64| {
        let shift = T::from_f64(share) * unit;
        equation.value(&add_scaled(q, shift, n)) * over - shift
    };
    let [farthest, nearer @ ..] = SHIFTS;
    let middle = off(0.0);
    let bent = off(farthest) - middle;
    let most = |most: T, share: f64| {
        let part = share / farthest;
        most.max((off(share) - middle - T::from_f64(part * part) * bent).abs())
    };
    nearer.into_iter().fold(T::from_f64(0.0), most)
}

/// Whether what is off by so many ∇g = n is so by the rounding of g, whose [terms](noise_of_terms) may be larger than
/// places of this size.
#[cold]
#[inline(never)]
pub(crate) fn is_rounding<T: Scalar, const D: usize>(
    equation: &dyn Equation<T, D>,
    q: &[T; D],
    n: &[T; D],
    size: T,
    off: T,
) -> bool {
    let length = dot(n, n).sqrt().to_f64();
    let rounding = |size: f64| length * rounding_of(equation, q, n, T::from_f64(size)).to_f64();
    off.abs().to_f64() * length <= noise_of_terms::<T>(size.to_f64(), rounding)
}
