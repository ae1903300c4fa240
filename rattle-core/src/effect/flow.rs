//! What momenta decide: drag, magnetic fields, heat.

use crate::effect::moment::Moment;
use crate::effect::noise::Noise;
use crate::effect::one::{Acting, Effect};
use crate::error::{EffectMistake, Error};
use crate::number::lanes::Lane;
use crate::number::real::Real;
use std::array::from_fn;
use std::fmt::Debug;

/// A flow of momenta p ← Φₕ(p; q, t) while positions and time stand still: an effect that is no force of positions alone.
///
/// ```text
/// linear drag     ṗ = −γ p        Φₕ(p) = exp(−γh) p
/// magnetic field  ṗ = b v × B     Φₕ(p) = p turned about B
/// ```
///
/// Half of it acts before each step of the method and half after (G. Strang 1968), which is of second order whatever the order of the
/// method; methods that say so, such as [`Baoab`](crate::methods::baoab::Baoab), have it act in the middle of their step. Momenta are
/// then made those of motion along the constraints again, by a [rule](Rule) that keeps second order. The work that flows do is part of
/// [`Simulation::work`](crate::run::simulation::Simulation::work), so that the energy error is that of the method. Only methods with
/// a symmetric step and momenta at the time of the positions can be divided so; others are refused before a run.
/// Trajectories of an ensemble go one by one.
///
/// ```
/// use rattle::effect::{Flow, Interval};
/// use rattle::prelude::*;
/// use rattle::real::Real;
///
/// /// ṗ = −γ p.
/// #[derive(Clone)]
/// struct Slowing(f64);
///
/// impl<const D: usize> Flow<D> for Slowing {
///     fn flow<T: Real>(&self, during: &Interval<'_, T, D>, changes: &mut [[T; D]]) {
///         let lost = T::from_f64((-self.0 * during.h).exp_m1());
///         for (change, p) in changes.iter_mut().zip(during.momenta) {
///             *change = p.map(|p| lost * p);
///         }
///     }
/// }
///
/// let scene = Scene::point().with(Slowing(0.5));
/// let mut simulation = scene.simulate(State::at([0.0]).moving([1.0]), Rattle::new(0.1))?;
/// simulation.run(20)?;
/// assert!((simulation.momentum().x - (-1.0_f64).exp()).abs() < 1e-15);
/// assert!((simulation.work() + 0.5 * (1.0 - (-2.0_f64).exp())).abs() < 1e-15);
/// assert!(simulation.energy_error().abs() < 1e-15);
/// # Ok::<(), rattle::Error>(())
/// ```
#[diagnostic::on_unimplemented(message = "`{Self}` is no flow of momenta with {D} components")]
pub trait Flow<const D: usize>: Clone + Send + Sync + 'static {
    /// How the flow is kept along the constraints.
    const RULE: Rule = Rule::Exact;
    /// Whether the flow looks at [`Interval::rates`] and [`Interval::holding`], which take an evaluation of the multipliers.
    const FEELS_FORCES: bool = false;

    /// Writes what the momentum of every body changes by in a time h, Φₕ(p; q, t) − p, in the unit of momentum: a change, so that
    /// it is rounded to its own size. What would move a pinned body, or take momenta off the constraints,
    /// is taken away again. Of a rigid body the first three momenta count. Neither allocates nor panics.
    fn flow<T: Real>(&self, during: &Interval<'_, T, D>, changes: &mut [[T; D]]);

    /// Whether the flow changes with time.
    fn changes_with_time(&self) -> bool {
        false
    }

    /// Looks at the parameters, before a run with so many bodies.
    ///
    /// # Errors
    /// Says which parameter makes no sense.
    fn check(&self, _bodies: usize) -> Result<(), EffectMistake> {
        Ok(())
    }
}

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
    /// M⁻¹p of all bodies in turn, in the coordinates of the momenta: of a rigid body its angular velocity in the body's frame.
    pub velocities: &'a [[T; D]],
    /// ṗ of all bodies by forces and constraints, for a flow that [feels](Flow::FEELS_FORCES) it.
    pub rates: &'a [[T; D]],
    /// The part Gᵀλ of ṗ that holds the bodies on their constraints, likewise.
    pub holding: &'a [[T; D]],
    /// Masses.
    pub inertia: &'a dyn Inertia<T, D>,
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

    /// A random momentum of this body, normal with mean 0 and covariance `variance` M: with the variance kT that of Maxwell's
    /// distribution, before it is made one along the constraints. See [`Noise::normal`].
    pub fn normal(&self, seed: u64, body: usize, variance: f64) -> [T; D] {
        let numbers = self.noise.normal(seed, body).map(|x: f64| T::from_f64(variance.sqrt() * x));
        self.inertia.root(body, &numbers)
    }
}

