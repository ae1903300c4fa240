//! A scene under way.

use crate::bodies::{Bodies, Count, One};
use crate::effect::{Effects, Field, Force};
use crate::error::Error;
use crate::kernel::{Constraint, ConstraintKernel};
use crate::recorder::Recorder;
use crate::solver::multiplier_from_curvature;
use crate::state::State;
use crate::stepper::{Stepper, System, Witness};
use crate::vector::dot;
use nalgebra::SVector;
use std::fmt;
use std::marker::PhantomData;

type FieldOf<E, const D: usize> = <E as Effects<D>>::Field<f64>;
type BodiesOf<E, N, const D: usize> = Bodies<N, f64, <FieldOf<E, D> as Field<f64, D>>::Force, D>;

/// A scene, its present state and the method that moves it on.
///
/// Made by [`crate::scene::Scene::simulate`]. A step neither allocates nor panics; if it fails, the simulation is
/// as it was before the step, bit for bit.
pub struct Simulation<C: Constraint<D, 1>, E: Effects<D>, N: Count, S, const D: usize> {
    system: System<C::Kernel<f64>, FieldOf<E, D>>,
    stepper: S,
    bodies: BodiesOf<E, N, D>,
    /// The bodies before the step under way.
    before: BodiesOf<E, N, D>,
    steps: u64,
    start_energy: f64,
}

impl<C: Constraint<D, 1>, E: Effects<D>, N: Count, S: Stepper, const D: usize> Simulation<C, E, N, S, D> {
    pub(crate) fn new(
        system: System<C::Kernel<f64>, FieldOf<E, D>>,
        bodies: BodiesOf<E, N, D>,
        stepper: S,
    ) -> Self {
        let before = bodies.clone();
        let mut simulation = Self { system, stepper, bodies, before, steps: 0, start_energy: 0.0 };
        simulation.start_energy = simulation.energy();
        simulation
    }

    /// Takes one step.
    ///
    /// # Errors
    /// [`Error::Step`] says why the step cannot be taken; the simulation is then unchanged.
    #[inline(always)]
    pub fn step(&mut self) -> Result<(), Error> {
        self.advance(&mut ())
    }

    /// Takes `steps` steps.
    ///
    /// # Errors
    /// At the first step that cannot be taken; the simulation is then as the steps before left it.
    pub fn run(&mut self, steps: u64) -> Result<(), Error> {
        for _ in 0..steps {
            self.advance(&mut ())?;
        }
        Ok(())
    }

    /// Takes `steps` steps and shows the simulation to `see` after each.
    ///
    /// ```text
    /// simulation.run_with(2000, |now| energies.push(now.energy()))?;
    /// ```
    ///
    /// # Errors
    /// As [`Self::run`]; `see` has been shown every step that was taken.
    pub fn run_with(&mut self, steps: u64, mut see: impl FnMut(&Self)) -> Result<(), Error> {
        for _ in 0..steps {
            self.advance(&mut ())?;
            see(self);
        }
        Ok(())
    }

    /// Takes `steps` steps and has `recorder` record each.
    ///
    /// # Errors
    /// As [`Self::run`]; the recorder has seen every step that was taken.
    pub fn run_recording<R: Recorder<Self>>(&mut self, steps: u64, recorder: &mut R) -> Result<(), Error> {
        for _ in 0..steps {
            self.advance(&mut Listening(recorder, PhantomData::<Self>))?;
            recorder.record(self);
        }
        Ok(())
    }

    #[inline(always)]
    fn advance(&mut self, witness: &mut impl Witness<f64>) -> Result<(), Error> {
        self.before.copy_from(&self.bodies);
        match self.stepper.step(&self.system, &mut self.bodies, witness) {
            Ok(()) => {
                self.steps += 1;
                Ok(())
            }
            Err(failure) => {
                std::mem::swap(&mut self.bodies, &mut self.before);
                let (step, time) = (self.steps + 1, self.time());
                Err(Error::Step { step, time, body: failure.body, cause: failure.cause })
            }
        }
    }

    /// Steps taken so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Time since the start, steps times step size.
    #[allow(clippy::cast_precision_loss, reason = "exact up to 2⁵³ steps")]
    pub fn time(&self) -> f64 {
        self.steps as f64 * self.stepper.step_size()
    }

    /// The method.
    pub fn stepper(&self) -> &S {
        &self.stepper
    }

    /// The number of bodies.
    pub fn len(&self) -> usize {
        self.bodies.q.as_ref().len()
    }

