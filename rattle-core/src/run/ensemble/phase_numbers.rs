//! A few numbers of one lane: sizes of vectors of phase space, and linear equations.

use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::number::vector::largest;
use crate::run::ensemble::phase_row::{Each, Number};

/// The larger number, or the one that is none.
#[inline(always)]
fn most(most: Number, x: Number) -> Number {
    Real::select(most.lt(x) | !x.le(x), x, most)
}

/// How many times a vector of phase space is as large as the other, in positions or in momenta, whichever is more; 0
/// where the other is.
#[inline(always)]
pub(super) fn over<const D: usize>(
    [q, p]: &[[Number; D]; 2],
    [other_q, other_p]: &[[Number; D]; 2],
) -> Number {
    let part = |x: &[Number; D], other: &[Number; D]| {
        let (size, length) = (largest(x), largest(other));
        Real::select(Fused(0.0).lt(length), size / length, Fused(0.0))
    };
    part(q, other_q).max(part(p, other_p))
}

/// The solution of a few linear equations, by elimination with row exchanges; no numbers where they are dependent.
#[inline(always)]
pub(super) fn solve<const M: usize>(mut a: [[Number; M]; M], mut b: [Number; M]) -> [Number; M] {
    for k in 0..M {
        for i in k + 1..M {
            let swap = a[k][k].abs().lt(a[i][k].abs());
            for j in k..M {
                (a[k][j], a[i][j]) =
                    (Real::select(swap, a[i][j], a[k][j]), Real::select(swap, a[k][j], a[i][j]));
            }
            (b[k], b[i]) = (Real::select(swap, b[i], b[k]), Real::select(swap, b[k], b[i]));
        }
        for i in k + 1..M {
            let factor = a[i][k] / a[k][k];
            for j in k + 1..M {
                a[i][j] = (-factor).multiply_add(a[k][j], a[i][j]);
            }
            b[i] = (-factor).multiply_add(b[k], b[i]);
        }
    }
    for k in (0..M).rev() {
        for j in k + 1..M {
            b[k] = (-a[k][j]).multiply_add(b[j], b[k]);
        }
        b[k] = b[k] / a[k][k];
    }
    b
}

/// The largest entry of N⁻¹N′ − 1, as in a simulation; not a number where that has none.
#[inline(always)]
pub(super) fn turn<const M: usize>(before: [[Number; M]; M], after: &[[Number; M]; M]) -> Number {
    let (mut largest, mut units) = ([Fused(0.0); 2], [Fused(1.0); M]);
    for i in 0..M {
        let diagonal = before[i][i].abs();
        units[i] = Real::select(Fused(0.0).lt(diagonal), diagonal.sqrt(), units[i]);
    }
    for j in 0..M {
        let mut column = [Fused(0.0); M];
        for i in 0..M {
            column[i] = after[i][j];
        }
        let column = solve(before, column);
        for i in 0..M {
            let one = Fused(f64::from(u8::from(i == j)));
            let off = (column[i] - one).abs();
            largest = [most(largest[0], off), most(largest[1], off * (units[i] / units[j]))];
        }
    }
    Real::select(largest[1].lt(largest[0]), largest[1], largest[0])
}

/// The most roundings that one of these values has; not a number where one has not.
#[inline(always)]
pub(super) fn worst<const M: usize>(value: &[Each; M], size: &[Each; M], l: usize) -> Number {
    let mut worst = Fused(0.0);
    for m in 0..M {
        let roundings = value[m][l].abs() / (Fused(f64::EPSILON) * size[m][l]);
        worst = most(worst, Real::select(value[m][l] == Fused(0.0), Fused(0.0), roundings));
    }
    worst
}
