//! Ready-made potentials: on each body, between chosen bodies, and between every two.
//!
//! Each is a plain [`potential!`](crate::potential) or [`pair_potential!`](crate::pair_potential); its page shows the
//! formula, the gradient and the number of operations. To vary one, copy its line into a macro of your own. Units are
//! any that fit together. Forces are −∇U.
//!
//! | acts | how a scene takes it | which |
//! |---|---|---|
//! | on each body | `.with(Gravity { … })` | [`Gravity`], [`ConstantForce`], [`Harmonic`], [`AnisotropicHarmonic`], [`Kepler`] |
//! | on bodies by their masses | `.with(weights(g, masses))` | [`weights`] |
//! | between chosen bodies | `.with(Spring { … }.over([[0, 1]]))` | [`Spring`], [`InverseDistance`] |
//! | between bodies by masses or charges | `.with(gravitation(constant, masses))` | [`gravitation`], [`charges`] |
//! | between every two bodies | `.with(LennardJones { … })` | [`Coulomb`], [`LennardJones`], [`Wca`], [`Morse`], [`Yukawa`], [`Ricker`], [`Gaussian`], [`HarmonicPair`], [`SoftSphere`] |
//! | between near bodies, of a kind or of several | `.with(LennardJones { … }.within(2.5))`, [`Kinds`](crate::effect::Kinds) | the same |
//!
//! Pair potentials depend on the distance alone, so they serve bodies with any number of coordinates. The other
//! potentials here are for bodies in space; [`planar`] has those for bodies in the plane, with the same names.
//!
//! ```
//! use rattle::potentials::{LennardJones, weights};
//! use rattle::prelude::*;
//!
//! let masses = [1.0, 2.0];
//! let scene = Scene::points(2)
//!     .masses(masses)
//!     .with(weights(9.81, masses))
//!     .with(LennardJones { epsilon: 1.0, sigma: 1.0 });
//! let mut simulation = scene.simulate(State::of([[0.0, 0.0, 0.0], [0.0, 0.0, 1.2]]), Rattle::new(1e-3))?;
//! simulation.run(100)?;
//! assert!(simulation.energy_error().abs() < 1e-4);
//! # Ok::<(), rattle::Error>(())
//! ```

mod pairs;
pub mod planar;

pub use pairs::*;

use crate::effect::Over;
use crate::ready_made::potential;

potential! {
    /// Uniform gravity along −z, on a body of unit mass: z points up.
    ///
    /// `g` is the acceleration. Potentials do not know masses: for a body of mass m give `g` times m, for bodies of
    /// different masses use [`weights`].
    ///
    /// ```
    /// use rattle::potentials::Gravity;
    /// use rattle::prelude::*;
    ///
    /// let stone = Scene::point().with(Gravity { g: 9.81 });
    /// let mut simulation = stone.simulate(State::at([0.0, 0.0, 10.0]), Rattle::new(0.01))?;
    /// simulation.run(100)?;
    /// assert!((simulation.position().z - (10.0 - 9.81 / 2.0)).abs() < 1e-12);
    /// # Ok::<(), rattle::Error>(())
    /// ```
    #[doc(alias = "weight")]
    pub struct Gravity { g }
    |x, y, z| g * z
}

potential! {
    /// A force that is the same everywhere, such as that of a uniform electric field on a charge.
    ///
    /// ```
    /// use rattle::potentials::ConstantForce;
    /// use rattle::prelude::*;
    ///
    /// let pull = ConstantForce { force: [1.0, 0.0, -2.0] };
    /// assert_eq!((-pull.gradient(&[5.0, 6.0, 7.0].into())).as_slice(), [1.0, 0.0, -2.0]);
    /// ```
    pub struct ConstantForce { force: [f64; 3] }
    |q: [f64; 3]| -dot(force, q)
}

potential! {
    /// A spring of rest length zero from a fixed point to a body: an isotropic harmonic trap.
    ///
    /// `stiffness` is a force over a length. A body of mass m swings with the angular frequency √(stiffness / m).
    ///
    /// ```
    /// use rattle::potentials::Harmonic;
    /// use rattle::prelude::*;
    ///
    /// let trap = Harmonic { stiffness: 4.0, centre: [0.0, 0.0, 1.0] };
    /// assert_eq!(trap.value(&[0.0, 3.0, 1.0].into()), 18.0);
    /// ```
    #[doc(alias = "spring")]
    #[doc(alias = "trap")]
    pub struct Harmonic { stiffness, centre: [f64; 3] }
    |q: [f64; 3]| stiffness / 2 * sum(i in 0..3, (q[i] - centre[i])^2)
}

