//! What trajectories in lanes ask of a system in phase space: a step of one body by itself.

use crate::kernel::functions::{HamiltonianKernel, PhaseConstraintKernel};
use crate::motion::bodies::{Bodies, Body, Count, One};
use crate::motion::failure::Failure;
use crate::motion::system::System;
use crate::solve::aim::{Aim, Pace};
use crate::systems::phase::kept::{InPhaseSpace, Kept, OfBody};
use crate::systems::phase::point::Point;

/// A body of a lane, N at its point, and what it remembers of the guesses of its last two steps.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lone<const D: usize, const M: usize> {
    pub(crate) body: Body<f64, D>,
    pub(crate) slopes: [[f64; M]; M],
    pub(crate) aims: [Aim<f64>; M],
}

impl<K, H, N: Count, const M: usize> InPhaseSpace<K, H, N, M> {
    /// Bodies under these constraints and energies.
    pub(crate) fn new(constraint: K, energy: H, count: N) -> Self {
        Self { constraint, energy, count }
    }

    /// A body of which nothing is remembered.
    pub(crate) fn lone<const D: usize>(&self, body: &Body<f64, D>) -> Lone<D, M>
    where
        K: PhaseConstraintKernel<f64, D, M>,
        H: HamiltonianKernel<f64, D>,
    {
        let slopes = self.functions().hidden(&Point::high(body)).slopes;
        Lone { body: *body, slopes, aims: [Aim::unknown(); M] }
    }

    /// Moves a body by a step of h, after steps of this pace, as a simulation does.
    pub(crate) fn step_alone<const D: usize>(
        &self,
        h: f64,
        pace: Pace,
        Lone { body, slopes, aims }: Lone<D, M>,
    ) -> Result<Lone<D, M>, Failure>
    where
        K: PhaseConstraintKernel<f64, D, M>,
        H: HamiltonianKernel<f64, D>,
    {
        let alone =
            InPhaseSpace { constraint: self.constraint.clone(), energy: self.energy.clone(), count: One };
        let kept = Kept::<One, M> { bodies: [OfBody { slopes, aims }], pace, room: () };
        let mut bodies = Bodies::new(One, kept, &[body], 0.0);
        alone.drift(0.0, h, &mut bodies, &mut ())?;
        alone.settle(0.0, h, &mut bodies, &mut ())?;
        let [OfBody { slopes, aims }] = bodies.kept.bodies;
        Ok(Lone { body: bodies.body(0), slopes, aims })
    }
}
