//! Bodies in tiles, asked whether other sheets are near: see [`crate::solve::crowd`].

use crate::effect::force::Force;
use crate::kernel::functions::ConstraintKernel;
use crate::number::instructions::Work;
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::number::vector::dot;
use crate::number::vectors::{LANES, at};
use crate::solve::crowd::{EVERY as SHARES_EVERY, PATH, REACH, rises, shares};
use crate::systems::surface::tile::{Number, Tile, gathered};
use crate::systems::surface::tiles::{MANY, tiles};

/// After so many drifts it is asked again: for one step of a tile that has to be gone on from, it is asked more often than
/// where a stretch can be gone through again.
pub(super) const EVERY: u64 = 16;

/// Which bodies of a simulation are to be moved one by one, since other sheets are near.
#[derive(Debug, Clone)]
pub(crate) struct Crowd {
    /// A bit for each body of a tile.
    tiles: Vec<u64>,
    drifts: u64,
    longest: f64,
    /// Whether one was, when it was last asked after a step that did not follow its root.
    pub(super) near: bool,
}

impl Crowd {
    /// Room for so many bodies, of which nothing is known.
    pub(super) fn of(bodies: usize) -> Self {
        let tiles = if bodies < MANY { 0 } else { tiles(bodies).count() };
        Self { tiles: vec![0; tiles], drifts: 0, longest: 0.0, near: false }
    }

    /// Nothing is known any more.
    pub(super) fn forget(&mut self) {
        (self.drifts, self.longest) = (0, 0.0);
    }

    /// Before a drift of length h: if it is time to ask, after how many steps of [`shares`], and for which length.
    pub(super) fn turn(&mut self, h: f64) -> Option<(u64, f64)> {
        let (now, longer) = (self.drifts, h.abs() > self.longest);
        self.drifts += 1;
        self.longest = self.longest.max(h.abs());
        let turn = if longer { 0 } else { now / EVERY * SHARES_EVERY };
        (longer || now % EVERY == 0).then_some((turn, self.longest))
    }

    /// Notes which bodies of a tile are in a crowd.
    pub(super) fn note(&mut self, tile: usize, bodies: u64) {
        self.tiles[tile] = bodies;
    }

    /// The bodies of a tile that are to be moved one by one.
    pub(super) fn of_tile(&self, tile: usize) -> u64 {
        self.tiles[tile]
    }
}

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
        let Self { constraint, bodies, h, turn } = self;
        let constraint = constraint.clone(); // out of reach of what the loops write
        let number = bodies.q.len().min(LANES);
        let (q, p) = (gathered::<T, LANES, D>(bodies.q), gathered::<T, LANES, D>(bodies.p));
        let ((normal, inverse_square), force) = (bodies.normals::<LANES>(), bodies.forces::<LANES>());
        let [pushed, path] = [REACH * 0.5 * h * h, REACH * PATH * h].map(Fused);
        let (mut square, mut furthest) = ([Fused(0.0); LANES], [Fused(0.0); LANES]);
        for l in 0..number {
            let (p, f) = (at(&p, l), at(&force, l));
            let [bend] = constraint.jet(&at(&q, l), &p).2;
            let free = path * path * dot(&p, &p) + pushed * pushed * dot(&f, &f);
            let back = pushed * bend.abs() * inverse_square[l];
            furthest[l] = back + Real::sqrt(free * inverse_square[l]);
            square[l] = Fused(1.0) / inverse_square[l];
        }
        let mut least = square;
        for share in shares(turn) {
            for l in 0..number {
                let shift = Fused(share) * furthest[l];
                let rises = rises(&constraint, &at(&q, l), &at(&normal, l), square[l], shift);
                least[l] = Real::select(rises.le(least[l]), rises, least[l]);
            }
        }
        (0..number).fold(0, |bits, l| bits | u64::from(!Fused(0.0).le(least[l])) << l)
    }
}