/// Masses, in the coordinates of the momenta.
pub trait Inertia<T, const D: usize>: Debug {
    /// M⁻¹p of a momentum of this body; 0 for one that is pinned.
    fn velocity(&self, body: usize, p: &[T; D]) -> [T; D];
    /// L u with M = L Lᵀ: of independent normal numbers u of variance 1, a momentum of covariance M. 0 for a body that is pinned.
    fn root(&self, body: usize, u: &[T; D]) -> [T; D];
    /// Whether the body is held at its place.
    fn is_pinned(&self, body: usize) -> bool;
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

/// How a [`Flow`] is kept along the constraints. Φₕ is what [`Flow::flow`] says, Π makes momenta those of motion along the
/// constraints.
///
/// Π Φₕ alone would be of first order where Φₕ leads off the constraints and back, as drag does that differs by direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// Φₕ is the flow without constraints, exact or of second order. Where Π takes nothing away, ΠΦₕ is made; else
    /// 2 ΠΦₕ⸝₂ΠΦₕ⸝₂ − ΠΦₕ, which is of second order.
    Exact,
    /// Φₕ(p) − p = h ṗ(p), the rate itself. p′ = p + h Πṗ((p + p′)/2) is made, the implicit rule of the midpoint along the constraints, found by
    /// iteration: symmetric, and a rate without power does no work. For rates with h|∂ṗ/∂p| below 2 in a half step.
    Rate,
    /// Φₕ is symmetric, Φ₋ₕ Φₕ = 1, and of second order. What the constraints give meanwhile, N = Gᵀμ, is added half
    /// before it and half after it: p′ = Φₕ(p + N/2) + N/2, with N such that p′ is along the constraints, found by
    /// iteration. Symmetric, and as stable as Φₕ is: where that takes no energy away nor adds any, p′ has that of p (E.
    /// Hairer, BIT 40 (2000) 726).
    Symmetric,
    /// Φₕ draws random numbers: ΠΦₕ is made. Exact where Φₕ is a multiple of p, the same for bodies that constraints tie together, and a normal
    /// number of covariance proportional to M. Such a flow does not run backwards.
    Random,
}

/// Which half of a flow: before a step or after it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Half {
    Before,
    After,
}

/// The kind of effect that is a [`Flow`].
#[derive(Debug, Clone, Copy)]
pub struct Flowing;

/// A flow, over a scalar.
#[derive(Debug, Clone, Copy)]
pub struct ActsByFlow<F>(F);

impl<F: Flow<D>, const D: usize> Effect<D, Flowing> for F {
    type Acting<T: Real> = ActsByFlow<F>;
    fn acting<T: Real>(&self) -> ActsByFlow<F> {
        ActsByFlow(self.clone())
    }

    type Swept<S: Lane, const L: usize> = [ActsByFlow<F>; L];
    fn swept<'a, S: Lane, const L: usize>(lane: impl Fn(usize) -> &'a Self) -> Self::Swept<S, L>
    where
        Self: 'a,
    {
        from_fn(|i| ActsByFlow(lane(i).clone()))
    }

    fn check(&self, what: &'static str, bodies: usize) -> Result<(), Error> {
        Flow::check(self, bodies).map_err(|mistake| Error::Effect { effect: what, mistake })
    }
}

impl<T: Real, F: Flow<D>, const D: usize> Acting<T, D> for ActsByFlow<F> {
    type Room = ();
    const FLOWS: bool = true;
    fn room(&self, _: usize) {}

    fn changes_with_time(&self) -> bool {
        self.0.changes_with_time()
    }
    fn rule(&self) -> (Rule, bool) {
        (F::RULE, F::FEELS_FORCES)
    }
    fn flow(&self, during: &Interval<'_, T, D>, (): &mut (), changes: &mut [[T; D]]) {
        self.0.flow(during, changes);
    }

    fn add_forces(&self, _: Moment<'_, T, D>, (): &mut (), _: &mut [[T; D]]) {}
    fn energy(&self, _: Moment<'_, T, D>) -> T {
        T::from_f64(0.0)
    }
}
