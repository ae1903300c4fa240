//! Whether other sheets of the constraint are near, for many bodies at a time whose steps are not examined one by one.
//!
//! A guess can land on a wrong sheet of the same orientation only if the sheets are no farther apart than the error of
//! the guess, which is a part of the displacement by constraint and forces in a step. Between two such sheets g falls
//! again along the normal. So g is sampled on both sides of a body up to this distance, at irregular points, to see
//! whether it rises everywhere. On `sin(k(|q| − 1))` two of three points between sheets show that it does not. A body
//! where g does not rise is moved by itself, and each of its steps is examined (see [`crate::solve::aim`]).
//!
//! Many points are sampled at the start of a body and some from time to time, at a cost of a few percent; and many
//! where a lane of an ensemble was lost, as it is where |∇g| changes by more than a factor of two in a step, at the
//! edge of a region with other sheets. Sheets that are near only in a small region without such an edge, which a body
//! crosses between two samplings, are not found.

use crate::kernel::functions::ConstraintKernel;
use crate::number::real::{Real, Scalar};
use crate::number::vector::{add_scaled, dot};

/// After so many steps it is asked again.
pub(crate) const EVERY: u64 = 64;

/// After so many in a simulation: one step that has to be gone on from is asked about more often than a stretch that
/// can be gone through again.
pub(crate) const EVERY_ALONE: u64 = 16;

/// Who goes to a place is there within so many roundings of the size of places, or of the way: the rounding of g may be
/// some thousand of that of places.
const THERE: f64 = 65536.0;

/// Within which part of the size of places who goes to one is there; half of the digits tell of other sheets.
pub(crate) fn there<T: Real>() -> f64 {
    (THERE * T::EPSILON).min(T::EPSILON.sqrt())
}

/// At so many places it is asked at first, and again.
const AT_FIRST: u64 = 48;
const AGAIN: u64 = 6;

/// It is asked as far as so many times what the constraint takes a body back in a step, and what its forces push it, …
pub(crate) const REACH: f64 = 2.0;

/// … and this part of the path: where curvature and forces balance the constraint does nothing, and yet not the same in
/// the next step. Twice that is the most that is asked for the constraint's sake: farther no surface rises where steps
/// are long.
pub(crate) const PATH: f64 = 0.05;

/// How far it is asked: `back`, as far as the constraint takes a body back in a step, but no farther than `along`, the
/// part [`PATH`] of the path, then that part, and as far as forces push. The first and last are [`REACH`] times that.
#[inline(always)]
pub(crate) fn furthest<T: Scalar>(back: T, along: T, pushed: T) -> T {
    back.min(along) + along + pushed
}

/// √3, by which a length may be larger than its largest coordinate in space.
pub(crate) const ROOT_3: f64 = 1.732_050_807_568_877_2;

/// Of a method that does not follow its root it is asked as far as so many times what a step may have led astray, …
pub(crate) const FARTHER: f64 = 4.0;

/// … and no farther than this part of the radius in which a path is bent, where any surface turns.
pub(crate) const OF_RADIUS: f64 = 0.1;

/// Of steps that do not follow their root: how many were looked at, how far it was last asked, as a length, and whether
/// a sheet was near.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Asked {
    pub(crate) steps: u64,
    pub(crate) reach: f64,
    pub(crate) near: bool,
}

impl Asked {
    /// The steps and whether a sheet was near, in one number. Records of the first version have no steps.
    pub(crate) fn in_one(self) -> u64 {
        2 * self.steps + u64::from(self.near)
    }

    /// The same again, with how far it was asked.
    pub(crate) fn of(in_one: u64, reach: f64) -> Self {
        Self { steps: in_one / 2, reach, near: in_one % 2 == 1 }
    }

    /// After another step, which may have led so far astray: the turn of [`shares`], if it is time to ask. It is that
    /// of the first time for a sheet that was passed over, where the step may have led `times` as far astray as was
    /// asked; and to be clear of one that was near, which a few places may all miss.
    pub(crate) fn turn(&mut self, astray: f64, times: f64) -> Option<u64> {
        let steps = self.steps;
        self.steps += 1;
        let within = |times: f64| astray <= times * self.reach; // not where it is no number
        if within(1.0) && !steps.is_multiple_of(EVERY_ALONE) {
            return None;
        }
        let turn = if within(times) && !self.near { steps * (EVERY / EVERY_ALONE) } else { 0 };
        self.reach = reach(astray, self.reach);
        Some(turn)
    }
}

/// How far it is asked after a step that may have led so far astray, where it was asked so far before.
#[inline(always)]
pub(crate) fn reach<T: Scalar>(astray: T, asked: T) -> T {
    let [farther, half] = [FARTHER, 0.5].map(T::from_f64);
    (farther * astray).max(half * asked)
}

/// How many normals that is, of a normal with this square, where a path of this squared speed is bent so.
#[inline(always)]
pub(crate) fn shift<T: Scalar>(reach: T, square: T, speed_square: T, bend: T) -> T {
    let (shift, most) = (reach / square.sqrt(), T::from_f64(OF_RADIUS) * speed_square / bend.abs());
    T::select(most.le(shift), most, shift) // not where the path is straight, or none
}

