//! The traits of the functions that macros write: functions of few variables, with their derivatives.
//!
//! A type such as `Lemniscate { a, r }` holds parameters and implements [`Constraint`]. Its *kernel* is the same
//! function for a scalar type `T`, with everything that depends on parameters alone computed once. Simulations use the
//! kernel; users call the methods of the type.
//!
//! ```text
//! g : ℝᴰ → ℝᴹ      q̈ = −∇U(q) + G(q)ᵀλ,   G = ∂g/∂q  (M × D),   g(q) = 0
//! ```

use crate::kernel::over::Over;
use crate::kernel::series::Order;
use crate::kernel::within::Within;
use crate::number::real::Real;
use nalgebra::{SMatrix, SVector};

/// M equations g(q) = 0 between D coordinates, with derivatives. Written by `constraint!`.
///
/// **Kinks.** Where g has `abs`, `sign`, `min`, `max`, `if` or `cbrt`, its derivatives may jump. A step across a point
/// where the normal ∇g/|∇g| jumps fails with [`StepFailure::Kink`](crate::error::StepFailure::Kink), since Newton's
/// laws do not determine the momentum after it. Where only the curvature jumps, as for `abs(x)^3` or `max(x, 0)^2`,
/// steps succeed, but are less accurate than the order of the method says. Kinks of *potentials* are no errors: where a
/// force jumps the motion is well defined, and energy is conserved to first order in the step.
pub trait Constraint<const D: usize, const M: usize>: Sized + 'static {
    /// The functions, ready for the scalar `T`.
    type Kernel<T: Real>: ConstraintKernel<T, D, M>;

    /// The kernel in which lane i has the parameters of `lane(i)`: a sweep over parameters, side by side.
    fn kernel_of_lanes<'a, T: Real>(lane: impl Fn(usize) -> &'a Self) -> Self::Kernel<T>
    where
        Self: 'a;

    /// The kernel with `number` of each of its numbers, in the same order each time; of a kernel of lanes, for example,
    /// that of one lane by itself.
    ///
    /// ```text
    /// let lane = |i| C::map_kernel(&kernel, |lanes: &Lanes<f64, 8>| lanes.0[i]);      // Kernel<f64>
    /// ```
    fn map_kernel<T: Real, U: Real>(kernel: &Self::Kernel<T>, number: impl Fn(&T) -> U) -> Self::Kernel<U>;

    /// The name of a parameter that is NaN, if one is. Scenes refuse that: comparisons with NaN, in `if` and `max`, are
    /// false, so that a function may have values all the same.
    fn nan_parameter(&self) -> Option<&'static str> {
        None
    }

    /// The kernel with this value's parameters, in every lane.
    fn kernel<T: Real>(&self) -> Self::Kernel<T> {
        Self::kernel_of_lanes(|_| self)
    }

    /// g(q): zero on the constraint; bit for bit the expression as written.
    fn value(&self, q: &SVector<f64, D>) -> SVector<f64, M> {
        self.kernel::<f64>().value(&coordinates(q)).into()
    }
    /// G(q) = ∂g/∂q; row i is ∇gᵢ.
    fn jacobian(&self, q: &SVector<f64, D>) -> SMatrix<f64, M, D> {
        matrix(self.kernel::<f64>().jacobian(&coordinates(q)))
    }
    /// g(q) and G(q), sharing their subexpressions.
    fn value_and_jacobian(&self, q: &SVector<f64, D>) -> (SVector<f64, M>, SMatrix<f64, M, D>) {
        let (g, jacobian) = self.kernel::<f64>().value_and_jacobian(&coordinates(q));
        (g.into(), matrix(jacobian))
    }
    /// ∇²g(q) v; row i is vᵀ∇²gᵢ.
    fn hessian_vector(&self, q: &SVector<f64, D>, v: &SVector<f64, D>) -> SMatrix<f64, M, D> {
        matrix(self.kernel::<f64>().hessian_vector(&coordinates(q), &coordinates(v)))
    }
    /// (g, ġ, g̈) along the straight line q + t v: g, G v and vᵀ∇²g v.
    fn jet(
        &self,
        q: &SVector<f64, D>,
        v: &SVector<f64, D>,
    ) -> (SVector<f64, M>, SVector<f64, M>, SVector<f64, M>) {
        let (g, dg, ddg) = self.kernel::<f64>().jet(&coordinates(q), &coordinates(v));
        (g.into(), dg.into(), ddg.into())
    }
    /// ∇²gᵢ(q), one matrix for each equation.
    fn hessian(&self, q: &SVector<f64, D>) -> [SMatrix<f64, D, D>; M] {
        self.kernel::<f64>().hessian(&coordinates(q)).map(matrix)
    }
    /// Σ λᵢ ∇²gᵢ(q) v.
    fn weighted_hessian_vector(
        &self,
        q: &SVector<f64, D>,
        weights: &SVector<f64, M>,
        v: &SVector<f64, D>,
    ) -> SVector<f64, D> {
        let weights = coordinates(weights);
        self.kernel::<f64>().weighted_hessian_vector(&coordinates(q), &weights, &coordinates(v)).into()
    }
}

