//! What a method is: a map that takes all bodies one step on. Which method moves which system:
//!
//! | method | surfaces | free bodies | links | links that move | acting links | rigid bodies | phase space |
//! |---|---|---|---|---|---|---|---|
//! | `Rattle`, and compositions of it | yes | yes | yes | yes | yes | yes | yes |
//! | `Geodesic`, `PositionVerlet`, and compositions; `Shake`, `SymplecticEuler` | yes | yes | yes | yes | yes | yes | – |
//! | `Baoab`, `Brownian` | yes | yes | yes | yes | yes | yes | – |
//! | `NoseHoover` | yes | yes | yes | – | yes | yes | – |
//! | `Lobatto` | yes | yes | yes | yes | – | – | – |
//! | `Leapfrog` | – | yes | – | – | – | yes | – |
//! | `Dop853` | yes | yes | yes | yes | yes | yes | – |
//! | `Taylor` | yes | yes | yes | yes | yes | yes | – |
//! | `Bdf2` | yes | yes | yes | – | yes | – | – |
//!
//! Other combinations are refused before a run, see [`Method::Need`].
//!
//! Constructors take their arguments in this order: the parts of the method (coefficients, an order, a number of inner
//! steps); the step size `h`, or the method that has it; times and tolerances that control the steps:
//! `Composition::new(coefficients, h)`, `Composition::of(coefficients, base)`, `Geodesic::new(inner, h)`,
//! `Taylor::adaptive(order, h, tolerance)`, `Variable::of(base, tau)`. Baths name what they are first and `h` last:
//! `NoseHoover::new(temperature, time, h)`, `Brownian::new(friction, temperature, seed, h)`.

use crate::effect::noise::halves;
use crate::effect::ornstein_uhlenbeck::OrnsteinUhlenbeck;
use crate::error::Error;
use crate::motion::failure::Failure;
use crate::motion::identity::Identity;
use crate::motion::need::Need;
use crate::motion::parts::BodiesOf;
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::real::Scalar;
use std::fmt::Debug;

/// A system as a step of the method sees it: the capabilities that the method [needs](Method::Need).
pub type View<'a, S, T, Y, const D: usize> = <<S as Method>::Need as Need>::Of<'a, T, Y, D>;

