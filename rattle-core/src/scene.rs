//! What is simulated: the constraint, the bodies and the effects.

use crate::bodies::{Body, Count, Many, One};
use crate::effect::{Effect, Effects, Field, Force, With};
use crate::ensemble::group::Group;
use crate::ensemble::{Double, Ensemble, InLanes, InstructionSet, Precision};
use crate::error::{Error, NetworkMistake, StartFailure};
use crate::kernel::{Constraint, Hamiltonian, PhaseConstraint};
use crate::lanes::Fused;
use crate::network::{LinearAlgebra, Links, Mass, Masses, Network};
use crate::phase::PhaseSpace;
use crate::real::Real;
use crate::rigid::Rigid;
use crate::simulation::Simulation;
use crate::start;
use crate::state::State;
use crate::stepper::{Need, Stepper, check_step_size};
use crate::surface::{OnSurface, OneByOne};
use crate::system::System;
use crate::vector::{add_scaled, dot, two_sum};
use nalgebra::SVector;
use std::marker::PhantomData;

/// Constraints, the number of bodies that obey them, and the effects that act on them.
///
/// Only effects that are named are simulated; a scene without any is free motion along geodesics.
///
/// A function that takes a scene of one particle in space:
///
/// ```
/// use rattle_core::{bodies::One, effect::Effects, scene::{Hold, Scene}};
/// fn bills<C: Hold<3>, E: Effects<3>>(scene: &Scene<C, E, One, 3>) { /* scene.simulate(…) */ }
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Scene<C, E, N, const D: usize> {
    pub(crate) constraint: C,
    pub(crate) effects: E,
    count: N,
}

/// Coordinates of a body beyond which blocks of bodies in lanes would no longer fit the nearest cache, or the stack.
const MOST_IN_LANES: usize = 16;

/// What holds the bodies of a scene: a surface for each, or a [`Network`] of constraints.
pub trait Hold<const D: usize>: Sized {
    /// Bodies held in this way, in a field of force.
    type System<E: Effects<D>, N: Count>: System<f64, D, Count = N>;

    /// The system, ready to move from this start by this method.
    ///
    /// # Errors
    /// Where the constraints make no sense for so many bodies; says which body cannot start there and why.
    fn system<E: Effects<D>, N: Count>(
        &self,
        effects: &E,
        count: N,
        start: &State<D>,
        method: &impl Stepper,
    ) -> Result<Self::System<E, N>, Error>;

    /// Whether this body cannot move at all.
    fn pinned(&self, _body: usize) -> bool {
        false
    }

    /// ṗ of a body at q under a force, before constraints.
    fn pull(&self, _q: &[f64; D], force: &[f64; D]) -> [f64; D] {
        *force
    }

    /// The same for so many particles, each under its own copy.
    #[must_use]
    fn particles(self, number: usize) -> Self;

    /// The state moved onto the constraints.
    ///
    /// # Errors
    /// Where none is found.
    fn project(&self, state: &State<D>) -> Result<State<D>, Error>;

    /// A group of trajectories of one body, which can start so, in lanes; none where there are no lanes for them.
    #[doc(hidden)]
    fn in_lanes<P: Precision, E: Effects<D>>(
        _scene: (&Self, &E),
        _starts: &[State<D>],
        _lanes: &InLanes,
    ) -> Option<Box<dyn Group<D>>> {
        None
    }

    /// The same, each trajectory in a scene of its own.
    #[doc(hidden)]
    fn each_in_lanes<P: Precision, E: Effects<D> + 'static>(
        _scenes: &[(&Self, &E)],
        _starts: &[State<D>],
        _lanes: &InLanes,
    ) -> Option<Box<dyn Group<D>>>
    where
        Self: 'static,
    {
        None
    }
}

/// What links, pins and masses can be added to.
pub trait Tie<const D: usize>: Hold<D> {
    /// The same as a network of so many bodies.
    fn network(self, bodies: usize) -> Network<D>;
}