potential! {
    /// A harmonic trap with a stiffness for each axis, a force over a length; bodies move freely along an axis with
    /// stiffness 0.
    ///
    /// ```
    /// use rattle::potentials::AnisotropicHarmonic;
    /// use rattle::prelude::*;
    ///
    /// let tube = AnisotropicHarmonic { stiffness: [2.0, 2.0, 0.0], centre: [0.0; 3] };
    /// assert_eq!(tube.gradient(&[1.0, 2.0, 50.0].into()).as_slice(), [2.0, 4.0, 0.0]);
    /// ```
    pub struct AnisotropicHarmonic { stiffness: [f64; 3], centre: [f64; 3] }
    |q: [f64; 3]| sum(i in 0..3, stiffness[i] * (q[i] - centre[i])^2) / 2
}

potential! {
    /// The potential of Kepler and Coulomb about a fixed point: attracts for `mu` > 0, repels for `mu` < 0.
    ///
    /// `mu` is an energy times a length: G M m for a mass m about a mass M, −k Q q for a charge q about a charge Q. The
    /// force is not finite at the centre.
    ///
    /// ```
    /// use rattle::potentials::Kepler;
    /// use rattle::prelude::*;
    ///
    /// let sun = Scene::point().with(Kepler { mu: 1.0, centre: [0.0; 3] });
    /// let circle = State::at([1.0, 0.0, 0.0]).moving([0.0, 1.0, 0.0]);
    /// let mut simulation = sun.simulate(circle, Rattle::new(0.01))?;
    /// simulation.run(628)?;
    /// assert!((simulation.position().norm() - 1.0).abs() < 1e-4);
    /// # Ok::<(), rattle::Error>(())
    /// ```
    pub struct Kepler { mu, centre: [f64; 3] }
    |q: [f64; 3]| -mu / norm(q - centre)
}

potential! {
    /// A spring between two bodies that pushes when it is shorter than `length`, and pulls when it is longer.
    ///
    /// `stiffness` is a force over a length. Where both bodies are at one place, the spring has no direction and no
    /// force.
    ///
    /// ```
    /// use rattle::potentials::Spring;
    /// use rattle::prelude::*;
    ///
    /// let spring = Spring { stiffness: 9.0, length: 1.0 };
    /// let pair = Scene::points(2).with(spring.over([[0, 1]]));
    /// let mut simulation = pair.simulate(State::of([[0.0, 0.0, 0.0], [0.0, 0.0, 1.5]]), Rattle::new(0.01))?;
    /// assert_eq!(simulation.energy(), 9.0 / 2.0 * 0.5 * 0.5);
    /// simulation.run(100)?;
    /// assert!(simulation.energy_error().abs() < 1e-3);
    /// # Ok::<(), rattle::Error>(())
    /// ```
    pub struct Spring { stiffness, length }
    |a: [f64; 3], b: [f64; 3]| stiffness / 2 * (norm(a - b) - length)^2
}

potential! {
    /// The potential of two charges or masses at chosen bodies: repels for `strength` > 0, attracts for `strength` < 0.
    ///
    /// `strength` is an energy times a length: k q₁ q₂ for charges, −G m₁ m₂ for masses; see [`charges`] and
    /// [`gravitation`]. Where it is the same between every two bodies, [`Coulomb`] is faster.
    ///
    /// ```
    /// use rattle::potentials::InverseDistance;
    /// use rattle::prelude::*;
    ///
    /// let unlike = InverseDistance { strength: -6.0 };
    /// assert_eq!(unlike.value(&[0.0, 0.0, 0.0, 0.0, 2.0, 0.0].into()), -3.0);
    /// ```
    pub struct InverseDistance { strength }
    |a: [f64; 3], b: [f64; 3]| strength / norm(a - b)
}

/// Uniform gravity along −z on bodies of these masses, in the order of the bodies: U = Σ g mᵢ zᵢ. Give the same numbers
/// to `Scene::masses`. A scene of more or fewer bodies refuses it.
///
/// ```
/// use rattle::potentials::weights;
/// use rattle::prelude::*;
///
/// let masses = [1.0, 50.0];
/// let stones = Scene::points(2).masses(masses).with(weights(9.81, masses));
/// let mut simulation = stones.simulate(State::of([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), Rattle::new(0.01))?;
/// simulation.run(100)?;
/// let heights: Vec<f64> = simulation.positions().map(|q| q.z).collect();
/// assert!((heights[0] - heights[1]).abs() < 1e-12); // all fall alike
/// # Ok::<(), rattle::Error>(())
/// ```
pub fn weights(g: f64, masses: impl IntoIterator<Item = f64>) -> Over<Gravity, 1> {
    let weights: Vec<_> = masses.into_iter().map(|mass| Gravity { g: g * mass }).collect();
    let bodies = weights.len();
    Over::each(weights.into_iter().enumerate().map(|(body, weight)| (weight, [body]))).for_bodies(bodies)
}

