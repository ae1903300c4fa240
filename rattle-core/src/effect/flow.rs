//! Flows of momenta: effects that depend on momenta, such as drag, magnetic fields and thermostats.

use crate::effect::interval::{Inertia, Interval, Manner, Rule};
use crate::effect::moment::Moment;
use crate::effect::one::{Acting, Effect};
use crate::effect::ornstein_uhlenbeck::OrnsteinUhlenbeck;
use crate::error::{EffectMistake, Error};
use crate::number::lanes::Lane;
use crate::number::real::Real;

/// A flow of momenta p ← Φₕ(p; q, t) at fixed positions and time: an effect that depends on momenta.
///
/// ```text
/// linear drag     ṗ = −γ p        Φₕ(p) = exp(−γh) p
/// magnetic field  ṗ = b v × B     Φₕ(p) = p turned about B
/// ```
///
/// Half of the flow acts before each step of the method and half after it (Strang splitting), which is of second order
/// whatever the order of the method. Some methods, such as [`Baoab`](crate::methods::baoab::Baoab), apply the flow in
/// the middle of their step instead. Momenta are then made tangent to the constraints again, by a [rule](Rule) that
/// keeps second order. The work of flows is part of [`Simulation::work`](crate::run::simulation::Simulation::work), so
/// the energy error is that of the method. Only methods with a symmetric step, and with momenta at the time of the
/// positions, can be split like this; others are refused before a run.
///
/// **In lanes.** Ensembles of one body on a surface, of linked bodies and of rigid ones apply flows in SIMD lanes. A
/// flow with a [matrix](Self::linear), or one that is an [Ornstein–Uhlenbeck
/// process](Self::ornstein_uhlenbeck), is applied to all lanes at once; to rigid bodies a matrix is lane by lane. Any
/// other flow is evaluated lane by lane, with
/// a lane's number as `T` on surfaces, where with `#[inline(always)]` it can be compiled for the wide instructions of
/// the lanes, and with `f64` as `T` for linked and rigid bodies. Flows that [feel forces](Self::FEELS_FORCES), and
/// flows in other scenes, are computed as one simulation per trajectory;
/// [`Ensemble::plan`](crate::run::ensemble::Ensemble::plan) says so.
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
#[doc(alias = "velocity-dependent force")]
#[doc(alias = "dissipation")]
#[doc(alias = "thermostat")]
#[diagnostic::on_unimplemented(message = "`{Self}` is no flow of momenta with {D} components")]
pub trait Flow<const D: usize>: Clone + Send + Sync + 'static {
    /// How momenta are kept tangent to the constraints.
    const RULE: Rule = Rule::Symmetric;
    /// Whether the flow uses [`Interval::rates`] and [`Interval::holding`], which take an evaluation of the
    /// multipliers.
    const FEELS_FORCES: bool = false;
    /// Whether the flow does work. Where no flow of a scene does, and nothing changes with time, motion keeps the
    /// energy, and what it changes by is an error (see [`Price::energy`](crate::run::price::Price::energy)). Steps may
    /// change the kinetic energy by rounding alone then, also where the flow is made tangent to constraints.
    const WORKS: bool = true;

    /// Writes the change Φₕ(p; q, t) − p of the momentum of every body in a time h, in the unit of momentum. (A change
    /// has smaller rounding errors than a new momentum.) Parts that would move a pinned body, or violate the
    /// constraints, are removed afterwards. For a rigid body the first three components are those of the angular
    /// momentum, and the others have to be 0: a scene refuses a flow where they are not at the start, and later they do
    /// not count. Neither allocates nor panics.
    fn flow<T: Real>(&self, during: &Interval<'_, T, D>, changes: &mut [[T; D]]);

    /// The flow in a time `h` as an Ornstein–Uhlenbeck process, if it is one: [`flow`](Self::flow) then writes
    /// `lost` p + [`during.normal(seed, body, variance)`](Interval::normal) for every body. Ensembles apply such a flow
    /// to all SIMD lanes at once.
    fn ornstein_uhlenbeck(&self, _h: f64) -> Option<OrnsteinUhlenbeck> {
        None
    }

    /// The matrix A of body number `body` of a flow that is linear in the momenta of each body by itself, row by row:
    /// [`flow`](Self::flow) then writes A p for this body in a time `h`, in a scene of any number of bodies of these
    /// masses, with the same A at all positions and times. A body on a surface is number 0, and its mass is 1.
    /// Ensembles apply such a flow to all SIMD lanes at once.
    fn linear(&self, _h: f64, _body: usize, _inertia: &dyn Inertia<f64, D>) -> Option<[[f64; D]; D]> {
        None
    }

    /// Whether the flow changes with time.
    fn changes_with_time(&self) -> bool {
        false
    }

    /// Parameters that tell the flow from others of its type, where its changes of momenta in a short time need not: a
    /// rate of rare events, or what decides its memory. A checkpoint is refused where these numbers differ.
    fn parameters(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Checks the parameters, before a run with this number of bodies.
    ///
    /// # Errors
    /// Which parameter makes no sense.
    fn check(&self, _bodies: usize) -> Result<(), EffectMistake> {
        Ok(())
    }
}

/// The kind of effect of every [`Flow`].
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

    fn check(&self, what: &'static str, bodies: usize) -> Result<(), Error> {
        Flow::check(self, bodies).map_err(|mistake| Error::Effect { effect: what, mistake })
    }
}

impl<T: Real, F: Flow<D>, const D: usize> Acting<T, D> for ActsByFlow<F> {
    type Room = ();
    const FLOWS: bool = true;
    const WORKS: bool = F::WORKS;
    fn room(&self, _: usize) {}

    fn changes_with_time(&self) -> bool {
        self.0.changes_with_time()
    }
    fn manner(&self) -> Manner {
        Manner { rule: F::RULE, feels: F::FEELS_FORCES, pushes: false }
    }
    fn parameters(&self) -> Vec<f64> {
        self.0.parameters()
    }
    #[inline(always)]
    fn flow(&self, during: &Interval<'_, T, D>, (): &mut (), changes: &mut [[T; D]]) {
        self.0.flow(during, changes);
    }
    fn ornstein_uhlenbeck(&self, h: f64) -> Option<OrnsteinUhlenbeck> {
        self.0.ornstein_uhlenbeck(h)
    }
    fn linear(&self, h: f64, body: usize, inertia: &dyn Inertia<f64, D>) -> Option<[[f64; D]; D]> {
        self.0.linear(h, body, inertia)
    }

    fn add_forces(&self, _: Moment<'_, T, D>, (): &mut (), _: &mut [[T; D]]) {}
    fn energy(&self, _: Moment<'_, T, D>) -> T {
        T::from_f64(0.0)
    }
}
