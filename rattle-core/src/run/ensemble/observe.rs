//! What is kept of an ensemble while it runs, instead of its trajectories: means, histograms, crossings of a section.

use crate::error::Error;
use crate::run::ensemble::sight::Sight;
use nalgebra::SVector;

/// Is shown the trajectories of an ensemble as they go.
///
/// Each group of trajectories has an observer of its own, which sees them in turn; at the end these are joined in the order
/// of the trajectories, so that the outcome is the same, bit for bit, for any number of threads.
pub trait Observer<const D: usize>: Send {
    /// Is shown a trajectory now, and as it was at the sight before.
    fn see(&mut self, before: &Sight<'_, D>, now: &Sight<'_, D>);
    /// Takes over what another saw of the trajectories that come next.
    fn join(&mut self, next: Self);
}

impl<A: Observer<D>, B: Observer<D>, const D: usize> Observer<D> for (A, B) {
    #[inline(always)]
    fn see(&mut self, before: &Sight<'_, D>, now: &Sight<'_, D>) {
        self.0.see(before, now);
        self.1.see(before, now);
    }
    fn join(&mut self, next: Self) {
        self.0.join(next.0);
        self.1.join(next.1);
    }
}

/// Number, mean and variance of a quantity over all sights.
///
/// Those of 64 sights at a time are joined to the numbers before as Chan, Golub and LeVeque (1979) do; so are those of two
/// groups. No sight waits for the one before.
#[derive(Debug, Clone)]
pub struct Mean<Q> {
    quantity: Q,
    all: Moments,
    /// What is not yet in `all`: so many of these.
    number: usize,
    recent: [f64; RECENT],
}

/// So many sights are joined at a time.
const RECENT: usize = 64;

/// Number, mean, and sum of the squares of differences to it.
#[derive(Debug, Clone, Copy)]
struct Moments {
    number: f64,
    mean: f64,
    squares: f64,
}

impl Moments {
    #[allow(clippy::cast_precision_loss, reason = "a number of things")]
    fn of(all: &[f64]) -> Self {
        let number = all.len() as f64;
        let mean = if all.is_empty() { 0.0 } else { sum_of(all, |x| x) / number };
        Self { number, mean, squares: sum_of(all, |x| (x - mean) * (x - mean)) }
    }

    fn and(self, next: Self) -> Self {
        if self.number == 0.0 || next.number == 0.0 {
            return if self.number == 0.0 { next } else { self };
        }
        let (number, off) = (self.number + next.number, next.mean - self.mean);
        Self {
            number,
            mean: self.mean + off * (next.number / number),
            squares: self.squares + next.squares + off * off * (self.number * next.number / number),
        }
    }
}

/// Several sums side by side, and then theirs.
fn sum_of(all: &[f64], term: impl Fn(f64) -> f64) -> f64 {
    let (whole, rest) = all.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for chunk in whole {
        for (sum, &x) in sums.iter_mut().zip(chunk) {
            *sum += term(x);
        }
    }
    sums.into_iter().chain(rest.iter().map(|&x| term(x))).sum()
}

