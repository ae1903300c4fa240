//! Constraints of one equation, with a surface for each body, as the constraints of a scene.

use crate::effect::list::Effects;
use crate::error::Error;
use crate::kernel::functions::Constraint;
use crate::kernel::over::refuse_nan_in;
use crate::motion::bodies::Count;
use crate::motion::hold::{Hold, Surfaces};
use crate::motion::state::State;
use crate::number::lanes::Fused;
use crate::number::vector::largest;
use crate::systems::surface::kept::OnSurface;
use crate::systems::surface::start;

impl<C: Constraint<D, 1>, const D: usize> Hold<D> for C {
    type System<E: Effects<D>, N: Count> =
        OnSurface<C::Kernel<f64>, E::Forces<f64>, N, C::Kernel<Fused<f64>>>;

    fn system<E: Effects<D>, N: Count>(
        &self,
        effects: &E,
        count: N,
        start: &State<D>,
        h: f64,
        tangent: bool,
    ) -> Result<Self::System<E, N>, Error> {
        let constraint = self.kernel::<f64>();
        for (body, state) in start.bodies.iter().enumerate() {
            let path = h.abs() * largest(&state.p); // but for a factor of √D
            start::check(&constraint, state, path, tangent).map_err(|cause| Error::Start { body, cause })?;
        }
        Ok(OnSurface::new(constraint, self.kernel(), effects.forces(), count))
    }

    fn check(&self) -> Result<(), Error> {
        refuse_nan_in::<C>(self.nan_parameter())
    }

    fn project(&self, state: &State<D>) -> Result<State<D>, Error> {
        start::project(&self.kernel::<f64>(), state)
    }

    fn surfaces<V: Surfaces<D>>(of: &[&Self], to: V) -> Option<V::Found>
    where
        Self: 'static,
    {
        Some(to.found(of))
    }
}
