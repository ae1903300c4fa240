//! A kernel and its topology: a function, and the bodies that each copy of it links.

use crate::kernel::functions::{Constraint, ConstraintKernel};
use crate::kernel::kinks::{Kink, first_kink, sign_changes};
use crate::kernel::over::short_name;
use crate::kernel::series::AnyOrder;
use crate::number::lanes::{Fused, side_by_side};
use crate::systems::network::in_lanes::{Alike, FEW, LinksInLanes, Number, Numbers, ROW, RowLinks, Swept};
use crate::systems::network::places::{Evaluated, Places};
use crate::systems::network::series_in_lanes::{LinkSeries, LinksInSeries};
use std::any::Any;
use std::array::from_fn;
use std::fmt::Debug;
use std::ops::Range;
use std::sync::Arc;

/// Copies of one constraint. Rows (equations) and blocks (the D numbers of a row that belong to one body) of a range of
/// members lie one after the other.
pub(crate) trait LinkGroup<const D: usize>: Any + Debug + Send + Sync {
    /// The type that the macro made.
    fn name(&self) -> &'static str;
    /// The name of a parameter that is NaN, if one is.
    fn nan_parameter(&self) -> Option<&'static str>;
    /// Equations of a member.
    fn equations(&self) -> usize;
    /// The bodies of each member in turn, and how many a member ties together.
    fn bodies(&self) -> (Vec<usize>, usize);
    /// Coordinates that the multiplier acts on, for each body of a member; all, if nothing is said.
    fn acting(&self) -> Option<&[[bool; D]]>;
    /// Whether g depends on time.
    fn moving(&self) -> bool;
    /// The same with a member for each of so many bodies in turn, if there is one for each of those `before`, with the
    /// same parameters.
    fn for_each(&self, before: usize, bodies: usize) -> Option<Box<dyn LinkGroup<D>>>;
    /// Some members alone, with other numbers of their bodies.
    fn among(&self, members: Range<usize>, number: &dyn Fn(usize) -> usize) -> Arc<dyn LinkGroup<D>>;

    /// g.
    fn values(&self, members: Range<usize>, time: f64, q: &[[f64; D]], g: &mut [f64]);
    /// g, its blocks ∂g/∂q, and ∂g/∂t if it moves.
    fn gradients(
        &self,
        members: Range<usize>,
        time: f64,
        q: &[[f64; D]],
        g: &mut [f64],
        blocks: &mut [[f64; D]],
        rates: &mut [f64],
    );
    /// d²g/dt² along constant velocities, and |∇²g v|². Time passes at this pace: 1 on a motion, 0 along a direction in
    /// space.
    fn bends(
        &self,
        members: Range<usize>,
        at: (f64, &[[f64; D]]),
        along: (f64, &[[f64; D]]),
        bends: &mut [f64],
        turns: &mut [f64],
    );
    /// How the blocks ∂g/∂q of a member's equation change along a direction in space: ∇²g v. Allocates.
    fn changes(&self, of: (usize, usize), at: (f64, &[[f64; D]]), along: &[[f64; D]]) -> Vec<[f64; D]>;

    /// Of all members, row by row: g at these places.
    fn values_of_rows(&self, time: f64, q: &Places<D>, rows: &mut [Evaluated<D>]);
    /// g and its gradients.
    fn gradients_of_rows(&self, time: f64, q: &Places<D>, rows: &mut [Evaluated<D>]);
    /// d²g/dt² along constant velocities, and |∇²g v|².
    fn bends_of_rows(&self, time: f64, q: &Places<D>, v: &Places<D>, rows: &mut [Evaluated<D>]);

    /// The same links for trajectories side by side; none where multipliers act on chosen coordinates, g depends on
    /// time, or has kinks.
    fn in_lanes(&self) -> Option<Box<dyn RowLinks<ROW>>>;
    /// The same for a few trajectories.
    fn in_few_lanes(&self) -> Option<Box<dyn RowLinks<FEW>>>;

