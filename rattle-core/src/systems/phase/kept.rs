//! Constraints on phase space, g(q, p) = 0, with any energy H(q, p): geometric RATTLE.
//!
//! ```text
//! q̇ =  ∂H/∂p − (∂g/∂p)ᵀ λ
//! ṗ = −∂H/∂q + (∂g/∂q)ᵀ λ        g(q, p) = 0
//! ```
//!
//! with the sign of λ used everywhere in this library. Constraints must be *coisotropic*: {gᵢ, gⱼ} = 0 where g = 0,
//! with {a, b} = ∂a/∂q·∂b/∂p − ∂a/∂p·∂b/∂q. A single equation always is, and so are equations of positions alone; of
//! others that is asked at the start and after each step. The flows with the gᵢ as Hamiltonians then make *fibres*
//! within g = 0, and λ moves along them. The motion satisfies the hidden constraint hᵢ = {gᵢ, H} = 0, which a start
//! must satisfy too. The motion is determined where the matrix Nᵢⱼ = ∂hᵢ/∂σⱼ, with σ the parameters along the fibre,
//! is invertible. A step is
//!
//! ```text
//! z̃  = z slid along its fibre by h/2 λ
//! z* = Φₕ(z̃)                               λ such that g(z*) = 0
//! z′ = z* slid along its fibre by h/2 μ    μ such that {g, H}(z′) = 0
//! ```
//!
//! with the Störmer–Verlet step Φₕ of H without constraints. The step is symplectic on the hidden constraint, symmetric
//! and of second order, and for g(q) and H = |p|²/2 + U(q) it is [RATTLE](crate::methods::rattle). z* does not depend
//! on where z is on its fibre. So SHAKE, which leaves out the last move, is the same map of fibres, and not a separate
//! method here.
//!
//! Where N becomes singular the motion ends; for one equation |N| falls like √(t* − t). A step within which N becomes
//! less than half, or more than twice as large is refused: a step is taken where its way back is.
//!
//! Without equations a step is Φₕ alone: of an energy T(p) + U(q) leapfrog, of others an implicit equation for p½ and
//! one for q′, which are solved to rounding. They may have other solutions where a step is long: it is refused where
//! the iteration brings no component nearer at first.
//!
//! H is reported as kinetic energy; the shadow energy is NaN.
//!
//! Source: R. McLachlan, K. Modin, O. Verdier, M. Wilkins, *Geometric generalisations of SHAKE and RATTLE*, Found.
//! Comput. Math. 14 (2014) 339.

use crate::kernel::functions::{PhaseConstraint, PhaseConstraintKernel};
use crate::motion::bodies::{Bodies, Body, Count};
use crate::number::real::Real;
use crate::solve::aim::{Aim, Pace};
use crate::systems::phase::point::Point;

/// What messages call such a system.
pub(super) const IN_PHASE_SPACE: &str = "a system in phase space";

/// M equations g(q, p) = 0 and an energy H(q, p), of a scene made by
/// [`Scene::in_phase_space`](crate::scene::Scene::in_phase_space), or no equation, by
/// [`Scene::hamiltonian`](crate::scene::Scene::hamiltonian).
#[derive(Debug, Clone, Copy)]
pub struct PhaseSpace<G, H, const M: usize> {
    /// g.
    pub constraint: G,
    /// H.
    pub hamiltonian: H,
}

/// No constraint, for a [Hamiltonian alone](crate::scene::Scene::hamiltonian).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unconstrained;

impl<const D: usize> PhaseConstraint<D, 0> for Unconstrained {
    type Kernel<T: Real> = Self;

    fn kernel_of_lanes<'a, T: Real>(_: impl Fn(usize) -> &'a Self) -> Self
    where
        Self: 'a,
    {
        Self
    }
    fn map_kernel<T: Real, U: Real>(_: &Self, _: impl Fn(&T) -> U) -> Self {
        Self
    }
}

impl<T: Real, const D: usize> PhaseConstraintKernel<T, D, 0> for Unconstrained {
    #[inline(always)]
    fn value(&self, _: &[T; D], _: &[T; D]) -> [T; 0] {
        []
    }
    #[inline(always)]
    fn jacobians(&self, _: &[T; D], _: &[T; D]) -> ([[T; D]; 0], [[T; D]; 0]) {
        ([], [])
    }
    #[inline(always)]
    fn value_and_jacobians(&self, _: &[T; D], _: &[T; D]) -> ([T; 0], [[T; D]; 0], [[T; D]; 0]) {
        ([], [], [])
    }
    #[inline(always)]
    fn hessian_vector(&self, _: &[T; D], _: &[T; D], _: &[T; D], _: &[T; D]) -> ([[T; D]; 0], [[T; D]; 0]) {
        ([], [])
    }
}

/// Bodies in phase space, each with its own g and H.
#[derive(Debug, Clone)]
pub struct InPhaseSpace<K, H, N, const M: usize> {
    pub(super) constraint: K,
    pub(super) energy: H,
    pub(super) count: N,
}

/// The quantities kept for a body from step to step.
#[derive(Debug, Clone, Copy)]
pub struct OfBody<const M: usize> {
    /// N at its point.
    pub(super) slopes: [[f64; M]; M],
    /// By what parts of its terms each equation was off where guesses led.
    pub(super) aims: [Aim<f64>; M],
}

/// The quantities kept from step to step.
#[derive(Debug, Clone)]
pub struct Kept<N: Count, const M: usize> {
    pub(super) bodies: N::Of<OfBody<M>>,
    /// In steps of what length guesses were off.
    pub(super) pace: Pace,
    /// The room of effects, of which there are none.
    pub(super) room: (),
}

pub(super) type BodiesOf<N, const D: usize, const M: usize> = Bodies<N, f64, Kept<N, M>, D>;

impl<N: Count, const M: usize> Kept<N, M> {
    /// Nothing is known.
    pub(super) fn unknown(count: N) -> Self {
        let body = OfBody { slopes: [[f64::NAN; M]; M], aims: [Aim::unknown(); M] };
        Self { bodies: count.each(body), pace: Pace::unknown(), room: () }
    }
}

impl<const D: usize> Point<D> {
    pub(super) fn high(body: &Body<f64, D>) -> Self {
        Self { q: body.q, p: body.p }
    }
    pub(super) fn low(body: &Body<f64, D>) -> Self {
        Self { q: body.q_low, p: body.p_low }
    }
}
