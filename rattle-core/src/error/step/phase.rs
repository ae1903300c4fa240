//! Errors of steps: why a step in phase space could not be taken.

use crate::error::numbers::History;

/// Why a step in phase space could not be taken.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PhaseFailure {
    /// In phase space, no point along the fibre was found that satisfies an equation.
    #[error(
        "no slide along the fibre satisfies equation {equation}: residuals in roundings {residuals} (h = {h:.3e}); try a \
         smaller step; if none helps, the motion ends here"
    )]
    NoSlide {
        /// Which, counted from 0.
        equation: usize,
        /// The largest residual before each correction, in units of the rounding of its terms; empty where the motion
        /// along the fibre would leave the domain of g, or go many times around.
        residuals: History,
        /// The step size: in a composition, that of the stage.
        h: f64,
    },
    /// In phase space, a point of g = 0 was found, but maybe not the one that continues the motion: followed from h =
    /// 0, the root ends or turns too sharply.
    #[error(
        "the motion can be followed through {share:.3} of this step only: what satisfies g = 0 at its end may be \
         another sheet (h = {h:.3e}); try a smaller step; if none helps, the motion ends here"
    )]
    SheetLost {
        /// The fraction of the step through which the motion was followed.
        share: f64,
        /// The step size: in a composition, that of the stage.
        h: f64,
    },
    /// In phase space, N = {g, {g, H}} changes so much within the step that the motion may reach a point where it is
    /// not determined, or come from one.
    #[error(
        "near here the constraint leaves the motion undetermined: {{g, {{g, H}}}} at the two ends of the step differs by \
         {change:.2} of the smaller one, allowed 1 (h = {h:.3e}); try a smaller step; where it is singular the motion ends"
    )]
    Undetermined {
        /// The largest entry of N⁻¹N′ − 1 and of N′⁻¹N − 1.
        change: f64,
        /// The step size: in a composition, that of the stage.
        h: f64,
    },
    /// In phase space, two equations commute where the motion was, and not where it is now: {gᵢ, gⱼ} ≠ 0. The slide to
    /// the hidden constraint leads off g = 0 there.
    #[error(
        "equations {first} and {second} are not coisotropic where the step leads: {{g{first}, g{second}}} = {bracket:.3e}, \
         {share:.1e} of its terms, must vanish wherever both hold (q = {position:?}, p = {momentum:?}, h = {h:.3e}); no \
         step is short enough; equations that do not commute take away a degree of freedom instead: solve one for a variable"
    )]
    NotCoisotropic {
        /// One.
        first: usize,
        /// The other.
        second: usize,
        /// {gᵢ, gⱼ}.
        bracket: f64,
        /// |{gᵢ, gⱼ}| relative to the sizes of its terms.
        share: f64,
        /// The position at the end of the step.
        position: Vec<f64>,
        /// The momentum there.
        momentum: Vec<f64>,
        /// The step size: in a composition, that of the stage.
        h: f64,
    },
    /// The Störmer–Verlet step of a Hamiltonian that is not separable was not solved, or may have been by another root
    /// than the one that comes from the state.
    #[error(
        "the step of H alone has no solution near q = {position:?}, or may have others (h = {h:.3e}); try a smaller step"
    )]
    ImplicitStep {
        /// The step size: in a composition, that of the stage.
        h: f64,
        /// The position at the start of the step.
        position: Vec<f64>,
    },
    /// In phase space, the Hamiltonian has no finite derivatives where the step ends.
    #[error(
        "the Hamiltonian has no finite derivatives near q = {position:?}, p = {momentum:?}; check its domain, or try a smaller step"
    )]
    HamiltonianNotFinite {
        /// The position at the start of the step.
        position: Vec<f64>,
        /// The momentum there.
        momentum: Vec<f64>,
    },
}
