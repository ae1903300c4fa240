//! What is checked about a step: kinks, singular points, other sheets, energies.

use crate::motion::affected::Affected;
use crate::motion::bodies::Saved;
use crate::motion::failure::Failure;
use crate::motion::parts::BodiesOf;
use crate::number::real::Scalar;
use crate::number::vector::add_scaled;

/// What is checked about a step of a [`System`](crate::motion::system::System). The defaults are those of a system
/// whose constraints have no kinks, no singular points and no other sheets.
pub trait Guarded<T: Scalar, const D: usize>: Affected<T, D> {
    /// Whether constraints act along their own gradients, and so do no work where they do not move.
    #[inline(always)]
    fn pulls_along_normals(&self) -> bool {
        true
    }

    /// Whether the energy changes by the work that is booked alone: no flows, and constraints that do none.
    #[inline(always)]
    fn keeps_energy(&self) -> bool {
        Self::FLOWS == 0 && !self.moves_with_time() && self.pulls_along_normals()
    }

    /// Checks whether the normal of a constraint jumps between the saved and the present positions. Does nothing where
    /// constraints have no kinks.
    ///
    /// # Errors
    /// [`StepFailure::Kink`](crate::error::StepFailure::Kink).
    #[inline(always)]
    fn check_kinks(
        &self,
        _before: &Saved<Self::Count, T, D>,
        _now: &BodiesOf<Self, T, D>,
    ) -> Result<(), Failure> {
        Ok(())
    }

    /// Whether what changes its sign where a normal may jump has another one at the present positions than at the saved
    /// ones. Where there are kinks, this tells whether to [look](Self::check_kinks).
    #[inline(always)]
    fn changes_sides(&self, _before: &Saved<Self::Count, T, D>, _now: &BodiesOf<Self, T, D>) -> bool {
        false
    }

    /// Writes ∇g for every body at the present positions, of the equation whose normal jumps according to
    /// [`check_kinks`](Self::check_kinks). Systems that report kinks must implement this.
    fn kinked_normal(&self, _bodies: &BodiesOf<Self, T, D>, _kink: &Failure, normal: &mut [[T; D]]) {
        normal.fill([T::from_f64(0.0); D]);
    }

    /// Checks whether a step of length h has passed a singular point. Does nothing where there are none.
    ///
    /// # Errors
    /// [`StepFailure::NoNormal`](crate::error::StepFailure::NoNormal).
    #[inline(always)]
    fn check_normals(
        &self,
        _h: f64,
        _before: &Saved<Self::Count, T, D>,
        _now: &BodiesOf<Self, T, D>,
    ) -> Result<(), Failure> {
        Ok(())
    }

    /// Checks whether a step of length h, by a method that does not follow the root of its constraints, has ended on
    /// another sheet. Does nothing where the system cannot tell.
    ///
    /// # Errors
    /// [`StepFailure::OtherSheet`](crate::error::StepFailure::OtherSheet).
    #[inline(always)]
    fn check_sheets(
        &self,
        _h: f64,
        _before: &Saved<Self::Count, T, D>,
        _now: &mut BodiesOf<Self, T, D>,
    ) -> Result<(), Failure> {
        Ok(())
    }

    /// Moves bodies on for a time h as they go now, roughly: where a step that failed may have led.
    fn coast(&self, h: f64, bodies: &mut BodiesOf<Self, T, D>) {
        for body in 0..bodies.q.as_ref().len() {
            let v = self.velocity(bodies, body);
            let q = &mut bodies.q.as_mut()[body];
            *q = add_scaled(q, T::from_f64(h), &v);
        }
        bodies.time += h;
    }

    /// Moves bodies that coasted towards the constraints, along the normals that these had before: where a step may
    /// have led that began along an edge, which no coasting body leaves. Does nothing where edges are not looked for
    /// so.
    fn lean(&self, _before: &Saved<Self::Count, T, D>, _bodies: &mut BodiesOf<Self, T, D>) {}
}
