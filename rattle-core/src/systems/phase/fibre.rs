//! Motion along a fibre: the flow with the Hamiltonian −σ·g for the time 1.
//!
//! ```text
//! q̇ = −∂(σ·g)/∂p      ṗ = ∂(σ·g)/∂q
//! ```
//!
//! The fibres of a general constraint have no formula, so the flow is computed to rounding by the Gauss method of five
//! stages, order 10. The method is symmetric and conserves quadratic g; its steps are so short that the error is below
//! 1e-16 of the motion, where 256 of them suffice for that. For g(q) the flow is the kick p + Gᵀσ.

use crate::kernel::functions::PhaseConstraintKernel;
use crate::systems::phase::point::Point;
use std::array::from_fn;

/// Stages of the method.
pub(crate) const STAGES: usize = 5;

/// Coefficients of the Gauss method (J. Butcher 1964), from the zeros of the Legendre polynomial.
pub(crate) const A: [[f64; STAGES]; STAGES] = [
    [
        0.059_231_721_264_047_27, -0.019_570_364_359_076_04, 0.011_254_400_818_642_956,
        -0.005_593_793_660_812_185, 0.001_588_112_967_865_998_5,
    ],
    [
        0.128_151_005_670_045_28, 0.119_657_167_624_841_62, -0.024_592_114_619_642_2,
        0.010_318_280_670_683_357, -0.002_768_994_398_769_603,
    ],
    [
        0.113_776_288_004_224_6, 0.260_004_651_680_641_5, 0.142_222_222_222_222_22,
        -0.020_690_316_430_958_285, 0.004_687_154_523_869_941,
    ],
    [
        0.121_232_436_926_864_15, 0.228_996_054_578_999_88, 0.309_036_559_064_086_6,
        0.119_657_167_624_841_62, -0.009_687_563_141_950_74,
    ],
    [
        0.116_875_329_560_228_55, 0.244_908_128_910_495_42, 0.273_190_043_625_801_5,
        0.258_884_699_608_759_27, 0.059_231_721_264_047_27,
    ],
];
/// The weights of the stages.
pub(crate) const B: [f64; STAGES] = [
    0.118_463_442_528_094_54, 0.239_314_335_249_683_23, 0.284_444_444_444_444_44, 0.239_314_335_249_683_23,
    0.118_463_442_528_094_54,
];

/// What the stages hold of the Legendre polynomials of the third and of the fourth degree.
pub(crate) const DETAILS: [[f64; STAGES]; 2] = details();
/// A part is halved where these are more than the third and the fourth power of this part of the motion: the next ones
/// would be the fifth, and the error, as large as the tenth, stays below 1e-16 of the motion.
pub(crate) const DECAY: f64 = 0.025;
/// Parts whose stages come nearer by less than this factor are halved, too: that takes less time.
pub(crate) const CONTRACTION: f64 = 0.25;
/// What is left of a change is nothing below this part of it: a sixteenth of a rounding.
pub(crate) const LEFT: f64 = f64::EPSILON / 16.0;
/// What no longer shrinks is rounding below this part.
pub(crate) const ROUNDING: f64 = 1e-13;
/// No pass is trusted to shrink what is left by more than this.
pub(crate) const SHRINKS: f64 = 1e-3;
/// Passes over the stages; with that factor a dozen suffice.
const MAX_PASSES: usize = 30;
/// Parts beyond which a motion is given up: some hundred radians, where a step needs a fraction of one. So many parts
/// need not be smooth: a kink of the field does not become so.
const MAX_PARTS: u32 = 1 << 8;

const fn details() -> [[f64; STAGES]; 2] {
    let (mut details, mut i) = ([[0.0; STAGES]; 2], 0);
    while i < STAGES {
        let [a, b, c, d, e] = A[i];
        let x = 2.0 * (a + b + c + d + e) - 1.0;
        details[0][i] = 7.0 * B[i] * x * (5.0 * x * x - 3.0) / 2.0;
        details[1][i] = 9.0 * B[i] * ((35.0 * x * x - 30.0) * x * x + 3.0) / 8.0;
        i += 1;
    }
    details
}

/// (−∂gₘ/∂p, ∂gₘ/∂q) at each stage.
type Directions<const D: usize, const M: usize> = [[Point<D>; M]; STAGES];

