//! What is simulated: the constraint, the bodies and the effects.

use crate::bodies::{Body, Count, Many, One};
use crate::effect::{Effect, Effects, Field, Force, With};
use crate::error::{Error, StartFailure};
use crate::kernel::Constraint;
use crate::real::Real;
use crate::simulation::Simulation;
use crate::start;
use crate::state::State;
use crate::stepper::Stepper;
use crate::surface::OnSurface;
use crate::system::System;
use crate::vector::dot;
use std::marker::PhantomData;

/// Constraints, the number of bodies that obey them, and the effects that act on them.
///
/// Only effects that are named are simulated; a scene without any is free motion along geodesics.
#[derive(Debug, Clone, Copy)]
pub struct Scene<C, E, N, const D: usize> {
    constraint: C,
    effects: E,
    count: N,
}

/// What holds the bodies of a scene: a surface for each, or a [`Network`](crate::network::Network) of constraints.
pub trait Hold<const D: usize> {
    /// Bodies held in this way, in a field of force.
    type System<E: Effects<D>, N: Count>: System<f64, D, Count = N>;

    /// The system, ready to move.
    ///
    /// # Errors
    /// Where the constraints make no sense for so many bodies.
    fn system<E: Effects<D>, N: Count>(&self, effects: &E, count: N) -> Result<Self::System<E, N>, Error>;

    /// Whether a motion may start here with a step of this size.
    ///
    /// # Errors
    /// Says which body cannot start and why.
    fn check(&self, start: &State<D>, h: f64) -> Result<(), Error>;

    /// The state moved onto the constraints.
    ///
    /// # Errors
    /// Where none is found.
    fn project(&self, state: &State<D>) -> Result<State<D>, Error>;
}

impl<C: Constraint<D, 1>, const D: usize> Hold<D> for C {
    type System<E: Effects<D>, N: Count> = OnSurface<C::Kernel<f64>, E::Field<f64>, N>;

    fn system<E: Effects<D>, N: Count>(&self, effects: &E, count: N) -> Result<Self::System<E, N>, Error> {
        Ok(OnSurface { constraint: self.kernel(), field: effects.field(), count })
    }

    fn check(&self, start: &State<D>, h: f64) -> Result<(), Error> {
        let constraint = self.kernel::<f64>();
        for (body, state) in start.bodies.iter().enumerate() {
            let path = h.abs() * dot(&state.p, &state.p).sqrt();
            start::check(&constraint, state, path).map_err(|cause| Error::Start { body, cause })?;
        }
        Ok(())
    }

    fn project(&self, state: &State<D>) -> Result<State<D>, Error> {
        start::project(&self.kernel::<f64>(), state)
    }
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

    /// The scene made ready for the scalar `T`: lanes, to run several trajectories side by side.
    pub fn lanes<T: Real>(&self) -> OnSurface<C::Kernel<T>, E::Field<T>, N> {
        OnSurface { constraint: self.constraint.kernel(), field: self.effects.field(), count: self.count }
    }
}

impl<C: Hold<D>, E: Effects<D>, N: Count, const D: usize> Scene<C, E, N, D> {
    /// The same scene with one more effect: a potential on each particle, or one between every two (which does nothing
    /// to a particle alone).
    pub fn with<P: Effect<D, Kind>, Kind>(self, effect: P) -> Scene<C, With<E, P, Kind>, N, D> {
        let effects = With { others: self.effects, effect, kind: PhantomData };
        Scene { constraint: self.constraint, effects, count: self.count }
    }

    /// The state with every position moved onto the constraints, by Newton's method along their gradients, and
    /// every momentum made tangent.
    ///
    /// # Errors
    /// [`Error::Start`] where no such position is found, or the input is not finite.
    pub fn project(&self, state: &State<D>) -> Result<State<D>, Error> {
        self.constraint.project(state)
    }

    /// A simulation of this scene from `start` by the method `stepper`.
    ///
    /// # Errors
    /// [`Error::Start`] if a start is off the constraints, a momentum not tangent (beyond a relative
    /// 1e-10, see [`crate::START_TOLERANCE`]), or a constraint singular there; see [`Self::project`].
    #[allow(clippy::type_complexity, reason = "the one place where the types meet")]
    pub fn simulate<S: Stepper>(
        &self,
        start: State<D>,
        stepper: S,
    ) -> Result<Simulation<C::System<E, N>, S, D>, Error> {
        stepper.check()?;
        if let Some(momenta) = start.surplus_momenta {
            return Err(Error::MomentumCount { bodies: start.len(), momenta });
        }
        if start.len() != self.count.number() {
            return Err(Error::BodyCount { scene: self.count.number(), state: start.len() });
        }
        let system = self.constraint.system(&self.effects, self.count)?;
        self.constraint.check(&start, stepper.step_size())?;
        self.check_forces(&start.bodies)?;
        let bodies = system.bodies(|i| start.bodies[i], start.time);
        Ok(Simulation::new(system, self.count, bodies, stepper))
    }

    fn check_forces(&self, bodies: &[Body<f64, D>]) -> Result<(), Error> {
        let field = self.effects.field::<f64>();
        let positions: Vec<_> = bodies.iter().map(|body| body.q).collect();
        let mut forces = vec![Force::zero(); bodies.len()];
        field.evaluate(&positions, &mut forces);
        for (body, force) in forces.iter().enumerate() {
            let force = force.components();
            if !force.iter().all(|f| f.is_finite()) {
                let effect = field.culprit(&positions, body).map_or("sum of effects", |(name, _)| name);
                let cause = StartFailure::ForceNotFinite { effect, force: force.to_vec() };
                return Err(Error::Start { body, cause });
            }
        }
        Ok(())
    }
}
