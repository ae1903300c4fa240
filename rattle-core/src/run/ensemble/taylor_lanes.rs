//! The power series of [`Taylor`] for trajectories in lanes: each coefficient is an array with a number for each lane.

use crate::effect::list::{Effects, Forces};
use crate::effect::swept::Swept;
use crate::kernel::functions::{Constraint, ConstraintKernel};
use crate::kernel::series::Order;
use crate::methods::taylor::{INSIDE, ROUNDINGS_OF_SERIES, SMALLEST_PART, Taylor};
use crate::motion::bodies::One;
use crate::motion::failure::Failure;
use crate::motion::method::Method;
use crate::number::lanes::{Lane, Lanes};
use crate::number::real::Real;
use crate::number::vector::{add_scaled, dot, largest, scaled};
use crate::number::vectors::{Vectors, at};
use crate::run::ensemble::laws::{Each, Laws, Same};
use crate::run::ensemble::projected::{Projects, least_tolerance};
use crate::run::ensemble::projected_row::Place;
use crate::run::ensemble::row::pull;
use crate::systems::surface::kept::{BodiesOf, OnSurface, OneByOne};
use crate::systems::surface::room::SeriesRoom;
use crate::systems::surface::series::{Contributes, Together, expand, room};
use std::borrow::Borrow;

/// The method, and what lanes obey.
#[derive(Clone)]
pub(super) struct TaylorInLanes<X> {
    method: Taylor,
    laws: X,
    /// The blocks of products that functions take.
    functions: usize,
}

/// Working memory of an expansion, and the coefficients of positions.
pub(super) struct Expansion<S, const L: usize, const D: usize> {
    products: SeriesRoom<Lanes<S, L>, D>,
    series: Vec<[Lanes<S, L>; D]>,
    /// Accelerations at the ends of inner steps, and their last two terms.
    bends: Vectors<S, L, D>,
    left_out: [S; L],
}

/// What lanes obey, as functions of L numbers at once.
pub(super) trait InSeries<S: Lane, const L: usize, const D: usize>:
    Clone + Send + Sync + 'static
{
    fn constraint(&self) -> &impl ConstraintKernel<Lanes<S, L>, D, 1>;
    fn effects(&self) -> impl Contributes<Lanes<S, L>, D>;
    /// Has lane `to` obey what lane `from` does.
    fn copy(&mut self, from: usize, to: usize);
}

impl<S: Lane, K, F, const L: usize, const D: usize> InSeries<S, L, D> for Same<K, F>
where
    K: ConstraintKernel<Lanes<S, L>, D, 1>,
    F: Forces<Lanes<S, L>, D>,
{
    #[inline(always)]
    fn constraint(&self) -> &impl ConstraintKernel<Lanes<S, L>, D, 1> {
        &self.0
    }
    #[inline(always)]
    fn effects(&self) -> impl Contributes<Lanes<S, L>, D> {
        Together(&self.1)
    }
    fn copy(&mut self, _: usize, _: usize) {}
}

impl<C, E, S: Lane, const L: usize, const D: usize> InSeries<S, L, D> for Each<C, E, S, L, D>
where
    C: Constraint<D, 1> + 'static,
    E: Effects<D> + 'static,
{
    #[inline(always)]
    fn constraint(&self) -> &impl ConstraintKernel<Lanes<S, L>, D, 1> {
        &self.constraint
    }
    #[inline(always)]
    fn effects(&self) -> impl Contributes<Lanes<S, L>, D> {
        Apart(&self.effects)
    }
    fn copy(&mut self, from: usize, to: usize) {
        Laws::copy(self, from, to);
    }
}

/// The effects of a sweep on the body of each lane.
struct Apart<'a, W>(&'a W);

impl<S: Lane, W: Swept<S, L, D>, const L: usize, const D: usize> Contributes<Lanes<S, L>, D>
    for Apart<'_, W>
{
    fn blocks(&self, _: usize) -> Option<usize> {
        self.0.series_blocks()
    }
    #[inline(always)]
    fn contribute<const FIRST: bool>(
        &self,
        positions: &[[Lanes<S, L>; D]],
        forces: &mut [[Lanes<S, L>; D]],
        order: &mut Order<'_, Lanes<S, L>, FIRST>,
    ) {
        self.0.add_series(&positions[0], &mut forces[0], order);
    }
}

impl<X> TaylorInLanes<X> {
    /// This method in lanes that obey these laws; none where a function has no series.
    pub(super) fn new<S: Lane, const L: usize, const D: usize>(method: Taylor, laws: X) -> Option<Self>
    where
        X: InSeries<S, L, D>,
    {
        let functions = laws.constraint().series()? + laws.effects().blocks(1)?;
        Some(Self { method, laws, functions })
    }
}

impl<S: Lane, X: InSeries<S, L, D>, const L: usize, const D: usize> Projects<S, L, D> for TaylorInLanes<X> {
    type Method = Taylor;
    type Room = Expansion<S, L, D>;

