//! Few equations between few bodies, in lanes: their normals by coordinate, and elimination with sizes known when it is
//! compiled. To be called in loops over lanes, for one lane at a time.

use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::number::vector::dot;
use crate::systems::network::in_lanes::{Number, Numbers};
use std::array::from_fn;

/// Calls a function with the sizes (equations, coordinates that are not pinned) that are compiled, if these are such.
macro_rules! sized {
    ($sizes:expr, $run:ident, $otherwise:expr) => {
        match $sizes {
            (1, 2) => $run!(1, 2),
            (1, 3) => $run!(1, 3),
            (1, 4) => $run!(1, 4),
            (1, 6) => $run!(1, 6),
            (2, 4) => $run!(2, 4),
            (2, 6) => $run!(2, 6),
            (3, 6) => $run!(3, 6),
            (3, 9) => $run!(3, 9),
            _ => $otherwise,
        }
    };
}
pub(crate) use sized;

/// G by coordinate, zeros where an equation does not depend on it.
pub(crate) type Normals<'a, const M: usize, const K: usize, const W: usize> = [[&'a Numbers<W>; K]; M];

/// As many rows as there are.
#[inline(always)]
pub(crate) fn of_size<const N: usize, const W: usize>(rows: &mut [Numbers<W>]) -> &mut [Numbers<W>; N] {
    rows.first_chunk_mut().expect("as many as there are")
}

/// See [`of_size`].
#[inline(always)]
pub(crate) fn of_few<const N: usize, const W: usize>(rows: &[Numbers<W>]) -> &[Numbers<W>; N] {
    rows.first_chunk().expect("as many as there are")
}

/// See [`Normals`]. (No `map`, which is a call.)
#[inline(always)]
pub(crate) fn by_coordinate<'a, const M: usize, const K: usize, const W: usize>(
    entry: &[[Option<usize>; K]; M],
    gradient: &'a [Numbers<W>],
    zero: &'a Numbers<W>,
) -> Normals<'a, M, K, W> {
    let mut normals = [[zero; K]; M];
    for i in 0..M {
        for k in 0..K {
            if let Some(number) = entry[i][k] {
                normals[i][k] = &gradient[number];
            }
        }
    }
    normals
}

/// G of a lane.
#[inline(always)]
pub(crate) fn grid<const M: usize, const K: usize, const W: usize>(
    normals: &Normals<M, K, W>,
    l: usize,
) -> [[Number; K]; M] {
    from_fn(|i| from_fn(|k| normals[i][k].0[l]))
}

/// M⁻¹Gᵀ of a lane.
#[inline(always)]
pub(crate) fn lifted<const M: usize, const K: usize, const W: usize>(
    normals: &Normals<M, K, W>,
    over: &[Number; K],
    l: usize,
) -> [[Number; K]; M] {
    from_fn(|i| from_fn(|k| over[k] * normals[i][k].0[l]))
}

/// A coordinate, and what multipliers add to it.
#[inline(always)]
pub(crate) fn sum_of<const M: usize, const K: usize>(
    first: Number,
    lifted: &[[Number; K]; M],
    lambda: &[Number; M],
    k: usize,
) -> Number {
    (0..M).fold(first, |sum, i| lifted[i][k].multiply_add(lambda[i], sum))
}

/// A matrix G′M⁻¹Gᵀ with L below the diagonal, U above it, and on it the inverse pivots; and its diagonal. (Loops with
/// bounds that are known are unrolled, and what is around them becomes a loop over vectors.)
#[inline(always)]
pub(crate) fn factor<const M: usize, const K: usize>(
    normals: &[[Number; K]; M],
    lifted: &[[Number; K]; M],
) -> ([[Number; M]; M], [Number; M]) {
    let (mut matrix, mut slopes) = ([[Fused(0.0); M]; M], [Fused(0.0); M]);
    for i in 0..M {
        for j in 0..M {
            matrix[i][j] = dot(&normals[i], &lifted[j]);
        }
        slopes[i] = matrix[i][i];
    }
    for k in 0..M {
        let inverse = Fused(1.0 / matrix[k][k].0);
        matrix[k][k] = inverse;
        for i in 0..M {
            if i > k {
                matrix[i][k] = matrix[i][k] * inverse;
                for j in 0..M {
                    if j > k {
                        matrix[i][j] = (-matrix[i][k]).multiply_add(matrix[k][j], matrix[i][j]);
                    }
                }
            }
        }
    }
    (matrix, slopes)
}

/// Solves a factored system.
#[inline(always)]
pub(crate) fn solve<const M: usize>(matrix: &[[Number; M]; M], g: [Number; M]) -> [Number; M] {
    let mut x = g;
    for i in 0..M {
        for k in 0..M {
            if k < i {
                x[i] = (-matrix[i][k]).multiply_add(x[k], x[i]);
            }
        }
    }
    for from_last in 0..M {
        let i = M - 1 - from_last;
        for j in 0..M {
            if j > i {
                x[i] = (-matrix[i][j]).multiply_add(x[j], x[i]);
            }
        }
        x[i] = x[i] * matrix[i][i];
    }
    x
}
