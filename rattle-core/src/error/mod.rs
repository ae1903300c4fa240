//! Errors, with the numbers that explain them.

mod effect;
mod network;
mod numbers;
mod pairs;
mod phase;
mod price;
mod record;
mod sizes;
mod start;
mod step;

pub use effect::EffectMistake;
pub use network::{EquationAt, NetworkMistake};
pub use numbers::{History, Passing};
pub use pairs::PairMistake;
pub use phase::PhaseMistake;
pub use price::{Limit, PriceMistake};
pub use record::RecordMistake;
pub(crate) use sizes::expect_variables;
pub use start::StartFailure;
pub use step::{
    EffectFailure, LinkedFailure, MethodFailure, PhaseFailure, RigidFailure, StepFailure, SurfaceFailure,
};

use numbers::{Short, many};
use std::fmt;

/// Why a scene could not be set up or a step could not be taken.
///
/// Distances and residuals are in the unit of the coordinates. A failed step leaves the simulation as it was before the
/// step, bit for bit. `Debug` prints the same sentence as `Display`, since a `main` that returns this error shows it by
/// `Debug`.
#[derive(Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The step size is zero, infinite or NaN.
    #[error("the step size must be finite and not zero, found {}", Short(*.0))]
    StepSize(f64),

    /// The state has another number of bodies than the scene.
    #[error(
        "the scene has {} and the state has {state}; see `Scene::points`, `Scene::bodies` and `State::of`",
        many(*scene, "body", "bodies")
    )]
    BodyCount {
        /// Bodies of the scene.
        scene: usize,
        /// Bodies of the state.
        state: usize,
    },

    /// The time scale τ of [variable steps](crate::methods::variable) is not positive, or not finite.
    #[error("the time tau within which steps change must be positive and finite, found {}", Short(*.0))]
    ChangeTime(f64),

    /// A method that is not symmetric where it must be: in a composition, in variable steps, in a check of reversal.
    #[error(
        "{what} needs a symmetric method, and {method} is not symmetric: a step of −h does not undo one of h"
    )]
    NeedsSymmetricMethod {
        /// What needs a symmetric method.
        what: &'static str,
        /// The method.
        method: &'static str,
    },

    /// The method cannot move this kind of system.
    #[error(
        "{method} cannot move {system}; {} can, and compositions of those that are symmetric",
        listed(others)
    )]
    CannotMove {
        /// The method.
        method: &'static str,
        /// The kind of system.
        system: &'static str,
        /// Methods that can move it.
        others: Vec<&'static str>,
    },

    /// The time of the start is NaN or infinite.
    #[error("the time of the start must be finite, found {}", Short(*.0))]
    Time(f64),

    /// The time at which a run is to end is NaN or infinite.
    #[error("the time until which to run must be finite, found {}", Short(*.0))]
    EndTime(f64),

    /// A power series of fewer than two or more than 64 terms.
    #[error("the order of a Taylor method is 2 to 64, found {0}")]
    Order(u32),

    /// A step without inner steps, or with more than 65 536.
    #[error("a step of {method} has 1 to 65536 inner steps, found {inner}")]
    InnerSteps {
        /// The method.
        method: &'static str,
        /// How many were asked for.
        inner: u32,
    },

    /// An order that no [shadow energy](crate::run::watch::ShadowEnergy) has.
    #[error(
        "the order of a shadow energy is 2, 4, 6, 8, 10 or 12, found {0}; beyond that the rounding of positions dominates"
    )]
    ShadowOrder(usize),

    /// A tolerance that is not a positive number; or one of `Dop853` below 10⁻¹⁵⁰, where squares of errors are 0.
    #[error("a tolerance is a positive number, of `Dop853` at least 1e-150, found {}", Short(*.0))]
    Tolerance(f64),

    /// A histogram without bins, with an empty or infinite range, or with more bins than 2²⁷ or than there is memory
    /// for.
    #[error(
        "a histogram has one bin or more, up to 2²⁷ as memory allows, between two finite numbers; found {bins} from {} to {}",
        Short(*.from), Short(*.to)
    )]
    Bins {
        /// Where the first bin begins.
        from: f64,
        /// Where the last bin ends.
        to: f64,
        /// The number of bins.
        bins: usize,
    },

    /// A restitution that is not between 0 and 1.
    #[error("a restitution is a number from 0 to 1, found {}", Short(*.0))]
    Restitution(f64),

    /// A diameter that is not a positive number.
    #[error("a diameter is a positive number, found {}", Short(*.0))]
    Diameter(f64),

    /// Bodies overlap when contacts are added.
    #[error(
        "bodies {bodies:?} are beyond the contact `{contact}` by {:.1e} when it is named; start where its gap is positive", -gap
    )]
    Overlap {
        /// The contact.
        contact: &'static str,
        /// Its bodies.
        bodies: Vec<usize>,
        /// Its gap, negative.
        gap: f64,
    },

    /// Events (collisions, crossing of edges) with a method or system whose steps cannot be divided.
    #[error("{who} cannot be stopped at events: {why}; see `Simulation::collide`")]
    NoEvents {
        /// The method or the kind of system.
        who: &'static str,
        /// Why not.
        why: &'static str,
    },

    /// A composition whose coefficients do not add up to 1, are not symmetric, or of which one is 0.
    #[error(
        "the coefficients of {name} must be symmetric, add up to 1, and none be 0; their sum is {}",
        Short(*.sum)
    )]
    Coefficients {
        /// Their name.
        name: &'static str,
        /// Σγ.
        sum: f64,
    },

    /// The state was given more momenta than it has bodies, or fewer.
    #[error(
        "the state has {} and was given {}{}",
        many(*bodies, "body", "bodies"),
        if *momenta == bodies + 1 { "at least " } else { "" },
        many(*momenta, "momentum", "momenta")
    )]
    MomentumCount {
        /// Bodies of the state.
        bodies: usize,
        /// Momenta given; one more than bodies, where it is not known how many more there are.
        momenta: usize,
    },

    /// A method for free bodies was given constraints.
    #[error(
        "{method} is for free bodies, and the scene has {}; `Shake` and `Rattle` are for constraints",
        many(*equations, "equation", "equations")
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

    /// A parameter of a formula that is no number.
    #[error("`{formula}`: its parameter {parameter} is NaN")]
    NanParameter {
        /// The type that the macro wrote.
        formula: &'static str,
        /// The name of the parameter.
        parameter: &'static str,
    },
    /// An effect whose parameters make no sense.
    #[error("effect `{effect}`: {mistake}")]
    Effect {
        /// The type of the effect.
        effect: &'static str,
        /// What is wrong with it.
        mistake: EffectMistake,
    },
    /// The cost of accuracy could not be measured, or the accuracy cannot be reached.
    #[error(transparent)]
    Price(PriceMistake),
    /// Forces between pairs of bodies that make no sense.
    #[error(transparent)]
    Pairs(PairMistake),

    /// A start that cannot be simulated.
    #[error("start of body {body}: {cause}")]
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

    /// A run with which another was to be [compared](crate::run::simulation::Simulation::estimate_error), and which
    /// failed.
    #[error(
        "the comparison with steps of {}{} failed: {error}", Short(*.h), price::with_tolerance(*.tolerance)
    )]
    Comparison {
        /// The step size of the run that failed.
        h: f64,
        /// Its tolerance, if it has one.
        tolerance: Option<f64>,
        /// Why it failed.
        #[source]
        error: Box<Error>,
    },

    /// A checkpoint from which the run cannot continue.
    #[error(transparent)]
    Record(RecordMistake),

    /// Rows of a recorder that could not be written.
    #[error(
        "rows could not be kept, after {rows} that were handed on: {why}; the run is as it was at its last step"
    )]
    Recorder {
        /// The number of rows passed on before.
        rows: u64,
        /// The reason.
        why: String,
    },

    /// The error of a trajectory that failed before a checkpoint, as text.
    #[error("{0}")]
    Before(String),

    /// A step that cannot be taken.
    #[error("step {step} (t = {time:?}), body {body}: {cause}")]
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

    /// A step that cannot be taken even in parts: see [`Simulation::retry`](crate::run::simulation::Simulation::retry).
    #[error(
        "step {step} (t = {time:?}), body {body}: halved {halvings} times, and its parts still fail: {cause}"
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

    /// A step that is not reversible: see
    /// [`Simulation::check_reversal`](crate::run::simulation::Simulation::check_reversal).
    #[error(
        "step {step} (t = {time:?}), body {body}: {}; try a smaller step",
        missed(*off, *tolerance)
    )]
    NotReversed {
        /// Which step, counted from 1.
        step: u64,
        /// The time before it.
        time: f64,
        /// Which body, counted from 0.
        body: usize,
        /// The difference, relative to the largest coordinate or momentum; NaN if the step back failed.
        off: f64,
        /// The tolerance.
        tolerance: f64,
    },
}

impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// Refuses a formula one of whose parameters is NaN: that one.
pub(crate) fn refuse_nan(formula: &'static str, parameter: Option<&'static str>) -> Result<(), Error> {
    parameter.map_or(Ok(()), |parameter| Err(Error::NanParameter { formula, parameter }))
}

/// How a step that was taken back went wrong; by NaN if it could not be.
fn missed(off: f64, tolerance: f64) -> String {
    if off.is_nan() {
        return "it cannot be taken back".into();
    }
    format!("taken back it misses where it came from by {off:.1e}, and {tolerance:.1e} is allowed")
}

/// "`A`, `B` and `C`".
fn listed(names: &[&str]) -> String {
    match names {
        [] => "nothing".into(),
        [name] => format!("`{name}`"),
        [first @ .., last] => format!("`{}` and `{last}`", first.join("`, `")),
    }
}
