//! A deterministic thermostat: RATTLE between two halves of a Nosé–Hoover chain (Martyna, Klein, Tuckerman 1992).
//!
//! ```text
//! ξ̇₁ = (2K − N kT)/Q₁ − ξ₁ξ₂,  ξ̇ᵢ = (Qᵢ₋₁ξᵢ₋₁² − kT)/Qᵢ − ξᵢξᵢ₊₁,  η̇ᵢ = ξᵢ,  ṗ = −ξ₁ p        N independent momenta
//! E = K + U + Σ Qᵢξᵢ²/2 + N kT η₁ + kT (η₂ + η₃)        is kept;  Q₁ = N kT τ²,  Qᵢ = kT τ²
//! ```
//!
//! Bodies have the canonical distribution if their motion is chaotic enough. That may fail for a harmonic oscillator or
//! a single particle: use [`Langevin`](crate::effect::Langevin) there. A total momentum that forces conserve, or a
//! total angular momentum, is multiplied as all momenta are: from zero it stays zero, and its share of N kT/2 goes into
//! the other momenta. [`Scene::maxwell`](crate::scene::Scene::maxwell) begins with the right share; at rest nothing
//! begins to move.
//!
//! The chain of three moves by a symmetric splitting with the fourth-order weights of M. Suzuki and H. Yoshida, so
//! bodies and chain together are reversible.
//!
//! Source: G. Martyna, M. Tuckerman, D. Tobias, M. Klein, Mol. Phys. 87 (1996) 1117.

use crate::error::{EffectMistake, Error, MethodFailure};
use crate::methods::rattle;
use crate::motion::failure::Failure;
use crate::motion::identity::Identity;
use crate::motion::iteration::Newton;
use crate::motion::method::{Method, View, check_step_size};
use crate::motion::need::Still;
use crate::motion::parts::BodiesOf;
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::real::Scalar;
use crate::number::vector::scaled;

/// Links of the chain.
const LINKS: usize = 3;
/// 1/(2 − ∛2) twice, and what is left for the middle.
const WEIGHTS: [f64; 3] = [1.351_207_191_959_657_8, -1.702_414_383_919_315_5, 1.351_207_191_959_657_8];

/// RATTLE with a Nosé–Hoover chain of three, second order.
///
/// The heat given to the bodies counts as [work](crate::run::simulation::Simulation::work), so the energy error is that
/// of RATTLE. The sum of the energies of the bodies and of the [bath](Self::bath_energy) is conserved. Steps are not
/// divided by [`retry`](crate::run::simulation::Simulation::retry).
///
/// ```
/// use rattle::potentials::{Gravity, LennardJones};
/// use rattle::prelude::*;
/// use rattle::surfaces::Sphere;
///
/// let gas = Scene::on(Sphere { r: 2.0 }).bodies(12).with(LennardJones { epsilon: 1.0, sigma: 0.5 });
/// let at = |i: usize| { // places of a spiral
///     let (z, turn) = ((i as f64 - 5.5) / 6.0, 2.4 * i as f64);
///     let r = (1.0 - z * z).sqrt();
///     [2.0 * r * turn.cos(), 2.0 * r * turn.sin(), 2.0 * z]
/// };
/// let start = gas.maxwell(&State::of((0..12).map(at)), 0.5, 7)?;
/// let method = NoseHoover::new(0.5, 1.0, 0.01);
/// let mut simulation = gas.simulate(start, method)?;
/// let energy = simulation.energy();
/// simulation.run(1000)?;
/// let kept = simulation.energy() + method.bath_energy(simulation.memory(), simulation.freedom());
/// assert!((kept - energy).abs() < 1e-2);
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "thermostat")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoseHoover {
    temperature: f64,
    time: f64,
    h: f64,
}

impl NoseHoover {
    /// The method at the temperature kT, an energy, with the time scale τ = `time` of the bath, some tens of steps, and
    /// step size `h`, both in the unit of time. A step in which the bath would change momenta by a factor above 1000 is
    /// an error.
    #[must_use]
    pub fn new(temperature: f64, time: f64, h: f64) -> Self {
        Self { temperature, time, h }
    }

    /// The energy of the bath, from the [memory](crate::run::simulation::Simulation::memory) and the number of
    /// [independent momenta](crate::run::simulation::Simulation::freedom) of a simulation; 0 at the start.
    #[must_use]
    pub fn bath_energy(&self, memory: &[f64], freedom: usize) -> f64 {
        let (rates, places) = memory.split_at(memory.len() / 2);
        let each = rates.iter().zip(places).enumerate();
        let of = |(i, (rate, place)): (usize, (&f64, &f64))| {
            let number = if i == 0 { freedom as f64 } else { 1.0 };
            number * self.temperature * (0.5 * (self.time * rate).powi(2) + place)
        };
        each.map(of).sum()
    }

