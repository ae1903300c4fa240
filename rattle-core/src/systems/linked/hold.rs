//! Networks as the constraints of a scene.

use crate::effect::list::Effects;
use crate::error::{Error, NetworkMistake, refuse_nan};
use crate::motion::bodies::Count;
use crate::motion::hold::{Hold, Kind};
use crate::motion::state::State;
use crate::systems::linked::kept::Linked;
use crate::systems::linked::start;
use crate::systems::network::constraints::Network;
use crate::systems::network::solver::Solver;
use std::sync::Arc;

impl<const D: usize> Hold<D> for Network<D> {
    type System<E: Effects<D>, N: Count> = Linked<E::Forces<f64>, N, D>;

    const KIND: Kind = Kind::Network;

    fn system<E: Effects<D>, N: Count>(
        &self,
        effects: &E,
        count: N,
        start: &State<D>,
        h: f64,
        tangent: bool,
    ) -> Result<Self::System<E, N>, Error> {
        Linked::ready(self, effects.forces(), count, start, h, tangent)
    }

    fn check(&self) -> Result<(), Error> {
        self.groups.iter().try_for_each(|group| refuse_nan(group.name(), group.nan_parameter()))
    }

    fn pin(&self, body: usize) -> Option<[f64; D]> {
        self.pins.iter().find_map(|&(pinned, at)| (pinned == body).then_some(at))
    }

    fn bodies(mut self, number: usize) -> Self {
        let before = self.bodies;
        if number == before {
            return self;
        }
        let mut only = self.pins.first().map(|_| "pin");
        for group in &mut self.groups {
            match group.for_each(before, number) {
                Some(each) => *group = Arc::from(each),
                None => only = Some(group.name()),
            }
        }
        let mistake = only.map(|what| NetworkMistake::NotCopied { what, before, bodies: number });
        Self { bodies: number, not_copied: self.not_copied.or(mistake), ..self }
    }

    fn project(&self, state: &State<D>) -> Result<State<D>, Error> {
        start::project(&mut self.shape(state.len())?, self.algebra, state)
    }
}

impl<F, N: Count, const D: usize> Linked<F, N, D> {
    /// A network in a field of force, ready to move from this start, see [`Hold::system`].
    pub(crate) fn ready(
        network: &Network<D>,
        effects: F,
        count: N,
        start: &State<D>,
        h: f64,
        tangent: bool,
    ) -> Result<Self, Error> {
        let mut shape = network.shape(count.number())?;
        start::check(&mut shape, network.algebra, start, h, tangent)?;
        Ok(Self::new(shape, effects, count))
    }

    /// Whether an orthonormal basis is used in place of elimination: where that was asked for, or normals nearly depend
    /// on each other at the start.
    pub(crate) fn is_narrow(&self) -> bool {
        self.shape.components.iter().any(|component| matches!(component.solver, Solver::Orthogonal(_)))
    }
}
