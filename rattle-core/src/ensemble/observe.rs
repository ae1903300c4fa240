//! What is kept of an ensemble while it runs, instead of its trajectories: means, histograms, crossings of a section.

use super::group::Group;
use nalgebra::SVector;
use std::fmt;

/// A trajectory at a time: its bodies' positions and momenta.
#[derive(Clone, Copy)]
pub struct Sight<'a, const D: usize> {
    /// Which trajectory, counted from 0.
    pub trajectory: usize,
    /// The time.
    pub time: f64,
    /// Positions of its bodies.
    pub positions: &'a [SVector<f64, D>],
    /// Momenta of its bodies.
    pub momenta: &'a [SVector<f64, D>],
    /// What knows its energy, and under which number.
    pub(crate) scene: (&'a dyn Group<D>, usize),
}

impl<const D: usize> Sight<'_, D> {
    /// The position of the first body, which in lanes is the only one.
    #[must_use]
    pub fn position(&self) -> SVector<f64, D> {
        self.positions[0]
    }

    /// The momentum of the first body.
    #[must_use]
    pub fn momentum(&self) -> SVector<f64, D> {
        self.momenta[0]
    }

    /// Kinetic energy K = pᵀM⁻¹p/2, summed over the bodies; in phase space all of the energy H(q, p). As that of a
    /// [`Simulation`](crate::simulation::Simulation::kinetic_energy) but for rounding; evaluated when it is asked for.
    #[must_use]
    pub fn kinetic_energy(&self) -> f64 {
        self.energies()[0]
    }

    /// Potential energy U of all effects, of the trajectory's own scene in a sweep.
    #[must_use]
    pub fn potential_energy(&self) -> f64 {
        self.energies()[1]
    }

    /// Energy H = K + U.
    #[must_use]
    pub fn energy(&self) -> f64 {
        let [kinetic, potential] = self.energies();
        kinetic + potential
    }

    fn energies(&self) -> [f64; 2] {
        let (group, trajectory) = self.scene;
        group.energies(trajectory, self.positions, self.momenta)
    }
}

impl<const D: usize> fmt::Debug for Sight<'_, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut debug = f.debug_struct("Sight");
        debug.field("trajectory", &self.trajectory).field("time", &self.time);
        debug.field("positions", &self.positions).field("momenta", &self.momenta).finish_non_exhaustive()
    }
}

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
    fn see(&mut self, before: &Sight<'_, D>, now: &Sight<'_, D>) {
        self.0.see(before, now);
        self.1.see(before, now);
    }
    fn join(&mut self, next: Self) {
        self.0.join(next.0);
        self.1.join(next.1);
    }
}

/// Number, mean and variance of a quantity over all sights (Welford 1962; joined as Chan, Golub and LeVeque 1979 do).
#[derive(Debug, Clone)]
pub struct Mean<Q> {
    quantity: Q,
    number: f64,
    mean: f64,
    squares: f64,
}