impl<C: Constraint<D, 1>, const D: usize> Tie<D> for C {
    fn network(self, bodies: usize) -> Network<D> {
        Network::default().with(Links::<_, D, 1, 1, D>::new(vec![self], (0..bodies).map(|i| [i]).collect()))
    }
}

impl<C: Constraint<D, 1>, const D: usize> Hold<D> for C {
    type System<E: Effects<D>, N: Count> = OnSurface<C::Kernel<f64>, E::Field<f64>, N, C::Kernel<Fused<f64>>>;

    fn system<E: Effects<D>, N: Count>(
        &self,
        effects: &E,
        count: N,
        start: &State<D>,
        method: &impl Stepper,
    ) -> Result<Self::System<E, N>, Error> {
        let constraint = self.kernel::<f64>();
        for (body, state) in start.bodies.iter().enumerate() {
            let path = method.step_size().abs() * dot(&state.p, &state.p).sqrt();
            start::check(&constraint, state, path, start.must_be_tangent(method))
                .map_err(|cause| Error::Start { body, cause })?;
        }
        Ok(OnSurface::new(constraint, self.kernel(), effects.field(), count))
    }

    fn particles(self, _: usize) -> Self {
        self
    }

    fn project(&self, state: &State<D>) -> Result<State<D>, Error> {
        start::project(&self.kernel::<f64>(), state)
    }

    fn in_lanes<P: Precision, E: Effects<D>>(
        scene: (&Self, &E),
        starts: &[State<D>],
        lanes: &InLanes,
    ) -> Option<Box<dyn Group<D>>> {
        (D <= MOST_IN_LANES).then(|| P::same(scene, starts, lanes))
    }

    fn each_in_lanes<P: Precision, E: Effects<D> + 'static>(
        scenes: &[(&Self, &E)],
        starts: &[State<D>],
        lanes: &InLanes,
    ) -> Option<Box<dyn Group<D>>>
    where
        Self: 'static,
    {
        (D <= MOST_IN_LANES).then(|| P::each(scenes, starts, lanes))
    }
}

/// What a scene can begin with: one constraint, on one particle. A single equation makes a surface; several a
/// [`Network`]. Up to 64 are listed; for more, `Scene::point().link(constraint, [[0]])`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no constraint",
    label = "a scene begins with what `constraint!` makes, of up to 64 equations",
    note = "a potential acts in a scene: `Scene::on(constraint).with(potential)`, or `Scene::point().with(potential)` on a free body",
    note = "constraints between bodies are links: `Scene::points(n).link(constraint, members)`"
)]
pub trait Begin<const D: usize, const M: usize> {
    /// What holds the particle.
    type Hold: Hold<D>;
    /// The constraint as what holds it.
    fn begin(self) -> Self::Hold;
}

impl<C: Constraint<D, 1>, const D: usize> Begin<D, 1> for C {
    type Hold = C;
    fn begin(self) -> C {
        self
    }
}

macro_rules! begin_with_several {
    ($($equations:literal)*) => {$(
        impl<C: Constraint<D, $equations>, const D: usize> Begin<D, $equations> for C {
            type Hold = Network<D>;
            fn begin(self) -> Network<D> {
                Network::default().with(Links::<_, D, $equations, 1, D>::new(vec![self], vec![[0]]))
            }
        }
    )*};
}
begin_with_several!(2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32 33 34 35 36 37
    38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64);

impl Scene<(), (), One, 0> {
    /// One particle of unit mass on the surface g(q) = 0, or under several equations at once, and nothing else.
    pub fn on<C: Begin<D, M>, const D: usize, const M: usize>(constraint: C) -> Scene<C::Hold, (), One, D> {
        Scene { constraint: constraint.begin(), effects: (), count: One }
    }

