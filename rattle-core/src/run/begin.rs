//! From a scene to a simulation: the start is checked.

use crate::effect::force::Force;
use crate::effect::list::{Effects, Forces};
use crate::effect::moment::Moment;
use crate::effect::noise::Noise;
use crate::error::{EffectMistake, Error, StartFailure};
use crate::methods::able::{no_way_back, view};
use crate::motion::affected::Affected;
use crate::motion::bodies::{Body, Count};
use crate::motion::failure::Failure;
use crate::motion::hold::Hold;
use crate::motion::identity::Identity;
use crate::motion::method::{Method, check_step_size};
use crate::motion::parts::{BodiesOf, Parts};
use crate::motion::state::State;
use crate::motion::system::System;
use crate::motion::{sticking, stir};
use crate::run::simulation::Simulation;
use crate::scene::Scene;

impl<C: Hold<D>, E: Effects<D>, N: Count, const D: usize> Scene<C, E, N, D> {
    /// A simulation of this scene from `start` with `method`.
    ///
    /// # Errors
    /// [`Error::Start`] if a start is off the constraints, a momentum not tangent (beyond a relative
    /// 1e-10, see [`START_TOLERANCE`](crate::START_TOLERANCE)), or a constraint singular there; see [`Self::project`].
    #[doc(alias = "integrate")]
    #[doc(alias = "solve")]
    #[doc(alias = "run")]
    #[allow(clippy::type_complexity, reason = "the one place where the types meet")]
    pub fn simulate<S: Method>(
        &self,
        start: State<D>,
        method: S,
    ) -> Result<Simulation<C::System<E, N>, S, D>, Error> {
        self.begin(self.ready(&start, &method)?, &start, method, 0)
    }

    /// The state with random momenta, tangent to the constraints, from the Maxwell–Boltzmann distribution at the
    /// temperature kT, an energy: ½kT on average for each independent momentum. The momenta are the same for the same
    /// seed and the same [number](State::numbered) of the state.
    ///
    /// ```
    /// use rattle::prelude::*;
    /// use rattle::surfaces::Sphere;
    ///
    /// let gas = Scene::on(Sphere { r: 1.0 }).bodies(1000);
    /// let start = gas.maxwell(&State::of([[0.0, 0.0, 1.0]; 1000]), 0.5, 7)?;
    /// let simulation = gas.simulate(start, Rattle::new(0.01))?;
    /// assert!((simulation.temperature() - 0.5).abs() < 4.5 * 0.5 / 1000_f64.sqrt());
    /// # Ok::<(), rattle::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`simulate`](Self::simulate) for the positions; [`Error::Effect`] for a temperature below 0 or not finite.
    #[doc(alias = "seed")]
    #[doc(alias = "Boltzmann")]
    #[doc(alias = "random velocities")]
    #[doc(alias = "sample")]
    #[doc(alias = "temperature")]
    #[doc(alias = "thermostat")]
    pub fn maxwell(&self, state: &State<D>, temperature: f64, seed: u64) -> Result<State<D>, Error> {
        let effect = "Maxwell's distribution";
        EffectMistake::unless_positive_or_zero("temperature", temperature)
            .map_err(|mistake| Error::Effect { effect, mistake })?;
        let mut at_rest = state.clone().moving([0.0; D]);
        let system = self.system_at(&at_rest, 1.0, false)?;
        if let Err(system) = system.rates() {
            return Err(Error::Effect { effect, mistake: EffectMistake::NoMasses { system } });
        }
        let mut bodies = system.bodies(&at_rest.bodies, at_rest.time);
        let noise = Noise { trajectory: state.number.unwrap_or(0), step: u64::MAX, ..Noise::default() };
        for body in 0..at_rest.len() {
            let numbers = noise.normal(seed, body).map(|x: f64| temperature.sqrt() * x);
            bodies.p.as_mut()[body] = system.inertia().root(body, &numbers);
        }
        system.settle(0.0, 1.0, &mut bodies, &mut ()).map_err(|Failure { body, cause }| Error::Step {
            step: 0,
            time: state.time,
            body,
            cause,
        })?;
        for (number, body) in at_rest.bodies.iter_mut().enumerate() {
            *body = bodies.body(number);
        }
        Ok(at_rest)
    }

