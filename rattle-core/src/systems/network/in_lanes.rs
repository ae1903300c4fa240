//! Links of a network for trajectories in lanes: each number of a link is a row of numbers, one for each trajectory.
//!
//! Made from a [`Group`](crate::systems::network::group::Group) for ensembles alone. Its type does not contain the
//! number of coordinates of a body, so code that uses it is compiled once, not for every scene.

use crate::kernel::functions::ConstraintKernel;
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::{Fused, Lanes};
use std::array::from_fn;
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

/// Links whose numbers are rows. `q` are the coordinates of all bodies in turn; g, and the entries of ∂g/∂q by equation
/// and coordinate of the link's bodies, are written one after the other.
pub(crate) trait InLanes<const W: usize>: Send + Sync {
    /// g and ∂g/∂q of some members.
    fn gradients(
        &self,
        set: Fusing,
        members: Range<usize>,
        q: &[Numbers<W>],
        g: &mut [Numbers<W>],
        gradients: &mut [Numbers<W>],
    );
}

/// Copies of one constraint between A bodies of D coordinates; K = A·D.
pub(super) struct LinksInLanes<H, const K: usize, const M: usize, const A: usize, const D: usize> {
    /// One for all members, or one for each.
    pub(super) kernels: Vec<H>,
    pub(super) members: Vec<[usize; A]>,
}

impl<H: Clone, const K: usize, const M: usize, const A: usize, const D: usize> LinksInLanes<H, K, M, A, D> {
    /// A kernel of one's own, which is out of reach of what loops write.
    #[inline(always)]
    fn kernel(&self, member: usize) -> H {
        self.kernels[if self.kernels.len() == 1 { 0 } else { member }].clone()
    }

    /// Where the coordinates of a member's bodies are.
    #[inline(always)]
    fn places<'a, const W: usize>(&self, member: usize, q: &'a [Numbers<W>]) -> [&'a Numbers<W>; K] {
        let bodies = &self.members[member];
        from_fn(|k| &q[bodies[k / D] * D + k % D])
    }
}

impl<H, const K: usize, const M: usize, const A: usize, const D: usize, const W: usize> InLanes<W>
    for LinksInLanes<H, K, M, A, D>
where
    H: ConstraintKernel<Number, K, M>,
{
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
}

struct Gradients<'a, H, const K: usize, const M: usize, const A: usize, const D: usize, const W: usize> {
    links: &'a LinksInLanes<H, K, M, A, D>,
    members: Range<usize>,
    q: &'a [Numbers<W>],
    g: &'a mut [Numbers<W>],
    gradients: &'a mut [Numbers<W>],
}

impl<H, const K: usize, const M: usize, const A: usize, const D: usize, const W: usize> Work
    for Gradients<'_, H, K, M, A, D, W>
where
    H: ConstraintKernel<Number, K, M>,
{
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { links, members, q, g, gradients } = self;
        let rows = gradients.as_chunks_mut::<K>().0.as_chunks_mut::<M>().0;
        for (member, (g, rows)) in members.zip(g.as_chunks_mut().0.iter_mut().zip(rows)) {
            gradients_of(&links.kernel(member), links.places(member, q), g, rows);
        }
    }
}

/// One member. Arguments of a function are known not to overlap, so that the loop becomes one over vectors.
#[inline(always)]
fn gradients_of<H, const K: usize, const M: usize, const W: usize>(
    kernel: &H,
    q: [&Numbers<W>; K],
    g: &mut [Numbers<W>; M],
    rows: &mut [[Numbers<W>; K]; M],
) where
    H: ConstraintKernel<Number, K, M>,
{
    for l in 0..W {
        let (values, gradients) = kernel.value_and_jacobian(&from_fn(|k| q[k].0[l]));
        for i in 0..M {
            g[i].0[l] = values[i];
            for k in 0..K {
                rows[i][k].0[l] = gradients[i][k];
            }
        }
    }
}
