//! What can go wrong, with the numbers that explain it.

use std::fmt;

/// Why a scene could not be set up or a step could not be taken.
///
/// Distances and residuals are in the unit of the coordinates. A failed step leaves the simulation
/// as it was before the step, bit for bit. `Debug` prints the same sentence as `Display`, because that is what a `main`
/// that returns this error shows.
#[derive(Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The step size is zero, infinite or NaN.
    #[error("the step size must be finite and not zero, found {0}")]
    StepSize(f64),

    /// The state has another number of bodies than the scene.
    #[error(
        "the scene has {scene} particle(s) and the state has {state}; see `Scene::particles` and `State::of`"
    )]
    BodyCount {
        /// Bodies of the scene.
        scene: usize,
        /// Bodies of the state.
        state: usize,
    },

    /// The time of variable steps is not positive, or not finite.
    #[error("the time tau within which steps change must be positive and finite, found {0}")]
    ChangeTime(f64),

    /// A method that is not symmetric, where one must be: in a composition, in variable steps, in a check of reversal.
    #[error(
        "{what} needs a symmetric method, and {method} is not symmetric: a step of −h does not undo one of h"
    )]
    NeedsSymmetricMethod {
        /// What needs one.
        what: &'static str,
        /// The method.
        method: &'static str,
    },

    /// A method was given a system that has not what it needs.
    #[error("{method} cannot move {system} yet; use `Rattle` or a composition of it")]
    CannotMove {
        /// The method.
        method: &'static str,
        /// The kind of system.
        system: &'static str,
    },

    /// A system is moved by RATTLE alone.
    #[error("{method} cannot move {system}; use `Rattle` or a composition of it")]
    NeedsRattle {
        /// The method.
        method: &'static str,
        /// The kind of system.
        system: &'static str,
    },

    /// The time of the start is NaN or infinite.
    #[error("the time of the start must be finite, found {0}")]
    Time(f64),

    /// A power series of fewer than two or more than 64 terms.
    #[error("the order of a Taylor method is 2 to 64, found {0}")]
    Order(u32),

    /// A tolerance that is not a positive number.
    #[error("a tolerance is a positive number, found {0}")]
    Tolerance(f64),

    /// Bins of a histogram that hold nothing.
    #[error("a histogram has one bin or more, between two finite numbers; found {bins} from {from} to {to}")]
    Bins {
        /// Where the first begins.
        from: f64,
        /// Where the last ends.
        to: f64,
        /// How many.
        bins: usize,
    },

    /// A composition whose coefficients do not add up to 1, or are not symmetric.
    #[error("the coefficients of {name} must be symmetric and add up to 1; their sum is {sum}")]
    Coefficients {
        /// Their name.
        name: &'static str,
        /// Σγ.
        sum: f64,
    },

    /// The state was given more momenta than it has bodies.
    #[error("the state has {bodies} bodies and was given {momenta} momenta")]
    MomentumCount {
        /// Bodies of the state.
        bodies: usize,
        /// Momenta given.
        momenta: usize,
    },

    /// A method for free bodies was given constraints.
    #[error(
        "{method} is for free bodies, and the scene has {equations} equation(s); `Shake` and `Rattle` are for constraints"
    )]
    NeedsFreeBodies {
        /// The method.
        method: &'static str,
        /// Equations of the scene.
        equations: usize,
    },

    /// Links, masses or pins that make no sense.
    #[error(transparent)]
    Network(NetworkMistake),

    /// A start that cannot be simulated.
    #[error("start of particle {body}: {cause}")]
    Start {
        /// Which body, counted from 0.
        body: usize,
        /// What is wrong with it.
        cause: StartFailure,
    },

    /// A start of an ensemble that cannot be simulated.
    #[error("trajectory {trajectory}: {error}")]
    Trajectory {
        /// Which trajectory, counted from 0.
        trajectory: usize,
        /// What is wrong with it.
        #[source]
        error: Box<Error>,
    },

    /// A step that cannot be taken.
    #[error("step {step} (t = {time}), particle {body}: {cause}")]
    Step {
        /// The step that failed; the first step is 1.
        step: u64,
        /// Time at which the failed step began.
        time: f64,
        /// Which body, counted from 0.
        body: usize,
        /// What stopped it.
        cause: StepFailure,
    },

    /// A step that cannot be taken, not even in parts: see [`Simulation::retry`](crate::run::simulation::Simulation::retry).
    #[error(
        "step {step} (t = {time}), particle {body}: halved {halvings} times, and its parts still fail: {cause}"
    )]
    Retried {
        /// Which step, counted from 1.
        step: u64,
        /// The time before it.
        time: f64,
        /// Which body, counted from 0, in the shortest parts.
        body: usize,
        /// How often the step was halved.
        halvings: u32,
        /// What stopped the shortest parts.
        cause: StepFailure,
    },

    /// A step that does not lead back: see [`Simulation::check_reversal`](crate::run::simulation::Simulation::check_reversal).
    #[error(
        "step {step} (t = {time}), particle {body}: {}; try a smaller step",
        missed(*off, *tolerance)
    )]
    NotReversed {
        /// Which step, counted from 1.
        step: u64,
        /// The time before it.
        time: f64,
        /// Which body, counted from 0.
        body: usize,
        /// By how much, relative to the largest coordinate or momentum; NaN if there is no way back.
        off: f64,
        /// What is allowed.
        tolerance: f64,
    },
}

impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// What is wrong with links, masses or pins.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NetworkMistake {
    /// A link or pin names a body that the scene does not have.
    #[error("{what} {member} names body {body}; the scene has {bodies}, counted from 0")]
    NoSuchBody {
        /// The type of the constraint, or `pin`.
        what: &'static str,
        /// Which of its members.
        member: usize,
        /// The body it names.
        body: usize,
        /// Bodies of the scene.
        bodies: usize,
    },
    /// A link names one body twice.
    #[error("{what} {member} names body {body} twice; a link is between different bodies")]
    Repeated {
        /// The type of the constraint.
        what: &'static str,
        /// Which of its members.
        member: usize,
        /// The body.
        body: usize,
    },
    /// As many masses as bodies are needed.
    #[error("{masses} masses were given for {bodies} bodies")]
    MassCount {
        /// Masses given.
        masses: usize,
        /// Bodies of the scene.
        bodies: usize,
    },
    /// A mass is not positive and finite, or a mass matrix not symmetric positive definite.
    #[error(
        "the mass of body {body} is not positive and finite, or its matrix not symmetric positive definite"
    )]
    Mass {
        /// Which body.
        body: usize,
    },
    /// Moments of inertia that no body has.
    #[error(
        "moments of inertia must be positive and finite, none larger than the sum of the others; found {moments:?}"
    )]
    Inertia {
        /// I₁, I₂, I₃.
        moments: [f64; 3],
    },
    /// Multipliers that act on chosen coordinates, between bodies whose mass couples coordinates.
    #[error("{what} acts on chosen coordinates; its bodies need masses that do not couple coordinates")]
    ActingNeedsDiagonalMass {
        /// The type of the constraint.
        what: &'static str,
    },
}

/// One equation of a network, as messages name it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EquationAt {
    /// The type of the constraint.
    pub link: &'static str,
    /// Which member of its list, counted from 0.
    pub member: usize,
    /// Which of the member's equations …
    pub equation: usize,
    /// … of so many.
    pub of: usize,
    /// The bodies that it ties together.
    pub bodies: Vec<usize>,
}

impl fmt::Display for EquationAt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.link, self.member)?;
        if self.of > 1 {
            write!(f, ", equation {}", self.equation)?;
        }
        f.write_str(if self.bodies.len() == 1 { " (body " } else { " (bodies " })?;
        for (i, body) in self.bodies.iter().enumerate() {
            write!(f, "{}{body}", if i == 0 { "" } else { ", " })?;
        }
        f.write_str(")")
    }
}

/// A step size that would pass where one failed, found by trying.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passing(pub Option<f64>);

impl fmt::Display for Passing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(h) => write!(f, "a step of {h:.3e} passes here"),
            None => f.write_str("no shorter step passes here either"),
        }
    }
}

