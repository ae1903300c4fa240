//! Errors of links, masses and pins, and how messages name an equation.

use crate::error::numbers::many;
use std::fmt;

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
        /// The body that it names.
        body: usize,
        /// Bodies of the scene.
        bodies: usize,
    },
    /// A link or an effect names one body twice.
    #[error("{what} {member} names body {body} twice; its members are different bodies")]
    Repeated {
        /// The type of the constraint.
        what: &'static str,
        /// Which of its members.
        member: usize,
        /// The body.
        body: usize,
    },
    /// The place of a pin is not a number, or infinite.
    #[error("the pin of body {body} is at {place:?}; every coordinate must be finite")]
    PinNotFinite {
        /// The body.
        body: usize,
        /// The place.
        place: Vec<f64>,
    },
    /// A body is pinned twice, at different places.
    #[error("body {body} is pinned at {first:?} and at {second:?}")]
    PinnedTwice {
        /// The body.
        body: usize,
        /// One place.
        first: Vec<f64>,
        /// The other.
        second: Vec<f64>,
    },
    /// The number of masses is not the number of bodies.
    #[error("{} given for {}", many(*masses, "mass was", "masses were"), many(*bodies, "body", "bodies"))]
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
    /// Moments of inertia that no body can have.
    #[error(
        "moments of inertia must be positive, none larger than the sum of the others, their sum and inverses finite; found \
         {moments:?}"
    )]
    Inertia {
        /// I₁, I₂, I₃.
        moments: [f64; 3],
    },
    /// A link or pin of some bodies alone, before the number of bodies was changed: it cannot be copied to each.
    #[error(
        "{what} was said of some of {of} only, so that `bodies({bodies})` has no copy of it for each; say how many \
         bodies there are before links and pins",
        of = many(*before, "body", "bodies")
    )]
    NotCopied {
        /// The type of the constraint, or `pin`.
        what: &'static str,
        /// Bodies when it was said.
        before: usize,
        /// Bodies now.
        bodies: usize,
    },
    /// Too many equations for `LinearAlgebra::Orthogonal`.
    #[error(
        "an orthonormal basis costs the cube of the equations that are tied together, and serves up to {most}; here are \
         {equations}: leave out those that depend on others, and have the rest solved by `LinearAlgebra::Automatic`"
    )]
    TooManyForBasis {
        /// Equations of the largest connected component.
        equations: usize,
        /// The largest number of equations allowed.
        most: usize,
    },
    /// Multipliers that act on chosen coordinates only, on bodies whose mass matrix couples coordinates.
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
    /// Which group of links, in the order in which the scene names them, counted from 0.
    pub group: usize,
    /// Which member of its list, counted from 0.
    pub member: usize,
    /// Which equation of the member, counted from 0.
    pub equation: usize,
    /// The number of equations of the member.
    pub of: usize,
    /// The bodies that it links.
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
