//! Scenes: constraints, bodies and effects, to be simulated.

use crate::effect::force::Force;
use crate::effect::list::{Effects, Forces, With};
use crate::effect::moment::Moment;
use crate::effect::one::Effect;
use crate::error::{Error, expect_variables};
use crate::kernel::functions::{Constraint, Hamiltonian, PhaseConstraint};
use crate::kernel::over::short_name;
use crate::motion::bodies::{Body, Count, Many, One};
pub use crate::motion::hold::{Hold, Kind, PhaseSpaces, Surfaces};
use crate::motion::method::Method;
use crate::motion::state::{Coordinates, State};
use crate::number::real::Scalar;
use crate::number::vector::{add_scaled, two_sum};
use crate::systems::network::algebra::LinearAlgebra;
use crate::systems::network::constraints::{Masses, Network};
use crate::systems::network::group::Links;
use crate::systems::network::mass::Mass;
use crate::systems::network::tie::Tie;
use crate::systems::phase::{PhaseSpace, Unconstrained};
use crate::systems::rigid::Rigid;
use crate::systems::surface::kept::{OnSurface, OneByOne};
use std::marker::PhantomData;

/// Constraints, the number of bodies that obey them, and the effects that act on them.
///
/// Only effects added by [`with`](Self::with) act; without any, motion is free, on a surface along geodesics.
///
/// A function that takes a scene of one body in space:
///
/// ```
/// use rattle::{bodies::One, effect::Effects, scene::{Hold, Scene}};
/// fn bills<C: Hold<3>, E: Effects<3>>(scene: &Scene<C, E, One, 3>) { /* scene.simulate(…) */ }
/// ```
#[doc(alias = "model")]
#[doc(alias = "system")]
#[doc(alias = "setup")]
#[derive(Debug, Clone, Copy)]
pub struct Scene<C, E, N, const D: usize> {
    pub(crate) constraint: C,
    pub(crate) effects: E,
    pub(crate) count: N,
}

/// Constraints accepted by [`Scene::on`]: a single equation makes a surface, several equations (up to 64) a
/// [`Network`]. For more use `Scene::point().link(constraint, [[0]])`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no constraint",
    label = "a scene begins with what `constraint!` makes, of up to 64 equations",
    note = "a potential acts in a scene: `Scene::on(constraint).with(potential)`, or `Scene::point().with(potential)` on a free body",
    note = "constraints between bodies are links: `Scene::points(n).link(constraint, members)`",
    note = "a rigid body: `Scene::rigid(body)`"
)]
pub trait Begin<const D: usize, const M: usize> {
    /// The constraint in the form that the scene keeps.
    type Hold: Hold<D>;
    /// Converts the constraint into this form.
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
    /// One body of unit mass under g(q) = 0, without effects: one equation makes a surface, several equations a
    /// submanifold of lower dimension.
    #[doc(alias = "surface")]
    #[doc(alias = "manifold")]
    #[doc(alias = "constraint")]
    pub fn on<C: Begin<D, M>, const D: usize, const M: usize>(constraint: C) -> Scene<C::Hold, (), One, D> {
        Scene { constraint: constraint.begin(), effects: (), count: One }
    }

    /// One body in phase space, under g(q, p) = 0 with the energy H(q, p). Methods are
    /// [`Rattle`](crate::methods::rattle::Rattle), here in the form of geometric RATTLE, and compositions of it. See
    /// [`phase`](crate::systems::phase) for the conditions on g.
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

    /// One body with the energy H(q, p) alone: q̇ = ∂H/∂p, ṗ = −∂H/∂q. [`Rattle`](crate::methods::rattle::Rattle) is
    /// the Störmer–Verlet step of H here, which is leapfrog for H = T(p) + U(q), and symplectic for any H; compositions
    /// raise its order.
    ///
    /// ```
    /// use rattle::prelude::*;
    ///
    /// hamiltonian! {
    ///     /// A pendulum of length and mass 1, by its angle.
    ///     struct Pendulum { g }
    ///     |phi, p| p^2 / 2 - g * cos(phi)
    /// }
    ///
    /// let start = State::at([3.0]).moving([0.0]);
    /// let mut simulation = Scene::hamiltonian(Pendulum { g: 9.81 }).simulate(start, Rattle::new(0.01))?;
    /// simulation.run(100_000)?;
    /// assert!(simulation.energy_error().abs() < 1e-3 * 9.81);
    /// # Ok::<(), rattle::Error>(())
    /// ```
    #[doc(alias = "leapfrog")]
    #[doc(alias = "Hamiltonian system")]
    pub fn hamiltonian<H, const D: usize>(
        hamiltonian: H,
    ) -> Scene<PhaseSpace<Unconstrained, H, 0>, (), One, D>
    where
        H: Hamiltonian<D>,
    {
        Self::in_phase_space(Unconstrained, hamiltonian)
    }

