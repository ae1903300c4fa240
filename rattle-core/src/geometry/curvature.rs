//! Curvatures of constraint surfaces, in any dimension.
//!
//! ```text
//! n = ∇g/|∇g|     S = P ∇²g P/|∇g|,  P = 1 − n nᵀ            S v: the change of n along v
//! κ(v) = v·S v/|v|²     H = tr S/(D−1)     K = det S on the tangent space
//! ```
//!
//! **Sign**: κ is positive where the surface bends away from ∇g. With g growing outwards a sphere of radius r has
//! κ = H = 1/r and K = 1/r². For −g, κ and H change sign; K does too if D is even.
//!
//! **Mechanics**: g(q(t)) = 0 differentiated twice gives the multiplier of q̈ = f + ∇g λ,
//!
//! ```text
//! λ |∇g| = −(κ |v|² + n·f)
//! ```
//!
//! so the multiplier of a free particle is given by the normal curvature along its path, and that of a force by the
//! component normal to the surface. A RATTLE step needs h·|κ|·|v| < 1.
//!
//! Formulas: Goldman 2005, “Curvature formulas for implicit curves and surfaces”.

use crate::kernel::functions::Constraint;
use nalgebra::{DMatrix, SVector, SymmetricEigen};

/// A tangential part that is smaller than this part of a vector is rounding.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Curvatures of the level set of g through q, for every [`Constraint`] of one equation.
///
/// q need not lie on g = 0: the surface is the one on which g has the value g(q). Where ∇g = 0, everything is NaN;
/// where ∇²g is not finite, NaN or infinite.
///
/// Formulas with a literal power between 1 and 2, such as |x|^1.5, have an infinite second derivative where its base is
/// 0. It is taken as 0 there, so that curvatures are finite on x = 0, and without bound beside it.
pub trait Curvature<const D: usize>: Constraint<D, 1> {
    /// κ along v: the curvature of the section through q spanned by n and v. Only the direction of the tangential part
    /// of v counts; if that is zero but for rounding, κ is NaN.
    fn normal_curvature(&self, q: &SVector<f64, D>, v: &SVector<f64, D>) -> f64 {
        let gradient = self.jacobian(q).transpose();
        let steepness = gradient.norm();
        let normal = gradient / steepness;
        let v = v / v.amax(); // its square may leave the floats
        let tangent = v - normal * normal.dot(&v);
        if tangent.norm() <= ROUNDING * v.norm() {
            return f64::NAN; // what rounding has left of v has any direction
        }
        self.jet(q, &tangent).2[0] / (steepness * tangent.norm_squared())
    }

    /// The D − 1 principal curvatures, smallest first, each with its direction: orthogonal unit vectors of the tangent
    /// space. Where curvatures are equal, these are not unique.
    fn principal_curvatures(&self, q: &SVector<f64, D>) -> Vec<(f64, SVector<f64, D>)> {
        let (frame, shape) = shape_operator(self, q);
        if frame.is_empty() {
            return Vec::new(); // D = 1: nalgebra takes no empty matrix
        }
        let eigen = SymmetricEigen::new(shape);
        let direction = |column: usize| {
            frame.iter().zip(eigen.eigenvectors.column(column).iter()).map(|(basis, x)| basis * *x).sum()
        };
        let mut principal: Vec<_> =
            eigen.eigenvalues.iter().enumerate().map(|(i, &kappa)| (kappa, direction(i))).collect();
        principal.sort_by(|a, b| a.0.total_cmp(&b.0));
        principal
    }

    /// H, the average of the principal curvatures.
    fn mean_curvature(&self, q: &SVector<f64, D>) -> f64 {
        let (frame, shape) = shape_operator(self, q);
        shape.trace() / frame.len() as f64
    }

    /// K, the product of the principal curvatures: for D = 3 the Gaussian curvature, in other dimensions the
    /// Gauss–Kronecker curvature.
    fn gaussian_curvature(&self, q: &SVector<f64, D>) -> f64 {
        shape_operator(self, q).1.determinant()
    }
}

impl<C: Constraint<D, 1>, const D: usize> Curvature<D> for C {}

/// An orthonormal basis tᵢ of the tangent space, and S in it: tᵢ·∇²g tⱼ/|∇g|.
fn shape_operator<C: Constraint<D, 1>, const D: usize>(
    surface: &C,
    q: &SVector<f64, D>,
) -> (Vec<SVector<f64, D>>, DMatrix<f64>) {
    let gradient = surface.jacobian(q).transpose();
    let steepness = gradient.norm();
    let frame = tangents(&(gradient / steepness));
    let bends: Vec<_> = frame.iter().map(|t| surface.hessian_vector(q, t).transpose() / steepness).collect();
    let entry = |i: usize, j: usize| frame[i].dot(&bends[j]);
    let shape = DMatrix::from_fn(frame.len(), frame.len(), |i, j| 0.5 * (entry(i, j) + entry(j, i)));
    (frame, shape)
}

/// The reflection that takes ∓n to the first unit vector takes the others to these (Householder).
fn tangents<const D: usize>(normal: &SVector<f64, D>) -> Vec<SVector<f64, D>> {
    let sign = 1_f64.copysign(normal[0]); // away from cancellation
    let mut mirror = *normal;
    mirror[0] += sign;
    let reflected = |j: usize| {
        let mut unit = mirror * (-mirror[j] / (1.0 + normal[0].abs()));
        unit[j] += 1.0;
        unit
    };
    (1..D).map(reflected).collect()
}
