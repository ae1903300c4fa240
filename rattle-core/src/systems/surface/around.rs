//! Whether other sheets are near bodies in tiles: see [`crate::solve::crowd`].

use crate::effect::force::Force;
use crate::kernel::functions::ConstraintKernel;
use crate::number::instructions::Work;
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::number::vector::largest;
use crate::number::vectors::{LANES, at};
use crate::solve::crowd::{PATH, REACH, ROOT_3, rises, shares};
use crate::systems::surface::in_lanes::{InLanes, Number};
use crate::systems::surface::tile::Tile;

/// Asks at most [`LANES`] bodies, before a step of length h.
pub(super) struct Around<'a, T, K, F, const D: usize> {
    pub(super) constraint: &'a K,
    pub(super) bodies: Tile<'a, T, F, D>,
    pub(super) h: f64,
    /// After so many steps of [`shares`].
    pub(super) turn: u64,
}

impl<T: Real, K: ConstraintKernel<Number, D, 1>, F: Force<T, D>, const D: usize> Work
    for Around<'_, T, K, F, D>
{
    /// A bit for each body in a crowd.
    type Done = u64;

    #[inline(always)]
    fn run(self) -> u64 {
        let Self { constraint, mut bodies, h, turn } = self;
        let constraint = constraint.clone(); // out of reach of what the loops write
        let number = bodies.q.len().min(LANES);
        let InLanes { q, p, normal, force, inverse_square, square, first: furthest, slope: least, .. } =
            bodies.spread();
        let [pushed, path] = [REACH * 0.5 * h * h, REACH * PATH * h].map(Fused);
        for l in 0..LANES {
            let p = at(p, l);
            let [bend] = constraint.jet(&at(q, l), &p).2;
            let over = Fused(ROOT_3) * largest(&at(normal, l)) * inverse_square[l];
            let along = over * path * largest(&p);
            let back = pushed * bend.abs() * inverse_square[l];
            furthest[l] = Real::min(back, along) + along;
            if F::ACTS {
                furthest[l] = furthest[l] + over * pushed * largest(&at(force, l));
            }
            square[l] = Fused(1.0) / inverse_square[l];
            least[l] = square[l];
        }
        for share in shares(turn) {
            for l in 0..LANES {
                let shift = Fused(share) * furthest[l];
                let rises = rises(&constraint, &at(q, l), &at(normal, l), square[l], shift);
                least[l] = Real::select(rises.le(least[l]), rises, least[l]);
            }
        }
        (0..number).fold(0, |bits, l| bits | u64::from(!Fused(0.0).le(least[l])) << l)
    }
}
