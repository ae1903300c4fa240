//! Effects whose parameters make no sense.

use crate::error::numbers::many;

/// What is wrong with an effect.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EffectMistake {
    /// A parameter outside its range.
    #[error("{name} must be {range}, found {value}")]
    Parameter {
        /// Its name.
        name: &'static str,
        /// What it may be.
        range: &'static str,
        /// What it is.
        value: f64,
    },
    /// Something is listed for each body, and the scene has another number of bodies.
    #[error("{} given for {}", many(*listed, "number was", "numbers were"), many(*bodies, "body", "bodies"))]
    Count {
        /// How many are listed.
        listed: usize,
        /// Bodies of the scene.
        bodies: usize,
    },
    /// Momenta that no masses belong to.
    #[error("{system} has no masses, and so no temperature")]
    NoMasses {
        /// The kind of system.
        system: &'static str,
    },
    /// What goes along a surface, and bodies that are on none.
    #[error("it is for bodies each on a surface in space, or for bodies in the plane that are on no curve")]
    NoSurface,
    /// A direction without a part along the surface.
    #[error("the heading {heading:?} of body {body} has no part along the surface")]
    NoHeading {
        /// Which body.
        body: usize,
        /// The heading that was given.
        heading: Vec<f64>,
    },
    /// Random forces do not run backwards.
    #[error(
        "what is random is not undone by a step of −h: a positive step size is needed, and no check of reversal"
    )]
    NoWayBack,
}

impl EffectMistake {
    /// Looks whether a parameter is at least 0 and finite.
    ///
    /// # Errors
    /// [`EffectMistake::Parameter`].
    pub fn unless_positive_or_zero(name: &'static str, value: f64) -> Result<(), Self> {
        let fine = value >= 0.0 && value.is_finite();
        if fine { Ok(()) } else { Err(Self::Parameter { name, range: "0 or positive, and finite", value }) }
    }

    /// Looks whether a parameter is above 0 and finite.
    ///
    /// # Errors
    /// [`EffectMistake::Parameter`].
    pub fn unless_positive(name: &'static str, value: f64) -> Result<(), Self> {
        let fine = value > 0.0 && value.is_finite();
        if fine { Ok(()) } else { Err(Self::Parameter { name, range: "positive and finite", value }) }
    }

    /// Looks whether nothing is listed, or one number for each body.
    ///
    /// # Errors
    /// [`EffectMistake::Count`].
    pub fn unless_listed(listed: usize, bodies: usize) -> Result<(), Self> {
        if listed == 0 || listed == bodies { Ok(()) } else { Err(Self::Count { listed, bodies }) }
    }

    /// Looks whether a parameter is a number.
    ///
    /// # Errors
    /// [`EffectMistake::Parameter`].
    pub fn unless_finite(name: &'static str, value: f64) -> Result<(), Self> {
        if value.is_finite() { Ok(()) } else { Err(Self::Parameter { name, range: "finite", value }) }
    }
}
