//! Errors of steps: why linked bodies could not be moved.

use crate::error::network::EquationAt;
use crate::error::numbers::{History, Passing};

/// Why linked bodies could not be moved.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LinkedFailure {
    /// The position equations of linked bodies were not solved, or not at the root that continues the motion.
    #[error(
        "{equation} cannot be kept on a path of {path:.1e}: residuals as lengths {residuals}, |∇g| = {gradient:.3e}, \
         h·|∇²g v|/|∇g| = {turn:.3} (accurate below about 0.2); {passing} (h = {h:.3e})"
    )]
    NotSolved {
        /// The equation with the largest residual.
        equation: Box<EquationAt>,
        /// The longest path of a body of the connected component without constraints.
        path: f64,
        /// The largest |gᵢ|/|∇gᵢ| before each correction.
        residuals: History,
        /// |∇g| of the equation at the start of the step.
        gradient: f64,
        /// The largest relative change of a normal within the step; on a surface, h·κ·|v|.
        turn: f64,
        /// The step size: in a composition, that of the stage.
        h: f64,
        /// A step size that would work.
        passing: Passing,
    },
    /// Normals that were independent at the start have become dependent.
    #[error(
        "{equation} has come to depend on the others: the sine of the angle between normals is {sine:.1e}; the \
         mechanism branches here, or an equation is too many{}{}", bears(*orthogonal), passes(*passing)
    )]
    RankLost {
        /// Which equation.
        equation: Box<EquationAt>,
        /// The sine of the angle of its normal to the span of the others.
        sine: f64,
        /// A step size that works here, if one was found.
        passing: Option<f64>,
        /// Whether an orthonormal basis of the normals is at work, as by `LinearAlgebra::Orthogonal`.
        orthogonal: bool,
    },
    /// Dependent equations that contradict each other now.
    #[error("{equation} contradicts the others: residuals as lengths {residuals} remain where they hold")]
    Contradictory {
        /// Which equation.
        equation: Box<EquationAt>,
        /// The largest |gᵢ|/|∇gᵢ| before each correction.
        residuals: History,
    },
    /// The stages of a collocation method rest, and an equation does not hold at the end of the step.
    #[error(
        "{equation} is off by {distance:.1e} at the end of a step h = {h:.3e}, {roundings:.1e} roundings, though its stages \
         have converged; try a smaller step"
    )]
    LeftOff {
        /// Which equation.
        equation: Box<EquationAt>,
        /// |g|/|∇g|.
        distance: f64,
        /// The same in roundings of the coordinates that linked bodies have.
        roundings: f64,
        /// The step size.
        h: f64,
    },
    /// The multiplier of an equation acts on chosen coordinates only, on which the equation no longer depends.
    #[error(
        "the multiplier of {equation} can no longer hold it: the coordinates that it acts on have a share of {share:.1e} \
         in its gradient; let it act on the others too"
    )]
    CannotAct {
        /// Which equation.
        equation: Box<EquationAt>,
        /// The length of the gradient along these coordinates, relative to its whole length.
        share: f64,
    },
}

/// What bears smaller angles, where that is not at work.
fn bears(orthogonal: bool) -> &'static str {
    if orthogonal { "" } else { " (`LinearAlgebra::Orthogonal` bears small angles, of up to 1000 equations)" }
}

/// A step that works, if one is known.
fn passes(passing: Option<f64>) -> String {
    passing.map_or_else(String::new, |h| format!("; {}", Passing(Some(h))))
}