/// What is wrong with a start in phase space. Equations are counted from 0, and compared with the sizes of their terms.
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
    /// The hidden constraint does not hold.
    #[error(
        "equation {equation} would not stay: {{g, H}} = {rate:.3e}, a slide by {share:.1e} of the coordinates off, allowed {tolerance:.1e}; \
         `scene.project(state)` slides the start to where it is zero"
    )]
    Hidden {
        /// Which.
        equation: usize,
        /// {g, H}.
        rate: f64,
        /// How far along the fibre it would hold, relative to the coordinates.
        share: f64,
        /// The largest share allowed.
        tolerance: f64,
    },
    /// Two equations do not commute.
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
    /// The motion is not determined.
    #[error("the motion is not determined here: {{g, {{g, H}}}} = {slopes:?} is singular; start elsewhere")]
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
        /// The largest residual before each correction, in roundings of its terms.
        residuals: History,
    },
}

/// What is wrong with a start.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StartFailure {
    /// A coordinate or momentum component is NaN or infinite.
    #[error("{quantity}[{component}] is {value}; every component must be finite")]
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
        "at q = {position:?} the constraint is {value} and its gradient {gradient:?}; both must be finite, and |∇g| below 1e154"
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
        "momentum is not tangent: |∇g·p|/(|∇g||p|) = {sine:.3e}, allowed {tolerance:.1e}; \
         `scene.project(state)` takes its normal part away"
    )]
    NotTangent {
        /// Sine of the angle between p and the tangent plane.
        sine: f64,
        /// The largest sine allowed.
        tolerance: f64,
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
    /// The momenta break an equation between linked bodies.
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
    /// A constraint whose gradient is zero wherever it holds, as z² instead of z.
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
    /// Equations that depend on each other, where elimination was asked for or the component is large.
    #[error(
        "{equation} depends on the others (sine of the angle between normals {sine:.1e}); leave it out, or ask for \
         `LinearAlgebra::Orthogonal`"
    )]
    Dependent {
        /// Which equation.
        equation: Box<EquationAt>,
        /// The sine of the angle of its normal to the span of the others.
        sine: f64,
    },
    /// Equations that cannot hold together near the start.
    #[error(
        "{equation} contradicts the others: near the start it stays off by {distance:.3e} where they hold"
    )]
    Contradictory {
        /// Which equation.
        equation: Box<EquationAt>,
        /// |g|/|∇g| that remains.
        distance: f64,
    },
    /// No place where linked bodies satisfy their equations was found near the start.
    #[error(
        "no place found where {equation} and the links with it hold: distances {distances} after {} Newton steps; start \
         nearer, or see whether the links can hold together at all",
        distances.len()
    )]
    NoPlace {
        /// The equation that was furthest off at last.
        equation: Box<EquationAt>,
        /// The largest |g|/|∇g| before every Newton step.
        distances: History,
    },
    /// No momenta satisfy all velocity conditions: links move apart.
    #[error(
        "no momenta fit: {equation} would change at the rate {rate:.3e} where the others are kept; the links move apart"
    )]
    RatesContradict {
        /// Which equation.
        equation: Box<EquationAt>,
        /// G v + ∂g/∂t that remains.
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
    /// The multiplier of an equation acts only on coordinates that do not change it here.
    #[error("the multiplier of {equation} acts on coordinates along which g does not change here")]
    CannotAct {
        /// Which equation.
        equation: Box<EquationAt>,
    },
    /// Nine numbers that are no attitude of a rigid body.
    #[error(
        "no attitude: QᵀQ is off from 1 by {deviation:.1e} (allowed 1e-10), det Q = {determinant:.3}; it must be a rotation; \
         `scene.project(state)` straightens what is nearly one"
    )]
    NoAttitude {
        /// det Q.
        determinant: f64,
        /// The largest entry of QᵀQ − 1.
        deviation: f64,
    },
    /// A rigid body's momenta are more than an angular momentum.
    #[error("momenta of a rigid body are its angular momentum and six zeros; see `Rigid::start`")]
    NoAngularMomentum,
    /// A pinned body is elsewhere, or moves.
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
    /// A start in phase space.
    #[error(transparent)]
    Phase(PhaseMistake),
    /// The gradient is zero here or so near that it has no direction in floating point.
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

