//! Reversible variable steps: steps are short where momenta change fast. Energy does not drift; it would if each step
//! size were chosen from the present state alone.
//!
//! ```text
//! ρ½ = ρ  + ε/2 G(z)        ρ follows R, the wanted density of steps:
//! z′ = Φ_{ε/ρ½}(z)          R = √(1 + τ² |ṗ|²/(|p|² + p₀²)),   dR/dt = R G,   dt = dε/R
//! ρ′ = ρ½ + ε/2 G(z′)
//! ```
//!
//! This map is its own inverse with −ε instead of ε, if Φ is symmetric, so the energy of reversible motion does not
//! drift. The price is a further number, ρ, kept from step to step. The only condition is that G changes its sign with
//! the momenta. The difference of two steps of RATTLE,
//!
//! ```text
//! G(z) = ln(R(Ψ_δ(z))/R(Ψ_{−δ}(z)))/2δ        Ψ a step of RATTLE, δ = ε/32
//! ```
//!
//! does that exactly, for any R, without a derivative of R. ε is about the longest step: R is at least 1, and ρ/R at
//! least ½, so just behind a passage one may be up to twice as long. τ is a time: where momenta change by
//! their own size within τ, steps are shorter than ε. p₀² is a tenth of |p|² + τ²|ṗ|² at the start, so R stays finite
//! where bodies are at rest. If nothing moves at the start, and no force acts, it is a tenth of the largest so far, and
//! steps are reversible from where that no longer grows.
//!
//! ρ is an integral of G, and departs from R where steps are too long: a step after which ρ/R is outside of (½, 3/2) is
//! an error. The simpler recursion ρ′ρ = R² (Huang, Leimkuhler 1997) has a second solution, of alternating sign, that
//! is not damped. On the lemniscate with ε = 0.06 τ, in half steps, its ρ differed from R by a factor of 20 by t =
//! 5000; the ρ of this module stayed within 6 % in whole steps.
//!
//! Φ keeps no memory between steps: its `guess(…)` has no effect.
//!
//! Source: E. Hairer, G. Söderlind, SIAM J. Sci. Comput. 26 (2005) 1838.

use crate::error::{Error, MethodFailure};
use crate::methods::rattle;
use crate::motion::capability::Rates;
use crate::motion::failure::Failure;
use crate::motion::iteration::Newton;
use crate::motion::method::{Method, Stage, View};
use crate::motion::need::{Steps, WithRates};
use crate::motion::parts::BodiesOf;
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::real::Scalar;
use crate::number::vector::dot;

/// ρ and R may differ by this part of R.
const ASTRAY: f64 = 0.5;
/// δ, as a part of ε: well below the shortest, well above the rounding of a difference.
const PROBE: f64 = 1.0 / 32.0;
/// p₀² as a part of what the start has.
const REST: f64 = 0.1;

/// Reversible variable steps of a symmetric method: steps are shorter where momenta change fast.
///
/// The method is reversible, not symplectic. On a surface of genus two with sharp ends the energy error is a half to a
/// quarter of that of as many equal steps. But each step costs two further steps of RATTLE, for the change of R. So
/// variable steps pay where a step of `base` costs more than that, and where long gentle motion alternates with short
/// violent motion.
///
/// In chaotic motion the energy may wander, since only symmetry conserves it: over 2·10⁴, 2·10⁵ and 2·10⁶ steps on the
/// tube of a lemniscate (r = 0.3, gravity 1, τ = 0.3, steps of 0.016 on average) the largest error was 1.3, 2.1 and 2.5
/// ‰; with equal steps of 0.02 it was 7, 12 and 13 ‰. Where τ is far too long for a close passage, energy is lost
/// without an error.
///
/// ```
/// # use rattle::{Lobatto, Variable};
/// let method = Variable::of(Lobatto::<3>::new(0.05), 0.3); // steps of 0.05; shorter where momenta turn within 0.3
/// ```
#[doc(alias = "adaptive")]
#[doc(alias = "step size control")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variable<B> {
    base: B,
    tau: f64,
}

impl<B: Method> Variable<B> {
    /// Steps of `base`, of about its step size at most, and shorter where momenta change by their own size within the
    /// time `tau`, in the unit of time. Just behind a close passage a few may be up to twice as long.
    #[must_use]
    pub fn of(base: B, tau: f64) -> Self {
        Self { base, tau }
    }

