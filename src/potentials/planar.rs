//! The same potentials for bodies in the plane. y points up.
//!
//! Pair potentials are those of [`potentials`](super): they depend on the distance alone.
//!
//! ```
//! use rattle::potentials::planar::{Spring, weights};
//! use rattle::prelude::*;
//!
//! let masses = [1.0, 2.0];
//! let spring = Spring { stiffness: 9.0, length: 1.0 }.over([[0, 1]]);
//! let scene = Scene::points(2).masses(masses).with(spring).with(weights(9.81, masses));
//! let mut simulation = scene.simulate(State::of([[0.0, 0.0], [0.0, 1.5]]), Rattle::new(0.01))?;
//! simulation.run(100)?;
//! assert!(simulation.energy_error().abs() < 1e-3);
//! # Ok::<(), rattle::Error>(())
//! ```

use crate::effect::Over;
use crate::ready_made::potential;

potential! {
    /// Uniform gravity along −y, on a body of unit mass: y points up.
    ///
    /// `g` is the acceleration. Potentials do not know masses: for a body of mass m give `g` times m, for bodies of
    /// different masses use [`weights`].
    ///
    /// ```
    /// use rattle::potentials::planar::Gravity;
    /// use rattle::prelude::*;
    ///
    /// assert_eq!(Gravity { g: 9.81 }.gradient(&[1.0, 2.0].into()).as_slice(), [0.0, 9.81]);
    /// ```
    pub struct Gravity { g }
    |x, y| g * y
}

potential! {
    /// A force that is the same everywhere.
    ///
    /// ```
    /// use rattle::potentials::planar::ConstantForce;
    /// use rattle::prelude::*;
    ///
    /// let wind = ConstantForce { force: [3.0, 0.0] };
    /// assert_eq!((-wind.gradient(&[1.0, 2.0].into())).as_slice(), [3.0, 0.0]);
    /// ```
    pub struct ConstantForce { force: [f64; 2] }
    |q: [f64; 2]| -dot(force, q)
}

potential! {
    /// A spring of rest length zero from a fixed point to a body: an isotropic harmonic trap.
    ///
    /// `stiffness` is a force over a length.
    ///
    /// ```
    /// use rattle::potentials::planar::Harmonic;
    /// use rattle::prelude::*;
    ///
    /// assert_eq!(Harmonic { stiffness: 4.0, centre: [0.0, 1.0] }.value(&[3.0, 1.0].into()), 18.0);
    /// ```
    pub struct Harmonic { stiffness, centre: [f64; 2] }
    |q: [f64; 2]| stiffness / 2 * sum(i in 0..2, (q[i] - centre[i])^2)
}

potential! {
    /// A harmonic trap with a stiffness for each axis, a force over a length; bodies move freely along an axis with
    /// stiffness 0.
    ///
    /// ```
    /// use rattle::potentials::planar::AnisotropicHarmonic;
    /// use rattle::prelude::*;
    ///
    /// let trench = AnisotropicHarmonic { stiffness: [0.0, 2.0], centre: [0.0; 2] };
    /// assert_eq!(trench.gradient(&[50.0, 2.0].into()).as_slice(), [0.0, 4.0]);
    /// ```
    pub struct AnisotropicHarmonic { stiffness: [f64; 2], centre: [f64; 2] }
    |q: [f64; 2]| sum(i in 0..2, stiffness[i] * (q[i] - centre[i])^2) / 2
}

potential! {
    /// The potential of Kepler and Coulomb about a fixed point of the plane: attracts for `mu` > 0, repels for `mu` <
    /// 0.
    ///
    /// `mu` is an energy times a length: G M m for a mass m about a mass M. The force is not finite at the centre.
    ///
    /// ```
    /// use rattle::potentials::planar::Kepler;
    /// use rattle::prelude::*;
    ///
    /// assert_eq!(Kepler { mu: 6.0, centre: [0.0; 2] }.value(&[0.0, 2.0].into()), -3.0);
    /// ```
    pub struct Kepler { mu, centre: [f64; 2] }
    |q: [f64; 2]| -mu / norm(q - centre)
}

potential! {
    /// A spring between two bodies that pushes when it is shorter than `length`, and pulls when it is longer.
    ///
    /// `stiffness` is a force over a length. Where both bodies are at one place, the spring has no direction and no
    /// force.
    ///
    /// ```
    /// use rattle::potentials::planar::Spring;
    /// use rattle::prelude::*;
    ///
    /// let spring = Spring { stiffness: 8.0, length: 1.0 };
    /// assert_eq!(spring.gradient(&[0.0, 0.0, 0.0, 1.5].into()).as_slice(), [0.0, -4.0, 0.0, 4.0]);
    /// ```
    pub struct Spring { stiffness, length }
    |a: [f64; 2], b: [f64; 2]| stiffness / 2 * (norm(a - b) - length)^2
}

potential! {
    /// The potential of two charges or masses at chosen bodies: repels for `strength` > 0, attracts for `strength` < 0.
    ///
    /// `strength` is an energy times a length: k q₁ q₂ for charges, −G m₁ m₂ for masses; see [`charges`] and
    /// [`gravitation`].
    ///
    /// ```
    /// use rattle::potentials::planar::InverseDistance;
    /// use rattle::prelude::*;
    ///
    /// assert_eq!(InverseDistance { strength: -6.0 }.value(&[0.0, 0.0, 0.0, 2.0].into()), -3.0);
    /// ```
    pub struct InverseDistance { strength }
    |a: [f64; 2], b: [f64; 2]| strength / norm(a - b)
}

/// Uniform gravity along −y on bodies of these masses, in the order of the bodies; see [`weights`](super::weights) in
/// space.
pub fn weights(g: f64, masses: impl IntoIterator<Item = f64>) -> Over<Gravity, 1> {
    let weights: Vec<_> = masses.into_iter().map(|mass| Gravity { g: g * mass }).collect();
    let bodies = weights.len();
    Over::each(weights.into_iter().enumerate().map(|(body, weight)| (weight, [body]))).for_bodies(bodies)
}

/// Newton's potential −G mᵢ mⱼ / |qᵢ − qⱼ| between every two bodies of these masses; see
/// [`gravitation`](super::gravitation) in space.
pub fn gravitation(constant: f64, masses: impl IntoIterator<Item = f64>) -> Over<InverseDistance, 2> {
    charges(-constant, masses)
}

/// The potential k qᵢ qⱼ / |qᵢ − qⱼ| between every two bodies of these charges; see [`charges`](super::charges) in
/// space.
pub fn charges(constant: f64, charges: impl IntoIterator<Item = f64>) -> Over<InverseDistance, 2> {
    super::between_every_two(constant, charges.into_iter().collect(), |strength| InverseDistance { strength })
}
