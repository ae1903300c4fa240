//! RATTLE: the symplectic integrator of constrained mechanics (Andersen 1983).
//!
//! ```text
//! p½ = p  + h/2 (∇g(q) λ − ∇U(q))         λ such that g(q′) = 0
//! q′ = q  + h p½
//! p′ = p½ + h/2 (∇g(q′) μ − ∇U(q′))       μ such that ∇g(q′)·p′ = 0
//! ```
//!
//! Second order, symplectic, and reversible while the step is short enough to have one clear solution, h·κ·|v| ≲ ½.
//! λ and μ are on one scale, that of q̈ = −∇U + ∇g λ; each is
//! first order, their mean (μₙ + λₙ₊₁)/2 at tₙ second. Without constraints, RATTLE is the velocity form of the
//! Störmer–Verlet method, kick–drift–kick.
//!
//! The step is formed as an increment and added once, q and p are compensated sums (Kahan 1965):
//! rounding in the energy then grows like √n steps instead of like n. The first guess of λ comes
//! from the second derivative of g along the motion, so that a step is a pure function of the state; or, if wanted, from
//! the parabola through the last three λ, 3λₙ − 3λₙ₋₁ + λₙ₋₂, which needs no second derivative.
//!
//! Source: E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, VII.1.4.

use crate::bodies::Bodies;
use crate::guess::{Extrapolated, FromState, Guess};
use crate::real::Real;
use crate::stepper::{Failure, Stepper, Witness};
use crate::system::System;

/// RATTLE with a constant step size, second order.
///
/// A negative step size runs backwards in time. A step needs h·κ·|v| < 1, with κ the normal curvature of the
/// surface along the velocity v, and is an error otherwise; accurate runs stay below a fifth of that.
///
/// ```
/// # use rattle_core::rattle::Rattle;
/// let method = Rattle::new(0.01);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rattle<G = FromState> {
    h: f64,
    guess: G,
}

impl Rattle {
    /// RATTLE with step size `h`, in the unit of time.
    #[must_use]
    pub fn new(h: f64) -> Self {
        Self { h, guess: FromState }
    }

    /// The same method, its iteration begun with multipliers extrapolated from the last steps: the same motion to rounding,
    /// for fewer evaluations, unless sheets of the surface lie closer to each other than such guesses are off. A state taken from a simulation carries them. Linked bodies do not make use of it.
    ///
    /// ```
    /// # use rattle_core::rattle::Rattle;
    /// let method = Rattle::new(0.01).extrapolated();
    /// ```
    #[must_use]
    pub fn extrapolated(self) -> Rattle<Extrapolated> {
        Rattle { h: self.h, guess: Extrapolated }
    }
}

impl<G: Guess> Stepper for Rattle<G> {
    type Memory<T: Real> = G::Memory<T>;

    fn step_size(&self) -> f64 {
        self.h
    }
    fn order(&self) -> u32 {
        2
    }
    fn name(&self) -> &'static str {
        "RATTLE"
    }
    fn with_step(&self, h: f64) -> Self {
        Self { h, ..*self }
    }
    fn is_symmetric(&self) -> bool {
        true
    }
    fn rattle_steps(&self) -> Option<Vec<f64>> {
        Some(vec![self.h])
    }

    fn memory<T: Real, Y: System<T, D>, const D: usize>(
        &self,
        system: &Y,
        _: &Bodies<Y::Count, T, Y::Kept, D>,
    ) -> G::Memory<T> {
        // How many steps there were, up to three; the guess, and λ of the last three.
        G::numbers(1 + 4 * system.equations())
    }

    #[inline(always)]
    fn step<T: Real, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: &Y,
        bodies: &mut Bodies<Y::Count, T, Y::Kept, D>,
        memory: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        let Some((steps, multipliers)) = memory.split_first_mut() else {
            return step(self.h, system, bodies, witness);
        };
        let (guess, past) = multipliers.split_at_mut(system.equations());
        let mut recorded = Recorded { past, witness };
        if steps.lanes().all(|steps| steps >= 3.0) {
            recorded.extrapolate(guess);
            system.drift_near(0.5 * self.h, self.h, guess, bodies, &mut recorded)?;
        } else {
            system.drift(0.5 * self.h, self.h, bodies, &mut recorded)?;
            *steps = *steps + T::from_f64(1.0);
        }
        system.evaluate_forces(bodies);
        system.settle(0.5 * self.h, self.h, bodies, witness)
    }
}

/// λ of each equation in the last three steps, the last one first, and who else listens.
struct Recorded<'a, T, W> {
    past: &'a mut [T],
    witness: &'a mut W,
}

impl<T: Real, W> Recorded<'_, T, W> {
    #[inline(always)]
    fn extrapolate(&self, guess: &mut [T]) {
        let three = T::from_f64(3.0);
        for (guess, past) in guess.iter_mut().zip(self.past.as_chunks::<3>().0) {
            *guess = three * (past[0] - past[1]) + past[2];
        }
    }
}

impl<T: Real, W: Witness<T>> Witness<T> for Recorded<'_, T, W> {
    #[inline(always)]
    fn position_multiplier(&mut self, equation: usize, lambda: T) {
        let past = &mut self.past[3 * equation..][..3];
        (past[2], past[1], past[0]) = (past[1], past[0], lambda);
        self.witness.position_multiplier(equation, lambda);
    }
    #[inline(always)]
    fn momentum_multiplier(&mut self, equation: usize, mu: T) {
        self.witness.momentum_multiplier(equation, mu);
    }
}

/// One step of size `h`; on failure `bodies` are left half way.
#[inline(always)]
pub(crate) fn step<T: Real, Y: System<T, D>, W: Witness<T>, const D: usize>(
    h: f64,
    system: &Y,
    bodies: &mut Bodies<Y::Count, T, Y::Kept, D>,
    witness: &mut W,
) -> Result<(), Failure> {
    system.drift(0.5 * h, h, bodies, witness)?;
    system.evaluate_forces(bodies);
    system.settle(0.5 * h, h, bodies, witness)
}
