//! A function of several bodies, and the bodies on which each copy of it acts.

use crate::error::{EffectMistake, Error, NetworkMistake, refuse_nan};
use std::any::type_name;

/// A potential, or another function of A bodies, on chosen bodies. Each member is a list of A bodies; the variables of
/// the function are their coordinates, one after the other. Made by [`Potential::over`](crate::kernel::Potential::over)
/// and similar methods.
///
/// ```text
/// scene.with(Spring { stiffness: 9.0, length: 1.0 }.over([[0, 1], [1, 2]]))      // |a: [f64; 3], b: [f64; 3]| …
/// scene.with(Over::each(masses.iter().enumerate().map(|(i, m)| (Gravity { g: 9.81 * m }, [i]))))
/// ```
#[derive(Debug, Clone)]
pub struct Over<P, const A: usize> {
    /// One for all members, or one for each.
    pub(crate) potentials: Vec<P>,
    pub(crate) members: Vec<[usize; A]>,
    /// The number of bodies of the scenes for which it is made.
    bodies: Option<usize>,
}

impl<P, const A: usize> Over<P, A> {
    /// The same potential for all of these members.
    pub fn new(potential: P, members: impl IntoIterator<Item = [usize; A]>) -> Self {
        Self { potentials: vec![potential], members: members.into_iter().collect(), bodies: None }
    }

    /// A potential for each member.
    pub fn each(pairs: impl IntoIterator<Item = (P, [usize; A])>) -> Self {
        let (potentials, members) = pairs.into_iter().unzip();
        Self { potentials, members, bodies: None }
    }

    /// The same for scenes of so many bodies alone; others refuse it. For members made of a list with an entry for each
    /// body, of which none was to be forgotten.
    #[must_use]
    pub fn for_bodies(self, bodies: usize) -> Self {
        Self { bodies: Some(bodies), ..self }
    }

    /// Looks whether the members name bodies that there are, each once, and whether there are as many bodies as it is
    /// made for; and whether a potential has a parameter that is NaN.
    ///
    /// # Errors
    /// Which member does not, of the effect called so; how many bodies it is for; which parameter.
    pub(crate) fn check_each(
        &self,
        what: &'static str,
        bodies: usize,
        nan_parameter: impl Fn(&P) -> Option<&'static str>,
    ) -> Result<(), Error> {
        if let Some(listed) = self.bodies.filter(|&listed| listed != bodies) {
            return Err(Error::Effect { effect: what, mistake: EffectMistake::Count { listed, bodies } });
        }
        let ends = self.members.iter().enumerate().flat_map(|(i, of)| (0..A).map(move |end| (i, of, end)));
        for (member, of, end) in ends {
            let body = of[end];
            if body >= bodies {
                return Err(Error::Network(NetworkMistake::NoSuchBody { what, member, body, bodies }));
            }
            if of[..end].contains(&body) {
                return Err(Error::Network(NetworkMistake::Repeated { what, member, body }));
            }
        }
        refuse_nan(what, self.potentials.iter().find_map(nan_parameter))
    }
}

/// The name of a type without paths; of a potential over bodies, within a reach or by kinds, that of the potential.
pub(crate) fn short_name<P>() -> &'static str {
    innermost(type_name::<P>())
}

/// Refuses a formula of this type one of whose parameters is NaN: that one. The name is asked for only then: it takes
/// a tenth of a microsecond, and every start of an ensemble is checked.
pub(crate) fn refuse_nan_in<P>(parameter: Option<&'static str>) -> Result<(), Error> {
    parameter.map_or(Ok(()), |parameter| refuse_nan(short_name::<P>(), Some(parameter)))
}

/// The name of what stands in such wrappers. Not generic, so that it is compiled once.
fn innermost(mut name: &'static str) -> &'static str {
    for wrapper in [
        "over::Over<", "counted::Counted<", "kinds::Kinds<", "within::Along<", "within::AlongGeodesics<",
        "within::Within<",
    ] {
        name = name.split_once(wrapper).map_or(name, |(_, potential)| potential);
    }
    let name = name.split(['<', ',', '>']).next().unwrap_or(name);
    name.rsplit(':').next().unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::counted::Counted;
    use crate::kernel::kinds::Kinds;
    use crate::kernel::space::Periodic;
    use crate::kernel::within::{Along, AlongGeodesics, Within};

    #[test]
    fn potentials_are_named_without_what_they_stand_in() {
        struct Pull;
        struct Between<P>(P);
        assert_eq!(short_name::<Pull>(), "Pull");
        assert_eq!(short_name::<Between<Pull>>(), "Between");
        assert_eq!(short_name::<Within<Pull>>(), "Pull");
        assert_eq!(short_name::<Within<Between<Pull>, Periodic<3>>>(), "Between");
        assert_eq!(short_name::<Kinds<Within<Pull>>>(), "Pull");
        assert_eq!(short_name::<Along<Pull, Between<Pull>>>(), "Pull");
        assert_eq!(short_name::<AlongGeodesics<Pull, Between<Pull>>>(), "Pull");
        assert_eq!(short_name::<Over<Pull, 2>>(), "Pull");
        assert_eq!(short_name::<Within<Counted<Between<Pull>>>>(), "Between");
    }
}
