//! Where the iteration for the multipliers begins, and what has to be remembered for that.
//!
//! The solution does not depend on it but in the last bits; the number of evaluations does. A guess that is off by more than
//! a hundredth of the path is not followed; the step is then that of [`FromState`].

use crate::number::real::Real;
use std::fmt::Debug;

/// A first guess of multipliers.
pub trait Guess: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// What is remembered from step to step.
    type Memory<T: Real>: AsRef<[T]> + AsMut<[T]> + Default + Clone + Debug + Send + Sync;
    /// So many steps, of one length if more than one, come before the first guess.
    const STEPS: f64;
    /// So many numbers are remembered of each equation of RATTLE.
    const NUMBERS: usize;

    /// Room for so many numbers, all 0; none where nothing is remembered.
    fn room<T: Real>(count: usize) -> Self::Memory<T>;
    /// λ of the step to come.
    fn guess<T: Real>(numbers: &[T]) -> T;
    /// Notes λ of the position equation of a step.
    fn note_position<T: Real>(_numbers: &mut [T], _lambda: T) {}
    /// Notes μ of the momentum equation of a step.
    fn note_momentum<T: Real>(_numbers: &mut [T], _mu: T) {}
}

/// From g̈ = 0 at the start of the step: a step is a pure function of the state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FromState;

/// μ of the last step, off by first order in h; needs no second derivative, and steps may differ in length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LastMultiplier;

/// From what the last steps lead to: RATTLE extends the parabola through its last three λ, 3λₙ − 3λₙ₋₁ + λₙ₋₂, Lobatto methods
/// the polynomial through the stages of the last step. Needs no second derivative either.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Extrapolated;

impl Guess for FromState {
    type Memory<T: Real> = [T; 0];
    const STEPS: f64 = 0.0;
    const NUMBERS: usize = 0;

    fn room<T: Real>(_: usize) -> [T; 0] {
        []
    }
    fn guess<T: Real>(_: &[T]) -> T {
        T::from_f64(0.0)
    }
}

impl Guess for LastMultiplier {
    type Memory<T: Real> = Vec<T>;
    const STEPS: f64 = 1.0;
    const NUMBERS: usize = 1;

    fn room<T: Real>(count: usize) -> Vec<T> {
        vec![T::from_f64(0.0); count]
    }
    #[inline(always)]
    fn guess<T: Real>(numbers: &[T]) -> T {
        numbers[0]
    }
    #[inline(always)]
    fn note_momentum<T: Real>(numbers: &mut [T], mu: T) {
        numbers[0] = mu;
    }
}

impl Guess for Extrapolated {
    type Memory<T: Real> = Vec<T>;
    const STEPS: f64 = 3.0;
    const NUMBERS: usize = 3;

    fn room<T: Real>(count: usize) -> Vec<T> {
        vec![T::from_f64(0.0); count]
    }
    #[inline(always)]
    fn guess<T: Real>(numbers: &[T]) -> T {
        T::from_f64(3.0) * (numbers[0] - numbers[1]) + numbers[2]
    }
    #[inline(always)]
    fn note_position<T: Real>(numbers: &mut [T], lambda: T) {
        (numbers[2], numbers[1], numbers[0]) = (numbers[1], numbers[0], lambda);
    }
}