    /// One body in phase space, under g(q, p) = 0 with the energy H(q, p): moved by [`Rattle`](crate::rattle::Rattle), which
    /// then is geometric RATTLE, or a composition of it. See [`phase`](crate::phase) for what g must be.
    ///
    /// ```text
    /// phase_constraint! { struct Hopf {}        |q: [f64; 2], p: [f64; 2]| dot(q, q) + dot(p, p) - 1 }
    /// hamiltonian!      { struct Falling { g }  |q: [f64; 2], p: [f64; 2]| dot(p, p) / 2 + g * q[1] }
    ///
    /// let scene = Scene::in_phase_space(Hopf {}, Falling { g: 0.3 });
    /// let start = scene.project(&State::at([-0.55, -0.83]))?;         // onto g = 0, then along the fibre to {g, H} = 0
    /// let mut simulation = scene.simulate(start, Rattle::new(0.05))?;
    /// ```
    pub fn in_phase_space<G, H, const D: usize, const M: usize>(
        constraint: G,
        hamiltonian: H,
    ) -> Scene<PhaseSpace<G, H, M>, (), One, D>
    where
        G: PhaseConstraint<D, M>,
        H: Hamiltonian<D>,
    {
        Scene { constraint: PhaseSpace { constraint, hamiltonian }, effects: (), count: One }
    }

    /// One rigid body that turns about its centre of mass.
    #[must_use]
    pub fn rigid(body: Rigid) -> Scene<Rigid, (), One, 9> {
        Scene { constraint: body, effects: (), count: One }
    }

    /// One free body of unit mass, to be linked or left free.
    #[must_use]
    pub fn point<const D: usize>() -> Scene<Network<D>, (), One, D> {
        Scene { constraint: Network::default(), effects: (), count: One }
    }

    /// So many free bodies of unit mass, to be linked or left free.
    ///
    /// ```
    /// # use rattle_core::{scene::Scene, state::State, rattle::Rattle};
    /// let free = Scene::points(2);
    /// let mut simulation = free.simulate(State::of([[0.0], [1.0]]).moving([2.0]), Rattle::new(0.5))?;
    /// simulation.run(2)?;
    /// assert_eq!(simulation.positions().map(|q| q.x).collect::<Vec<_>>(), [2.0, 3.0]);
    /// # Ok::<(), rattle_core::error::Error>(())
    /// ```
    #[must_use]
    pub fn points<const D: usize>(number: usize) -> Scene<Network<D>, (), Many, D> {
        Scene { constraint: Network::default(), effects: (), count: Many(number) }
    }
}

impl<C: Hold<D>, E: Effects<D>, N: Count, const D: usize> Scene<C, E, N, D> {
    /// This many particles, each under its own copy of the constraint. From eight on they go several at a time where the
    /// processor fuses multiply-add: as each would go alone but for rounding, with [functions](crate::lanes) of their own, and in
    /// half to a fourth of the time.
    pub fn particles(self, number: usize) -> Scene<C, E, Many, D> {
        Scene { constraint: self.constraint.particles(number), effects: self.effects, count: Many(number) }
    }
}

impl<C: Tie<D>, E: Effects<D>, N: Count, const D: usize> Scene<C, E, N, D> {
    /// The same scene with these links: `constraint` holds between the bodies of each member, with their coordinates in
    /// turn as its variables.
    ///
    /// ```text
    /// Scene::points(1001).link(Rod { length: 1e-3 }, (0..1000).map(|i| [i, i + 1])).pin(0, [0.0; 3])
    /// ```
    pub fn link<G: Constraint<K, M>, const K: usize, const M: usize, const A: usize>(
        self,
        constraint: G,
        members: impl IntoIterator<Item = [usize; A]>,
    ) -> Scene<Network<D>, E, N, D> {
        const {
            assert!(
                K == A * D,
                "a constraint on A bodies has A times as many variables as a body coordinates"
            )
        };
        let members = members.into_iter().collect();
        self.network(|network| network.with(Links::<_, K, M, A, D>::new(vec![constraint], members)))
    }

