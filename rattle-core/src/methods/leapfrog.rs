//! The staggered leapfrog: positions at whole steps, momenta at half steps.
//!
//! ```text
//! q(t + h)    = q(t)      + h M⁻¹ p(t + h/2)
//! p(t + 3h/2) = p(t + h/2) − h ∇U(q(t + h))
//! ```
//!
//! Symplectic, second order on its two grids, one force per step. For free bodies only: momenta half a step away from
//! the positions cannot be tangent to a constraint there; [`Shake`](crate::methods::shake::Shake) is the leapfrog with constraints.

use crate::error::Error;
use crate::motion::bodies::Bodies;
use crate::motion::failure::Failure;
use crate::motion::method::{Method, check_step_size};
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::real::Real;

/// The leapfrog with a constant step size. A start's momenta are taken as those of half a step later.
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
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leapfrog {
    h: f64,
}

impl Leapfrog {
    /// The leapfrog with step size `h`, in the unit of time.
    #[must_use]
    pub fn new(h: f64) -> Self {
        Self { h }
    }
}

impl Method for Leapfrog {
    type Memory<T: Real> = [T; 0];

    fn step_size(&self) -> f64 {
        self.h
    }
    fn order(&self) -> u32 {
        2
    }
    fn name(&self) -> &'static str {
        "leapfrog"
    }
    fn with_step(&self, h: f64) -> Self {
        Self::new(h)
    }
    fn is_symmetric(&self) -> bool {
        false // positions and momenta would have to change places
    }
    fn momentum_delay(&self) -> f64 {
        0.5 * self.h
    }
    fn check(&self, equations: usize) -> Result<(), Error> {
        if equations > 0 {
            return Err(Error::NeedsFreeBodies { method: self.name(), equations });
        }
        check_step_size(self.h)
    }

    #[inline(always)]
    fn step<T: Real, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: &Y,
        bodies: &mut Bodies<Y::Count, T, Y::Kept, D>,
        _: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        system.drift(0.0, self.h, bodies, witness)?;
        system.evaluate_forces(bodies);
        system.settle(self.h, self.h, bodies, witness)
    }
}