    /// One rigid body that turns about its centre of mass.
    #[doc(alias = "rotation")]
    #[doc(alias = "top")]
    #[doc(alias = "gyroscope")]
    #[must_use]
    pub fn rigid(body: Rigid) -> Scene<Rigid, (), One, 9> {
        Scene { constraint: body, effects: (), count: One }
    }

    /// One body of unit mass without constraints; [`link`](Self::link) adds them.
    #[must_use]
    pub fn point<const D: usize>() -> Scene<Network<D>, (), One, D> {
        Scene { constraint: Network::default(), effects: (), count: One }
    }

    /// `number` bodies of unit mass without constraints; [`link`](Self::link) adds them.
    ///
    /// ```
    /// # use rattle::{Scene, State, Rattle};
    /// let free = Scene::points(2);
    /// let mut simulation = free.simulate(State::of([[0.0], [1.0]]).moving([2.0]), Rattle::new(0.5))?;
    /// simulation.run(2)?;
    /// assert_eq!(simulation.positions().map(|q| q.x).collect::<Vec<_>>(), [2.0, 3.0]);
    /// # Ok::<(), rattle::Error>(())
    /// ```
    #[must_use]
    pub fn points<const D: usize>(number: usize) -> Scene<Network<D>, (), Many, D> {
        Scene { constraint: Network::default(), effects: (), count: Many(number) }
    }
}

impl<C: Hold<D>, E: Effects<D>, N: Count, const D: usize> Scene<C, E, N, D> {
    /// The same scene with `number` bodies, each with its own copy of the constraint. Links and pins of some bodies
    /// alone have no copies, so that `number` must be what it was when they were added; effects stay as they are.
    ///
    /// Eight bodies or more are moved several at a time on processors with fused multiply-add, which takes a half to a
    /// fourth of the time. Their motion then differs by rounding from that of each body alone, since other code
    /// evaluates [functions](crate::number::lanes).
    pub fn bodies(self, number: usize) -> Scene<C, E, Many, D> {
        Scene { constraint: self.constraint.bodies(number), effects: self.effects, count: Many(number) }
    }
}

impl<C: Tie<D>, E: Effects<D>, N: Count, const D: usize> Scene<C, E, N, D> {
    /// The same scene with these links. Each of `members` lists the bodies that one copy of `constraint` links; the
    /// variables of the constraint are the coordinates of the first body of the list, then of the second, and so on.
    ///
    /// ```text
    /// Scene::points(1001).link(Rod { length: 1e-3 }, (0..1000).map(|i| [i, i + 1])).pin(0, [0.0; 3])
    /// ```
    #[doc(alias = "hinge")]
    #[doc(alias = "bond")]
    #[doc(alias = "constraint")]
    #[doc(alias = "joint")]
    pub fn link<G: Constraint<K, M>, const K: usize, const M: usize, const A: usize>(
        self,
        constraint: G,
        members: impl IntoIterator<Item = [usize; A]>,
    ) -> Scene<Network<D>, E, N, D> {
        const { expect_variables(K, A, D, false) };
        let members = members.into_iter().collect();
        self.network(|network| network.with(Links::<_, K, M, A, D>::new(vec![constraint], members)))
    }

    /// The same scene with these links, each with parameters of its own.
    pub fn link_each<G: Constraint<K, M>, const K: usize, const M: usize, const A: usize>(
        self,
        links: impl IntoIterator<Item = (G, [usize; A])>,
    ) -> Scene<Network<D>, E, N, D> {
        const { expect_variables(K, A, D, false) };
        let (constraints, members) = links.into_iter().unzip();
        self.network(|network| network.with(Links::<_, K, M, A, D>::new(constraints, members)))
    }