/// Slides from one point. Each begins with the directions of the last one.
pub(super) struct Slides<const D: usize, const M: usize> {
    last: Option<Directions<D, M>>,
}

impl<const D: usize, const M: usize> Slides<D, M> {
    pub(super) fn new() -> Self {
        Self { last: None }
    }

    /// The change of `start` along the fibre by σ. None if the field is not finite on the way.
    pub(super) fn slide<K: PhaseConstraintKernel<f64, D, M>>(
        &mut self,
        constraint: &K,
        start: &Point<D>,
        sigma: &[f64; M],
    ) -> Option<Point<D>> {
        if *sigma == [0.0; M] {
            return Some(Point::ZERO);
        }
        if let Some(mut directions) = self.last.take()
            && let Some(change) = part(constraint, start, &Point::ZERO, sigma, &mut directions, true)
        {
            self.last = Some(directions);
            return Some(change);
        }
        let halvings = std::iter::successors(Some(1), |parts| (*parts < MAX_PARTS).then_some(2 * parts));
        halvings.into_iter().find_map(|parts: u32| {
            let share = sigma.map(|sigma| sigma / f64::from(parts));
            (0..parts).try_fold(Point::ZERO, |before, _| {
                let mut directions = [directions(constraint, &start.plus(&before)); STAGES];
                let is_last = parts == MAX_PARTS;
                let change = part(constraint, start, &before, &share, &mut directions, !is_last);
                self.last = (parts == 1).then_some(directions);
                change
            })
        })
    }
}

/// The change after one more part, begun with these directions; none if its stages come nearer too slowly, or if it is
/// to be smooth and is not.
fn part<K: PhaseConstraintKernel<f64, D, M>, const D: usize, const M: usize>(
    constraint: &K,
    start: &Point<D>,
    before: &Point<D>,
    sigma: &[f64; M],
    directions: &mut Directions<D, M>,
    smooth: bool,
) -> Option<Point<D>> {
    let mut speeds = directions.map(|directions| speed(&directions, sigma));
    let reach = start.plus(before).sizes();
    let mut sizes = speeds.iter().fold([0.0; 2], |sizes, speed| larger(&sizes, &speed.sizes()));
    let (mut weights, mut last, mut rate) = ([UNMOVED; 2], [f64::INFINITY; 2], 0.0_f64);
    for pass in 0..MAX_PASSES {
        let (mut off, old) = ([0.0; 2], speeds);
        for (i, row) in A.iter().enumerate() {
            let inner = combined(&old, row).plus(before);
            directions[i] = self::directions(constraint, &start.plus(&inner));
            speeds[i] = speed(&directions[i], sigma);
            off = larger(&off, &speeds[i].minus(&old[i]).sizes());
            sizes = larger(&sizes, &speeds[i].sizes());
        }
        for i in 0..2 {
            // Also what begins to move later.
            if weights[i] == UNMOVED && sizes[i] > 0.0 {
                (weights[i], last) = (weight(sizes[i], reach[i]), [f64::INFINITY; 2]);
            }
        }
        let weighed = |[q, p]: [f64; 2]| (weights[0] * q).max(weights[1] * p);
        let (moved, size) = (weighed(off), weighed(sizes));
        // Where passes move positions and momenta in turn, the slower of two tells what is left.
        let slower = rate;
        rate = (moved / last[1]).max(SHRINKS);
        let still = moved <= f64::EPSILON * size || (pass > 0 && rate.max(slower) * moved <= LEFT * size);
        if still || (pass > 1 && moved >= 0.5 * last[1] && moved <= ROUNDING * size) {
            let detail = |n: usize| weighed(combined(&speeds, &DETAILS[n]).sizes());
            let is_smooth = detail(0) <= DECAY.powi(3) * size && detail(1) <= DECAY.powi(4) * size;
            return (is_smooth || !smooth).then(|| combined(&speeds, &B).plus(before));
        }
        if !moved.is_finite() || (moved > CONTRACTION * CONTRACTION * last[0] && moved > ROUNDING * size) {
            return None;
        }
        last = [last[1], moved];
    }
    None
}

