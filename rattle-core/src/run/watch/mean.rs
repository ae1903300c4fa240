//! Mean and variance of a quantity along runs.

use crate::run::watch::observer::Observer;
use crate::run::watch::sight::Sight;

/// Number, mean and variance of a quantity over all [sights](Sight) (observed states).
///
/// Sums over 64 sights at a time, and those of different groups of trajectories, are joined by the formulas of Chan,
/// Golub and LeVeque (1979). So the processor need not wait for one sight before it adds the next.
#[doc(alias = "average")]
#[doc(alias = "expectation")]
#[derive(Debug, Clone)]
pub struct Mean<Q> {
    quantity: Q,
    /// Whether a sight counts as half the values at it and before it.
    over_time: bool,
    all: Moments,
    /// What is not yet in `all`: so many of these.
    number: usize,
    recent: [f64; RECENT],
    blocks: Blocks,
    /// Momenta have jumped since the sight of this time: the integral until the last jump, the value right after it,
    /// and its time. A step that failed behind a jump leaves it to a sight that is seen no more.
    jumped: Option<(f64, [f64; 3])>,
}

/// So many sights are joined at a time.
const RECENT: usize = 64;

/// Means of blocks of [`RECENT`] successive sights, of twice as many, and so on: where blocks are longer than the
/// quantity remembers, their means are independent.
///
/// Source: H. Flyvbjerg, H. G. Petersen, J. Chem. Phys. 91 (1989) 461.
#[derive(Debug, Clone)]
struct Blocks([(Moments, Option<f64>); LENGTHS]);

/// Lengths of blocks.
const LENGTHS: usize = 32;

/// Fewer blocks say too little of the spread of their means.
const FEWEST_BLOCKS: f64 = 16.0;

impl Blocks {
    /// Adds the mean of a block of the shortest length.
    fn add(&mut self, mut mean: f64) {
        for (blocks, first_half) in &mut self.0 {
            *blocks = blocks.and(Moments { number: 1.0, mean, squares: 0.0 });
            match first_half.take() {
                None => {
                    *first_half = Some(mean);
                    return;
                }
                Some(first) => mean = 0.5 * (first + mean),
            }
        }
    }

    /// Adds those of other trajectories, or of later sights; halves of blocks are left out.
    fn join(&mut self, next: &Self) {
        for ((blocks, _), (others, _)) in self.0.iter_mut().zip(&next.0) {
            *blocks = blocks.and(*others);
        }
    }

