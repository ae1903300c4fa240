//! Vectors side by side: a coordinate of all, then the next, as loops over lanes read them.

use std::array::from_fn;

/// Lanes of a full block of trajectories or tile of bodies.
pub(crate) const LANES: usize = 64;

/// Coordinates beyond which as many vectors in lanes would no longer fit the nearest cache, or the stack.
pub(crate) const MOST_COORDINATES: usize = 16;

/// D coordinates in each of L lanes.
pub(crate) type Vectors<S, const L: usize, const D: usize> = [[S; L]; D];

/// The vector in a lane.
#[inline(always)]
pub(crate) fn at<S: Copy, const L: usize, const D: usize>(vectors: &Vectors<S, L, D>, lane: usize) -> [S; D] {
    from_fn(|d| vectors[d][lane])
}

/// Puts a vector into a lane.
#[inline(always)]
pub(crate) fn put<S: Copy, const L: usize, const D: usize>(
    vectors: &mut Vectors<S, L, D>,
    lane: usize,
    x: [S; D],
) {
    for d in 0..D {
        vectors[d][lane] = x[d];
    }
}
