//! Constraint and energy in phase space as the constraints of a scene.

use crate::effect::list::{Effects, Forces};
use crate::error::Error;
use crate::kernel::functions::{Hamiltonian, PhaseConstraint};
use crate::kernel::over::refuse_nan_in;
use crate::motion::bodies::{Body, Count};
use crate::motion::hold::{Hold, Kind, PhaseSpaces};
use crate::motion::state::State;
use crate::systems::phase::kept::{InPhaseSpace, PhaseSpace};
use crate::systems::phase::point::Point;

impl<G, H, const M: usize> PhaseSpace<G, H, M> {
    fn in_phase_space<N: Count, const D: usize>(
        &self,
        count: N,
    ) -> InPhaseSpace<G::Kernel<f64>, H::Kernel<f64>, N, M>
    where
        G: PhaseConstraint<D, M>,
        H: Hamiltonian<D>,
    {
        InPhaseSpace { constraint: self.constraint.kernel(), energy: self.hamiltonian.kernel(), count }
    }
}

impl<G: PhaseConstraint<D, M>, H: Hamiltonian<D>, const D: usize, const M: usize> Hold<D>
    for PhaseSpace<G, H, M>
{
    type System<E: Effects<D>, N: Count> = InPhaseSpace<G::Kernel<f64>, H::Kernel<f64>, N, M>;

    const KIND: Kind = Kind::Phase;

    fn system<E: Effects<D>, N: Count>(
        &self,
        _: &E,
        count: N,
        start: &State<D>,
        h: f64,
        _: bool,
    ) -> Result<Self::System<E, N>, Error> {
        const {
            assert!(
                E::Forces::<f64>::FLOWS == 0,
                "in phase space no drag, heat or other flow of momenta acts: they are for scenes with masses; a magnetic field \
                 is |p - A(q)|^2/2 in H"
            );
            assert!(
                size_of::<<E::Forces<f64> as Forces<f64, D>>::Force>() == 0,
                "in phase space the Hamiltonian is the whole energy: write potentials into it"
            )
        };
        let system = self.in_phase_space(count);
        for (body, state) in start.bodies.iter().enumerate() {
            system.functions().check(h, state).map_err(|cause| Error::Start { body, cause })?;
        }
        Ok(system)
    }

    fn check(&self) -> Result<(), Error> {
        refuse_nan_in::<G>(self.constraint.nan_parameter())?;
        refuse_nan_in::<H>(self.hamiltonian.nan_parameter())
    }

    fn project(&self, state: &State<D>) -> Result<State<D>, Error> {
        let system = self.in_phase_space(crate::motion::bodies::One);
        let mut state = State { remembered: None, ..state.clone() };
        for (number, body) in state.bodies.iter_mut().enumerate() {
            let cause = |cause| Error::Start { body: number, cause };
            let Point { q, p } = system.functions().project(body).map_err(cause)?;
            *body = Body { q, p, q_low: [0.0; D], p_low: [0.0; D] };
        }
        Ok(state)
    }

    fn phase_spaces<V: PhaseSpaces<D>>(of: &[&Self], to: V) -> Option<V::Found>
    where
        Self: 'static,
    {
        let spaces = of.iter().map(|space| (&space.constraint, &space.hamiltonian)).collect::<Vec<_>>();
        Some(to.found::<G, H, M>(&spaces))
    }
}