/// The functions of a [`Constraint`] over the scalar `T`.
pub trait ConstraintKernel<T: Real, const D: usize, const M: usize>: Clone + Send + Sync + 'static {
    /// g(q).
    fn value(&self, q: &[T; D]) -> [T; M];
    /// ∂g/∂q, row i is ∇gᵢ.
    fn jacobian(&self, q: &[T; D]) -> [[T; D]; M] {
        self.value_and_jacobian(q).1
    }
    /// g and ∂g/∂q.
    fn value_and_jacobian(&self, q: &[T; D]) -> ([T; M], [[T; D]; M]);
    /// Row i is vᵀ∇²gᵢ.
    fn hessian_vector(&self, q: &[T; D], v: &[T; D]) -> [[T; D]; M];
    /// g, G v and vᵀ∇²g v.
    #[allow(clippy::type_complexity, reason = "three values of one shape")]
    fn jet(&self, q: &[T; D], v: &[T; D]) -> ([T; M], [T; M], [T; M]);
    /// ∇²gᵢ for each i.
    fn hessian(&self, q: &[T; D]) -> [[[T; D]; D]; M] {
        let zero = T::from_f64(0.0);
        let mut hessian = [[[zero; D]; D]; M];
        for k in 0..D {
            let mut unit = [zero; D];
            unit[k] = T::from_f64(1.0);
            let columns = self.hessian_vector(q, &unit);
            for (matrix, column) in hessian.iter_mut().zip(columns) {
                matrix[k] = column; // symmetric: a column is a row
            }
        }
        hessian
    }
    /// Σ λᵢ ∇²gᵢ v.
    fn weighted_hessian_vector(&self, q: &[T; D], weights: &[T; M], v: &[T; D]) -> [T; D] {
        let mut sum = [T::from_f64(0.0); D];
        for (row, &weight) in self.hessian_vector(q, v).iter().zip(weights) {
            for (total, &entry) in sum.iter_mut().zip(row) {
                *total = *total + weight * entry;
            }
        }
        sum
    }

    /// The number of blocks of [products](crate::kernel::series) that [`jacobian_series`](Self::jacobian_series) needs;
    /// `None` where the macro wrote no series: for functions of more than 2000 operations.
    #[inline(always)]
    fn series(&self) -> Option<usize> {
        None
    }
    /// The next coefficient of the power series of ∂g/∂q along a curve q(t), from that of q; lower ones are known.
    fn jacobian_series<const FIRST: bool>(
        &self,
        _q: &[T; D],
        _order: &mut Order<'_, T, FIRST>,
    ) -> [[T; D]; M] {
        [[T::from_f64(f64::NAN); D]; M]
    }

    /// The terms that change sign where g is not smooth, as text: the arguments of `abs`, `sign` and `cbrt`, the
    /// differences that `min`, `max` and `if` compare, y of `atan2(y, x)`, and what `atan` and other bounded functions
    /// divide by. Edges where the argument of a root touches zero are listed for a² + c alone, with c that stays.
    const KINKS: &'static [&'static str] = &[];

    /// The values of the terms [`KINKS`](Self::KINKS) from number `first` on, as many as `found` has room for. If one
    /// changes sign between two points, g may have a kink between them.
    ///
    /// ```
    /// use rattle::{kernel::ConstraintKernel, prelude::*};
    /// constraint! { struct Roof {} |x, _y, z| z + abs(x) }
    ///
    /// let right_of_the_ridge = |q: [f64; 3]| {
    ///     let mut found = [0.0];
    ///     Roof {}.kernel().kinks(&q, 0, &mut found);
    ///     found[0] > 0.0
    /// };
    /// assert!(right_of_the_ridge([0.1, 0.0, -0.1]) && !right_of_the_ridge([-0.1, 0.0, -0.1]));
    /// ```
    #[inline(always)]
    fn kinks(&self, _q: &[T; D], _first: usize, _found: &mut [T]) {}
}

