//! The first guess of the multipliers, from which the iteration of a step begins.
//!
//! | guess | λ begins as | order of its error | second derivatives of g |
//! |---|---|---|---|
//! | [`FromState`], the default | λ from g̈ = 0 at the start of the step | h | needed |
//! | [`LastMultiplier`] | μ of the last step | h | not needed |
//! | [`Extrapolated`] | λ continued from the last three steps | h³ | not needed |
//!
//! A guess changes how many evaluations a step takes; it changes the result in its last bits only. Where the guess is
//! wrong by more than a hundredth of the length of the step's path, the step is repeated from [`FromState`]. What
//! steps begin with in the lanes of an [ensemble](crate::run::ensemble) is told there.

use crate::number::real::Scalar;
use std::fmt::Debug;

/// A rule for the first guess of multipliers.
#[doc(alias = "warm start")]
#[doc(alias = "initial guess")]
pub trait Guess: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// The numbers kept from step to step.
    type Memory<T: Scalar>: AsRef<[T]> + AsMut<[T]> + Default + Clone + Debug + Send + Sync;
    /// How many steps must precede the first guess; where more than one, they must have the same length.
    const STEPS: f64;
    /// How many numbers RATTLE keeps for each equation.
    const NUMBERS: usize;

    /// Memory for `count` numbers, all 0; empty where nothing is kept.
    fn room<T: Scalar>(count: usize) -> Self::Memory<T>;
    /// The guess of λ of the next step.
    fn guess<T: Scalar>(numbers: &[T]) -> T;
    /// Stores λ of the position equation of a step.
    fn note_position<T: Scalar>(_numbers: &mut [T], _lambda: T) {}
    /// Stores μ of the momentum equation of a step.
    fn note_momentum<T: Scalar>(_numbers: &mut [T], _mu: T) {}
}

/// λ from g̈ = 0 at the start of the step. Nothing is kept from earlier steps, so a step depends on the present state
/// alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FromState;

/// μ of the last step. Its error is of first order in h. No second derivative is evaluated, and steps may differ in
/// length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LastMultiplier;

/// λ extrapolated from earlier steps: RATTLE continues the parabola through its last three λ, 3λₙ − 3λₙ₋₁ + λₙ₋₂;
/// Lobatto methods continue the polynomial through the stages of the last step. No second derivative is evaluated.
/// Until enough steps of one length have been taken, a step begins as with [`FromState`].
#[doc(alias = "warm start")]
#[doc(alias = "predictor")]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Extrapolated;

impl Guess for FromState {
    type Memory<T: Scalar> = [T; 0];
    const STEPS: f64 = 0.0;
    const NUMBERS: usize = 0;

    fn room<T: Scalar>(_: usize) -> [T; 0] {
        []
    }
    fn guess<T: Scalar>(_: &[T]) -> T {
        T::from_f64(0.0)
    }
}

impl Guess for LastMultiplier {
    type Memory<T: Scalar> = Vec<T>;
    const STEPS: f64 = 1.0;
    const NUMBERS: usize = 1;

    fn room<T: Scalar>(count: usize) -> Vec<T> {
        vec![T::from_f64(0.0); count]
    }
    #[inline(always)]
    fn guess<T: Scalar>(numbers: &[T]) -> T {
        numbers[0]
    }
    #[inline(always)]
    fn note_momentum<T: Scalar>(numbers: &mut [T], mu: T) {
        numbers[0] = mu;
    }
}

impl Guess for Extrapolated {
    type Memory<T: Scalar> = Vec<T>;
    const STEPS: f64 = 3.0;
    const NUMBERS: usize = 3;

    fn room<T: Scalar>(count: usize) -> Vec<T> {
        vec![T::from_f64(0.0); count]
    }
    #[inline(always)]
    fn guess<T: Scalar>(numbers: &[T]) -> T {
        T::from_f64(3.0) * (numbers[0] - numbers[1]) + numbers[2]
    }
    #[inline(always)]
    fn note_position<T: Scalar>(numbers: &mut [T], lambda: T) {
        (numbers[2], numbers[1], numbers[0]) = (numbers[1], numbers[0], lambda);
    }
}
