//! Errors of steps: what can happen to bodies of any kind, and a type for each system, for methods and for effects.

mod effect;
mod linked;
mod method;
mod phase;
mod rigid;
mod surface;

pub use effect::EffectFailure;
pub use linked::LinkedFailure;
pub use method::MethodFailure;
pub use phase::PhaseFailure;
pub use rigid::RigidFailure;
pub use surface::SurfaceFailure;

use crate::error::network::EquationAt;

/// Why a step could not be taken.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StepFailure {
    /// A body could not be moved on its surface.
    #[error(transparent)]
    Surface(#[from] SurfaceFailure),
    /// Linked bodies could not be moved.
    #[error(transparent)]
    Linked(#[from] LinkedFailure),
    /// A rigid body could not be turned.
    #[error(transparent)]
    Rigid(#[from] RigidFailure),
    /// A step in phase space could not be taken.
    #[error(transparent)]
    Phase(#[from] PhaseFailure),
    /// The method could not take its step, whatever it moves.
    #[error(transparent)]
    Method(#[from] MethodFailure),
    /// An effect could not act.
    #[error(transparent)]
    Effect(#[from] EffectFailure),
    /// The gradient of the constraint is zero, NaN or infinite at the new point.
    #[error(
        "the constraint has no normal at q = {position:?}: ∇g = {gradient:?}; the surface is singular there"
    )]
    NoNormal {
        /// Where.
        position: Vec<f64>,
        /// ∇g.
        gradient: Vec<f64>,
    },
    /// The momentum is NaN, infinite, or so large (about 1e154) that its square overflows.
    #[error("the momentum is no longer finite at q = {position:?}; try a smaller step, or other units")]
    MomentumNotFinite {
        /// Where.
        position: Vec<f64>,
    },
    /// A coordinate of a body is so large (about 1e154) that its square overflows.
    #[error("the body has run away to q = {position:?}; end the run before, or try other units")]
    RanAway {
        /// Where.
        position: Vec<f64>,
    },
    /// A step of a method that does not follow the root of the constraint has ended on another sheet close by.
    #[error(
        "a step h = {h:.3e} ends at q = {position:?}, {} the sheet that it began on; try a smaller step, or Rattle, which \
         follows its sheet",
        beside(*off)
    )]
    OtherSheet {
        /// The step size.
        h: f64,
        /// The distance from the sheet on which the motion continues; NaN where that was not found.
        off: f64,
        /// Where.
        position: Vec<f64>,
    },
    /// The normal of a constraint jumps on the way, and Newton's laws do not determine the momentum after it; see
    /// [`over_kinks`](crate::run::simulation::Simulation::over_kinks).
    #[error(
        "{} has a kink where `{argument}` changes its sign, after {share:.3} of the step at q = {position:?}: {}; a smooth form \
         has none, such as sqrt(x^2 + eps^2) for abs(x), go around it, or {}", constraint(equation.as_deref()), jumps(*angle, *gap), instead(*share, *along)
    )]
    Kink {
        /// The term of the constraint's expression that changes its sign.
        argument: &'static str,
        /// Which equation, for linked bodies.
        equation: Option<Box<EquationAt>>,
        /// The coordinates there; for a link, those of its bodies one after the other.
        position: Vec<f64>,
        /// The fraction of the step before the kink.
        share: f64,
        /// The angle by which the normal jumps.
        angle: f64,
        /// How far the surface jumps, to first order.
        gap: f64,
        /// Whether the momentum does not lead over it, and what the constraint adds does.
        along: bool,
    },
    /// A contact stays closed, or impacts that take energy away do not end within a step: bodies have come to rest on
    /// each other, or on a wall.
    #[error(
        "the contact `{contact}` of bodies {bodies:?} stays closed after {impacts} more impacts within the step (restitution {restitution}): what rests \
         there must be held by a link from here on, or be left out{}", unless_many(*impacts)
    )]
    Rests {
        /// The contact.
        contact: &'static str,
        /// Its bodies.
        bodies: Vec<usize>,
        /// Impacts so far within the step.
        impacts: u64,
        /// The restitution; where a step has as many impacts as it may have, the smallest of all of them.
        restitution: f64,
    },
    /// A step has more than 1000 impacts for each body, all of them elastic: nothing comes to rest.
    #[error(
        "the contact `{contact}` of bodies {bodies:?} closes once more after {impacts} impacts within the step, which may have \
         1000 for each body: try a shorter step"
    )]
    TooManyImpacts {
        /// The contact that closes once more.
        contact: &'static str,
        /// Its bodies.
        bodies: Vec<usize>,
        /// Impacts so far within the step.
        impacts: u64,
    },
    /// Constraints leave no momentum by which bodies could give way at a contact.
    #[error(
        "the contact `{contact}` of bodies {bodies:?} closes, and constraints leave them no way to part: let them move along \
         the gradient of the gap"
    )]
    NoWayApart {
        /// The contact.
        contact: &'static str,
        /// Its bodies.
        bodies: Vec<usize>,
    },
    /// The constraint function, or what follows from it, is NaN or infinite where the solver evaluated it.
    #[error(
        "the constraint is not a number near q = {position:?}; the step left the domain of its expression, or came to a point \
         without a normal"
    )]
    ConstraintNotFinite {
        /// The position at the start of the step.
        position: Vec<f64>,
    },
}

/// A constraint, as messages name it.
fn constraint(equation: Option<&EquationAt>) -> String {
    equation.map_or_else(|| "the constraint".to_owned(), EquationAt::to_string)
}

/// What else many impacts may mean than that bodies have come to rest.
fn unless_many(impacts: u64) -> &'static str {
    if impacts < 1000 {
        ""
    } else {
        "; where bodies do not rest yet, try a shorter step, which has fewer impacts"
    }
}

/// How far off a sheet, as far as that is known.
fn beside(off: f64) -> String {
    if off.is_nan() { "off".into() } else { format!("{off:.1e} beside") }
}

/// What can be done about a kink after this share of the step, along which the momentum may lead.
fn instead(share: f64, along: bool) -> &'static str {
    if along && share < AT_ONCE {
        "begin beside it, as the step begins along this edge; `over_kinks` takes a momentum over an edge, and none along it"
    } else {
        "let `over_kinks` take the momentum over the edge"
    }
}

/// A step begins on an edge that comes after less than this part of it: edges are found to 2⁻²⁰ of a way.
const AT_ONCE: f64 = 2e-6;

/// What jumps.
fn jumps(angle: f64, gap: f64) -> String {
    let normal = format!("its normal turns by {:.1}° at once", angle.to_degrees());
    if gap > angle { format!("{normal}, and the surface goes on {gap:.1e} away") } else { normal }
}
