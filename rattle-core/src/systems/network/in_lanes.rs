//! Links of a network for trajectories in lanes: each number of a link is a row of numbers, one for each trajectory.
//!
//! Made from a [`LinkGroup`](crate::systems::network::group::LinkGroup) for ensembles alone. Its type does not contain
//! the number of coordinates of a body, so code that uses it is compiled once, not for every scene.

use crate::kernel::functions::{Constraint, ConstraintKernel};
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::{Fused, Lanes};
use crate::number::vector::dot;
use std::array::from_fn;
use std::borrow::Borrow;
use std::ops::Range;

/// Trajectories of a row: what is walked through once for all is little to each of them.
pub(crate) const ROW: usize = 64;

/// Trajectories of a row of a few: as many as the widest register holds.
pub(crate) const FEW: usize = 8;

/// A number of a lane.
pub(crate) type Number = Fused<f64>;

/// A number of each of W trajectories.
pub(crate) type Numbers<const W: usize> = Lanes<Number, W>;

/// Zeros.
pub(crate) const fn zeros<const W: usize>() -> Numbers<W> {
    Lanes([Fused(0.0); W])
}

/// For each lane 1 or 0; as wide as what is compared, so that comparing is done side by side.
pub(crate) type Which<const W: usize> = [u64; W];

/// Whether there is one among them.
#[inline(always)]
pub(crate) fn any<const W: usize>(which: &Which<W>) -> bool {
    which.iter().fold(0, |any, which| any | which) != 0
}

/// The numbers of a lane.
#[inline(always)]
pub(crate) fn at<const N: usize, const W: usize>(rows: &[Numbers<W>; N], l: usize) -> [Number; N] {
    from_fn(|n| rows[n].0[l])
}

/// The first lane in which one of these is infinite or no number.
#[inline(always)]
pub(crate) fn lost<'a, const W: usize>(rows: impl Iterator<Item = &'a Numbers<W>>) -> Option<usize> {
    no_number(rows, |x| x)
}

/// The first lane in which one of these is so large that its square is no number: a body that has run away.
#[inline(always)]
pub(crate) fn ran_away<const W: usize>(places: &[Numbers<W>]) -> Option<usize> {
    no_number(places.iter(), |x| x * x)
}

#[inline(always)]
fn no_number<'a, const W: usize>(
    rows: impl Iterator<Item = &'a Numbers<W>>,
    of: impl Fn(Number) -> Number,
) -> Option<usize> {
    let mut sum = zeros::<W>();
    for row in rows {
        for l in 0..W {
            sum.0[l] = sum.0[l] + Fused(0.0) * of(row.0[l]);
        }
    }
    sum.0.iter().position(|sum| sum.0 != 0.0)
}

/// Puts numbers into a lane.
#[inline(always)]
pub(crate) fn put<const N: usize, const W: usize>(rows: &mut [Numbers<W>; N], l: usize, x: [Number; N]) {
    for n in 0..N {
        rows[n].0[l] = x[n];
    }
}

/// Links whose numbers are rows. `q` are the coordinates of all bodies in turn; g, and the entries of ∂g/∂q by equation
/// and coordinate of the link's bodies, are written one after the other.
pub(crate) trait RowLinks<const W: usize>: Send + Sync {
    /// A copy.
    fn boxed(&self) -> Box<dyn RowLinks<W>>;
    /// Has lane `to` obey what lane `from` does.
    fn copy(&mut self, _from: usize, _to: usize) {}
    /// g and ∂g/∂q of some members.
    fn gradients(
        &self,
        set: Fusing,
        members: Range<usize>,
        q: &[Numbers<W>],
        g: &mut [Numbers<W>],
        gradients: &mut [Numbers<W>],
    );
    /// d²g/dt² at coordinates along constant velocities, and |∇²g v|², of some members.
    fn bends(
        &self,
        set: Fusing,
        members: Range<usize>,
        of: [&[Numbers<W>]; 2],
        bends: &mut [Numbers<W>],
        turns: &mut [Numbers<W>],
    );
}

impl<const W: usize> Clone for Box<dyn RowLinks<W>> {
    fn clone(&self) -> Self {
        (**self).boxed()
    }
}

/// The kernel of a link in W lanes: the same in all, or of each its own.
pub(crate) trait InLanes<const K: usize, const M: usize, const W: usize>:
    Clone + Send + Sync + 'static
{
    type Kernel: ConstraintKernel<Number, K, M>;

    /// That of a lane.
    fn lane(&self, lane: usize) -> impl Borrow<Self::Kernel>;
    /// Has lane `to` obey what lane `from` does.
    fn copy(&mut self, _from: usize, _to: usize) {}
}

/// The same in all lanes.
#[derive(Clone)]
pub(super) struct Alike<H>(pub(super) H);

impl<H: ConstraintKernel<Number, K, M>, const K: usize, const M: usize, const W: usize> InLanes<K, M, W>
    for Alike<H>
{
    type Kernel = H;

    #[inline(always)]
    fn lane(&self, _: usize) -> impl Borrow<H> {
        &self.0
    }
}

/// With parameters of its own for each lane: numbers are lanes.
pub(super) struct Swept<C: Constraint<K, M>, const K: usize, const M: usize>(
    pub(super) C::Kernel<Numbers<ROW>>,
);

