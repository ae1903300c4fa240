//! What a method is: a map that takes all bodies one step on. Which method moves which system:
//!
//! | method | surfaces | free bodies | links | links that move | acting links | rigid bodies | phase space |
//! |---|---|---|---|---|---|---|---|
//! | `Rattle`, and compositions of it | yes | yes | yes | yes | yes | yes | yes |
//! | `Geodesic`, `PositionVerlet`, and compositions; `Shake`, `SymplecticEuler` | yes | yes | yes | yes | yes | yes | – |
//! | `Lobatto` | yes | yes | yes | yes | – | – | – |
//! | `Leapfrog` | – | yes | – | – | – | yes | – |
//! | `Dop853` | yes | yes | yes | yes | yes | yes | – |
//! | `Taylor` | yes | yes | yes | yes | yes | yes | – |
//! | `Bdf2` | yes | yes | yes | – | yes | – | – |
//!
//! Others are refused before a run, see [`Need`].

use crate::bodies::Bodies;
use crate::effect::Field;
use crate::error::{Error, StepFailure};
use crate::kernel::ConstraintKernel;
use crate::real::{Mask, Real};
use crate::solver::Departure;
use crate::surface::Normal;
use crate::system::System;
use crate::vector::dot;
use std::fmt::Debug;

/// A method: a map of the bodies, and of what the method remembers.
///
/// A one-step method remembers nothing, and pays nothing for that. A method that looks back, or whose step size has a law
/// of its own, keeps numbers from step to step; they are made before the first step, cloned with the simulation, put back
/// bit for bit when a step fails, and part of a [`State`](crate::state::State) taken from it.
pub trait Stepper: Clone + Send + Sync + 'static {
    /// The numbers carried from step to step: `[T; 0]` for a one-step method.
    type Memory<T: Real>: AsRef<[T]> + AsMut<[T]> + Default + Clone + Debug + Send + Sync;

    /// The time that one step takes; negative to run backwards.
    fn step_size(&self) -> f64;
    /// The order p: errors fall like hᵖ.
    fn order(&self) -> u32;
    /// The method's name, as in the literature.
    fn name(&self) -> &'static str;

    /// The same method with another step size, which may be negative.
    #[must_use]
    fn with_step(&self, h: f64) -> Self;
    /// Whether a step of −h undoes a step of h, Φ₋ₕ ∘ Φₕ = 1, with nothing remembered: what
    /// [compositions](crate::composition) are made of.
    fn is_symmetric(&self) -> bool;

    /// How much later than positions momenta are, negative if earlier; 0 but for staggered methods. Only momenta of the
    /// same time can be, and are, those of motion along the constraints.
    fn momentum_delay(&self) -> f64 {
        0.0
    }

    /// The lengths of the RATTLE steps that one step consists of, if it does: such methods go in the lanes of an
    /// [ensemble](crate::ensemble), and make sense in [phase space](crate::phase).
    fn rattle_steps(&self) -> Option<Vec<f64>> {
        None
    }

    /// What the method asks of a system, which may refuse it before the run.
    fn need(&self) -> Need {
        Need::Verbs
    }

    /// Stages of a collocation method, or coefficients of a power series, for which a system makes room.
    fn stages(&self) -> usize {
        0
    }

    /// Vectors per body that a step writes to [`Bodies::room`].
    fn room(&self) -> usize {
        0
    }

    /// What else tells methods of one type, name and step size apart: they do not go on with each other's memory.
    fn parameters(&self) -> Vec<f64> {
        Vec::new()
    }

    /// What is remembered at the start of a run, with room for all that will ever be. Allocates what is allocated.
    fn memory<T: Real, Y: System<T, D>, const D: usize>(
        &self,
        _system: &Y,
        _bodies: &Bodies<Y::Count, T, Y::Kept, D>,
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
        system: &Y,
        bodies: &mut Bodies<Y::Count, T, Y::Kept, D>,
        memory: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure>;
}