    /// Says what is wrong with a start, or gives the system that is ready to move from there.
    pub(crate) fn ready<S: Method>(&self, start: &State<D>, method: &S) -> Result<C::System<E, N>, Error> {
        check_step_size(method.step_size())?;
        let own = start.remembered.as_ref().filter(|memory| memory.method == method.identity());
        let tangent = method.momentum_delay() == 0.0 && !S::RENEWS; // which draws momenta anew
        let mut system = self.system_at(start, method.step_size(), tangent && own.is_none())?;
        if let Some(memory) = own
            && tangent
            && !memory.system.is(&Identity::of_system(&system, &bodies_at(&system, start)))
        {
            system = self.system_at(start, method.step_size(), true)?; // the memory is of another scene
        }
        method.check(system.equations())?;
        view(method, &system)?;
        if method.step_size() < 0.0 {
            no_way_back(&system)?;
        }
        let refused = |(effect, mistake)| Error::Effect { effect, mistake };
        if const { <E::Forces<f64> as Forces<f64, D>>::LOOKS } {
            system.fits(&mut bodies_at(&system, start)).map_err(refused)?;
        }
        self.check_effects(&start.bodies, start.time)?;
        if const { <C::System<E, N> as Parts<f64, D>>::MOMENTA < D } {
            let checked = system.check_flows(method.step_size(), &bodies_at(&system, start));
            checked.map_err(refused)?;
        }
        Ok(system)
    }

    /// The system at a start, for steps of h; `tangent`: whether momenta have to be tangent.
    fn system_at(&self, start: &State<D>, h: f64, tangent: bool) -> Result<C::System<E, N>, Error> {
        if !start.time.is_finite() {
            return Err(Error::Time(start.time));
        }
        self.fits(start)?;
        self.constraint.system(&self.effects, self.count, start, h, tangent)
    }

    /// The simulation from a start of a system that is ready to move from there.
    #[allow(clippy::type_complexity, reason = "as above")]
    pub(crate) fn begin<S: Method>(
        &self,
        system: C::System<E, N>,
        start: &State<D>,
        method: S,
        trajectory: u64,
    ) -> Result<Simulation<C::System<E, N>, S, D>, Error> {
        const { assert!(counts_all::<C::System<E, N>, E, D>(), "a system passes over effects of its scene") };
        let mut bodies = bodies_at(&system, start);
        method.prepare(view(&method, &system)?, &mut bodies);
        Simulation::new(system, bodies, start, method, trajectory)
    }

    /// Whether forces are finite, and energies are numbers: a potential may have a force where it has no value, and the
    /// energy of such a run would be NaN in silence.
    fn check_effects(&self, bodies: &[Body<f64, D>], time: f64) -> Result<(), Error> {
        if const { E::Forces::<f64>::EFFECTS == 0 } {
            return Ok(());
        }
        let (positions, effects) = (Body::positions(bodies), self.effects.forces::<f64>());
        let at = Moment { time, positions: &positions };
        let mut forces: Vec<<E::Forces<f64> as Forces<f64, D>>::Force> = vec![Force::zero(); bodies.len()];
        effects.evaluate(at, &mut effects.room(bodies.len()), &mut forces);
        for (body, force) in forces.iter().enumerate() {
            let force = force.components();
            if !is_finite(&force) {
                let effect = effects.culprit(at, body).map_or("sum of effects", |(name, _)| name);
                let cause = StartFailure::ForceNotFinite { effect, force: force.to_vec() };
                return Err(Error::Start { body, cause });
            }
        }
        match effects.without_energy(at) {
            Some(effect) => Err(Error::Effect { effect, mistake: EffectMistake::NoEnergy }),
            None => Ok(()),
        }
    }
}

fn is_finite(numbers: &[f64]) -> bool {
    numbers.iter().all(|x| x.is_finite())
}

/// The bodies where a simulation starts, with room for flows.
pub(in crate::run) fn bodies_at<Y: System<f64, D>, const D: usize>(
    system: &Y,
    start: &State<D>,
) -> BodiesOf<Y, f64, D> {
    let mut bodies = system.bodies(&start.bodies, start.time);
    if const { Y::FLOWS > 0 } {
        bodies.make_room(stir::ROOM);
        if stir::feels(system) {
            let lent = bodies.lend(sticking::ROOM * start.len());
            bodies.take_back(lent);
        }
    }
    bodies
}

/// Whether a system counts all effects of its scene, as what they are: one that it leaves out would be passed over in
/// silence.
const fn counts_all<Y: System<f64, D>, E: Effects<D>, const D: usize>() -> bool {
    Y::EFFECTS == E::Forces::<f64>::EFFECTS
        && Y::FLOWS == E::Forces::<f64>::FLOWS
        && Y::REMEMBERS == E::Forces::<f64>::REMEMBERS
        && Y::PUSHES == E::Forces::<f64>::PUSHES
}
