//! Errors of steps: why a method could not take its step, whatever it moves.

/// Why a method could not take its step, whatever it moves.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MethodFailure {
    /// The step density ρ of [variable steps](crate::methods::variable) is no longer near its target R.
    #[error(
        "steps have gone astray: their density is {ratio:.3} times what the momenta's change asks for, and must stay within 0.5 \
         and 1.5; try a longest step below {longest:.3e}"
    )]
    Astray {
        /// ρ/R.
        ratio: f64,
        /// The longest step ε.
        longest: f64,
    },
    /// The stages of a collocation method were not solved to rounding.
    #[error(
        "the {stages} stages of a step h = {h:.3e} did not converge: {}; try a smaller step, or another method where a light \
         body holds heavy ones or links nearly depend on each other", ended(*iterations, *left)
    )]
    StagesNotSolved {
        /// The step size.
        h: f64,
        /// The number of stages.
        stages: usize,
        /// Iterations made.
        iterations: usize,
        /// The last displacement, in units of the rounding of the position; NaN where it is no number.
        left: f64,
    },
    /// A step of a projected method (`Taylor`, `Dop853`) ended too far from the constraints to be projected onto them.
    #[error(
        "the step leads {distance:.3e} off the constraint, on a way of {path:.3e}, and cannot be brought back; try a smaller \
         step or tolerance"
    )]
    NotProjected {
        /// The distance, to first order.
        distance: f64,
        /// The path h|v|.
        path: f64,
    },
    /// The equations of an implicit step were not solved to rounding.
    #[error(
        "the equations of an implicit step h = {h:.3e} did not converge: {}; try a smaller step", ended(*iterations, *left)
    )]
    ImplicitNotSolved {
        /// The step size.
        h: f64,
        /// Iterations made.
        iterations: usize,
        /// The last displacement, in units of the rounding of the position.
        left: f64,
    },
    /// In a stage of an explicit method a force, a normal or λ is not finite.
    #[error(
        "a force, a normal or a multiplier is not finite at a stage of the step h = {h:.3e}, or, of a power series, has a \
         kink where it begins; try a smaller step"
    )]
    StageNotFinite {
        /// The step size.
        h: f64,
    },
    /// A step of `Taylor` or `Dop853` would need more than 10⁶ inner steps of a length that hardly changes.
    #[error(
        "a step h = {h:.3e} is divided into at most 10⁶ inner steps, and the tolerance {tolerance:.1e} needs inner steps \
         of {inner:.1e} at most; try a shorter h, and more steps, or a larger tolerance; where shorter ones fail as well, look \
         for a singular point nearby, or for a force that jumps (`if`, `abs`, a cut-off): `Taylor::adaptive` finds it"
    )]
    TooManyInnerSteps {
        /// The inner step that the tolerance needs.
        inner: f64,
        /// The step size.
        h: f64,
        /// The tolerance.
        tolerance: f64,
    },
    /// The inner steps needed for the tolerance have become too short.
    #[error(
        "inner steps of {inner:.1e} within h = {h:.3e} still have an error of {error:.1e}, more than the tolerance \
         {tolerance:.1e}; try a larger tolerance, and look for a singular point nearby, or for a force that jumps (`if`, `abs`, \
         a cut-off): `Taylor::adaptive` finds it"
    )]
    StepsCollapse {
        /// The inner step that failed.
        inner: f64,
        /// The step size.
        h: f64,
        /// Its estimated error; NaN if a stage was not finite.
        error: f64,
        /// The tolerance.
        tolerance: f64,
    },
    /// A Nosé–Hoover bath changes momenta by more than a thousand times within half a step.
    #[error(
        "the bath takes momenta times {factor:.1e} within half a step h = {h:.3e}, and cannot be followed so: it swings \
         within {time:.1e}, and the kinetic energy was {hot:.1e} times that of its temperature; try a smaller step or a \
         longer time, or start near the temperature (`scene.maxwell`)"
    )]
    BathTooFast {
        /// The factor of the momenta.
        factor: f64,
        /// The step size.
        h: f64,
        /// The period τ of the bath.
        time: f64,
        /// The kinetic energy before, divided by its mean at the temperature.
        hot: f64,
    },
    /// The energy jumped in a step of a method that does not follow the constraint on its way (`Taylor`, `Dop853`,
    /// `Bdf2`, `Lobatto`): the step has leapt across a place that it could not see, such as a singular point or an
    /// edge.
    #[error(
        "a step h = {h:.3e} takes the kinetic energy from {before:.3e} to {after:.3e}, where forces and constraints gave {given:.3e}: \
         it is too long for what is near; try a smaller step or a tolerance, and look for a singular point"
    )]
    EnergyJump {
        /// The step size.
        h: f64,
        /// The kinetic energy before.
        before: f64,
        /// The kinetic energy after.
        after: f64,
        /// What the potential energy lost, and the work of constraints and of potentials that change.
        given: f64,
    },
}

impl MethodFailure {
    /// Of a step h with this tolerance, of which an inner step has an error, and the one that is needed is too short.
    /// Where the step had not made longer ones before, at most `made`, its inner steps do not collapse: they are too
    /// many.
    #[cold]
    pub(crate) fn of_short_steps(
        [inner, needed]: [f64; 2],
        made: f64,
        error: f64,
        [h, tolerance]: [f64; 2],
    ) -> Self {
        if made <= COLLAPSE * inner.abs() && !error.is_nan() {
            Self::TooManyInnerSteps { inner: needed, h, tolerance }
        } else {
            Self::StepsCollapse { inner, h, error, tolerance }
        }
    }
}

/// Inner steps collapse where they are so many times shorter than one that the same step has made.
const COLLAPSE: f64 = 100.0;

/// How an iteration ended that did not converge.
fn ended(iterations: usize, left: f64) -> String {
    let plural = if iterations == 1 { "" } else { "s" };
    if left.is_finite() {
        format!("after {iterations} iteration{plural} positions still move by {left:.1e} roundings")
    } else {
        format!("after {iterations} iteration{plural} positions are far from the start, or no numbers")
    }
}