    /// Moves the chain for a time h with the bodies' momenta.
    fn exchange<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        h: f64,
        system: &Y,
        bodies: &mut BodiesOf<Y, T, D>,
        memory: &mut [T],
    ) -> Result<(), Failure> {
        let number = |x: f64| T::from_f64(x);
        let freedom = system.freedom(bodies) as f64;
        if freedom == 0.0 {
            return Ok(());
        }
        let start = system.kinetic_energy(bodies);
        let (rates, places) = memory.split_at_mut(LINKS);
        let (tau, mut factor) = (number(1.0 / (self.time * self.time)), number(1.0));
        // ξ̇ without the next link's friction, at kinetic energies K α² of the bodies.
        let pull = |i: usize, rates: &[T], factor: T| match i {
            0 => (factor * factor * start * number(2.0 / (freedom * self.temperature)) - number(1.0)) * tau,
            1 => rates[0] * rates[0] * number(freedom) - tau,
            _ => rates[i - 1] * rates[i - 1] - tau,
        };
        let fade = |h: f64, rate: T| (number(-h) * rate).exp();
        for weight in WEIGHTS {
            let h = weight * h;
            for i in (0..LINKS).rev() {
                let half = if i + 1 < LINKS { fade(0.25 * h, rates[i + 1]) } else { number(1.0) };
                rates[i] = (rates[i] * half + number(0.5 * h) * pull(i, rates, factor)) * half;
            }
            factor = factor * fade(h, rates[0]);
            for (place, rate) in places.iter_mut().zip(&*rates) {
                *place = *place + number(h) * *rate;
            }
            for i in 0..LINKS {
                let half = if i + 1 < LINKS { fade(0.25 * h, rates[i + 1]) } else { number(1.0) };
                rates[i] = (rates[i] * half + number(0.5 * h) * pull(i, rates, factor)) * half;
            }
        }
        // Nearer bounds would refuse starts that are far from the temperature.
        if !(1e-3..=1e3).contains(&factor.to_f64()) {
            let (factor, hot) = (factor.to_f64(), 2.0 * start.to_f64() / (freedom * self.temperature));
            let cause = MethodFailure::BathTooFast { factor, h: self.h, time: self.time, hot }.into();
            return Err(Failure { body: 0, cause });
        }
        for (p, low) in bodies.p.as_mut().iter_mut().zip(bodies.p_low.as_mut()) {
            (*p, *low) = (scaled(factor, p), scaled(factor, low));
        }
        bodies.work = bodies.work + (system.kinetic_energy(bodies) - start);
        Ok(())
    }
}

impl Method for NoseHoover {
    type Memory<T: Scalar> = Vec<T>;
    type Need = Still;

    fn step_size(&self) -> f64 {
        self.h
    }
    fn order(&self) -> u32 {
        2
    }
    fn name(&self) -> &'static str {
        "RATTLE with a Nosé–Hoover chain"
    }
    fn with_step(&self, h: f64) -> Self {
        Self { h, ..*self }
    }
    fn evaluations(&self) -> Option<usize> {
        Some(1)
    }
    fn is_symmetric(&self) -> bool {
        false // only together with what it remembers
    }
    fn undivided(&self) -> Option<&'static str> {
        Some("its bath goes on from step to step")
    }
    fn parameters(&self) -> Vec<f64> {
        vec![self.temperature, self.time]
    }
    fn check(&self, _: usize) -> Result<(), Error> {
        check_step_size(self.h)?;
        let of = |mistake| Error::Effect { effect: "NoseHoover", mistake };
        EffectMistake::unless_positive("temperature", self.temperature).map_err(of)?;
        EffectMistake::unless_positive("time", self.time).map_err(of)
    }

    /// Without the step size: the bath is a part of the state, which goes on with other steps.
    fn identity(&self) -> Identity {
        Identity::of::<Self>(self.name(), self.parameters())
    }

    fn memory<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        _: View<'_, Self, T, Y, D>,
        _: &BodiesOf<Y, T, D>,
    ) -> Vec<T> {
        vec![T::from_f64(0.0); 2 * LINKS]
    }

    fn step<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        memory: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        self.exchange(0.5 * self.h, system, bodies, memory)?;
        rattle::step::<Newton, _, _, _, D>(self.h, &[], system, bodies, witness)?;
        self.exchange(0.5 * self.h, system, bodies, memory)
    }
}