/// Σ wᵢ Kᵢ.
fn combined<const D: usize>(speeds: &[Point<D>; STAGES], weights: &[f64; STAGES]) -> Point<D> {
    speeds.iter().zip(weights).fold(Point::ZERO, |sum, (speed, weight)| sum.plus(&speed.times(*weight)))
}

/// The larger ones.
#[inline(always)]
fn larger(a: &[f64; 2], b: &[f64; 2]) -> [f64; 2] {
    [a[0].max(b[0]), a[1].max(b[1])]
}

/// By what changes of coordinates, or of momenta, count: one over the root of how large they are times how large their
/// motion along the fibre is. Where momenta move by a·q and coordinates by b·p, these are as √b and √a, so that changes
/// of both count alike. That does not depend on units, whose squares may be no numbers.
fn weight(motion: f64, reach: f64) -> f64 {
    1.0 / (motion.sqrt() * reach.max(motion).sqrt())
}

/// The weight of what has not moved yet.
const UNMOVED: f64 = 0.0;

/// (−∂gₘ/∂p, ∂gₘ/∂q).
fn directions<K: PhaseConstraintKernel<f64, D, M>, const D: usize, const M: usize>(
    constraint: &K,
    at: &Point<D>,
) -> [Point<D>; M] {
    let (by_q, by_p) = constraint.jacobians(&at.q, &at.p);
    from_fn(|m| Point { q: by_p[m], p: by_q[m] }.weighted(-1.0, 1.0))
}