/// What a method asks of a system.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Need {
    /// Drifts, forces and kicks, or rates of change and projection: every system has them.
    Verbs,
    /// A position equation along kept normals, which is solved as the method says.
    PositionEquation,
    /// Inner stages solved together.
    Stages,
    /// Momenta that are mass times velocity, and constraints that do not move.
    Differences,
    /// The motion as a power series in time.
    Series,
}

/// Refuses a step size that is zero or not finite.
pub(crate) fn check_step_size(h: f64) -> Result<(), Error> {
    if h.is_finite() && h != 0.0 { Ok(()) } else { Err(Error::StepSize(h)) }
}

/// Is told the multipliers as a step finds them; `()` does not listen, and then they are not formed.
pub trait Witness<T> {
    /// Whether multipliers are formed at all.
    const LISTENS: bool = true;

    /// λ of the position equation with this number: on surfaces, that of the body. A composition tells that of each
    /// of its steps, the last one last; a collocation method λ(t) at the start of the step, to its order.
    fn position_multiplier(&mut self, equation: usize, lambda: T);
    /// μ of the momentum equation; of a collocation method λ(t) at the end of the step.
    fn momentum_multiplier(&mut self, equation: usize, mu: T);
}

impl<T> Witness<T> for () {
    const LISTENS: bool = false;

    #[inline(always)]
    fn position_multiplier(&mut self, _: usize, _: T) {}
    #[inline(always)]
    fn momentum_multiplier(&mut self, _: usize, _: T) {}
}

/// Tells λ as that of the end of a step.
pub(crate) struct AtEnd<'a, W>(pub(crate) &'a mut W);

impl<T, W: Witness<T>> Witness<T> for AtEnd<'_, W> {
    const LISTENS: bool = W::LISTENS;

    fn position_multiplier(&mut self, equation: usize, lambda: T) {
        self.0.momentum_multiplier(equation, lambda);
    }
    fn momentum_multiplier(&mut self, _: usize, _: T) {}
}

/// Why a step failed, and for which body.
#[derive(Debug, Clone, PartialEq)]
pub struct Failure {
    /// Which body, counted from 0.
    pub body: usize,
    /// What stopped it.
    pub cause: StepFailure,
}

impl Failure {
    /// A failure of `body` in the first lane where the condition does not hold.
    #[cold]
    pub(crate) fn at<M: Mask>(body: usize, holds: M) -> FailureAt {
        FailureAt { body, lane: holds.lanes().position(|held| !held).unwrap_or(0) }
    }
}

/// Where a step failed; its methods find out why.
pub(crate) struct FailureAt {
    body: usize,
    lane: usize,
}

impl FailureAt {
    fn number<T: Real>(&self, x: T) -> f64 {
        x.lanes().nth(self.lane).unwrap_or(f64::NAN)
    }

    fn numbers<T: Real, const D: usize>(&self, x: &[T; D]) -> Vec<f64> {
        x.iter().map(|&x| self.number(x)).collect()
    }

    /// The stages of a collocation method did not converge.
    #[cold]
    pub(crate) fn unsolved(&self, h: f64, stages: usize, iterations: usize, left: f64) -> Failure {
        self.because(StepFailure::StagesNotSolved { h, stages, iterations, left })
    }

    /// Successive stages are on different sides of the surface.
    #[cold]
    pub(crate) fn turned_over(&self, h: f64, stages: usize) -> Failure {
        self.because(StepFailure::StagesTurnOver { h, stages })
    }

    /// The end of the step is too far from the constraint.
    #[cold]
    pub(crate) fn not_projected<T: Real, const D: usize>(
        &self,
        distance: T,
        path: &[T; D],
        q: &[T; D],
    ) -> Failure {
        let (distance, path) = (self.number(distance), self.number(dot(path, path)).sqrt());
        self.because(if distance.is_finite() {
            StepFailure::NotProjected { distance, path }
        } else {
            StepFailure::ConstraintNotFinite { position: self.numbers(q) }
        })
    }

    fn because(&self, cause: StepFailure) -> Failure {
        Failure { body: self.body, cause }
    }

