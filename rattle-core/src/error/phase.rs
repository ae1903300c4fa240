//! Errors of starts in phase space.

use crate::error::numbers::{History, Short};

/// What is wrong with a start in phase space. Equations are counted from 0; residuals are compared with the sizes of
/// their terms.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PhaseMistake {
    /// An equation does not hold.
    #[error(
        "equation {equation} is off: g = {value:.3e}, {share:.1e} of its terms, allowed {tolerance:.1e}; \
         `scene.project(state)` moves the start onto the constraint"
    )]
    Off {
        /// Which.
        equation: usize,
        /// g(q, p).
        value: f64,
        /// |g| relative to Σ|∂g/∂zₖ||zₖ|.
        share: f64,
        /// The largest share allowed.
        tolerance: f64,
    },
    /// The Hamiltonian or its gradient is NaN or infinite.
    #[error(
        "the Hamiltonian is {} here, its gradient {gradient:?}; both must be finite: check its domain", Short(*.value)
    )]
    HamiltonianNotFinite {
        /// H(q, p).
        value: f64,
        /// ∂H/∂q, then ∂H/∂p.
        gradient: Vec<f64>,
    },
    /// The hidden constraint {g, H} = 0 does not hold.
    #[error(
        "equation {equation} would not stay: {{g, H}} = {rate:.3e}, a slide by {share:.1e} of the coordinates off, allowed {tolerance:.1e}; \
         `scene.project(state)` slides the start to where it is zero"
    )]
    Hidden {
        /// Which.
        equation: usize,
        /// {g, H}.
        rate: f64,
        /// The distance along the fibre to a point where it holds, relative to the largest of the coordinates that it
        /// depends on.
        share: f64,
        /// The largest share allowed.
        tolerance: f64,
    },
    /// Two equations do not commute: {gᵢ, gⱼ} ≠ 0.
    #[error(
        "equations {first} and {second} are not coisotropic: {{g{first}, g{second}}} = {bracket:.3e}, {share:.1e} of its terms, \
         must vanish where both hold; equations that do not commute take away a degree of freedom instead: solve one for a variable"
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
    },
    /// The gradients of the equations depend on each other: an equation repeats others, or has no gradient.
    #[error("{}", dependent(*equation, *part))]
    Dependent {
        /// The first equation whose gradient is made of those before it.
        equation: usize,
        /// The part of its gradient that is not made of those before it; NaN where it has no gradient.
        part: f64,
    },
    /// The motion is not determined: the matrix N = {g, {g, H}} is singular.
    #[error(
        "the motion is not determined here: {{g, {{g, H}}}} = {slopes:?} is singular; start elsewhere; \
         where it is singular everywhere, H needs a term that changes along the fibres of g"
    )]
    Undetermined {
        /// Nᵢⱼ, row by row.
        slopes: Vec<f64>,
    },
    /// No point of the fibre satisfies the hidden constraint.
    #[error(
        "no point of the fibre with {{g, H}} = 0 was found for equation {equation}: residuals in roundings {residuals}; \
         start nearer to one"
    )]
    NoSlide {
        /// Which.
        equation: usize,
        /// The largest residual before each correction, in units of the rounding of its terms.
        residuals: History,
    },
}

/// Which gradients depend on each other.
fn dependent(equation: usize, part: f64) -> String {
    if part.is_nan() {
        return format!(
            "equation {equation} has no gradient here: start elsewhere; or if it has none anywhere, as a square, \
             constrain what is squared"
        );
    }
    format!(
        "the gradients of the equations depend on each other here: that of equation {equation} is made of those of \
         equations before it but for {part:.1e} of itself; leave out an equation that repeats others, or start where \
         gradients are independent"
    )
}
