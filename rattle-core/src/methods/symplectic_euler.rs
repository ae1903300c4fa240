//! The symplectic Euler method with constraints: a whole kick, then the drift.
//!
//! ```text
//! p½ = p  + h (f(q) + G(q)ᵀλ)       λ such that g(q′) = 0
//! q′ = q  + h M⁻¹ p½
//! p′ = p½ + h G(q′)ᵀμ               μ such that G(q′) M⁻¹ p′ = 0
//! ```
//!
//! Symplectic, first order, not symmetric. For comparison: RATTLE costs the same and is of second order.
//!
//! Source: E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, VII.1.3.

use crate::motion::bodies::Bodies;
use crate::motion::failure::Failure;
use crate::motion::method::Method;
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::real::Real;

/// The symplectic Euler method with a constant step size, first order.
///
/// ```
/// use rattle::{Scene, State, SymplecticEuler};
///
/// let start = State::at([0.0]).moving([1.0]);
/// let mut simulation = Scene::point().simulate(start, SymplecticEuler::new(0.5))?;
/// simulation.run(4)?;
/// assert_eq!(simulation.position().x, 2.0);
/// # Ok::<(), rattle::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SymplecticEuler {
    h: f64,
}

impl SymplecticEuler {
    /// The method with step size `h`, in the unit of time.
    #[must_use]
    pub fn new(h: f64) -> Self {
        Self { h }
    }
}

impl Method for SymplecticEuler {
    type Memory<T: Real> = [T; 0];

    fn step_size(&self) -> f64 {
        self.h
    }
    fn order(&self) -> u32 {
        1
    }
    fn name(&self) -> &'static str {
        "symplectic Euler"
    }
    fn with_step(&self, h: f64) -> Self {
        Self::new(h)
    }
    fn is_symmetric(&self) -> bool {
        false
    }

    #[inline(always)]
    fn step<T: Real, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: &Y,
        bodies: &mut Bodies<Y::Count, T, Y::Kept, D>,
        _: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        system.drift(self.h, self.h, bodies, witness)?;
        system.evaluate_forces(bodies);
        system.settle(0.0, self.h, bodies, witness)
    }
}
