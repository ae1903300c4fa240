//! Capabilities that only some systems have, beyond the operations of every [`System`](crate::motion::system::System).
//! [`Never`] stands for a missing capability.
//!
//! A method gets them through its [`need`](crate::motion::need). That a system has them is checked before the run, so
//! no step can ask for a missing capability.

use crate::motion::bodies::{Bodies, Count};
use crate::motion::failure::Failure;
use crate::motion::table::Table;
use crate::motion::witness::Witness;
use crate::number::real::Scalar;
use std::array::from_fn;

/// Rates of change, and projection onto the constraints in the metric of the masses. For systems with H = K(p) + U(q),
/// whose momenta and forces are separate.
pub trait Rates<N: Count, X, T: Scalar, const D: usize> {
    /// Writes ṗ = f + Gᵀλ of each body, with λ such that g̈ = 0, at the present positions, from the normals and forces
    /// kept there. Positions and momenta may be a little off the constraints. Returns the power of what moves with
    /// time, ∂U/∂t − λᵀ ∂g/∂t. `witness` gets λ as that of the start of a step. Neither allocates nor panics.
    fn evaluate_rates<W: Witness<T>>(
        &self,
        bodies: &mut Bodies<N, T, X, D>,
        rates: &mut [[T; D]],
        witness: &mut W,
    ) -> T;

    /// Moves positions, which a motion over the time `h` has left a little off the constraints, to the nearest point on
    /// them in the metric of the masses, to rounding, and evaluates normals and forces there. Momenta are unchanged;
    /// [`settle`](crate::motion::system::System::settle) with kick 0 projects them. Neither allocates nor panics.
    ///
    /// # Errors
    /// As [`drift`](crate::motion::system::System::drift); also where the iteration does not come nearer to the
    /// constraints.
    fn project(&self, h: f64, bodies: &mut Bodies<N, T, X, D>) -> Result<(), Failure>;

    /// aᵀM b, for changes a and b of the position of a body; 0 for a pinned body.
    fn mass_product(&self, body: usize, a: &[T; D], b: &[T; D]) -> T;

    /// M v of a body; 0 for a pinned body.
    fn momentum(&self, body: usize, v: &[T; D]) -> [T; D] {
        from_fn(|i| {
            let unit = from_fn(|k| T::from_f64(if k == i { 1.0 } else { 0.0 }));
            self.mass_product(body, &unit, v)
        })
    }
}

/// Steps of collocation methods, whose inner stages are solved together.
pub trait Collocation<N: Count, X, T: Scalar, const D: usize> {
    /// Allocates memory for a method of `stages` stages, so that steps need not.
    fn reserve(&self, bodies: &mut Bodies<N, T, X, D>, stages: usize);

    /// Takes one step of the collocation method with this table. `memory` is empty, or holds one number and, for each
    /// stage, f + Gᵀλ of each body and λ of each equation: then the iteration begins with the values of the last step.
    ///
    /// # Errors
    /// As [`drift`](crate::motion::system::System::drift).
    fn collocate<W: Witness<T>, const S: usize>(
        &self,
        table: &Table<S>,
        h: f64,
        bodies: &mut Bodies<N, T, X, D>,
        memory: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure>;
}

/// The motion as a power series in time.
pub trait Series<N: Count, X, T: Scalar, const D: usize> {
    /// Allocates memory for `orders` coefficients, so that steps of about `h` need not.
    fn reserve_series(&self, bodies: &mut Bodies<N, T, X, D>, orders: usize, h: f64);

    /// The unit in which coefficients measure time: near h, so that high ones do not overflow, and a power of two, so
    /// that none of their bits depends on it; or 1.
    #[inline(always)]
    fn unit(&self, _bodies: &Bodies<N, T, X, D>) -> f64 {
        1.0
    }

    /// Writes the power series of the motion in time, in this [unit](Self::unit), about the present state: q₀ of all
    /// bodies, q₁ of all, …, as many coefficients as `series` has room for. `witness` gets λ at the start. Neither
    /// allocates nor panics.
    fn expand<W: Witness<T>>(&self, bodies: &mut Bodies<N, T, X, D>, series: &mut [[T; D]], witness: &mut W);

    /// The change of a body's momentum in the time h after the last expansion; `None` where it is M times the change of
    /// its velocity.
    #[inline(always)]
    fn expanded_impulse(&self, _bodies: &Bodies<N, T, X, D>, _body: usize, _h: f64) -> Option<[T; D]> {
        None
    }

    /// The rate of a body's momentum at the time h after the last expansion; `None` as for its
    /// [change](Self::expanded_impulse).
    #[inline(always)]
    fn expanded_rate(&self, _bodies: &Bodies<N, T, X, D>, _body: usize, _h: f64) -> Option<[T; D]> {
        None
    }

    /// The work of moving constraints in the time h after the last expansion.
    #[inline(always)]
    fn expanded_work(&self, _bodies: &Bodies<N, T, X, D>, _h: f64) -> T {
        T::from_f64(0.0)
    }
}

/// A missing capability: a type without values.
#[derive(Debug, Clone, Copy)]
pub enum Never {}

impl<N: Count, X, T: Scalar, const D: usize> Rates<N, X, T, D> for Never {
    fn evaluate_rates<W: Witness<T>>(&self, _: &mut Bodies<N, T, X, D>, _: &mut [[T; D]], _: &mut W) -> T {
        match *self {}
    }
    fn project(&self, _: f64, _: &mut Bodies<N, T, X, D>) -> Result<(), Failure> {
        match *self {}
    }
    fn mass_product(&self, _: usize, _: &[T; D], _: &[T; D]) -> T {
        match *self {}
    }
}

impl<N: Count, X, T: Scalar, const D: usize> Collocation<N, X, T, D> for Never {
    fn reserve(&self, _: &mut Bodies<N, T, X, D>, _: usize) {
        match *self {}
    }
    fn collocate<W: Witness<T>, const S: usize>(
        &self,
        _: &Table<S>,
        _: f64,
        _: &mut Bodies<N, T, X, D>,
        _: &mut [T],
        _: &mut W,
    ) -> Result<(), Failure> {
        match *self {}
    }
}

impl<N: Count, X, T: Scalar, const D: usize> Series<N, X, T, D> for Never {
    fn reserve_series(&self, _: &mut Bodies<N, T, X, D>, _: usize, _: f64) {
        match *self {}
    }
    fn expand<W: Witness<T>>(&self, _: &mut Bodies<N, T, X, D>, _: &mut [[T; D]], _: &mut W) {
        match *self {}
    }
}
