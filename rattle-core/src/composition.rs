//! Compositions: methods of high order from steps of RATTLE with well-chosen sizes.
//!
//! ```text
//! Ψₕ = Φ_{γₛh} ∘ … ∘ Φ_{γ₁h},   γ_{s+1−i} = γᵢ,   Σγᵢ = 1,   Σγᵢ³ = 0 (order 4)
//! ```
//!
//! A symmetric method of order 2 composed symmetrically stays symplectic and reversible. Some γ are
//! negative, and the limit h·κ·|v| < 1 holds for each |γᵢ|h.

use crate::bodies::Bodies;
use crate::error::Error;
use crate::rattle;
use crate::real::Real;
use crate::stepper::{Failure, Stepper, Witness, check_step_size};
use crate::system::System;

/// Coefficients of a symmetric composition.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    /// Author, year, order.
    pub name: &'static str,
    /// The order that they raise a method of order 2 to.
    pub order: u32,
    /// γ₁ … γₛ.
    pub gammas: &'static [f64],
}

/// M. Suzuki, Phys. Lett. A 146 (1990) 319: γ₁ = γ₂ = 1/(4 − ∛4), γ₃ = −∛4 γ₁; five steps, |γ| ≤ 0.66.
#[allow(clippy::excessive_precision, reason = "rounded once, by the compiler")]
pub const SUZUKI_1990_ORDER_4: Coefficients = Coefficients {
    name: "Suzuki 1990, order 4",
    order: 4,
    gammas: &[
        0.414_490_771_794_375_737_142_354,
        0.414_490_771_794_375_737_142_354,
        -0.657_963_087_177_502_948_569_416,
        0.414_490_771_794_375_737_142_354,
        0.414_490_771_794_375_737_142_354,
    ],
};

/// RATTLE steps of sizes γᵢh, together one step of size h.
///
/// ```
/// # use rattle_core::composition::{Composition, SUZUKI_1990_ORDER_4};
/// let method = Composition::new(SUZUKI_1990_ORDER_4, 0.03);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Composition {
    coefficients: Coefficients,
    h: f64,
}

impl Composition {
    /// The composition with these coefficients and step size `h`, in the unit of time.
    #[must_use]
    pub fn new(coefficients: Coefficients, h: f64) -> Self {
        Self { coefficients, h }
    }
}

impl Stepper for Composition {
    fn step_size(&self) -> f64 {
        self.h
    }
    fn order(&self) -> u32 {
        self.coefficients.order
    }
    fn name(&self) -> &'static str {
        self.coefficients.name
    }
    fn check(&self, _: usize) -> Result<(), Error> {
        let Coefficients { name, gammas, .. } = self.coefficients;
        let sum: f64 = gammas.iter().sum();
        let rounding = f64::EPSILON * gammas.iter().map(|gamma| gamma.abs()).sum::<f64>();
        let adds_up = (sum - 1.0).abs() <= 8.0 * rounding; // false for NaN
        if !(gammas.iter().eq(gammas.iter().rev()) && adds_up) {
            return Err(Error::Coefficients { name, sum });
        }
        check_step_size(self.h)
    }

    #[inline(always)]
    fn step<T: Real, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: &Y,
        bodies: &mut Bodies<Y::Count, T, Y::Kept, D>,
        witness: &mut W,
    ) -> Result<(), Failure> {
        for gamma in self.coefficients.gammas {
            rattle::step(gamma * self.h, system, bodies, witness)?;
        }
        Ok(())
    }
}
