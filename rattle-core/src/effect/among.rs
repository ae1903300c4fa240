//! A potential over chosen bodies, several at a time.

use crate::effect::moment::Moment;
use crate::effect::one::{Acting, Effect};
use crate::error::{Error, expect_variables};
use crate::kernel::functions::{Potential, PotentialKernel};
use crate::kernel::over::Over;
use crate::kernel::series::Order;
use crate::number::lanes::Lane;
use crate::number::real::Real;
use std::array::from_fn;

/// The kind of effect of a potential [`Over`] chosen bodies, A at a time, of K = A·D variables.
#[derive(Debug, Clone, Copy)]
pub struct Among<const K: usize, const A: usize>;

/// A potential of K = A·D variables over members of A bodies, over a scalar.
#[derive(Debug, Clone)]
pub struct ActsAmong<X, const K: usize, const A: usize> {
    kernels: Vec<X>,
    members: Vec<[usize; A]>,
}

impl<P: Potential<K>, const D: usize, const K: usize, const A: usize> Effect<D, Among<K, A>> for Over<P, A> {
    type Acting<T: Real> = ActsAmong<P::Kernel<T>, K, A>;

    fn acting<T: Real>(&self) -> Self::Acting<T> {
        const { expect_variables(K, A, D, false) };
        ActsAmong { kernels: self.potentials.iter().map(P::kernel).collect(), members: self.members.clone() }
    }

    type Swept<S: Lane, const L: usize> = [Self::Acting<S>; L];

    fn check(&self, what: &'static str, bodies: usize) -> Result<(), Error> {
        self.check_each(what, bodies, P::nan_parameter)
    }
}

impl<X, const K: usize, const A: usize> ActsAmong<X, K, A> {
    #[inline(always)]
    fn kernel(&self, member: usize) -> &X {
        &self.kernels[if self.kernels.len() == 1 { 0 } else { member }]
    }

    /// Each member's kernel and bodies, and its variables.
    #[inline(always)]
    fn each<'a, T: Real, const D: usize>(
        &'a self,
        positions: &'a [[T; D]],
    ) -> impl Iterator<Item = (&'a X, &'a [usize; A], [T; K])> + 'a {
        let members = self.members.iter().enumerate();
        members.map(|(i, member)| (self.kernel(i), member, from_fn(|k| positions[member[k / D]][k % D])))
    }
}

impl<T: Real, X: PotentialKernel<T, K>, const D: usize, const K: usize, const A: usize> Acting<T, D>
    for ActsAmong<X, K, A>
{
    type Room = ();
    fn room(&self, _: usize) {}

    fn add_forces(&self, at: Moment<'_, T, D>, (): &mut (), forces: &mut [[T; D]]) {
        for (kernel, member, variables) in self.each(at.positions) {
            let gradient = kernel.gradient(&variables);
            for (a, &body) in member.iter().enumerate() {
                forces[body] = from_fn(|d| forces[body][d] - gradient[a * D + d]);
            }
        }
    }
    fn energy(&self, at: Moment<'_, T, D>) -> T {
        let energies = self.each(at.positions).map(|(kernel, _, variables)| kernel.value(&variables));
        energies.fold(T::from_f64(-0.0), |sum, energy| sum + energy)
    }
    fn series_blocks(&self, _: usize) -> Option<usize> {
        (0..self.members.len()).map(|member| self.kernel(member).series()).sum()
    }
    #[inline(always)]
    fn add_series<const FIRST: bool>(
        &self,
        positions: &[[T; D]],
        forces: &mut [[T; D]],
        order: &mut Order<'_, T, FIRST>,
    ) {
        // Loops: of many lanes `array::from_fn` is a call, compiled for no instruction set.
        for (i, member) in self.members.iter().enumerate() {
            let mut variables = [T::from_f64(0.0); K];
            for (k, variable) in variables.iter_mut().enumerate() {
                *variable = positions[member[k / D]][k % D];
            }
            let gradient = self.kernel(i).gradient_series(&variables, order);
            for (a, &body) in member.iter().enumerate() {
                for (d, force) in forces[body].iter_mut().enumerate() {
                    *force = *force - gradient[a * D + d];
                }
            }
        }
    }
}
