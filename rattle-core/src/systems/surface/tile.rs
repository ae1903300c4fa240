//! A tile of bodies, put into lanes and written back.

use crate::effect::force::Force;
use crate::effect::list::Forces;
use crate::motion::bodies::Count;
use crate::number::lanes::Fused;
use crate::number::real::Scalar;
use crate::number::vectors::Chunks;
use crate::systems::surface::in_lanes::{InEach, Number, TileInLanes};
use crate::systems::surface::kept::BodiesOf;
use crate::systems::surface::normal::Normal;
use std::array::from_fn;
use std::ops::Range;

/// Some bodies, and what is kept at them.
pub(super) struct Tile<'a, T, F, const D: usize> {
    pub(super) q: &'a mut [[T; D]],
    pub(super) q_low: &'a mut [[T; D]],
    pub(super) p: &'a mut [[T; D]],
    pub(super) p_low: &'a mut [[T; D]],
    pub(super) normal: &'a mut [Normal<T, D>],
    pub(super) force: &'a [F],
    pub(super) lanes: &'a mut TileInLanes<D>,
    pub(super) chunks: Chunks,
}

impl<'a, T: Scalar, F: Force<T, D>, const D: usize> Tile<'a, T, F, D> {
    #[inline(always)]
    pub(super) fn of<N: Count, E: Forces<T, D, Force = F>>(
        bodies: &'a mut BodiesOf<N, T, E, D>,
        tile: Range<usize>,
    ) -> Self {
        Self {
            chunks: Chunks::of(tile.len()),
            q: &mut bodies.q.as_mut()[tile.clone()],
            q_low: &mut bodies.q_low.as_mut()[tile.clone()],
            p: &mut bodies.p.as_mut()[tile.clone()],
            p_low: &mut bodies.p_low.as_mut()[tile.clone()],
            normal: &mut bodies.kept.normal.as_mut()[tile.clone()],
            force: &bodies.kept.force.as_ref()[tile],
            lanes: bodies.kept.lanes.get_or_insert_with(|| Box::new(TileInLanes::new())),
        }
    }

    /// Puts everything into lanes. Lanes past the last body have what was there: they are not looked at.
    #[inline(always)]
    pub(super) fn spread(&mut self) -> &mut TileInLanes<D> {
        let Self { q, q_low, lanes, chunks, .. } = self;
        chunks.put_into(q, &mut lanes.q, 0, |q| q.map(fused));
        chunks.put_into(q_low, &mut lanes.q_low, 0, |q| q.map(fused));
        self.spread_momenta()
    }

    /// Puts everything but positions into lanes.
    #[inline(always)]
    pub(super) fn spread_momenta(&mut self) -> &mut TileInLanes<D> {
        let Self { p, p_low, normal, force, lanes, chunks, .. } = self;
        let length = chunks.length();
        for begin in chunks.begins() {
            let (p, p_low) = (&p[begin..][..length], &p_low[begin..][..length]);
            let (normal, force) = (&normal[begin..][..length], &force[begin..][..length]);
            let (high, low) = (rows(&mut lanes.p, begin, length), rows(&mut lanes.p_low, begin, length));
            let gradients = rows(&mut lanes.normal, begin, length);
            let inverse_squares = &mut lanes.inverse_square[begin..][..length];
            let forces = rows(&mut lanes.force, begin, length);
            for l in 0..length {
                let (Normal { gradient, inverse_square }, force) = (&normal[l], force[l].components());
                for d in 0..D {
                    high[d][l] = fused(p[l][d]);
                    low[d][l] = fused(p_low[l][d]);
                    gradients[d][l] = fused(gradient[d]);
                    if F::ACTS {
                        forces[d][l] = fused(force[d]);
                    }
                }
                inverse_squares[l] = fused(*inverse_square);
            }
        }
        lanes
    }

    /// λ or μ of a body.
    pub(super) fn multiplier(&self, body: usize) -> T {
        plain(self.lanes.multiplier[body])
    }

    /// Writes places and normals.
    #[inline(always)]
    pub(super) fn keep_places(&mut self) {
        let Self { q, q_low, normal, lanes, chunks, .. } = self;
        chunks.take_out(&lanes.q, q, |q| q.map(plain));
        chunks.take_out(&lanes.q_low, q_low, |q| q.map(plain));
        let length = chunks.length();
        for begin in chunks.begins() {
            let normals = &mut normal[begin..][..length];
            let gradients = lanes.normal.each_ref().map(|row| &row[begin..][..length]);
            let inverse_squares = &lanes.inverse_square[begin..][..length];
            for l in 0..length {
                let gradient = from_fn(|d| plain(gradients[d][l]));
                normals[l] = Normal { gradient, inverse_square: plain(inverse_squares[l]) };
            }
        }
    }

    /// Writes momenta.
    #[inline(always)]
    pub(super) fn keep_momenta(&mut self) {
        let Self { p, p_low, lanes, chunks, .. } = self;
        chunks.take_out(&lanes.p, p, |p| p.map(plain));
        chunks.take_out(&lanes.p_low, p_low, |p| p.map(plain));
    }
}

/// The lanes of a chunk of vectors, coordinate by coordinate.
#[inline(always)]
fn rows<const D: usize>(lanes: &mut InEach<D>, begin: usize, length: usize) -> [&mut [Number]; D] {
    lanes.each_mut().map(|row| &mut row[begin..][..length])
}

#[inline(always)]
pub(super) fn fused<T: Scalar>(x: T) -> Number {
    Fused(x.to_f64())
}

#[inline(always)]
pub(super) fn plain<T: Scalar>(x: Number) -> T {
    T::from_f64(x.0)
}