    /// The same scene with these links, each with parameters of its own.
    pub fn link_each<G: Constraint<K, M>, const K: usize, const M: usize, const A: usize>(
        self,
        links: impl IntoIterator<Item = (G, [usize; A])>,
    ) -> Scene<Network<D>, E, N, D> {
        const {
            assert!(
                K == A * D,
                "a constraint on A bodies has A times as many variables as a body coordinates"
            )
        };
        let (constraints, members) = links.into_iter().unzip();
        self.network(|network| network.with(Links::<_, K, M, A, D>::new(constraints, members)))
    }

    /// The same scene with links that change with time: the last variable of `constraint` is the time t.
    ///
    /// Such a constraint does work, see [`Simulation::work`]; momenta must satisfy G v = −∂g/∂t.
    pub fn link_moving<G: Constraint<K, M>, const K: usize, const M: usize, const A: usize>(
        self,
        constraint: G,
        members: impl IntoIterator<Item = [usize; A]>,
    ) -> Scene<Network<D>, E, N, D> {
        const {
            assert!(
                A > 0 && K == A * D + 1,
                "a moving constraint has the variables of its bodies, then the time"
            )
        };
        let members = members.into_iter().collect();
        self.network(|network| network.with(Links::<_, K, M, A, D>::new(vec![constraint], members)))
    }

    /// The same scene with links whose multipliers act only on the coordinates that are `true`: the others move as if
    /// there were no link. That is no longer mechanics: energy is not kept, and where g does not depend on the chosen
    /// coordinates there is no solution, which is an error.
    pub fn link_acting<G: Constraint<K, M>, const K: usize, const M: usize, const A: usize>(
        self,
        constraint: G,
        members: impl IntoIterator<Item = [usize; A]>,
        acting: [[bool; D]; A],
    ) -> Scene<Network<D>, E, N, D> {
        const {
            assert!(
                K == A * D,
                "a constraint on A bodies has A times as many variables as a body coordinates"
            )
        };
        let mut links = Links::<_, K, M, A, D>::new(vec![constraint], members.into_iter().collect());
        links.acting = Some(acting);
        self.network(|network| network.with(links))
    }

    /// The same scene with a body held at a place.
    pub fn pin(self, body: usize, at: impl Into<SVector<f64, D>>) -> Scene<Network<D>, E, N, D> {
        self.network(|mut network| {
            network.pins.push((body, at.into().into()));
            network
        })
    }

    /// The same scene, every body with this mass: a number, one for each coordinate, or a symmetric positive definite
    /// matrix. Momenta are then p = M v.
    ///
    /// Potentials do not know masses: weight in proportion to mass is `Gravity { g: 9.81 * mass }`, or
    /// [`Over::each`](crate::effect::Over::each) where masses differ.
    pub fn mass(self, mass: impl Into<Mass<D>>) -> Scene<Network<D>, E, N, D> {
        self.network(|network| Network { masses: Masses::Each(mass.into()), ..network })
    }

    /// The same scene with the masses of the bodies in turn. Weights, see [`mass`](Self::mass).
    pub fn masses<X: Into<Mass<D>>>(self, masses: impl IntoIterator<Item = X>) -> Scene<Network<D>, E, N, D> {
        let masses = masses.into_iter().map(Into::into).collect();
        self.network(|network| Network { masses: Masses::Listed(masses), ..network })
    }

    /// The same scene with multipliers found in this way; see [`Linked::components`](crate::linked::Linked::components)
    /// for what is chosen otherwise.
    pub fn linear_algebra(self, algebra: LinearAlgebra) -> Scene<Network<D>, E, N, D> {
        self.network(|network| Network { algebra, ..network })
    }

    fn network(self, change: impl FnOnce(Network<D>) -> Network<D>) -> Scene<Network<D>, E, N, D> {
        let constraint = change(self.constraint.network(self.count.number()));
        Scene { constraint, effects: self.effects, count: self.count }
    }
}

