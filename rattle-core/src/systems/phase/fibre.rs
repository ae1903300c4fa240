//! Motion along a fibre: the flow with the Hamiltonian −σ·g for the time 1.
//!
//! ```text
//! q̇ = −∂(σ·g)/∂p      ṗ = ∂(σ·g)/∂q
//! ```
//!
//! The fibres of a general constraint have no formula, so the flow is computed to rounding by the Gauss method of five
//! stages, order 10. The method is symmetric and conserves quadratic g; its steps are so short that the error is below
//! 1e-16 of the motion. For g(q) the flow is the kick p + Gᵀσ.

use crate::kernel::functions::PhaseConstraintKernel;
use crate::systems::phase::point::Point;
use std::array::from_fn;

/// Stages of the method.
pub(crate) const STAGES: usize = 5;

/// Coefficients of the Gauss method (J. Butcher 1964), from the zeros of the Legendre polynomial.
pub(crate) const A: [[f64; STAGES]; STAGES] = [
    [
        0.059_231_721_264_047_27,
        -0.019_570_364_359_076_04,
        0.011_254_400_818_642_956,
        -0.005_593_793_660_812_185,
        0.001_588_112_967_865_998_5,
    ],
    [
        0.128_151_005_670_045_28,
        0.119_657_167_624_841_62,
        -0.024_592_114_619_642_2,
        0.010_318_280_670_683_357,
        -0.002_768_994_398_769_603,
    ],
    [
        0.113_776_288_004_224_6,
        0.260_004_651_680_641_5,
        0.142_222_222_222_222_22,
        -0.020_690_316_430_958_285,
        0.004_687_154_523_869_941,
    ],
    [
        0.121_232_436_926_864_15,
        0.228_996_054_578_999_88,
        0.309_036_559_064_086_6,
        0.119_657_167_624_841_62,
        -0.009_687_563_141_950_74,
    ],
    [
        0.116_875_329_560_228_55,
        0.244_908_128_910_495_42,
        0.273_190_043_625_801_5,
        0.258_884_699_608_759_27,
        0.059_231_721_264_047_27,
    ],
];
/// The weights of the stages.
pub(crate) const B: [f64; STAGES] = [
    0.118_463_442_528_094_54,
    0.239_314_335_249_683_23,
    0.284_444_444_444_444_44,
    0.239_314_335_249_683_23,
    0.118_463_442_528_094_54,
];

/// Parts whose stages come nearer by less than this factor are halved: the largest eigenvalue of A is about 0.13, so
/// that the error of a part, 4e-13 x¹⁰ of it with x the relative change of the field along it, stays below 1e-16.
pub(crate) const CONTRACTION: f64 = 1.0 / 20.0;
/// Iterations of the stages; with that factor a dozen suffice.
const MAX_ITERATIONS: usize = 30;
/// Parts beyond which a motion is given up: some hundred radians, where a step needs a fraction of one.
const MAX_PARTS: u32 = 1 << 8;

/// The change of `start` along the fibre by σ. None if the field is not finite on the way.
pub(super) fn slide<K: PhaseConstraintKernel<f64, D, M>, const D: usize, const M: usize>(
    constraint: &K,
    start: &Point<D>,
    sigma: &[f64; M],
) -> Option<Point<D>> {
    let halvings = std::iter::successors(Some(1), |parts| (*parts < MAX_PARTS).then_some(2 * parts));
    halvings.into_iter().find_map(|parts: u32| {
        let share = sigma.map(|sigma| sigma / f64::from(parts));
        (0..parts).try_fold(Point::ZERO, |before, _| part(constraint, start, &before, &share))
    })
}