    /// τ²|ṗ|² and |p|² of all bodies.
    fn change<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        system: View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        rates: &mut [[T; D]],
    ) -> (f64, f64) {
        let (_, _, capability) = system;
        let _ = capability.evaluate_rates(bodies, rates, &mut ());
        let zero = T::from_f64(0.0);
        let square = |x: &[[T; D]]| x.iter().fold(zero, |sum, x| sum + dot(x, x));
        let (change, size) = (square(rates).to_f64(), square(bodies.p.as_ref()).to_f64());
        (self.tau * self.tau * change, size)
    }

    /// R and G, where forces are those at these places. All is as before, and what is kept evaluated anew.
    fn density<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        scale: f64,
        all: View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
    ) -> Result<(f64, f64), Failure> {
        let delta = PROBE * self.step_size().abs();
        let mut probe = |delta: f64| {
            bodies.with_room(1, |bodies, before, rates| {
                let (_, system, _) = all;
                bodies.save(before);
                rattle::step::<Newton, _, _, _, D>(delta, &[], system, bodies, &mut ())?;
                let (change, size) = self.change(all, bodies, rates);
                system.put_back(bodies, before);
                Ok(1.0 + change / (size + scale).max(f64::MIN_POSITIVE))
            })
        };
        let (ahead, behind) = (probe(delta)?, probe(-delta)?);
        Ok(((ahead * behind).sqrt().sqrt(), (ahead.ln() - behind.ln()) / (4.0 * delta)))
    }

    /// The memory at these bodies, for p₀² of a run or that of a start here.
    fn begun<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        all: View<'_, Self, T, Y, D>,
        bodies: &BodiesOf<Y, T, D>,
        of_run: Option<f64>,
    ) -> Vec<T> {
        let mut bodies = bodies.clone();
        let mut rates = vec![[T::from_f64(0.0); D]; bodies.q.as_ref().len()];
        let (_, system, _) = all;
        system.evaluate_forces(&mut bodies);
        let (change, size) = self.change(all, &mut bodies, &mut rates);
        let here = REST * (size + change);
        let (scale, grows) = match of_run {
            Some(scale) if scale > 0.0 => (scale, false),
            Some(scale) => (here.max(-scale), true),
            None => (here, here == 0.0),
        };
        let wanted = (1.0 + change / (size + scale).max(f64::MIN_POSITIVE)).sqrt();
        // Where not even a probe can be made the first step tells why.
        let slope = self.density(scale, all, &mut bodies).map_or(0.0, |(_, slope)| slope);
        // The last step, ρ, p₀², below 0 if it grows, and G at the state.
        [0.0, wanted, if grows { -scale } else { scale }, slope].map(T::from_f64).into()
    }
}

impl<B: Method> Method for Variable<B> {
    type Memory<T: Scalar> = Vec<T>;
    type Need = (B::Need, Steps, WithRates);
    const HAS_STRUCTURE: bool = B::HAS_STRUCTURE;
    const FOLLOWS_ROOTS: bool = B::FOLLOWS_ROOTS;
    const CHECKS: bool = B::CHECKS;
    const DRAWS: bool = B::DRAWS;
    const STIRS: bool = B::STIRS;

    fn step_size(&self) -> f64 {
        self.base.step_size()
    }
    fn order(&self) -> u32 {
        self.base.order()
    }
    fn name(&self) -> &'static str {
        "reversible variable steps"
    }
    fn with_step(&self, h: f64) -> Self {
        Self { base: self.base.with_step(h), tau: self.tau }
    }
    fn is_symmetric(&self) -> bool {
        false // only together with what it remembers
    }
    fn undivided(&self) -> Option<&'static str> {
        self.base.undivided()
    }

    fn check(&self, equations: usize) -> Result<(), Error> {
        if !self.base.is_symmetric() {
            return Err(Error::NeedsSymmetricMethod { what: self.name(), method: self.base.name() });
        }
        if !(self.tau.is_finite() && self.tau > 0.0) {
            return Err(Error::ChangeTime(self.tau));
        }
        self.base.check(equations)
    }

    fn parameters(&self) -> Vec<f64> {
        [vec![self.tau], self.base.parameters(), Stage::numbers(&self.base.stages())].concat()
    }

    fn prepare<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        (base, ..): View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
    ) {
        self.base.prepare(base, bodies);
        bodies.make_room(1);
    }

    fn memory<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        all: View<'_, Self, T, Y, D>,
        bodies: &BodiesOf<Y, T, D>,
    ) -> Vec<T> {
        self.begun(all, bodies, None)
    }

    fn memory_within<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        all: View<'_, Self, T, Y, D>,
        bodies: &BodiesOf<Y, T, D>,
        of_run: &[T],
    ) -> Vec<T> {
        self.begun(all, bodies, of_run.get(2).map(|scale| scale.to_f64()))
    }

    fn time_taken<T: Scalar>(&self, memory: &[T]) -> Option<T> {
        Some(memory[0])
    }

    #[inline(always)]
    fn step<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        memory: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        let [density, scale, slope] = [1, 2, 3].map(|i| memory[i].to_f64());
        let longest = self.step_size();
        let middle = density + 0.5 * longest * slope;
        let astray = |ratio| Err(Failure { body: 0, cause: MethodFailure::Astray { ratio, longest }.into() });
        if middle.is_nan() || middle <= 0.0 {
            return astray(middle / density);
        }
        let h = longest / middle;
        let (base, ..) = system;
        self.base.with_step(h).step(base, bodies, &mut [], witness)?;

        if const { !B::KEEPS_FORCES } {
            let (_, moved, _) = system;
            moved.evaluate_forces(bodies);
        }
        if scale <= 0.0 {
            let (change, size) = bodies.with_room(1, |bodies, _, rates| self.change(system, bodies, rates));
            if scale == 0.0 || REST * (size + change) > -scale {
                memory.copy_from_slice(&self.begun(system, bodies, Some(scale)));
                memory[0] = T::from_f64(h);
                return Ok(());
            }
        }
        let (wanted, slope) = self.density(scale.abs(), system, bodies)?;
        let density = middle + 0.5 * longest * slope;
        let near = (density / wanted - 1.0).abs() <= ASTRAY; // false for NaN
        if !near {
            return astray(density / wanted);
        }
        memory.copy_from_slice(&[h, density, scale, slope].map(T::from_f64));
        Ok(())
    }
}
