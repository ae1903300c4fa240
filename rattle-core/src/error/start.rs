//! Errors of starts.

use crate::error::network::EquationAt;
use crate::error::numbers::{Digits, History, Short};
use crate::error::phase::PhaseMistake;

/// What is wrong with a start.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StartFailure {
    /// A coordinate or momentum component is NaN or infinite, or too large for single precision in an ensemble that has
    /// it.
    #[error(
        "{quantity}[{component}] is {value:e}; every component must be finite{}",
        if value.is_finite() { " in the precision of the ensemble" } else { "" }
    )]
    NotFinite {
        /// `position` or `momentum`.
        quantity: &'static str,
        /// Which component.
        component: usize,
        /// The offending number.
        value: f64,
    },
    /// The constraint function is NaN or infinite at the start.
    #[error(
        "at q = {position:?} the constraint is {} and its gradient {gradient:?}; both must be finite", Short(*.value)
    )]
    ConstraintNotFinite {
        /// g(q).
        value: f64,
        /// ∇g(q).
        gradient: Vec<f64>,
        /// q.
        position: Vec<f64>,
    },
    /// The start is not on the surface.
    #[error(
        "off the surface by {distance:.3e} (g = {value:.3e}), allowed {tolerance:.1e}; \
         `scene.project(state)` moves the start onto the surface"
    )]
    OffSurface {
        /// |g|/|∇g|, to first order the distance from the surface.
        distance: f64,
        /// The largest distance allowed.
        tolerance: f64,
        /// g(q).
        value: f64,
    },
    /// The momentum is not tangent to the surface.
    #[error(
        "momentum is not tangent: |∇g·p|/(|∇g||p|) = {sine:.3e}, allowed {tolerance:.1e}; {}",
        edge.map_or_else(
            || "`scene.project(state)` takes its normal part away".to_owned(),
            |argument| format!(
                "the start lies on an edge, where `{argument}` changes its sign, and the momentum leads over it: \
                 `scene.project(state)` puts the start on that of the two faces to which the momentum is more nearly \
                 tangent, by some roundings, and takes away what is normal to that face"
            )
        )
    )]
    NotTangent {
        /// Sine of the angle between p and the tangent plane.
        sine: f64,
        /// The largest sine allowed.
        tolerance: f64,
        /// Where the start lies on an edge over which the momentum leads: the term of the constraint's expression that
        /// changes its sign there.
        edge: Option<&'static str>,
    },
    /// An equation between linked bodies does not hold at the start.
    #[error(
        "{equation} is off by {distance:.3e} (g = {value:.3e}), allowed {tolerance:.1e}; `scene.project(state)` moves \
         the start onto the constraints"
    )]
    OffConstraint {
        /// Which equation.
        equation: Box<EquationAt>,
        /// |g|/|∇g|, to first order the distance.
        distance: f64,
        /// The largest distance allowed.
        tolerance: f64,
        /// g(q, t).
        value: f64,
    },
    /// The momenta violate an equation between linked bodies.
    #[error(
        "the momenta break {equation}: it would change at the rate {rate:.3e}, {sine:.3e} of |∇g||v|, allowed \
         {tolerance:.1e}; `scene.project(state)` makes them fit"
    )]
    NotAlong {
        /// Which equation.
        equation: Box<EquationAt>,
        /// ∇g·v + ∂g/∂t.
        rate: f64,
        /// The rate relative to |∇g||v| + |∂g/∂t|.
        sine: f64,
        /// The largest relative rate allowed.
        tolerance: f64,
    },
    /// A constraint whose gradient is zero wherever it holds, such as z² instead of z.
    #[error(
        "{equation} vanishes to second order: its gradient is {gradient:.1e} where it holds (singular point about \
         {distance:.1e} away); write a constraint whose gradient is not zero there, as z instead of z²"
    )]
    Vanishes {
        /// Which equation.
        equation: Box<EquationAt>,
        /// |∇g|.
        gradient: f64,
        /// To first order the distance to the point where ∇g = 0.
        distance: f64,
    },
    /// Equations that depend on each other, where elimination was asked for or too many equations are coupled.
    #[error(
        "{equation} depends on the others (sine of the angle between normals {sine:.1e}); leave it out{}",
        if equations <= most {
            format!(", or ask for `LinearAlgebra::Orthogonal`, of which a step costs the cube of the {equations} equations")
        } else if *most == 0 {
            ": where a multiplier acts on chosen coordinates, no equation may depend on others".into()
        } else {
            format!(
                ": of the {equations} equations that are tied together none may depend on others, as \
                 `LinearAlgebra::Orthogonal` serves up to {most}"
            )
        }
    )]
    Dependent {
        /// Which equation.
        equation: Box<EquationAt>,
        /// The sine of the angle between its normal and the span of the others.
        sine: f64,
        /// The number of coupled equations, including this one.
        equations: usize,
        /// The largest number for which `LinearAlgebra::Orthogonal` can be used; 0 where multipliers act on chosen
        /// coordinates.
        most: usize,
    },
    /// Equations that contradict each other near the start.
    #[error(
        "{equation} contradicts the others: near the start it stays off by {distance:.3e} where they hold; or they lie in \
         one line, and hold beside it: start beside it"
    )]
    Contradictory {
        /// Which equation.
        equation: Box<EquationAt>,
        /// The remaining |g|/|∇g|.
        distance: f64,
    },
    /// No place where linked bodies satisfy their equations was found near the start.
    #[error(
        "no place found where {equation} and the links with it hold: distances {distances} after {} Newton steps; start \
         nearer, or see whether the links can hold together at all",
        distances.len()
    )]
    NoPlace {
        /// The equation with the largest residual at the end.
        equation: Box<EquationAt>,
        /// The largest |g|/|∇g| before every Newton step.
        distances: History,
    },
    /// No momenta satisfy all velocity conditions: moving links contradict each other.
    #[error(
        "no momenta fit: {equation} would change at the rate {rate:.3e} where the others are kept; the links move apart"
    )]
    RatesContradict {
        /// Which equation.
        equation: Box<EquationAt>,
        /// The remaining G v + ∂g/∂t.
        rate: f64,
    },
    /// A link between pinned bodies does not hold, or moves.
    #[error(
        "{equation} joins pinned bodies alone, and {}; change the pins or the link",
        if *.moving { "moves".to_owned() } else { format!("is off by {distance:.3e}") }
    )]
    BetweenPins {
        /// Which equation.
        equation: Box<EquationAt>,
        /// |g|/|∇g|.
        distance: f64,
        /// Whether it changes with time.
        moving: bool,
    },
    /// The multiplier of an equation acts only on coordinates on which the equation does not depend here, or others act
    /// along the same; or rows would have to be exchanged, and `LinearAlgebra::Elimination` was asked for, which does
    /// not.
    #[error(
        "the multiplier of {equation} acts on coordinates along which g does not change here, or no otherwise than by \
         the multipliers of others (or asks for an exchange of rows, which `LinearAlgebra::Automatic` makes, `Elimination` \
         not)"
    )]
    CannotAct {
        /// Which equation.
        equation: Box<EquationAt>,
    },
    /// Nine numbers that are not a rotation matrix.
    #[error(
        "no attitude: QᵀQ is off from 1 by {deviation:.1e} (allowed 1e-10), det Q = {}; it must be a rotation; \
         `scene.project(state)` straightens what is nearly one",
        Digits(*.determinant, 3)
    )]
    NoAttitude {
        /// det Q.
        determinant: f64,
        /// The largest entry of QᵀQ − 1.
        deviation: f64,
    },
    /// The momenta of a rigid body are more than an angular momentum: only the first three may be nonzero.
    #[error(
        "momenta of a rigid body are its angular momentum and six zeros; see `Rigid::start`, and \
         `Rigid::angular_momentum_of_matrix` for momenta of a matrix"
    )]
    NoAngularMomentum,
    /// A pinned body starts at another position, or with a momentum.
    #[error(
        "the body is pinned at {at:?} and starts at {position:?} with momentum {momentum:?}; `scene.project(state)` puts it there"
    )]
    Pinned {
        /// Where it is pinned.
        at: Vec<f64>,
        /// Where it starts.
        position: Vec<f64>,
        /// Its momentum.
        momentum: Vec<f64>,
    },
    /// An error of a start in phase space.
    #[error(transparent)]
    Phase(PhaseMistake),
    /// The gradient is zero here, or so near that its direction is lost to rounding.
    #[error(
        "the gradient vanishes here (|∇g| = {gradient:.3e}, singular point about {distance:.1e} away); \
         start elsewhere, or write a constraint whose gradient is not zero on the surface"
    )]
    SingularPoint {
        /// |∇g(q)|.
        gradient: f64,
        /// |∇g|/|∇²g n| with n = ∇g/|∇g|, to first order the distance to the point where ∇g = 0.
        distance: f64,
    },
    /// The gradient is so long or so short that its square, or that over the masses, overflows or underflows.
    #[error(
        "the gradient of {} has the length {gradient:.1e}, and its square, or that over the masses, is beyond the \
         numbers; choose units in which lengths and masses are nearer to 1, or, if units are such, multiply the \
         constraint by about {:.0e}", equation.as_ref().map_or("the constraint".into(), ToString::to_string), 1.0 / gradient
    )]
    OutOfScale {
        /// Which equation, for linked bodies.
        equation: Option<Box<EquationAt>>,
        /// |∇g|.
        gradient: f64,
    },
    /// The force at the start is NaN or infinite.
    #[error("the force of `{effect}` is {force:?}; check the start against the potential's domain")]
    ForceNotFinite {
        /// The type of the effect.
        effect: &'static str,
        /// −∇U.
        force: Vec<f64>,
    },
    /// No point of the surface was found near the start.
    #[error(
        "no point of the surface found: distances {distances} after {} Newton steps; start nearer to the surface",
        distances.len()
    )]
    NoProjection {
        /// First-order distance from the surface before every Newton step.
        distances: History,
    },
}
