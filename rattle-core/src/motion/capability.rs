//! What some systems can do beyond the verbs of every [`System`](crate::motion::system::System); [`Never`] stands where
//! one cannot.
//!
//! A method reaches these through its [`need`](crate::motion::need): who has the object has been told that the system
//! has the capability, so that no step is asked for what there is not.

use crate::motion::bodies::{Bodies, Count};
use crate::motion::failure::Failure;
use crate::motion::table::Table;
use crate::motion::witness::Witness;
use crate::number::real::Real;
use std::array::from_fn;

/// Rates of change, and a way back onto the constraints: forces and momenta are apart, and masses measure distances.
pub trait Rates<N: Count, X, T: Real, const D: usize> {
    /// Writes ṗ = f + Gᵀλ of each body, with λ such that g̈ = 0, at the present places and from what is kept there.
    /// Places and momenta may be a little off the constraints. Returns the power of moving constraints, −λᵀ ∂g/∂t.
    /// `witness` is told λ as that of the start of a step. Neither allocates nor panics.
    fn evaluate_rates<W: Witness<T>>(
        &self,
        bodies: &mut Bodies<N, T, X, D>,
        rates: &mut [[T; D]],
        witness: &mut W,
    ) -> T;

    /// Moves positions that a time `h` has brought a little off the constraints back to them, the least way as masses
    /// measure it, to rounding; evaluates there what is kept. Momenta stay;
    /// [`settle`](crate::motion::system::System::settle) with kick 0 moves them. Neither allocates nor panics.
    ///
    /// # Errors
    /// As [`drift`](crate::motion::system::System::drift); where the iteration does not come nearer to the constraints.
    fn project(&self, h: f64, bodies: &mut Bodies<N, T, X, D>) -> Result<(), Failure>;

    /// aᵀM b, for changes of position of a body; 0 for one that is pinned.
    fn mass_product(&self, body: usize, a: &[T; D], b: &[T; D]) -> T;

    /// M v of a body; 0 for one that is pinned.
    fn momentum(&self, body: usize, v: &[T; D]) -> [T; D] {
        from_fn(|i| {
            let unit = from_fn(|k| T::from_f64(if k == i { 1.0 } else { 0.0 }));
            self.mass_product(body, &unit, v)
        })
    }
}

/// Inner stages solved together.
pub trait Collocation<N: Count, X, T: Real, const D: usize> {
    /// Makes room for a method of so many stages, so that its steps need not allocate.
    fn reserve(&self, bodies: &mut Bodies<N, T, X, D>, stages: usize);

    /// Takes one step of the collocation method with this table. `memory` is empty, or has room for a number and, for
    /// each stage, f + Gᵀλ of each body and λ of each equation: the iteration then begins with what the last step left
    /// there.
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
pub trait Series<N: Count, X, T: Real, const D: usize> {
    /// Makes room for so many coefficients, so that steps need not allocate.
    fn reserve_series(&self, bodies: &mut Bodies<N, T, X, D>, orders: usize);

    /// Writes the power series of the motion in time from the present state on, into as many coefficients as there is
    /// room for: q₀ of all bodies, q₁ of all, … `witness` is told λ at the start. Neither allocates nor panics.
    fn expand<W: Witness<T>>(&self, bodies: &mut Bodies<N, T, X, D>, series: &mut [[T; D]], witness: &mut W);

    /// The change of a body's momentum in a time h from where the motion was expanded last; none where it is M times
    /// the change of its velocity.
    #[inline(always)]
    fn expanded_impulse(&self, _bodies: &Bodies<N, T, X, D>, _body: usize, _h: f64) -> Option<[T; D]> {
        None
    }

    /// The work that moving constraints do in a time h from where the motion was expanded last.
    #[inline(always)]
    fn expanded_work(&self, _bodies: &Bodies<N, T, X, D>, _h: f64) -> T {
        T::from_f64(0.0)
    }
}

/// A capability that a system has not: there is no such object.
#[derive(Debug, Clone, Copy)]
pub enum Never {}

impl<N: Count, X, T: Real, const D: usize> Rates<N, X, T, D> for Never {
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

impl<N: Count, X, T: Real, const D: usize> Collocation<N, X, T, D> for Never {
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

impl<N: Count, X, T: Real, const D: usize> Series<N, X, T, D> for Never {
    fn reserve_series(&self, _: &mut Bodies<N, T, X, D>, _: usize) {
        match *self {}
    }
    fn expand<W: Witness<T>>(&self, _: &mut Bodies<N, T, X, D>, _: &mut [[T; D]], _: &mut W) {
        match *self {}
    }
}