    /// Some members with other numbers of their bodies, for components that are alike, side by side; none also where
    /// the group's parameters differ.
    fn alike(&self, members: Range<usize>, number: &dyn Fn(usize) -> usize)
    -> Option<Box<dyn RowLinks<ROW>>>;

    /// The same for the trajectories of a sweep, each with the parameters of its own group, the first of which is this
    /// one; none also where groups are of other kinds, or tie other bodies.
    fn swept(&self, groups: &[&dyn LinkGroup<D>]) -> Option<Box<dyn RowLinks<ROW>>>;

    /// The same as power series for a few trajectories, all with the parameters of one group, this one, or each with
    /// those of its own, the first of which is this one.
    fn in_series(&self, groups: &[&dyn LinkGroup<D>]) -> Option<Arc<dyn LinkSeries>>;

    /// Whether there are kinks.
    fn has_kinks(&self) -> bool;
    /// Whether what changes its sign where a normal may jump has another one at the second places and times.
    fn changes_sides(&self, time: [f64; 2], q: [&[[f64; D]]; 2]) -> bool;
    /// The first member of which a normal jumps on the straight way between two places and times.
    fn kink(&self, time: [f64; 2], q: [&[[f64; D]]; 2]) -> Option<(usize, Kink)>;

    /// Blocks of products that the power series of these members' gradients take; none where one has no series.
    fn series_blocks(&self, members: Range<usize>) -> Option<usize>;
    /// The next coefficient of the blocks ∂g/∂q, and of ∂g/∂t if g moves, along a motion; `time` is that of t.
    fn gradients_series(
        &self,
        members: Range<usize>,
        time: f64,
        q: &[[f64; D]],
        blocks: &mut [[f64; D]],
        rates: &mut [f64],
        order: &mut AnyOrder<'_, '_, f64>,
    );
}

/// A kernel with K variables on A bodies each; K = A·D, or one more, the time.
#[derive(Clone)]
pub(crate) struct Links<G, const K: usize, const M: usize, const A: usize, const D: usize> {
    pub(crate) name: &'static str,
    nan_parameter: Option<&'static str>,
    /// One for all members, or one for each.
    pub(crate) kernels: Vec<G>,
    pub(crate) members: Vec<[usize; A]>,
    pub(crate) acting: Option<[[bool; D]; A]>,
    in_lanes: fn(&Self) -> Box<dyn RowLinks<ROW>>,
    in_few_lanes: fn(&Self) -> Box<dyn RowLinks<FEW>>,
    swept: fn(&[&Self]) -> Box<dyn RowLinks<ROW>>,
    in_series: fn(&[&Self]) -> Arc<dyn LinkSeries>,
}

impl<G, const K: usize, const M: usize, const A: usize, const D: usize> Debug for Links<G, K, M, A, D> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} × {}", self.members.len(), self.name)
    }
}

impl<G, const K: usize, const M: usize, const A: usize, const D: usize> Links<G, K, M, A, D> {
    const MOVING: bool = K == A * D + 1;

    /// Constraints, one for all members or one for each.
    pub(crate) fn new<C>(constraints: Vec<C>, members: Vec<[usize; A]>) -> Self
    where
        C: Constraint<K, M, Kernel<f64> = G>,
    {
        let name = short_name::<C>();
        Self {
            name,
            nan_parameter: constraints.iter().find_map(C::nan_parameter),
            kernels: constraints.iter().map(|constraint| constraint.kernel::<f64>()).collect(),
            members,
            acting: None,
            in_lanes: |links| Box::new(links.fused::<C>()),
            in_few_lanes: |links| Box::new(links.fused::<C>()),
            swept: |links| {
                let kernels = Self::kernels_of::<C, ROW>(links).into_iter().map(Swept::<C, K, M>);
                Box::new(LinksInLanes::<_, K, M, A, D> {
                    kernels: kernels.collect(),
                    members: links[0].members.clone(),
                })
            },
            in_series: |links| {
                let (kernels, members) = (Self::kernels_of::<C, FEW>(links), links[0].members.clone());
                Arc::new(LinksInSeries::<_, K, M, A, D> { kernels, members })
            },
        }
    }

