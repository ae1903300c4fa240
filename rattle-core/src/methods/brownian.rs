//! Brownian motion: the overdamped limit, without inertia.
//!
//! ```text
//! dq = M⁻¹(f/γ dt + √(2kT/γ) L dW), along the constraints       M = L Lᵀ
//! q′ = q + h M⁻¹(f(q)/γ + √(2kT/γh) Π L ξ + ∇g(q) λ)            λ such that g(q′) = 0, ξ normal
//! ```
//!
//! This is the limit of [`Langevin`](crate::effect::Langevin) dynamics for large friction γ, with steps that need not
//! resolve 1/γ. Positions have the density exp(−U/kT) with respect to the area of the surface in the metric of the
//! masses, to first order in h; the diffusion constant is D = kT/(γm).
//!
//! Source: G. Ciccotti, T. Lelièvre, E. Vanden-Eijnden, Comm. Pure Appl. Math. 61 (2008) 371.

use crate::effect::interval::Half;
use crate::effect::noise::Noise;
use crate::error::{EffectMistake, Error, LinkedFailure, Passing, RigidFailure, StepFailure, SurfaceFailure};
use crate::motion::failure::Failure;
use crate::motion::method::{Method, Renewal, View, check_step_size};
use crate::motion::need::Kicks;
use crate::motion::parts::BodiesOf;
use crate::motion::stir::{self, Chosen};
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::real::Scalar;

/// Brownian motion by the projected Euler–Maruyama method, of first order in averages.
///
/// There are no momenta: those of a start are ignored, and after each step they are zero (with moving links, those of
/// the links). Energies are potential energies, no work is counted, and the energy error has no meaning. A step needs
/// h·κ·|v| < 1, with its random displacement as h|v|. That is √(2Dh) times a normal number, which in n steps reaches
/// some √(2 ln n): long runs need κ√(2Dh) below a seventh, and a step that is half as long helps by √2 alone. The only
/// possible [flows](crate::effect::Flow) are those that do not depend on momenta:
/// [`SelfPropulsion`](crate::effect::SelfPropulsion), and a `force!` without velocities.
///
/// ```
/// use rattle::prelude::*;
/// use rattle::surfaces::Sphere;
///
/// // ⟨(q − q₀)²⟩ = 2R² (1 − exp(−2Dt/R²))
/// let method = Brownian::new(1.0, 0.5, 7, 0.01);
/// let start = State::of([[0.0, 0.0, 1.0]; 1000]);
/// let mut simulation = Scene::on(Sphere { r: 1.0 }).bodies(1000).simulate(start, method)?;
/// simulation.run(50)?;
/// let mean = simulation.positions().map(|q| 2.0 - 2.0 * q.z).sum::<f64>() / 1000.0;
/// assert!((mean - 2.0 * (1.0 - (-0.5_f64).exp())).abs() < 0.1);
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "diffusion")]
#[doc(alias = "Smoluchowski")]
#[doc(alias = "noise")]
#[doc(alias = "Langevin")]
#[doc(alias = "overdamped")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Brownian {
    friction: f64,
    temperature: f64,
    seed: u64,
    h: f64,
}

impl Brownian {
    /// The method with the friction γ, in the unit of 1/time, the temperature kT, an energy, the seed of its random
    /// numbers, and step size `h`, in the unit of time.
    #[must_use]
    pub fn new(friction: f64, temperature: f64, seed: u64, h: f64) -> Self {
        Self { friction, temperature, seed, h }
    }

    fn drawn(&self) -> Renewal {
        let deviation = (2.0 * self.temperature / (self.friction * self.h)).sqrt();
        Renewal { seed: self.seed, deviation, kick: 1.0 / self.friction }
    }
}

impl Method for Brownian {
    type Memory<T: Scalar> = [T; 0];
    type Need = Kicks;
    const DRAWS: bool = true;
    const STIRS: bool = true;
    const FORGETS: bool = true;
    const RENEWS: bool = true;

