//! A potential on each body.

use crate::effect::moment::Moment;
use crate::effect::one::{Acting, Effect};
use crate::effect::swept::{OfLanes, Swept};
use crate::error::{Error, refuse_nan};
use crate::kernel::functions::{Potential, PotentialKernel};
use crate::kernel::series::Order;
use crate::number::lanes::{Lane, Lanes, side_by_side};
use crate::number::real::Real;
use crate::number::vector::add_scaled;
use std::cell::{Cell, RefCell};

/// The kind of effect of every [`Potential`]: on each body.
#[derive(Debug, Clone, Copy)]
pub struct OnEach;

/// A potential that acts on each body, over a scalar.
#[derive(Debug, Clone, Copy)]
pub struct ActsOnEach<K>(K);

impl<P: Potential<D>, const D: usize> Effect<D, OnEach> for P {
    type Acting<T: Real> = ActsOnEach<P::Kernel<T>>;
    fn acting<T: Real>(&self) -> Self::Acting<T> {
        ActsOnEach(self.kernel())
    }

    type Swept<S: Lane, const L: usize> = SweptOnEach<P, S, L, D>;

    fn check(&self, what: &'static str, _: usize) -> Result<(), Error> {
        refuse_nan(what, self.nan_parameter())
    }
}

impl<T: Real, K: PotentialKernel<T, D>, const D: usize> Acting<T, D> for ActsOnEach<K> {
    type Room = ();
    const ON_EACH: bool = true;
    fn room(&self, _: usize) {}

    #[inline(always)]
    fn add_forces(&self, at: Moment<'_, T, D>, (): &mut (), forces: &mut [[T; D]]) {
        for (q, force) in at.positions.iter().zip(forces) {
            *force = add_scaled(force, T::from_f64(-1.0), &self.0.gradient(q));
        }
    }
    #[inline(always)]
    fn kick(&self, q: &[T; D], c: T, p: [T; D]) -> [T; D] {
        let gradient = self.0.gradient(q);
        let along = self.0.acts_along();
        let mut kicked = p;
        for d in 0..D {
            if along[d] {
                kicked[d] = (-c).multiply_add(gradient[d], p[d]);
            }
        }
        kicked
    }
    fn energy(&self, at: Moment<'_, T, D>) -> T {
        at.positions.iter().fold(T::from_f64(-0.0), |energy, q| energy + self.0.value(q))
    }
    fn series_blocks(&self, bodies: usize) -> Option<usize> {
        Some(bodies * self.0.series()?)
    }
    #[inline(always)]
    fn add_series<const FIRST: bool>(
        &self,
        positions: &[[T; D]],
        forces: &mut [[T; D]],
        order: &mut Order<'_, T, FIRST>,
    ) {
        for (q, force) in positions.iter().zip(forces) {
            let gradient = self.0.gradient_series(q, order);
            for (force, gradient) in force.iter_mut().zip(gradient) {
                *force = *force - gradient;
            }
        }
    }
}

/// A potential on the body of each lane: a kernel whose numbers are arrays with one entry for each lane.
#[derive(Debug)]
pub struct SweptOnEach<P: Potential<D>, S: Lane, const L: usize, const D: usize>(P::Kernel<Lanes<S, L>>);

impl<P: Potential<D>, S: Lane, const L: usize, const D: usize> OfLanes<ActsOnEach<P::Kernel<S>>>
    for SweptOnEach<P, S, L, D>
{
    fn of_lanes(lane: impl Fn(usize) -> ActsOnEach<P::Kernel<S>>) -> Self {
        Self(side_by_side(
            |i| lane(i).0,
            |kernel, number| drop(P::map_kernel::<S, S>(kernel, number)),
            |kernel, number| P::map_kernel(kernel, number),
        ))
    }
}

impl<P: Potential<D>, S: Lane, const L: usize, const D: usize> Clone for SweptOnEach<P, S, L, D> {
    #[inline(always)]
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<P: Potential<D>, S: Lane, const L: usize, const D: usize> Swept<S, L, D> for SweptOnEach<P, S, L, D> {
    type Lane = ActsOnEach<P::Kernel<S>>;

    #[inline(always)]
    fn lane(&self, lane: usize) -> Self::Lane {
        ActsOnEach(P::map_kernel(&self.0, |number| number.0[lane]))
    }
    #[inline(always)]
    fn kick(&self, lane: usize, q: &[S; D], c: S, p: [S; D]) -> [S; D] {
        Swept::lane(self, lane).kick(q, c, p)
    }
    fn copy(&mut self, from: usize, to: usize) {
        self.0 = P::map_kernel(&self.0, |number| number.copied(from, to));
    }
    fn series_blocks(&self) -> Option<usize> {
        self.0.series()
    }
    fn take_over(&mut self, lane: usize, others: &Self, from: usize) {
        let numbers = RefCell::new(Vec::new());
        P::map_kernel::<Lanes<S, L>, S>(&others.0, |number| {
            numbers.borrow_mut().push(number.0[from]);
            number.0[from]
        });
        let (numbers, next) = (numbers.into_inner(), Cell::new(0));
        self.0 = P::map_kernel(&self.0, |&number| {
            let mut number: Lanes<S, L> = number;
            number.0[lane] = numbers[next.replace(next.get() + 1)];
            number
        });
    }
    #[inline(always)]
    fn add_series<const FIRST: bool>(
        &self,
        q: &[Lanes<S, L>; D],
        force: &mut [Lanes<S, L>; D],
        order: &mut Order<'_, Lanes<S, L>, FIRST>,
    ) {
        let gradient = self.0.gradient_series(q, order);
        for (force, gradient) in force.iter_mut().zip(gradient) {
            *force = *force - gradient;
        }
    }
}