    /// Kernels whose numbers are those of each lane; of lanes beyond these the first.
    fn kernels_of<C: Constraint<K, M, Kernel<f64> = G>, const W: usize>(
        links: &[&Self],
    ) -> Vec<C::Kernel<Numbers<W>>> {
        let number = links.iter().map(|links| links.kernels.len()).max().unwrap_or(1);
        let kernel = |member| {
            side_by_side(
                |lane| {
                    let links = links.get(lane).unwrap_or(&links[0]);
                    C::map_kernel(links.kernel(member), |&number| Fused(number))
                },
                |kernel, number| drop(C::map_kernel::<Number, Number>(kernel, number)),
                |kernel, number| C::map_kernel(kernel, number),
            )
        };
        (0..number).map(kernel).collect()
    }

    /// The same over numbers of lanes.
    fn fused<C: Constraint<K, M, Kernel<f64> = G>>(
        &self,
    ) -> LinksInLanes<Alike<C::Kernel<Number>>, K, M, A, D> {
        let kernels = self.kernels.iter().map(|kernel| Alike(C::map_kernel(kernel, |&x| Fused(x))));
        LinksInLanes { kernels: kernels.collect(), members: self.members.clone() }
    }

    /// Some members, with other numbers of their bodies.
    fn some(&self, members: Range<usize>, number: &dyn Fn(usize) -> usize) -> Self
    where
        G: Clone,
    {
        let kernels = if self.kernels.len() == 1 { 0..1 } else { members.clone() };
        Self {
            kernels: self.kernels[kernels].to_vec(),
            members: self.members[members].iter().map(|bodies| bodies.map(number)).collect(),
            ..*self
        }
    }

    #[inline(always)]
    fn kernel(&self, member: usize) -> &G {
        &self.kernels[if self.kernels.len() == 1 { 0 } else { member }]
    }

    /// The kernel's variables from those of the bodies, with `last` as time.
    #[inline(always)]
    fn gather(&self, member: usize, of_bodies: &[[f64; D]], last: f64) -> [f64; K] {
        let bodies = &self.members[member];
        from_fn(|k| if k < A * D { of_bodies[bodies[k / D]][k % D] } else { last })
    }

    /// Writes the rows of a member's Jacobian as blocks and ∂g/∂t.
    #[inline(always)]
    fn spread(rows: &[[f64; K]; M], blocks: &mut [[f64; D]], rates: &mut [f64]) {
        for (i, row) in rows.iter().enumerate() {
            for (a, block) in blocks[i * A..(i + 1) * A].iter_mut().enumerate() {
                *block = from_fn(|d| row[a * D + d]);
            }
            if Self::MOVING {
                rates[i] = row[K - 1];
            }
        }
    }
}

impl<G, const K: usize, const M: usize, const A: usize, const D: usize> Links<G, K, M, A, D>
where
    G: ConstraintKernel<f64, K, M>,
{
    fn goes_in_lanes(&self) -> bool {
        self.acting.is_none() && const { !Self::MOVING && G::KINKS.is_empty() }
    }

    /// These groups, if they are of this kind, tie the same bodies, and go in lanes.
    fn alike_in_lanes<'a>(&self, groups: &[&'a dyn LinkGroup<D>]) -> Option<Vec<&'a Self>> {
        let links = groups.iter().map(|&group| (group as &dyn Any).downcast_ref::<Self>());
        let links = links.collect::<Option<Vec<_>>>()?;
        let alike = links.iter().all(|links| links.goes_in_lanes() && links.members == self.members);
        alike.then_some(links)
    }
}

