//! A few linear equations.

use crate::number::real::Real;
use crate::number::vector::{add_scaled, largest};

/// The solution of a few linear equations, by elimination with row exchanges, whatever the scale of each equation; none
/// if they are dependent.
pub(crate) fn solve<const M: usize>(mut a: [[f64; M]; M], mut b: [f64; M]) -> Option<[f64; M]> {
    let mut sizes = a.map(|row| largest(&row));
    for k in 0..M {
        let share = |i: usize| a[i][k].abs() / sizes[i];
        let pivot = (k..M).max_by(|&i, &j| share(i).total_cmp(&share(j)))?;
        a.swap(k, pivot);
        b.swap(k, pivot);
        sizes.swap(k, pivot);
        if a[k][k] == 0.0 || !a[k][k].is_finite() {
            return None;
        }
        for i in k + 1..M {
            let factor = a[i][k] / a[k][k];
            for j in k..M {
                a[i][j] -= factor * a[k][j];
            }
            b[i] -= factor * b[k];
        }
    }
    for k in (0..M).rev() {
        for j in k + 1..M {
            b[k] -= a[k][j] * b[j];
        }
        b[k] /= a[k][k];
    }
    b.iter().all(|x| x.is_finite()).then_some(b)
}

/// The solution of a few linear equations whose matrix is near to a positive one, such as 1 + A with A small,
/// antisymmetric or a product of positive ones: by elimination without exchanges. NaN or infinite where a pivot
/// vanishes.
#[inline(always)]
pub(crate) fn solve_positive<T: Real, const M: usize>(a: [[T; M]; M], x: [T; M]) -> [T; M] {
    eliminated(a, x, |pivot| pivot)
}

/// The same, and NaN where a pivot is not positive.
#[inline(always)]
pub(crate) fn solve_definite<T: Real, const M: usize>(a: [[T; M]; M], x: [T; M]) -> [T; M] {
    let zero = T::from_f64(0.0);
    eliminated(a, x, |pivot| T::select(zero.lt(pivot), pivot, T::from_f64(f64::NAN)))
}

/// The solution with what `allowed` makes of each pivot.
#[inline(always)]
fn eliminated<T: Real, const M: usize>(
    mut a: [[T; M]; M],
    mut x: [T; M],
    allowed: impl Fn(T) -> T,
) -> [T; M] {
    for i in 0..M {
        a[i][i] = allowed(a[i][i]);
        for k in i + 1..M {
            let share = a[k][i] / a[i][i];
            a[k] = add_scaled(&a[k], -share, &a[i]);
            x[k] = x[k] - share * x[i];
        }
    }
    for i in (0..M).rev() {
        for k in i + 1..M {
            x[i] = x[i] - a[i][k] * x[k];
        }
        x[i] = x[i] / a[i][i];
    }
    x
}