/// Newton's gravitation between every two bodies of these masses: U = −Σ G mᵢ mⱼ / |qᵢ − qⱼ|. `constant` is G. Give the
/// same masses to `Scene::masses`. A scene of more or fewer bodies refuses it. For thousands of bodies with few
/// different masses see [`Kinds`](crate::effect::Kinds), as for [`charges`].
///
/// ```
/// use rattle::potentials::gravitation;
/// use rattle::prelude::*;
///
/// let masses = [1.0, 1e-3];
/// let scene = Scene::points(2).masses(masses).with(gravitation(1.0, masses));
/// let start = State::of([[0.0; 3], [1.0, 0.0, 0.0]]).with_momenta([[0.0, -1e-3, 0.0], [0.0, 1e-3, 0.0]]);
/// let mut simulation = scene.simulate(start, Rattle::new(0.01))?;
/// simulation.run(1000)?;
/// assert!(simulation.energy_error().abs() < 1e-7);
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "n-body")]
#[doc(alias = "Newton")]
pub fn gravitation(constant: f64, masses: impl IntoIterator<Item = f64>) -> Over<InverseDistance, 2> {
    charges(-constant, masses)
}

/// Coulomb's law between every two bodies of these charges: U = Σ k qᵢ qⱼ / |qᵢ − qⱼ|; like charges repel for
/// `constant` k > 0. Bodies without charge are left out; a scene of more or fewer bodies than there are charges refuses
/// it.
///
/// ```
/// use rattle::potentials::charges;
/// use rattle::prelude::*;
///
/// let salt = Scene::points(3).with(charges(1.0, [1.0, -1.0, 0.0]));
/// let simulation = salt.simulate(State::of([[0.0; 3], [0.5, 0.0, 0.0], [1.0, 0.0, 0.0]]), Rattle::new(0.01))?;
/// assert_eq!(simulation.energy(), -2.0);
/// # Ok::<(), rattle::Error>(())
/// ```
///
/// Each pair takes some 50 bytes, so that 10 000 bodies take 2.5 GB. Where charges are of few kinds,
/// [`Kinds`](crate::effect::Kinds) hold one potential for every two kinds, whatever the number of bodies:
///
/// ```
/// use rattle::effect::Kinds;
/// use rattle::potentials::Coulomb;
/// use rattle::prelude::*;
///
/// let (charge_of_kind, kind_of_body) = ([1.0, -1.0], (0..1000).map(|body| body % 2));
/// let between = |a: usize, b: usize| Coulomb { strength: charge_of_kind[a] * charge_of_kind[b] };
/// let salt = Scene::points::<3>(1000).with(Kinds::mixed(kind_of_body, between));
/// # let places = (0..1000).map(|body| [f64::from(body), 0.0, 0.0]);
/// # let simulation = salt.simulate(State::of(places), Rattle::new(0.01))?;
/// # let of_each = simulation.energy() / 1000.0;
/// # assert!((of_each + 2.0_f64.ln()).abs() < 1e-3, "{of_each}"); // Madelung's constant, but for the ends
/// # Ok::<(), rattle::Error>(())
/// ```
pub fn charges(constant: f64, charges: impl IntoIterator<Item = f64>) -> Over<InverseDistance, 2> {
    between_every_two(constant, charges.into_iter().collect(), |strength| InverseDistance { strength })
}

/// The potential of strength k cᵢ cⱼ for every pair i < j, without those of strength zero.
fn between_every_two<P>(constant: f64, charges: Vec<f64>, potential: impl Fn(f64) -> P) -> Over<P, 2> {
    let pairs = (0..charges.len()).flat_map(|j| (0..j).map(move |i| [i, j]));
    let strengths = pairs
        .map(|[i, j]| (constant * charges[i] * charges[j], [i, j]))
        .filter(|&(strength, _)| strength != 0.0);
    Over::each(strengths.map(|(strength, pair)| (potential(strength), pair))).for_bodies(charges.len())
}
