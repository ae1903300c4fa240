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
//! from the second derivative of g along the motion, so that a step is a pure function of the state.
//!
//! Source: E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, VII.1.4.

use crate::bodies::Bodies;
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
pub struct Rattle {
    h: f64,
}

impl Rattle {
    /// RATTLE with step size `h`, in the unit of time.
    #[must_use]
    pub fn new(h: f64) -> Self {
        Self { h }
    }
}

impl Stepper for Rattle {
    type Memory<T: Real> = [T; 0];

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
        Self::new(h)
    }
    fn is_symmetric(&self) -> bool {
        true
    }

    #[inline(always)]
    fn step<T: Real, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: &Y,
        bodies: &mut Bodies<Y::Count, T, Y::Kept, D>,
        _: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        step(self.h, system, bodies, witness)
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
