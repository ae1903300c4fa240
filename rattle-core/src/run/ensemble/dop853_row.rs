//! [`Dop853`] in rows of numbers, one of each lane: sums over the stages, the estimate of the error, and how long inner
//! steps are. What is moved, and where its rates come from, is another.
//!
//! Arguments of a function are known not to overlap, so that its loop becomes one over vectors.

use crate::methods::dop853::{CHANGE, Dop853, SAFETY, SMALLEST_PART};
use crate::methods::dop853_table::{ERROR_3, ERROR_5, STAGES, STEPS, WEIGHTS};
use crate::motion::method::Method;
use crate::number::lanes::{Fused, Lane};
use crate::number::real::Real;
use crate::number::vector::two_sum;
use crate::run::ensemble::engine::Stuck;
use crate::systems::network::in_lanes::{Number, Numbers, Which, zeros};
use std::ops::Range;

/// Inner steps, those that are repeated among them, after which a lane goes by itself.
pub(super) const MOST_PASSES: usize = 1024;

/// Newton steps onto the constraints after which a lane goes by itself.
pub(super) const MOST_NEWTON_STEPS: usize = 12;

/// A lane is moved, has arrived, or has to take the step by itself.
pub(super) const MOVES: u64 = 1;
pub(super) const ARRIVED: u64 = 0;
pub(super) const BY_ITSELF: u64 = 2;

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
        let way = if SUMS > 0 { inner[l].multiply_add(rate[l], low[l]) } else { inner[l] * rate[l] };
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

/// Two kinds of numbers that move together, and what rounding took from both: what is kept from step to step.
pub(super) type State<const W: usize> = [Vec<Numbers<W>>; 4];

/// Numbers that have rates: where inner steps have led them, what rounding took from that, and the rates of each, stage
/// by stage.
pub(super) struct Track<const W: usize> {
    pub(super) now: Vec<Numbers<W>>,
    low: Vec<Numbers<W>>,
    rates: Vec<[Numbers<W>; STAGES]>,
}

impl<const W: usize> Track<W> {
    /// So many numbers.
    pub(super) fn new(n: usize) -> Self {
        let rows = |number| vec![zeros::<W>(); number];
        Self { now: rows(n), low: rows(n), rates: vec![[zeros(); STAGES]; n] }
    }

    /// Takes over the rates at a stage.
    #[inline(always)]
    pub(super) fn note(&mut self, stage: usize, rates: &[Numbers<W>]) {
        self.rates.iter_mut().zip(rates).for_each(|(to, from)| to[stage] = *from);
    }

    /// The rates of number `c` with these weights.
    #[inline(always)]
    fn sum(&self, weights: &[(usize, f64)], c: usize, to: &mut Numbers<W>) {
        let rates = &self.rates[c];
        combine(weights, |stage| &rates[stage].0, &mut to.0);
    }

