//! How the bodies of a scene are constrained, and the system that results.

use crate::effect::list::Effects;
use crate::error::Error;
use crate::kernel::functions::{Constraint, Hamiltonian, PhaseConstraint};
use crate::motion::bodies::Count;
use crate::motion::state::State;
use crate::motion::system::System;

/// The constraints of a scene: a surface for each body, a [`Network`](crate::systems::network::Network) of links,
/// [`Rigid`](crate::systems::rigid::Rigid) bodies, or a [`PhaseSpace`](crate::systems::phase::PhaseSpace).
pub trait Hold<const D: usize>: Sized {
    /// The system of bodies under these constraints, with effects `E`.
    type System<E: Effects<D>, N: Count>: System<f64, D, Count = N>;

    /// What kind of constraints this is. A constant of the type, so that the code of ensembles of networks, say, is
    /// compiled for networks alone.
    const KIND: Kind = Kind::Other;

    /// The system, ready to move from this start in steps of size `h`. If `tangent`, momenta must be tangent to the
    /// constraints there.
    ///
    /// # Errors
    /// Where the constraints make no sense for this number of bodies, or a body cannot start there: which body, and
    /// why.
    fn system<E: Effects<D>, N: Count>(
        &self,
        effects: &E,
        count: N,
        start: &State<D>,
        h: f64,
        tangent: bool,
    ) -> Result<Self::System<E, N>, Error>;

    /// Checks the parameters of the constraints.
    ///
    /// # Errors
    /// [`Error::NanParameter`].
    fn check(&self) -> Result<(), Error> {
        Ok(())
    }

    /// Where this body is fixed, if it is.
    fn pin(&self, _body: usize) -> Option<[f64; D]> {
        None
    }

    /// ṗ of a body at q under a force, without constraints.
    fn pull(&self, _q: &[f64; D], force: &[f64; D]) -> [f64; D] {
        *force
    }

    /// The same constraints for `number` bodies; where each has a copy of its own, `self`.
    #[must_use]
    fn bodies(self, _number: usize) -> Self {
        self
    }

    /// The state moved onto the constraints.
    ///
    /// # Errors
    /// Where no such state is found.
    fn project(&self, state: &State<D>) -> Result<State<D>, Error>;

    /// Calls a visitor with the surfaces of these scenes, of one body each; `None` where their constraints are not
    /// surfaces.
    fn surfaces<V: Surfaces<D>>(_of: &[&Self], _to: V) -> Option<V::Found>
    where
        Self: 'static,
    {
        None
    }

    /// Calls a visitor with the constraints and Hamiltonians of these scenes; `None` where they are not in phase space.
    fn phase_spaces<V: PhaseSpaces<D>>(_of: &[&Self], _to: V) -> Option<V::Found>
    where
        Self: 'static,
    {
        None
    }
}

/// A kind of constraints, as far as ensembles tell them apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A [`Network`](crate::systems::network::Network).
    Network,
    /// [`Rigid`](crate::systems::rigid::Rigid) bodies.
    Rigid,
    /// A [`PhaseSpace`](crate::systems::phase::PhaseSpace).
    Phase,
    /// Surfaces, and all others.
    Other,
}

/// A visitor for [`Hold::surfaces`]: a function that is generic in the type of the surfaces.
pub trait Surfaces<const D: usize> {
    /// The result.
    type Found;
    /// Called with the surfaces.
    fn found<C: Constraint<D, 1> + 'static>(self, surfaces: &[&C]) -> Self::Found;
}

/// A visitor for [`Hold::phase_spaces`]: a function that is generic in the types of constraints and Hamiltonians.
pub trait PhaseSpaces<const D: usize> {
    /// The result.
    type Found;
    /// Called with the constraint and the Hamiltonian of each scene.
    fn found<G, H, const M: usize>(self, spaces: &[(&G, &H)]) -> Self::Found
    where
        G: PhaseConstraint<D, M> + 'static,
        H: Hamiltonian<D> + 'static;
}
