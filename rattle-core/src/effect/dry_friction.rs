//! Dry friction, with sticking.

use crate::effect::flow::Flow;
use crate::effect::interval::{Interval, has_scalar_mass, inverse_mass};
use crate::error::EffectMistake;
use crate::number::linear::solve_positive;
use crate::number::real::{Mask, Real};
use crate::number::vector::{add_scaled, dot, scaled, sum};
use std::array::from_fn;

/// Coulomb's dry friction of bodies that slide on their surface (1785).
///
/// ```text
/// ṗ = −μ N v/|v|   where the body slides       N = |∇g λ|, the normal force
/// ṗ = 0            where it rests and the force along the surface is at most μ N
/// ```
///
/// N and the force along the surface include potentials and other flows, such as a [`force!`](crate::effect::Flow) and
/// [`SelfPropulsion`](crate::effect::SelfPropulsion), whatever their order in the scene. They do not include random
/// flows, which shake a body loose.
///
/// A body that comes to rest stays at its place, to the last bit: friction then cancels exactly the forces of the next
/// step. (In a network, where not all bodies rest, or some links move, that takes a method that begins with a kick, as
/// [`Rattle`](crate::methods::rattle::Rattle) and [`Geodesic`](crate::methods::geodesic::Geodesic) do; by others a body
/// at rest creeps by some h³ in a unit of time.) Of second order while a body slides. The surface holds a body from
/// both sides, so N has no sign: N = |f·n + κv²|, with the force f and the curvature κ of the path. For linked bodies N
/// is the size of the force of all links on the body. Where links move, v is what is left without the motion that they
/// impose: what a lift carries up does not slide; where they are curved too, friction is of first order. Where time
/// runs back a body at rest is an error, `FlowNotFound`: what it did before is not known. Beside a drag that leaves
/// nothing of a momentum in half a step, h c/m above some 60, whatever creeps counts as at rest.
///
/// Nothing presses on a free point, on a body that no link holds, or on a [rigid body](crate::systems::rigid::Rigid),
/// which turns about its centre: there N = 0, and dry friction does nothing. For these there is
/// [`LinearDrag`](crate::effect::LinearDrag), or a force of one's own.
///
/// ```
/// use rattle::effect::DryFriction;
/// use rattle::potentials::Gravity;
/// use rattle::prelude::*;
/// use rattle::surfaces::Plane;
///
/// // On a slope of 30°, tan 30° = 0.577: μ = 0.6 holds.
/// let slope = Plane { a: 0.5, b: 0.0, c: 0.75_f64.sqrt(), d: 0.0 };
/// let scene = Scene::on(slope).with(Gravity { g: 9.81 }).with(DryFriction { coefficient: 0.6 });
/// let mut simulation = scene.simulate(State::at([0.0; 3]), Rattle::new(0.01))?;
/// simulation.run(1000)?;
/// assert_eq!(simulation.position().norm(), 0.0);
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "sliding")]
#[doc(alias = "stick-slip")]
#[doc(alias = "friction")]
#[doc(alias = "Coulomb")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DryFriction {
    /// The coefficient of friction μ.
    pub coefficient: f64,
}

/// Rounds of Newton's method where the mass is a matrix: from below, and each with twice the digits of the one before,
/// once the smallest mass no longer matters.
const ROUNDS: usize = 24;

impl<const D: usize> Flow<D> for DryFriction {
    const FEELS_FORCES: bool = true;