    /// The same scene with links that change with time, g(q, t) = 0: the last variable of `constraint` is the time t.
    ///
    /// Moving supports and motors with a prescribed angle are such links. They do
    /// [work](crate::run::simulation::Simulation::work). The momenta of a start must satisfy G v = −∂g/∂t;
    /// [`project`](Self::project) makes them do so.
    #[doc(alias = "rheonomic")]
    #[doc(alias = "driven")]
    #[doc(alias = "motor")]
    pub fn link_moving<G: Constraint<K, M>, const K: usize, const M: usize, const A: usize>(
        self,
        constraint: G,
        members: impl IntoIterator<Item = [usize; A]>,
    ) -> Scene<Network<D>, E, N, D> {
        const {
            assert!(A > 0, "a moving constraint is one of some body");
            expect_variables(K, A, D, true)
        };
        let members = members.into_iter().collect();
        self.network(|network| network.with(Links::<_, K, M, A, D>::new(vec![constraint], members)))
    }

    /// The same scene with links whose multipliers act only on the coordinates that are `true`; the others move as if
    /// there were no link. This is no longer mechanics: energy is not conserved, and heat baths, which differ by what
    /// they hold at kT then, and `temperature()` have no common meaning. Where g does not depend on the chosen
    /// coordinates there is no solution, which is an error.
    pub fn link_acting<G: Constraint<K, M>, const K: usize, const M: usize, const A: usize>(
        self,
        constraint: G,
        members: impl IntoIterator<Item = [usize; A]>,
        acting: [[bool; D]; A],
    ) -> Scene<Network<D>, E, N, D> {
        const { expect_variables(K, A, D, false) };
        let mut links = Links::<_, K, M, A, D>::new(vec![constraint], members.into_iter().collect());
        links.acting = Some(acting);
        self.network(|network| network.with(links))
    }

    /// The same scene with a body fixed at a position.
    #[doc(alias = "anchor")]
    #[doc(alias = "fixed")]
    pub fn pin(self, body: usize, at: impl Coordinates<D>) -> Scene<Network<D>, E, N, D> {
        self.network(|mut network| {
            network.pins.push((body, at.coordinates()));
            network
        })
    }

    /// The same scene, every body with this mass: a number, one for each coordinate, or a symmetric positive definite
    /// matrix. Momenta are then p = M v.
    ///
    /// In thermal equilibrium places have the density exp(−U/kT) times area, which such a matrix measures.
    ///
    /// Potentials do not know masses: the weight of a body is `Gravity { g: 9.81 * mass }`, or
    /// [`Over::each`](crate::kernel::over::Over::each) where masses differ.
    pub fn mass(self, mass: impl Into<Mass<D>>) -> Scene<Network<D>, E, N, D> {
        self.network(|network| Network { masses: Masses::Each(mass.into()), ..network })
    }

    /// The same scene with a mass for each body, in their order. See [`mass`](Self::mass) for weights.
    pub fn masses<X: Into<Mass<D>>>(self, masses: impl IntoIterator<Item = X>) -> Scene<Network<D>, E, N, D> {
        let masses = masses.into_iter().map(Into::into).collect();
        self.network(|network| Network { masses: Masses::Listed(masses), ..network })
    }

    /// The same scene with a chosen method of linear algebra for the multipliers. By default it is chosen
    /// automatically; [`Linked::components`](crate::systems::linked::Linked::components) shows the choice.
    pub fn linear_algebra(self, algebra: LinearAlgebra) -> Scene<Network<D>, E, N, D> {
        self.network(|network| Network { algebra, ..network })
    }

    fn network(self, change: impl FnOnce(Network<D>) -> Network<D>) -> Scene<Network<D>, E, N, D> {
        let constraint = change(self.constraint.network(self.count.number()));
        Scene { constraint, effects: self.effects, count: self.count }
    }
}

impl<C: Constraint<D, 1>, E: Effects<D>, N: Count, const D: usize> Scene<C, E, N, D> {
    /// The system of this scene over the scalar `T`, to be moved step by step by a [method](crate::motion::method):
    /// over complex numbers or dual ones a step has its derivatives with it.
    ///
    /// Flows of momenta (drag, heat, forces of velocities or time) act in the steps of methods that have them
    /// [inside](crate::motion::method::Method::STIRS), as [`Baoab`](crate::methods::baoab::Baoab). To steps of other
    /// methods a simulation adds half of each flow before and after; who moves a system by hand has none. What `force!`
    /// and [`VelocityRescaling`](crate::effect::VelocityRescaling) change by is computed with real parts, and has no
    /// derivatives.
    ///
    /// The scene is not checked: what is wrong with it, [`simulate`](Self::simulate) tells.
    pub fn system<T: Scalar>(&self) -> OnSurface<C::Kernel<T>, E::Forces<T>, N, OneByOne> {
        OnSurface::new(self.constraint.kernel(), OneByOne, self.effects.forces(), self.count)
    }
}