    /// The largest standard error of the mean that blocks of a length tell of.
    fn error(&self) -> f64 {
        let told = self.0.iter().filter(|(blocks, _)| blocks.number >= FEWEST_BLOCKS);
        let errors = told.map(|(Moments { number, squares, .. }, _)| squares / (number - 1.0) / number);
        errors.fold(f64::NAN, f64::max).sqrt()
    }
}

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
    /// The mean of this quantity, a function of a sight.
    pub fn of<const D: usize>(quantity: Q) -> Self
    where
        Q: Fn(&Sight<'_, D>) -> f64,
    {
        Self {
            quantity,
            over_time: false,
            all: Moments::of(&[]),
            number: 0,
            recent: [0.0; RECENT],
            blocks: Blocks([(Moments::of(&[]), None); LENGTHS]),
            jumped: None,
        }
    }

    /// The average over time of this quantity, by the trapezoidal rule: between two sights the quantity counts as half
    /// the sum of its values at both. The start of the run is the first of them. For steps of one length; the error is
    /// that of the rule, of order 2 in the time between sights, where [`of`](Self::of) alone is of order 1. Where
    /// momenta [jump](Observer::jump) between two sights, at impacts and edges, each part counts by itself.
    ///
    /// ```
    /// # use rattle::{Rattle, Scene, State, watch::{Mean, Sight}};
    /// let mut simulation = Scene::point().simulate(State::at([0.0]).moving([1.0]), Rattle::new(0.5))?;
    /// let mut mean = Mean::over_time(|now: &Sight<'_, 1>| now.positions[0].x);
    /// simulation.observe(8, 1, &mut mean)?;
    /// assert_eq!((mean.number(), mean.mean()), (8, 2.0));
    /// # Ok::<(), rattle::Error>(())
    /// ```
    #[doc(alias = "trapezoidal rule")]
    pub fn over_time<const D: usize>(quantity: Q) -> Self
    where
        Q: Fn(&Sight<'_, D>) -> f64,
    {
        Self { over_time: true, ..Self::of(quantity) }
    }

    fn moments(&self) -> Moments {
        self.all.and(Moments::of(&self.recent[..self.number]))
    }

    #[inline(never)]
    fn settle(&mut self) {
        if self.number == RECENT {
            self.blocks.add(Moments::of(&self.recent).mean);
        }
        (self.all, self.number) = (self.moments(), 0);
    }

    /// The number of sights.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number of things")]
    pub fn number(&self) -> u64 {
        self.moments().number as u64
    }

    /// The mean; NaN if there was no sight.
    pub fn mean(&self) -> f64 {
        let Moments { number, mean, .. } = self.moments();
        if number == 0.0 { f64::NAN } else { mean }
    }

    /// The mean square deviation from the mean, with n − 1 in the denominator; NaN if there were fewer than two sights.
    ///
    /// √(variance/n) is the standard error of the mean only where sights are independent. Successive sights of one
    /// trajectory are not: their [`uncertainty`](Self::uncertainty) is larger.
    #[doc(alias = "standard deviation")]
    pub fn variance(&self) -> f64 {
        let Moments { number, squares, .. } = self.moments();
        if number < 2.0 { f64::NAN } else { squares / (number - 1.0) }
    }

    /// The standard error of the mean, by the spread of means over blocks of 64, 128, … successive sights; the largest
    /// that blocks of a length tell of, of those that there are 16 of. NaN after fewer than 1024 sights.
    ///
    /// Too small where a quantity remembers longer than a sixteenth of the run of its trajectory, or where a part of
    /// the surface was not reached at all; up to a third too large otherwise. variance/uncertainty² is the number of
    /// independent sights that would tell as much.
    ///
    /// ```
    /// # use rattle::effect::Langevin;
    /// # use rattle::{Baoab, Scene, State, potentials::planar::Harmonic, watch::{Mean, Sight}};
    /// let heat = Langevin { friction: 1.0, temperature: 0.5, seed: 1 };
    /// let scene = Scene::point().with(Harmonic { stiffness: 1.0, centre: [0.0, 0.0] }).with(heat);
    /// let mut simulation = scene.simulate(State::at([0.0, 0.0]), Baoab::new(0.5))?;
    /// let mut square = Mean::of(|now: &Sight<'_, 2>| now.positions[0].x.powi(2));
    /// simulation.observe(20_000, 1, &mut square)?;
    /// assert!((square.mean() - 0.5).abs() < 4.0 * square.uncertainty());
    /// # Ok::<(), rattle::Error>(())
    /// ```
    #[doc(alias = "standard error")]
    #[doc(alias = "error bar")]
    #[doc(alias = "block averaging")]
    #[doc(alias = "effective sample size")]
    pub fn uncertainty(&self) -> f64 {
        self.blocks.error()
    }
}

impl<Q: Fn(&Sight<'_, D>) -> f64, const D: usize> Observer<D> for Mean<Q> {
    #[inline(always)]
    fn see(&mut self, before: &Sight<'_, D>, now: &Sight<'_, D>) {
        let value = (self.quantity)(now);
        self.recent[self.number] = match self.jumped.take().filter(|&(since, _)| since == before.time) {
            _ if !self.over_time => value,
            None => 0.5 * ((self.quantity)(before) + value),
            Some((_, [integral, last, time])) => {
                (integral + 0.5 * (last + value) * (now.time - time)) / (now.time - before.time)
            }
        };
        self.number += 1;
        if self.number == RECENT {
            self.settle();
        }
    }

    fn sees_jumps(&self) -> bool {
        self.over_time
    }

    fn jump(&mut self, from: &Sight<'_, D>, before: &Sight<'_, D>, after: &Sight<'_, D>) {
        // `from` is the last sight, or right after the jump before.
        let known = self.jumped.filter(|&(_, [_, _, time])| time == from.time);
        let (since, [integral, last, time]) =
            known.unwrap_or_else(|| (from.time, [0.0, (self.quantity)(from), from.time]));
        let part = 0.5 * (last + (self.quantity)(before)) * (before.time - time);
        self.jumped = Some((since, [integral + part, (self.quantity)(after), after.time]));
    }

    fn join(&mut self, next: Self) {
        self.settle();
        self.all = self.all.and(next.moments());
        self.blocks.join(&next.blocks);
    }
}
