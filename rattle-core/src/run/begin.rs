//! How a scene gets under way: a start is checked, and a simulation made.

use crate::effect::force::Force;
use crate::effect::list::{Effects, Field};
use crate::error::{Error, NetworkMistake, StartFailure};
use crate::motion::bodies::{Body, Count};
use crate::motion::hold::Hold;
use crate::motion::method::{Method, check_step_size};
use crate::motion::need::Need;
use crate::motion::state::State;
use crate::motion::system::System;
use crate::run::simulation::Simulation;
use crate::scene::Scene;

impl<C: Hold<D>, E: Effects<D>, N: Count, const D: usize> Scene<C, E, N, D> {
    /// A simulation of this scene from `start` by the method `method`.
    ///
    /// # Errors
    /// [`Error::Start`] if a start is off the constraints, a momentum not tangent (beyond a relative
    /// 1e-10, see [`crate::START_TOLERANCE`]), or a constraint singular there; see [`Self::project`].
    #[allow(clippy::type_complexity, reason = "the one place where the types meet")]
    pub fn simulate<S: Method>(
        &self,
        start: State<D>,
        method: S,
    ) -> Result<Simulation<C::System<E, N>, S, D>, Error> {
        Ok(self.begin(self.ready(&start, &method)?, &start, method))
    }

    /// Says what is wrong with a start, or gives the system that is ready to move from there.
    pub(crate) fn ready<S: Method>(&self, start: &State<D>, method: &S) -> Result<C::System<E, N>, Error> {
        check_step_size(method.step_size())?;
        if !start.time.is_finite() {
            return Err(Error::Time(start.time));
        }
        if let Some(momenta) = start.surplus_momenta {
            return Err(Error::MomentumCount { bodies: start.len(), momenta });
        }
        if start.len() != self.count.number() {
            return Err(Error::BodyCount { scene: self.count.number(), state: start.len() });
        }
        if let Some((what, member, body)) = self.effects.stray(start.len()) {
            let bodies = start.len();
            return Err(Error::Network(NetworkMistake::NoSuchBody { what, member, body, bodies }));
        }
        let system = self.constraint.system(&self.effects, self.count, start, method)?;
        method.check(system.equations())?;
        if let Some(system) = system.refuses(method.need()) {
            return Err(Error::CannotMove { method: method.name(), system });
        }
        self.check_forces(&start.bodies)?;
        Ok(system)
    }

    /// The simulation from a start of a system that is ready to move from there.
    pub(crate) fn begin<S: Method>(
        &self,
        system: C::System<E, N>,
        start: &State<D>,
        method: S,
    ) -> Simulation<C::System<E, N>, S, D> {
        let mut bodies = system.bodies(|i| start.bodies[i], start.time);
        match method.need() {
            Need::Series => system.reserve_series(&mut bodies, method.stages()),
            _ => system.reserve(&mut bodies, method.stages()),
        }
        bodies.room = vec![[0.0; D]; method.room() * self.count.number()];
        let (clock, remembered) = ((start.time, start.time_low), start.remembered.as_ref());
        Simulation::new(system, self.count, bodies, clock, remembered, method)
    }

    fn check_forces(&self, bodies: &[Body<f64, D>]) -> Result<(), Error> {
        let (field, mut positions) = (self.effects.field::<f64>(), self.count.each([0.0; D]));
        positions.as_mut().iter_mut().zip(bodies).for_each(|(position, body)| *position = body.q);
        let mut forces = self.count.each(Force::zero());
        field.evaluate(positions.as_ref(), forces.as_mut());
        for (body, force) in forces.as_ref().iter().enumerate() {
            let force = force.components();
            if !force.iter().all(|f| f.is_finite()) {
                let effect =
                    field.culprit(positions.as_ref(), body).map_or("sum of effects", |(name, _)| name);
                let cause = StartFailure::ForceNotFinite { effect, force: force.to_vec() };
                return Err(Error::Start { body, cause });
            }
        }
        Ok(())
    }
}
