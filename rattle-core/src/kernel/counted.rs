//! Counting the evaluations of a function in a run.

use crate::kernel::functions::{Constraint, ConstraintKernel, Potential, PotentialKernel};
use crate::kernel::series::Order;
use crate::number::real::Real;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// A constraint or potential that counts how often it is evaluated.
///
/// ```
/// # use rattle::{Counted, kernel::Potential, kernel::PotentialKernel, real::Real};
/// # #[derive(Clone)] struct Flat;
/// # impl Potential<1> for Flat {
/// #     type Kernel<T: Real> = Flat;
/// #     fn kernel_of_lanes<'a, T: Real>(_: impl Fn(usize) -> &'a Self) -> Flat where Self: 'a { Flat }
/// #     fn map_kernel<T: Real, U: Real>(_: &Flat, _: impl Fn(&T) -> U) -> Flat { Flat }
/// # }
/// # impl<T: Real> PotentialKernel<T, 1> for Flat {
/// #     fn value(&self, q: &[T; 1]) -> T { q[0] }
/// #     fn gradient(&self, _: &[T; 1]) -> [T; 1] { [T::from_f64(1.0)] }
/// # }
/// let potential = Counted::new(Flat);
/// let counts = potential.counts();
/// Potential::gradient(&potential, &[2.0].into());
/// assert_eq!((counts.values(), counts.gradients()), (0, 1));
/// ```
#[doc(alias = "profile")]
#[doc(alias = "evaluations")]
#[derive(Debug, Clone)]
pub struct Counted<X> {
    inner: X,
    counts: Counts,
}

/// How often each function was evaluated, by all copies of a kernel together; for power series, the number of
/// coefficients. Where lanes have parameters of their own, evaluations of all lanes of a group count for the function
/// of the first.
#[derive(Debug, Clone, Default)]
pub struct Counts(Arc<[AtomicU64; 4]>);

impl<X> Counted<X> {
    /// `inner`, counted from zero.
    pub fn new(inner: X) -> Self {
        Self { inner, counts: Counts::default() }
    }

    /// The counts, which continue while `self` is in use.
    pub fn counts(&self) -> Counts {
        self.counts.clone()
    }
}

impl Counts {
    /// Evaluations of the function itself, alone or together with its gradient.
    #[must_use]
    pub fn values(&self) -> u64 {
        self.0[0].load(Relaxed)
    }
    /// Evaluations of the gradient, alone or together with the function.
    #[must_use]
    pub fn gradients(&self) -> u64 {
        self.0[1].load(Relaxed)
    }
    /// Evaluations of second derivatives.
    #[must_use]
    pub fn curvatures(&self) -> u64 {
        self.0[2].load(Relaxed)
    }
    /// Coefficients of the power series of the gradient.
    #[must_use]
    pub fn coefficients(&self) -> u64 {
        self.0[3].load(Relaxed)
    }
    /// All evaluations, and coefficients.
    #[must_use]
    pub fn all(&self) -> u64 {
        self.0.iter().map(|count| count.load(Relaxed)).sum()
    }
    /// Starts counting from zero again.
    pub fn reset(&self) {
        self.0.iter().for_each(|count| count.store(0, Relaxed));
    }

    fn add(&self, value: bool, gradient: bool, curvature: bool) {
        for (count, evaluated) in self.0.iter().zip([value, gradient, curvature]) {
            count.fetch_add(u64::from(evaluated), Relaxed);
        }
    }
}

impl<C: Constraint<D, M>, const D: usize, const M: usize> Constraint<D, M> for Counted<C> {
    type Kernel<T: Real> = Counted<C::Kernel<T>>;
    fn kernel_of_lanes<'a, T: Real>(lane: impl Fn(usize) -> &'a Self) -> Self::Kernel<T>
    where
        Self: 'a,
    {
        let counts = lane(0).counts.clone();
        Counted { inner: C::kernel_of_lanes(|i| &lane(i).inner), counts }
    }
    fn map_kernel<T: Real, U: Real>(kernel: &Self::Kernel<T>, number: impl Fn(&T) -> U) -> Self::Kernel<U> {
        Counted { inner: C::map_kernel(&kernel.inner, number), counts: kernel.counts.clone() }
    }
    fn nan_parameter(&self) -> Option<&'static str> {
        self.inner.nan_parameter()
    }
}

