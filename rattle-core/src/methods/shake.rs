//! SHAKE: the leapfrog with constraints, with momenta half a step before the positions (Ryckaert, Ciccotti, Berendsen
//! 1977).
//!
//! ```text
//! p(t + h/2) = p(t − h/2) + h (f(q) + G(q)ᵀλ)      λ such that g(q(t + h)) = 0
//! q(t + h)   = q(t) + h M⁻¹ p(t + h/2)
//! ```
//!
//! The positions are those of [RATTLE](crate::methods::rattle): both repeat the same cycle of operations, but a step
//! begins at another point of it. RATTLE's momentum p(t) is p(t − h/2) after a kick of half a step, projected to be
//! tangent. The momenta here are M (q(t) − q(t − h))/h, which are not tangent, and an energy computed from them varies
//! by O(h).
//!
//! Source: J.-P. Ryckaert, G. Ciccotti, H. J. C. Berendsen, J. Comput. Phys. 23 (1977) 327; E. Hairer, C. Lubich,
//! G. Wanner, *Geometric Numerical Integration*, VII.1.4.

use crate::methods::fixed::{Fixed, Map};
use crate::motion::failure::Failure;
use crate::motion::parts::BodiesOf;
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::real::Scalar;

/// SHAKE with a constant step size, second order in the positions.
///
/// The momenta of a start are those half a step before its positions;
/// [`Scene::staggered`](crate::scene::Scene::staggered) makes them from momenta of the same time. They need not be
/// tangent: a normal component has no effect.
///
/// ```
/// use rattle::{Scene, Shake, State};
///
/// let (scene, method) = (Scene::point(), Shake::new(0.5));
/// let start = scene.staggered(&State::at([0.0]).moving([1.0]), &method)?;
/// let mut simulation = scene.simulate(start, method)?;
/// simulation.run(4)?;
/// assert_eq!((simulation.time(), simulation.momentum_time()), (2.0, 1.75));
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "Verlet")]
#[doc(alias = "staggered")]
#[doc(alias = "bond constraints")]
pub type Shake = Fixed<KickKickDrift>;

/// The map of [`Shake`]: half a kick and projection, half a kick, the drift.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct KickKickDrift;

impl Map for KickKickDrift {
    const NAME: &'static str = "SHAKE";
    const ORDER: u32 = 2;
    const SYMMETRIC: bool = false; // positions and momenta would have to change places
    const DELAY: f64 = -0.5;
    const EVALUATIONS: Option<usize> = Some(1);

    #[inline(always)]
    fn map<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        h: f64,
        system: &Y,
        bodies: &mut BodiesOf<Y, T, D>,
        witness: &mut W,
    ) -> Result<(), Failure> {
        system.settle(0.5 * h, h, bodies, witness)?;
        system.drift(0.5 * h, h, bodies, witness)?;
        system.evaluate_forces(bodies);
        system.check_forces(bodies)
    }
}
