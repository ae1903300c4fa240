//! Friction and noise in lanes: the Ornstein–Uhlenbeck process of the momenta, between two drifts of a step.
//!
//! ```text
//! p ← c p + √variance Π ξ      ξ normal, Π onto momenta along the surface
//! ```
//!
//! Random words are those of [`Noise`], a function of trajectory and step, and are drawn lane by lane; all else is done
//! side by side. Momenta change at random, so the Λ of the drift to come is not extrapolated from past ones: its first
//! guess is made from g̈ = 0.

use crate::effect::list::Forces;
use crate::effect::noise::Noise;
use crate::effect::ornstein_uhlenbeck::OrnsteinUhlenbeck;
use crate::kernel::functions::ConstraintKernel;
use crate::number::lanes::{Fused, Lane};
use crate::number::philox::unit;
use crate::number::real::Real;
use crate::number::vector::{add_scaled, dot, scaled, sum, two_sum};
use crate::number::vectors::{Vectors, at, put};
use crate::run::ensemble::block::{Block, Part};
use crate::run::ensemble::laws::Laws;
use std::array::from_fn;
use std::borrow::Borrow;
use std::f64::consts::TAU;

/// Momenta are taken to be no more than so many times their standard deviation in equilibrium: a normal number is
/// beyond that once in 5e8.
const DEVIATIONS: f64 = 6.0;

/// What stirs each lane.
#[derive(Clone)]
pub(super) struct Stirring<const L: usize> {
    /// After how many parts of a step.
    pub(super) after: usize,
    process: [OrnsteinUhlenbeck; L],
    /// Of which trajectory and step the random numbers are drawn, before the first step.
    first: [Noise; L],
}

impl<const L: usize> Stirring<L> {
    /// What stirs lanes that obey these laws for a time h, after so many parts of a step; none where nothing does.
    pub(super) fn of<S: Lane, X: Laws<S, D>, const D: usize>(
        laws: &X,
        after: usize,
        h: f64,
    ) -> Option<Box<Self>> {
        if const { X::Forces::FLOWS == 0 } {
            return None;
        }
        let still = OrnsteinUhlenbeck { lost: 0.0, variance: 0.0, seed: 0 };
        let process = |lane| laws.effects(lane).borrow().ornstein_uhlenbeck(h).unwrap_or(still);
        let first = from_fn(|_| Noise::default());
        Some(Box::new(Self { after, process: from_fn(process), first }))
    }

    /// Has lane `to` be stirred as lane `from` is.
    pub(super) fn copy(&mut self, from: usize, to: usize) {
        (self.process[to], self.first[to]) = (self.process[from], self.first[from]);
    }

    /// Says of which trajectory a lane draws, and how many steps that had taken before its start.
    pub(super) fn draw_as(&mut self, lane: usize, trajectory: u64, step: u64) {
        self.first[lane] = Noise { trajectory, step, ..Noise::default() };
    }

    /// Where the random numbers of a lane are after so many steps.
    pub(super) fn noise(&self, lane: usize, steps: u64) -> Noise {
        let first = self.first[lane];
        Noise { step: first.step + steps, ..first }
    }

    /// What tells the process of a lane from others.
    pub(super) fn numbers(&self, lane: usize) -> Vec<f64> {
        let OrnsteinUhlenbeck { lost, variance, seed } = self.process[lane];
        vec![lost, variance, (seed >> 32) as f64, (seed & 0xFFFF_FFFF) as f64]
    }

    /// The largest momentum to expect of a lane.
    #[inline(always)]
    pub(super) fn momentum(&self, lane: usize) -> f64 {
        DEVIATIONS * self.process[lane].temperature().sqrt()
    }

    /// Stirs all lanes, after so many steps and before the part of a step that is to come.
    #[inline(always)]
    pub(super) fn act<S, const D: usize, const SUMS: usize, const EQUAL: bool>(
        &self,
        steps: u64,
        block: &mut Block<S, L, D, SUMS, EQUAL>,
        laws: &impl Laws<S, D>,
        part: &Part,
    ) where
        S: Lane,
    {
        let (mut noise, mut kept, mut spread) = ([[Fused(0.0); L]; D], [0.0; L], [0.0; L]);
        self.draw(steps, &mut noise);
        for l in 0..L {
            let OrnsteinUhlenbeck { lost, variance, .. } = self.process[l];
            (kept[l], spread[l]) = (lost, part.unit * variance.sqrt());
        }
        let Block { q, way, normal, square, guess, past: [last, earlier], way_low, .. } = block;
        let [bends, before] = [-0.5 * (part.h / part.unit).powi(2), part.before].map(S::from_f64);
        for l in 0..L {
            let (n, old) = (at(normal, l), at(way, l));
            let (lost, spread) = (S::from_f64(kept[l]), spread[l]);
            let random = at(&noise, l).map(|x| S::from_f64(spread * x.0));
            let mut change = sum(&scaled(lost, &old), &random);
            if SUMS == 1 {
                change = sum(&at(&way_low[0], l), &change);
            }
            let change = add_scaled(&change, -dot(&n, &sum(&old, &change)) / square[l], &n);
            let new = if SUMS == 1 {
                let (new, low) = two_sum(&old, &change);
                put(&mut way_low[0], l, low);
                new
            } else {
                sum(&old, &change)
            };
            put(way, l, new);
            let [bend] = laws.constraint(l).borrow().jet(&at(q, l), &new).2;
            guess[l] = bends * bend / square[l];
            (last[l], earlier[l]) = (before * guess[l], before * guess[l]);
        }
    }

    /// Draws D normal numbers for each lane, those of [`Noise::normal`].
    #[inline(always)]
    fn draw<const D: usize>(&self, steps: u64, numbers: &mut Vectors<Fused<f64>, L, D>) {
        for (draw, four) in (0..).zip(numbers.chunks_mut(4)) {
            let mut words = [[0; L]; 4];
            for l in 0..L {
                let drawn = self.noise(l, steps).words(self.process[l].seed, draw);
                for (words, drawn) in words.iter_mut().zip(drawn) {
                    words[l] = drawn;
                }
            }
            for (two, words) in four.chunks_mut(2).zip(words.as_chunks().0) {
                normal(words, two);
            }
        }
    }
}

/// A normal number, or two, for each lane, of two words (G. Box, M. Muller).
#[inline(always)]
fn normal<const L: usize>([a, b]: &[[u64; L]; 2], numbers: &mut [[Fused<f64>; L]]) {
    let (mut cosines, mut sines) = ([Fused(0.0); L], [Fused(0.0); L]);
    for l in 0..L {
        let radius = (Fused(-2.0) * Fused(unit(a[l])).ln()).sqrt();
        let (sin, cos) = (Fused(TAU) * Fused(unit(b[l]))).sin_cos();
        (cosines[l], sines[l]) = (radius * cos, radius * sin);
    }
    for (numbers, drawn) in numbers.iter_mut().zip([cosines, sines]) {
        *numbers = drawn;
    }
}
