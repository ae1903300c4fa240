//! When an iteration ends: once the next correction is known to be far below rounding.
//!
//! Corrections are displacements; their *floor* is the rounding error of the coordinates, as far as it moves a place
//! along the normal: on a cylinder the coordinate along the axis may be as large as it likes. A solve ends when a
//! correction was at the floor, or when the error after it is known to be below [`SPARE`] of the floor: then the
//! constraint need not be evaluated again to measure it.
//!
//! A sixteenth of the floor is hidden by rounding. The table shows, for networks, the residuals of rods, computed in
//! double-double precision, as root mean square in ε of the coordinates, and the evaluations of g per step (3 000 to 12
//! 000 steps each):
//!
//! | what may be left | double pendulum, h = 0.01 | h = 0.2 | chain of 50, h = 0.01 | h = 0.1 |
//! |---|---|---|---|---|
//! | 1/16 | 0.190 ε, 2.29 | 0.196 ε, 30.9 | 0.172 ε, 2.02 | 0.176 ε, 19.2 |
//! | 1/256 | 0.187 ε, 2.49 | 0.191 ε, 32.4 | 0.172 ε, 2.14 | 0.177 ε, 20.0 |
//! | solved to the floor | 0.184 ε, 3.13 | 0.190 ε, 32.6 | 0.172 ε, 3.01 | 0.177 ε, 20.1 |
//!
//! On surfaces 40 000 steps each of the lemniscate, a torus and a gyroid end within 2.5, 9 and 1.5 ε of the surface, as
//! many where each solve goes on to the floor: that is the rounding of g (`optimised/tests/stopping.rs`). What matters
//! more than the sixteenth is that the estimate is no guess. On surfaces the normal where the solve ends, which is
//! needed anyway, tells what is left; without it some steps ended 60 and 190 ε off, with 1/256 as with 1/16. In
//! networks the slower of the last two contractions is taken; with the last one some steps ended 9 ε off instead of 3.

use crate::kernel::rounding::size_of_terms;
use crate::number::real::Scalar;
use crate::number::vector::larger;

/// What may be left of a correction when a solve ends without another evaluation, in units of the rounding floor.
pub(crate) const SPARE: f64 = 1.0 / 16.0;

/// One over a rounding of numbers of this size, or over the least number that has all digits where a rounding is less.
#[inline(always)]
pub(crate) fn over_rounding(size: f64) -> f64 {
    1.0 / larger(f64::EPSILON * size, f64::MIN_POSITIVE)
}

/// What g of a link is made of, body by body: its normal, and how large coordinates are.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Terms {
    square: f64,
    along: f64,
    way: f64,
    most: f64,
}

impl Terms {
    /// Of these normals, places and ways from there.
    #[inline(always)]
    pub(crate) fn of<'a, const D: usize>(
        terms: impl Iterator<Item = (&'a [f64; D], [f64; D], [f64; D])>,
    ) -> Self {
        let mut all = Self::default();
        for (normal, place, way) in terms {
            for i in 0..D {
                let size = larger(place[i].abs(), way[i].abs());
                all.square += normal[i] * normal[i];
                all.along += normal[i].abs() * size;
                all.way = larger(all.way, way[i].abs());
                all.most = larger(all.most, size);
            }
        }
        all
    }

    /// |∇g|.
    #[inline(always)]
    pub(crate) fn length(&self) -> f64 {
        self.square.sqrt()
    }

    /// The [size](size_of_terms) of g, where ∇g is of this length.
    #[inline(always)]
    pub(crate) fn size(&self, length: f64) -> f64 {
        size_of_terms(self.along, self.way * length, self.most * length)
    }
}

/// Stages that are solved together are done after a displacement below so many roundings. What is left of a place does
/// not count there, but what the last displacement changed forces by, since momenta are kicked by those of the places
/// before: it does work. Measured on the plane pendulum, h = 1/64, five stages: 1e-18 of the energy each step where
/// displacements below 40 are the last, 1e-19 below 1, 4e-20 below a half, at 12, 13 and 14 evaluations of g.
pub(crate) const LAST_OF_STAGES: f64 = 0.5;

/// Corrections that one matrix makes shrink by about the same factor each time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shrinking<T> {
    last: Option<T>,
    contraction: T,
}

impl<T: Scalar> Shrinking<T> {
    /// Before the first correction.
    #[inline(always)]
    pub(crate) fn start() -> Self {
        Self { last: None, contraction: T::from_f64(0.0) }
    }

    /// Notes the size of a correction. Returns by what part it is smaller than the one before, and about how much is
    /// left once it is made: by the slower of the last two contractions, since one lucky correction is not the rate.
    /// Both infinite for the first one.
    #[inline(always)]
    pub(crate) fn note(&mut self, size: T) -> (T, T) {
        let Some(last) = self.last.replace(size) else {
            return (T::from_f64(f64::INFINITY), T::from_f64(f64::INFINITY));
        };
        let contraction = size / last;
        let slower = T::select(self.contraction.le(contraction), contraction, self.contraction);
        self.contraction = contraction;
        (contraction, slower * size)
    }
}

/// The largest of some displacements stays if it is at least this part of that of as many before, and no larger than by
/// the inverse.
const STAYS: f64 = 0.75;

/// Displacements of stages that neither shrink nor grow, though they are above [`NOISE`]: they may be the rounding of
/// terms of g that are larger than coordinates. Single ones say little, as roundings differ.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stalling {
    now: f64,
    before: f64,
}

impl Stalling {
    /// Before the first displacement.
    pub(crate) const START: Self = Self { now: 0.0, before: f64::INFINITY };
    /// The largest of so many displacements is compared with that of as many before.
    pub(crate) const MOVES: usize = 8;

    /// Notes another displacement; the iteration is the number of those before. Whether they stay as large as they are.
    pub(crate) fn note(&mut self, moved: f64, iteration: usize) -> bool {
        self.now = larger(self.now, moved);
        if !(iteration + 1).is_multiple_of(Self::MOVES) {
            return false;
        }
        let stays = STAYS * self.before <= self.now && STAYS * self.now <= self.before;
        *self = Self { now: 0.0, before: self.now };
        stays
    }
}

/// The end of a step whose stages are solved together is left where equations are off by no more roundings of the
/// coordinates that reach them, times the root of their number.
pub(crate) const OFF_AT_END: f64 = 1024.0;

/// Corrections that no longer shrink by half are the rounding of the functions themselves, if they are below so many
/// roundings of the coordinates.
pub(crate) const NOISE: f64 = 64.0;
