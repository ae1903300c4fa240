//! Heat by friction and noise: Langevin's equation.

use crate::effect::flow::Flow;
use crate::effect::interval::{Interval, Rule};
use crate::error::EffectMistake;
use crate::number::real::Real;
use crate::number::vector::{scaled, sum};

/// Friction and noise that hold bodies at a temperature (P. Langevin 1908).
///
/// ```text
/// dp = −γ p dt + √(2γ kT) Π L dW       M = L Lᵀ, Π onto momenta along the constraints
/// Φₕ(p) = c p + √((1 − c²) kT) Π L ξ   c = exp(−γh), ξ normal: exact
/// ```
///
/// All momenta then are of Maxwell's distribution in the tangent space, ½kT for each of the
/// [independent ones](crate::run::simulation::Simulation::freedom), whatever the masses; places are of the density
/// exp(−U/kT) over the surface, in the measure that masses give it: without forces uniform in area.
///
/// By [`Rattle`](crate::methods::rattle::Rattle) a step is the splitting O B A B O; by
/// [`Baoab`](crate::methods::baoab::Baoab) it is B A O A B, whose errors in averages over places are far smaller at the
/// same cost: use that. Heat counts as [work](crate::run::simulation::Simulation::work), so that the energy error is
/// that of the method.
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
#[doc(alias = "friction")]
#[doc(alias = "thermostat")]
#[doc(alias = "noise")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Langevin {
    /// γ: a rate, in the unit of 1/time; after 1/γ a momentum has forgotten half of itself and more.
    pub friction: f64,
    /// kT, an energy.
    pub temperature: f64,
    /// What random numbers are made from: the same seed, the same noise.
    pub seed: u64,
}

impl<const D: usize> Flow<D> for Langevin {
    const RULE: Rule = Rule::Random;

    fn flow<T: Real>(&self, during: &Interval<'_, T, D>, changes: &mut [[T; D]]) {
        let lost = (-self.friction * during.h).exp_m1();
        let variance = self.temperature * -(-2.0 * self.friction * during.h).exp_m1();
        for (body, (change, p)) in changes.iter_mut().zip(during.momenta).enumerate() {
            *change = sum(&scaled(T::from_f64(lost), p), &during.normal(self.seed, body, variance));
        }
    }

    fn check(&self, _: usize) -> Result<(), EffectMistake> {
        EffectMistake::unless_positive_or_zero("friction", self.friction)?;
        EffectMistake::unless_positive_or_zero("temperature", self.temperature)
    }
}