/// The change after one more part; none if it is too long.
fn part<K: PhaseConstraintKernel<f64, D, M>, const D: usize, const M: usize>(
    constraint: &K,
    start: &Point<D>,
    before: &Point<D>,
    sigma: &[f64; M],
) -> Option<Point<D>> {
    let first = direction(constraint, &start.plus(before), sigma);
    let mut stages = [first; STAGES];
    let (reach, mut sizes) = (start.plus(before).sizes(), first.sizes());
    let (mut weights, mut last) = ([0.0; 2], [f64::INFINITY; 2]);
    for iteration in 0..MAX_ITERATIONS {
        let mut off = [0.0; 2];
        let old = stages;
        for (stage, row) in stages.iter_mut().zip(A) {
            let inner = old.iter().zip(row).fold(*before, |sum, (stage, a)| sum.plus(&stage.times(a)));
            let new = direction(constraint, &start.plus(&inner), sigma);
            off = larger(&off, &new.minus(stage).sizes());
            sizes = larger(&sizes, &new.sizes());
            *stage = new;
        }
        if iteration == 0 {
            weights = from_fn(|i| weight(sizes[i], reach[i]));
        }
        let weighed = |[q, p]: [f64; 2]| (weights[0] * q).max(weights[1] * p);
        let (moved, size) = (weighed(off), weighed(sizes));
        if moved <= f64::EPSILON * size || (iteration > 1 && moved >= 0.5 * last[1] && moved <= 1e-13 * size)
        {
            return Some(stages.iter().zip(B).fold(*before, |sum, (stage, b)| sum.plus(&stage.times(b))));
        }
        // By two passes: where coordinates move by momenta and momenta by coordinates, one may seem to bring nothing.
        if !moved.is_finite() || (moved > CONTRACTION * CONTRACTION * last[0] && moved > 1e-13 * size) {
            return None;
        }
        last = [last[1], moved];
    }
    None
}

/// The larger ones.
#[inline(always)]
fn larger(a: &[f64; 2], b: &[f64; 2]) -> [f64; 2] {
    [a[0].max(b[0]), a[1].max(b[1])]
}

/// By what changes of coordinates, or of momenta, count: one over the root of how large they are times how large their
/// motion along the fibre is. Where momenta move by a·q and coordinates by b·p, these are as √b and √a, so that changes
/// of both count alike. That does not depend on units.
fn weight(motion: f64, reach: f64) -> f64 {
    if motion > 0.0 { 1.0 / (motion * reach.max(motion)).sqrt() } else { f64::MAX }
}

/// (−∂(σ·g)/∂p, ∂(σ·g)/∂q).
fn direction<K: PhaseConstraintKernel<f64, D, M>, const D: usize, const M: usize>(
    constraint: &K,
    at: &Point<D>,
    sigma: &[f64; M],
) -> Point<D> {
    let (by_q, by_p) = constraint.jacobians(&at.q, &at.p);
    let mut sum = Point::ZERO;
    for i in 0..M {
        sum = sum.plus(&Point { q: by_p[i], p: by_q[i] }.weighted(-sigma[i], sigma[i]));
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::{A, B, STAGES};

    /// Σⱼ aᵢⱼ cⱼᵏ⁻¹ = cᵢᵏ/k and Σ bⱼ cⱼᵏ⁻¹ = 1/k: with k to 5 and to 10 that is order 10.
    #[test]
    fn coefficients_satisfy_their_conditions() {
        let c: [f64; STAGES] = A.map(|row| row.iter().sum());
        for k in 1..=10 {
            let powers = c.map(|c| c.powi(k - 1));
            let sum =
                |row: &[f64; STAGES]| -> f64 { row.iter().zip(powers).map(|(a, power)| a * power).sum() };
            assert!((sum(&B) - 1.0 / f64::from(k)).abs() < 2.0 * f64::EPSILON, "b, {k}");
            for (row, c) in A.iter().zip(c).filter(|_| k <= 5) {
                assert!((sum(row) - c.powi(k) / f64::from(k)).abs() < 2.0 * f64::EPSILON, "a, {k}");
            }
        }
    }
}