impl<C: Constraint<D, 1>, E: Effects<D>, N: Count, const D: usize> Scene<C, E, N, D> {
    /// The scene made ready for the scalar `T`: lanes, to run several trajectories side by side.
    pub fn lanes<T: Real>(&self) -> OnSurface<C::Kernel<T>, E::Field<T>, N, OneByOne> {
        OnSurface::new(self.constraint.kernel(), OneByOne, self.effects.field(), self.count)
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

    /// The state with momenta moved, by the forces at its positions, to where `method` takes them to be: a start for a
    /// staggered method from momenta of the same time.
    pub fn staggered<S: Stepper>(&self, state: &State<D>, method: &S) -> State<D> {
        let mut state = state.clone();
        let forces = self.forces(&state.bodies);
        let moving = |(i, _): &(usize, _)| !self.constraint.pinned(*i);
        for (_, (body, force)) in state.bodies.iter_mut().zip(forces).enumerate().filter(moving) {
            let pull = self.constraint.pull(&body.q, &force.components());
            let change = add_scaled(&body.p_low, method.momentum_delay(), &pull);
            (body.p, body.p_low) = two_sum(&body.p, &change);
        }
        state.remembered = None;
        state
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
        check_step_size(stepper.step_size())?;
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
        let system = self.constraint.system(&self.effects, self.count, &start, &stepper)?;
        stepper.check(system.equations())?;
        if let Some(system) = system.refuses(stepper.need()) {
            return Err(Error::CannotMove { method: stepper.name(), system });
        }
        self.check_forces(&start.bodies)?;
        let mut bodies = system.bodies(|i| start.bodies[i], start.time);
        match stepper.need() {
            Need::Series => system.reserve_series(&mut bodies, stepper.stages()),
            _ => system.reserve(&mut bodies, stepper.stages()),
        }
        bodies.room = vec![[0.0; D]; stepper.room() * self.count.number()];
        let (clock, remembered) = ((start.time, start.time_low), start.remembered.as_ref());
        Ok(Simulation::new(system, self.count, bodies, clock, remembered, stepper))
    }

    /// Many trajectories of this scene, from these starts, by the same method; see [`Ensemble`].
    ///
    /// ```text
    /// let mut ensemble = scene.ensemble(starts, Rattle::new(0.01))?;
    /// ensemble.run(2000);
    /// ```
    ///
    /// # Errors
    /// [`Error::Trajectory`] says which start is refused, and why, as [`simulate`](Self::simulate) does.
    pub fn ensemble<S: Stepper>(
        &self,
        starts: impl IntoIterator<Item = State<D>>,
        stepper: S,
    ) -> Result<Ensemble<D>, Error> {
        self.ensemble_in(Double, starts, stepper)
    }

    /// The same with numbers of another [`Precision`] in lanes.
    ///
    /// # Errors
    /// As [`ensemble`](Self::ensemble).
    pub fn ensemble_in<P: Precision, S: Stepper>(
        &self,
        precision: P,
        starts: impl IntoIterator<Item = State<D>>,
        stepper: S,
    ) -> Result<Ensemble<D>, Error> {
        Ensemble::of(precision, self, starts, stepper, InstructionSet::widest())
    }

    fn forces(&self, bodies: &[Body<f64, D>]) -> Vec<<E::Field<f64> as Field<f64, D>>::Force> {
        let positions: Vec<_> = bodies.iter().map(|body| body.q).collect();
        let mut forces = vec![Force::zero(); bodies.len()];
        self.effects.field::<f64>().evaluate(&positions, &mut forces);
        forces
    }

    fn check_forces(&self, bodies: &[Body<f64, D>]) -> Result<(), Error> {
        for (body, force) in self.forces(bodies).iter().enumerate() {
            let force = force.components();
            if !force.iter().all(|f| f.is_finite()) {
                let positions: Vec<_> = bodies.iter().map(|body| body.q).collect();
                let field = self.effects.field::<f64>();
                let effect = field.culprit(&positions, body).map_or("sum of effects", |(name, _)| name);
                let cause = StartFailure::ForceNotFinite { effect, force: force.to_vec() };
                return Err(Error::Start { body, cause });
            }
        }
        Ok(())
    }
}
