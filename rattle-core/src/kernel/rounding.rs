//! What rounding does to g, as a distance across its levels, and how far off a level a place may be.

use crate::kernel::functions::ConstraintKernel;
use crate::number::real::Real;
use crate::number::vector::{add_scaled, dot};

/// The largest coordinate is too large for a floor if it is more than so many times all coordinates, each as far as it
/// moves a place along the normal. g itself is rounded too, and not to less than by the largest coordinate where all
/// take part. Where they do not, the floor is eight times larger, and a [solve](crate::solve::stop) leaves a sixteenth
/// of it: half a rounding.
pub(crate) const TERMS: f64 = 8.0;

/// How large coordinates are whose rounding moves g, times |n|: `most` of the largest times |n|, or, if that is less,
/// some times `along`, Σ|nᵢaᵢ|, and `way`, what other links move a body by, times |n|. On a plane through the origin,
/// where nothing is left, a rounding of the first.
#[inline(always)]
pub(crate) fn size_of_terms<T: Real>(along: T, way: T, most: T) -> T {
    T::from_f64(T::EPSILON).multiply_add(most, T::from_f64(TERMS).multiply_add(along, way).min(most))
}

/// Σ|nᵢaᵢ|, and the largest |aᵢ|.
#[inline(always)]
pub(crate) fn along_and_most<T: Real, const D: usize>(n: &[T; D], a: &[T; D]) -> (T, T) {
    let mut most = a[0].abs();
    let mut along = n[0].abs() * most;
    for i in 1..D {
        let size = a[i].abs();
        (along, most) = (n[i].abs().multiply_add(size, along), most.max(size));
    }
    (along, most)
}

/// The [size of terms](size_of_terms) by |n|, which is `length`, for one body without links.
#[inline(always)]
pub(crate) fn size_along<T: Real, const D: usize>(n: &[T; D], length: T, a: &[T; D]) -> T {
    let (along, most) = along_and_most(n, a);
    size_of_terms(along / length, T::from_f64(0.0), most)
}

/// The same squared, by 1/|n|², without a root.
#[inline(always)]
pub(crate) fn size_along_square<T: Real, const D: usize>(n: &[T; D], over_square: T, a: &[T; D]) -> T {
    let (along, most) = along_and_most(n, a);
    let most_square = most * most;
    let along_square = T::from_f64(TERMS * TERMS) * (along * (along * over_square));
    T::from_f64(T::EPSILON * T::EPSILON).multiply_add(most_square, along_square.min(most_square))
}

/// Positions of this size are so far apart as they are rounded, some times.
const ROUNDINGS: f64 = 16.0 * f64::EPSILON;

/// How far off a level a place may be, of coordinates of this size, and of that along the normal: that part of the
/// size, or of the distance to the next place without a normal, which is the size of the surface; or as rounding.
pub(crate) fn allowed(part: f64, [coordinates, along]: [f64; 2], singular: f64) -> f64 {
    (part * coordinates.min(singular)).max(ROUNDINGS * along) // no number is none of them
}

/// How large coordinates are along the normal, and the distance to the next place without one; from ∇g and ∇²g ∇g.
pub(crate) fn sizes<const D: usize>(q: &[f64; D], gradient: &[f64; D], bend: &[f64; D]) -> (f64, f64) {
    let square = dot(gradient, gradient);
    (size_along(gradient, square.sqrt(), q), square / dot(bend, bend).sqrt())
}

/// What is taken for rounding of g where it was found to be so many times less.
pub(crate) const NOISY: f64 = 16.0;

/// By so many roundings a body is moved to find that of g.
pub(crate) const SHIFTS: [f64; 6] = [-46368.0, -6765.0, -144.0, 21.0, 987.0, 17711.0];

/// g follows shifts by up to 46 368 roundings of a size if it is off by no more than so many roundings of that size.
pub(crate) const FOLLOWED: f64 = 2048.0;

/// By which a size grows until g follows.
pub(crate) const GROWS: f64 = 256.0;

/// The rounding of g as a distance. `bent` shifts the place along the normal, and tells by how much g is no straight
/// line there. Terms of g may be larger than the coordinates, near the origin of a large sphere say, but no larger than
/// the surface is. So the shifts are some roundings of a size that grows until g follows them. What bends the surface
/// on their way is not taken for rounding.
pub(crate) fn rounding_of_g(coordinates: f64, singular: f64, mut bent: impl FnMut(f64) -> f64) -> f64 {
    let most = if singular.is_finite() { singular } else { coordinates };
    let mut size = if coordinates > 0.0 { coordinates } else { f64::EPSILON * most };
    loop {
        let shifts = SHIFTS.map(|share| share * f64::EPSILON * size);
        let rounding = shifts
            .into_iter()
            .fold(0.0, |worst: f64, shift| worst.max(bent(shift) - shift * shift / singular));
        // Nor where that is no number.
        if !(rounding > FOLLOWED * f64::EPSILON * size && size < most) {
            return rounding;
        }
        size *= GROWS;
    }
}

/// What is taken for rounding of g at a place, as a distance, where g is of this value, and ∇g of that length.
pub(crate) fn noise_of_g<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    kernel: &K,
    q: &[f64; D],
    (value, gradient, length): (f64, &[f64; D], f64),
    singular: f64,
) -> f64 {
    let bent = |shift: f64| {
        let [there] = kernel.value(&add_scaled(q, shift / length, gradient));
        ((there - value) / length - shift).abs()
    };
    NOISY * rounding_of_g(size_along(gradient, length, q), singular, bent)
}