/// A potential energy U(q) of one body with D coordinates. Written by `potential!`.
pub trait Potential<const D: usize>: Sized {
    /// The functions, ready for the scalar `T`.
    type Kernel<T: Real>: PotentialKernel<T, D>;

    /// The kernel in which lane i has the parameters of `lane(i)`: a sweep over parameters, side by side.
    fn kernel_of_lanes<'a, T: Real>(lane: impl Fn(usize) -> &'a Self) -> Self::Kernel<T>
    where
        Self: 'a;

    /// The kernel with `number` of each of its numbers, in the same order each time; of a kernel of lanes, for example,
    /// that of one lane by itself.
    ///
    /// ```text
    /// let lane = |i| C::map_kernel(&kernel, |lanes: &Lanes<f64, 8>| lanes.0[i]);      // Kernel<f64>
    /// ```
    fn map_kernel<T: Real, U: Real>(kernel: &Self::Kernel<T>, number: impl Fn(&T) -> U) -> Self::Kernel<U>;

    /// The name of a parameter that is NaN, if one is. Scenes refuse that: comparisons with NaN, in `if` and `max`, are
    /// false, so that a function may have values all the same.
    fn nan_parameter(&self) -> Option<&'static str> {
        None
    }

    /// The kernel with this value's parameters, in every lane.
    fn kernel<T: Real>(&self) -> Self::Kernel<T> {
        Self::kernel_of_lanes(|_| self)
    }

    /// U(q).
    fn value(&self, q: &SVector<f64, D>) -> f64 {
        self.kernel::<f64>().value(&coordinates(q))
    }
    /// ∇U(q); the force is its negative.
    fn gradient(&self, q: &SVector<f64, D>) -> SVector<f64, D> {
        self.kernel::<f64>().gradient(&coordinates(q)).into()
    }

    /// The potential as an [effect](crate::kernel::over::Over) on chosen bodies, or between them: its variables are the
    /// coordinates of the bodies of a member, one after the other.
    fn over<const A: usize>(self, members: impl IntoIterator<Item = [usize; A]>) -> Over<Self, A> {
        Over::new(self, members)
    }
}

/// The functions of a [`Potential`] over the scalar `T`.
pub trait PotentialKernel<T: Real, const D: usize>: Clone + Send + Sync + 'static {
    /// Which components of ∇U can be other than zero.
    #[inline(always)]
    fn acts_along(&self) -> [bool; D] {
        [true; D]
    }

    /// U(q).
    fn value(&self, q: &[T; D]) -> T;
    /// ∇U(q).
    fn gradient(&self, q: &[T; D]) -> [T; D];

    /// The number of blocks of [products](crate::kernel::series) that [`gradient_series`](Self::gradient_series) needs;
    /// `None` without a series.
    #[inline(always)]
    fn series(&self) -> Option<usize> {
        None
    }
    /// The next coefficient of the power series of ∇U along a curve q(t), from that of q; lower ones are known.
    fn gradient_series<const FIRST: bool>(&self, _q: &[T; D], _order: &mut Order<'_, T, FIRST>) -> [T; D] {
        [T::from_f64(f64::NAN); D]
    }
}

/// A potential energy U(r) of two bodies at distance r. Written by `pair_potential!`.
///
/// U is evaluated as a function of s = r², so that an even potential needs no root and has no 0/0 at r = 0. The force
/// on body i is −2 dU/ds (qᵢ − qⱼ): repulsive where U falls with distance.
pub trait PairPotential: Sized {
    /// The functions, ready for the scalar `T`.
    type Kernel<T: Real>: PairKernel<T>;

    /// The kernel in which lane i has the parameters of `lane(i)`: a sweep over parameters, side by side.
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

    /// U(r).
    fn value(&self, r: f64) -> f64 {
        self.kernel::<f64>().value(r * r)
    }
    /// U′(r)/r = 2 dU/d(r²): finite at r = 0 for an even potential.
    fn slope_over_distance(&self, r: f64) -> f64 {
        2.0 * self.kernel::<f64>().slope(r * r)
    }

