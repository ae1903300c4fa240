//! What is simulated: the constraint, the bodies and the effects.

use crate::bodies::{Count, Many, One};
use crate::effect::{Effect, Effects, Field, Force, With};
use crate::error::{Error, StartFailure};
use crate::kernel::Constraint;
use crate::real::Real;
use crate::simulation::Simulation;
use crate::start;
use crate::state::State;
use crate::stepper::{Stepper, System};
use crate::vector::dot;
use std::marker::PhantomData;

/// A constraint, the number of bodies that obey it, and the effects that act on them.
///
/// Only effects that are named are simulated; a scene without any is free motion along geodesics.
#[derive(Debug, Clone, Copy)]
pub struct Scene<C, E, N, const D: usize> {
    constraint: C,
    effects: E,
    count: N,
}

impl<C: Constraint<D, 1>, const D: usize> Scene<C, (), One, D> {
    /// One particle of unit mass on the surface g(q) = 0, and nothing else.
    pub fn on(constraint: C) -> Self {
        Self { constraint, effects: (), count: One }
    }
}

impl<C: Constraint<D, 1>, E: Effects<D>, N: Count, const D: usize> Scene<C, E, N, D> {
    /// This many particles, each on its own copy of the surface.
    pub fn particles(self, number: usize) -> Scene<C, E, Many, D> {
        Scene { constraint: self.constraint, effects: self.effects, count: Many(number) }
    }

    /// The same scene with one more effect: a potential on each particle, or one between every two (which does nothing
    /// to a particle alone).
    pub fn with<P: Effect<D, Kind>, Kind>(self, effect: P) -> Scene<C, With<E, P, Kind>, N, D> {
        let effects = With { others: self.effects, effect, kind: PhantomData };
        Scene { constraint: self.constraint, effects, count: self.count }
    }

    /// The state with every particle moved onto the surface, by Newton's method along the gradient, and
    /// every momentum made tangent.
    ///
    /// # Errors
    /// [`Error::Start`] where no point of the surface is found, or the input is not finite.
    pub fn project(&self, state: &State<D>) -> Result<State<D>, Error> {
        start::project(&self.constraint.kernel::<f64>(), state)
    }

    /// A simulation of this scene from `start` by the method `stepper`.
    ///
    /// # Errors
    /// [`Error::Start`] if a particle is off the surface, its momentum not tangent (beyond a relative
    /// 1e-10, see [`crate::START_TOLERANCE`]), or the surface singular there; see [`Self::project`].
    pub fn simulate<S: Stepper>(
        &self,
        start: State<D>,
        stepper: S,
    ) -> Result<Simulation<C, E, N, S, D>, Error> {
        stepper.check()?;
        if let Some(momenta) = start.surplus_momenta {
            return Err(Error::MomentumCount { bodies: start.len(), momenta });
        }
        if start.len() != self.count.number() {
            return Err(Error::BodyCount { scene: self.count.number(), state: start.len() });
        }
        let system = self.system::<f64>();
        for (body, state) in start.bodies.iter().enumerate() {
            let path = stepper.step_size().abs() * dot(&state.p, &state.p).sqrt();
            start::check(&system.constraint, state, path).map_err(|cause| Error::Start { body, cause })?;
        }
        let bodies = system.bodies(self.count, |i| start.bodies[i]);
        for (body, force) in bodies.force.as_ref().iter().enumerate() {
            let force = force.components();
            if !force.iter().all(|f| f.is_finite()) {
                let effect =
                    system.field.culprit(bodies.q.as_ref(), body).map_or("sum of effects", |(name, _)| name);
                let cause = StartFailure::ForceNotFinite { effect, force: force.to_vec() };
                return Err(Error::Start { body, cause });
            }
        }
        Ok(Simulation::new(system, bodies, stepper))
    }

    /// The scene made ready for the scalar `T`.
    pub fn system<T: Real>(&self) -> System<C::Kernel<T>, E::Field<T>> {
        System { constraint: self.constraint.kernel(), field: self.effects.field() }
    }
}
