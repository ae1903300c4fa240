//! Power series of links' gradients for a few trajectories in lanes: each coefficient is an array with a number for
//! each lane.
//!
//! Made from a [`LinkGroup`](crate::systems::network::group::LinkGroup) for ensembles by power series alone. All links
//! of a kind take their [products](Products) from the same memory.

use crate::kernel::functions::ConstraintKernel;
use crate::kernel::series::{Order, Products};
use crate::number::instructions::{Fusing, Work};
use crate::systems::network::in_lanes::{FEW, Numbers, zeros};
use std::ops::Range;

/// Some members in turn, and the first entry of their gradients.
pub(crate) type Run = (Range<usize>, usize);

/// Links as power series. `q` are the coordinates of all bodies in turn.
pub(crate) trait LinkSeries: Send + Sync {
    /// Blocks of products of these runs; none where a function has no series.
    fn blocks(&self, runs: &[Run]) -> Option<usize>;

    /// Writes coefficient k of ∂g/∂q, by equation and coordinate of the link's bodies, from that of the coordinates.
    /// The lower ones were written before, with the same products.
    fn gradients(
        &self,
        set: Fusing,
        runs: &[Run],
        k: usize,
        q: &[Numbers<FEW>],
        gradients: &mut [Numbers<FEW>],
        products: &mut Products<Numbers<FEW>>,
    );
}

/// Copies of one constraint between A bodies of D coordinates; K = A·D.
pub(super) struct LinksInSeries<H, const K: usize, const M: usize, const A: usize, const D: usize> {
    /// One for all members, or one for each.
    pub(super) kernels: Vec<H>,
    pub(super) members: Vec<[usize; A]>,
}

impl<H, const K: usize, const M: usize, const A: usize, const D: usize> LinksInSeries<H, K, M, A, D> {
    #[inline(always)]
    fn kernel(&self, member: usize) -> &H {
        &self.kernels[if self.kernels.len() == 1 { 0 } else { member }]
    }
}

impl<H, const K: usize, const M: usize, const A: usize, const D: usize> LinkSeries
    for LinksInSeries<H, K, M, A, D>
where
    H: ConstraintKernel<Numbers<FEW>, K, M>,
{
    fn blocks(&self, runs: &[Run]) -> Option<usize> {
        runs.iter().flat_map(|(members, _)| members.clone()).map(|member| self.kernel(member).series()).sum()
    }

    fn gradients(
        &self,
        set: Fusing,
        runs: &[Run],
        k: usize,
        q: &[Numbers<FEW>],
        gradients: &mut [Numbers<FEW>],
        products: &mut Products<Numbers<FEW>>,
    ) {
        // In narrow registers: whoever has links compiles this, and it is little of an expansion.
        set.run_narrow(Gradients { links: self, runs, k, q, gradients, products });
    }
}

struct Gradients<'a, H, const K: usize, const M: usize, const A: usize, const D: usize> {
    links: &'a LinksInSeries<H, K, M, A, D>,
    runs: &'a [Run],
    k: usize,
    q: &'a [Numbers<FEW>],
    gradients: &'a mut [Numbers<FEW>],
    products: &'a mut Products<Numbers<FEW>>,
}

impl<H, const K: usize, const M: usize, const A: usize, const D: usize> Work for Gradients<'_, H, K, M, A, D>
where
    H: ConstraintKernel<Numbers<FEW>, K, M>,
{
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { links, runs, k, q, gradients, products } = self;
        if k == 0 {
            each(links, runs, q, gradients, &mut products.first());
        } else {
            each(links, runs, q, gradients, &mut products.next_within(k));
        }
    }
}

/// Those of all runs.
#[inline(always)]
fn each<const FIRST: bool, H, const K: usize, const M: usize, const A: usize, const D: usize>(
    links: &LinksInSeries<H, K, M, A, D>,
    runs: &[Run],
    q: &[Numbers<FEW>],
    gradients: &mut [Numbers<FEW>],
    order: &mut Order<'_, Numbers<FEW>, FIRST>,
) where
    H: ConstraintKernel<Numbers<FEW>, K, M>,
{
    for (members, entry) in runs {
        let rows = gradients[*entry..].as_chunks_mut::<K>().0.as_chunks_mut::<M>().0;
        for (member, to) in members.clone().zip(rows) {
            let (bodies, mut variables) = (&links.members[member], [zeros(); K]);
            for k in 0..K {
                variables[k] = q[bodies[k / D] * D + k % D];
            }
            *to = links.kernel(member).jacobian_series(&variables, order);
        }
    }
}
