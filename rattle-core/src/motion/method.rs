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
//! Others are refused before a run, see [`Method::Need`].
//!
//! Arguments of constructors stand in one order: what the method is made of (coefficients, an order, a number of inner
//! steps), the step size `h` or the method that has it, then times and tolerances that steps are chosen by:
//! `Composition::new(coefficients, h)`, `Composition::of(coefficients, base)`, `Geodesic::new(inner, h)`,
//! `Taylor::adaptive(order, h, tolerance)`, `Variable::of(base, tau)`.

use crate::error::Error;
use crate::motion::failure::Failure;
use crate::motion::identity::Identity;
use crate::motion::need::Need;
use crate::motion::system::{BodiesOf, System};
use crate::motion::witness::Witness;
use crate::number::real::Real;
use std::fmt::Debug;

/// A system as a step of the method is handed it: the capabilities that the method [needs](Method::Need).
pub type View<'a, S, T, Y, const D: usize> = <<S as Method>::Need as Need>::Of<'a, T, Y, D>;

/// A method: a map of the bodies, and of what the method remembers.
///
/// A one-step method remembers nothing, and pays nothing for that. A method that looks back, or whose step size has a
/// law of its own, keeps numbers from step to step; they are made before the first step, cloned with the simulation,
/// put back bit for bit when a step fails, and part of a [`State`](crate::motion::state::State) taken from it.
pub trait Method: Clone + Send + Sync + 'static {
    /// The numbers carried from step to step: `[T; 0]` for a one-step method.
    type Memory<T: Real>: AsRef<[T]> + AsMut<[T]> + Default + Clone + Debug + Send + Sync;
    /// What the method asks of a system, one of [`need`](crate::motion::need) or a tuple of them; a system that has it
    /// not is refused before the run.
    type Need: Need;

    /// The time that one step takes; negative to run backwards.
    fn step_size(&self) -> f64;
    /// The order p: errors fall like hᵖ.
    fn order(&self) -> u32;
    /// The method's name, as in the literature.
    fn name(&self) -> &'static str;

    /// The same method with another step size, which may be negative.
    #[must_use]
    fn with_step(&self, h: f64) -> Self;
    /// The same method with so many times its tolerance; none if no tolerance decides on its errors.
    #[must_use]
    fn with_tolerance_times(&self, _factor: f64) -> Option<Self> {
        None
    }
    /// Whether a step of −h undoes a step of h, Φ₋ₕ ∘ Φₕ = 1, with nothing remembered: what
    /// [compositions](crate::methods::composition) are made of.
    fn is_symmetric(&self) -> bool;

    /// How much later than positions momenta are, negative if earlier; 0 but for staggered methods. Only momenta of the
    /// same time can be, and are, those of motion along the constraints.
    fn momentum_delay(&self) -> f64 {
        0.0
    }

    /// Whether a step follows the motion on its constraints: one that does not is [looked at](crate::run::simulation)
    /// afterwards, whether it passed a singular point, and whether its energy comes from anywhere.
    const HAS_STRUCTURE: bool = true;

    /// Whether a step follows the root of its constraints from its start: one that does not may end on another sheet,
    /// and is looked at afterwards where others are near.
    const FOLLOWS_ROOTS: bool = Self::HAS_STRUCTURE;

    /// Why a step cannot be taken in parts, by [`retry`](crate::run::simulation::Simulation::retry) or at the instant
    /// of an event; none if it can.
    fn undivided(&self) -> Option<&'static str> {
        None
    }

    /// Whether a step draws random numbers.
    const DRAWS: bool = false;

    /// Whether a step has the [flows](crate::effect::Flow) of momenta act itself, where it wants them; else half of
    /// them acts before it and half after.
    const STIRS: bool = false;

    /// Whether momenta play no part, so that of flows only [pushes](crate::effect::Acting::PUSHES) make sense.
    const FORGETS: bool = false;

    /// Whether a step is a splitting into [stages](Self::stages): known by the type, so that the lanes of an ensemble
    /// are compiled for methods of that kind alone.
    const SPLITTING: Splitting = Splitting::Not;

    /// The stages that one step consists of, as many as [`SPLITTING`](Self::SPLITTING) says, in turn: such methods go
    /// in the lanes of an [ensemble](crate::run::ensemble).
    fn stages(&self) -> Vec<Stage> {
        Vec::new()
    }

    /// How many stages a step of [collocation](crate::motion::capability::Collocation) solves together; 0 if it is
    /// none. Known by the type, as [`SPLITTING`](Self::SPLITTING) is, so that the lanes of an ensemble are compiled for
    /// such methods alone, of a [`Table`](crate::motion::table::Table) with so many stages.
    const COLLOCATES: usize = 0;

    /// How often a step evaluates the forces, where that is known before: for the [bill](crate::run::bill).
    fn evaluations(&self) -> Option<usize> {
        match Self::SPLITTING {
            Splitting::Not => None,
            Splitting::OneStage | Splitting::Stages => Some(self.stages().len()),
        }
    }

    /// What else tells methods of one type, name and step size apart: they do not go on with each other's memory.
    fn parameters(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Type, name, step size and parameters.
    fn identity(&self) -> Identity {
        Identity::of::<Self>(self.name(), [vec![self.step_size()], self.parameters()].concat())
    }

    /// Makes room before a run for what a step works with, so that steps need not allocate.
    fn prepare<T: Real, Y: System<T, D>, const D: usize>(
        &self,
        _system: View<'_, Self, T, Y, D>,
        _bodies: &mut BodiesOf<Y, T, D>,
    ) {
    }

    /// What is remembered at the start of a run, with room for all that will ever be. Allocates what is allocated.
    fn memory<T: Real, Y: System<T, D>, const D: usize>(
        &self,
        _system: View<'_, Self, T, Y, D>,
        _bodies: &BodiesOf<Y, T, D>,
    ) -> Self::Memory<T> {
        Self::Memory::default()
    }

    /// How long the step was that left this memory; none if each is of the step size, and the time steps × h.
    fn time_taken<T: Real>(&self, _memory: &[T]) -> Option<T> {
        None
    }

    /// Whether the method makes sense for a system with so many equations, asked once before a run.
    ///
    /// # Errors
    /// [`Error::StepSize`] for a step size that is zero or not finite.
    fn check(&self, _equations: usize) -> Result<(), Error> {
        check_step_size(self.step_size())
    }

    /// Takes `bodies` one step on, and `memory` with them. Neither allocates nor panics.
    ///
    /// # Errors
    /// Says which body cannot be moved and why; `bodies` and `memory` are then left half way.
    fn step<T: Real, Y: System<T, D>, W: Witness<T>, const D: usize>(
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
    /// It is not.
    Not,
    /// Into one.
    OneStage,
    /// Into any number of them.
    Stages,
}

/// A drift of a splitting along the constraints, with the kicks before and after it; after each kick momenta are made
/// those of motion along the constraints. All are lengths of time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stage {
    /// The kick before.
    pub before: f64,
    /// The drift.
    pub h: f64,
    /// The kick after, by the forces there.
    pub after: f64,
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