/// A method: a map that takes the bodies, and the memory of the method, one step on.
///
/// A one-step method has no memory, at no cost. A multistep method, or one that chooses its step size, keeps numbers
/// from step to step. They are made before the first step, cloned with the simulation, restored bit for bit when a step
/// fails, and part of a [`State`](crate::motion::state::State) taken from it.
#[doc(alias = "integrator")]
#[doc(alias = "scheme")]
#[doc(alias = "stepper")]
pub trait Method: Clone + Send + Sync + 'static {
    /// The numbers carried from step to step: `[T; 0]` for a one-step method.
    type Memory<T: Scalar>: AsRef<[T]> + AsMut<[T]> + Default + Clone + Debug + Send + Sync;
    /// The capabilities that the method needs: a type of [`need`](crate::motion::need), or a tuple of them. A system
    /// without them is refused before the run.
    type Need: Need;

    /// The time interval of one step; negative to run backwards.
    fn step_size(&self) -> f64;
    /// The order p: errors fall like hᵖ.
    fn order(&self) -> u32;
    /// The method's name, as in the literature.
    fn name(&self) -> &'static str;

    /// The same step with so many times as many steps of free motion between its kicks, and the same random numbers;
    /// none where a method has no such. For those that have [flows](Self::STIRS) act inside their step.
    fn finer(&self, _times: u32) -> Option<Self> {
        None
    }

    /// The same method with another step size, which may be negative.
    #[must_use]
    fn with_step(&self, h: f64) -> Self;
    /// The same method with its tolerance times `factor`; `None` if its errors do not depend on a tolerance.
    #[must_use]
    fn with_tolerance_times(&self, _factor: f64) -> Option<Self> {
        None
    }
    /// Whether the method is symmetric, Φ₋ₕ ∘ Φₕ = 1, without memory. Only such methods can be
    /// [composed](crate::methods::composition).
    fn is_symmetric(&self) -> bool;

    /// The time of the momenta minus the time of the positions: 0 except for staggered methods such as leapfrog.
    /// Momenta are tangent to the constraints only where this is 0.
    fn momentum_delay(&self) -> f64 {
        0.0
    }

    /// Whether each step solves the constraints along its way, as RATTLE does. After a step of a method that does not
    /// (`Bdf2`, and `Taylor` and `Dop853` after each inner step), it is checked whether the step passed a singular
    /// point.
    const HAS_STRUCTURE: bool = true;

    /// Whether a step follows the root of its constraints from its start. A method that does not may end on another
    /// sheet of {g = 0}; the simulation checks that after a step where other sheets are near, and whether the energy
    /// jumped.
    const FOLLOWS_ROOTS: bool = Self::HAS_STRUCTURE;

    /// Whether a step checks by itself what the simulation would check after it: a method that divides its steps has
    /// each inner one checked.
    #[doc(hidden)]
    const CHECKS: bool = false;

    /// Why a step cannot be divided, by [`retry`](crate::run::simulation::Simulation::retry) or at an event; `None` if
    /// it can.
    fn undivided(&self) -> Option<&'static str> {
        None
    }

    /// Whether a step draws random numbers.
    const DRAWS: bool = false;

    /// Whether the method applies the [flows](crate::effect::Flow) of momenta (drag, heat) inside its step. Otherwise
    /// half of each flow is applied before the step and half after it.
    const STIRS: bool = false;

    /// After how many of its [stages](Self::stages) a step applies the flows, where it [does so](Self::STIRS).
    fn stirs_after(&self) -> usize {
        0
    }

    /// Whether the method has no momenta (overdamped motion), so that the only possible flows are
    /// [pushes](crate::effect::Acting::PUSHES).
    const FORGETS: bool = false;

    /// Whether a step ends with the forces at its end, so that who asks for them there need not evaluate them anew.
    const KEEPS_FORCES: bool = false;

    /// Whether a step is a splitting into [stages](Self::stages). A constant of the type, so that the SIMD code of
    /// ensembles is compiled for such methods alone.
    const SPLITTING: Splitting = Splitting::Not;

    /// The stages of one step in order, as many as [`SPLITTING`](Self::SPLITTING) says.
    /// [Ensembles](crate::run::ensemble) compute such methods in SIMD lanes.
    fn stages(&self) -> Vec<Stage> {
        Vec::new()
    }

    /// The number of stages of a [collocation](crate::motion::capability::Collocation) method; 0 for other methods. A
    /// constant of the type, as [`SPLITTING`](Self::SPLITTING), so that the SIMD code of ensembles is compiled for such
    /// methods alone, with a [`Table`](crate::motion::table::Table) of this many stages.
    const COLLOCATES: usize = 0;

    /// Whether a step disregards the constraint until its end is projected onto it, and how it gets there. A constant
    /// of the type, as [`SPLITTING`](Self::SPLITTING), so that the SIMD code of ensembles is compiled for such methods
    /// alone.
    const PROJECTS: Projecting = Projecting::Not;

    /// Whether each step [draws momenta anew](Self::renewal). A constant of the type, as
    /// [`SPLITTING`](Self::SPLITTING), so that the SIMD code of ensembles is compiled for such methods alone.
    const RENEWS: bool = false;

    /// The momenta that each step draws, where it [does so](Self::RENEWS).
    fn renewal(&self) -> Option<Renewal> {
        None
    }

    /// The tolerance of the inner steps into which a step is divided, a length; `None` where it is not divided.
    fn tolerance(&self) -> Option<f64> {
        None
    }

    /// How often a step evaluates the forces; `None` if that is not known in advance. Used by the
    /// [bill](crate::run::bill).
    fn evaluations(&self) -> Option<usize> {
        match Self::SPLITTING {
            Splitting::Not => None,
            Splitting::OneStage | Splitting::Stages => Some(self.stages().len()),
        }
    }

    /// Further parameters that distinguish methods of one type, name and step size. A method does not use the memory of
    /// a method with other parameters.
    fn parameters(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Type, name, step size and parameters.
    fn identity(&self) -> Identity {
        Identity::of::<Self>(self.name(), [vec![self.step_size()], self.parameters()].concat())
    }

    /// Allocates before a run the memory that steps work with, so that steps need not.
    fn prepare<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        _system: View<'_, Self, T, Y, D>,
        _bodies: &mut BodiesOf<Y, T, D>,
    ) {
    }

    /// The memory at the start of a run, at its final size: no later step allocates.
    fn memory<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        _system: View<'_, Self, T, Y, D>,
        _bodies: &BodiesOf<Y, T, D>,
    ) -> Self::Memory<T> {
        Self::Memory::default()
    }

    /// The memory at these bodies in the midst of a run that has this one: what is one number for a whole run stays.
    fn memory_within<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        system: View<'_, Self, T, Y, D>,
        bodies: &BodiesOf<Y, T, D>,
        _of_run: &[T],
    ) -> Self::Memory<T> {
        self.memory(system, bodies)
    }

    /// The length of the last step, from this memory; `None` if all steps have the step size, so that the time is steps
    /// × h.
    fn time_taken<T: Scalar>(&self, _memory: &[T]) -> Option<T> {
        None
    }

    /// Checks, once before a run, that the method makes sense for a system with this number of equations.
    ///
    /// # Errors
    /// [`Error::StepSize`] for a step size that is zero or not finite.
    fn check(&self, _equations: usize) -> Result<(), Error> {
        check_step_size(self.step_size())
    }

    /// Takes `bodies` one step on, and `memory` with them. Neither allocates nor panics.
    ///
    /// # Errors
    /// Which body cannot be moved, and why; `bodies` and `memory` are then left unfinished.
    fn step<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        memory: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure>;
}