impl<T: Real, K: ConstraintKernel<T, D, M>, const D: usize, const M: usize> ConstraintKernel<T, D, M>
    for Counted<K>
{
    fn value(&self, q: &[T; D]) -> [T; M] {
        self.counts.add(true, false, false);
        self.inner.value(q)
    }
    fn jacobian(&self, q: &[T; D]) -> [[T; D]; M] {
        self.counts.add(false, true, false);
        self.inner.jacobian(q)
    }
    fn value_and_jacobian(&self, q: &[T; D]) -> ([T; M], [[T; D]; M]) {
        self.counts.add(true, true, false);
        self.inner.value_and_jacobian(q)
    }
    fn hessian_vector(&self, q: &[T; D], v: &[T; D]) -> [[T; D]; M] {
        self.counts.add(false, false, true);
        self.inner.hessian_vector(q, v)
    }
    fn jet(&self, q: &[T; D], v: &[T; D]) -> ([T; M], [T; M], [T; M]) {
        self.counts.add(false, false, true);
        self.inner.jet(q, v)
    }
    fn hessian(&self, q: &[T; D]) -> [[[T; D]; D]; M] {
        self.counts.add(false, false, true);
        self.inner.hessian(q)
    }
    fn weighted_hessian_vector(&self, q: &[T; D], weights: &[T; M], v: &[T; D]) -> [T; D] {
        self.counts.add(false, false, true);
        self.inner.weighted_hessian_vector(q, weights, v)
    }

    const KINKS: &'static [&'static str] = K::KINKS;
    fn kinks(&self, q: &[T; D], first: usize, found: &mut [T]) {
        self.inner.kinks(q, first, found);
    }
    fn series(&self) -> Option<usize> {
        self.inner.series()
    }
    fn jacobian_series<const FIRST: bool>(&self, q: &[T; D], order: &mut Order<'_, T, FIRST>) -> [[T; D]; M] {
        self.counts.0[3].fetch_add(1, Relaxed);
        self.inner.jacobian_series(q, order)
    }
}

impl<P: Potential<D>, const D: usize> Potential<D> for Counted<P> {
    type Kernel<T: Real> = Counted<P::Kernel<T>>;
    fn kernel_of_lanes<'a, T: Real>(lane: impl Fn(usize) -> &'a Self) -> Self::Kernel<T>
    where
        Self: 'a,
    {
        let counts = lane(0).counts.clone();
        Counted { inner: P::kernel_of_lanes(|i| &lane(i).inner), counts }
    }
    fn map_kernel<T: Real, U: Real>(kernel: &Self::Kernel<T>, number: impl Fn(&T) -> U) -> Self::Kernel<U> {
        Counted { inner: P::map_kernel(&kernel.inner, number), counts: kernel.counts.clone() }
    }
    fn nan_parameter(&self) -> Option<&'static str> {
        self.inner.nan_parameter()
    }
}

impl<T: Real, K: PotentialKernel<T, D>, const D: usize> PotentialKernel<T, D> for Counted<K> {
    fn acts_along(&self) -> [bool; D] {
        self.inner.acts_along()
    }
    fn value(&self, q: &[T; D]) -> T {
        self.counts.add(true, false, false);
        self.inner.value(q)
    }
    fn gradient(&self, q: &[T; D]) -> [T; D] {
        self.counts.add(false, true, false);
        self.inner.gradient(q)
    }

    fn series(&self) -> Option<usize> {
        self.inner.series()
    }
    fn gradient_series<const FIRST: bool>(&self, q: &[T; D], order: &mut Order<'_, T, FIRST>) -> [T; D] {
        self.counts.0[3].fetch_add(1, Relaxed);
        self.inner.gradient_series(q, order)
    }
}
