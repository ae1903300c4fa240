//! Lobatto IIIA–IIIB: symplectic, symmetric collocation of order 2s − 2 with s stages, for constrained motion.
//!
//! ```text
//! Qᵢ = q + h cᵢ M⁻¹p + h² Σⱼ aᵢⱼ M⁻¹(f(Qⱼ) + G(Qⱼ)ᵀλⱼ)      0 = g(Qᵢ),   i = 2 … s,   Q₁ = q
//! p′ = p + h Σⱼ bⱼ (f(Qⱼ) + G(Qⱼ)ᵀλⱼ)                        λₛ such that G(q′) M⁻¹p′ = 0,   q′ = Qₛ
//! ```
//!
//! aᵢⱼ is the product of the two matrices; with two stages this is RATTLE. On a surface a step may be a few times
//! as long as one of RATTLE. Errors of 1e-8 take one body 0.3 to 0.4 of the time of the best composition of RATTLE; a
//! gas takes less time for errors below 1e-8 alone. In lanes compositions of order 6 and 8 are as cheap, or cheaper, to
//! errors of 1e-12 (`docs/accuracy.md`).
//!
//! Source: L. Jay, SIAM J. Numer. Anal. 33 (1996) 368; E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical
//! Integration*, VII.1.4.

use crate::motion::capability::Collocation;
use crate::motion::failure::Failure;
use crate::motion::guess::{Extrapolated, FromState, Guess};
use crate::motion::method::{Method, View};
use crate::motion::need::{Steps, WithCollocation};
use crate::motion::parts::BodiesOf;
use crate::motion::system::System;
use crate::motion::table::Table;
use crate::motion::table::Tabulated;
use crate::motion::witness::Witness;
use crate::number::real::Scalar;

/// Lobatto IIIA–IIIB with `S` = 2 to 9 stages and a constant step size. Five stages, order 8, suit most uses.
///
/// ```
/// # use rattle::{Lobatto, Method};
/// assert_eq!(Lobatto::<5>::new(0.05).order(), 8);
/// ```
///
/// The iteration for the stages of linked bodies takes the normals of the start, and steps have to be short where they
/// do not stand for those of the stages: it contracts by the angle that normals turn in the step, times √(M/m) where
/// a body of mass m holds bodies of mass M, and divided by the sine of a link's normal to the others. Where it does not
/// contract, the step is an error; [`Taylor`](crate::methods::taylor::Taylor),
/// [`Dop853`](crate::methods::dop853::Dop853) and [`Rattle`](crate::methods::rattle::Rattle) do not care.
///
/// The iteration for the stages begins with the acceleration at the start (`G` = [`FromState`]), so a step is a pure
/// function of the state. With [`guess`](Self::guess) it begins with values extrapolated from the stages of the step
/// before. In the lanes of an [ensemble](crate::run::ensemble) it always begins so, whatever `G` is.
#[doc(alias = "high order")]
#[doc(alias = "implicit Runge-Kutta")]
#[doc(alias = "collocation")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lobatto<const S: usize, G = FromState> {
    h: f64,
    guess: G,
}

impl<const S: usize> Lobatto<S> {
    // The bound stands here, for only then the compiler tells a wrong number of stages in the words of `Tabulated`.
    /// The method with step size `h`, in the unit of time.
    #[doc(alias = "dt")]
    #[doc(alias = "timestep")]
    #[must_use]
    pub fn new(h: f64) -> Self
    where
        Table<S>: Tabulated,
    {
        Self { h, guess: FromState }
    }

    /// The same method, with its iteration begun from the polynomial through the stages of the step before: fewer
    /// iterations where steps are short, and the same motion to rounding. A state read from a simulation contains these
    /// stages.
    ///
    /// ```
    /// # use rattle::{guess::Extrapolated, Lobatto};
    /// let method = Lobatto::<5>::new(0.02).guess(Extrapolated);
    /// ```
    #[must_use]
    pub fn guess(self, guess: Extrapolated) -> Lobatto<S, Extrapolated> {
        Lobatto { h: self.h, guess }
    }
}

impl<const S: usize, G: Guess> Method for Lobatto<S, G>
where
    Table<S>: Tabulated,
{
    type Memory<T: Scalar> = G::Memory<T>;
    type Need = (Steps, WithCollocation);
    const FOLLOWS_ROOTS: bool = false;
    const COLLOCATES: usize = S;

    fn step_size(&self) -> f64 {
        self.h
    }
    fn order(&self) -> u32 {
        u32::try_from(2 * S - 2).unwrap_or(u32::MAX)
    }
    fn name(&self) -> &'static str {
        Table::<S>::NAME
    }
    fn with_step(&self, h: f64) -> Self {
        Self { h, ..*self }
    }
    fn is_symmetric(&self) -> bool {
        true
    }

    fn prepare<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        (_, collocation): View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
    ) {
        collocation.reserve(bodies, S);
    }
    fn memory<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        (system, _): View<'_, Self, T, Y, D>,
        bodies: &BodiesOf<Y, T, D>,
    ) -> G::Memory<T> {
        // Whether there was a step; f + Gᵀλ and λ of its stages.
        G::room(1 + S * (D * bodies.q.as_ref().len() + system.equations()))
    }

    #[inline(always)]
    fn step<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        (_, collocation): View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        memory: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        collocation.collocate(&Table::<S>::TABLE, self.h, bodies, memory, witness)
    }
}
