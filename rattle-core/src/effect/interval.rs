//! What a flow of momenta is handed, and how it is kept along constraints.

use crate::effect::moment::Moment;
use crate::effect::noise::Noise;
use crate::number::real::Real;
use std::array::from_fn;
use std::fmt::Debug;

/// What a flow is handed: the bodies, and a time in which only their momenta change.
#[derive(Debug)]
pub struct Interval<'a, T, const D: usize> {
    /// How long: a time, negative where a method runs backwards.
    pub h: f64,
    /// Whether this is the half before a step of the method; else it is that after it.
    pub before: bool,
    /// When and where.
    pub at: Moment<'a, T, D>,
    /// The momenta p of all bodies in turn.
    pub momenta: &'a [[T; D]],
    /// M⁻¹p of all bodies in turn, in the coordinates of the momenta: of a rigid body its angular velocity in the
    /// body's frame.
    pub velocities: &'a [[T; D]],
    /// ṗ of all bodies by forces, other flows that are not random, and constraints, for a flow that
    /// [feels](crate::effect::Flow::FEELS_FORCES) it.
    pub rates: &'a [[T; D]],
    /// The part Gᵀλ of ṗ that holds the bodies on their constraints, likewise.
    pub holding: &'a [[T; D]],
    /// What of ṗ h, from this half of a step, is still to come before places move again, or before the step is over,
    /// likewise.
    pub coming: &'a [[T; D]],
    /// The kinetic energy that links which move impose on bodies, part of that of their momenta.
    pub imposed: T,
    /// Masses.
    pub inertia: &'a dyn Inertia<T, D>,
    /// The surfaces that bodies are on, each on one; none in other scenes.
    pub surface: Option<&'a dyn Normals<T, D>>,
    /// What the flow [remembers](crate::effect::Acting::marks).
    pub marks: &'a [T],
    /// Whether constraints tie bodies to one another, so that momenta are made tangent together.
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

    /// The kinetic energy of all bodies beside what links that move impose on them: what has a temperature.
    pub fn thermal_energy(&self) -> T {
        self.kinetic_energy() - self.imposed
    }

    /// A random momentum of this body, normal with mean 0 and covariance `variance` M: with the variance kT that of
    /// Maxwell's distribution, before it is made one along the constraints. See [`Noise::normal`].
    pub fn normal(&self, seed: u64, body: usize, variance: f64) -> [T; D] {
        let numbers = self.noise.normal(seed, body).map(|x: f64| T::from_f64(variance.sqrt() * x));
        self.inertia.root(body, &numbers)
    }
}

/// Masses, in the coordinates of the momenta.
pub trait Inertia<T, const D: usize>: Debug {
    /// M⁻¹p of a momentum of this body; 0 for one that is pinned.
    fn velocity(&self, body: usize, p: &[T; D]) -> [T; D];
    /// L u with M = L Lᵀ: of independent normal numbers u of variance 1, a momentum of covariance M. 0 for a body that
    /// is pinned.
    fn root(&self, body: usize, u: &[T; D]) -> [T; D];
    /// Whether the body is held at its place.
    fn is_pinned(&self, body: usize) -> bool;
}

/// The surfaces that bodies are on, each on one.
pub trait Normals<T, const D: usize>: Debug {
    /// ∇g/|∇g| at the place of this body.
    fn normal(&self, body: usize) -> [T; D];
}

/// The columns of M⁻¹ of a body.
pub(crate) fn inverse_mass<T: Real, const D: usize>(inertia: &dyn Inertia<T, D>, body: usize) -> [[T; D]; D] {
    from_fn(|i| inertia.velocity(body, &from_fn(|k| T::from_f64(f64::from(u8::from(i == k))))))
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

/// How a [flow](crate::effect::Flow) is kept along the constraints. Φₕ is what
/// [`Flow::flow`](crate::effect::Flow::flow) says.
///
/// To make momenta those of motion along the constraints after Φₕ alone would be of first order where Φₕ leads off the
/// constraints and back, as drag does that differs by direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// Φₕ is symmetric, Φ₋ₕ Φₕ = 1, and of second order or exact. What the constraints give meanwhile, N = Gᵀμ, is
    /// added half before it and half after it: p′ = Φₕ(p + N/2) + N/2, with N such that p′ is along the constraints,
    /// found by iteration. Symmetric, and as stable as Φₕ is: where that takes no energy away nor adds any, p′ has that
    /// of p (E. Hairer, BIT 40 (2000) 726).
    Symmetric,
    /// Φₕ draws random numbers. All of N comes after it: exact where Φₕ is a multiple of p, the same for bodies that
    /// constraints tie together, and a normal number of covariance proportional to M. Such a flow does not run
    /// backwards.
    Random,
}

/// What a flow is like.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Manner {
    /// How it is kept along the constraints.
    pub rule: Rule,
    /// Whether it [feels](crate::effect::Flow::FEELS_FORCES) forces.
    pub feels: bool,
    /// Whether it is a [push](crate::effect::Acting::PUSHES).
    pub pushes: bool,
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