/// What stopped a step.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StepFailure {
    /// h·κ·|v| > 1: the surface curves away within one step, so that the position equation has no
    /// solution that the motion could follow.
    #[error(
        "step too long for the curvature: h·κ·|v| = {reach:.3} must be below 1 (h = {h:.3e}, κ = {curvature:.4}, \
         |v| = {speed:.4}); that needs |h| < {longest:.3e} here, and accurate runs stay below a fifth of it"
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
        /// 1/(κ·|v|), which |h| must be below; the curvature on the way may ask for less.
        longest: f64,
    },
    /// The position equation was not solved to the rounding floor.
    #[error(
        "projection onto the surface did not converge on a path of {path:.1e}: corrections {corrections}, floor \
         {floor:.1e}, |∇g| = {gradient:.3e}, h·κ·|v| = {reach:.3}; try a smaller step"
    )]
    NoConvergence {
        /// How far the body would have moved without the constraint; far where a force is too strong for the step.
        path: f64,
        /// Length of every correction in turn.
        corrections: History,
        /// Corrections shorter than this count as converged.
        floor: f64,
        /// |∇g| at the start of the step.
        gradient: f64,
        /// h·κ·|v|.
        reach: f64,
    },
    /// The density of reversible variable steps is no longer near the one that is wanted.
    #[error(
        "steps have gone astray: their density is {ratio:.3} times what the momenta's change asks for, and must stay within 0.5 \
         and 1.5; try a longest step below {longest:.3e}"
    )]
    Astray {
        /// ρ/R.
        ratio: f64,
        /// The longest step, ε.
        longest: f64,
    },
    /// The position equation has a solution, but it cannot be told that the motion leads there: followed from h = 0,
    /// the root ends or turns too sharply.
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
    /// The position equations of linked bodies were not solved, or not on the root that the motion leads to.
    #[error(
        "{equation} cannot be kept on a path of {path:.1e}: residuals as lengths {residuals}, |∇g| = {gradient:.3e}, \
         h·|∇²g v|/|∇g| = {turn:.3} (accurate below about 0.2); {passing} (h = {h:.3e})"
    )]
    NotSolved {
        /// The equation that is furthest off.
        equation: Box<EquationAt>,
        /// The longest way of a body of the component without the constraints.
        path: f64,
        /// The largest |gᵢ|/|∇gᵢ| before each correction.
        residuals: History,
        /// |∇g| of the equation at the start of the step.
        gradient: f64,
        /// The largest relative change of a normal within the step, for a surface h·κ·|v|.
        turn: f64,
        /// The step size: in a composition, that of the stage.
        h: f64,
        /// What would pass.
        passing: Passing,
    },
    /// The stages of a collocation method were not solved to the rounding floor.
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
        /// The last displacement, in roundings of the position.
        left: f64,
    },
    /// A step without structure ended too far from the constraints to be brought back to them.
    #[error(
        "the step leads {distance:.3e} off the constraint, on a way of {path:.3e}, and cannot be brought back; try a smaller \
         step or tolerance"
    )]
    NotProjected {
        /// The distance, to first order.
        distance: f64,
        /// The way h|v|.
        path: f64,
    },
    /// The equations of an implicit step were not solved to the rounding floor.
    #[error(
        "the equations of an implicit step h = {h:.3e} did not converge: after {iterations} iterations positions still \
         move by {left:.1e} roundings; try a smaller step"
    )]
    ImplicitNotSolved {
        /// The step size.
        h: f64,
        /// Iterations made.
        iterations: usize,
        /// The last displacement, in roundings of the position.
        left: f64,
    },
    /// A stage of an explicit method came to where a force, a normal or λ is not finite.
    #[error(
        "a force, a normal or a multiplier is not finite at a stage of the step h = {h:.3e}, or, of a power series, has a \
         kink where it begins; try a smaller step"
    )]
    StageNotFinite {
        /// The step size.
        h: f64,
    },
    /// Inner steps that keep the tolerance have become too short.
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
    /// Normals of successive stages are turned over: the step jumps over a bend.
    #[error(
        "the surface turns over between two of the {stages} stages of a step h = {h:.3e}; try a smaller step"
    )]
    StagesTurnOver {
        /// The step size.
        h: f64,
        /// The number of stages.
        stages: usize,
    },
    /// The system has no power series.
    #[error("these bodies have no power series of their motion; use another method")]
    NoSeries,
    /// The system has no collocation.
    #[error("{system} cannot be moved by collocation yet; use `Rattle` or a composition of it")]
    NoCollocation {
        /// The kind of system.
        system: &'static str,
    },
    /// A rigid body turns so far within the step that no rotation fits.
    #[error(
        "the body turns too far within the step: h·|Ω| = {turn:.3} must stay below about 2; {passing} (h = {h:.3e})"
    )]
    TurnsTooFar {
        /// h·|Ω|.
        turn: f64,
        /// The step size: in a composition, that of the stage.
        h: f64,
        /// What would pass.
        passing: Passing,
    },
    /// In phase space, no slide along the fibre was found that satisfies an equation.
    #[error(
        "no slide along the fibre satisfies equation {equation}: residuals in roundings {residuals} (h = {h:.3e}); try a \
         smaller step; if none helps, the motion ends here"
    )]
    NoSlide {
        /// Which, counted from 0.
        equation: usize,
        /// The largest residual before each correction, in roundings of its terms; none where a slide would lead out of the
        /// domain of g, or many times around.
        residuals: History,
        /// The step size: in a composition, that of the stage.
        h: f64,
    },
    /// In phase space, {g, {g, H}} changes so much within the step that the motion may come to where it is not determined.
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
    /// Normals that were independent at the start are no longer.
    #[error(
        "{equation} has come to depend on the others: the sine of the angle between normals is {sine:.1e}; the \
         mechanism branches here, or an equation is too many (`LinearAlgebra::Orthogonal` bears small angles)"
    )]
    RankLost {
        /// Which equation.
        equation: Box<EquationAt>,
        /// The sine of the angle of its normal to the span of the others.
        sine: f64,
    },
    /// Dependent equations that no longer agree.
    #[error("{equation} contradicts the others: residuals as lengths {residuals} remain where they hold")]
    Contradictory {
        /// Which equation.
        equation: Box<EquationAt>,
        /// The largest |gᵢ|/|∇gᵢ| before each correction.
        residuals: History,
    },
    /// The multiplier of an equation acts on chosen coordinates only, and these no longer change it.
    #[error(
        "the multiplier of {equation} can no longer hold it: the coordinates that it acts on have a share of {share:.1e} \
         in its gradient; let it act on the others too"
    )]
    CannotAct {
        /// Which equation.
        equation: Box<EquationAt>,
        /// Length of the gradient along these coordinates, relative to all of it.
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
    /// The momentum is beyond what can be squared, about 1e154.
    #[error("the momentum is no longer finite at q = {position:?}; try a smaller step, or other units")]
    MomentumNotFinite {
        /// Where.
        position: Vec<f64>,
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

/// Numbers in turn; the first eight are printed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct History(Vec<f64>);

impl History {
    /// The numbers, first one first.
    #[must_use]
    pub fn as_slice(&self) -> &[f64] {
        &self.0
    }
    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.0.len()
    }
    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl FromIterator<f64> for History {
    fn from_iter<I: IntoIterator<Item = f64>>(numbers: I) -> Self {
        Self(numbers.into_iter().collect())
    }
}

impl fmt::Display for History {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("[")?;
        for (i, x) in self.0.iter().take(8).enumerate() {
            write!(f, "{}{x:.1e}", if i == 0 { "" } else { ", " })?;
        }
        f.write_str(if self.0.len() > 8 { ", …]" } else { "]" })
    }
}

/// How a step that was taken back went wrong; by NaN if it could not be.
fn missed(off: f64, tolerance: f64) -> String {
    if off.is_nan() {
        return "it cannot be taken back".into();
    }
    format!("taken back it misses where it came from by {off:.1e}, and {tolerance:.1e} is allowed")
}
