//! Effects whose parameters make no sense.

use crate::error::numbers::{Short, many};

/// What is wrong with an effect.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EffectMistake {
    /// A parameter outside its range.
    #[error("{name} must be {range}, found {}", Short(*.value))]
    Parameter {
        /// Its name.
        name: &'static str,
        /// The allowed range.
        range: &'static str,
        /// Its value.
        value: f64,
    },
    /// A list with one entry for each body has another length than the number of bodies.
    #[error("{} given for {}", many(*listed, "number was", "numbers were"), many(*bodies, "body", "bodies"))]
    Count {
        /// The length of the list.
        listed: usize,
        /// Bodies of the scene.
        bodies: usize,
    },
    /// The effect needs masses, which this system does not have.
    #[error("{system} has no masses, and so no temperature")]
    NoMasses {
        /// The kind of system.
        system: &'static str,
    },
    /// The effect acts along a surface, and bodies are on none.
    #[error("it is for bodies each on a surface in space, or for bodies in the plane that are on no curve")]
    NoSurface,
    /// The potential energy at the start is NaN.
    #[error(
        "its energy is NaN at the start; check the start and the parameters against the potential's domain"
    )]
    NoEnergy,
    /// Distances along a surface, and bodies are on another.
    #[error("{}", not_along(*body, *other, *off))]
    NotAlong {
        /// Which body.
        body: usize,
        /// Another body that is near, where the two are not on one level of g.
        other: Option<usize>,
        /// How far they are apart across the surface; without another body the sine of the angle between the normals.
        off: f64,
    },
    /// Distances along a surface in a periodic box, whose periods are not those of the surface.
    #[error(
        "its surface does not repeat itself after the period {} of coordinate {coordinate}: at body {body} it is off by \
         {off:.1e} there; the periods of a box are those of the surface, in all digits, or infinite where it has none",
        Short(*.period)
    )]
    NotRepeated {
        /// Which body.
        body: usize,
        /// Which coordinate, counted from 0.
        coordinate: usize,
        /// Its period.
        period: f64,
        /// How far the body and its image are apart across the levels of g, or by how much their normals differ.
        off: f64,
    },
    /// A heading is normal to the surface.
    #[error("the heading {heading:?} of body {body} has no part along the surface")]
    NoHeading {
        /// Which body.
        body: usize,
        /// The heading that was given.
        heading: Vec<f64>,
    },
    /// A force on a rigid body that is more than a torque: only the first three of nine components may be nonzero.
    #[error(
        "on body {body} it is {force:?}; of the nine components of a force on a rigid body the first three are the \
         torque, in the frame of the body, and the others have to be 0 (a force F on the entries of the attitude Q has \
         the torque (QᵀF − FᵀQ)ˇ)"
    )]
    NoTorque {
        /// Which body.
        body: usize,
        /// The force.
        force: Vec<f64>,
    },
    /// A negative step size, with random forces, which do not run backwards.
    #[error(
        "what is random is not undone by a step of −h: a positive step size is needed, and no check of reversal"
    )]
    NoWayBack,
}

/// What [`EffectMistake::NotAlong`] says.
fn not_along(body: usize, other: Option<usize>, off: f64) -> String {
    let asked = "distances along a surface are those of the surface on which bodies are: give it that one";
    match other {
        Some(other) => {
            format!("bodies {body} and {other} are {off:.1e} apart across the levels of its surface; {asked}")
        }
        None => format!("the normal at body {body} is off from that of its surface by {off:.1e}; {asked}"),
    }
}

impl EffectMistake {
    /// Checks that a parameter is at least 0 and finite.
    ///
    /// # Errors
    /// [`EffectMistake::Parameter`].
    pub fn unless_positive_or_zero(name: &'static str, value: f64) -> Result<(), Self> {
        let fine = value >= 0.0 && value.is_finite();
        if fine { Ok(()) } else { Err(Self::Parameter { name, range: "0 or positive, and finite", value }) }
    }

    /// Checks that a parameter is above 0 and finite.
    ///
    /// # Errors
    /// [`EffectMistake::Parameter`].
    pub fn unless_positive(name: &'static str, value: f64) -> Result<(), Self> {
        let fine = value > 0.0 && value.is_finite();
        if fine { Ok(()) } else { Err(Self::Parameter { name, range: "positive and finite", value }) }
    }

    /// Checks that a list, if there is one, has an entry for each body.
    ///
    /// # Errors
    /// [`EffectMistake::Count`].
    pub fn unless_for_each<T>(list: Option<&[T]>, bodies: usize) -> Result<(), Self> {
        let listed = list.map_or(bodies, <[T]>::len);
        if listed == bodies { Ok(()) } else { Err(Self::Count { listed, bodies }) }
    }

    /// Checks that a parameter is finite.
    ///
    /// # Errors
    /// [`EffectMistake::Parameter`].
    pub fn unless_finite(name: &'static str, value: f64) -> Result<(), Self> {
        if value.is_finite() { Ok(()) } else { Err(Self::Parameter { name, range: "finite", value }) }
    }
}