/// Σ σₘ times these directions.
fn speed<const D: usize, const M: usize>(directions: &[Point<D>; M], sigma: &[f64; M]) -> Point<D> {
    directions
        .iter()
        .zip(sigma)
        .fold(Point::ZERO, |sum, (direction, sigma)| sum.plus(&direction.times(*sigma)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    thread_local! {
        static EVALUATIONS: Cell<usize> = const { Cell::new(0) };
    }

    /// (q² + p²)/2: slides are rotations by σ.
    #[derive(Clone)]
    struct Circle;

    impl PhaseConstraintKernel<f64, 1, 1> for Circle {
        fn value(&self, [q]: &[f64; 1], [p]: &[f64; 1]) -> [f64; 1] {
            [0.5 * (q * q + p * p)]
        }
        fn jacobians(&self, q: &[f64; 1], p: &[f64; 1]) -> ([[f64; 1]; 1], [[f64; 1]; 1]) {
            EVALUATIONS.set(EVALUATIONS.get() + 1);
            ([*q], [*p])
        }
        fn value_and_jacobians(
            &self,
            q: &[f64; 1],
            p: &[f64; 1],
        ) -> ([f64; 1], [[f64; 1]; 1], [[f64; 1]; 1]) {
            (self.value(q, p), [*q], [*p])
        }
        fn hessian_vector(
            &self,
            _: &[f64; 1],
            _: &[f64; 1],
            dq: &[f64; 1],
            dp: &[f64; 1],
        ) -> ([[f64; 1]; 1], [[f64; 1]; 1]) {
            ([*dq], [*dp])
        }
    }

    /// The next slide begins with what the last one found, and ends where any other does: also where it is much longer,
    /// another way, or in parts. A pass of five evaluations brings nearly three digits here: six are needed from the
    /// start, one less where σ is known to three digits, two less where it is to six.
    #[test]
    fn a_nearby_slide_takes_few_evaluations() {
        let (q, p) = (0.6, -0.8_f64);
        let (start, mut slides) = (Point { q: [q], p: [p] }, Slides::new());
        let ways = [0.01, 0.010_01, 0.010_010_01, 0.0, -0.01, 0.1, 0.6, 3.0, 2.9, 0.1, 0.3, 1e-3, 0.6, 0.01];
        let taken = ways.map(|sigma: f64| {
            EVALUATIONS.set(0);
            let change = slides.slide(&Circle, &start, &[sigma]).unwrap();
            let (sin, less) = (sigma.sin(), -2.0 * (0.5 * sigma).sin().powi(2));
            let off = (change.q[0] - (q * less - p * sin)).abs() + (change.p[0] - (p * less + q * sin)).abs();
            assert!(off <= 4.0 * f64::EPSILON * sigma.abs(), "σ = {sigma}: {off:e}");
            EVALUATIONS.get()
        });
        assert_eq!(taken[..4], [31, 25, 20, 0]);
    }

    /// p²/2 − cos q.
    #[derive(Clone)]
    struct Swing;

    impl PhaseConstraintKernel<f64, 1, 1> for Swing {
        fn value(&self, [q]: &[f64; 1], [p]: &[f64; 1]) -> [f64; 1] {
            [0.5 * p * p - q.cos()]
        }
        fn jacobians(&self, [q]: &[f64; 1], p: &[f64; 1]) -> ([[f64; 1]; 1], [[f64; 1]; 1]) {
            ([[q.sin()]], [*p])
        }
        fn value_and_jacobians(
            &self,
            q: &[f64; 1],
            p: &[f64; 1],
        ) -> ([f64; 1], [[f64; 1]; 1], [[f64; 1]; 1]) {
            (self.value(q, p), [[q[0].sin()]], [*p])
        }
        fn hessian_vector(
            &self,
            [q]: &[f64; 1],
            _: &[f64; 1],
            [dq]: &[f64; 1],
            dp: &[f64; 1],
        ) -> ([[f64; 1]; 1], [[f64; 1]; 1]) {
            ([[q.cos() * dq]], [*dp])
        }
    }

    /// Slides keep g, whatever the slide before was.
    #[test]
    fn slides_keep_what_generates_them() {
        for (q, p) in [(1.16, 1.19), (0.1, 0.05), (3.0, 0.3), (-2.0, 2.0_f64)] {
            let (start, [level]) = (Point { q: [q], p: [p] }, Swing.value(&[q], &[p]));
            for first in [1e-3, 0.05, 0.0957, 0.15, 0.3] {
                for second in [0.06, 0.2, 0.5, 1.0, 1.619, -0.4, -1.2] {
                    let mut slides = Slides::new();
                    for sigma in [first, second] {
                        let change = slides.slide(&Swing, &start, &[sigma]).unwrap();
                        let [now] = Swing.value(&[q + change.q[0]], &[p + change.p[0]]);
                        let off = (now - level).abs() / (1.0 + 0.5 * p * p);
                        assert!(off <= 8.0 * f64::EPSILON, "({q}, {p}), {first}, {second}: {off:e}");
                    }
                }
            }
        }
    }

    /// p₀ + q₀p₁ + q₁².
    #[derive(Clone)]
    struct Later;

    impl PhaseConstraintKernel<f64, 2, 1> for Later {
        fn value(&self, q: &[f64; 2], p: &[f64; 2]) -> [f64; 1] {
            [p[0] + q[0] * p[1] + q[1] * q[1]]
        }
        fn jacobians(&self, q: &[f64; 2], p: &[f64; 2]) -> ([[f64; 2]; 1], [[f64; 2]; 1]) {
            ([[p[1], 2.0 * q[1]]], [[1.0, q[0]]])
        }
        fn value_and_jacobians(
            &self,
            q: &[f64; 2],
            p: &[f64; 2],
        ) -> ([f64; 1], [[f64; 2]; 1], [[f64; 2]; 1]) {
            let (by_q, by_p) = self.jacobians(q, p);
            (self.value(q, p), by_q, by_p)
        }
        fn hessian_vector(
            &self,
            _: &[f64; 2],
            _: &[f64; 2],
            dq: &[f64; 2],
            dp: &[f64; 2],
        ) -> ([[f64; 2]; 1], [[f64; 2]; 1]) {
            ([[dp[1], 2.0 * dq[1]]], [[0.0, dq[0]]])
        }
    }

    /// From the origin it moves q₀ = −σ at first, then q₁ = σ²/2, p₁ = σ³/3 and last p₀ = σ⁴/12: in 256 parts, each
    /// rounded.
    #[test]
    fn what_moves_later_slides_too() {
        for sigma in [1e-4_f64, -1e-2, 0.3, 2.0] {
            let change = Slides::new().slide(&Later, &Point::ZERO, &[sigma]).unwrap();
            let exact = [-sigma, sigma.powi(2) / 2.0, sigma.powi(4) / 12.0, sigma.powi(3) / 3.0];
            for (x, exact) in change.q.iter().chain(&change.p).zip(exact) {
                assert!((x - exact).abs() <= 64.0 * f64::EPSILON * exact.abs(), "{sigma}: {x:e}, {exact:e}");
            }
        }
    }

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
