//! A few linear equations.

use crate::number::real::Real;
use crate::number::vector::{add_scaled, largest};
use std::array::from_fn;

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
pub(crate) fn solve_positive<T: Real, const M: usize>(mut a: [[T; M]; M], mut x: [T; M]) -> [T; M] {
    for i in 0..M {
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

/// Rounds of rotations; 5 to 10 do, since what is left is squared in each.
const ROUNDS: usize = 40;

/// The eigenvalues of a symmetric matrix, and for each of them the eigenvector of length 1, by rotations that take one
/// pair of entries after the other to zero (C. Jacobi 1846).
pub(crate) fn axes<const M: usize>(mut a: [[f64; M]; M]) -> ([f64; M], [[f64; M]; M]) {
    let mut axes: [[f64; M]; M] = from_fn(|i| from_fn(|k| f64::from(u8::from(i == k))));
    for _ in 0..ROUNDS {
        let mut turned = false;
        for (i, k) in (0..M).flat_map(|i| (i + 1..M).map(move |k| (i, k))) {
            let size = (a[i][i].abs() * a[k][k].abs()).sqrt();
            if a[i][k].abs() <= 0.125 * f64::EPSILON * size {
                continue;
            }
            turned = true;
            let slope = 0.5 * (a[k][k] - a[i][i]) / a[i][k];
            let tan = 1.0_f64.copysign(slope) / (slope.abs() + slope.hypot(1.0));
            let cos = 1.0 / tan.hypot(1.0);
            let turn = |x: f64, y: f64| [cos * (x - tan * y), cos * (tan * x + y)];
            for line in &mut a {
                [line[i], line[k]] = turn(line[i], line[k]);
            }
            for j in 0..M {
                [a[i][j], a[k][j]] = turn(a[i][j], a[k][j]);
                [axes[i][j], axes[k][j]] = turn(axes[i][j], axes[k][j]);
            }
            (a[i][k], a[k][i]) = (0.0, 0.0);
        }
        if !turned {
            break;
        }
    }
    (from_fn(|i| a[i][i]), axes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::vector::dot;

    /// Of matrices that are badly scaled, with equal eigenvalues, or diagonal: A = Σ λ v vᵀ, and vᵢ·vₖ = δᵢₖ.
    #[test]
    fn axes_of_symmetric_matrices() {
        let bad = [[1e8, 3e3, 10.0], [3e3, 1.0, 2e-4], [10.0, 2e-4, 1e-4]];
        let same = [[2.0, 1.0, 1.0], [1.0, 2.0, 1.0], [1.0, 1.0, 2.0]]; // 1, 1, 4
        let none = [[0.0; 3]; 3];
        let diagonal = [[3.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, -1.0]];
        for a in [bad, same, none, diagonal] {
            let (values, axes) = axes(a);
            for (i, k) in (0..9).map(|at| (at / 3, at % 3)) {
                let again = (0..3).map(|j| values[j] * axes[j][i] * axes[j][k]).sum::<f64>();
                let size = (a[i][i] * a[k][k]).abs().sqrt();
                // Some roundings of 10 rounds of 3 rotations.
                assert!((again - a[i][k]).abs() <= 1e-14 * size, "{i}, {k}: {again:e} of {:e}", a[i][k]);
                let one = if i == k { 1.0 } else { 0.0 };
                assert!((dot(&axes[i], &axes[k]) - one).abs() < 1e-14, "{i}, {k}");
            }
        }
        let (mut values, _) = axes(same);
        values.sort_by(f64::total_cmp);
        assert!(values.iter().zip([1.0, 1.0, 4.0]).all(|(x, exact)| (x - exact).abs() < 1e-14), "{values:?}");
    }
}
