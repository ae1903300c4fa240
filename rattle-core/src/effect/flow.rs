//! What momenta decide: drag, magnetic fields, thermostats.

use crate::effect::moment::Moment;
use crate::effect::one::{Acting, Effect};
use crate::number::lanes::Lane;
use crate::number::real::Real;
use std::array::from_fn;

/// A flow of momenta p ← Φₕ(p; q, t) while positions and time stand still: an effect that is no force of positions alone.
///
/// ```text
/// linear drag     ṗ = −γ p        Φₕ(p) = exp(−γh) p
/// magnetic field  ṗ = b v × B     Φₕ(p) = p turned about B
/// ```
///
/// Half of it acts before each step of the method and half after (G. Strang 1968), which is of second order whatever the order of the
/// method. Momenta are then made those of motion along the constraints again. The work that flows do is part of
/// [`Simulation::work`](crate::run::simulation::Simulation::work), so that the energy error is that of the method. Only methods with
/// a symmetric step and momenta at the time of the positions can be divided so; others are refused before a run.
/// Trajectories of an ensemble go one by one.
///
/// ```
/// use rattle::effect::{Flow, Moment};
/// use rattle::prelude::*;
/// use rattle::real::Real;
///
/// /// ṗ = −γ p.
/// #[derive(Clone)]
/// struct Drag(f64);
///
/// impl<const D: usize> Flow<D> for Drag {
///     fn flow<T: Real>(&self, h: f64, _: Moment<T, D>, p: &[[T; D]], _: &[[T; D]], changes: &mut [[T; D]]) {
///         for (change, p) in changes.iter_mut().zip(p) {
///             *change = p.map(|p| T::from_f64((-self.0 * h).exp_m1()) * p);
///         }
///     }
/// }
///
/// let scene = Scene::point().with(Drag(0.5));
/// let mut simulation = scene.simulate(State::at([0.0]).moving([1.0]), Rattle::new(0.1))?;
/// simulation.run(20)?;
/// assert!((simulation.momentum().x - (-1.0_f64).exp()).abs() < 1e-15);
/// assert!((simulation.work() + 0.5 * (1.0 - (-2.0_f64).exp())).abs() < 1e-15);
/// assert!(simulation.energy_error().abs() < 1e-15);
/// # Ok::<(), rattle::Error>(())
/// ```
#[diagnostic::on_unimplemented(message = "`{Self}` is no flow of momenta with {D} components")]
pub trait Flow<const D: usize>: Clone + Send + Sync + 'static {
    /// Writes what the momentum of every body changes by in a time h, Φₕ(p; q, t) − p, in the unit of momentum: a change, so that
    /// it is rounded to its own size. `velocities` are M⁻¹p. What would move a pinned body, or take momenta off the constraints,
    /// is taken away again. Of a rigid body the first three momenta count. Neither allocates nor panics.
    fn flow<T: Real>(
        &self,
        h: f64,
        at: Moment<'_, T, D>,
        momenta: &[[T; D]],
        velocities: &[[T; D]],
        changes: &mut [[T; D]],
    );

    /// Whether the flow changes with time.
    fn changes_with_time(&self) -> bool {
        false
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
}

impl<T: Real, F: Flow<D>, const D: usize> Acting<T, D> for ActsByFlow<F> {
    type Room = ();
    const FLOWS: bool = true;
    fn room(&self, _: usize) {}

    fn changes_with_time(&self) -> bool {
        self.0.changes_with_time()
    }
    fn flow(
        &self,
        h: f64,
        at: Moment<'_, T, D>,
        (): &mut (),
        momenta: &[[T; D]],
        velocities: &[[T; D]],
        changes: &mut [[T; D]],
    ) {
        self.0.flow(h, at, momenta, velocities, changes);
    }

    fn add_forces(&self, _: Moment<'_, T, D>, (): &mut (), _: &mut [[T; D]]) {}
    fn energy(&self, _: Moment<'_, T, D>) -> T {
        T::from_f64(0.0)
    }
}
