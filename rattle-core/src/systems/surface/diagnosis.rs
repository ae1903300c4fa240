//! The reason why a step on a surface failed, determined afterwards, so that successful steps do not pay for it.

use crate::effect::list::Forces;
use crate::effect::moment::Moment;
use crate::error::{MethodFailure, StepFailure, SurfaceFailure};
use crate::motion::failure::{Failure, numbers};
use crate::number::real::{Mask, Real};
use crate::number::vector::dot;
use crate::systems::surface::equation::Equation;
use crate::systems::surface::normal::Normal;
use crate::systems::surface::position::Departure;

/// Where a step failed; its methods find out why.
pub(crate) struct FailureAt {
    body: usize,
    lane: usize,
}

impl FailureAt {
    /// A failure of `body` in the first lane where the condition does not hold.
    #[cold]
    pub(crate) fn of<M: Mask>(body: usize, holds: M) -> Self {
        Self { body, lane: holds.lanes().position(|held| !held).unwrap_or(0) }
    }

    fn number<T: Real>(&self, x: T) -> f64 {
        x.lanes().nth(self.lane).unwrap_or(f64::NAN)
    }

    fn numbers<T: Real, const D: usize>(&self, x: &[T; D]) -> Vec<f64> {
        numbers(x, self.lane)
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
    pub(crate) fn not_projected<T: Real, const D: usize>(
        &self,
        distance: T,
        path: &[T; D],
        q: &[T; D],
    ) -> Failure {
        let (distance, path) = (self.number(distance), self.number(dot(path, path)).sqrt());
        self.because(if distance.is_finite() {
            MethodFailure::NotProjected { distance, path }.into()
        } else {
            StepFailure::ConstraintNotFinite { position: self.numbers(q) }
        })
    }

    fn because(&self, cause: StepFailure) -> Failure {
        Failure { body: self.body, cause }
    }

    /// |∇g|, |v| and κ at the start of the step.
    fn curvature<T: Real, const D: usize>(&self, departure: &Departure<'_, T, D>) -> (f64, f64, f64) {
        let &Departure { p, bend, normal: Normal { gradient: n, .. }, .. } = departure;
        let gradient = self.number(dot(n, n)).sqrt();
        let speed = self.number(dot(p, p)).sqrt();
        let curvature = if speed == 0.0 { 0.0 } else { self.number(bend).abs() / (gradient * speed * speed) };
        (gradient, speed, curvature)
    }

    #[inline(never)]
    pub(super) fn no_normal<T: Real, const D: usize>(
        &self,
        q: &[T; D],
        gradient: &[T; D],
    ) -> Option<Failure> {
        let (position, gradient) = (self.numbers(q), self.numbers(gradient));
        let square: f64 = gradient.iter().map(|n| n * n).sum();
        let none = !(square > 0.0 && square.is_finite());
        none.then(|| self.because(StepFailure::NoNormal { position, gradient }))
    }

    /// h·κ·|v| is not below 1.
    #[cold]
    #[inline(never)]
    pub(crate) fn too_long<T: Real, const D: usize>(&self, departure: &Departure<'_, T, D>) -> Failure {
        let h = departure.h;
        let (_, speed, curvature) = self.curvature(departure);
        let reach = h.abs() * curvature * speed;
        self.no_normal(departure.q, &departure.normal.gradient).unwrap_or_else(|| {
            self.because(if reach < 0.99 {
                SurfaceFailure::OutOfScale { reach, curvature, speed }.into() // a product that overflows is not below 1
            } else if reach.is_finite() {
                SurfaceFailure::StepTooLong { h, reach, curvature, speed, longest: h.abs() / reach }.into()
            } else {
                StepFailure::ConstraintNotFinite { position: self.numbers(departure.q) }
            })
        })
    }

    /// The position equation has no solution that can be used: solves it once more, taking notes.
    #[cold]
    #[inline(never)]
    pub(crate) fn lost<T: Real, const D: usize>(
        &self,
        equation: &dyn Equation<T, D>,
        departure: &Departure<'_, T, D>,
    ) -> Failure {
        let mut corrections = Vec::new();
        let landing = departure.solve(equation, |length| corrections.push(self.number(length)));
        corrections.retain(|&length| length != 0.0); // second corrections that were not made
        let (gradient, speed, curvature) = self.curvature(departure);
        let reach = departure.h.abs() * curvature * speed;
        if corrections.iter().any(|length| !length.is_finite()) {
            let position = self.numbers(departure.q);
            return self.because(StepFailure::ConstraintNotFinite { position });
        }
        let path = self.number(dot(&departure.free, &departure.free)).sqrt();
        if !landing.converged.lanes().nth(self.lane).unwrap_or(false) {
            return self.because(
                SurfaceFailure::NoConvergence {
                    path,
                    corrections: corrections.into_iter().collect(),
                    floor: self.number(landing.floor),
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
        let after = self.number(dot(&landing.gradient, &landing.gradient)).sqrt();
        let cosine = self.number(dot(&landing.gradient, &departure.normal.gradient)) / (gradient * after);
        let correction = self.number(landing.multiplier).abs() * gradient;
        self.because(SurfaceFailure::RootLost { cosine, correction, path, reach }.into())
    }

    /// The momentum is not finite: a force or a normal is not.
    #[cold]
    #[inline(never)]
    pub(crate) fn not_finite<T: Real, F: Forces<T, D>, const D: usize>(
        &self,
        effects: &F,
        at: Moment<'_, T, D>,
        normals: &[Normal<T, D>],
    ) -> Failure {
        let place = &at.positions[self.body];
        let position = self.numbers(place);
        if let Some(failure) = Failure::of_force(effects, at, [self.body], self.lane) {
            return failure;
        }
        self.no_normal(place, &normals[self.body].gradient)
            .unwrap_or_else(|| self.because(StepFailure::MomentumNotFinite { position }))
    }
}
