//! The number formats for trajectories in lanes.

use crate::number::lanes::{Fused, Lane};

/// Double precision without compensated sums; the default. (In phase space sums are always compensated.)
///
/// Each step rounds the position. For coordinates near 1 this rounding is biased, since doubles above 1 are twice as
/// far apart as those below: on a unit sphere the energy grows by a relative 1e-17 in each step. [`Compensated`] has no
/// such drift.
#[doc(alias = "f64")]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Double;

/// Double precision, with positions and momenta as compensated sums, as a
/// [`Simulation`](crate::run::simulation::Simulation) keeps them: for runs of millions of steps.
#[doc(alias = "Kahan summation")]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Compensated;

/// Single precision, where seven digits are enough: half the memory, and a half to two thirds of the time.
///
/// tan, ∛, powers, log₂, log₁₀, erf and inverse functions are evaluated in double precision. Linked and
/// rigid bodies, bodies in phase space, and trajectories that do not go in lanes, are computed in double precision.
///
/// Where places and momenta keep close to one size, as on a unit sphere, their rounding has a bias: energies drift
/// there by some 5e-9 of themselves in a step, so by 0.5 % in a million steps. Each step adds h v to a place and rounds
/// the sum, by up to 6e-8 of the place. Shorter steps are therefore less exact: where the direction stays the same, the
/// way is wrong by up to 6e-8 |q|/(h |v|) of itself. For |q| = |v| = 1 and h = 1e-5 that is 0.6 %, and where h |v| is
/// less than 3e-8 |q| nothing moves. ([`Double`] has the same far from the origin: 1e-16 |q|/(h |v|).)
#[doc(alias = "f32")]
#[doc(alias = "float")]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Single;

/// The number format in lanes: [`Double`], [`Compensated`] or [`Single`].
pub trait Precision: Copy {
    /// The largest finite number.
    const MOST: f64;
    /// The shortest step, and stage of one, in lanes: products of what it moves by, however slow, keep clear of the
    /// smallest numbers.
    const SHORTEST: f64;

    /// Runs `work` with this number format.
    #[doc(hidden)]
    fn compute<W: InNumbers>(work: W) -> W::Done;
}

/// A computation that is generic in the number format of a [`Precision`].
#[doc(hidden)]
pub trait InNumbers {
    /// The result.
    type Done;
    /// Computes with numbers of type `S`; `SUMS` is 1 if positions and momenta are to be compensated sums, else 0.
    fn compute<S: Lane, const SUMS: usize>(self) -> Self::Done;
}

macro_rules! precision {
    ($($name:ident: $float:ident, $sums:literal, $shortest:literal;)*) => {$(
        impl Precision for $name {
            const MOST: f64 = $float::MAX as f64;
            const SHORTEST: f64 = $shortest;

            fn compute<W: InNumbers>(work: W) -> W::Done {
                work.compute::<Fused<$float>, $sums>()
            }
        }
    )*};
}
precision! {
    Double: f64, 0, 1e-100;
    Compensated: f64, 1, 1e-100;
    Single: f32, 0, 1e-15;
}
