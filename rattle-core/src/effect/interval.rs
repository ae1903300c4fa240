//! The input of a flow of momenta, and how it is combined with constraints.

use crate::effect::moment::Moment;
use crate::effect::noise::Noise;
use crate::number::real::Real;
use std::array::from_fn;
use std::fmt::{self, Debug};

/// The input of a flow: the bodies, and a time interval in which only their momenta change.
#[derive(Debug)]
pub struct Interval<'a, T, const D: usize> {
    /// The length of the interval, a time; negative where a method runs backwards.
    pub h: f64,
    /// Whether this is the half before a step of the method; otherwise the half after it.
    pub before: bool,
    /// Time and positions.
    pub at: Moment<'a, T, D>,
    /// The momenta p of all bodies.
    pub momenta: &'a [[T; D]],
    /// The velocities M⁻¹p of all bodies, in the coordinates of the momenta: for a rigid body, its angular velocity in
    /// the body's frame.
    pub velocities: &'a [[T; D]],
    /// ṗ of all bodies by forces, other flows that are not random, and constraints; only with
    /// [`FEELS_FORCES`](crate::effect::Flow::FEELS_FORCES).
    pub rates: &'a [[T; D]],
    /// The constraint forces Gᵀλ in ṗ; only with `FEELS_FORCES`.
    pub holding: &'a [[T; D]],
    /// The part of ṗ h, for this half of a step, that momenta do not yet contain but will receive before positions move
    /// again or the step ends; only with `FEELS_FORCES`.
    pub coming: &'a [[T; D]],
    /// The part of the kinetic energy that moving links impose on the bodies.
    pub imposed: T,
    /// The momenta that moving links impose, those of the least kinetic energy: what is left of momenta without them is
    /// motion along the links. Empty where none move.
    pub led: &'a [[T; D]],
    /// The masses.
    pub inertia: &'a dyn Inertia<T, D>,
    /// The surfaces, one for each body; `None` in other scenes.
    pub surface: Option<&'a dyn Normals<T, D>>,
    /// The [memory](crate::effect::Acting::marks) of the flow.
    pub marks: &'a [T],
    /// Whether constraints couple bodies, so that their momenta are projected together.
    pub tied: bool,
    /// The number of independent momenta.
    pub freedom: usize,
    /// Random numbers.
    pub noise: Noise,
}

impl<T: Real, const D: usize> Interval<'_, T, D> {
    /// The kinetic energy pᵀM⁻¹p/2 of all bodies.
    pub fn kinetic_energy(&self) -> T {
        let products = self.momenta.iter().flatten().zip(self.velocities.iter().flatten());
        products.fold(T::from_f64(0.0), |sum, (&p, &v)| sum + T::from_f64(0.5) * p * v)
    }

    /// The kinetic energy of all bodies without the part imposed by moving links: the energy that has a temperature.
    pub fn thermal_energy(&self) -> T {
        self.kinetic_energy() - self.imposed
    }

    /// A random momentum of this body, normal with mean 0 and covariance `variance` M. With the variance kT that is the
    /// Maxwell–Boltzmann distribution, before the projection onto the constraints. See [`Noise::normal`].
    pub fn normal(&self, seed: u64, body: usize, variance: f64) -> [T; D] {
        let numbers = self.noise.normal(seed, body).map(|x: f64| T::from_f64(variance.sqrt() * x));
        self.inertia.root(body, &numbers)
    }
}

/// Masses, in the coordinates of the momenta.
pub trait Inertia<T, const D: usize>: Debug {
    /// The velocity M⁻¹p of this body for a momentum p; 0 for a pinned body.
    fn velocity(&self, body: usize, p: &[T; D]) -> [T; D];
    /// L u, with M = L Lᵀ: for independent normal numbers u of variance 1, a momentum of covariance M. 0 for a pinned
    /// body.
    fn root(&self, body: usize, u: &[T; D]) -> [T; D];
    /// Whether the body is pinned.
    fn is_pinned(&self, body: usize) -> bool;
}

