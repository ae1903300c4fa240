//! Rows of trajectories in phase space: what their lanes obey, and the numbers that are kept from step to step.

use crate::kernel::functions::{Hamiltonian, HamiltonianKernel, PhaseConstraint, PhaseConstraintKernel};
use crate::motion::bodies::Body;
use crate::number::lanes::{Fused, Lanes, side_by_side};
use crate::number::vectors::{Vectors, at, put};
use crate::run::ensemble::lane_record::{InRows, Rows};
use crate::solve::aim::Aim;
use crate::systems::phase::in_lanes::Lone;
use std::array::from_fn;

/// Trajectories of a row: it waits for its slowest lane, and what a step works on has to fit the nearest cache.
pub(super) const ROW: usize = 16;

/// A number of a lane.
pub(super) type Number = Fused<f64>;

/// A number of each lane.
pub(super) type Each = [Number; ROW];

/// A vector of each lane.
pub(super) type Vector<const D: usize> = Vectors<Number, ROW, D>;

/// A matrix of each lane.
pub(super) type Matrix<const M: usize> = [[Each; M]; M];

/// Zeros.
pub(super) const ZEROS: Each = [Fused(0.0); ROW];

/// A point of phase space, or a difference of two, in each lane.
#[derive(Clone)]
#[repr(align(64))]
pub(super) struct Points<const D: usize> {
    pub(super) q: Vector<D>,
    pub(super) p: Vector<D>,
}

impl<const D: usize> Points<D> {
    pub(super) const ZERO: Self = Self { q: [ZEROS; D], p: [ZEROS; D] };

    /// Both parts.
    pub(super) fn rows(&mut self) -> impl Iterator<Item = &mut Each> {
        self.q.iter_mut().chain(&mut self.p)
    }
}

/// The matrix of a lane.
#[inline(always)]
pub(super) fn matrix<const M: usize>(of: &Matrix<M>, lane: usize) -> [[Number; M]; M] {
    from_fn(|i| at(&of[i], lane))
}

/// What each lane obeys.
pub(super) trait Laws<const D: usize, const M: usize>: Clone + Send + Sync + 'static {
    type Constraint: PhaseConstraintKernel<Number, D, M>;
    type Energy: HamiltonianKernel<Number, D>;

    fn constraint(&self, lane: usize) -> Self::Constraint;
    fn energy(&self, lane: usize) -> Self::Energy;
    /// Has lane `to` obey what lane `from` does.
    fn copy(&mut self, from: usize, to: usize);
}

/// Constraints and Hamiltonians as structures of arrays: kernels whose numbers are lanes.
pub(super) struct Swept<G: PhaseConstraint<D, M>, H: Hamiltonian<D>, const D: usize, const M: usize> {
    constraint: G::Kernel<Lanes<Number, ROW>>,
    energy: H::Kernel<Lanes<Number, ROW>>,
}

impl<G: PhaseConstraint<D, M>, H: Hamiltonian<D>, const D: usize, const M: usize> Swept<G, H, D, M> {
    /// Lane i obeys `lane(i)`.
    pub(super) fn new<'a>(lane: impl Fn(usize) -> (&'a G, &'a H)) -> Self
    where
        G: 'a,
        H: 'a,
    {
        let constraint = side_by_side(
            |i| lane(i).0.kernel::<Number>(),
            |kernel, number| drop(G::map_kernel::<Number, Number>(kernel, number)),
            |kernel, number| G::map_kernel(kernel, number),
        );
        let energy = side_by_side(
            |i| lane(i).1.kernel::<Number>(),
            |kernel, number| drop(H::map_kernel::<Number, Number>(kernel, number)),
            |kernel, number| H::map_kernel(kernel, number),
        );
        Self { constraint, energy }
    }
}

impl<G: PhaseConstraint<D, M>, H: Hamiltonian<D>, const D: usize, const M: usize> Clone
    for Swept<G, H, D, M>
{
    #[inline(always)]
    fn clone(&self) -> Self {
        Self { constraint: self.constraint.clone(), energy: self.energy.clone() }
    }
}

