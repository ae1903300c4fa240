//! Errors of measuring the cost of accuracy.

use crate::error::numbers::Short;
use std::fmt;

/// Why the cost of accuracy could not be measured, or the accuracy not be reached.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PriceMistake {
    /// A duration, a budget or a wanted error that is not a positive number.
    #[error("the {what} must be positive and finite, found {}", Short(*.value))]
    NotPositive {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// The budget was spent before the reference motion was known.
    #[error(
        "a budget of {budget:.3e} s is too short for a reference in this scene; `.budget(seconds)` gives more"
    )]
    Late {
        /// The budget in seconds.
        budget: f64,
    },
    /// Trajectories of this scene do not go side by side by this method: an ensemble moves them one by one.
    #[error("trajectories go one by one here, and take as long as simulations")]
    OneByOne,
    /// Linked and rigid bodies, and those in phase space, are computed in double precision in lanes, whatever is asked
    /// for.
    #[error("linked and rigid bodies, and those in phase space, are computed in double precision")]
    AlwaysDouble,
    /// Random forces: another step size gives another path, so there is no error to measure.
    #[error(
        "random forces of `{effect}` make another path with every step size, and there is no error of one path to price"
    )]
    Random {
        /// The effect.
        effect: &'static str,
    },
    /// A start from which the simulation did not run.
    #[error(
        "{steps} steps from the start at t = {} end at t = {}, and it is t = {}: give a state of this simulation",
        Short(*.start), Short(*.end), Short(*.now)
    )]
    OtherStart {
        /// The time of the start.
        start: f64,
        /// Steps behind the present state, by what both count.
        steps: u64,
        /// The time at their end.
        end: f64,
        /// The present time.
        now: f64,
    },
    /// A start of the right time from which another motion began.
    #[error(
        "the same steps from this start end {} from the present positions: give a state of this simulation",
        Short(*.off)
    )]
    OtherMotion {
        /// The largest distance of a body from where it is.
        off: f64,
    },
    /// No method reaches the wanted error.
    #[error("an error of {wish:.1e} {what} cannot be had{}; {limit}", best_of(*.wish, *.best, .method))]
    Unreachable {
        /// The wanted error.
        wish: f64,
        /// The quantity: "in position", …
        what: String,
        /// The least error that was measured, on the whole duration, or on as much of it as can be told; NaN where none
        /// was.
        best: f64,
        /// The method of this error.
        method: String,
        /// What limits the accuracy.
        limit: Limit,
    },
}

/// A tolerance, as part of a sentence.
pub(super) fn with_tolerance(tolerance: Option<f64>) -> String {
    tolerance.map_or_else(String::new, |tolerance| format!(" and a tolerance of {}", Short(tolerance)))
}

/// The best that was measured, as part of a sentence. An error as small as was wished for is one of a shorter time.
fn best_of(wish: f64, best: f64, method: &str) -> String {
    if best > wish { format!(": the best is {best:.1e}, by {method}") } else { String::new() }
}

/// What limits accuracy.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Limit {
    /// The rounding of double precision: shorter steps are no more exact.
    Rounding,
    /// Chaos: close motions separate exponentially, so positions are not predictable for so long.
    Chaos {
        /// The time in which their distance grows by the factor e.
        lyapunov_time: f64,
        /// The time until which positions are predictable.
        predictable: f64,
    },
    /// The statistical uncertainty of an average over so short a time of chaotic motion.
    Statistics {
        /// The uncertainty of the average.
        uncertainty: f64,
    },
    /// Kinks of forces or constraints, at which methods of high order have a low order.
    Kink {
        /// The observed order of methods of order 8 and more.
        order: f64,
    },
    /// [Flows](crate::effect::Flow) of momenta, which act around a step: no method is of more than second order.
    Flows {
        /// The budget in seconds, in which no step short enough was measured.
        seconds: f64,
    },
    /// The budget: shorter steps would be more exact, but there was no time to measure them.
    Budget {
        /// The budget in seconds.
        seconds: f64,
    },
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rounding => {
                f.write_str("rounding of double precision stands in the way: try a shorter time")
            }
            Self::Chaos { lyapunov_time, predictable } => write!(
                f,
                "the motion is chaotic (Lyapunov time {lyapunov_time:.3}), and positions can be told until t = {predictable:.3} after the \
                 start: wish for an energy or an average"
            ),
            Self::Statistics { uncertainty } => write!(
                f,
                "the motion is chaotic, and an average over this time is uncertain by {uncertainty:.1e}: try a longer time"
            ),
            Self::Kink { order } => write!(
                f,
                "something is not smooth (methods of order 8 and more are of order {order:.1}): take a kink out, or try `over_kinks`"
            ),
            Self::Flows { seconds } => write!(
                f,
                "flows of momenta (drag, fields, `force!`) are of second order, whatever the method: take shorter steps of RATTLE, or more \
                 than the budget of {seconds:.1e} s to measure them, by `.budget(seconds)`"
            ),
            Self::Budget { seconds } => {
                write!(
                    f,
                    "a budget of {seconds:.1e} s had no time for shorter steps: `.budget(seconds)` gives more"
                )
            }
        }
    }
}
