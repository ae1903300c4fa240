//! Potentials that change with time: on each body, or on chosen bodies.

use crate::effect::moment::Moment;
use crate::effect::one::{Acting, Effect};
use crate::error::{Error, expect_variables, refuse_nan};
use crate::kernel::driven::{DrivenPotential, DrivenPotentialKernel};
use crate::kernel::over::Over;
use crate::number::lanes::Lane;
use crate::number::real::Real;
use std::array::from_fn;

/// The kind of effect of every [`DrivenPotential`]: on each body, and changing with time.
#[derive(Debug, Clone, Copy)]
pub struct Driven;

/// The kind of effect of a [`DrivenPotential`] [`Over`] chosen bodies, A at a time, of K = A·D coordinates.
#[derive(Debug, Clone, Copy)]
pub struct DrivenAmong<const K: usize, const A: usize>;

/// A potential of K = A·D coordinates and the time, over a scalar: over members of A bodies, or on each body.
#[derive(Debug, Clone)]
pub struct ActsDriven<X, const K: usize, const A: usize> {
    kernels: Vec<X>,
    /// None where it acts on each body by itself.
    members: Option<Vec<[usize; A]>>,
}

impl<P: DrivenPotential<D>, const D: usize> Effect<D, Driven> for P {
    type Acting<T: Real> = ActsDriven<P::Kernel<T>, D, 1>;
    fn acting<T: Real>(&self) -> Self::Acting<T> {
        ActsDriven { kernels: vec![self.kernel()], members: None }
    }

    type Swept<S: Lane, const L: usize> = [Self::Acting<S>; L];

    fn check(&self, what: &'static str, _: usize) -> Result<(), Error> {
        refuse_nan(what, self.nan_parameter())
    }
}

impl<P: DrivenPotential<K>, const D: usize, const K: usize, const A: usize> Effect<D, DrivenAmong<K, A>>
    for Over<P, A>
{
    type Acting<T: Real> = ActsDriven<P::Kernel<T>, K, A>;
    fn acting<T: Real>(&self) -> Self::Acting<T> {
        const { expect_variables(K, A, D, false) };
        let kernels = self.potentials.iter().map(P::kernel).collect();
        ActsDriven { kernels, members: Some(self.members.clone()) }
    }

    type Swept<S: Lane, const L: usize> = [Self::Acting<S>; L];

    fn check(&self, what: &'static str, bodies: usize) -> Result<(), Error> {
        self.check_each(what, bodies, P::nan_parameter)
    }
}

impl<X, const K: usize, const A: usize> ActsDriven<X, K, A> {
    /// Each member's kernel and bodies, and its variables.
    #[inline(always)]
    fn each<'a, T: Real, const D: usize>(
        &'a self,
        positions: &'a [[T; D]],
    ) -> impl Iterator<Item = (&'a X, [usize; A], [T; K])> + 'a {
        let number = self.members.as_ref().map_or(positions.len(), Vec::len);
        (0..number).map(move |i| {
            let member = self.members.as_ref().map_or([i; A], |members| members[i]);
            let kernel = &self.kernels[if self.kernels.len() == 1 { 0 } else { i }];
            (kernel, member, from_fn(|k| positions[member[k / D]][k % D]))
        })
    }
}

impl<T: Real, X: DrivenPotentialKernel<T, K>, const D: usize, const K: usize, const A: usize> Acting<T, D>
    for ActsDriven<X, K, A>
{
    type Room = ();
    fn room(&self, _: usize) {}

    #[inline(always)]
    fn changes_with_time(&self) -> bool {
        true
    }
    fn add_forces(&self, at: Moment<'_, T, D>, (): &mut (), forces: &mut [[T; D]]) {
        let time = T::from_f64(at.time);
        for (kernel, member, q) in self.each(at.positions) {
            let gradient = kernel.gradient(&q, time);
            for (a, &body) in member.iter().enumerate() {
                forces[body] = from_fn(|d| forces[body][d] - gradient[a * D + d]);
            }
        }
    }
    fn energy(&self, at: Moment<'_, T, D>) -> T {
        let time = T::from_f64(at.time);
        let energies = self.each(at.positions).map(|(kernel, _, q)| kernel.value(&q, time));
        energies.fold(T::from_f64(-0.0), |sum, energy| sum + energy)
    }
    fn power(&self, at: Moment<'_, T, D>) -> T {
        let time = T::from_f64(at.time);
        let rates = self.each(at.positions).map(|(kernel, _, q)| kernel.rate(&q, time));
        rates.fold(T::from_f64(0.0), |sum, rate| sum + rate)
    }
}