impl<C: Constraint<K, M>, const K: usize, const M: usize> Clone for Swept<C, K, M> {
    #[inline(always)]
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<C: Constraint<K, M>, const K: usize, const M: usize> InLanes<K, M, ROW> for Swept<C, K, M> {
    type Kernel = C::Kernel<Number>;

    #[inline(always)]
    fn lane(&self, lane: usize) -> impl Borrow<Self::Kernel> {
        C::map_kernel(&self.0, |number| number.0[lane])
    }
    fn copy(&mut self, from: usize, to: usize) {
        self.0 = C::map_kernel(&self.0, |number| number.copied(from, to));
    }
}

/// Copies of one constraint between A bodies of D coordinates; K = A·D.
#[derive(Clone)]
pub(super) struct LinksInLanes<X, const K: usize, const M: usize, const A: usize, const D: usize> {
    /// One for all members, or one for each.
    pub(super) kernels: Vec<X>,
    pub(super) members: Vec<[usize; A]>,
}

impl<X: Clone, const K: usize, const M: usize, const A: usize, const D: usize> LinksInLanes<X, K, M, A, D> {
    /// A kernel of one's own, which is out of reach of what loops write.
    #[inline(always)]
    fn kernel(&self, member: usize) -> X {
        self.kernels[if self.kernels.len() == 1 { 0 } else { member }].clone()
    }
}

/// Where the coordinates of a member's bodies are.
#[inline(always)]
fn places<'a, const K: usize, const A: usize, const D: usize, const W: usize>(
    bodies: &[usize; A],
    q: &'a [Numbers<W>],
) -> [&'a Numbers<W>; K] {
    from_fn(|k| &q[bodies[k / D] * D + k % D])
}

impl<X, const K: usize, const M: usize, const A: usize, const D: usize, const W: usize> RowLinks<W>
    for LinksInLanes<X, K, M, A, D>
where
    X: InLanes<K, M, W>,
{
    fn boxed(&self) -> Box<dyn RowLinks<W>> {
        Box::new(self.clone())
    }

    fn copy(&mut self, from: usize, to: usize) {
        self.kernels.iter_mut().for_each(|kernel| kernel.copy(from, to));
    }

    fn gradients(
        &self,
        set: Fusing,
        members: Range<usize>,
        q: &[Numbers<W>],
        g: &mut [Numbers<W>],
        gradients: &mut [Numbers<W>],
    ) {
        set.run(Gradients { links: self, members, q, g, gradients });
    }

    fn bends(
        &self,
        set: Fusing,
        members: Range<usize>,
        [q, v]: [&[Numbers<W>]; 2],
        bends: &mut [Numbers<W>],
        turns: &mut [Numbers<W>],
    ) {
        set.run(Bends { links: self, members, q, v, bends, turns });
    }
}

struct Gradients<'a, X, const K: usize, const M: usize, const A: usize, const D: usize, const W: usize> {
    links: &'a LinksInLanes<X, K, M, A, D>,
    members: Range<usize>,
    q: &'a [Numbers<W>],
    g: &'a mut [Numbers<W>],
    gradients: &'a mut [Numbers<W>],
}

impl<X, const K: usize, const M: usize, const A: usize, const D: usize, const W: usize> Work
    for Gradients<'_, X, K, M, A, D, W>
where
    X: InLanes<K, M, W>,
{
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { links, members, q, g, gradients } = self;
        let rows = gradients.as_chunks_mut::<K>().0.as_chunks_mut::<M>().0;
        for (member, (g, rows)) in members.zip(g.as_chunks_mut().0.iter_mut().zip(rows)) {
            gradients_of(&links.kernel(member), places::<K, A, D, W>(&links.members[member], q), g, rows);
        }
    }
}

struct Bends<'a, X, const K: usize, const M: usize, const A: usize, const D: usize, const W: usize> {
    links: &'a LinksInLanes<X, K, M, A, D>,
    members: Range<usize>,
    q: &'a [Numbers<W>],
    v: &'a [Numbers<W>],
    bends: &'a mut [Numbers<W>],
    turns: &'a mut [Numbers<W>],
}

impl<X, const K: usize, const M: usize, const A: usize, const D: usize, const W: usize> Work
    for Bends<'_, X, K, M, A, D, W>
where
    X: InLanes<K, M, W>,
{
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { links, members, q, v, bends, turns } = self;
        let rows = bends.as_chunks_mut::<M>().0.iter_mut().zip(turns.as_chunks_mut::<M>().0);
        for (member, (bends, turns)) in members.zip(rows) {
            let of = [q, v].map(|of| places::<K, A, D, W>(&links.members[member], of));
            bends_of(&links.kernel(member), of, bends, turns);
        }
    }
}

/// See [`gradients_of`].
#[inline(always)]
fn bends_of<X: InLanes<K, M, W>, const K: usize, const M: usize, const W: usize>(
    kernel: &X,
    [q, v]: [[&Numbers<W>; K]; 2],
    bends: &mut [Numbers<W>; M],
    turns: &mut [Numbers<W>; M],
) {
    for l in 0..W {
        let direction = from_fn(|k| v[k].0[l]);
        let rows = kernel.lane(l).borrow().hessian_vector(&from_fn(|k| q[k].0[l]), &direction);
        for i in 0..M {
            (bends[i].0[l], turns[i].0[l]) = (dot(&rows[i], &direction), dot(&rows[i], &rows[i]));
        }
    }
}

/// One member. Arguments of a function are known not to overlap, so that the loop becomes one over vectors.
#[inline(always)]
fn gradients_of<X: InLanes<K, M, W>, const K: usize, const M: usize, const W: usize>(
    kernel: &X,
    q: [&Numbers<W>; K],
    g: &mut [Numbers<W>; M],
    rows: &mut [[Numbers<W>; K]; M],
) {
    for l in 0..W {
        let (values, gradients) = kernel.lane(l).borrow().value_and_jacobian(&from_fn(|k| q[k].0[l]));
        for i in 0..M {
            g[i].0[l] = values[i];
            for k in 0..K {
                rows[i][k].0[l] = gradients[i][k];
            }
        }
    }
}