impl<Q> Mean<Q> {
    /// Of this quantity.
    pub fn of<const D: usize>(quantity: Q) -> Self
    where
        Q: Fn(&Sight<'_, D>) -> f64,
    {
        Self { quantity, all: Moments::of(&[]), number: 0, recent: [0.0; RECENT] }
    }

    fn moments(&self) -> Moments {
        self.all.and(Moments::of(&self.recent[..self.number]))
    }

    #[inline(never)]
    fn settle(&mut self) {
        (self.all, self.number) = (self.moments(), 0);
    }

    /// How many sights there were.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number of things")]
    pub fn number(&self) -> u64 {
        self.moments().number as u64
    }

    /// The mean; NaN of none.
    pub fn mean(&self) -> f64 {
        let Moments { number, mean, .. } = self.moments();
        if number == 0.0 { f64::NAN } else { mean }
    }

    /// The mean square deviation from the mean, with n − 1 in the denominator; NaN of fewer than two.
    pub fn variance(&self) -> f64 {
        let Moments { number, squares, .. } = self.moments();
        if number < 2.0 { f64::NAN } else { squares / (number - 1.0) }
    }
}

impl<Q: Fn(&Sight<'_, D>) -> f64 + Send, const D: usize> Observer<D> for Mean<Q> {
    #[inline(always)]
    fn see(&mut self, _: &Sight<'_, D>, now: &Sight<'_, D>) {
        self.recent[self.number] = (self.quantity)(now);
        self.number += 1;
        if self.number == RECENT {
            self.settle();
        }
    }

    fn join(&mut self, next: Self) {
        self.settle();
        self.all = self.all.and(next.moments());
    }
}

/// How often a quantity fell into each of equal bins.
#[derive(Debug, Clone)]
pub struct Histogram<Q> {
    quantity: Q,
    from: f64,
    to: f64,
    /// Bins per unit.
    density: f64,
    counts: Vec<u64>,
    outside: u64,
}

impl<Q> Histogram<Q> {
    /// Of this quantity, in so many bins between two numbers. It is asked for once, and each group of trajectories is
    /// given a copy:
    ///
    /// ```
    /// # use rattle::{Scene, State, Rattle, ensemble::{Histogram, Sight}};
    /// # let starts = (0..100).map(|i| State::at([0.0]).moving([f64::from(i)]));
    /// # let mut ensemble = Scene::points::<1>(1).ensemble(starts, Rattle::new(0.5))?;
    /// let speeds = Histogram::of(|now: &Sight<'_, 1>| now.momentum().norm(), 0.0, 80.0, 4)?;
    /// let speeds = ensemble.observe(10, 1, || speeds.clone());
    /// assert_eq!((speeds.counts(), speeds.outside()), (&[200, 200, 200, 200][..], 200));
    /// # Ok::<(), rattle::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Bins`] without bins, or if the numbers are not finite, or the first not below the second.
    #[allow(clippy::cast_precision_loss, reason = "a number of bins")]
    pub fn of<const D: usize>(quantity: Q, from: f64, to: f64, bins: usize) -> Result<Self, Error>
    where
        Q: Fn(&Sight<'_, D>) -> f64,
    {
        let density = bins as f64 / (to - from);
        if !(bins > 0 && from < to && from.is_finite() && to.is_finite() && density.is_normal()) {
            return Err(Error::Bins { from, to, bins });
        }
        Ok(Self { quantity, from, to, density, counts: vec![0; bins], outside: 0 })
    }

    /// Sights by bin: bin i holds from + i w ≤ x < from + (i + 1) w, with w = (to − from)/bins; to rounding of x − from.
    pub fn counts(&self) -> &[u64] {
        &self.counts
    }

    /// Sights outside of all bins, and such that are not numbers.
    pub fn outside(&self) -> u64 {
        self.outside
    }
}

impl<Q: Fn(&Sight<'_, D>) -> f64 + Send, const D: usize> Observer<D> for Histogram<Q> {
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a bin, after it was seen to be one"
    )]
    #[inline(always)]
    fn see(&mut self, _: &Sight<'_, D>, now: &Sight<'_, D>) {
        let x = (self.quantity)(now);
        let last = self.counts.len() - 1;
        let count = if x >= self.from && x < self.to {
            &mut self.counts[(((x - self.from) * self.density) as usize).min(last)]
        } else {
            &mut self.outside
        };
        *count += 1;
    }

    fn join(&mut self, next: Self) {
        self.outside += next.outside;
        for (count, more) in self.counts.iter_mut().zip(next.counts) {
            *count += more;
        }
    }
}

/// A Poincaré section: where and when trajectories pass from s < 0 to s ≥ 0.
///
/// Between two sights a body's way is the cubic through both places with the velocities there, for which momenta of unit
/// mass are taken; the crossing is where s is zero on it.
#[derive(Debug, Clone)]
pub struct Section<Q, const D: usize> {
    quantity: Q,
    crossings: Vec<Crossing<D>>,
}

/// A crossing of a [`Section`].
#[derive(Debug, Clone, PartialEq)]
pub struct Crossing<const D: usize> {
    /// Which trajectory.
    pub trajectory: usize,
    /// When.
    pub time: f64,
    /// Positions of its bodies.
    pub positions: Vec<SVector<f64, D>>,
    /// Momenta of its bodies.
    pub momenta: Vec<SVector<f64, D>>,
}