impl<G, const K: usize, const M: usize, const A: usize, const D: usize> LinkGroup<D> for Links<G, K, M, A, D>
where
    G: ConstraintKernel<f64, K, M>,
{
    fn name(&self) -> &'static str {
        self.name
    }
    fn nan_parameter(&self) -> Option<&'static str> {
        self.nan_parameter
    }
    fn equations(&self) -> usize {
        M
    }
    fn bodies(&self) -> (Vec<usize>, usize) {
        (self.members.iter().flatten().copied().collect(), A)
    }
    fn acting(&self) -> Option<&[[bool; D]]> {
        self.acting.as_ref().map(<[_; A]>::as_slice)
    }
    fn moving(&self) -> bool {
        Self::MOVING
    }
    fn for_each(&self, before: usize, bodies: usize) -> Option<Box<dyn LinkGroup<D>>> {
        let alike = A == 1 && self.kernels.len() == 1;
        let each = alike && self.members.iter().copied().eq((0..before).map(|i| [i; A]));
        each.then(|| {
            Box::new(Self { members: (0..bodies).map(|i| [i; A]).collect(), ..self.clone() })
                as Box<dyn LinkGroup<D>>
        })
    }

    fn among(&self, members: Range<usize>, number: &dyn Fn(usize) -> usize) -> Arc<dyn LinkGroup<D>> {
        Arc::new(self.some(members, number))
    }

    fn values(&self, members: Range<usize>, time: f64, q: &[[f64; D]], g: &mut [f64]) {
        for (member, g) in members.zip(g.chunks_exact_mut(M)) {
            g.copy_from_slice(&self.kernel(member).value(&self.gather(member, q, time)));
        }
    }

    fn gradients(
        &self,
        members: Range<usize>,
        time: f64,
        q: &[[f64; D]],
        g: &mut [f64],
        blocks: &mut [[f64; D]],
        rates: &mut [f64],
    ) {
        let outputs =
            g.chunks_exact_mut(M).zip(blocks.chunks_exact_mut(M * A)).zip(rates.chunks_exact_mut(M));
        for (member, ((g, blocks), rates)) in members.zip(outputs) {
            let (values, rows) = self.kernel(member).value_and_jacobian(&self.gather(member, q, time));
            g.copy_from_slice(&values);
            Self::spread(&rows, blocks, rates);
        }
    }

    fn bends(
        &self,
        members: Range<usize>,
        (time, q): (f64, &[[f64; D]]),
        (pace, v): (f64, &[[f64; D]]),
        bends: &mut [f64],
        turns: &mut [f64],
    ) {
        let outputs = bends.chunks_exact_mut(M).zip(turns.chunks_exact_mut(M));
        for (member, (bends, turns)) in members.zip(outputs) {
            let direction = self.gather(member, v, pace);
            let rows = self.kernel(member).hessian_vector(&self.gather(member, q, time), &direction);
            for (i, row) in rows.iter().enumerate() {
                bends[i] = row.iter().zip(&direction).map(|(h, v)| h * v).sum();
                turns[i] = row[..A * D].iter().map(|h| h * h).sum();
            }
        }
    }

    fn changes(
        &self,
        (member, equation): (usize, usize),
        (time, q): (f64, &[[f64; D]]),
        along: &[[f64; D]],
    ) -> Vec<[f64; D]> {
        let direction = self.gather(member, along, 0.0);
        let rows = self.kernel(member).hessian_vector(&self.gather(member, q, time), &direction);
        rows[equation][..A * D].chunks_exact(D).map(|block| from_fn(|d| block[d])).collect()
    }

    fn values_of_rows(&self, time: f64, q: &Places<D>, rows: &mut [Evaluated<D>]) {
        for (member, rows) in rows.chunks_exact_mut(M).take(self.members.len()).enumerate() {
            let values = self.kernel(member).value(&self.gather(member, q, time));
            rows.iter_mut().zip(values).for_each(|(row, value)| row.value = value);
        }
    }

    fn gradients_of_rows(&self, time: f64, q: &Places<D>, rows: &mut [Evaluated<D>]) {
        for (member, rows) in rows.chunks_exact_mut(M).take(self.members.len()).enumerate() {
            let (values, gradients) = self.kernel(member).value_and_jacobian(&self.gather(member, q, time));
            for (i, row) in rows.iter_mut().enumerate() {
                row.value = values[i];
                for (a, &body) in self.members[member].iter().enumerate() {
                    row.blocks[body] = from_fn(|d| gradients[i][a * D + d]);
                }
            }
        }
    }

    fn bends_of_rows(&self, time: f64, q: &Places<D>, v: &Places<D>, rows: &mut [Evaluated<D>]) {
        for (member, rows) in rows.chunks_exact_mut(M).take(self.members.len()).enumerate() {
            let direction = self.gather(member, v, 1.0);
            let along = self.kernel(member).hessian_vector(&self.gather(member, q, time), &direction);
            for (row, along) in rows.iter_mut().zip(&along) {
                row.value = along.iter().zip(&direction).map(|(h, v)| h * v).sum();
                row.turn = along[..A * D].iter().map(|h| h * h).sum();
            }
        }
    }

    fn in_lanes(&self) -> Option<Box<dyn RowLinks<ROW>>> {
        self.goes_in_lanes().then(|| (self.in_lanes)(self))
    }
    fn in_few_lanes(&self) -> Option<Box<dyn RowLinks<FEW>>> {
        self.goes_in_lanes().then(|| (self.in_few_lanes)(self))
    }

    fn alike(
        &self,
        members: Range<usize>,
        number: &dyn Fn(usize) -> usize,
    ) -> Option<Box<dyn RowLinks<ROW>>> {
        let may = self.goes_in_lanes() && self.kernels.len() == 1;
        may.then(|| (self.in_lanes)(&self.some(members, number)))
    }

    fn swept(&self, groups: &[&dyn LinkGroup<D>]) -> Option<Box<dyn RowLinks<ROW>>> {
        self.alike_in_lanes(groups).map(|links| (self.swept)(&links))
    }

    fn in_series(&self, groups: &[&dyn LinkGroup<D>]) -> Option<Arc<dyn LinkSeries>> {
        self.alike_in_lanes(groups).map(|links| (self.in_series)(&links))
    }

    fn has_kinks(&self) -> bool {
        !G::KINKS.is_empty()
    }

    fn kink(&self, time: [f64; 2], q: [&[[f64; D]]; 2]) -> Option<(usize, Kink)> {
        if const { G::KINKS.is_empty() } {
            return None;
        }
        (0..self.members.len()).find_map(|member| {
            let [from, to] = [0, 1].map(|i| self.gather(member, q[i], time[i]));
            let kernel = self.kernel(member);
            let changes = sign_changes(kernel, &[from], &[to]);
            let kink = if changes { first_kink(kernel, &[from], &[to]) } else { None };
            kink.map(|kink| (member, kink))
        })
    }

    fn changes_sides(&self, time: [f64; 2], q: [&[[f64; D]]; 2]) -> bool {
        if const { G::KINKS.is_empty() } {
            return false;
        }
        (0..self.members.len()).any(|member| {
            let [from, to] = [0, 1].map(|i| self.gather(member, q[i], time[i]));
            sign_changes(self.kernel(member), &[from], &[to])
        })
    }

    fn series_blocks(&self, members: Range<usize>) -> Option<usize> {
        members.map(|member| self.kernel(member).series()).sum()
    }

    fn gradients_series(
        &self,
        members: Range<usize>,
        time: f64,
        q: &[[f64; D]],
        blocks: &mut [[f64; D]],
        rates: &mut [f64],
        order: &mut AnyOrder<'_, '_, f64>,
    ) {
        let outputs = blocks.chunks_exact_mut(M * A).zip(rates.chunks_exact_mut(M));
        for (member, (blocks, rates)) in members.zip(outputs) {
            let (kernel, variables) = (self.kernel(member), self.gather(member, q, time));
            let rows = match order {
                AnyOrder::First(order) => kernel.jacobian_series(&variables, order),
                AnyOrder::Next(order) => kernel.jacobian_series(&variables, order),
            };
            Self::spread(&rows, blocks, rates);
        }
    }
}
