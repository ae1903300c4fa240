//! Points conjugate to the start of a geodesic, by Jacobi fields J along it: where ways end that are turned a little.
//!
//! ```text
//! J̇ = A − (J·Hv) ∇g/|∇g|²,   Ȧ = −R − (A·Hv) ∇g/|∇g|²        R = P [(v·Hv) HJ − (J·Hv) Hv]/|∇g|²,   H = ∇²g
//! ```
//!
//! A is the change of J along the surface, R that by its curvature (C. F. Gauss), P the projection on the tangent
//! space. Fields that are 0 at the start are the columns of a matrix. Between two neighbouring places a point is
//! conjugate to the start where J₁ᵀ B⁻¹ J₂ is not positive definite (M. Morse 1934, the index of a broken geodesic); B
//! is nearly a number there, the time between them. So no point is missed, be they two in one place, or many.

use crate::kernel::functions::ConstraintKernel;
use crate::kernel::geodesic::{Motion, follow};
use crate::number::vector::{add_scaled, dot, scaled, sum};
use nalgebra::SMatrix;
use std::array::from_fn;

/// Turns of the way: so small that fields are known to seven digits where the way is known to thirteen.
const SMALL: f64 = 1e-6;

/// Whether the geodesic from a with the velocity v passes a point conjugate to a until time 1, from the axes across it
/// at a, fewer than N; none where that is not known.
pub(crate) fn passes_conjugate<K: ConstraintKernel<f64, D, 1>, const D: usize, const N: usize>(
    kernel: &K,
    a: &[f64; D],
    v: &[f64; D],
    axes: &[[f64; D]],
) -> Option<bool> {
    let fields = axes.len();
    let rate = |now: &Motion<D, N>| -> Motion<D, N> {
        let (way, v) = &now[0];
        let q = sum(a, way);
        let ([gradient], [bend]) = (kernel.jacobian(&q), kernel.hessian_vector(&q, v));
        let square = dot(&gradient, &gradient);
        let normal = |part: f64| scaled(-part / square, &gradient);
        let bent = dot(v, &bend);
        from_fn(|n| {
            if n == 0 {
                return (*v, normal(bent));
            }
            if n > fields {
                return ([0.0; D], [0.0; D]);
            }
            let (field, change) = &now[n];
            let [turned] = kernel.hessian_vector(&q, field);
            let (across, twist) = (dot(&bend, field), dot(&bend, change));
            let curved = add_scaled(&scaled(bent, &turned), -across, &bend);
            let along = add_scaled(&curved, -dot(&curved, &gradient) / square, &gradient);
            (sum(change, &normal(across)), add_scaled(&normal(twist), -1.0 / square, &along))
        })
    };
    let conjugate = |one: &Motion<D, N>, next: &Motion<D, N>| {
        let beside = |i: usize, k: usize| dot(&one[i].0, &next[k].0);
        let is_field = |i: usize| (1..=fields).contains(&i);
        let whole = |i: usize, k: usize| {
            if is_field(i) && is_field(k) { beside(i, k) } else { f64::from(u8::from(i == k)) }
        };
        let starts = one[1].0 == [0.0; D];
        let alike = if fields == 1 {
            beside(1, 1) > 0.0
        } else {
            SMatrix::<f64, N, N>::from_fn(whole).cholesky().is_some()
        };
        !(starts || alike)
    };
    let speed = SMALL * dot(v, v).sqrt();
    let start = from_fn(|n| match n {
        0 => ([0.0; D], *v),
        n => ([0.0; D], axes.get(n - 1).map_or([0.0; D], |axis| scaled(speed, axis))),
    });
    follow(kernel, a, start, rate, conjugate).map(|(_, passed)| passed)
}
