//! The force on one body: a vector, or in a scene without effects nothing at all.

use crate::number::real::Real;
use crate::number::vector::{add_scaled, dot};
use std::fmt::Debug;

/// The force on one body, or its absence.
pub trait Force<T: Real, const D: usize>: Copy + Debug + Send + Sync + 'static {
    /// Whether there can be a force.
    const ACTS: bool = true;

    /// No force.
    fn zero() -> Self;
    /// a + c f; `a` itself where forces are absent.
    fn add_to(&self, a: [T; D], c: T) -> [T; D];
    /// c f·n; zero where forces are absent.
    fn dot(&self, n: &[T; D], c: T) -> T;
    /// |c f|²; zero where forces are absent.
    fn square(&self, c: T) -> T;
    /// The components; zeros where forces are absent.
    fn components(&self) -> [T; D];
}

/// The force in a scene without effects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Absent;

impl<T: Real, const D: usize> Force<T, D> for Absent {
    const ACTS: bool = false;

    #[inline(always)]
    fn zero() -> Self {
        Self
    }
    #[inline(always)]
    fn add_to(&self, a: [T; D], _: T) -> [T; D] {
        a
    }
    #[inline(always)]
    fn dot(&self, _: &[T; D], _: T) -> T {
        T::from_f64(-0.0) // x + (−0) is x, bit for bit, also for the compiler
    }
    #[inline(always)]
    fn square(&self, _: T) -> T {
        T::from_f64(-0.0)
    }
    #[inline(always)]
    fn components(&self) -> [T; D] {
        [T::from_f64(0.0); D]
    }
}

impl<T: Real, const D: usize> Force<T, D> for [T; D] {
    #[inline(always)]
    fn zero() -> Self {
        [T::from_f64(-0.0); D]
    }
    #[inline(always)]
    fn add_to(&self, a: [T; D], c: T) -> [T; D] {
        add_scaled(&a, c, self)
    }
    #[inline(always)]
    fn dot(&self, n: &[T; D], c: T) -> T {
        c * dot(self, n)
    }
    #[inline(always)]
    fn square(&self, c: T) -> T {
        c * c * dot(self, self)
    }
    #[inline(always)]
    fn components(&self) -> [T; D] {
        *self
    }
}