/// Whether a step of a [`Method`] is a splitting into [stages](Stage).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Splitting {
    /// No splitting.
    Not,
    /// One stage.
    OneStage,
    /// Any number of stages.
    Stages,
}

/// Whether a step of a [`Method`] disregards the constraint until its end is projected onto it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Projecting {
    /// It does not, or has no form in lanes.
    Not,
    /// By the stages of [`Dop853`](crate::methods::dop853::Dop853), with its [tolerance](Method::tolerance).
    Dop853,
    /// By the power series of [`Taylor`](crate::methods::taylor::Taylor), of its [order](Method::order) and with its
    /// [tolerance](Method::tolerance).
    Taylor,
}

/// Momenta that a step of a [`Method`] draws anew: they are drawn, a kick follows and then the drift of the step, both
/// along the constraints, and after it they are forgotten.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Renewal {
    /// The seed of the random numbers, the first of their step: [`Noise::normal`](crate::effect::Noise::normal).
    pub seed: u64,
    /// Their standard deviation, that of a momentum of a mass of 1.
    pub deviation: f64,
    /// The kick, a time.
    pub kick: f64,
}

impl Renewal {
    /// All of it as numbers that lose no bit.
    pub(crate) fn numbers(&self) -> [f64; 4] {
        let [high, low] = halves(self.seed);
        [self.deviation, self.kick, high, low]
    }

    /// What forgets momenta and draws others, as a process.
    pub(crate) fn process(&self) -> OrnsteinUhlenbeck {
        OrnsteinUhlenbeck { lost: -1.0, variance: self.deviation * self.deviation, seed: self.seed }
    }
}

/// A stage of a splitting: a drift along the constraints, with a kick before and after it. After each kick momenta are
/// made tangent to the constraints. All three numbers are times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stage {
    /// The kick before.
    pub before: f64,
    /// The drift.
    pub h: f64,
    /// The kick after, by the forces at the end of the drift.
    pub after: f64,
}

impl Stage {
    /// All numbers of these stages.
    pub(crate) fn numbers(stages: &[Self]) -> Vec<f64> {
        stages.iter().flat_map(|stage| [stage.before, stage.h, stage.after]).collect()
    }

    /// These stages in one of so many equal parts of a step, and the sum of their drifts.
    pub(crate) fn parts(stages: &[Self], parts: u32) -> (Vec<Self>, f64) {
        let share = |x: f64| x / f64::from(parts);
        let part =
            |stage: &Self| Self { before: share(stage.before), h: share(stage.h), after: share(stage.after) };
        let stages: Vec<_> = stages.iter().map(part).collect();
        let whole = stages.iter().map(|stage| stage.h).sum();
        (stages, whole)
    }

    /// The same kicks, with each drift between them in so many equal parts.
    pub(crate) fn finer(stages: &[Self], times: u32) -> Vec<Self> {
        let part = |&Self { before, h, after }: &Self| {
            (1..=times).map(move |i| Self {
                before: if i == 1 { before } else { 0.0 },
                h: h / f64::from(times),
                after: if i == times { after } else { 0.0 },
            })
        };
        stages.iter().flat_map(part).collect()
    }
}

/// Refuses a step size that is zero or not finite.
pub(crate) fn check_step_size(h: f64) -> Result<(), Error> {
    if h.is_finite() && h != 0.0 { Ok(()) } else { Err(Error::StepSize(h)) }
}

/// Refuses a tolerance, where there is one, that is not positive or not finite.
pub(crate) fn check_tolerance(tolerance: Option<f64>) -> Result<(), Error> {
    match tolerance {
        Some(tolerance) if !(tolerance > 0.0 && tolerance.is_finite()) => Err(Error::Tolerance(tolerance)),
        _ => Ok(()),
    }
}
