//! The equation of one body, as the solver sees it.

use crate::kernel::functions::ConstraintKernel;
use crate::kernel::kinks::{first_kink, sign_changes};
use crate::number::real::Scalar;
use crate::number::vector::{add_scaled, dot};
use crate::solve::aim::{FOLLOWED, LARGER, NOISY, SHIFTS};
use crate::solve::crowd::there;

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

/// What may be taken for the rounding of g, as a multiple of ∇g = n, where its terms may be larger than places: as near
/// the origin of a large sphere through it. Places are moved by some [roundings](rounding_of) of a size that grows
/// until g follows. Nothing where it never does, as that of waves, which is bent too much.
#[cold]
#[inline(never)]
pub(crate) fn noise_of_terms<T: Scalar, const D: usize>(
    equation: &dyn Equation<T, D>,
    q: &[T; D],
    n: &[T; D],
    size: T,
) -> T {
    let (length, followed) = (dot(n, n).sqrt(), T::from_f64(FOLLOWED / f64::EPSILON * T::EPSILON));
    let [most, step] = LARGER;
    let mut times = 1.0;
    while times <= most {
        let size = T::from_f64(times) * size;
        let rounding = rounding_of(equation, q, n, size);
        if (rounding * length).le(followed * size) {
            return (T::from_f64(NOISY) * rounding).min(T::from_f64(there::<T>()) * size / length);
        }
        times *= step;
    }
    T::from_f64(0.0)
}
