//! A thermostat that rescales all momenta at random, so that the kinetic energy has the canonical distribution.

use crate::effect::flow::Flow;
use crate::effect::interval::{Interval, Rule};
use crate::effect::noise::Noise;
use crate::error::EffectMistake;
use crate::number::philox::normal;
use crate::number::real::{Real, each_lane};
use crate::number::vector::scaled;

/// Velocity rescaling with the right fluctuations (G. Bussi, D. Donadio, M. Parrinello 2007).
///
/// ```text
/// dK = (K̄ − K) dt/τ + 2 √(K K̄/(N τ)) dW        K̄ = N kT/2,  N independent momenta
/// Φₕ(p) = α p,  α² = c + (1 − c) (K̄/(N K)) Σᵢ₌₁ᴺ Rᵢ² + 2 R₁ √(c (1 − c) K̄/(N K)),  c = exp(−h/τ): exact
/// ```
///
/// All momenta are multiplied by one factor, so their directions are unchanged: motion is disturbed less than by
/// [`Langevin`](crate::effect::Langevin), and single bodies are not randomised. For many bodies that exchange energy. A
/// single particle gets the right distribution of energies, but keeps to its path.
///
/// A total momentum that forces conserve, or a total angular momentum, is multiplied as well: from zero it stays zero,
/// and all of K̄ goes into the other momenta. [`Scene::maxwell`](crate::scene::Scene::maxwell) gives it its right
/// share.
///
/// Bodies at rest stay at rest: a start needs momenta, for example by [`Scene::maxwell`](crate::scene::Scene::maxwell).
/// Motion imposed by moving links is not heat: it is not in K and not rescaled.
///
/// Source: J. Chem. Phys. 126 (2007) 014101, Appendix A.
///
/// ```
/// use rattle::effect::VelocityRescaling;
/// use rattle::prelude::*;
///
/// let heat = VelocityRescaling { time: 1.0, temperature: 2.0, seed: 7 };
/// let start = State::of([[0.0; 3]; 50]).moving([1.0, 0.0, 0.0]);
/// let mut simulation = Scene::points(50).with(heat).simulate(start, Rattle::new(0.1))?;
/// let mut sum = 0.0;
/// simulation.run(100)?;
/// simulation.run_with(10_000, |now| sum += now.temperature())?;
/// assert!((sum / 10_000.0 - 2.0).abs() < 0.1);
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "Bussi")]
#[doc(alias = "v-rescale")]
#[doc(alias = "CSVR")]
#[doc(alias = "thermostat")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VelocityRescaling {
    /// τ, the relaxation time of the kinetic energy.
    pub time: f64,
    /// kT, an energy.
    pub temperature: f64,
    /// The seed of the random numbers.
    pub seed: u64,
}

impl<const D: usize> Flow<D> for VelocityRescaling {
    const RULE: Rule = Rule::Random;

    fn flow<T: Real>(&self, during: &Interval<'_, T, D>, changes: &mut [[T; D]]) {
        let kinetic = during.thermal_energy();
        let factor = each_lane(kinetic, |kinetic| self.factor(during, kinetic) - 1.0);
        for (change, p) in changes.iter_mut().zip(during.momenta) {
            *change = scaled(factor, p);
        }
    }

    fn check(&self, _: usize) -> Result<(), EffectMistake> {
        EffectMistake::unless_positive_or_zero("temperature", self.temperature)?;
        EffectMistake::unless_positive("time", self.time)
    }
}

impl VelocityRescaling {
    /// α; 1 for bodies at rest, which have no direction to go in.
    fn factor<T, const D: usize>(&self, during: &Interval<'_, T, D>, kinetic: f64) -> f64 {
        if kinetic <= f64::MIN_POSITIVE / f64::EPSILON || during.freedom == 0 {
            return 1.0;
        }
        let (kept, gone) = ((-during.h / self.time).exp(), -(-during.h / self.time).exp_m1());
        let [first, ..] = normal(during.noise.words(self.seed, 0));
        let others = chi_squared(&during.noise, self.seed, during.freedom - 1);
        let share = gone * 0.5 * self.temperature / kinetic; // (1 − c) K̄/(N K)
        let square = kept + share * (first * first + others) + 2.0 * first * (kept * share).sqrt();
        // The sign of α is that of R₁ + √(c/share): momenta turn over where noise is all that is left.
        let sign = if first + (kept / share).sqrt() < 0.0 { -1.0 } else { 1.0 };
        sign * square.max(0.0).sqrt()
    }
}

/// The sum of so many squares of independent normal numbers, from the draws from 1 on.
///
/// Up to 64 one by one; more as a number of the gamma distribution (G. Marsaglia, W. Tsang, ACM Trans. Math. Softw. 26
/// (2000) 363).
fn chi_squared(noise: &Noise, seed: u64, number: usize) -> f64 {
    if number <= 64 {
        let draws = (1..).flat_map(|draw| normal(noise.words(seed, draw)));
        return draws.take(number).map(|x| x * x).sum();
    }
    let d = 0.5 * number as f64 - 1.0 / 3.0;
    let c = 1.0 / (9.0 * d).sqrt();
    let tries = (1..).map(|draw| {
        let words = noise.words(seed, draw);
        let ([x, ..], [.., u]) = (normal(words), noise.uniform(seed, draw));
        let v = (1.0 + c * x).powi(3);
        (v > 0.0 && libm::log(u) < 0.5 * x * x + d - d * v + d * libm::log(v)).then_some(2.0 * d * v)
    });
    tries.flatten().next().unwrap_or(2.0 * d)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// χ² of N squares has the mean N, the variance 2N and the fourth moment (3 + 12/N) (2N)²: one by one up to 64, and
    /// by the gamma distribution. Bounds are 4.5 standard deviations.
    #[test]
    fn sums_of_squares() {
        for number in [1, 64, 65, 200] {
            let samples: u32 = 100_000;
            let draw = |step| {
                let noise = Noise { step: u64::from(step), ..Noise::default() };
                chi_squared(&noise, 1, number)
            };
            let (n, exact) = (f64::from(samples), number as f64);
            let [sum, square] = (0..samples)
                .map(draw)
                .fold([0.0; 2], |[sum, square], x| [sum + (x - exact), square + (x - exact).powi(2)]);
            let (off, variance) = (sum / n, square / n - (sum / n).powi(2));
            let of_variance = 2.0 * exact * ((2.0 + 12.0 / exact) / n).sqrt();
            assert!(off.abs() < 4.5 * (2.0 * exact / n).sqrt(), "{number}: {off}");
            assert!((variance - 2.0 * exact).abs() < 4.5 * of_variance, "{number}: {variance}");
        }
    }
}
