//! A tile of bodies, spread over lanes and written back.

use crate::effect::force::Force;
use crate::effect::list::Forces;
use crate::motion::bodies::Count;
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::number::vectors::{Vectors, at, put};
use crate::systems::surface::kept::BodiesOf;
use crate::systems::surface::normal::Normal;
use std::ops::Range;

/// A number of a lane.
pub(super) type Number = Fused<f64>;

/// Some bodies, at least one, and what is kept at them.
pub(super) struct Tile<'a, T, F, const D: usize> {
    pub(super) q: &'a mut [[T; D]],
    pub(super) q_low: &'a mut [[T; D]],
    pub(super) p: &'a mut [[T; D]],
    pub(super) p_low: &'a mut [[T; D]],
    pub(super) normal: &'a mut [Normal<T, D>],
    pub(super) force: &'a [F],
}

impl<'a, T: Real, F: Force<T, D>, const D: usize> Tile<'a, T, F, D> {
    #[inline(always)]
    pub(super) fn of<N: Count, E: Forces<T, D, Force = F>>(
        bodies: &'a mut BodiesOf<N, T, E, D>,
        tile: Range<usize>,
    ) -> Self {
        Self {
            q: &mut bodies.q.as_mut()[tile.clone()],
            q_low: &mut bodies.q_low.as_mut()[tile.clone()],
            p: &mut bodies.p.as_mut()[tile.clone()],
            p_low: &mut bodies.p_low.as_mut()[tile.clone()],
            normal: &mut bodies.kept.normal.as_mut()[tile.clone()],
            force: &bodies.kept.force.as_ref()[tile],
        }
    }

    /// ∇g and 1/|∇g|² in lanes.
    #[inline(always)]
    pub(super) fn normals<const L: usize>(&self) -> (Vectors<Number, L, D>, [Number; L]) {
        let (mut gradient, mut inverse_square) = ([[Fused(0.0); L]; D], [Fused(0.0); L]);
        spread::<_, L>(self.normal, |l, normal| {
            put(&mut gradient, l, normal.gradient.map(fused));
            inverse_square[l] = fused(normal.inverse_square);
        });
        (gradient, inverse_square)
    }

    /// Forces in lanes; zeros where there are none.
    #[inline(always)]
    pub(super) fn forces<const L: usize>(&self) -> Vectors<Number, L, D> {
        let mut lanes = [[Fused(0.0); L]; D];
        if F::ACTS {
            spread::<_, L>(self.force, |l, force| put(&mut lanes, l, force.components().map(fused)));
        }
        lanes
    }
}

#[inline(always)]
pub(super) fn fused<T: Real>(x: T) -> Number {
    Fused(x.lanes().next().unwrap_or(f64::NAN))
}

#[inline(always)]
pub(super) fn plain<T: Real>(x: Number) -> T {
    T::from_f64(x.0)
}

/// Puts each of at most L into its lane; the last lanes repeat the last one. (A loop of a length that is not known when
/// compiling stays one; unrolled, this would not fit the cache of instructions.)
#[inline(always)]
fn spread<X, const L: usize>(each: &[X], mut put: impl FnMut(usize, &X)) {
    let number = each.len().min(L);
    for l in 0..number {
        put(l, &each[l]);
    }
    for l in number..L {
        put(l, &each[number - 1]);
    }
}

/// Vectors in lanes.
#[inline(always)]
pub(super) fn gathered<T: Real, const L: usize, const D: usize>(vectors: &[[T; D]]) -> Vectors<Number, L, D> {
    let mut lanes = [[Fused(0.0); L]; D];
    spread::<_, L>(vectors, |l, vector| put(&mut lanes, l, vector.map(fused)));
    lanes
}

/// Writes the first lanes to bodies' vectors.
#[inline(always)]
pub(super) fn scatter<T: Real, const L: usize, const D: usize>(
    lanes: &Vectors<Number, L, D>,
    vectors: &mut [[T; D]],
) {
    for (l, vector) in vectors.iter_mut().enumerate().take(L) {
        *vector = at(lanes, l).map(plain);
    }
}
