//! Position Verlet with constraints: half the free motion, the whole kick, the other half.
//!
//! ```text
//! a step of RATTLE of size h/2 without force
//! p ← p + h f(q), tangent
//! a step of RATTLE of size h/2 without force
//! ```
//!
//! Without constraints it is the drift–kick–drift form of the Störmer–Verlet method. Second order, symplectic, symmetric;
//! one force per step, evaluated half way. The limit h·κ·|v| < 1 holds for h/2: steps may be twice as long as RATTLE's.
//!
//! Source: M. Tuckerman, B. J. Berne, G. J. Martyna, J. Chem. Phys. 97 (1992) 1990; with constraints it is the other
//! order of [geodesic RATTLE](crate::methods::geodesic).

use crate::motion::bodies::Bodies;
use crate::motion::failure::Failure;
use crate::motion::method::Method;
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::real::Real;

/// Position Verlet with a constant step size, second order.
///
/// Multipliers told to an observer are those of the free motion alone.
///
/// ```
/// # use rattle::PositionVerlet;
/// let method = PositionVerlet::new(0.01);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PositionVerlet {
    h: f64,
}

impl PositionVerlet {
    /// The method with step size `h`, in the unit of time.
    #[must_use]
    pub fn new(h: f64) -> Self {
        Self { h }
    }
}

impl Method for PositionVerlet {
    type Memory<T: Real> = [T; 0];

    fn step_size(&self) -> f64 {
        self.h
    }
    fn order(&self) -> u32 {
        2
    }
    fn name(&self) -> &'static str {
        "position Verlet"
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
        let half = 0.5 * self.h;
        system.drift(0.0, half, bodies, witness)?;
        system.evaluate_forces(bodies);
        system.settle(self.h, self.h, bodies, &mut ())?;
        system.drift(0.0, half, bodies, witness)?;
        system.settle(0.0, half, bodies, witness)
    }
}
