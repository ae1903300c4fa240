//! Prices of accuracy that cannot be told, and wishes that cannot be met.

use std::fmt;

/// Why accuracy could not be priced, or not be had.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PriceMistake {
    /// A duration, a budget or a wish that is not a positive number.
    #[error("the {what} must be positive and finite, found {value}")]
    NotPositive {
        /// Which number.
        what: &'static str,
        /// What it is.
        value: f64,
    },
    /// The budget is spent before there is a reference to compare with.
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
    /// Momenta that are pushed at random: another step is another path.
    #[error(
        "random forces of `{effect}` make another path with every step size, and there is no error of one path to price"
    )]
    Random {
        /// The effect.
        effect: &'static str,
    },
    /// No method is as exact as was wished.
    #[error("an error of {wish:.1e} {what} cannot be had: the best is {best:.1e}, by {method}; {limit}")]
    Unreachable {
        /// The wish.
        wish: f64,
        /// "in position", …
        what: String,
        /// The least error that was measured, on the whole duration.
        best: f64,
        /// By which method.
        method: String,
        /// What stands in the way.
        limit: Limit,
    },
}

/// What limits accuracy.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Limit {
    /// Shorter steps give nothing: double precision ends there.
    Rounding,
    /// Close motions part exponentially, so that positions cannot be told for so long.
    Chaos {
        /// The time in which their distance grows by e.
        lyapunov_time: f64,
        /// Until when positions can be told.
        predictable: f64,
    },
    /// An average over so short a time is not more certain, as the motion is chaotic.
    Statistics {
        /// Its uncertainty.
        uncertainty: f64,
    },
    /// Forces or constraints have a kink: methods of high order are of low order there.
    Kink {
        /// The order that methods of order 8 and more showed.
        order: f64,
    },
    /// Shorter steps would be more exact, and the budget had no time for them.
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
            Self::Budget { seconds } => {
                write!(
                    f,
                    "a budget of {seconds:.1e} s had no time for shorter steps: `.budget(seconds)` gives more"
                )
            }
        }
    }
}
