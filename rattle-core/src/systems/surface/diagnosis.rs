//! The reason why a step on a surface failed, determined afterwards, so that successful steps do not pay for it.

use crate::effect::list::Forces;
use crate::effect::moment::Moment;
use crate::error::{MethodFailure, StepFailure, SurfaceFailure};
use crate::motion::failure::{Failure, numbers};
use crate::number::real::Scalar;
use crate::number::vector::dot;
use crate::systems::surface::equation::Equation;
use crate::systems::surface::normal::Normal;
use crate::systems::surface::position::Departure;

/// Where a step failed; its methods find out why.
pub(crate) struct FailureAt {
    body: usize,
}

impl FailureAt {
    /// A failure of a body.
    #[cold]
    pub(crate) fn of(body: usize) -> Self {
        Self { body }
    }

    /// The stages of a collocation method did not converge.
    #[cold]
    pub(crate) fn unsolved(&self, h: f64, stages: usize, iterations: usize, left: f64) -> Failure {
        self.because(MethodFailure::StagesNotSolved { h, stages, iterations, left }.into())
    }

    /// Successive stages are on different sides of the surface.
    #[cold]
    pub(crate) fn turned_over(&self, h: f64, stages: usize) -> Failure {
        self.because(SurfaceFailure::StagesTurnOver { h, stages }.into())
    }

    /// The end of the step is too far from the constraint.
    #[cold]
    pub(crate) fn not_projected<T: Scalar, const D: usize>(
        &self,
        distance: T,
        path: &[T; D],
        q: &[T; D],
    ) -> Failure {
        let (distance, path) = (distance.to_f64(), dot(path, path).to_f64().sqrt());
        self.because(if distance.is_finite() {
            MethodFailure::NotProjected { distance, path }.into()
        } else {
            StepFailure::ConstraintNotFinite { position: numbers(q) }
        })
    }

    /// The square of the speed is multiplied by this, between normals that are so much
    /// [alike](crate::solve::root::alike).
    #[cold]
    pub(super) fn jumped<T: Scalar>(&self, h: f64, factor: T, alike: T) -> Failure {
        let (factor, angle) = (factor.to_f64().sqrt(), alike.to_f64().sqrt().acos().to_degrees());
        self.because(SurfaceFailure::SpeedJump { h, factor, angle }.into())
    }

    fn because(&self, cause: StepFailure) -> Failure {
        Failure { body: self.body, cause }
    }

    /// |∇g|, |v| and κ at the start of the step.
    fn curvature<T: Scalar, const D: usize>(&self, departure: &Departure<'_, T, D>) -> (f64, f64, f64) {
        let &Departure { p, bend, normal: Normal { gradient: n, .. }, .. } = departure;
        let gradient = dot(n, n).to_f64().sqrt();
        let speed = dot(p, p).to_f64().sqrt();
        let curvature = if speed == 0.0 { 0.0 } else { bend.to_f64().abs() / (gradient * speed * speed) };
        (gradient, speed, curvature)
    }

    #[inline(never)]
    pub(super) fn no_normal<T: Scalar, const D: usize>(
        &self,
        q: &[T; D],
        gradient: &[T; D],
    ) -> Option<Failure> {
        let (position, gradient) = (numbers(q), numbers(gradient));
        let square: f64 = gradient.iter().map(|n| n * n).sum();
        let none = !(square > 0.0 && square.is_finite());
        none.then(|| self.because(StepFailure::NoNormal { position, gradient }))
    }

    /// h·κ·|v| is not below 1.
    #[cold]
    #[inline(never)]
    pub(crate) fn too_long<T: Scalar, const D: usize>(&self, departure: &Departure<'_, T, D>) -> Failure {
        let h = departure.h;
        let (_, speed, curvature) = self.curvature(departure);
        let reach = h.abs() * curvature * speed;
        self.no_normal(departure.q, &departure.normal.gradient).unwrap_or_else(|| {
            self.because(if reach < 0.99 {
                SurfaceFailure::OutOfScale { reach, curvature, speed }.into() // a product that overflows is not below 1
            } else if reach.is_finite() {
                SurfaceFailure::StepTooLong { h, reach, curvature, speed, longest: h.abs() / reach }.into()
            } else {
                StepFailure::ConstraintNotFinite { position: numbers(departure.q) }
            })
        })
    }

    /// The position equation has no solution that can be used: solves it once more, taking notes.
    #[cold]
    #[inline(never)]
    pub(crate) fn lost<T: Scalar, const D: usize>(
        &self,
        equation: &dyn Equation<T, D>,
        departure: &Departure<'_, T, D>,
    ) -> Failure {
        let mut corrections = Vec::new();
        let landing = departure.solve(equation, |length| corrections.push(length.to_f64()));
        corrections.retain(|&length| length != 0.0); // second corrections that were not made
        let (gradient, speed, curvature) = self.curvature(departure);
        let reach = departure.h.abs() * curvature * speed;
        if corrections.iter().any(|length| !length.is_finite()) {
            let guess = departure.point(departure.guess);
            let (g, gradient) = equation.value_and_gradient(&guess);
            let singular = if g.to_f64().is_finite() { self.no_normal(&guess, &gradient) } else { None };
            let position = numbers(departure.q);
            return singular.unwrap_or_else(|| self.because(StepFailure::ConstraintNotFinite { position }));
        }
        let path = dot(&departure.free, &departure.free).to_f64().sqrt();
        if !landing.converged {
            return self.because(
                SurfaceFailure::NoConvergence {
                    path,
                    corrections: corrections.into_iter().collect(),
                    floor: landing.floor.to_f64(),
                    gradient,
                    reach,
                }
                .into(),
            );
        }
        let arrival = departure.point(landing.multiplier);
        if let Some(failure) = self.no_normal(&arrival, &landing.gradient) {
            return failure;
        }
        let after = dot(&landing.gradient, &landing.gradient).to_f64().sqrt();
        let cosine = dot(&landing.gradient, &departure.normal.gradient).to_f64() / (gradient * after);
        let correction = landing.multiplier.to_f64().abs() * gradient;
        self.because(SurfaceFailure::RootLost { cosine, correction, path, reach }.into())
    }

    /// The momentum is not finite: a force or a normal is not.
    #[cold]
    #[inline(never)]
    pub(crate) fn not_finite<T: Scalar, F: Forces<T, D>, const D: usize>(
        &self,
        effects: &F,
        at: Moment<'_, T, D>,
        normals: &[Normal<T, D>],
    ) -> Failure {
        let place = &at.positions[self.body];
        let position = numbers(place);
        if let Some(failure) = Failure::of_force(effects, at, [self.body]) {
            return failure;
        }
        self.no_normal(place, &normals[self.body].gradient)
            .unwrap_or_else(|| self.because(StepFailure::MomentumNotFinite { position }))
    }
}
