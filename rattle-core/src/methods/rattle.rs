//! RATTLE: the symplectic integrator of constrained mechanics (Andersen 1983).
//!
//! ```text
//! p½ = p  + h/2 (∇g(q) λ − ∇U(q))         λ such that g(q′) = 0
//! q′ = q  + h p½
//! p′ = p½ + h/2 (∇g(q′) μ − ∇U(q′))       μ such that ∇g(q′)·p′ = 0
//! ```
//!
//! Second order, symplectic, and reversible while the step is short enough to have one clear solution, h·κ·|v| ≲ ½. λ
//! and μ have the scale of q̈ = −∇U + ∇g λ. Each is of first order; their mean (μₙ + λₙ₊₁)/2 at tₙ is of second order.
//! Without constraints, RATTLE is the velocity form of the Störmer–Verlet method, kick–drift–kick.
//!
//! A step is computed as an increment and added once, and q and p are compensated sums (Kahan 1965). So rounding errors
//! of the energy grow like √n in n steps, not like n. The [iteration](crate::motion::iteration) for the position
//! equation and its [first guess](crate::motion::guess) change only last bits and the cost of a step. By default
//! Newton's method begins with λ from g̈ = 0, so a step is a pure function of the state.
//!
//! Source: E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, VII.1.4.

use crate::motion::failure::Failure;
use crate::motion::guess::{FromState, Guess};
use crate::motion::iteration::{Iteration, Kind, Newton};
use crate::motion::method::{Method, Splitting, Stage};
use crate::motion::need::Steps;
use crate::motion::parts::BodiesOf;
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::real::Scalar;
use std::marker::PhantomData;

/// RATTLE with a constant step size, second order.
///
/// A negative step size runs backwards in time. A step needs h·κ·|v| < 1, with κ the normal curvature of the surface
/// along the velocity v, and is an error otherwise; for accuracy stay below 0.2.
///
/// ```
/// # use rattle::Rattle;
/// let method = Rattle::new(0.01);
/// ```
#[doc(alias = "integrator")]
#[doc(alias = "Verlet")]
#[doc(alias = "symplectic")]
#[doc(alias = "leapfrog")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rattle<G = FromState, X = Newton> {
    h: f64,
    guess: G,
    iteration: X,
}

impl Rattle {
    /// RATTLE with step size `h`, in the unit of time.
    #[doc(alias = "dt")]
    #[doc(alias = "timestep")]
    #[must_use]
    pub fn new(h: f64) -> Self {
        Self { h, guess: FromState, iteration: Newton }
    }
}

impl<G: Guess, X: Iteration> Rattle<G, X> {
    /// The same method with another [first guess](crate::motion::guess) of the multipliers.
    ///
    /// The motion is the same to rounding; the number of values, gradients and second derivatives that a step evaluates
    /// changes. The memory of the guess is part of the [`State`](crate::motion::state::State) of a simulation, so a run
    /// continues from a state bit for bit.
    ///
    /// ```
    /// # use rattle::{guess::{Extrapolated, LastMultiplier}, Rattle};
    /// let few_values = Rattle::new(0.01).guess(Extrapolated);
    /// let steps_of_any_length = Rattle::new(0.01).guess(LastMultiplier);
    /// ```
    #[must_use]
    pub fn guess<H: Guess>(self, guess: H) -> Rattle<H, X> {
        Rattle { h: self.h, guess, iteration: self.iteration }
    }

    /// The same method with another [iteration](crate::motion::iteration) for its position equation.
    ///
    /// The motion is the same to rounding; the number of values and gradients that a step evaluates changes.
    ///
    /// ```
    /// # use rattle::{iteration::Broyden, Rattle};
    /// let where_gradients_are_dear = Rattle::new(0.01).solved_by(Broyden);
    /// ```
    #[must_use]
    pub fn solved_by<Z: Iteration>(self, iteration: Z) -> Rattle<G, Z> {
        Rattle { h: self.h, guess: self.guess, iteration }
    }
}

