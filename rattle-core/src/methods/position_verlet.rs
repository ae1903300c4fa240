//! Position Verlet with constraints: half the free motion, the whole kick, the other half.
//!
//! ```text
//! a step of RATTLE of size h/2 without force
//! p ← p + h f(q), tangent
//! a step of RATTLE of size h/2 without force
//! ```
//!
//! Without constraints it is the drift–kick–drift form of the Störmer–Verlet method. Second order, symplectic,
//! symmetric; one force per step, evaluated at its middle. The limit h·κ·|v| < 1 holds for h/2: steps may be twice as
//! long as RATTLE's.
//!
//! Source: M. Tuckerman, B. J. Berne, G. J. Martyna, J. Chem. Phys. 97 (1992) 1990; with constraints it is [geodesic
//! RATTLE](crate::methods::geodesic) with kicks and drifts exchanged.

use crate::methods::fixed::{Fixed, Map};
use crate::motion::failure::Failure;
use crate::motion::method::{Splitting, Stage};
use crate::motion::parts::BodiesOf;
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::real::Scalar;

/// Position Verlet with a constant step size, second order.
///
/// An observer gets the multipliers of the free motion alone.
///
/// ```
/// # use rattle::PositionVerlet;
/// let method = PositionVerlet::new(0.01);
/// ```
pub type PositionVerlet = Fixed<DriftKickDrift>;

/// The map of [`PositionVerlet`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DriftKickDrift;

impl Map for DriftKickDrift {
    const NAME: &'static str = "position Verlet";
    const ORDER: u32 = 2;
    const SYMMETRIC: bool = true;

    const SPLITTING: Splitting = Splitting::Stages;
    const EVALUATIONS: Option<usize> = Some(1);
    fn stages(&self, h: f64) -> Vec<Stage> {
        vec![Stage { before: 0.0, h: 0.5 * h, after: h }, Stage { before: 0.0, h: 0.5 * h, after: 0.0 }]
    }

    #[inline(always)]
    fn map<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        h: f64,
        system: &Y,
        bodies: &mut BodiesOf<Y, T, D>,
        witness: &mut W,
    ) -> Result<(), Failure> {
        system.drift(0.0, 0.5 * h, bodies, witness)?;
        system.evaluate_forces(bodies);
        system.settle(h, h, bodies, &mut ())?;
        system.drift(0.0, 0.5 * h, bodies, witness)?;
        system.settle(0.0, 0.5 * h, bodies, witness)
    }
}