    /// Where some numbers are at a stage, from 1 on.
    #[inline(always)]
    pub(super) fn stage(
        &self,
        stage: usize,
        numbers: impl Iterator<Item = usize>,
        inner: &Numbers<W>,
        to: &mut [Numbers<W>],
    ) {
        // Each of them compiled for its weights: so few that loops over them would take half of the time.
        macro_rules! match_stage {
            ($($number:literal)*) => {
                match stage {
                    $($number => self.stage_of::<$number>(numbers, inner, to),)*
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
        numbers: impl Iterator<Item = usize>,
        inner: &Numbers<W>,
        to: &mut [Numbers<W>],
    ) {
        for c in numbers {
            let mut rate = zeros();
            self.sum(STEPS[STAGE], c, &mut rate);
            reach::<_, W, 1>(&inner.0, &rate.0, [&self.now[c].0, &self.low[c].0], &mut to[c].0);
        }
    }

    /// Where number `c` is at the end of an inner step, and what rounding takes from that.
    #[inline(always)]
    pub(super) fn arrive(&self, c: usize, inner: &Numbers<W>, to: &mut Numbers<W>, low: &mut Numbers<W>) {
        let mut rate = zeros();
        self.sum(WEIGHTS, c, &mut rate);
        arrive(inner, &rate, [&self.now[c], &self.low[c]], to, low);
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

    /// Has number `c` of these lanes be there.
    #[inline(always)]
    pub(super) fn take(&mut self, lanes: &Which<W>, c: usize, [to, low]: [&Numbers<W>; 2]) {
        choose(lanes, to, &mut self.now[c]);
        choose(lanes, low, &mut self.low[c]);
    }
}

/// Where two tracks are, as a [`State`].
pub(super) fn state<const W: usize>([a, b]: &mut [Track<W>; 2]) -> [&mut Vec<Numbers<W>>; 4] {
    [&mut a.now, &mut b.now, &mut a.low, &mut b.low]
}

/// Has lanes that go [by themselves](BY_ITSELF) moved one by one, and put copies with what they are copies of. All that
/// cannot are told of at once: each is left out before the row is tried again.
#[cold]
#[inline(never)]
pub(super) fn one_by_one<X, const W: usize>(
    going: &Which<W>,
    copy_of: &[usize; W],
    moved: &mut dyn FnMut(usize) -> Result<X, Stuck>,
    put: &mut dyn FnMut(usize, &X),
) -> Result<(), Vec<Stuck>> {
    let mut stuck = Vec::new();
    for of in (0..W).filter(|&of| copy_of[of] == of && going[of] == BY_ITSELF) {
        match moved(of) {
            Ok(landed) => (0..W).filter(|&lane| copy_of[lane] == of).for_each(|lane| put(lane, &landed)),
            Err(why) => stuck.push(why),
        }
    }
    if stuck.is_empty() { Ok(()) } else { Err(stuck) }
}

/// Has a lane of two tracks be there.
pub(super) fn put<const W: usize>(tracks: &mut [Track<W>; 2], lane: usize, there: &[Vec<f64>; 4]) {
    for (now, there) in state(tracks).into_iter().zip(there) {
        now.iter_mut().zip(there).for_each(|(now, &there)| now.0[lane] = Fused(there));
    }
}

/// The end of an inner step as a sum of two.
#[inline(always)]
fn arrive<const W: usize>(
    inner: &Numbers<W>,
    rate: &Numbers<W>,
    [from, low]: [&Numbers<W>; 2],
    sum: &mut Numbers<W>,
    rest: &mut Numbers<W>,
) {
    for l in 0..W {
        let by = low.0[l] + inner.0[l] * rate.0[l];
        let ([high], [low]) = two_sum(&[from.0[l]], &[by]);
        (sum.0[l], rest.0[l]) = (high, low);
    }
}

/// Writes the numbers of some lanes.
#[inline(always)]
pub(super) fn choose<const W: usize>(lanes: &Which<W>, from: &Numbers<W>, to: &mut Numbers<W>) {
    for l in 0..W {
        to.0[l] = Real::select(lanes[l] != 0, from.0[l], to.0[l]);
    }
}

/// How far all lanes have come in a step.
pub(super) struct Pace<const W: usize> {
    method: Dop853,
    /// How much of the step is left, and the lengths of the inner step and of the next one.
    left: Numbers<W>,
    pub(super) inner: Numbers<W>,
    next: Numbers<W>,
    /// Whether the inner step is within the tolerance.
    taken: [bool; W],
    /// Whether a lane [moves](MOVES).
    pub(super) going: Which<W>,
    /// The largest estimate of an error.
    worst: Numbers<W>,
}

impl<const W: usize> Pace<W> {
    pub(super) fn new(method: Dop853) -> Self {
        let [left, inner, next, worst] = [zeros(); 4];
        Self { method, left, inner, next, taken: [true; W], going: [ARRIVED; W], worst }
    }

    /// The whole step.
    pub(super) fn h(&self) -> Number {
        Fused(self.method.step_size())
    }

    /// Begins a step.
    #[inline(always)]
    pub(super) fn begin(&mut self) {
        let h = self.h();
        (self.left.0, self.inner.0, self.going) = ([h; W], [h; W], [MOVES; W]);
    }

    /// Begins an inner step, which goes no farther than the step.
    #[inline(always)]
    pub(super) fn begin_inner(&mut self) {
        for l in 0..W {
            let [left, inner] = [self.left.0[l], self.inner.0[l]];
            self.inner.0[l] = Real::select(left.0.abs() <= inner.0.abs(), left, inner);
        }
        self.worst = zeros();
    }

    /// What errors of inner steps, which are to be [noted](Self::note) then, may be.
    #[inline(always)]
    pub(super) fn tolerance(&self) -> Option<f64> {
        self.method.tolerance()
    }

    /// Notes the errors of a body, from [`Track::squares`] of its places and of its velocities.
    #[inline(always)]
    pub(super) fn note(&mut self, places: &[Numbers<W>; 2], velocities: &[Numbers<W>; 2]) {
        let (whole, [mut fifth, mut third]) = (Fused(self.h().0.abs()), [zeros::<W>(); 2]);
        length(whole, &places[0].0, &velocities[0].0, &mut fifth.0);
        length(whole, &places[1].0, &velocities[1].0, &mut third.0);
        let error = error(&fifth.0, &third.0, &self.inner.0);
        for l in 0..W {
            let (error, most) = (error[l], self.worst.0[l]);
            self.worst.0[l] = Real::select((error.0 <= most.0) | most.0.is_nan(), most, error);
        }
    }

    /// Judges the inner step by what was noted. Without a tolerance all lanes go where it leads.
    #[inline(always)]
    pub(super) fn judge(&mut self) {
        let Some(tolerance) = self.method.tolerance() else {
            (self.next, self.taken) = (self.inner, [true; W]);
            return;
        };
        let tolerance = [Fused(tolerance); W];
        fit(&tolerance, &self.worst.0, &self.inner.0, &mut self.next.0, &mut self.taken);
    }

    /// Whether a lane goes where its inner step leads, if that can be believed.
    #[inline(always)]
    pub(super) fn takes(&self, l: usize) -> bool {
        (self.going[l] == MOVES) & self.taken[l]
    }

    /// Has a lane go by itself that goes where its inner step leads, if that cannot be believed.
    #[inline(always)]
    pub(super) fn doubt(&mut self, l: usize, believed: bool) {
        self.going[l] = if self.takes(l) & !believed { BY_ITSELF } else { self.going[l] };
    }

    /// Goes on after this many inner steps. Returns which lanes are where theirs led, and whether a lane has still some
    /// way to go.
    #[inline(always)]
    pub(super) fn advance(&mut self, passes: usize) -> (Which<W>, bool) {
        let (shortest, end) = (SMALLEST_PART * self.h().0.abs(), passes == MOST_PASSES);
        let (mut moves, mut any) = ([0; W], false);
        for l in 0..W {
            let (goes, takes, left) = (self.going[l] == MOVES, self.takes(l), self.left.0[l]);
            moves[l] = u64::from(takes);
            let left = if takes { left - self.inner.0[l] } else { left };
            let collapsed = !self.taken[l] & (self.next.0[l].0.abs() < shortest);
            let arrived = left.0 == 0.0;
            let on = if arrived { ARRIVED } else { MOVES };
            let on = if collapsed | (end & !arrived) { BY_ITSELF } else { on };
            (self.left.0[l], self.inner.0[l]) = (left, self.next.0[l]);
            self.going[l] = if goes { on } else { self.going[l] };
            any |= self.going[l] == MOVES;
        }
        (moves, any)
    }
}
