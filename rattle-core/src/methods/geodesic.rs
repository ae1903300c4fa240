//! Geodesic RATTLE: kicks, each projected to be tangent, with free motion in several steps between them (Leimkuhler,
//! Matthews 2016).
//!
//! ```text
//! p ← p + h/2 f(q),  tangent
//! n times: a step of RATTLE of size h/n without force
//! p ← p + h/2 f(q′), tangent
//! ```
//!
//! Second order, symplectic, symmetric. One force per step, whatever the number of position equations: for forces that
//! cost more than constraints, on surfaces whose curvature limits the step more than the forces do. The limit h·κ·|v| <
//! 1 holds for h/n. With n → ∞ the free motion is along geodesics.
//!
//! Source: B. Leimkuhler, C. Matthews, Proc. R. Soc. A 472 (2016) 20160138.

use crate::error::Error;
use crate::methods::fixed::{Fixed, MOST_INNER, Map, check_inner_steps};
use crate::motion::failure::Failure;
use crate::motion::method::{Splitting, Stage};
use crate::motion::parts::BodiesOf;
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::real::Scalar;

/// Geodesic RATTLE with a constant step size, second order.
///
/// An observer gets multipliers that add up to the whole: λ keeps the free motion on the constraints, μ balances the
/// force.
///
/// ```
/// # use rattle::Geodesic;
/// let method = Geodesic::new(4, 0.04); // free steps of 0.01
/// ```
pub type Geodesic = Fixed<KickDriftsKick>;

/// The map of [`Geodesic`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KickDriftsKick {
    inner: u32,
}

impl Geodesic {
    /// The method with step size `h`, in the unit of time, and `inner` steps of free motion in each step, 1 to 65 536.
    ///
    /// ```
    /// use rattle::prelude::*;
    /// use rattle::surfaces::Sphere;
    ///
    /// // A step of RATTLE may have h·κ·|v| up to 1; here it is 2.
    /// let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 1.0, 0.0]);
    /// let mut simulation = Scene::on(Sphere { r: 1.0 }).simulate(start, Geodesic::new(20, 2.0))?;
    /// simulation.run(10)?;
    /// assert!(simulation.constraint_residual() < 1e-14);
    /// # Ok::<(), rattle::Error>(())
    /// ```
    #[must_use]
    pub fn new(inner: u32, h: f64) -> Self {
        Self::of(KickDriftsKick { inner }, h)
    }
}

impl Map for KickDriftsKick {
    const NAME: &'static str = "geodesic RATTLE";
    const ORDER: u32 = 2;
    const SYMMETRIC: bool = true;
    const KEEPS_FORCES: bool = true;

    const SPLITTING: Splitting = Splitting::Stages;
    const EVALUATIONS: Option<usize> = Some(1);
    fn stages(&self, h: f64) -> Vec<Stage> {
        let kick = |at_end: bool| if at_end { 0.5 * h } else { 0.0 };
        let number = self.inner.min(MOST_INNER); // more are refused before a run
        let inner = h / f64::from(number);
        let stage = |i| Stage { before: kick(i == 0), h: inner, after: kick(i + 1 == number) };
        (0..number).map(stage).collect()
    }

    fn check(&self, _: usize) -> Result<(), Error> {
        check_inner_steps(Self::NAME, self.inner)
    }

    #[inline(always)]
    fn map<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        h: f64,
        system: &Y,
        bodies: &mut BodiesOf<Y, T, D>,
        witness: &mut W,
    ) -> Result<(), Failure> {
        let inner = h / f64::from(self.inner);
        system.settle(0.5 * h, h, bodies, witness)?;
        for _ in 0..self.inner {
            system.drift(0.0, inner, bodies, witness)?;
            system.settle(0.0, inner, bodies, witness)?;
        }
        system.evaluate_forces(bodies);
        system.settle(0.5 * h, h, bodies, witness)
    }
}
