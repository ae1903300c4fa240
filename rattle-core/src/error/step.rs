//! Errors of steps.

use crate::error::network::EquationAt;
use crate::error::numbers::{Digits, History, Passing};

/// Why a step could not be taken.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StepFailure {
    /// h·κ·|v| > 1: the surface curves away within one step, so the position equation has no solution that continues
    /// the motion.
    #[error(
        "step too long for the curvature: h·κ·|v| = {} must be below 1 (h = {h:.3e}, κ = {}, \
         |v| = {}); that needs |h| < {longest:.3e} here, and accurate runs stay below a fifth of it",
        Digits(*reach, 3), Digits(*curvature, 4), Digits(*speed, 4)
    )]
    StepTooLong {
        /// The step size: in a composition, that of the stage.
        h: f64,
        /// h·κ·|v|.
        reach: f64,
        /// Normal curvature κ along v.
        curvature: f64,
        /// |v|.
        speed: f64,
        /// 1/(κ·|v|), an upper limit of |h|; the curvature on the way may require less.
        longest: f64,
    },
    /// h·κ·|v| is below 1, but numbers in its computation overflow or underflow.
    #[error(
        "products of curvature and speed are beyond the numbers: κ = {curvature:.1e}, |v| = {speed:.1e}, h·κ·|v| = {reach:.3}; \
         choose units in which lengths and speeds are nearer to 1"
    )]
    OutOfScale {
        /// h·κ·|v|.
        reach: f64,
        /// Normal curvature κ along v.
        curvature: f64,
        /// |v|.
        speed: f64,
    },
    /// The position equation was not solved to rounding.
    #[error(
        "projection onto the surface did not converge on a path of {path:.1e}: corrections {corrections}, floor \
         {floor:.1e}, |∇g| = {gradient:.3e}, h·κ·|v| = {reach:.3}; try a smaller step"
    )]
    NoConvergence {
        /// How far the body would have moved without the constraint. It is large where a force is too strong for the
        /// step.
        path: f64,
        /// The lengths of the corrections, in order.
        corrections: History,
        /// Corrections shorter than this count as converged.
        floor: f64,
        /// |∇g| at the start of the step.
        gradient: f64,
        /// h·κ·|v|.
        reach: f64,
    },
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
    /// The position equation has a solution, but maybe not the one that continues the motion: followed from h = 0, the
    /// root ends or turns too sharply.
    #[error(
        "the motion cannot be followed through this step: the solution found would move {correction:.3e} along the \
         normal on a path of {path:.3e}, normals at cosine {cosine:.3}, h·κ·|v| = {reach:.3}; try a smaller step"
    )]
    RootLost {
        /// Cosine of the angle between ∇g before and after.
        cosine: f64,
        /// How far the constraint would have moved the body.
        correction: f64,
        /// How far the body would have moved without the constraint.
        path: f64,
        /// h·κ·|v|.
        reach: f64,
    },
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
    /// The stages of a collocation method were not solved to rounding.
    #[error(
        "the {stages} stages of a step h = {h:.3e} did not converge: after {iterations} iterations they still move by \
         {left:.1e} roundings; try a smaller step"
    )]
    StagesNotSolved {
        /// The step size.
        h: f64,
        /// The number of stages.
        stages: usize,
        /// Iterations made.
        iterations: usize,
        /// The last displacement, in units of the rounding of the position.
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
        "the equations of an implicit step h = {h:.3e} did not converge: after {iterations} iterations positions still \
         move by {left:.1e} roundings; try a smaller step"
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
    /// The inner steps needed for the tolerance have become too short.
    #[error(
        "inner steps of {inner:.1e} within h = {h:.3e} still have an error of {error:.1e}, more than the tolerance \
         {tolerance:.1e}; try a larger tolerance, and look for a singular point nearby"
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
    /// Normals of successive stages point in opposite directions: the step jumps over a bend.
    #[error(
        "the surface turns over between two of the {stages} stages of a step h = {h:.3e}; try a smaller step"
    )]
    StagesTurnOver {
        /// The step size.
        h: f64,
        /// The number of stages.
        stages: usize,
    },
    /// A rigid body turns so far within the step that no rotation fits.
    #[error(
        "the body turns too far within the step: h·|Ω| = {turn:.3}; below 1 there always is a rotation, above in some \
         directions; {passing} (h = {h:.3e})"
    )]
    TurnsTooFar {
        /// h·|Ω|.
        turn: f64,
        /// The step size: in a composition, that of the stage.
        h: f64,
        /// A step size that would work.
        passing: Passing,
    },
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
    /// not determined.
    #[error(
        "the constraint is about to leave the motion undetermined: {{g, {{g, H}}}} changes by {change:.2} of itself within \
         the step, allowed 0.5 (h = {h:.3e}); a smaller step comes nearer, and where it is singular the motion ends"
    )]
    Undetermined {
        /// The largest entry of N⁻¹N′ − 1.
        change: f64,
        /// The step size: in a composition, that of the stage.
        h: f64,
    },
    /// The Störmer–Verlet step of a Hamiltonian that is not separable was not solved.
    #[error("the step of H alone has no solution near q = {position:?} (h = {h:.3e}); try a smaller step")]
    ImplicitStep {
        /// The step size: in a composition, that of the stage.
        h: f64,
        /// The position at the start of the step.
        position: Vec<f64>,
    },
    /// Normals that were independent at the start have become dependent.
    #[error(
        "{equation} has come to depend on the others: the sine of the angle between normals is {sine:.1e}; the \
         mechanism branches here, or an equation is too many (`LinearAlgebra::Orthogonal` bears small angles, of up to 1000 equations)"
    )]
    RankLost {
        /// Which equation.
        equation: Box<EquationAt>,
        /// The sine of the angle of its normal to the span of the others.
        sine: f64,
    },
    /// Dependent equations that contradict each other now.
    #[error("{equation} contradicts the others: residuals as lengths {residuals} remain where they hold")]
    Contradictory {
        /// Which equation.
        equation: Box<EquationAt>,
        /// The largest |gᵢ|/|∇gᵢ| before each correction.
        residuals: History,
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
    /// A force is NaN or infinite.
    #[error(
        "the force of `{effect}` is {force:?} at q = {position:?}; check the potential's domain, or try a smaller step"
    )]
    ForceNotFinite {
        /// The type of the effect.
        effect: &'static str,
        /// −∇U.
        force: Vec<f64>,
        /// Where.
        position: Vec<f64>,
    },
    /// The implicit equation of a force that depends on velocities was not solved, or the force is not finite.
    #[error(
        "no change of the momentum by `{effect}` is found, in a time {h:.3e} from p = {momentum:?} at q = {position:?}: check where \
         the force is a number, and whether it jumps, or try a smaller step"
    )]
    FlowNotFound {
        /// The type of the effect.
        effect: &'static str,
        /// The time for which it acts.
        h: f64,
        /// The momentum before.
        momentum: Vec<f64>,
        /// Where.
        position: Vec<f64>,
    },
    /// A flow changes momenta by too much in one step: no constraint impulse was found that keeps them tangent.
    #[error(
        "the flow of `{effect}` for a time of {h:.3e} is not found together with the impulse of the constraints: it changes momenta by more than themselves; try a smaller step"
    )]
    FlowTooLong {
        /// The type of the effect.
        effect: &'static str,
        /// The time for which it acts.
        h: f64,
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
    /// A step of a method that does not follow the root of the constraint has ended on another sheet close by.
    #[error(
        "a step h = {h:.3e} ends at q = {position:?}, {off:.1e} beside the sheet that it began on; try a smaller step, or Rattle, \
         which follows its sheet"
    )]
    OtherSheet {
        /// The step size.
        h: f64,
        /// The distance from the sheet on which the motion continues.
        off: f64,
        /// Where.
        position: Vec<f64>,
    },
    /// The energy jumped in a step of a method without geometric structure (`Taylor`, `Dop853`, `Bdf2`): the step has
    /// leapt across a place that it could not see, such as a singular point.
    #[error(
        "a step h = {h:.3e} takes the kinetic energy from {before:.3e} to {after:.3e}, where forces and constraints gave {given:.3e}: \
         it is too long for what is near; try a smaller step or a tolerance, and look for a singular point"
    )]
    EnergyFromNowhere {
        /// The step size.
        h: f64,
        /// The kinetic energy before.
        before: f64,
        /// The kinetic energy after.
        after: f64,
        /// The energy given by the change of potential energy and the work of constraints.
        given: f64,
    },
    /// The normal of a constraint jumps on the way, and Newton's laws do not determine the momentum after it; see
    /// [`over_kinks`](crate::run::simulation::Simulation::over_kinks).
    #[error(
        "{} has a kink where `{argument}` changes its sign, after {share:.3} of the step at q = {position:?}: {}; a smooth form \
         has none, such as sqrt(x^2 + eps^2) for abs(x), go around it, or let \
         `over_kinks` take the momentum over the edge", constraint(equation.as_deref()), jumps(*angle, *gap)
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
    },
    /// Impacts within a step do not end: bodies have come to rest on each other, or on a wall.
    #[error(
        "the contact `{contact}` of bodies {bodies:?} stays closed after {impacts} more impacts within the step (restitution {restitution}): what rests \
         there must be held by a link from here on, or be left out"
    )]
    Rests {
        /// The contact.
        contact: &'static str,
        /// Its bodies.
        bodies: Vec<usize>,
        /// Impacts so far within the step.
        impacts: u64,
        /// The restitution.
        restitution: f64,
    },
    /// The constraint function is NaN or infinite where the solver evaluated it.
    #[error(
        "the constraint is not a number near q = {position:?}; the step left the domain of its expression"
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

/// What jumps.
fn jumps(angle: f64, gap: f64) -> String {
    let normal = format!("its normal turns by {:.1}° at once", angle.to_degrees());
    if gap > angle { format!("{normal}, and the surface goes on {gap:.1e} away") } else { normal }
}