    fn flow<T: Real>(&self, during: &Interval<'_, T, D>, changes: &mut [[T; D]]) {
        let (zero, one) = (T::from_f64(0.0), T::from_f64(1.0));
        let (h, mu) = (T::from_f64(during.h), T::from_f64(self.coefficient));
        let length = |a: &[T; D]| dot(a, a).sqrt();
        // What is left of p after an impulse against v, which is along p where the mass is a number.
        let slowed = |inverse: Option<&[[T; D]; D]>, p: &[T; D], impulse: T| {
            let size = length(p);
            if let Some(inverse) = inverse {
                let left = add_scaled(p, -one, &taken(inverse, p, impulse));
                return left.map(|p| T::select(impulse.lt(size), p, zero));
            }
            scaled(T::select(impulse.lt(size), one - impulse / size, zero), p)
        };
        let forces = during.rates.iter().zip(during.holding).zip(during.coming);
        for (body, ((change, p), ((rate, holding), coming))) in
            changes.iter_mut().zip(during.momenta).zip(forces).enumerate()
        {
            // Along links that move: with what they impose a body does not slide.
            let p = &during.led.get(body).map_or(*p, |led| add_scaled(p, -one, led));
            let matrix = (!has_scalar_mass(during.inertia, body)).then(|| inverse_mass(during.inertia, body));
            let inverse = matrix.as_ref();
            // What an impulse gives, but for a factor where the mass is a number.
            let velocity = |a: &[T; D]| inverse.map_or(*a, |inverse| inverse.map(|line| dot(&line, a)));
            // N at the middle of the flow: its part that answers forces stays, that of the curvature goes with v².
            let (size, force) = (length(p), add_scaled(rate, -one, holding));
            let held = velocity(holding);
            let square = dot(holding, &held);
            let share = T::select(zero.lt(square), -dot(&force, &held) / square, zero);
            let at_rest = scaled(share, holding);
            let half = slowed(inverse, p, T::from_f64(0.5) * mu * length(holding) * h);
            let (half, whole) = (velocity(&half), velocity(p));
            let left = T::select(zero.lt(size), dot(&half, &half) / dot(&whole, &whole), zero);
            // Where links move, the rest of N may be their acceleration.
            let left = if during.led.is_empty() { left } else { one };
            let curved = add_scaled(holding, -one, &at_rest);
            let impulse = mu * length(&add_scaled(&at_rest, left, &curved)) * h;

            let near_rest = size.le(impulse + length(coming)).all();
            let next = if near_rest {
                add_scaled(&slowed(inverse, &sum(p, coming), impulse), -one, coming)
            } else {
                slowed(inverse, p, impulse)
            };
            *change = add_scaled(&next, -one, p);
        }
    }

    /// It does not show where a body is at rest.
    fn parameters(&self) -> Vec<f64> {
        vec![self.coefficient]
    }

    fn check(&self, _: usize) -> Result<(), EffectMistake> {
        EffectMistake::unless_positive_or_zero("coefficient", self.coefficient)
    }
}

/// What an impulse of this size takes from p, less than p is long, along v in the middle: p′ = p − 2x with
///
/// ```text
/// x = (1 + wM)⁻¹p ∥ v      |x| = ½ impulse      1/|x| rises with w, and ever less
/// ```
///
/// as in the secular equation of trust regions (M. Hebden 1973). So no kinetic energy is gained.
fn taken<T: Real, const D: usize>(inverse: &[[T; D]; D], p: &[T; D], impulse: T) -> [T; D] {
    let (zero, one) = (T::from_f64(0.0), T::from_f64(1.0));
    // With B = M⁻¹: x = Bz, z = (B + w)⁻¹p.
    let by_inverse = |a: &[T; D]| inverse.map(|line| dot(&line, a));
    let solved = |w: T, a: [T; D]| {
        let shifted = |i: usize, k: usize| if i == k { inverse[i][k] + w } else { inverse[i][k] };
        solve_positive(from_fn(|i| from_fn(|k| shifted(i, k))), a)
    };
    let (mut w, mut x) = (zero, *p);
    for _ in 0..ROUNDS {
        let length = dot(&x, &x).sqrt();
        let z = solved(w, *p);
        let slope = dot(&x, &by_inverse(&solved(w, z))) / (length * length * length);
        w = w + (T::from_f64(2.0) / impulse - one / length) / slope;
        x = by_inverse(&solved(w, *p));
    }
    let factor = impulse / dot(&x, &x).sqrt();
    x.map(|x| T::select(zero.lt(impulse), factor * x, zero))
}
