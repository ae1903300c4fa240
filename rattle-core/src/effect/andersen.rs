//! A thermostat by collisions with a heat bath: at random times a body gets a new random momentum.

use crate::effect::flow::Flow;
use crate::effect::interval::{Interval, Rule};
use crate::effect::noise::halves;
use crate::error::EffectMistake;
use crate::number::real::Real;
use crate::number::vector::add_scaled;

/// Collisions with a heat bath (H. Andersen 1980): within a time h, with the probability 1 − exp(−νh), a body gets a
/// new momentum from the Maxwell–Boltzmann distribution.
///
/// Bodies without links collide one by one. In a scene with links all collide at once: a new momentum of one body,
/// projected together with the old momenta of the others, would have another temperature.
///
/// Source: J. Chem. Phys. 72 (1980) 2384.
///
/// ```
/// use rattle::effect::Andersen;
/// use rattle::prelude::*;
///
/// let bath = Andersen { rate: 2.0, temperature: 0.5, seed: 7 };
/// let start = State::of([[0.0; 3]; 100]);
/// let mut simulation = Scene::points(100).with(bath).simulate(start, Rattle::new(0.1))?;
/// let mut sum = 0.0;
/// simulation.run(50)?;
/// simulation.run_with(500, |now| sum += now.temperature())?;
/// assert!((sum / 500.0 - 0.5).abs() < 0.02);
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "thermostat")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Andersen {
    /// ν, collisions per time.
    pub rate: f64,
    /// kT, an energy.
    pub temperature: f64,
    /// The seed of the random numbers.
    pub seed: u64,
}

impl<const D: usize> Flow<D> for Andersen {
    const RULE: Rule = Rule::Random;

    fn flow<T: Real>(&self, during: &Interval<'_, T, D>, changes: &mut [[T; D]]) {
        let chance = -(-self.rate * during.h).exp_m1();
        // Draws of momenta lie below those of chances, which are few enough not to meet.
        let collides = |body: usize| during.noise.uniform(self.seed, (1 << 39) | body as u64)[0] <= chance;
        let all = during.tied && collides(0);
        for (body, (change, p)) in changes.iter_mut().zip(during.momenta).enumerate() {
            *change = [T::from_f64(0.0); D];
            if if during.tied { all } else { collides(body) } {
                *change = add_scaled(&during.normal(self.seed, body, self.temperature), T::from_f64(-1.0), p);
            }
        }
    }

    fn parameters(&self) -> Vec<f64> {
        let [high, low] = halves(self.seed);
        vec![self.rate, self.temperature, high, low]
    }

    fn check(&self, _: usize) -> Result<(), EffectMistake> {
        EffectMistake::unless_positive_or_zero("rate", self.rate)?;
        EffectMistake::unless_positive_or_zero("temperature", self.temperature)
    }
}
