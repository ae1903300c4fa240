//! When a lane is at rest: after the last correction less is left than places are rounded.

use crate::kernel::rounding::{along_and_most, size_along_square, size_of_terms};
use crate::number::lanes::{Lane, is_finite};
use crate::number::vector::largest;
use crate::solve::crowd::EVERY;
use crate::systems::surface::tiles::AT_REST;

/// After so many steps it is measured again how large places are. In the meantime they may come nearer by some times.
pub(super) const fn measured_every<S: Lane>() -> u64 {
    if is_single::<S>() { EVERY / 8 } else { EVERY }
}

/// So many roundings may be left to the last correction; in single precision, where their square is more of a rounding,
/// an eighth.
const fn roundings<S: Lane>() -> f64 {
    if is_single::<S>() { AT_REST / 8.0 * S::EPSILON } else { AT_REST * S::EPSILON }
}

/// The least of numbers whose digits are whole.
const fn least<S: Lane>() -> f64 {
    if is_single::<S>() { f32::MIN_POSITIVE as f64 } else { f64::MIN_POSITIVE }
}

/// Whether squares of displacements tell who is at rest, where places and the way of a step are of this size: they do
/// not where those of rounding are less than the least of numbers. In the origin there is nothing to tell.
#[inline(always)]
pub(super) fn squares_tell<S: Lane>(size: S) -> bool {
    let rounding = S::from_f64(const { roundings::<S>() }) * size;
    size == S::default() || S::from_f64(const { least::<S>() }).le(rounding * rounding)
}

const fn is_single<S: Lane>() -> bool {
    S::EPSILON > f64::EPSILON
}

/// What a displacement may be at rest, squared: that of so many roundings of [how large](size_along_square) coordinates
/// are along the normal; in the origin the least of numbers. Nothing where that is no number: then no lane rests before
/// it is corrected by itself.
#[inline(always)]
pub(super) fn rest_square<S: Lane, const D: usize>(gradient: &[S; D], square: S, q: &[S; D]) -> S {
    let part = const { roundings::<S>() * roundings::<S>() };
    let least = const { least::<S>() };
    let size_square = size_along_square(gradient, S::from_f64(1.0) / square, q);
    let most = (S::from_f64(part) * size_square).max(S::from_f64(least));
    S::select(is_finite(size_square), most, S::default())
}

/// What |g| may be at rest: that of so many roundings of the [size of its terms](size_of_terms), with |q|∞ |∇g|∞ for
/// the largest, which is |∇g| |q| to a factor of √3 in space.
#[inline(always)]
pub(super) fn at_rest<S: Lane, const D: usize>(gradient: &[S; D], q: &[S; D]) -> S {
    let (along, farthest) = along_and_most(gradient, q);
    let part = const { roundings::<S>() };
    S::from_f64(part) * size_of_terms(along, S::default(), largest(gradient) * farthest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::lanes::Fused;

    /// Who rests in the origin rests; and nobody where nothing is a number.
    #[test]
    fn in_the_origin_and_where_there_are_no_numbers() {
        let double =
            |q: f64, n: f64| rest_square(&[Fused(n), Fused(0.0)], Fused(n * n), &[Fused(q), Fused(0.0)]).0;
        let expected = (256.0 * f64::EPSILON).powi(2);
        assert!((double(1.0, 2.0) / expected - 1.0).abs() < 1e-15 && double(0.0, 2.0) > 0.0);
        assert_eq!([double(f64::NAN, 1.0), double(1e200, 1.0), double(1.0, 0.0)], [0.0; 3]);
        let single = |q: f32| rest_square(&[Fused(1.0), Fused(0.0)], Fused(1.0), &[Fused(q), Fused(0.0)]).0;
        assert!(single(1e-25) > 0.0 && single(0.0) > 0.0 && single(1e30) == 0.0);
        assert!((single(1.0) / (32.0 * f32::EPSILON).powi(2) - 1.0).abs() < 1e-6);
    }
}