impl<G: Guess, X: Iteration> Method for Rattle<G, X> {
    type Memory<T: Scalar> = G::Memory<T>;
    type Need = Steps<X>;

    fn step_size(&self) -> f64 {
        self.h
    }
    fn order(&self) -> u32 {
        2
    }
    fn name(&self) -> &'static str {
        match X::KIND {
            Kind::Newton => "RATTLE",
            Kind::Symmetric => "RATTLE by symmetric corrections",
            Kind::Simplified => "RATTLE by simplified corrections",
            Kind::Broyden => "RATTLE by Broyden's method",
        }
    }
    fn with_step(&self, h: f64) -> Self {
        Self { h, ..*self }
    }
    fn is_symmetric(&self) -> bool {
        true
    }
    const KEEPS_FORCES: bool = true;
    const SPLITTING: Splitting = Splitting::OneStage;
    fn stages(&self) -> Vec<Stage> {
        vec![Stage { before: 0.5 * self.h, h: self.h, after: 0.5 * self.h }]
    }

    fn memory<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        system: &Y,
        _: &BodiesOf<Y, T, D>,
    ) -> G::Memory<T> {
        // How many steps there were, and of what length; guesses, and what they are made from.
        G::room(2 + (1 + G::NUMBERS) * system.equations())
    }

    #[inline(always)]
    fn step<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: &Y,
        bodies: &mut BodiesOf<Y, T, D>,
        memory: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        // `Variable` keeps nothing between steps.
        if const { G::NUMBERS == 0 } || memory.is_empty() {
            return step::<X, _, _, _, D>(self.h, &[], system, bodies, witness);
        }
        let ([steps, length], multipliers) = memory.split_first_chunk_mut().expect("as `memory` makes it");
        let h = T::from_f64(self.h);
        let (guess, numbers) = multipliers.split_at_mut(system.equations());
        let same_length = G::STEPS <= 1.0 || (h.le(*length) & length.le(h));
        let known = same_length && steps.to_f64() >= G::STEPS;
        if known {
            let each = numbers.chunks_exact(G::NUMBERS.max(1));
            guess.iter_mut().zip(each).for_each(|(guess, numbers)| *guess = G::guess(numbers));
        }
        let guess = if known { &*guess } else { &[] };
        let mut noting = Noting::<G, T, W> { numbers, witness, guess: PhantomData };
        step::<X, _, _, _, D>(self.h, guess, system, bodies, &mut noting)?;
        let counted = if same_length { *steps } else { T::from_f64(0.0) };
        (*steps, *length) = ((counted + T::from_f64(1.0)).min(T::from_f64(3.0)), h);
        Ok(())
    }
}

/// What is remembered of each equation, and who else listens.
struct Noting<'a, G, T, W> {
    numbers: &'a mut [T],
    witness: &'a mut W,
    guess: PhantomData<G>,
}

impl<G: Guess, T: Scalar, W: Witness<T>> Witness<T> for Noting<'_, G, T, W> {
    #[inline(always)]
    fn position_multiplier(&mut self, equation: usize, lambda: T) {
        G::note_position(&mut self.numbers[G::NUMBERS * equation..][..G::NUMBERS], lambda);
        self.witness.position_multiplier(equation, lambda);
    }
    #[inline(always)]
    fn momentum_multiplier(&mut self, equation: usize, mu: T) {
        G::note_momentum(&mut self.numbers[G::NUMBERS * equation..][..G::NUMBERS], mu);
        self.witness.momentum_multiplier(equation, mu);
    }
}

/// One step of size `h`, begun with this guess of λ, or from g̈ = 0 without one; on failure `bodies` are left half way.
#[inline(always)]
pub(crate) fn step<X: Iteration, T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
    h: f64,
    guess: &[T],
    system: &Y,
    bodies: &mut BodiesOf<Y, T, D>,
    witness: &mut W,
) -> Result<(), Failure> {
    system.drift_by::<X, W>(0.5 * h, h, guess, bodies, witness)?;
    system.evaluate_forces(bodies);
    system.settle(0.5 * h, h, bodies, witness)
}
