//! Reversible variable steps: short where momenta change fast, and yet without the drift that choosing each step from the
//! present state brings.
//!
//! ```text
//! z½ = Φ_{ε/2ρ}(z),   ρ′ = R(z½)²/ρ,   z′ = Φ_{ε/2ρ′}(z½)        R = √(1 + τ² |ṗ|²/(|p|² + p₀²))
//! ```
//!
//! Read backwards, with −ε, this is the same map of (z, ρ): symmetric if Φ is, so that the energy of reversible motion does
//! not drift, at the price of one more number to remember. R is looked at in the middle, where both halves see the same
//! state, and no derivative of it is needed; in the product form ρ is never negative. ε is the longest step, τ the time in
//! which momenta may turn without shortening it; p₀² is |p|² + τ²|ṗ|² at the start, so that rest is no trouble.
//!
//! Source: W. Huang, B. Leimkuhler, SIAM J. Sci. Comput. 18 (1997) 239, for the recursion; E. Barth, B. Leimkuhler, S. Reich,
//! SIAM J. Sci. Comput. 21 (1999) 1027, with constraints.

use crate::bodies::Bodies;
use crate::error::Error;
use crate::real::Real;
use crate::stepper::{Failure, Stepper, Witness};
use crate::system::System;
use crate::vector::dot;

/// Two steps of a symmetric method, each as long as the momenta's change allows, so chosen that time can run backwards.
///
/// Not symplectic. Lanes go with the steps of the fastest one.
///
/// ```
/// # use rattle_core::{rattle::Rattle, variable::Variable};
/// let method = Variable::of(Rattle::new(0.05), 0.3); // steps of 0.025 and less; shorter where momenta turn within 0.3
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variable<B> {
    base: B,
    tau: f64,
}

impl<B: Stepper> Variable<B> {
    /// Steps of `base`, whose own step size is the longest that two of them make together; shorter where momenta change by
    /// their own size within the time `tau`.
    #[must_use]
    pub fn of(base: B, tau: f64) -> Self {
        Self { base, tau }
    }

    /// |ṗ|² and |p|² of all bodies, in the lane where their ratio is the largest.
    fn change<T: Real, Y: System<T, D>, const D: usize>(
        system: &Y,
        bodies: &mut Bodies<Y::Count, T, Y::Kept, D>,
        room: &mut [[T; D]],
    ) -> (f64, f64) {
        system.evaluate_forces(bodies);
        let _ = system.rates(bodies, room, &mut ());
        let zero = T::from_f64(0.0);
        let square = |x: &[[T; D]]| x.iter().fold(zero, |sum, x| sum + dot(x, x));
        let (change, size) = (square(room), square(bodies.p.as_ref()));
        let pairs = change.lanes().zip(size.lanes());
        pairs.fold((0.0, 1.0), |a, b| if a.0 * b.1 >= b.0 * a.1 { a } else { b })
    }
}

impl<B: Stepper> Stepper for Variable<B> {
    type Memory<T: Real> = Vec<T>;

    fn step_size(&self) -> f64 {
        self.base.step_size()
    }
    fn order(&self) -> u32 {
        self.base.order()
    }
    fn name(&self) -> &'static str {
        "reversible variable steps"
    }
    fn with_step(&self, h: f64) -> Self {
        Self { base: self.base.with_step(h), tau: self.tau }
    }
    fn is_symmetric(&self) -> bool {
        false // only together with what it remembers
    }
    fn stages(&self) -> usize {
        self.base.stages()
    }
    fn room(&self) -> usize {
        self.base.room().max(1)
    }

    fn check(&self, equations: usize) -> Result<(), Error> {
        if !self.base.is_symmetric() {
            let composition = self.name();
            return Err(Error::NeedsSymmetricMethod { composition, method: self.base.name() });
        }
        if !(self.tau.is_finite() && self.tau > 0.0) {
            return Err(Error::ChangeTime(self.tau));
        }
        self.base.check(equations)
    }

    fn memory<T: Real, Y: System<T, D>, const D: usize>(
        &self,
        system: &Y,
        bodies: &Bodies<Y::Count, T, Y::Kept, D>,
    ) -> Vec<T> {
        let mut room = vec![[T::from_f64(0.0); D]; bodies.q.as_ref().len()];
        let (change, size) = Self::change(system, &mut bodies.clone(), &mut room);
        let turn = self.tau * self.tau * change;
        let density = (1.0 + turn / (2.0 * size + turn).max(f64::MIN_POSITIVE)).sqrt();
        // The last step, ρ, p₀².
        [0.0, density, size + turn].map(T::from_f64).into()
    }

    fn time_taken<T: Real>(&self, memory: &[T]) -> Option<T> {
        Some(memory[0])
    }

    #[inline(always)]
    fn step<T: Real, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: &Y,
        bodies: &mut Bodies<Y::Count, T, Y::Kept, D>,
        memory: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        let first = |x: T| x.lanes().next().unwrap_or(f64::NAN); // the same in all lanes
        let (density, scale) = (first(memory[1]), first(memory[2]));
        let half = 0.5 * self.step_size();
        self.base.with_step(half / density).step(system, bodies, &mut [], witness)?;

        let n = bodies.q.as_ref().len();
        let (change, size) =
            bodies.with_room(self.room(), |bodies, room| Self::change(system, bodies, &mut room[..n]));
        let wanted = 1.0 + self.tau * self.tau * change / (size + scale).max(f64::MIN_POSITIVE);
        let next = wanted / density;

        self.base.with_step(half / next).step(system, bodies, &mut [], witness)?;
        memory[0] = T::from_f64(half / density + half / next);
        memory[1] = T::from_f64(next);
        Ok(())
    }
}
