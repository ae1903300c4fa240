//! What momenta decide: drag, magnetic fields, heat.

use crate::effect::interval::{Interval, Manner, Rule};
use crate::effect::moment::Moment;
use crate::effect::one::{Acting, Effect};
use crate::error::{EffectMistake, Error};
use crate::number::lanes::Lane;
use crate::number::real::Real;
use std::array::from_fn;

/// A flow of momenta p ← Φₕ(p; q, t) while positions and time stand still: an effect that is no force of positions
/// alone.
///
/// ```text
/// linear drag     ṗ = −γ p        Φₕ(p) = exp(−γh) p
/// magnetic field  ṗ = b v × B     Φₕ(p) = p turned about B
/// ```
///
/// Half of it acts before each step of the method and half after (G. Strang 1968), which is of second order whatever
/// the order of the method; methods that say so, such as [`Baoab`](crate::methods::baoab::Baoab), have it act in the
/// middle of their step. Momenta are then made those of motion along the constraints again, by a [rule](Rule) that
/// keeps second order. The work that flows do is part of
/// [`Simulation::work`](crate::run::simulation::Simulation::work), so that the energy error is that of the method. Only
/// methods with a symmetric step and momenta at the time of the positions can be divided so; others are refused before
/// a run. Trajectories of an ensemble go one by one.
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
    const RULE: Rule = Rule::Symmetric;
    /// Whether the flow looks at [`Interval::rates`] and [`Interval::holding`], which take an evaluation of the
    /// multipliers.
    const FEELS_FORCES: bool = false;

    /// Writes what the momentum of every body changes by in a time h, Φₕ(p; q, t) − p, in the unit of momentum: a
    /// change, so that it is rounded to its own size. What would move a pinned body, or take momenta off the
    /// constraints, is taken away again. Of a rigid body the first three momenta count. Neither allocates nor panics.
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
    fn manner(&self) -> Manner {
        Manner { rule: F::RULE, feels: F::FEELS_FORCES, pushes: false }
    }
    fn flow(&self, during: &Interval<'_, T, D>, (): &mut (), changes: &mut [[T; D]]) {
        self.0.flow(during, changes);
    }

    fn add_forces(&self, _: Moment<'_, T, D>, (): &mut (), _: &mut [[T; D]]) {}
    fn energy(&self, _: Moment<'_, T, D>) -> T {
        T::from_f64(0.0)
    }
}
