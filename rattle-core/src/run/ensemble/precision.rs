//! The numbers that trajectories in lanes are computed with.

use crate::number::lanes::{Fused, Lane};

/// Double precision without compensated sums; the default.
///
/// Each step loses the rounding of the position. On coordinates near 1 that loss is biased, since doubles above 1 are
/// twice as far apart as those below: on a unit sphere the energy grows by 1e-17 of itself in each step.
/// [`Compensated`] has no such drift.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Double;

/// Double precision, with positions and momenta as compensated sums, as a
/// [`Simulation`](crate::run::simulation::Simulation) keeps them: for runs of millions of steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Compensated;

/// Single precision, where seven digits are enough: half the memory, and a half to two thirds of the time.
///
/// tan, ∛, powers, log₂, log₁₀, erf and inverse functions are evaluated in double precision. Linked bodies, and
/// trajectories that do not go in lanes, are computed in double precision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Single;

/// What numbers in lanes are: [`Double`], [`Compensated`] or [`Single`].
pub trait Precision: Copy {
    /// The largest finite number.
    const MOST: f64;

    /// Has work computed in these numbers.
    #[doc(hidden)]
    fn compute<W: InNumbers>(work: W) -> W::Done;
}

/// Work in the numbers of a [`Precision`].
#[doc(hidden)]
pub trait InNumbers {
    /// What comes of it.
    type Done;
    /// Does it in the numbers S; `SUMS` is 1 if positions and momenta are to be compensated sums, else 0.
    fn compute<S: Lane, const SUMS: usize>(self) -> Self::Done;
}

macro_rules! precision {
    ($($name:ident: $float:ident, $sums:literal;)*) => {$(
        impl Precision for $name {
            const MOST: f64 = $float::MAX as f64;

            fn compute<W: InNumbers>(work: W) -> W::Done {
                work.compute::<Fused<$float>, $sums>()
            }
        }
    )*};
}
precision! {
    Double: f64, 0;
    Compensated: f64, 1;
    Single: f32, 0;
}
