//! The symplectic Euler method with constraints: a whole kick, then the drift.
//!
//! ```text
//! p½ = p  + h (f(q) + G(q)ᵀλ)       λ such that g(q′) = 0
//! q′ = q  + h M⁻¹ p½
//! p′ = p½ + h G(q′)ᵀμ               μ such that G(q′) M⁻¹ p′ = 0
//! ```
//!
//! Symplectic, first order, not symmetric. For comparison only: RATTLE costs the same and is of second order.
//!
//! Source: E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, VII.1.3.

use crate::methods::fixed::{Fixed, Map};
use crate::motion::failure::Failure;
use crate::motion::method::{Splitting, Stage};
use crate::motion::parts::BodiesOf;
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::real::Scalar;

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
pub type SymplecticEuler = Fixed<KickDrift>;

/// The map of [`SymplecticEuler`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct KickDrift;

impl Map for KickDrift {
    const NAME: &'static str = "symplectic Euler";
    const ORDER: u32 = 1;
    const SYMMETRIC: bool = false;

    const SPLITTING: Splitting = Splitting::OneStage;
    fn stages(&self, h: f64) -> Vec<Stage> {
        vec![Stage { before: h, h, after: 0.0 }]
    }

    #[inline(always)]
    fn map<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        h: f64,
        system: &Y,
        bodies: &mut BodiesOf<Y, T, D>,
        witness: &mut W,
    ) -> Result<(), Failure> {
        system.drift(h, h, bodies, witness)?;
        system.evaluate_forces(bodies);
        system.settle(0.0, h, bodies, witness)
    }
}