impl<G, H, const D: usize, const M: usize> Laws<D, M> for Swept<G, H, D, M>
where
    G: PhaseConstraint<D, M> + 'static,
    H: Hamiltonian<D> + 'static,
{
    type Constraint = G::Kernel<Number>;
    type Energy = H::Kernel<Number>;

    #[inline(always)]
    fn constraint(&self, lane: usize) -> G::Kernel<Number> {
        G::map_kernel(&self.constraint, |number| number.0[lane])
    }
    #[inline(always)]
    fn energy(&self, lane: usize) -> H::Kernel<Number> {
        H::map_kernel(&self.energy, |number| number.0[lane])
    }
    fn copy(&mut self, from: usize, to: usize) {
        self.constraint = G::map_kernel(&self.constraint, |number| number.copied(from, to));
        self.energy = H::map_kernel(&self.energy, |number| number.copied(from, to));
    }
}

/// A body in each lane.
#[derive(Clone)]
pub(super) struct Row<const D: usize, const M: usize> {
    /// Where it is, and what rounding took from that.
    pub(super) high: Points<D>,
    pub(super) low: Points<D>,
    /// N there.
    pub(super) slopes: Matrix<M>,
    /// By what parts of its terms each equation was off where the guesses of the last two steps led, the last one
    /// first.
    pub(super) aims: [[Each; M]; 2],
}

impl<const D: usize, const M: usize> Row<D, M> {
    /// A body in no lane.
    pub(super) fn new() -> Self {
        Self {
            high: Points::ZERO,
            low: Points::ZERO,
            slopes: [[ZEROS; M]; M],
            aims: [[[Fused(f64::NAN); ROW]; M]; 2],
        }
    }

    /// The body of a lane.
    pub(super) fn body(&self, lane: usize) -> Body<f64, D> {
        let Self { high, low, .. } = self;
        let [q, q_low, p, p_low] = [&high.q, &low.q, &high.p, &low.p].map(|x| at(x, lane));
        Body { q, q_low, p, p_low }.map(|Fused(x)| x)
    }

    /// The same, and what is kept of it.
    pub(super) fn lone(&self, lane: usize) -> Lone<D, M> {
        let aim = |i: usize| Aim { last: self.aims[0][i][lane].0, before: self.aims[1][i][lane].0 };
        let slopes = matrix(&self.slopes, lane).map(|row| row.map(|Fused(x)| x));
        Lone { body: self.body(lane), slopes, aims: from_fn(aim) }
    }

    /// Puts a body into a lane.
    pub(super) fn put(&mut self, lane: usize, Lone { body, slopes, aims }: &Lone<D, M>) {
        let Body { q, q_low, p, p_low } = body.map(Fused);
        let Self { high, low, .. } = self;
        for (to, x) in [(&mut high.q, q), (&mut low.q, q_low), (&mut high.p, p), (&mut low.p, p_low)] {
            put(to, lane, x);
        }
        for (i, row) in slopes.iter().enumerate() {
            put(&mut self.slopes[i], lane, row.map(Fused));
        }
        put(&mut self.aims[0], lane, aims.map(|aim| Fused(aim.last)));
        put(&mut self.aims[1], lane, aims.map(|aim| Fused(aim.before)));
    }
}

impl<const D: usize, const M: usize> InRows<Number> for Row<D, M> {
    fn rows(&mut self) -> Rows<'_, Number> {
        let Self { high, low, slopes, aims } = self;
        let mut rows: Rows<'_, Number> = Vec::new();
        rows.extend(high.rows().map(|numbers| ("q and p", &mut numbers[..])));
        rows.extend(low.rows().map(|numbers| ("q and p, rounding", &mut numbers[..])));
        rows.extend(slopes.as_flattened_mut().iter_mut().map(|numbers| ("slopes", &mut numbers[..])));
        rows.extend(
            aims.as_flattened_mut().iter_mut().map(|numbers| ("guesses were off by", &mut numbers[..])),
        );
        rows
    }
}
