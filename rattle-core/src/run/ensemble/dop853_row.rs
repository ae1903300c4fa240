//! [`Dop853`](crate::methods::dop853::Dop853) in rows of numbers, one of each lane: sums over the stages, the estimate
//! of the error, and how long inner steps are. What is moved, and where its rates come from, is another.
//!
//! Arguments of a function are known not to overlap, so that its loop becomes one over vectors.

use crate::methods::dop853::{CHANGE, SAFETY};
use crate::methods::dop853_table::{ERROR_3, ERROR_5, STAGES, STEPS, WEIGHTS};
use crate::number::lanes::{Fused, Lane};
use crate::number::real::Real;
use crate::run::ensemble::pace::Pace;
use crate::run::ensemble::track::Track;
use crate::systems::network::in_lanes::{Numbers, zeros};
use std::ops::Range;

/// Adds the rates of a number, stage by stage, with these weights.
#[inline(always)]
pub(super) fn combine<'a, S: Lane, const L: usize>(
    weights: &[(usize, f64)],
    rate: impl Fn(usize) -> &'a [S; L],
    to: &mut [S; L],
) {
    for &(stage, weight) in weights {
        let (weight, rate) = (S::from_f64(weight), rate(stage));
        for l in 0..L {
            to[l] = weight.multiply_add(rate[l], to[l]);
        }
    }
}

/// Where a rate leads from a number with its low digits, if it has some.
#[inline(always)]
pub(super) fn reach<S: Lane, const L: usize, const SUMS: usize>(
    inner: &[S; L],
    rate: &[S; L],
    [from, low]: [&[S; L]; 2],
    to: &mut [S; L],
) {
    for l in 0..L {
        let way =
            if const { SUMS > 0 } { inner[l].multiply_add(rate[l], low[l]) } else { inner[l] * rate[l] };
        to[l] = from[l] + way;
    }
}

/// |Σ cⱼ q̇ⱼ| + h |Σ cⱼ ṗⱼ|, from the squares of both.
#[inline(always)]
pub(super) fn length<S: Lane, const L: usize>(whole: S, places: &[S; L], momenta: &[S; L], to: &mut [S; L]) {
    for l in 0..L {
        to[l] = places[l].sqrt() + whole * momenta[l].sqrt();
    }
}

/// Adds a square.
#[inline(always)]
pub(super) fn add_square<S: Lane, const L: usize>(x: &[S; L], to: &mut [S; L]) {
    for l in 0..L {
        to[l] = x[l].multiply_add(x[l], to[l]);
    }
}

/// The estimated errors of inner steps, from their [lengths](length).
#[inline(always)]
pub(super) fn error<S: Lane, const L: usize>(fifth: &[S; L], third: &[S; L], inner: &[S; L]) -> [S; L] {
    let ([zero, tenth], mut error) = ([0.0, 0.1].map(S::from_f64), *fifth);
    for l in 0..L {
        let (a, b) = (fifth[l], tenth * third[l]);
        let of_lane = inner[l].abs() * a * (a / a.multiply_add(a, b * b).sqrt());
        error[l] = S::select(a.le(zero), zero, of_lane);
    }
    error
}

/// Which inner steps are within the tolerance, and how long the next ones are to be.
#[inline(always)]
pub(super) fn fit<S: Lane, const L: usize>(
    tolerance: &[S; L],
    error: &[S; L],
    inner: &[S; L],
    next: &mut [S; L],
    taken: &mut [bool; L],
) {
    let [safety, least, most] = [SAFETY, CHANGE.0, CHANGE.1].map(S::from_f64);
    for l in 0..L {
        let fits = safety * (tolerance[l] / error[l]).sqrt().sqrt().sqrt();
        let fits = S::select(least.le(fits), fits, least).min(most); // also where it is no number
        taken[l] = error[l].le(tolerance[l]);
        next[l] = inner[l] * S::select(taken[l], fits, fits.min(safety));
    }
}

/// The rates of two kinds of numbers that move together, stage by stage, and the errors that they tell of.
pub(super) struct Stages<const W: usize> {
    pub(super) of: [Rates<W>; 2],
    /// The largest estimate of an error.
    worst: Numbers<W>,
}

impl<const W: usize> Stages<W> {
    /// So many numbers of each kind.
    pub(super) fn new(numbers: [usize; 2]) -> Self {
        Self { of: numbers.map(Rates::new), worst: zeros() }
    }

    /// Begins inner steps, which are to be [noted](Self::note) where there is a tolerance.
    #[inline(always)]
    pub(super) fn begin(&mut self, pace: &mut Pace<W>) {
        pace.begin_inner();
        self.worst = zeros();
    }

