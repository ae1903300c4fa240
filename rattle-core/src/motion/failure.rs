//! Why a step failed.

use crate::effect::force::Force;
use crate::effect::list::Forces;
use crate::effect::moment::Moment;
use crate::error::{EffectFailure, EquationAt, StepFailure, SurfaceFailure};
use crate::kernel::kinks::Kink;
use crate::number::real::Scalar;
use crate::number::vector::dot;

/// Why a step failed, and for which body.
#[derive(Debug, Clone, PartialEq)]
pub struct Failure {
    /// Which body, counted from 0.
    pub body: usize,
    /// The reason.
    pub cause: StepFailure,
}

impl Failure {
    /// A normal jumps: that of the body's surface, or of an equation between bodies.
    #[cold]
    pub(crate) fn of_kink(kink: Kink, body: usize, equation: Option<Box<EquationAt>>) -> Self {
        let Kink { argument, share, place: position, angle, gap, .. } = kink;
        Self {
            body,
            cause: StepFailure::Kink { argument, equation, position, share, angle, gap, along: false },
        }
    }

    /// Whether a kink on the way can be the reason: not where the reason is known.
    pub(crate) fn may_be_of_a_kink(&self) -> bool {
        !matches!(
            self.cause,
            StepFailure::Surface(SurfaceFailure::StepTooLong { .. } | SurfaceFailure::OutOfScale { .. })
                | StepFailure::Rests { .. }
                | StepFailure::TooManyImpacts { .. }
                | StepFailure::NoWayApart { .. }
        )
    }

    /// The same, told of a whole step: it is that of a `part` of it, which began after the share `from`.
    #[cold]
    pub(crate) fn of_part(mut self, from: f64, part: f64) -> Self {
        if let StepFailure::Kink { share, .. } = &mut self.cause {
            *share = from + part * *share;
        }
        self
    }

    /// Looks whether the forces on these bodies are numbers.
    pub(crate) fn unless_finite<T: Scalar, F: Forces<T, D>, const D: usize>(
        effects: &F,
        at: Moment<'_, T, D>,
        forces: &[F::Force],
        bodies: impl IntoIterator<Item = usize>,
    ) -> Result<(), Self> {
        for body in bodies {
            let force = forces[body].components();
            let finite = dot(&force, &force).le(T::from_f64(f64::MAX));
            if !finite && let Some(failure) = Self::of_force(effects, at, [body]) {
                return Err(failure);
            }
        }
        Ok(())
    }

    /// The force on the first of these bodies where it is not finite; none if all forces are.
    #[cold]
    pub(crate) fn of_force<T: Scalar, F: Forces<T, D>, const D: usize>(
        effects: &F,
        at: Moment<'_, T, D>,
        bodies: impl IntoIterator<Item = usize>,
    ) -> Option<Self> {
        for body in bodies {
            if let Some((effect, force)) = effects.culprit(at, body) {
                let (force, position) = (numbers(&force), numbers(&at.positions[body]));
                return Some(Self {
                    body,
                    cause: EffectFailure::ForceNotFinite { effect, force, position }.into(),
                });
            }
        }
        None
    }
}

/// As `f64`.
#[inline(never)]
pub(crate) fn numbers<T: Scalar>(x: &[T]) -> Vec<f64> {
    x.iter().map(|&x| x.to_f64()).collect()
}