    /// |∇g|, |v| and κ at the start of the step.
    fn curvature<T: Real, const D: usize>(
        &self,
        normal: &Normal<T, D>,
        p: &[T; D],
        bend: T,
    ) -> (f64, f64, f64) {
        let gradient = self.number(dot(&normal.gradient, &normal.gradient)).sqrt();
        let speed = self.number(dot(p, p)).sqrt();
        let curvature = if speed == 0.0 { 0.0 } else { self.number(bend).abs() / (gradient * speed * speed) };
        (gradient, speed, curvature)
    }

    fn no_normal<T: Real, const D: usize>(&self, q: &[T; D], gradient: &[T; D]) -> Option<Failure> {
        let (position, gradient) = (self.numbers(q), self.numbers(gradient));
        let square: f64 = gradient.iter().map(|n| n * n).sum();
        let none = !(square > 0.0 && square.is_finite());
        none.then(|| self.because(StepFailure::NoNormal { position, gradient }))
    }

    /// h·κ·|v| is not below 1.
    #[cold]
    #[inline(never)]
    pub(crate) fn too_long<T: Real, const D: usize>(
        &self,
        h: f64,
        departure: &Departure<'_, T, D>,
        p: &[T; D],
        bend: T,
    ) -> Failure {
        let (_, speed, curvature) = self.curvature(departure.normal, p, bend);
        let reach = h.abs() * curvature * speed;
        self.no_normal(departure.q, &departure.normal.gradient).unwrap_or_else(|| {
            self.because(if reach.is_finite() {
                StepFailure::StepTooLong { h, reach, curvature, speed, longest: h.abs() / reach }
            } else {
                StepFailure::ConstraintNotFinite { position: self.numbers(departure.q) }
            })
        })
    }

    /// The position equation has no solution that can be used: solves it once more, taking notes.
    #[cold]
    #[inline(never)]
    pub(crate) fn lost<T: Real, K: ConstraintKernel<T, D, 1>, const D: usize>(
        &self,
        h: f64,
        constraint: &K,
        departure: &Departure<'_, T, D>,
        p: &[T; D],
        bend: T,
    ) -> Failure {
        let mut corrections = Vec::new();
        let landing = departure.land(constraint, |length| corrections.push(self.number(length)));
        corrections.retain(|&length| length != 0.0); // second corrections that were not made
        let (gradient, speed, curvature) = self.curvature(departure.normal, p, bend);
        let reach = h.abs() * curvature * speed;
        if corrections.iter().any(|length| !length.is_finite()) {
            let position = self.numbers(departure.q);
            return self.because(StepFailure::ConstraintNotFinite { position });
        }
        let path = self.number(dot(&departure.free, &departure.free)).sqrt();
        if !landing.converged.lanes().nth(self.lane).unwrap_or(false) {
            return self.because(StepFailure::NoConvergence {
                path,
                corrections: corrections.into_iter().collect(),
                floor: self.number(landing.floor),
                gradient,
                reach,
            });
        }
        let arrival = departure.point(landing.multiplier);
        if let Some(failure) = self.no_normal(&arrival, &landing.gradient) {
            return failure;
        }
        let after = self.number(dot(&landing.gradient, &landing.gradient)).sqrt();
        let cosine = self.number(dot(&landing.gradient, &departure.normal.gradient)) / (gradient * after);
        let correction = self.number(landing.multiplier).abs() * gradient;
        self.because(StepFailure::RootLost { cosine, correction, path, reach })
    }

    /// The momentum is not finite: a force or a normal is not.
    #[cold]
    #[inline(never)]
    pub(crate) fn not_finite<T: Real, F: Field<T, D>, const D: usize>(
        &self,
        field: &F,
        positions: &[[T; D]],
        normals: &[Normal<T, D>],
    ) -> Failure {
        let position = self.numbers(&positions[self.body]);
        if let Some((effect, force)) = field.culprit(positions, self.body) {
            return self.because(StepFailure::ForceNotFinite {
                effect,
                force: self.numbers(&force),
                position,
            });
        }
        self.no_normal(&positions[self.body], &normals[self.body].gradient)
            .unwrap_or_else(|| self.because(StepFailure::MomentumNotFinite { position }))
    }
}
