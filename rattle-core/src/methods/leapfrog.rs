//! The staggered leapfrog: positions at whole steps, momenta at half steps.
//!
//! ```text
//! q(t + h)    = q(t)      + h M⁻¹ p(t + h/2)
//! p(t + 3h/2) = p(t + h/2) − h ∇U(q(t + h))
//! ```
//!
//! Symplectic, second order on its two time grids, one force per step. For free bodies only: momenta half a step away
//! from the positions cannot be tangent to a constraint; [`Shake`](crate::methods::shake::Shake) is the leapfrog with
//! constraints.

use crate::error::Error;
use crate::methods::fixed::{Fixed, Map};
use crate::motion::failure::Failure;
use crate::motion::parts::BodiesOf;
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::real::Scalar;

/// The leapfrog with a constant step size. The momenta of a start are those half a step after its positions;
/// [`Scene::staggered`](crate::scene::Scene::staggered) makes them. A state goes on with the step size that it was
/// computed with: its momenta are half of that step ahead.
///
/// ```
/// use rattle::{Leapfrog, Scene, State};
///
/// let start = State::at([0.0]).moving([1.0]);
/// let mut simulation = Scene::point().simulate(start, Leapfrog::new(0.5))?;
/// simulation.run(4)?;
/// assert_eq!((simulation.time(), simulation.momentum_time()), (2.0, 2.25));
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "Verlet")]
#[doc(alias = "staggered")]
pub type Leapfrog = Fixed<DriftKick>;

/// The map of [`Leapfrog`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DriftKick;

impl Map for DriftKick {
    const NAME: &'static str = "leapfrog";
    const ORDER: u32 = 2;
    const SYMMETRIC: bool = false; // positions and momenta would have to change places
    const DELAY: f64 = 0.5;
    const EVALUATIONS: Option<usize> = Some(1);

    fn check(&self, equations: usize) -> Result<(), Error> {
        if equations > 0 {
            return Err(Error::NeedsFreeBodies { method: Self::NAME, equations });
        }
        Ok(())
    }

    #[inline(always)]
    fn map<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        h: f64,
        system: &Y,
        bodies: &mut BodiesOf<Y, T, D>,
        witness: &mut W,
    ) -> Result<(), Failure> {
        system.drift(0.0, h, bodies, witness)?;
        system.evaluate_forces(bodies);
        system.settle(h, h, bodies, witness)
    }
}
