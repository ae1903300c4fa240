//! Where the iteration for the multipliers begins, and what has to be remembered for that.
//!
//! The solution does not depend on it but in the last bits; the number of evaluations does.

use crate::real::Real;
use std::fmt::Debug;

/// A first guess of multipliers.
pub trait Guess: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// What is remembered from step to step.
    type Memory<T: Real>: AsRef<[T]> + AsMut<[T]> + Default + Clone + Debug + Send + Sync;

    /// Room for so many numbers, all 0; none where nothing is remembered.
    fn numbers<T: Real>(count: usize) -> Self::Memory<T>;
}

/// From g̈ = 0 at the start of the step: a step is a pure function of the state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FromState;

/// From what the last steps lead to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Extrapolated;

impl Guess for FromState {
    type Memory<T: Real> = [T; 0];
    fn numbers<T: Real>(_: usize) -> [T; 0] {
        []
    }
}

impl Guess for Extrapolated {
    type Memory<T: Real> = Vec<T>;
    fn numbers<T: Real>(count: usize) -> Vec<T> {
        vec![T::from_f64(0.0); count]
    }
}