    /// The potential with the cut-off distance `reach`: zero between bodies farther apart. Use it for many bodies,
    /// since the cost is proportional to the number of near pairs. See [`Within`] for the behaviour at the cut-off.
    ///
    /// ```
    /// use rattle::potentials::LennardJones;
    /// use rattle::prelude::*;
    ///
    /// let gas = Scene::points(3).with(LennardJones { epsilon: 1.0, sigma: 1.0 }.within(2.5));
    /// let start = State::of([[0.0, 0.0], [1.1, 0.0], [9.0, 0.0]]); // the third is out of reach
    /// let simulation = gas.simulate(start, Rattle::new(1e-3))?;
    /// assert_eq!(simulation.energy(), LennardJones { epsilon: 1.0, sigma: 1.0 }.value(1.1));
    /// # Ok::<(), rattle::Error>(())
    /// ```
    fn within(self, reach: f64) -> Within<Self> {
        Within::new(self, reach, |of, r| [of.value(r), r * of.slope_over_distance(r)])
    }
}

/// The functions of a [`PairPotential`] over the scalar `T`.
pub trait PairKernel<T: Real>: Clone + Send + Sync + 'static {
    /// U at s = r².
    fn value(&self, s: T) -> T;
    /// dU/ds at s = r².
    fn slope(&self, s: T) -> T;
    /// Replaces each s of a block by dU/ds, for forces between many bodies.
    #[inline(always)]
    fn slope_block<const L: usize>(&self, s: &mut [T; L]) {
        // A loop over few is unrolled, also where the slope is long: several pairs are in flight then.
        let (chunks, rest) = s.as_chunks_mut::<32>();
        for chunk in chunks {
            for s in chunk {
                *s = self.slope(*s);
            }
        }
        for s in rest {
            *s = self.slope(*s);
        }
    }

    /// The number of blocks of [products](crate::kernel::series) that [`slope_series`](Self::slope_series) needs;
    /// `None` without a series.
    #[inline(always)]
    fn series(&self) -> Option<usize> {
        None
    }
    /// The next coefficient of the power series of dU/ds in time, from that of s; lower ones are known.
    fn slope_series<const FIRST: bool>(&self, _s: T, _order: &mut Order<'_, T, FIRST>) -> T {
        T::from_f64(f64::NAN)
    }
}

/// An energy H(q, p) with D degrees of freedom. Written by `hamiltonian!`.
///
/// ```text
/// q̇ = ∂H/∂p      ṗ = −∂H/∂q
/// ```
pub trait Hamiltonian<const D: usize>: Sized {
    /// The functions, ready for the scalar `T`.
    type Kernel<T: Real>: HamiltonianKernel<T, D>;

    /// The kernel in which lane i has the parameters of `lane(i)`: a sweep over parameters, side by side.
    fn kernel_of_lanes<'a, T: Real>(lane: impl Fn(usize) -> &'a Self) -> Self::Kernel<T>
    where
        Self: 'a;

    /// The kernel with `number` of each of its numbers, in the same order each time; of a kernel of lanes, for example,
    /// that of one lane by itself.
    fn map_kernel<T: Real, U: Real>(kernel: &Self::Kernel<T>, number: impl Fn(&T) -> U) -> Self::Kernel<U>;

    /// The name of a parameter that is NaN, if one is. Scenes refuse that: comparisons with NaN, in `if` and `max`, are
    /// false, so that a function may have values all the same.
    fn nan_parameter(&self) -> Option<&'static str> {
        None
    }

    /// The kernel with this value's parameters, in every lane.
    fn kernel<T: Real>(&self) -> Self::Kernel<T> {
        Self::kernel_of_lanes(|_| self)
    }

    /// H(q, p).
    fn value(&self, q: &SVector<f64, D>, p: &SVector<f64, D>) -> f64 {
        self.kernel::<f64>().value(&coordinates(q), &coordinates(p))
    }
    /// (∂H/∂q, ∂H/∂p).
    fn gradients(&self, q: &SVector<f64, D>, p: &SVector<f64, D>) -> (SVector<f64, D>, SVector<f64, D>) {
        let (by_q, by_p) = self.kernel::<f64>().gradients(&coordinates(q), &coordinates(p));
        (by_q.into(), by_p.into())
    }
}

