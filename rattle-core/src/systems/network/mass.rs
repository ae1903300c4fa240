//! Masses: M in pᵀM⁻¹p/2, one block per body.

use crate::number::vector::dot;
use nalgebra::SMatrix;
use std::array::from_fn;

/// The mass of one body with D coordinates.
#[doc(alias = "inertia")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mass<const D: usize> {
    /// Mass 1: momenta are velocities.
    Unit,
    /// One mass for each coordinate.
    Diagonal([f64; D]),
    /// A symmetric positive definite matrix, row by row.
    Matrix([[f64; D]; D]),
}

impl<const D: usize> From<f64> for Mass<D> {
    fn from(mass: f64) -> Self {
        Self::Diagonal([mass; D])
    }
}

impl<const D: usize> From<[f64; D]> for Mass<D> {
    fn from(masses: [f64; D]) -> Self {
        Self::Diagonal(masses)
    }
}

impl<const D: usize> From<SMatrix<f64, D, D>> for Mass<D> {
    fn from(matrix: SMatrix<f64, D, D>) -> Self {
        Self::Matrix(from_fn(|i| from_fn(|j| matrix[(i, j)])))
    }
}

/// L⁻¹ and its transpose for M = L Lᵀ: what a step needs of the masses. A body that is pinned has M⁻¹ = 0.
#[derive(Debug, Clone)]
pub(crate) enum Root<const D: usize> {
    Unit,
    Pinned,
    /// 1/mᵢ and 1/√mᵢ.
    Diagonal {
        inverse: [f64; D],
        root: [f64; D],
    },
    /// L, row by row.
    Cholesky([[f64; D]; D]),
}

impl<const D: usize> Root<D> {
    /// None where the mass is not positive definite or not finite.
    pub(crate) fn new(mass: &Mass<D>) -> Option<Self> {
        match mass {
            Mass::Unit => Some(Self::Unit),
            Mass::Diagonal(m) => {
                let inverse = m.map(|m| 1.0 / m);
                let fine = m.iter().zip(&inverse).all(|(m, i)| *m > 0.0 && m.is_finite() && i.is_finite());
                fine.then(|| Self::Diagonal { inverse, root: inverse.map(f64::sqrt) })
            }
            Mass::Matrix(m) if (0..D).all(|i| (0..D).all(|j| i == j || m[i][j] == 0.0)) => {
                Self::new(&Mass::Diagonal(from_fn(|i| m[i][i])))
            }
            Mass::Matrix(m) => cholesky(m).map(Self::Cholesky),
        }
    }

    /// M⁻¹ p.
    #[inline]
    pub(crate) fn velocity(&self, p: &[f64; D]) -> [f64; D] {
        match self {
            Self::Unit => *p,
            Self::Pinned => [0.0; D],
            Self::Diagonal { inverse, .. } => from_fn(|i| inverse[i] * p[i]),
            Self::Cholesky(_) => self.halve_transposed(&self.halve(p)),
        }
    }

    /// 1/m along each coordinate, 0 where pinned; none where the mass is a matrix.
    pub(crate) fn over_masses(&self) -> Option<[f64; D]> {
        match self {
            Self::Unit => Some([1.0; D]),
            Self::Pinned => Some([0.0; D]),
            Self::Diagonal { inverse, .. } => Some(*inverse),
            Self::Cholesky(_) => None,
        }
    }

    /// aᵀM b; 0 where pinned.
    pub(crate) fn product(&self, a: &[f64; D], b: &[f64; D]) -> f64 {
        match self {
            Self::Unit => dot(a, b),
            Self::Pinned => 0.0,
            Self::Diagonal { inverse, .. } => (0..D).map(|i| a[i] * b[i] / inverse[i]).sum(),
            Self::Cholesky(l) => {
                let half = |u: &[f64; D], j: usize| (j..D).map(|i| l[i][j] * u[i]).sum::<f64>(); // (Lᵀu)ⱼ
                (0..D).map(|j| half(a, j) * half(b, j)).sum()
            }
        }
    }

    /// L⁻¹ u.
    #[inline]
    pub(crate) fn halve(&self, u: &[f64; D]) -> [f64; D] {
        match self {
            Self::Unit => *u,
            Self::Pinned => [0.0; D],
            Self::Diagonal { root, .. } => from_fn(|i| root[i] * u[i]),
            Self::Cholesky(l) => {
                let mut x = *u;
                for i in 0..D {
                    for j in 0..i {
                        x[i] -= l[i][j] * x[j];
                    }
                    x[i] /= l[i][i];
                }
                x
            }
        }
    }

    /// L⁻ᵀ u.
    #[inline]
    pub(crate) fn halve_transposed(&self, u: &[f64; D]) -> [f64; D] {
        match self {
            Self::Cholesky(l) => {
                let mut x = *u;
                for i in (0..D).rev() {
                    for j in i + 1..D {
                        x[i] -= l[j][i] * x[j];
                    }
                    x[i] /= l[i][i];
                }
                x
            }
            _ => self.halve(u),
        }
    }

    /// L u, for a body that is not pinned.
    #[inline]
    pub(crate) fn restore(&self, u: &[f64; D]) -> [f64; D] {
        match self {
            Self::Unit => *u,
            Self::Pinned => [0.0; D],
            Self::Diagonal { root, .. } => from_fn(|i| u[i] / root[i]),
            Self::Cholesky(l) => from_fn(|i| (0..=i).map(|j| l[i][j] * u[j]).sum()),
        }
    }

    /// Whether M⁻¹ acts on each coordinate by itself.
    pub(crate) fn is_diagonal(&self) -> bool {
        !matches!(self, Self::Cholesky(_))
    }
}

/// L with M = L Lᵀ; None where M is not symmetric positive definite.
fn cholesky<const D: usize>(m: &[[f64; D]; D]) -> Option<[[f64; D]; D]> {
    if !m.iter().flatten().all(|x| x.is_finite()) {
        return None;
    }
    let largest = m.iter().flatten().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    let mut l = [[0.0; D]; D];
    for i in 0..D {
        for j in 0..=i {
            if (m[i][j] - m[j][i]).abs() > 16.0 * f64::EPSILON * largest {
                return None;
            }
            let rest = m[i][j] - dot(&l[i], &l[j]);
            if i == j {
                if !(rest > 0.0 && (1.0 / rest).is_finite()) {
                    return None;
                }
                l[i][i] = rest.sqrt();
            } else {
                l[i][j] = rest / l[j][j];
            }
        }
    }
    Some(l)
}
