//! Compositions: methods of high order from steps of a symmetric one with well-chosen sizes.
//!
//! ```text
//! Ψₕ = Φ_{γₛh} ∘ … ∘ Φ_{γ₁h},   γ_{s+1−i} = γᵢ,   Σγᵢ = 1,   Σγᵢ³ = 0 (order 4),   …
//! ```
//!
//! A symmetric method of order 2 composed symmetrically stays symmetric, and symplectic if it was. Some γ are
//! negative, and the limit h·κ·|v| < 1 holds for each |γᵢ|h.
//!
//! **Order conditions.** A symmetric method is exp(hY₁ + h³Y₃ + h⁵Y₅ + …) with Y₁ the exact motion and Yₖ that do not
//! commute. The composition has order p if in
//!
//! ```text
//! exp(Σₖ γ₁ᵏYₖ) ⋯ exp(Σₖ γₛᵏYₖ)
//! ```
//!
//! every word Y_a Y_b ⋯ with a + b + ⋯ ≤ p that is not a power of Y₁ has the coefficient 0.
//!
//! Source: E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, III.1.3 and V.3.

pub use crate::methods::coefficients::*;

use crate::error::Error;
use crate::methods::rattle::Rattle;
use crate::motion::failure::Failure;
use crate::motion::method::{Method, Splitting, Stage, View};
use crate::motion::parts::BodiesOf;
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::real::Scalar;

/// Steps of a symmetric method, by default RATTLE, of sizes γᵢh: together one step of size h.
///
/// ```
/// # use rattle::composition::{Composition, KAHAN_LI_1997_ORDER_8, SUZUKI_1990_ORDER_4};
/// # use rattle::Geodesic;
/// let method = Composition::new(SUZUKI_1990_ORDER_4, 0.03);
/// let other = Composition::of(KAHAN_LI_1997_ORDER_8, Geodesic::new(4, 0.1));
/// ```
#[doc(alias = "Yoshida")]
#[doc(alias = "high order")]
#[doc(alias = "symmetric composition")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Composition<B = Rattle> {
    base: B,
    coefficients: Coefficients,
}

impl Composition {
    /// RATTLE composed with these coefficients, with step size `h` in the unit of time.
    #[doc(alias = "dt")]
    #[doc(alias = "timestep")]
    #[must_use]
    pub fn new(coefficients: Coefficients, h: f64) -> Self {
        Self::of(coefficients, Rattle::new(h))
    }
}

impl<B: Method> Composition<B> {
    /// `base` composed with these coefficients: steps of γᵢ times its step size, one after the other, make one of the
    /// same length.
    #[must_use]
    pub fn of(coefficients: Coefficients, base: B) -> Self {
        Self { base, coefficients }
    }

    /// The coefficients.
    pub fn coefficients(&self) -> Coefficients {
        self.coefficients
    }
}

impl<B: Method> Method for Composition<B> {
    type Memory<T: Scalar> = B::Memory<T>;
    type Need = B::Need;
    const HAS_STRUCTURE: bool = B::HAS_STRUCTURE;
    const FOLLOWS_ROOTS: bool = B::FOLLOWS_ROOTS;
    const CHECKS: bool = B::CHECKS;
    const DRAWS: bool = B::DRAWS;
    const STIRS: bool = B::STIRS;
    const KEEPS_FORCES: bool = B::KEEPS_FORCES;

    fn step_size(&self) -> f64 {
        self.base.step_size()
    }
    fn order(&self) -> u32 {
        self.coefficients.order.max(self.base.order())
    }
    fn name(&self) -> &'static str {
        self.coefficients.name
    }
    fn with_step(&self, h: f64) -> Self {
        Self { base: self.base.with_step(h), ..*self }
    }
    fn is_symmetric(&self) -> bool {
        self.base.is_symmetric()
    }
    fn undivided(&self) -> Option<&'static str> {
        self.base.undivided()
    }
    // Stages know of one place for flows, not of one in each step of the base.
    const SPLITTING: Splitting = match B::SPLITTING {
        Splitting::OneStage | Splitting::Stages if !B::STIRS => Splitting::Stages,
        _ => Splitting::Not,
    };
    fn stages(&self) -> Vec<Stage> {
        if const { B::STIRS } {
            return Vec::new();
        }
        let of_each = self.coefficients.gammas.iter();
        of_each.flat_map(|gamma| self.base.with_step(gamma * self.base.step_size()).stages()).collect()
    }
    fn evaluations(&self) -> Option<usize> {
        Some(self.base.evaluations()? * self.coefficients.gammas.len())
    }
    fn parameters(&self) -> Vec<f64> {
        let parameters = self.base.parameters();
        if self.stages().is_empty() { [self.coefficients.gammas, &parameters].concat() } else { parameters }
    }
    fn check(&self, equations: usize) -> Result<(), Error> {
        let Coefficients { name, gammas, .. } = self.coefficients;
        let sum: f64 = gammas.iter().sum();
        let rounding = f64::EPSILON * gammas.iter().map(|gamma| gamma.abs()).sum::<f64>();
        let adds_up = (sum - 1.0).abs() <= 8.0 * rounding; // false for NaN
        let moves = !gammas.contains(&0.0); // a step of no length moves nothing off its constraints, nor back
        if !(gammas.iter().eq(gammas.iter().rev()) && adds_up && moves) {
            return Err(Error::Coefficients { name, sum });
        }
        if !self.base.is_symmetric() {
            return Err(Error::NeedsSymmetricMethod { what: name, method: self.base.name() });
        }
        self.base.check(equations)
    }

    fn prepare<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        system: View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
    ) {
        self.base.prepare(system, bodies);
    }
    fn memory<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        system: View<'_, Self, T, Y, D>,
        bodies: &BodiesOf<Y, T, D>,
    ) -> B::Memory<T> {
        self.base.memory(system, bodies)
    }

    #[inline(always)]
    fn step<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        memory: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        for gamma in self.coefficients.gammas {
            self.base.with_step(gamma * self.base.step_size()).step(system, bodies, memory, witness)?;
        }
        Ok(())
    }
}
