//! The law of flow in one triangle: the control-volume scheme, with a slope vector p for the triangle.
//!
//! ```text
//! |p| p = ∇(b + h)                     in the triangle; q = −c hᵅ p,  |q| = c hᵅ √|∇(b + h)|
//! dₑ = −c p · aₑ,  aₑ = wₑ (xⱼ − xᵢ),  wₑ = ½ cot ϑₑ      for each edge e from i to j, ϑₑ the angle opposite to it
//! Fₑ = dₑ max(h_up, 0)ᵅ                up is i where dₑ ≥ 0, else j
//!    = dₑ max(min(h₀, h₁, h₂), 0)ᵅ     opposite to an obtuse angle, where wₑ < 0
//! Rᵢ = Σ Fₑ from i − Σ Fₑ to i
//! ```
//!
//! **Energy.** Opposite to an obtuse angle the flux goes uphill, less than the other two go downhill. With the depth
//! upstream it would go uphill too where these two are 0 since the third corner is dry: lakes would be unstable. With
//! the least depth of the three no triangle gives energy to the water. Let mₑ be what is carried, mₑ ≥ m where wₑ ≥ 0,
//! and mₑ = m where wₑ < 0, m of the least depth. With levels L = b + h
//!
//! ```text
//! Σ Lᵢ Rᵢ = Σ Fₑ (Lᵢ − Lⱼ) = c/√|∇L| Σ mₑ wₑ (Lᵢ − Lⱼ)² ≥ c m/√|∇L| Σ wₑ (Lᵢ − Lⱼ)² = c m |T| √|∇L|³ ≥ 0
//! ```
//!
//! E = Σ Mᵢ (bᵢ hᵢ + hᵢ²/2) is convex and has the slope Mᵢ Lᵢ. So in a closed basin without sources a step by implicit
//! Euler changes it by at most −Δt Σ Lᵢ′ Rᵢ′ ≤ 0, however long the step is.
//!
//! Every flux leaves one vertex and enters another, so Σ Rᵢ = 0 for all h and p, and the columns of the derivatives
//! have the sum zero: each Newton step conserves the volume, converged or not. No water leaves a dry vertex, whatever
//! the sign of the cotangent; up an edge it flows only where none of the three is dry. In the derivative √(p² + ε²)
//! replaces |p|, which overestimates it. With an underestimate, as from an ε in the explicit form √|∇(b + h)|, Newton's
//! method runs in circles.

use rattle::real::Real;
use rattle_macros::residual;

residual! {
    /// The law of Darcy and Weisbach, k |u| u = −g h ∇(b + h): α = 3/2, c = √(g/k). No angle is larger than
    /// that at the third corner, whose cotangent is −2 |T| ∇φ₀ · ∇φ₁.
    pub struct DarcyWeisbach {
        /// What rounds |p| off at 0, in the derivative alone.
        epsilon
    }

    |h: [f64; 3], p: [f64; 2]|
    given |grad: [[f64; 2]; 3], arm: [[f64; 2]; 3], rise: [f64; 2], c|
    eliminate(p)
    {
        let smooth = sqrt(dot(p, p) + epsilon^2);
        let level = [h[0], rise[0] + h[1], rise[1] + h[2]];
        let slope = level[0] * grad[0] + level[1] * grad[1] + level[2] * grad[2];
        let a = max(h[0], 0)^(3/2);
        let b = max(h[1], 0)^(3/2);
        let d = max(h[2], 0)^(3/2);
        let d01 = -c * dot(p, arm[0]);
        let d12 = -c * dot(p, arm[1]);
        let d20 = -c * dot(p, arm[2]);
        let least = min(a, b, d);
        let f01 = d01 * if dot(grad[0], grad[1]) > 0 { least } else { if d01 >= 0 { a } else { b } };
        let f12 = d12 * if d12 >= 0 { b } else { d };
        let f20 = d20 * if d20 >= 0 { d } else { a };
        let out = [f01 - f20, f12 - f01, f20 - f12];
        [out, norm(p) * p - slope]
        linearise [out, smooth * p - slope]
    }
}

residual! {
    /// The law of Gauckler and Manning, u = −h^(2/3) ∇(b + h) / (n √|∇(b + h)|): α = 5/3, c = 1/n. No angle is
    /// larger than that at the third corner.
    pub struct Manning {
        /// What rounds |p| off at 0, in the derivative alone.
        epsilon
    }

    |h: [f64; 3], p: [f64; 2]|
    given |grad: [[f64; 2]; 3], arm: [[f64; 2]; 3], rise: [f64; 2], c|
    eliminate(p)
    {
        let smooth = sqrt(dot(p, p) + epsilon^2);
        let level = [h[0], rise[0] + h[1], rise[1] + h[2]];
        let slope = level[0] * grad[0] + level[1] * grad[1] + level[2] * grad[2];
        let a = max(h[0], 0)^(5/3);
        let b = max(h[1], 0)^(5/3);
        let d = max(h[2], 0)^(5/3);
        let d01 = -c * dot(p, arm[0]);
        let d12 = -c * dot(p, arm[1]);
        let d20 = -c * dot(p, arm[2]);
        let least = min(a, b, d);
        let f01 = d01 * if dot(grad[0], grad[1]) > 0 { least } else { if d01 >= 0 { a } else { b } };
        let f12 = d12 * if d12 >= 0 { b } else { d };
        let f20 = d20 * if d20 >= 0 { d } else { a };
        let out = [f01 - f20, f12 - f01, f20 - f12];
        [out, norm(p) * p - slope]
        linearise [out, smooth * p - slope]
    }
}

/// How many numbers are given for a triangle: ∇φ of its three hats, arms of its three edges, how much
/// higher the ground is at its second and third corner than at the first, c.
pub(crate) const GIVEN: usize = DarcyWeisbach::GIVEN;

/// What assembly asks of a law.
pub(crate) trait Law: Sync {
    /// The functions over the scalar `T`.
    type Kernel<T: Real>: Element<T>;
    fn of<T: Real>(epsilon: f64) -> Self::Kernel<T>;
}

/// The condensed system of triangles side by side.
pub(crate) trait Element<T: Real> {
    fn condensed(&self, u: &[T; 5], d: &[T; GIVEN]) -> ([T; 3], [[T; 3]; 3]);
    fn condensed_residual(&self, u: &[T; 5], d: &[T; GIVEN]) -> [T; 3];
    fn recovered(&self, u: &[T; 5], d: &[T; GIVEN], step: &[T; 3]) -> [T; 2];
}

macro_rules! law {
    ($law:ident $kernel:ident) => {
        impl Law for $law {
            type Kernel<T: Real> = $kernel<T>;
            fn of<T: Real>(epsilon: f64) -> $kernel<T> {
                $law { epsilon }.kernel()
            }
        }
        impl<T: Real> Element<T> for $kernel<T> {
            #[inline(always)]
            fn condensed(&self, u: &[T; 5], d: &[T; GIVEN]) -> ([T; 3], [[T; 3]; 3]) {
                $kernel::condensed(self, u, d)
            }
            #[inline(always)]
            fn condensed_residual(&self, u: &[T; 5], d: &[T; GIVEN]) -> [T; 3] {
                $kernel::condensed_residual(self, u, d)
            }
            #[inline(always)]
            fn recovered(&self, u: &[T; 5], d: &[T; GIVEN], step: &[T; 3]) -> [T; 2] {
                $kernel::recovered(self, u, d, step)
            }
        }
    };
}
law!(DarcyWeisbach DarcyWeisbachKernel);
law!(Manning ManningKernel);