impl<Q: Fn(&Sight<'_, D>) -> f64, const D: usize> Section<Q, D> {
    /// Where this quantity s is zero.
    pub fn of(quantity: Q) -> Self {
        Self { quantity, crossings: Vec::new() }
    }

    /// All crossings, of the first group of trajectories as they came, then of the next. [`return_times`](Self::return_times)
    /// puts them in order.
    pub fn crossings(&self) -> &[Crossing<D>] {
        &self.crossings
    }

    /// Where s passes from s₀ < 0 to s₁ ≥ 0.
    #[inline(never)]
    fn crossing(&self, (before, s0): (&Sight<'_, D>, f64), (now, s1): (&Sight<'_, D>, f64)) -> Crossing<D> {
        // The root by regula falsi; s at an end that stays twice is halved (Dowell and Jarratt 1971). It is nearly linear in a step.
        let (mut low, mut high, mut at_low, mut at_high) = (0.0, 1.0, s0, s1);
        let (mut crossing, mut last, mut was_below) = (Crossing::of(now), f64::NAN, None);
        for _ in 0..60 {
            let part = low - at_low * (high - low) / (at_high - at_low);
            crossing.move_to(before, now, part);
            let s = (self.quantity)(&crossing.sight(now));
            let below = s < 0.0;
            let (end, at_end, at_other) = if below {
                (&mut low, &mut at_low, &mut at_high)
            } else {
                (&mut high, &mut at_high, &mut at_low)
            };
            (*end, *at_end) = (part, s);
            if was_below == Some(below) {
                *at_other *= 0.5;
            }
            if s == 0.0 || high - low <= f64::EPSILON || (part - last).abs() <= f64::EPSILON {
                break;
            }
            (last, was_below) = (part, Some(below));
        }
        crossing
    }

    /// How long each trajectory took from one crossing to its next, with the number of the trajectory.
    pub fn return_times(&self) -> Vec<(usize, f64)> {
        let mut order: Vec<&Crossing<D>> = self.crossings.iter().collect();
        order.sort_by(|a, b| {
            (a.trajectory, a.time).partial_cmp(&(b.trajectory, b.time)).unwrap_or(std::cmp::Ordering::Equal)
        });
        let pairs = order.windows(2).filter(|pair| pair[0].trajectory == pair[1].trajectory);
        pairs.map(|pair| (pair[1].trajectory, pair[1].time - pair[0].time)).collect()
    }
}

impl<Q: Fn(&Sight<'_, D>) -> f64 + Send, const D: usize> Observer<D> for Section<Q, D> {
    #[inline(always)]
    fn see(&mut self, before: &Sight<'_, D>, now: &Sight<'_, D>) {
        let (s0, s1) = ((self.quantity)(before), (self.quantity)(now));
        if s0 < 0.0 && s1 >= 0.0 {
            self.crossings.push(self.crossing((before, s0), (now, s1)));
        }
    }

    fn join(&mut self, mut next: Self) {
        self.crossings.append(&mut next.crossings);
    }
}

impl<const D: usize> Crossing<D> {
    fn of(now: &Sight<'_, D>) -> Self {
        let (positions, momenta) = (now.positions.to_vec(), now.momenta.to_vec());
        Self { trajectory: now.trajectory, time: now.time, positions, momenta }
    }

    fn sight<'a>(&'a self, now: &Sight<'a, D>) -> Sight<'a, D> {
        let Self { trajectory, time, positions, momenta } = self;
        Sight { trajectory: *trajectory, time: *time, positions, momenta, scene: now.scene }
    }

    /// Puts it a part of the way from one sight to the next, on Hermite's cubic; momenta are its derivative by time.
    fn move_to(&mut self, before: &Sight<'_, D>, now: &Sight<'_, D>, part: f64) {
        let (t, h) = (part, now.time - before.time);
        self.time = before.time + part * h;
        let place = [
            (1.0 + 2.0 * t) * (1.0 - t).powi(2),
            t * (1.0 - t).powi(2),
            t * t * (3.0 - 2.0 * t),
            t * t * (t - 1.0),
        ];
        let rate =
            [6.0 * t * (t - 1.0), (1.0 - t) * (1.0 - 3.0 * t), 6.0 * t * (1.0 - t), t * (3.0 * t - 2.0)];
        for body in 0..self.positions.len() {
            let (q0, q1) = (before.positions[body], now.positions[body]);
            let (p0, p1) = (before.momenta[body] * h, now.momenta[body] * h);
            let sum = |[a, b, c, d]: [f64; 4]| q0 * a + p0 * b + q1 * c + p1 * d;
            self.positions[body] = sum(place);
            self.momenta[body] = sum(rate) / h;
        }
    }
}
