//! The law of flow in one triangle: the control-volume scheme, with a slope vector p for the triangle.
//!
//! ```text
//! |p| p = ∇(b + h)                     in the triangle; q = −c hᵅ p,  |q| = c hᵅ √|∇(b + h)|
//! dₑ = −c p · aₑ,  aₑ = ½ cot ϑₑ (xⱼ − xᵢ)           for each edge e from i to j, ϑₑ the angle opposite to it
//! Fₑ = dₑ max(h_up, 0)ᵅ                up is i where dₑ ≥ 0, else j; 0 to dry ground that is no lower than the water
//! Rᵢ = Σ Fₑ from i − Σ Fₑ to i
//! ```
//!
//! Opposite to an obtuse angle the cotangent is negative, and the flux along the edge goes uphill, less than the other
//! two go downhill. At a shore the other two are 0, since dry ground has nothing to give: a lake would creep ashore.
//! So nothing flows up to dry ground.
//!
//! Every flux leaves one vertex and enters another, so Σ Rᵢ = 0 for all h and p, and the columns of the derivatives
//! have the sum zero: each Newton step conserves the volume, converged or not. No water leaves a dry vertex, whatever
//! the sign of the cotangent. In the derivative √(p² + ε²) replaces |p|, which overestimates it. With an underestimate,
//! as from an ε in the explicit form √|∇(b + h)|, Newton's method runs in circles.

use rattle::real::Real;
use rattle_macros::residual;

residual! {
    /// The law of Darcy and Weisbach, k |u| u = −g h ∇(b + h): α = 3/2, c = √(g/k).
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
        let f01 = d01 * if d01 >= 0 {
            if h[1] <= 0 && level[1] >= level[0] { 0 } else { a }
        } else {
            if h[0] <= 0 && level[0] >= level[1] { 0 } else { b }
        };
        let f12 = d12 * if d12 >= 0 {
            if h[2] <= 0 && level[2] >= level[1] { 0 } else { b }
        } else {
            if h[1] <= 0 && level[1] >= level[2] { 0 } else { d }
        };
        let f20 = d20 * if d20 >= 0 {
            if h[0] <= 0 && level[0] >= level[2] { 0 } else { d }
        } else {
            if h[2] <= 0 && level[2] >= level[0] { 0 } else { a }
        };
        let out = [f01 - f20, f12 - f01, f20 - f12];
        [out, norm(p) * p - slope]
        linearise [out, smooth * p - slope]
    }
}

residual! {
    /// The law of Gauckler and Manning, u = −h^(2/3) ∇(b + h) / (n √|∇(b + h)|): α = 5/3, c = 1/n.
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
        let f01 = d01 * if d01 >= 0 {
            if h[1] <= 0 && level[1] >= level[0] { 0 } else { a }
        } else {
            if h[0] <= 0 && level[0] >= level[1] { 0 } else { b }
        };
        let f12 = d12 * if d12 >= 0 {
            if h[2] <= 0 && level[2] >= level[1] { 0 } else { b }
        } else {
            if h[1] <= 0 && level[1] >= level[2] { 0 } else { d }
        };
        let f20 = d20 * if d20 >= 0 {
            if h[0] <= 0 && level[0] >= level[2] { 0 } else { d }
        } else {
            if h[2] <= 0 && level[2] >= level[0] { 0 } else { a }
        };
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
