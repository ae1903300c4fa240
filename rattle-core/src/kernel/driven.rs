//! Potentials that depend on time.

use crate::kernel::over::Over;
use crate::number::real::Real;
use nalgebra::SVector;

/// A potential energy U(q, t) of one body with D coordinates that changes with time. Written by `potential!` where the
/// last variable is named `t`.
///
/// The work ∫ ∂U/∂t dt along the motion is part of [`Simulation::work`](crate::run::simulation::Simulation::work), so
/// K + U − work is conserved. Each kick of a length c adds c ∂U/∂t(q, t) at its position and time; Lobatto methods and
/// `Dop853` add it with their own weights. This is the method applied to dE/dt = ∂U/∂t, with t and −E as a further pair
/// of conjugate variables. So the energy error has the order of the method, and does not drift where the method is
/// symplectic. `Taylor`, `Bdf2` and `NoseHoover`, which cannot treat forces that depend on time, are refused.
///
/// U has to be continuous in t. Where it jumps at an instant, as `if t < 1 { 0 } else { a * x }` does, forces are those
/// of either side, but the work U(q, t⁺) − U(q, t⁻) of the jump is not booked: no ∂U/∂t tells of it.
///
/// ```
/// use rattle::prelude::*;
///
/// potential! {
///     /// A uniform field along x that oscillates.
///     struct Field { a, w }
///     |x, _y, t| -a * cos(w * t) * x
/// }
///
/// let scene = Scene::point().with(Field { a: 1.0, w: 2.0 });
/// let mut simulation = scene.simulate(State::at([0.0, 0.0]), Lobatto::<4>::new(0.1))?;
/// simulation.run(10)?;
/// let (t, q) = (simulation.time(), simulation.position());
/// assert!((q.x - (1.0 - (2.0 * t).cos()) / 4.0).abs() < 1e-8); // ẍ = cos 2t
/// assert!(simulation.work().abs() > 0.1 && simulation.energy_error().abs() < 1e-7);
/// # Ok::<(), rattle::Error>(())
/// ```
pub trait DrivenPotential<const D: usize>: Sized {
    /// The functions, ready for the scalar `T`.
    type Kernel<T: Real>: DrivenPotentialKernel<T, D>;

    /// The kernel for lanes, with the parameters of `lane(i)` in lane i: for a parameter sweep.
    fn kernel_of_lanes<'a, T: Real>(lane: impl Fn(usize) -> &'a Self) -> Self::Kernel<T>
    where
        Self: 'a;

    /// The name of a parameter that is NaN, if one is. Scenes refuse that: comparisons with NaN, in `if` and `max`, are
    /// false, so that a function may have values all the same.
    fn nan_parameter(&self) -> Option<&'static str> {
        None
    }

    /// The kernel with this value's parameters, in every lane.
    fn kernel<T: Real>(&self) -> Self::Kernel<T> {
        Self::kernel_of_lanes(|_| self)
    }

    /// U(q, t).
    fn value(&self, q: &SVector<f64, D>, t: f64) -> f64 {
        self.kernel::<f64>().value(&(*q).into(), t)
    }
    /// ∂U/∂q; the force is its negative.
    fn gradient(&self, q: &SVector<f64, D>, t: f64) -> SVector<f64, D> {
        self.kernel::<f64>().gradient(&(*q).into(), t).into()
    }
    /// ∂U/∂t.
    fn rate(&self, q: &SVector<f64, D>, t: f64) -> f64 {
        self.kernel::<f64>().rate(&(*q).into(), t)
    }

    /// The potential as an effect on chosen bodies, or between them, as
    /// [`Potential::over`](crate::kernel::Potential::over).
    fn over<const A: usize>(self, members: impl IntoIterator<Item = [usize; A]>) -> Over<Self, A> {
        Over::new(self, members)
    }
}

/// The functions of a [`DrivenPotential`] over the scalar `T`.
pub trait DrivenPotentialKernel<T: Real, const D: usize>: Clone + Send + Sync + 'static {
    /// U(q, t).
    fn value(&self, q: &[T; D], t: T) -> T;
    /// ∂U/∂q.
    fn gradient(&self, q: &[T; D], t: T) -> [T; D];
    /// ∂U/∂t.
    fn rate(&self, q: &[T; D], t: T) -> T;
}