/// The functions of a [`Hamiltonian`] over the scalar `T`.
pub trait HamiltonianKernel<T: Real, const D: usize>: Clone + Send + Sync + 'static {
    /// H(q, p).
    fn value(&self, q: &[T; D], p: &[T; D]) -> T;
    /// ∂H/∂q and ∂H/∂p.
    fn gradients(&self, q: &[T; D], p: &[T; D]) -> ([T; D], [T; D]);
    /// The two halves of ∇²H (dq, dp).
    fn hessian_vector(&self, q: &[T; D], p: &[T; D], dq: &[T; D], dp: &[T; D]) -> ([T; D], [T; D]);
}

/// M equations g(q, p) = 0 in phase space. Written by `phase_constraint!`.
pub trait PhaseConstraint<const D: usize, const M: usize>: Sized {
    /// The functions, ready for the scalar `T`.
    type Kernel<T: Real>: PhaseConstraintKernel<T, D, M>;

    /// The kernel in which lane i has the parameters of `lane(i)`: a sweep over parameters, side by side.
    fn kernel_of_lanes<'a, T: Real>(lane: impl Fn(usize) -> &'a Self) -> Self::Kernel<T>
    where
        Self: 'a;

    /// The kernel with `number` of each of its numbers, in the same order each time; of a kernel of lanes, for example,
    /// that of one lane by itself.
    fn map_kernel<T: Real, U: Real>(kernel: &Self::Kernel<T>, number: impl Fn(&T) -> U) -> Self::Kernel<U>;

    /// The name of a parameter that is NaN, if one is. Scenes refuse that: comparisons with NaN, in `if` and `max`, are
    /// false, so that a function may have values all the same.
    fn nan_parameter(&self) -> Option<&'static str> {
        None
    }

    /// The kernel with this value's parameters, in every lane.
    fn kernel<T: Real>(&self) -> Self::Kernel<T> {
        Self::kernel_of_lanes(|_| self)
    }

    /// g(q, p).
    fn value(&self, q: &SVector<f64, D>, p: &SVector<f64, D>) -> SVector<f64, M> {
        self.kernel::<f64>().value(&coordinates(q), &coordinates(p)).into()
    }
    /// (∂g/∂q, ∂g/∂p); row i belongs to gᵢ.
    fn jacobians(
        &self,
        q: &SVector<f64, D>,
        p: &SVector<f64, D>,
    ) -> (SMatrix<f64, M, D>, SMatrix<f64, M, D>) {
        let (by_q, by_p) = self.kernel::<f64>().jacobians(&coordinates(q), &coordinates(p));
        (matrix(by_q), matrix(by_p))
    }
}

/// The functions of a [`PhaseConstraint`] over the scalar `T`.
#[allow(clippy::type_complexity, reason = "tuples of arrays of one shape")]
pub trait PhaseConstraintKernel<T: Real, const D: usize, const M: usize>:
    Clone + Send + Sync + 'static
{
    /// g(q, p).
    fn value(&self, q: &[T; D], p: &[T; D]) -> [T; M];
    /// ∂g/∂q and ∂g/∂p.
    fn jacobians(&self, q: &[T; D], p: &[T; D]) -> ([[T; D]; M], [[T; D]; M]);
    /// g, ∂g/∂q and ∂g/∂p.
    fn value_and_jacobians(&self, q: &[T; D], p: &[T; D]) -> ([T; M], [[T; D]; M], [[T; D]; M]);
    /// Row i holds the two halves of ∇²gᵢ (dq, dp).
    fn hessian_vector(&self, q: &[T; D], p: &[T; D], dq: &[T; D], dp: &[T; D]) -> ([[T; D]; M], [[T; D]; M]);

    /// What changes its sign where ∇g may jump, as [`ConstraintKernel::KINKS`].
    const KINKS: &'static [&'static str] = &[];

    /// The values of these, as [`ConstraintKernel::kinks`].
    #[inline(always)]
    fn kinks(&self, _q: &[T; D], _p: &[T; D], _first: usize, _found: &mut [T]) {}
}

fn coordinates<const D: usize>(v: &SVector<f64, D>) -> [f64; D] {
    (*v).into()
}

fn matrix<const D: usize, const M: usize>(rows: [[f64; D]; M]) -> SMatrix<f64, M, D> {
    SMatrix::from_fn(|i, j| rows[i][j])
}