    /// Notes the errors of a body, from [`Rates::squares`] of its places and of its velocities.
    #[inline(always)]
    pub(super) fn note(&mut self, pace: &Pace<W>, places: &[Numbers<W>; 2], velocities: &[Numbers<W>; 2]) {
        let (whole, [mut fifth, mut third]) = (Fused(pace.h().0.abs()), [zeros::<W>(); 2]);
        length(whole, &places[0].0, &velocities[0].0, &mut fifth.0);
        length(whole, &places[1].0, &velocities[1].0, &mut third.0);
        let error = error(&fifth.0, &third.0, &pace.inner.0);
        for l in 0..W {
            let (error, most) = (error[l], self.worst.0[l]);
            self.worst.0[l] = Real::select((error.0 <= most.0) | most.0.is_nan(), most, error);
        }
    }

    /// Judges inner steps by what was noted. Without a tolerance all lanes go where they lead.
    #[inline(always)]
    pub(super) fn judge(&self, pace: &mut Pace<W>) {
        let Some(tolerance) = pace.tolerance() else {
            (pace.next, pace.taken) = (pace.inner, [true; W]);
            return;
        };
        let tolerance = [Fused(tolerance); W];
        fit(&tolerance, &self.worst.0, &pace.inner.0, &mut pace.next.0, &mut pace.taken);
    }
}

/// The rates of numbers, stage by stage.
pub(super) struct Rates<const W: usize>(Vec<[Numbers<W>; STAGES]>);

impl<const W: usize> Rates<W> {
    /// Of so many numbers.
    fn new(n: usize) -> Self {
        Self(vec![[zeros(); STAGES]; n])
    }

    /// Takes over the rates at a stage.
    #[inline(always)]
    pub(super) fn note(&mut self, stage: usize, rates: &[Numbers<W>]) {
        self.0.iter_mut().zip(rates).for_each(|(to, from)| to[stage] = *from);
    }

    /// The rates of number `c` with these weights.
    #[inline(always)]
    fn sum(&self, weights: &[(usize, f64)], c: usize, to: &mut Numbers<W>) {
        let rates = &self.0[c];
        combine(weights, |stage| &rates[stage].0, &mut to.0);
    }

    /// Where some numbers of a track are at a stage, from 1 on.
    #[inline(always)]
    pub(super) fn stage(
        &self,
        stage: usize,
        track: &Track<W>,
        numbers: impl Iterator<Item = usize>,
        inner: &Numbers<W>,
        to: &mut [Numbers<W>],
    ) {
        // Each of them compiled for its weights: so few that loops over them would take half of the time.
        macro_rules! match_stage {
            ($($number:literal)*) => {
                match stage {
                    $($number => self.stage_of::<$number>(track, numbers, inner, to),)*
                    _ => {}
                }
            };
        }
        const { assert!(STAGES == 12) };
        match_stage!(1 2 3 4 5 6 7 8 9 10 11);
    }

    #[inline(always)]
    fn stage_of<const STAGE: usize>(
        &self,
        track: &Track<W>,
        numbers: impl Iterator<Item = usize>,
        inner: &Numbers<W>,
        to: &mut [Numbers<W>],
    ) {
        for c in numbers {
            let mut rate = zeros();
            self.sum(STEPS[STAGE], c, &mut rate);
            reach::<_, W, 1>(&inner.0, &rate.0, [&track.now[c].0, &track.low[c].0], &mut to[c].0);
        }
    }

    /// Where number `c` of a track is at the end of inner steps, and what rounding takes from that.
    #[inline(always)]
    pub(super) fn arrive(
        &self,
        track: &Track<W>,
        c: usize,
        inner: &Numbers<W>,
        to: &mut Numbers<W>,
        low: &mut Numbers<W>,
    ) {
        let (mut rate, mut way) = (zeros(), zeros());
        self.sum(WEIGHTS, c, &mut rate);
        for l in 0..W {
            way.0[l] = inner.0[l] * rate.0[l];
        }
        track.arrive(c, &way, to, low);
    }

    /// |Σ cⱼ ẏⱼ|² of some numbers y, by the weights of both estimates of the error.
    #[inline(always)]
    pub(super) fn squares(&self, numbers: Range<usize>) -> [Numbers<W>; 2] {
        let [mut fifth, mut third] = [zeros(); 2];
        for c in numbers {
            for (weights, square) in [(ERROR_5, &mut fifth), (ERROR_3, &mut third)] {
                let mut rate = zeros::<W>();
                self.sum(weights, c, &mut rate);
                add_square(&rate.0, &mut square.0);
            }
        }
        [fifth, third]
    }
}
