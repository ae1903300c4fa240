//! Random numbers of an effect.

use crate::number::philox::{normal, philox, unit};

/// A seed as two numbers of 32 bits each, which lose none.
pub(crate) fn halves(seed: u64) -> [f64; 2] {
    [(seed >> 32) as f64, (seed & 0xFFFF_FFFF) as f64]
}

/// The source of random numbers: a function of a seed, of the number of the trajectory and of *when* they are drawn. So
/// they are the same for any number of threads, with any other trajectories, and after a restart.
///
/// ```text
/// words = Philox4x64-10(key = (seed, 0), counter = (trajectory, step, effect, draw))
/// draw  = place within the step · 2⁴⁰ + number of the draw        2²² more for the place where flows take note
/// ```
///
/// `trajectory` is the index in an ensemble, 0 in a simulation, or the number given to
/// [`State::numbered`](crate::motion::state::State::numbered). `step` counts from the first start, across restarts.
/// `effect` is the number of the flow in its scene; for momenta that a method draws itself, as
/// [`Brownian`](crate::methods::brownian::Brownian) does, it is 2⁶⁴ − 1, so that the seeds of a method and of a flow
/// may be equal. The words are those of NumPy's `Philox` with the counter one less, since NumPy counts before
/// it draws: those of `Philox(key=seed, counter=[trajectory - 1, step, effect, draw])`, and for trajectory 0 one less
/// as a number of 256 bits, of which the first word is the lowest.
#[doc(alias = "random number generator")]
#[doc(alias = "rng")]
#[doc(alias = "Philox")]
#[doc(alias = "seed")]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Noise {
    /// The number of the trajectory.
    pub trajectory: u64,
    /// Steps taken since the first start.
    pub step: u64,
    /// The number of the flow among those of the scene; 2⁶⁴ − 1 for a method.
    pub effect: u64,
    /// The number of flows that acted earlier in this step.
    pub place: u64,
}

impl Noise {
    /// In place of the number of a flow where a method draws.
    pub(crate) const METHOD: u64 = u64::MAX;

    /// The four words of this draw; a flow may number its draws in any way, below 2⁴⁰.
    #[must_use]
    #[inline]
    pub fn words(&self, seed: u64, draw: u64) -> [u64; 4] {
        philox([seed, 0], [self.trajectory, self.step, self.effect, (self.place << 40) | draw])
    }

    /// Four independent numbers, uniform in (0, 1].
    #[doc(alias = "random")]
    #[must_use]
    pub fn uniform(&self, seed: u64, draw: u64) -> [f64; 4] {
        self.words(seed, draw).map(unit)
    }

    /// D independent normal numbers of mean 0 and variance 1 for body number `body`. Uses the draws from body · ⌈D/4⌉
    /// on.
    #[doc(alias = "random")]
    #[doc(alias = "Gaussian")]
    #[must_use]
    pub fn normal<const D: usize>(&self, seed: u64, body: usize) -> [f64; D] {
        let mut numbers = [0.0; D];
        let first = body as u64 * D.div_ceil(4) as u64;
        for (draw, four) in (first..).zip(numbers.chunks_mut(4)) {
            four.copy_from_slice(&normal(self.words(seed, draw))[..four.len()]);
        }
        numbers
    }
}