    fn method(&self) -> &Taylor {
        &self.method
    }

    fn room(&self) -> Expansion<S, L, D> {
        let orders = self.method.coefficients();
        let zero = Lanes([S::default(); L]);
        Expansion {
            products: room(self.functions, 1, orders, self.method.step_size()),
            series: vec![[zero; D]; orders],
            bends: [[S::default(); L]; D],
            left_out: [S::default(); L],
        }
    }

    fn evaluations(&self) -> u32 {
        self.method.order()
    }

    fn obey(&mut self, from: usize, to: usize) {
        self.laws.copy(from, to);
    }

    #[inline(always)]
    fn sum<const SUMS: usize>(
        &self,
        obeyed: &impl Laws<S, D>,
        now: &Place<S, L, D>,
        left: &[S; L],
        inner: &mut [S; L],
        next: &mut [S; L],
        taken: &mut [bool; L],
        [way, change]: [&mut Vectors<S, L, D>; 2],
        Expansion { products, series, bends, left_out }: &mut Expansion<S, L, D>,
    ) {
        let normal = now.normal.map(Lanes);
        let inverse_square = Lanes::from_f64(1.0) / dot(&normal, &normal);
        let unit = products.unit;
        (series[0], series[1]) = (now.q.map(Lanes), scaled(Lanes::from_f64(unit), &now.p.map(Lanes)));
        let Self { method, laws, .. } = self;
        let (constraint, effects) = (laws.constraint(), laws.effects());
        let start = |_| (normal, inverse_square);
        expand::<true, _, _, D>(constraint, &effects, products, 1, start, series, |_, _| {});
        match method.tolerance() {
            None => (*inner, *next, *taken) = (*left, *left, [true; L]),
            Some(tolerance) => {
                let longest = longest::<S, L, D>(method, tolerance, unit, now, series);
                let shortest = S::from_f64(SMALLEST_PART * method.step_size().abs());
                for l in 0..L {
                    taken[l] = shortest.le(longest[l]);
                    inner[l] = S::select(longest[l].lt(left[l].abs()), longest[l] * left[l].sign(), left[l]);
                    next[l] = S::select(taken[l], left[l], S::default());
                }
            }
        }
        let (mut step, over_unit) = (Lanes(*inner), S::from_f64(1.0 / unit));
        for step in &mut step.0 {
            *step = *step * over_unit;
        }
        let [mut x, mut y, mut z] = [[Lanes::from_f64(0.0); D]; 3];
        sum_up(&step, series, &mut x, &mut y, &mut z);
        let over_unit = Lanes::from_f64(1.0 / unit);
        let over_square = over_unit * over_unit;
        for d in 0..D {
            (way[d], change[d]) = (x[d].0, (over_unit * y[d]).0);
            bends[d] = (over_square * z[d]).0;
        }
        last_terms(&step, over_square, series, left_out);
        if let Some(tolerance) = method.tolerance() {
            let tolerance = [tolerance, method.step_size()].map(S::from_f64);
            leave_bent::<S, L, D>(obeyed, now, (series, unit), tolerance, inner, next, taken);
        }
    }

    #[inline(always)]
    fn bends<'a>(
        &self,
        Expansion { bends, left_out, .. }: &'a Expansion<S, L, D>,
    ) -> Option<(&'a Vectors<S, L, D>, &'a [S; L], f64)> {
        self.method.tolerance().map(|tolerance| (bends, left_out, tolerance))
    }

    fn by_itself<A: ConstraintKernel<S, D, 1>, B: Forces<S, D>>(
        &self,
        system: &OnSurface<A, B, One, OneByOne>,
        parts: u32,
        bodies: &mut BodiesOf<One, S, B, D>,
    ) -> Result<(), Failure> {
        let mut part = self.method.with_step(self.method.step_size() / f64::from(parts));
        if let Some(tolerance) = self.method.tolerance() {
            let tolerance = tolerance.max(least_tolerance(&bodies.q[0]).to_f64());
            part = Taylor::adaptive(part.order(), part.step_size(), tolerance);
        }
        let view = (system, system, system);
        part.prepare::<S, OnSurface<A, B, One, OneByOne>, D>(view, bodies);
        (0..parts).try_for_each(|_| {
            part.step::<S, OnSurface<A, B, One, OneByOne>, _, D>(view, bodies, &mut [], &mut ())
        })
    }
}

