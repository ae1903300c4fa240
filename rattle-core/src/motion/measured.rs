//! What can be read off a system besides positions and momenta.

use crate::effect::force::Force;
use crate::motion::affected::Affected;
use crate::motion::bodies::Bodies;
use crate::motion::parts::BodiesOf;
use crate::number::real::Scalar;
use crate::number::vector::dot;

/// What can be read off a [`System`](crate::motion::system::System). A system with equations implements
/// [`residuals`](Self::residuals), [`drift_rates`](Self::drift_rates) and
/// [`constraint_forces`](Self::constraint_forces).
pub trait Measured<T: Scalar, const D: usize>: Affected<T, D> {
    /// pᵀM⁻¹p/2, summed over the bodies, from positions and momenta alone.
    fn kinetic_energy<X>(&self, bodies: &Bodies<Self::Count, T, X, D>) -> T {
        let parts = bodies.p.as_ref().iter().zip(bodies.p_low.as_ref()).enumerate();
        let energy = parts.map(|(body, (p, low))| {
            let v = self.velocity(bodies, body);
            T::from_f64(0.5) * dot(p, &v) + dot(low, &v)
        });
        energy.fold(T::from_f64(0.0), |sum, part| sum + part)
    }

    /// The last force on a body.
    fn force(&self, bodies: &BodiesOf<Self, T, D>, body: usize) -> [T; D] {
        Self::forces_of(&bodies.kept).get(body).map_or([T::from_f64(0.0); D], Force::components)
    }

    /// Writes g(q, t) of each equation. A system with equations must implement this.
    fn residuals(&self, _bodies: &BodiesOf<Self, T, D>, _g: &mut [T]) {
        debug_assert_eq!(self.equations(), 0, "{} has equations", self.kind());
    }

    /// Writes G M⁻¹p + ∂g/∂t of each equation. A system with equations must implement this.
    fn drift_rates(&self, _bodies: &BodiesOf<Self, T, D>, _rates: &mut [T]) {
        debug_assert_eq!(self.equations(), 0, "{} has equations", self.kind());
    }

    /// Writes Gᵀλ of each body, with λ of [`multipliers`](crate::motion::system::System::multipliers); zeros where
    /// there are no equations. A system with equations must implement this.
    fn constraint_forces(&self, _bodies: &BodiesOf<Self, T, D>, forces: &mut [[T; D]]) {
        debug_assert_eq!(self.equations(), 0, "{} has equations", self.kind());
        forces.fill([T::from_f64(0.0); D]);
    }

    /// The number of corrections in the solution of position equations since the start; `None` where they are not
    /// counted.
    fn corrections(&self, _bodies: &BodiesOf<Self, T, D>) -> Option<u64> {
        None
    }
}
