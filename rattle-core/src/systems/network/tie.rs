//! What links, pins and masses can be added to.

use crate::kernel::functions::Constraint;
use crate::motion::hold::Hold;
use crate::systems::network::constraints::Network;
use crate::systems::network::group::Links;

/// What links, pins and masses can be added to.
pub trait Tie<const D: usize>: Hold<D> {
    /// The same constraints as a network of `bodies` bodies.
    fn network(self, bodies: usize) -> Network<D>;
}

impl<C: Constraint<D, 1>, const D: usize> Tie<D> for C {
    fn network(self, bodies: usize) -> Network<D> {
        let members = (0..bodies).map(|i| [i]).collect();
        Network { bodies, ..Network::default() }.with(Links::<_, D, 1, 1, D>::new(vec![self], members))
    }
}

impl<const D: usize> Tie<D> for Network<D> {
    fn network(self, bodies: usize) -> Self {
        Self { bodies, ..self }
    }
}
