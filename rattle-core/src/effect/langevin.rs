//! A thermostat by friction and noise: Langevin's equation.

use crate::effect::flow::Flow;
use crate::effect::interval::{Interval, Rule};
use crate::effect::ornstein_uhlenbeck::OrnsteinUhlenbeck;
use crate::error::EffectMistake;
use crate::number::real::Real;
use crate::number::vector::{scaled, sum};

/// Friction and noise that keep bodies at a temperature (P. Langevin 1908).
///
/// ```text
/// dp = −γ p dt + √(2γ kT) Π L dW       M = L Lᵀ, Π onto momenta along the constraints
/// Φₕ(p) = c p + √((1 − c²) kT) Π L ξ   c = exp(−γh), ξ normal: exact
/// ```
///
/// In equilibrium momenta have the Maxwell–Boltzmann distribution in the tangent space: ½kT for each [independent
/// momentum](crate::run::simulation::Simulation::freedom), whatever the masses. Positions have the density exp(−U/kT)
/// with respect to the area of the constraint surface in the metric of the masses; without forces they are uniform in
/// that area.
///
/// With [`Rattle`](crate::methods::rattle::Rattle) a step is the splitting O B A B O (A: drift, B: kick, O: friction
/// and noise); with [`Baoab`](crate::methods::baoab::Baoab) it is B A O A B. The latter has smaller errors in averages
/// over positions, none in a harmonic trap, and takes less time in the SIMD lanes of ensembles: use it. Its momenta are
/// colder under stiff forces: `temperature()` is kT (1 − h²ω²/4) in a harmonic trap of frequency ω, and kT with
/// `Rattle`. Heat counts as [work](crate::run::simulation::Simulation::work), so the energy error is that of the
/// method.
///
/// Steps that do not resolve the friction, h γ above ½, still have the right averages over positions by `Baoab`, but
/// not the right ways: drift velocities under a force and diffusion constants are x coth x times what they should be, x
/// = h γ/2, by both methods. That is 1.08 at h γ = 1, 2.07 at 4 and 5 at 10. Overdamped motion is
/// [`Brownian`](crate::methods::brownian::Brownian).
///
/// Source: B. Leimkuhler, C. Matthews, Proc. R. Soc. A 472 (2016) 20160138.
///
/// ```
/// use rattle::effect::Langevin;
/// use rattle::prelude::*;
/// use rattle::surfaces::Sphere;
///
/// let heat = Langevin { friction: 1.0, temperature: 0.5, seed: 7 };
/// let gas = Scene::on(Sphere { r: 1.0 }).bodies(100).with(heat);
/// let mut simulation = gas.simulate(State::of([[0.0, 0.0, 1.0]; 100]), Baoab::new(0.05))?;
/// let mut sum = 0.0;
/// simulation.run(200)?;
/// simulation.run_with(500, |now| sum += now.temperature())?;
/// assert!((sum / 500.0 - 0.5).abs() < 0.02);
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "stochastic")]
#[doc(alias = "heat bath")]
#[doc(alias = "canonical")]
#[doc(alias = "friction")]
#[doc(alias = "thermostat")]
#[doc(alias = "noise")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Langevin {
    /// The friction γ, in the unit of 1/time: without forces, momenta are correlated like exp(−γt).
    pub friction: f64,
    /// kT, an energy.
    pub temperature: f64,
    /// The seed of the random numbers: the same seed gives the same noise.
    pub seed: u64,
}

impl Langevin {
    fn process(&self, h: f64) -> OrnsteinUhlenbeck {
        let Self { friction, temperature, seed } = *self;
        let lost = (-friction * h).exp_m1();
        OrnsteinUhlenbeck { lost, variance: temperature * -(-2.0 * friction * h).exp_m1(), seed }
    }
}

impl<const D: usize> Flow<D> for Langevin {
    const RULE: Rule = Rule::Random;

    fn flow<T: Real>(&self, during: &Interval<'_, T, D>, changes: &mut [[T; D]]) {
        let OrnsteinUhlenbeck { lost, variance, seed } = self.process(during.h);
        for (body, (change, p)) in changes.iter_mut().zip(during.momenta).enumerate() {
            *change = sum(&scaled(T::from_f64(lost), p), &during.normal(seed, body, variance));
        }
    }

    fn ornstein_uhlenbeck(&self, h: f64) -> Option<OrnsteinUhlenbeck> {
        Some(self.process(h))
    }

    fn check(&self, _: usize) -> Result<(), EffectMistake> {
        EffectMistake::unless_positive_or_zero("friction", self.friction)?;
        EffectMistake::unless_positive_or_zero("temperature", self.temperature)
    }
}
