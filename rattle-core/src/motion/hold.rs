//! What holds the bodies of a scene, and the system that it makes of them.

use crate::effect::list::Effects;
use crate::error::Error;
use crate::kernel::functions::Constraint;
use crate::motion::bodies::Count;
use crate::motion::state::State;
use crate::motion::system::System;

/// What holds the bodies of a scene: a surface for each, or a [`Network`](crate::systems::network::Network) of
/// constraints.
pub trait Hold<const D: usize>: Sized {
    /// Bodies held in this way, in a field of force.
    type System<E: Effects<D>, N: Count>: System<f64, D, Count = N>;

    /// Whether this is a [`Network`](crate::systems::network::Network). Known by the type, so that its lanes in an
    /// ensemble are compiled for networks alone.
    const IS_NETWORK: bool = false;

    /// The system, ready to move from this start in steps of size `h`; momenta must be along the constraints there if
    /// `tangent`.
    ///
    /// # Errors
    /// Where the constraints make no sense for so many bodies; says which body cannot start there and why.
    fn system<E: Effects<D>, N: Count>(
        &self,
        effects: &E,
        count: N,
        start: &State<D>,
        h: f64,
        tangent: bool,
    ) -> Result<Self::System<E, N>, Error>;

    /// Whether this body cannot move at all.
    fn pinned(&self, _body: usize) -> bool {
        false
    }

    /// ṗ of a body at q under a force, before constraints.
    fn pull(&self, _q: &[f64; D], force: &[f64; D]) -> [f64; D] {
        *force
    }

    /// The same for so many bodies, each under its own copy.
    #[must_use]
    fn bodies(self, number: usize) -> Self;

    /// The state moved onto the constraints.
    ///
    /// # Errors
    /// Where none is found.
    fn project(&self, state: &State<D>) -> Result<State<D>, Error>;

    /// The surfaces that these are, one body each, shown to a visitor; none where they are something else.
    fn surfaces<V: Surfaces<D>>(_of: &[&Self], _to: V) -> Option<V::Found>
    where
        Self: 'static,
    {
        None
    }
}

/// Who asks [`Hold::surfaces`] what the surfaces are: without this the contract would have to know what is made of
/// them.
pub trait Surfaces<const D: usize> {
    /// What is made of the surfaces.
    type Found;
    /// Is shown them.
    fn found<C: Constraint<D, 1> + 'static>(self, surfaces: &[&C]) -> Self::Found;
}