impl<C: Hold<D>, E: Effects<D>, N: Count, const D: usize> Scene<C, E, N, D> {
    /// The same scene with a further [effect](crate::effect): a potential on each body or between every two, a force,
    /// drag, a thermostat.
    #[doc(alias = "force")]
    #[doc(alias = "friction")]
    #[doc(alias = "thermostat")]
    #[doc(alias = "gravity")]
    pub fn with<P: Effect<D, Kind>, Kind>(self, effect: P) -> Scene<C, With<E, P, Kind>, N, D> {
        let (name, kind) = (short_name::<P>(), PhantomData);
        let effects = With { others: self.effects, effect, name, kind };
        Scene { constraint: self.constraint, effects, count: self.count }
    }

    /// The state with every position moved onto the constraints, by Newton's method along their gradients, and
    /// every momentum made tangent. Linked bodies move by their masses, or, where that leads to no place, as if all
    /// were 1: light bodies between heavy ones are thrown far by theirs. On a surface, a body on an edge over which its
    /// momentum leads is put on the face beyond, by some roundings, if the momentum is more nearly tangent to that one.
    ///
    /// # Errors
    /// [`Error::Start`] where no such position is found, the input is not finite, or momenta of a rigid body are more
    /// than an angular momentum; [`Error::BodyCount`] for a state with another number of bodies.
    #[doc(alias = "initial condition")]
    #[doc(alias = "consistent")]
    pub fn project(&self, state: &State<D>) -> Result<State<D>, Error> {
        self.fits(state)?;
        self.constraint.project(state)
    }

    /// Whether a state has the bodies that the scene and its effects name, and as many momenta as bodies.
    pub(crate) fn fits(&self, state: &State<D>) -> Result<(), Error> {
        if let Some(momenta) = state.other_momenta {
            return Err(Error::MomentumCount { bodies: state.len(), momenta });
        }
        if state.len() != self.count.number() {
            return Err(Error::BodyCount { scene: self.count.number(), state: state.len() });
        }
        self.constraint.check()?;
        self.effects.check(state.len())
    }

    /// A start for a staggered method, such as [`Shake`](crate::methods::shake::Shake) or
    /// [`Leapfrog`](crate::methods::leapfrog::Leapfrog), from a state whose momenta belong to the time of its
    /// positions.
    ///
    /// A staggered method has positions at times tₙ and momenta half a step apart: `Leapfrog` at tₙ + h/2, `Shake` at
    /// tₙ − h/2. The momenta of the state are changed by the forces at its positions over that half step; positions are
    /// unchanged.
    ///
    /// # Errors
    /// [`Error::BodyCount`] for a state with another number of bodies, [`Error::Network`] for an effect on bodies that
    /// do not exist.
    #[doc(alias = "leapfrog")]
    #[doc(alias = "half step")]
    pub fn staggered<S: Method>(&self, state: &State<D>, method: &S) -> Result<State<D>, Error> {
        self.fits(state)?;
        let mut state = state.clone();
        let forces = self.forces(&state.bodies, state.time);
        let moving = |(i, _): &(usize, _)| self.constraint.pin(*i).is_none();
        for (_, (body, force)) in state.bodies.iter_mut().zip(forces).enumerate().filter(moving) {
            let pull = self.constraint.pull(&body.q, &force.components());
            let change = add_scaled(&body.p_low, method.momentum_delay(), &pull);
            (body.p, body.p_low) = two_sum(&body.p, &change);
        }
        state.remembered = None;
        Ok(state)
    }

    /// Forces on these bodies at this time.
    pub(crate) fn forces(
        &self,
        bodies: &[Body<f64, D>],
        time: f64,
    ) -> Vec<<E::Forces<f64> as Forces<f64, D>>::Force> {
        let positions = Body::positions(bodies);
        let mut forces = vec![Force::zero(); bodies.len()];
        let (effects, at) = (self.effects.forces::<f64>(), Moment { time, positions: &positions });
        effects.evaluate(at, &mut effects.room(bodies.len()), &mut forces);
        forces
    }
}