impl<Q> Mean<Q> {
    /// Of this quantity.
    pub fn of<const D: usize>(quantity: Q) -> Self
    where
        Q: Fn(&Sight<'_, D>) -> f64,
    {
        Self { quantity, number: 0.0, mean: 0.0, squares: 0.0 }
    }

    /// How many sights there were.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number of things")]
    pub fn number(&self) -> u64 {
        self.number as u64
    }

    /// The mean; NaN of none.
    pub fn mean(&self) -> f64 {
        if self.number == 0.0 { f64::NAN } else { self.mean }
    }

    /// The mean square deviation from the mean, with n − 1 in the denominator; NaN of fewer than two.
    pub fn variance(&self) -> f64 {
        if self.number < 2.0 { f64::NAN } else { self.squares / (self.number - 1.0) }
    }
}

impl<Q: Fn(&Sight<'_, D>) -> f64 + Send, const D: usize> Observer<D> for Mean<Q> {
    fn see(&mut self, _: &Sight<'_, D>, now: &Sight<'_, D>) {
        let x = (self.quantity)(now);
        self.number += 1.0;
        let off = x - self.mean;
        self.mean += off / self.number;
        self.squares += off * (x - self.mean);
    }

    fn join(&mut self, next: Self) {
        let number = self.number + next.number;
        if number > 0.0 {
            let off = next.mean - self.mean;
            self.mean += off * (next.number / number);
            self.squares += next.squares + off * off * (self.number * next.number / number);
            self.number = number;
        }
    }
}

/// How often a quantity fell into each of equal bins.
#[derive(Debug, Clone)]
pub struct Histogram<Q> {
    quantity: Q,
    from: f64,
    to: f64,
    counts: Vec<u64>,
    outside: u64,
}

impl<Q> Histogram<Q> {
    /// Of this quantity, in so many bins between two numbers.
    pub fn of<const D: usize>(quantity: Q, from: f64, to: f64, bins: usize) -> Self
    where
        Q: Fn(&Sight<'_, D>) -> f64,
    {
        Self { quantity, from, to, counts: vec![0; bins], outside: 0 }
    }

    /// Sights by bin: bin i holds from + i w ≤ x < from + (i + 1) w, with w = (to − from)/bins.
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
        clippy::cast_precision_loss,
        reason = "a bin, after it was seen to be one"
    )]
    fn see(&mut self, _: &Sight<'_, D>, now: &Sight<'_, D>) {
        let place = ((self.quantity)(now) - self.from) / (self.to - self.from) * self.counts.len() as f64;
        let bin = if place >= 0.0 { self.counts.get_mut(place as usize) } else { None };
        *bin.unwrap_or(&mut self.outside) += 1;
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
    fn see(&mut self, before: &Sight<'_, D>, now: &Sight<'_, D>) {
        let (s0, s1) = ((self.quantity)(before), (self.quantity)(now));
        if !(s0 < 0.0 && s1 >= 0.0) {
            return;
        }
        // The root by regula falsi, halved where it does not shrink (Dowell and Jarratt 1971): s is nearly linear in a step.
        let (mut low, mut high, mut at_low, mut at_high) = (0.0, 1.0, s0, s1);
        let mut crossing = between(before, now, 1.0);
        for _ in 0..60 {
            let part = low - at_low * (high - low) / (at_high - at_low);
            crossing = between(before, now, part);
            let s = (self.quantity)(&crossing.sight(now));
            if s < 0.0 {
                (low, at_low, at_high) = (part, s, 0.5 * at_high);
            } else {
                (high, at_high, at_low) = (part, s, 0.5 * at_low);
            }
            if s == 0.0 || high - low <= 1e-15 {
                break;
            }
        }
        self.crossings.push(crossing);
    }

    fn join(&mut self, mut next: Self) {
        self.crossings.append(&mut next.crossings);
    }
}

impl<const D: usize> Crossing<D> {
    fn sight<'a>(&'a self, now: &Sight<'a, D>) -> Sight<'a, D> {
        let Self { trajectory, time, positions, momenta } = self;
        Sight { trajectory: *trajectory, time: *time, positions, momenta, scene: now.scene }
    }
}

/// The trajectory a part of the way from one sight to the next.
fn between<const D: usize>(before: &Sight<'_, D>, now: &Sight<'_, D>, part: f64) -> Crossing<D> {
    let (t, h) = (part, now.time - before.time);
    let ends = |i: usize| [before.positions[i], before.momenta[i] * h, now.positions[i], now.momenta[i] * h];
    // Hermite's cubic, and its derivative by time.
    let place = [
        (1.0 + 2.0 * t) * (1.0 - t).powi(2),
        t * (1.0 - t).powi(2),
        t * t * (3.0 - 2.0 * t),
        t * t * (t - 1.0),
    ];
    let rate = [6.0 * t * (t - 1.0), (1.0 - t) * (1.0 - 3.0 * t), 6.0 * t * (1.0 - t), t * (3.0 * t - 2.0)];
    let sum = |i: usize, weights: [f64; 4]| {
        ends(i)
            .iter()
            .zip(weights)
            .fold(SVector::zeros(), |sum: SVector<f64, D>, (end, weight)| sum + end * weight)
    };
    let bodies = 0..before.positions.len();
    Crossing {
        trajectory: now.trajectory,
        time: before.time + part * h,
        positions: bodies.clone().map(|i| sum(i, place)).collect(),
        momenta: bodies.map(|i| sum(i, rate) / h).collect(),
    }
}