    fn step_size(&self) -> f64 {
        self.h
    }
    fn order(&self) -> u32 {
        1
    }
    fn name(&self) -> &'static str {
        "Brownian motion"
    }
    fn with_step(&self, h: f64) -> Self {
        Self { h, ..*self }
    }
    fn evaluations(&self) -> Option<usize> {
        Some(1)
    }
    fn is_symmetric(&self) -> bool {
        false
    }
    fn undivided(&self) -> Option<&'static str> {
        Some("it has no momenta, and another division draws other random numbers")
    }
    fn renewal(&self) -> Option<Renewal> {
        Some(self.drawn())
    }
    fn parameters(&self) -> Vec<f64> {
        vec![self.friction, self.temperature]
    }
    fn check(&self, _: usize) -> Result<(), Error> {
        check_step_size(self.h)?;
        let of = |mistake| Error::Effect { effect: "Brownian", mistake };
        EffectMistake::unless_positive_or_zero("temperature", self.temperature).map_err(of)?;
        EffectMistake::unless_positive("friction", self.friction).map_err(of)?;
        if self.h < 0.0 { Err(of(EffectMistake::NoWayBack)) } else { Ok(()) }
    }

    fn step<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        _: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        step(self.drawn(), self.h, system, bodies, witness)
    }
}

/// The same failure, with the step of h that its momenta need: those that were drawn are shorter by √h in longer steps,
/// so that half of the way takes a quarter of the step.
#[cold]
fn by_noise(h: f64, mut failure: Failure) -> Failure {
    match &mut failure.cause {
        StepFailure::Surface(SurfaceFailure::StepTooLong { h, reach, longest, .. }) => {
            *longest = h.abs() / (*reach * *reach);
        }
        StepFailure::Rigid(RigidFailure::TurnsTooFar { passing: Passing(Some(passing)), .. })
        | StepFailure::Linked(
            LinkedFailure::NotSolved { passing: Passing(Some(passing)), .. }
            | LinkedFailure::RankLost { passing: Some(passing), .. },
        ) => *passing *= *passing / h,
        _ => {}
    }
    failure
}

/// Draws momenta along the constraints, by the noise of the bodies.
#[inline(always)]
fn draw<T: Scalar, Y: System<T, D>, const D: usize>(
    Renewal { seed, deviation, .. }: Renewal,
    h: f64,
    system: &Y,
    bodies: &mut BodiesOf<Y, T, D>,
) -> Result<(), Failure> {
    let noise = Noise { effect: Noise::METHOD, ..bodies.noise };
    for body in 0..bodies.q.as_ref().len() {
        let numbers = noise.normal(seed, body).map(|x: f64| T::from_f64(deviation * x));
        bodies.p.as_mut()[body] = system.inertia().root(body, &numbers);
        bodies.p_low.as_mut()[body] = [T::from_f64(0.0); D];
    }
    system.settle(0.0, h, bodies, &mut ())
}

/// Goes where the momenta that a [step](step) of h draws would lead without constraints and forces, in search of what
/// is on the way.
#[cold]
#[inline(never)]
pub(crate) fn coast<T: Scalar, Y: System<T, D>, const D: usize>(
    renewal: Renewal,
    h: f64,
    system: &Y,
    bodies: &mut BodiesOf<Y, T, D>,
) {
    if draw(renewal, h, system, bodies).is_ok() {
        system.coast(h, bodies);
    }
}

/// A step of h of a method that draws momenta anew.
#[inline(always)]
pub(crate) fn step<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
    renewal: Renewal,
    h: f64,
    system: &Y,
    bodies: &mut BodiesOf<Y, T, D>,
    witness: &mut W,
) -> Result<(), Failure> {
    let (work, zero) = (bodies.work, [T::from_f64(0.0); D]);
    draw(renewal, h, system, bodies)?;
    let kick = renewal.kick;
    if const { Y::FLOWS > 0 } {
        stir::take_note(Half::Before, 0.5 * h, system, bodies);
        stir::push(Chosen::All, Half::Before, kick, system, bodies)?;
    }
    system.drift(kick, h, bodies, witness).map_err(|failure| by_noise(h, failure))?;
    stir::take_note(Half::After, 0.5 * h, system, bodies);
    for (p, low) in bodies.p.as_mut().iter_mut().zip(bodies.p_low.as_mut()) {
        (*p, *low) = (zero, zero);
    }
    system.evaluate_forces(bodies);
    system.settle(0.0, h, bodies, witness)?;
    bodies.work = work;
    Ok(())
}
