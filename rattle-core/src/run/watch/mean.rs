//! Mean and variance of a quantity along runs.

use crate::run::watch::each::Each;
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
    /// The trajectory that was seen, and whether others were.
    trajectory: Option<usize>,
    several: bool,
    /// Momenta have jumped since the sight of this time: the integral until the last jump, the value right after it,
    /// and its time; and the step of the last jump. A step that failed behind a jump leaves it to a sight that is seen
    /// no more.
    jumped: Option<(f64, [f64; 3], u64)>,
}

/// So many sights are joined at a time.
const RECENT: usize = 64;

/// Means of blocks of [`RECENT`] successive sights of one trajectory, of twice as many, and so on, each with that of a
/// first half: where blocks are longer than the quantity remembers, their means are independent.
///
/// Source: H. Flyvbjerg, H. G. Petersen, J. Chem. Phys. 91 (1989) 461.
#[derive(Debug)]
struct Blocks(Vec<(Moments, Option<f64>)>);

impl Clone for Blocks {
    fn clone(&self) -> Self {
        let mut lengths = Vec::with_capacity(LENGTHS);
        lengths.extend_from_slice(&self.0);
        Self(lengths)
    }
}

/// Lengths of blocks, so that sights need not allocate: the longest is of more than 10¹¹ sights.
const LENGTHS: usize = 32;

/// Fewer blocks say too little of the spread of their means.
const FEWEST_BLOCKS: f64 = 16.0;

impl Blocks {
    /// Adds the mean of a block of the shortest length.
    fn add(&mut self, mut mean: f64) {
        for length in 0..LENGTHS {
            if length == self.0.len() {
                self.0.push((Moments::of(&[]), None));
            }
            let (blocks, first_half) = &mut self.0[length];
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

    /// The largest standard error of the mean of so many sights that blocks of a length tell of; NaN if one is.
    fn error(&self, sights: f64) -> f64 {
        let (mut largest, mut length) = (f64::NAN, RECENT as f64);
        for (Moments { number, squares, .. }, _) in &self.0 {
            if *number < FEWEST_BLOCKS {
                break;
            }
            let square = squares / (number - 1.0) * (length / sights);
            if square.is_nan() {
                return square;
            }
            (largest, length) = (largest.max(square), 2.0 * length);
        }
        largest.sqrt()
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
            blocks: Blocks(Vec::with_capacity(LENGTHS)),
            trajectory: None,
            several: false,
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

    /// Adds a value as that of one more sight: of a chain whose states are not those of one simulation, as where a
    /// proposal is rejected and the state before it counts once more.
    ///
    /// ```
    /// # use rattle::watch::{Mean, Sight};
    /// let mut mean = Mean::of(|now: &Sight<'_, 1>| now.positions[0].x);
    /// [1.0, 2.0, 2.0, 3.0].into_iter().for_each(|x| mean.add(x));
    /// assert_eq!((mean.number(), mean.mean()), (4, 2.0));
    /// ```
    #[inline(always)]
    pub fn add(&mut self, value: f64) {
        self.recent[self.number] = value;
        self.number += 1;
        if self.number == RECENT {
            self.settle();
        }
    }

    fn moments(&self) -> Moments {
        self.all.and(Moments::of(&self.recent[..self.number]))
    }

    #[inline(never)]
    fn settle(&mut self) {
        let recent = Moments::of(&self.recent[..self.number]);
        if self.number == RECENT && !self.several {
            self.blocks.add(recent.mean);
        }
        (self.all, self.number) = (self.all.and(recent), 0);
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

    /// The standard error of the mean along one trajectory, by the spread of means over blocks of 64, 128, … successive
    /// sights; the largest that blocks of a length tell of, of those that there are 16 of: known to a fifth at worst,
    /// and to a few percent where blocks are many. NaN after fewer than 1024 sights, and where several trajectories of
    /// an ensemble were seen: what these are apart by is told by [`Each`] with a mean of its own for each. Simulations
    /// that are seen one after the other count as one.
    ///
    /// Too small where a quantity remembers longer than a sixteenth of the run, or where a part of the surface was not
    /// reached at all. variance/uncertainty² is the number of independent sights that would tell as much.
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
        let Moments { number, mean, .. } = self.moments();
        if self.several || !mean.is_finite() { f64::NAN } else { self.blocks.error(number) }
    }
}

impl<F, Q> Each<F, Mean<Q>> {
    /// The standard error of the mean over all trajectories, by the spread of their means, whatever each remembers: for
    /// runs of one length. NaN with fewer than two.
    ///
    /// ```
    /// # use rattle::{Rattle, Scene, State, watch::{Each, Mean, Sight}};
    /// let starts = (0..4).map(|i| State::at([f64::from(i)]));
    /// let mut ensemble = Scene::points::<1>(1).ensemble(starts, Rattle::new(0.5))?;
    /// let each = ensemble.observe(3, 1, || Each::of(|| Mean::of(|now: &Sight<'_, 1>| now.positions[0].x)));
    /// assert_eq!(each.uncertainty(), (5.0_f64 / 3.0 / 4.0).sqrt());
    /// # Ok::<(), rattle::Error>(())
    /// ```
    #[doc(alias = "standard error")]
    pub fn uncertainty(&self) -> f64 {
        let means: Vec<_> = self.iter().map(|(_, of)| of.mean()).collect();
        let Moments { number, squares, .. } = Moments::of(&means);
        if number < 2.0 { f64::NAN } else { (squares / (number - 1.0) / number).sqrt() }
    }
}

impl<Q: Fn(&Sight<'_, D>) -> f64, const D: usize> Observer<D> for Mean<Q> {
    #[inline(always)]
    fn see(&mut self, before: &Sight<'_, D>, now: &Sight<'_, D>) {
        let value = (self.quantity)(now);
        self.several |= self.trajectory.replace(now.trajectory).is_some_and(|last| last != now.trajectory);
        let value = match self.jumped.take().filter(|&(since, ..)| since == before.time) {
            _ if !self.over_time => value,
            None => 0.5 * ((self.quantity)(before) + value),
            Some((_, [integral, last, time], _)) => {
                (integral + 0.5 * (last + value) * (now.time - time)) / (now.time - before.time)
            }
        };
        self.add(value);
    }

    fn sees_jumps(&self) -> bool {
        self.over_time
    }

    fn jump(&mut self, from: &Sight<'_, D>, before: &Sight<'_, D>, after: &Sight<'_, D>) {
        // `from` is the last sight, or right after the jump before.
        let known = self.jumped.filter(|&(_, [_, _, time], step)| (time, step) == (from.time, from.step));
        let (since, [integral, last, time], _) =
            known.unwrap_or_else(|| (from.time, [0.0, (self.quantity)(from), from.time], from.step));
        let part = 0.5 * (last + (self.quantity)(before)) * (before.time - time);
        self.jumped = Some((since, [integral + part, (self.quantity)(after), after.time], after.step));
    }

    fn join(&mut self, next: Self) {
        let others = next.moments();
        if others.number > 0.0 {
            self.several |= next.several || self.trajectory.is_some();
            if self.trajectory.is_none() {
                (self.trajectory, self.blocks) = (next.trajectory, next.blocks);
            }
        }
        self.settle();
        self.all = self.all.and(others);
    }
}
