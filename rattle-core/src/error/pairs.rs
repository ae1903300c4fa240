//! Forces between pairs of bodies that cannot be set up.

use crate::error::numbers::{Short, many};

/// What is wrong with a cut-off, a periodic box or kinds of bodies.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PairMistake {
    /// A reach (cut-off distance) that is not a positive length.
    #[error(
        "the reach of {what} is {}, and must be positive, with a square that is neither 0 nor infinite",
        Short(*.reach)
    )]
    Reach {
        /// The type of the potential.
        what: &'static str,
        /// The reach.
        reach: f64,
    },
    /// A potential that is not finite at its cut-off.
    #[error("{what} is {} at its reach {}: nothing can be taken from it there", Short(*.value), Short(*.reach))]
    Value {
        /// The type of the potential.
        what: &'static str,
        /// The reach.
        reach: f64,
        /// U or U′ there.
        value: f64,
    },
    /// A switch that does not begin between 0 and the reach.
    #[error(
        "{what} is switched off from {} on, which must be 0 or more and less than its reach {}",
        Short(*.from), Short(*.reach)
    )]
    Switch {
        /// The type of the potential.
        what: &'static str,
        /// Where the switch begins.
        from: f64,
        /// The reach.
        reach: f64,
    },
    /// A skin that is negative or not finite.
    #[error(
        "the skin of {what} is {}, and must be 0 or more and finite; 0.3 of the reach serves most", Short(*.skin)
    )]
    Skin {
        /// The type of the potential.
        what: &'static str,
        /// The skin.
        skin: f64,
    },
    /// A periodic box that is too small for the reach, or has no size.
    #[error(
        "{what} reaches as far as {}{}, and its box repeats itself after {} along coordinate {coordinate}: a period \
         must be at least twice {}, or infinite where there is none",
        Short(*.reach), looked_for(*.reach, *.through), Short(*.period),
        if .through > .reach { "that" } else { "the reach" }
    )]
    Period {
        /// The type of the potential.
        what: &'static str,
        /// Which coordinate, counted from 0.
        coordinate: usize,
        /// The period.
        period: f64,
        /// The reach.
        reach: f64,
        /// How far through space bodies are looked for: farther than the reach, where that is along a surface.
        through: f64,
    },
    /// A table that does not have one potential for every two kinds.
    #[error("{what}: a table of k kinds has k (k + 1)/2 potentials, that is 1, 3, 6, 10, …; found {size}")]
    Table {
        /// The type of the potential.
        what: &'static str,
        /// Its potentials.
        size: usize,
    },
    /// A body of a kind that is not in the table.
    #[error(
        "{what}: body {body} is of kind {kind}, and the table is of {}, counted from 0",
        many(*kinds, "kind", "kinds")
    )]
    NoSuchKind {
        /// The type of the potential.
        what: &'static str,
        /// Which body.
        body: usize,
        /// Its kind.
        kind: usize,
        /// The number of kinds.
        kinds: usize,
    },
    /// The number of kinds given is not the number of bodies.
    #[error("{what}: {} given for {}", many(*kinds, "kind was", "kinds were"), many(*bodies, "body", "bodies"))]
    KindCount {
        /// The type of the potential.
        what: &'static str,
        /// Kinds given.
        kinds: usize,
        /// Bodies of the scene.
        bodies: usize,
    },
    /// Potentials of one table in different boxes.
    #[error("{what}: all potentials of a table are in one box; `Kinds::periodic` puts them there")]
    Boxes {
        /// The type of the potential.
        what: &'static str,
    },
    /// More bodies than lists of pairs can number.
    #[error("{what}: lists of near pairs number {most} bodies at most; here are {bodies}")]
    TooMany {
        /// The type of the potential.
        what: &'static str,
        /// Bodies of the scene.
        bodies: usize,
        /// The largest number allowed.
        most: usize,
    },
}

/// How far through space bodies are looked for, where that is farther than the reach.
fn looked_for(reach: f64, through: f64) -> String {
    if through > reach {
        return format!(
            ", along the surface, for which bodies are looked for up to {} through space, {} times as far",
            Short(through),
            Short(through / reach)
        );
    }
    String::new()
}
