//! g-BAOAB: a step of geodesic RATTLE with the thermostat in its middle (Leimkuhler, Matthews 2016).
//!
//! ```text
//! B   p ← p + h/2 f(q), tangent
//! A   n times: a step of RATTLE of size h/2n without force
//! O   the flows of momenta for a time h: friction and noise
//! A   n times: a step of RATTLE of size h/2n without force
//! B   p ← p + h/2 f(q), tangent
//! ```
//!
//! Averages over positions have errors that fall like h². Those of the splitting O B A B O, which
//! [`Rattle`](crate::methods::rattle::Rattle) makes with the same effects, are some three times as large in the table;
//! in a harmonic trap g-BAOAB has none. The table shows the measured error of the mean height of a body on a sphere of
//! radius 2 under gravity ½, at kT = ½ and γ = 1, where the exact mean is −1.0746
//! (`cargo test --release --test effects heat::table -- --ignored --nocapture`; the noise is 5e-4):
//!
//! | h | `Baoab::new(h)` | `Baoab::with_inner(4, h)` | `Rattle::new(h)` |
//! |---|---|---|---|
//! | 0.1 | −3e-4 | −4e-4 | 8e-4 |
//! | 0.2 | 1.5e-3 | 1.0e-3 | 4.3e-3 |
//! | 0.3 | 2.8e-3 | 1.6e-3 | 9.8e-3 |
//!
//! Averages over momenta are not as good: in a harmonic trap of frequency ω the momenta at the ends of steps have the
//! temperature kT (1 − h²ω²/4), whatever γ is, so that `temperature()` reads low under stiff forces. By O B A B O it is
//! kT there, and ⟨q²⟩ is too large by 1/(1 − h²ω²/4).
//!
//! Averages over positions say nothing of ways: where steps do not resolve the friction γ, bodies drift and diffuse x
//! coth x times as fast as they should, x = h γ/2 (1.08 at h γ = 1, 5 at 10), by `Rattle` too. Overdamped motion is
//! [`Brownian`](crate::methods::brownian::Brownian).
//!
//! Without flows of momenta it is a symmetric, symplectic method of second order. With random flows a step of −h does
//! not undo a step of h, so it cannot be composed.
//!
//! Source: B. Leimkuhler, C. Matthews, Proc. R. Soc. A 472 (2016) 20160138.

use crate::error::Error;
use crate::methods::fixed::{Fixed, MOST_INNER, Map, check_inner_steps};
use crate::motion::failure::Failure;
use crate::motion::method::{Splitting, Stage};
use crate::motion::parts::BodiesOf;
use crate::motion::stir;
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::real::Scalar;

/// g-BAOAB with a constant step size: kick, drift, thermostat, drift, kick.
///
/// ```
/// # use rattle::Baoab;
/// let method = Baoab::new(0.05);
/// let on_curved_surfaces = Baoab::with_inner(2, 0.05); // twice two free steps of 0.0125
/// ```
#[doc(alias = "Langevin")]
#[doc(alias = "thermostat")]
pub type Baoab = Fixed<KickDriftHeat>;

/// The map of [`Baoab`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KickDriftHeat {
    inner: u32,
}

impl Default for KickDriftHeat {
    fn default() -> Self {
        Self { inner: 1 }
    }
}

impl Baoab {
    /// The method with step size `h`, in the unit of time, and `inner` steps of free motion on either side of the
    /// middle of each step, 1 to 65 536.
    #[must_use]
    pub fn with_inner(inner: u32, h: f64) -> Self {
        Self::of(KickDriftHeat { inner }, h)
    }
}

impl Map for KickDriftHeat {
    const NAME: &'static str = "g-BAOAB";
    const ORDER: u32 = 2;
    const SYMMETRIC: bool = false;
    const STIRS: bool = true;
    const SPLITTING: Splitting = Splitting::Stages;
    const EVALUATIONS: Option<usize> = Some(1);

    fn stages(&self, h: f64) -> Vec<Stage> {
        let inner = self.inner.min(MOST_INNER); // more are refused before a run
        let (drifts, kick) = (2 * inner, |this: bool| if this { 0.5 * h } else { 0.0 });
        let stage = |number| Stage {
            before: kick(number == 0),
            h: h / f64::from(drifts),
            after: kick(number + 1 == drifts),
        };
        (0..drifts).map(stage).collect()
    }

    fn stirs_after(&self) -> usize {
        self.inner as usize
    }

    fn finer(&self, times: u32) -> Option<Self> {
        let inner = self.inner.checked_mul(times)?;
        (inner <= MOST_INNER).then_some(Self { inner })
    }

    fn check(&self, _: usize) -> Result<(), Error> {
        check_inner_steps(Self::NAME, self.inner)
    }

    #[inline(always)]
    fn map<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        h: f64,
        system: &Y,
        bodies: &mut BodiesOf<Y, T, D>,
        witness: &mut W,
    ) -> Result<(), Failure> {
        let inner = 0.5 * h / f64::from(self.inner);
        system.settle(0.5 * h, h, bodies, witness)?;
        for half in 0..2 {
            for _ in 0..self.inner {
                system.drift(0.0, inner, bodies, witness)?;
                system.settle(0.0, inner, bodies, witness)?;
            }
            if half == 0 {
                stir::in_the_middle(h, system, bodies)?;
            }
        }
        system.evaluate_forces(bodies);
        system.settle(0.5 * h, h, bodies, witness)
    }
}