/// Has lanes go by themselves whose series is not that of the motion at some times [inside](INSIDE) of their inner
/// step, by the tolerance and the step: that inner step is not taken, and the next one is none.
#[inline(always)]
fn leave_bent<S: Lane, const L: usize, const D: usize>(
    laws: &impl Laws<S, D>,
    now: &Place<S, L, D>,
    (series, unit): (&[[Lanes<S, L>; D]], f64),
    [tolerance, h]: [S; 2],
    inner: &[S; L],
    next: &mut [S; L],
    taken: &mut [bool; L],
) {
    let [roundings, over_unit] = [ROUNDINGS_OF_SERIES * S::EPSILON, 1.0 / unit].map(S::from_f64);
    let over_square = Lanes::from_f64(1.0 / (unit * unit));
    let mut left_out = [S::default(); L];
    for part in INSIDE {
        let mut step = Lanes(*inner);
        for step in &mut step.0 {
            *step = *step * over_unit * S::from_f64(part);
        }
        let [mut x, mut y, mut z] = [[Lanes::from_f64(0.0); D]; 3];
        sum_up(&step, series, &mut x, &mut y, &mut z);
        last_terms(&step, over_square, series, &mut left_out);
        for l in 0..L {
            let (mut q, mut p, mut bend) = (at(&now.q, l), at(&now.p, l), [S::default(); D]);
            for d in 0..D {
                q[d] = q[d] + x[d].0[l];
                p[d] = p[d] + over_unit * y[d].0[l];
                bend[d] = over_square.0[l] * z[d].0[l];
            }
            let [gradient] = laws.constraint(l).borrow().jacobian(&q);
            let pull = pull(laws, l, &q, &p, &gradient).1;
            let time = inner[l] * S::from_f64(part);
            let off = largest(&add_scaled(&pull, S::from_f64(-1.0), &bend)) - left_out[l];
            let size = largest(&q) + largest(&pull) * time * time;
            let number = dot(&pull, &pull).le(S::from_f64(f64::MAX));
            let within =
                number & (off * (time * h).abs()).le(tolerance + roundings * size * (h / time).abs());
            taken[l] &= within;
            next[l] = S::select(within, next[l], S::default());
        }
    }
}

/// Sums up series after these steps by Horner's rule, in the unit of time: what places and momenta change by, and
/// accelerations. A loop: of many lanes in many dimensions `array::from_fn` is a call, compiled for no instruction set.
#[inline(always)]
fn sum_up<S: Lane, const L: usize, const D: usize>(
    step: &Lanes<S, L>,
    series: &[[Lanes<S, L>; D]],
    way: &mut [Lanes<S, L>; D],
    change: &mut [Lanes<S, L>; D],
    bend: &mut [Lanes<S, L>; D],
) {
    for (k, coefficient) in series.iter().enumerate().skip(1).rev() {
        let [number, both] = [k, k * (k - 1)].map(|k| Lanes::from_f64(k as f64));
        for d in 0..D {
            way[d] = *step * (coefficient[d] + way[d]);
            if k > 1 {
                change[d] = *step * number.multiply_add(coefficient[d], change[d]);
                bend[d] = step.multiply_add(bend[d], both * coefficient[d]);
            }
        }
    }
}

/// The last two terms of accelerations after these steps, which tell what series leave out.
#[inline(always)]
fn last_terms<S: Lane, const L: usize, const D: usize>(
    step: &Lanes<S, L>,
    over_square: Lanes<S, L>,
    series: &[[Lanes<S, L>; D]],
    to: &mut [S; L],
) {
    let (last, mut power) = (series.len() - 1, over_square);
    for _ in 0..last - 3 {
        power = power * *step;
    }
    let [before, number] = [(last - 1) * (last - 2), last * (last - 1)].map(|k| S::from_f64(k as f64));
    for l in 0..L {
        let mut terms = S::default();
        for d in 0..D {
            let both =
                before * series[last - 1][d].0[l].abs() + number * (series[last][d].0[l] * step.0[l]).abs();
            terms = terms.max(both);
        }
        to[l] = terms * power.0[l].abs();
    }
}

/// The longest inner steps whose last two terms keep the tolerance; 0 where a term is no number.
#[inline(always)]
fn longest<S: Lane, const L: usize, const D: usize>(
    method: &Taylor,
    tolerance: f64,
    unit: f64,
    now: &Place<S, L, D>,
    series: &[[Lanes<S, L>; D]],
) -> [S; L] {
    let [zero, whole, far] = [0.0, method.step_size().abs(), f64::INFINITY].map(S::from_f64);
    let mut longest = [far; L];
    for order in [method.order() as usize - 1, method.order() as usize] {
        let (inverse, scale) =
            (S::from_f64(1.0 / order as f64), S::from_f64((order + 1) as f64 / unit) * whole);
        let (terms, rates) = (&series[order], &series[order + 1]);
        for l in 0..L {
            let within = S::from_f64(tolerance).max(least_tolerance(&at(&now.q, l)));
            let [q, v] = [terms, rates].map(|x| largest(&std::array::from_fn::<S, D, _>(|d| x[d].0[l])));
            let fits = S::from_f64(unit) * (within / q.max(scale * v)).powf(inverse);
            let finite = (q + v).lt(far);
            longest[l] = S::select(finite, S::select(fits.lt(longest[l]), fits, longest[l]), zero);
        }
    }
    longest
}