    /// Whether there is no body.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Positions of the bodies in turn.
    pub fn positions(&self) -> impl ExactSizeIterator<Item = SVector<f64, D>> + '_ {
        self.bodies.q.as_ref().iter().map(|&q| q.into())
    }

    /// Momenta of the bodies in turn; with unit masses also velocities.
    pub fn momenta(&self) -> impl ExactSizeIterator<Item = SVector<f64, D>> + '_ {
        self.bodies.p.as_ref().iter().map(|&p| p.into())
    }

    /// The present state, from which a new simulation goes on bit for bit.
    pub fn state(&self) -> State<D> {
        State { bodies: (0..self.len()).map(|i| self.bodies.body(i)).collect(), surplus_momenta: None }
    }

    /// Kinetic energy |p|²/2, summed over the bodies.
    pub fn kinetic_energy(&self) -> f64 {
        let parts = self.bodies.p.as_ref().iter().zip(self.bodies.p_low.as_ref());
        parts.map(|(p, low)| 0.5 * dot(p, p) + dot(p, low)).sum()
    }

    /// Potential energy U of all effects.
    pub fn potential_energy(&self) -> f64 {
        self.system.field.energy(self.bodies.q.as_ref())
    }

    /// Energy H = K + U.
    pub fn energy(&self) -> f64 {
        self.kinetic_energy() + self.potential_energy()
    }

    /// Energy now less energy at the start.
    pub fn energy_error(&self) -> f64 {
        self.energy() - self.start_energy
    }

    /// The largest |g(q)| of all bodies, in the unit of g.
    pub fn constraint_residual(&self) -> f64 {
        let values = self.bodies.q.as_ref().iter().map(|q| self.system.constraint.value(q)[0].abs());
        values.fold(0.0, f64::max)
    }

    /// The largest |∇g(q)·p| of all bodies.
    pub fn cotangent_residual(&self) -> f64 {
        let pairs = self.bodies.normal.as_ref().iter().zip(self.bodies.p.as_ref());
        pairs.map(|(normal, p)| dot(&normal.gradient, p).abs()).fold(0.0, f64::max)
    }

    /// Multipliers λ of the bodies in turn, from the present state alone:
    /// λ = −(vᵀ∇²g v + ∇g·f)/|∇g|², of the order of the method.
    pub fn multipliers(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        (0..self.len()).map(|i| {
            let (q, p) = (&self.bodies.q.as_ref()[i], &self.bodies.p.as_ref()[i]);
            let normal = &self.bodies.normal.as_ref()[i];
            let [bend] = self.system.constraint.jet(q, p).2;
            multiplier_from_curvature(bend, self.bodies.force.as_ref()[i].dot(&normal.gradient), normal)
        })
    }
}

impl<C: Constraint<D, 1>, E: Effects<D>, S: Stepper, const D: usize> Simulation<C, E, One, S, D> {
    /// The particle's position.
    pub fn position(&self) -> SVector<f64, D> {
        self.bodies.q[0].into()
    }

    /// The particle's momentum; with unit mass also its velocity.
    pub fn momentum(&self) -> SVector<f64, D> {
        self.bodies.p[0].into()
    }

    /// λ of q̈ = −∇U + ∇g λ at the present state; see [`Self::multipliers`].
    pub fn multiplier(&self) -> f64 {
        self.multipliers().next().unwrap_or(f64::NAN)
    }
}

// Not derived: neither constraint nor effects need to be `Clone`, the simulation holds their kernels.
impl<C: Constraint<D, 1>, E: Effects<D>, N: Count, S: Stepper, const D: usize> Clone
    for Simulation<C, E, N, S, D>
{
    fn clone(&self) -> Self {
        Self {
            system: self.system.clone(),
            stepper: self.stepper.clone(),
            bodies: self.bodies.clone(),
            before: self.before.clone(),
            steps: self.steps,
            start_energy: self.start_energy,
        }
    }
}

impl<C: Constraint<D, 1>, E: Effects<D>, N: Count, S: Stepper, const D: usize> fmt::Debug
    for Simulation<C, E, N, S, D>
{
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut debug = f.debug_struct("Simulation");
        debug.field("method", &self.stepper.name()).field("time", &self.time()).field("bodies", &self.bodies);
        debug.finish_non_exhaustive()
    }
}

/// Passes a step's multipliers on to a recorder.
struct Listening<'a, R, S>(&'a mut R, PhantomData<S>);

impl<R: Recorder<S>, S> Witness<f64> for Listening<'_, R, S> {
    #[inline(always)]
    fn position_multiplier(&mut self, body: usize, lambda: f64) {
        self.0.position_multiplier(body, lambda);
    }
    #[inline(always)]
    fn momentum_multiplier(&mut self, body: usize, mu: f64) {
        self.0.momentum_multiplier(body, mu);
    }
}
