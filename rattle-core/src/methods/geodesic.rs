//! Geodesic RATTLE: kicks that are made tangent, and between them free motion in several steps (Leimkuhler, Matthews 2016).
//!
//! ```text
//! p ← p + h/2 f(q),  tangent
//! n times: a step of RATTLE of size h/n without force
//! p ← p + h/2 f(q′), tangent
//! ```
//!
//! Second order, symplectic, symmetric. One force per step, however many position equations: for forces that cost more
//! than constraints, on surfaces that are more curved than forces change. The limit h·κ·|v| < 1 holds for h/n. With n → ∞
//! the free motion is along geodesics.
//!
//! Source: B. Leimkuhler, C. Matthews, Proc. R. Soc. A 472 (2016) 20160138.

use crate::motion::bodies::Bodies;
use crate::motion::failure::Failure;
use crate::motion::method::Method;
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::real::Real;

/// Geodesic RATTLE with a constant step size, second order.
///
/// Multipliers told to an observer are shares that add up: λ keeps the free motion on the constraints, μ answers the force.
///
/// ```
/// # use rattle::Geodesic;
/// let method = Geodesic::new(0.04, 4); // free steps of 0.01
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geodesic {
    h: f64,
    inner: u32,
}

impl Geodesic {
    /// The method with step size `h`, in the unit of time, and so many steps of free motion in each.
    ///
    /// # Panics
    /// If there are none.
    #[must_use]
    #[track_caller]
    pub fn new(h: f64, inner: u32) -> Self {
        assert!(inner > 0, "a step of geodesic RATTLE has at least one inner step");
        Self { h, inner }
    }
}

impl Method for Geodesic {
    type Memory<T: Real> = [T; 0];

    fn step_size(&self) -> f64 {
        self.h
    }
    fn order(&self) -> u32 {
        2
    }
    fn name(&self) -> &'static str {
        "geodesic RATTLE"
    }
    fn with_step(&self, h: f64) -> Self {
        Self { h, ..*self }
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
        let inner = self.h / f64::from(self.inner);
        system.settle(0.5 * self.h, self.h, bodies, witness)?;
        for _ in 0..self.inner {
            system.drift(0.0, inner, bodies, witness)?;
            system.settle(0.0, inner, bodies, witness)?;
        }
        system.evaluate_forces(bodies);
        system.settle(0.5 * self.h, self.h, bodies, witness)
    }
}