/// The normals of the surfaces, one for each body.
pub trait Normals<T, const D: usize>: Debug {
    /// ∇g/|∇g| at the position of this body.
    fn normal(&self, body: usize) -> [T; D];
}

/// The columns of M⁻¹ of a body.
#[inline(always)]
pub(crate) fn inverse_mass<T: Real, const D: usize>(inertia: &dyn Inertia<T, D>, body: usize) -> [[T; D]; D] {
    from_fn(|i| inertia.velocity(body, &from_fn(|k| T::from_f64(f64::from(u8::from(i == k))))))
}

/// The diagonal of M⁻¹ of a body, if M⁻¹ is diagonal.
pub(crate) fn diagonal<T: Real, const D: usize>(inertia: &dyn Inertia<T, D>, body: usize) -> Option<[T; D]> {
    let columns = inverse_mass(inertia, body);
    let zero = |i: usize, k: usize| i == k || columns[i][k].lanes().all(|x| x == 0.0);
    (0..D).all(|i| (0..D).all(|k| zero(i, k))).then(|| from_fn(|i| columns[i][i]))
}

/// Whether the mass of a body is a number, in all lanes.
pub(crate) fn has_scalar_mass<T: Real, const D: usize>(inertia: &dyn Inertia<T, D>, body: usize) -> bool {
    let same = |a: T, b: T| a.lanes().zip(b.lanes()).all(|(a, b)| a == b);
    diagonal(inertia, body).is_some_and(|inverse| inverse.iter().all(|&over| same(over, inverse[0])))
}

/// Bodies of unit mass.
#[derive(Debug, Clone, Copy)]
pub struct UnitMasses;

impl<T: Copy, const D: usize> Inertia<T, D> for UnitMasses {
    fn velocity(&self, _: usize, p: &[T; D]) -> [T; D] {
        *p
    }
    fn root(&self, _: usize, u: &[T; D]) -> [T; D] {
        *u
    }
    fn is_pinned(&self, _: usize) -> bool {
        false
    }
}

/// How a [flow](crate::effect::Flow) is combined with the constraints. Φₕ is the map of
/// [`Flow::flow`](crate::effect::Flow::flow).
///
/// A single projection after Φₕ would be of first order only, where Φₕ leads off the constraints and back, as a drag
/// that depends on direction does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// For symmetric flows, Φ₋ₕ Φₕ = 1, of second order or exact. Half of the impulse N = Gᵀμ of the constraints is
    /// added before the flow and half after it: p′ = Φₕ(p + N/2) + N/2, with N, found by iteration, such that p′ is
    /// tangent. This is symmetric and as stable as Φₕ; where Φₕ conserves energy, so does this (E. Hairer, BIT 40
    /// (2000) 726).
    Symmetric,
    /// For flows that draw random numbers. All of N is added after Φₕ. This is exact where Φₕ(p) is a multiple of p,
    /// with one factor for bodies that constraints couple, plus a normal number of covariance proportional to M. Such a
    /// flow does not run backwards.
    Random,
}

/// The properties of a flow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Manner {
    /// How the flow is combined with the constraints.
    pub rule: Rule,
    /// Whether it depends on [forces](crate::effect::Flow::FEELS_FORCES).
    pub feels: bool,
    /// Whether it is a [push](crate::effect::Acting::PUSHES).
    pub pushes: bool,
}

/// As words of a message: "random", "symmetric, feels forces".
impl fmt::Display for Manner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.rule == Rule::Random { "random" } else { "symmetric" })?;
        f.write_str(if self.feels { ", feels forces" } else { "" })?;
        f.write_str(if self.pushes { ", pushes" } else { "" })
    }
}

impl Manner {
    /// Whether it is a force that others feel.
    pub(crate) fn is_felt(self) -> bool {
        !self.feels && (self.pushes || self.rule == Rule::Symmetric)
    }
}

/// Which half of a flow: before a step or after it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Half {
    Before,
    After,
}