/// g rises along the normal by at least this part of what it does at the body.
pub(crate) const RISES: f64 = 0.5;

/// The shares of the reach, from −1 to 1, at which it is asked after so many steps: pseudo-random, since multiples of
/// any number, and of the golden ratio too, may all meet the same phase of a wave. Each third one is its ninth power,
/// mostly small: for two or three sheets much closer than the reach.
pub(crate) fn shares(steps: u64) -> impl Iterator<Item = f64> {
    let (first, number) = if steps == 0 { (0, AT_FIRST) } else { (AT_FIRST + steps / EVERY * AGAIN, AGAIN) };
    (first..first + number).map(|n| {
        let share = mixed(n) as f64 / (1_u64 << 63) as f64 - 1.0;
        let square = share * share;
        let fourth = square * square;
        if n % 3 == 2 { fourth * fourth * share } else { share }
    })
}

/// The n-th number of the generator SplitMix64 (Steele, Lea, Flood 2014).
const fn mixed(n: u64) -> u64 {
    let z = (n + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// How much g rises along the normal n at q + shift·n, as a part of how much it does at q, less what it should:
/// negative where another sheet may be near.
#[inline(always)]
pub(crate) fn rises<S, K, const D: usize>(constraint: &K, q: &[S; D], n: &[S; D], square: S, shift: S) -> S
where
    S: Scalar,
    K: ConstraintKernel<S, D, 1>,
{
    let (_, [gradient]) = constraint.value_and_jacobian(&add_scaled(q, shift, n));
    dot(&gradient, n) - S::from_f64(RISES) * square
}

/// Whether no other sheet is near a body: g rises along the normal n at all shares of a turn of so many normals.
#[inline(always)]
pub(crate) fn is_alone<S, K, const D: usize>(
    constraint: &K,
    turn: u64,
    [q, n]: [&[S; D]; 2],
    square: S,
    furthest: S,
) -> bool
where
    S: Scalar,
    K: ConstraintKernel<S, D, 1>,
{
    shares(turn).all(|share| {
        let rises = rises(constraint, q, n, square, S::from_f64(share) * furthest);
        S::from_f64(0.0).le(rises)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first numbers of SplitMix64 from zero, as in its authors' own program.
    #[test]
    fn numbers_are_those_of_the_generator() {
        let known =
            [0xe220_a839_7b1d_cdaf, 0x6e78_9e6a_a1b9_65f4, 0x06c4_5d18_8009_454f, 0xf88b_b8a8_724c_81ec];
        assert_eq!([0, 1, 2, 3].map(mixed), known);
    }

    #[test]
    fn shares_go_on_where_the_last_ones_ended() {
        for (steps, first, number) in [(0, 0, 48), (64, 54, 6), (127, 54, 6), (128, 60, 6), (6400, 648, 6)] {
            let found: Vec<f64> = shares(steps).collect();
            assert_eq!(found.len(), number, "after {steps} steps");
            for (n, &share) in (first..).zip(&found) {
                let evenly = mixed(n) as f64 / 2.0_f64.powi(63) - 1.0;
                let expected = if n % 3 == 2 { evenly.powi(9) } else { evenly };
                assert!((share - expected).abs() <= 1e-15, "after {steps} steps number {n} is {share}");
            }
        }
    }

    #[test]
    fn it_is_asked_now_and_then_and_after_steps_that_lead_farther() {
        let ask = |near: bool, steps, astray| {
            let mut asked = Asked { steps, reach: 2.0, near };
            let turn = asked.turn(astray, 3.0);
            let again = Asked::of(asked.in_one(), asked.reach);
            assert_eq!((again.steps, again.near), (steps + 1, near));
            (turn, asked.reach)
        };
        assert_eq!([ask(false, 15, 2.0), ask(true, 17, 0.0)], [(None, 2.0); 2]);
        assert_eq!([ask(false, 32, 0.5), ask(true, 32, 0.5)], [(Some(128), 2.0), (Some(0), 2.0)]);
        assert_eq!([ask(false, 15, 6.0), ask(false, 15, 6.5)], [(Some(60), 24.0), (Some(0), 26.0)]);
        assert_eq!(ask(false, 15, f64::NAN).0, Some(0));
    }

    #[test]
    fn a_reach_halves_at_most_and_ends_where_paths_are_bent() {
        assert_eq!([reach(0.5, 2.0), reach(1.0, 8.0), reach(1.0, 10.0)], [2.0, 4.0, 5.0]);
        // A radius of speed²/bend in normals: 0.1 · 8/4, less than 3/√4; not where the path is straight, or none.
        assert_eq!(shift(3.0, 4.0, 8.0, -4.0), 0.2);
        assert_eq!(
            [shift(3.0, 4.0, 8.0, 0.0), shift(3.0, 4.0, 0.0, 0.0), shift(0.2, 4.0, 8.0, 4.0)],
            [1.5, 1.5, 0.1]
        );
    }
}
