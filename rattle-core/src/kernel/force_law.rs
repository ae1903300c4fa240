//! Forces that are not gradients: functions of coordinates, velocities and time.

use crate::kernel::over::Over;
use crate::number::real::Real;
use nalgebra::{SMatrix, SVector};

/// A force f(q, v, t) with K components, on K coordinates and their velocities. Written by `force!`.
///
/// ```text
/// ṗ = −∇U + f(q, v, t) + Gᵀλ        in the unit of momentum over time; v = M⁻¹p
/// ```
///
/// In a scene it acts as a [`Flow`](crate::effect::Flow) of momenta, see [`ActsByForce`](crate::effect::ActsByForce):
/// of second order whatever the order of the method. Its [work](crate::run::simulation::Simulation::work) is the change
/// of kinetic energy.
///
/// ```
/// use rattle::prelude::*;
///
/// force! {
///     /// Air that resists with the square of the speed.
///     struct Air { c }
///     |q: [f64; 2], v: [f64; 2]| -c * norm(v) * v
/// }
///
/// let air = Air { c: 0.5 };
/// assert_eq!(air.value(&[0.0, 0.0].into(), &[3.0, 4.0].into(), 0.0).as_slice(), [-7.5, -10.0]);
///
/// let mut simulation = Scene::point().with(air).simulate(State::at([0.0, 0.0]).moving([1.0, 0.0]), Rattle::new(0.01))?;
/// simulation.run(200)?;
/// assert!((simulation.momentum().x - 0.5).abs() < 1e-5); // 1/(1 + c t)
/// # Ok::<(), rattle::Error>(())
/// ```
pub trait ForceLaw<const K: usize>: Sized {
    /// The functions, ready for the scalar `T`.
    type Kernel<T: Real>: ForceLawKernel<T, K>;

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

    /// f(q, v, t).
    fn value(&self, q: &SVector<f64, K>, v: &SVector<f64, K>, t: f64) -> SVector<f64, K> {
        self.kernel::<f64>().value(&(*q).into(), &(*v).into(), t).into()
    }
    /// ∂f/∂v; row i belongs to fᵢ.
    fn slopes(&self, q: &SVector<f64, K>, v: &SVector<f64, K>, t: f64) -> SMatrix<f64, K, K> {
        let (_, slopes) = self.kernel::<f64>().value_and_slopes(&(*q).into(), &(*v).into(), t);
        SMatrix::from_fn(|i, j| slopes[i][j])
    }

    /// The force on chosen bodies, A at a time. Its variables are the coordinates of the bodies of a member, one after
    /// the other, then their velocities. Each body gets its D components of the force.
    fn over<const A: usize>(self, members: impl IntoIterator<Item = [usize; A]>) -> Over<Self, A> {
        Over::new(self, members)
    }
}

/// The functions of a [`ForceLaw`] over the scalar `T`.
pub trait ForceLawKernel<T: Real, const K: usize>: Clone + Send + Sync + 'static {
    /// Whether f depends on v.
    const ON_VELOCITY: bool = false;
    /// Whether ∂f/∂v is other than zero somewhere. Where v does no more than choose between forces, as in `sign(v)`, it
    /// is not, and f is taken at the velocity before the step, not in its middle.
    const SLOPED: bool = Self::ON_VELOCITY;
    /// Whether f depends on t.
    const ON_TIME: bool = false;

    /// f(q, v, t).
    fn value(&self, q: &[T; K], v: &[T; K], t: T) -> [T; K];
    /// f and ∂f/∂v, row i of which belongs to fᵢ.
    fn value_and_slopes(&self, q: &[T; K], v: &[T; K], t: T) -> ([T; K], [[T; K]; K]) {
        (self.value(q, v, t), [[T::from_f64(0.0); K]; K])
    }
}
