//! The macros, and the rules for their inputs.

use crate::problems::Problems;
use crate::syntax::{Item, Variable};

/// A macro.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Macro {
    /// `constraint!`
    Constraint,
    /// `potential!`
    Potential,
    /// `potential!` with the time as its last variable
    DrivenPotential,
    /// `force!`
    Force,
    /// `pair_potential!`
    PairPotential,
    /// `hamiltonian!`
    Hamiltonian,
    /// `phase_constraint!`
    PhaseConstraint,
}

/// What the macro at hand expects.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Expectation {
    /// Whether there may be several equations.
    pub(crate) several: bool,
    /// Whether a variable that is not used is a mistake.
    pub(crate) every_variable: bool,
    /// Whether an expression may depend on no variable at all.
    pub(crate) constant: bool,
    /// What the expression is, for messages.
    pub(crate) noun: &'static str,
    /// What to say to who writes the time into it.
    pub(crate) of_time: &'static str,
}

impl Macro {
    /// What lowering must know of the macro.
    pub(crate) fn expectation(self) -> Expectation {
        let equations = |of_time| Expectation {
            several: true,
            every_variable: true,
            constant: false,
            noun: "this equation",
            of_time,
        };
        let energy = |noun, of_time| Expectation {
            several: false,
            every_variable: false,
            constant: false,
            noun,
            of_time,
        };
        let last = "the time is the last variable, as in `|x, y, z, t|`";
        let pairs = "pair potentials know no time; a potential over two bodies does, with the time as its last variable";
        match self {
            Macro::Constraint => {
                equations("a moving constraint, for `link_moving`, has the time as its last variable")
            }
            Macro::PhaseConstraint => equations("constraints on phase space know no time"),
            Macro::Potential | Macro::DrivenPotential => energy("the potential", last),
            Macro::Force => Expectation { several: true, constant: true, ..energy("the force", last) },
            Macro::Hamiltonian => energy("the Hamiltonian", "Hamiltonians know no time"),
            Macro::PairPotential => Expectation { every_variable: true, ..energy("the potential", pairs) },
        }
    }

    /// The macro itself, or what it is for an item with the time as a variable.
    pub(crate) fn of(self, item: &Item) -> Self {
        let has_time = item.variables.iter().any(|variable| variable.name == TIME);
        if self == Macro::Potential && has_time { Macro::DrivenPotential } else { self }
    }

    /// What holds for this macro beyond its expression, of so many components.
    pub(crate) fn check(self, item: &Item, components: usize, problems: &mut Problems) {
        match self {
            Macro::DrivenPotential | Macro::Force => check_time(&item.variables, problems),
            Macro::Constraint => check_moving(&item.variables, problems),
            _ => {}
        }
        match (self, &item.variables[..]) {
            (Macro::Force, variables) => {
                let sizes = self.sizes(item, components);
                if let Some(velocity) = early_velocity(variables, sizes.coordinates(), components) {
                    let order = in_order(variables, is_velocity).unwrap_or("|q, v|".to_owned());
                    let message = format!("coordinates come first, then velocities: `{order}`");
                    problems.note_at(&velocity.name, message);
                }
                if problems.any() {
                    return;
                }
                let (rest, time) = (sizes.coordinates(), sizes.time);
                if rest != components && rest != 2 * components {
                    let unused = item.variables.iter().any(|variable| variable.name == format!("_{TIME}"));
                    let message = format!(
                        "the force has {components} component{}, and so as many coordinates, as many velocities if it depends on \
                         them, and the time `t` if it does; found {rest} variables{}{}",
                        if components == 1 { "" } else { "s" },
                        if time { " and the time" } else { "" },
                        if unused { ": leave `_t` out" } else { "" },
                    );
                    problems.note_at(&item.name, message);
                }
            }
            (Macro::PairPotential, [first, rest @ ..]) => {
                let message = "a pair potential has one variable, the distance, as in `|r| depth / r`";
                if let Some(second) = rest.first() {
                    problems.note_at(&second.name, message);
                } else if !first.shape.is_empty() {
                    problems.note_at(&first.name, message);
                }
            }
            (Macro::Hamiltonian | Macro::PhaseConstraint, variables) => check_halves(variables, problems),
            _ => {}
        }
    }

    /// What documentation calls the function.
    pub(crate) fn letter(self) -> &'static str {
        match self {
            Macro::Constraint | Macro::PhaseConstraint => "g",
            Macro::Potential | Macro::DrivenPotential | Macro::PairPotential => "U",
            Macro::Force => "f",
            Macro::Hamiltonian => "H",
        }
    }
}

/// What the time is called, where a variable can be the time.
const TIME: &str = "t";

/// Notes what is no half of coordinates before a half of momenta of the same shapes. More than two variables are told
/// apart by their names, since an order as in `|x, px, y, py|` or `|x, y, py, px|` has the same shapes.
fn check_halves(variables: &[Variable], problems: &mut Problems) {
    let names: Vec<_> = variables.iter().map(|variable| variable.name.to_string()).collect();
    let (half, several) = (names.len() / 2, names.len() > 2);
    let (of_q, of_p) = names.split_at(half);
    let is_p = |place: usize| is_momentum_among(&names, place, several);
    if let Some(early) = (0..half).find(|&place| is_p(place))
        && (several || is_coordinate(&of_p[0]) || !is_p(half))
    {
        let (momenta, coordinates): (Vec<_>, Vec<_>) = (0..names.len()).partition(|&place| is_p(place));
        let order = match several {
            false => Some(written(variables.iter().rev().map(|variable| ("", variable)))),
            true if coordinates.len() != momenta.len() => None,
            true => Some(with_momenta(coordinates.into_iter().map(|place| &variables[place]))),
        };
        let message = match order {
            Some(order) => format!("coordinates come first, then momenta: write `{order}`"),
            None => format!(
                "{} of these {} are called as momenta are; each coordinate has one momentum, called as it is behind a \
                 p: `|x, y, px, py|`",
                momenta.len(),
                names.len()
            ),
        };
        return problems.note_at(&variables[early].name, message);
    }
    let (coordinates, momenta) = variables.split_at(half);
    let other = match momenta.len() > coordinates.len() {
        true => momenta.last(),
        false => coordinates.iter().zip(momenta).find(|(q, p)| q.shape != p.shape).map(|(_, p)| p),
    };
    if let Some(other) = other {
        let message = "expected coordinates and momenta of one shape, as in `|q: [f64; 2], p: [f64; 2]|` or `|x, y, px, py|`";
        return problems.note_at(&other.name, message);
    }
    if let Some(place) = (0..half).find(|&place| several && !belongs(&of_p[place], of_q, place)) {
        let order = with_momenta(coordinates.iter());
        let message =
            format!("momenta have the names of their coordinates, in the same order: write `{order}`");
        problems.note_at(&momenta[place].name, message);
    }
}

/// Whether a variable on phase space is a momentum by its name: that of another after a p; or among more than two what
/// is called p, where no other has its name after a p, and among two what may be called so or as a velocity.
fn is_momentum_among(names: &[String], place: usize, several: bool) -> bool {
    let after_p = |name: &str| {
        name.trim_start_matches('_').strip_prefix('p').map(|rest| rest.trim_start_matches('_').to_owned())
    };
    let (name, has_own) =
        (&names[place], |name: &str| names.iter().any(|other| after_p(other).as_deref() == Some(name)));
    let of_another = after_p(name).is_some_and(|rest| names.contains(&rest));
    of_another || (!has_own(name) && if several { has_p(name) } else { is_momentum(name) })
}

/// These coordinates, and momenta of their names.
fn with_momenta<'a>(coordinates: impl Iterator<Item = &'a Variable> + Clone) -> String {
    written(coordinates.clone().map(|of| ("", of)).chain(coordinates.map(|of| ("p", of))))
}

/// A list of variables with their shapes, each with letters before its name.
fn written<'a>(variables: impl Iterator<Item = (&'a str, &'a Variable)>) -> String {
    let variables = variables.map(|(before, Variable { name, shape })| {
        let array = shape.iter().rev().fold("f64".to_owned(), |inner, size| format!("[{inner}; {size}]"));
        if shape.is_empty() { format!("{before}{name}") } else { format!("{before}{name}: {array}") }
    });
    format!("|{}|", variables.collect::<Vec<_>>().join(", "))
}

/// Whether a momentum is called as that of the coordinate of this place: of `theta1` `ptheta1`, `p_theta1` or `p1`, of
/// `q` also `p`; or by its place, where no coordinate ends so.
fn belongs(momentum: &str, coordinates: &[String], place: usize) -> bool {
    let Some(rest) = momentum.trim_start_matches('_').strip_prefix('p') else { return false };
    let (rest, coordinate) = (rest.trim_start_matches('_'), &coordinates[place]);
    if rest.is_empty() {
        return coordinate == "q";
    }
    let by_place = [place, place + 1].iter().any(|place| rest == place.to_string());
    coordinate.ends_with(rest) || (by_place && !coordinates.iter().any(|other| other.ends_with(rest)))
}

/// Notes a time that is not the last variable, no number, or the only variable of a potential.
fn check_time(variables: &[Variable], problems: &mut Problems) {
    for (place, Variable { name, shape }) in variables.iter().enumerate().filter(|(_, v)| v.name == TIME) {
        if !shape.is_empty() {
            problems.note_at(name, "`t` is the time, a number; call coordinates by another name");
        } else if place + 1 < variables.len() {
            problems.note_at(name, "`t` is the time, and stands last, as in `|x, y, z, t|`");
        } else if place == 0 {
            problems.note_at(
                name,
                "what depends on the time alone moves nothing; write the coordinates before `t`",
            );
        }
    }
}

/// Notes a number called the time that is not the last variable of a constraint: `link_moving` takes the last one.
fn check_moving(variables: &[Variable], problems: &mut Problems) {
    let Some((_, others)) = variables.split_last() else { return };
    for Variable { name, .. } in others.iter().filter(|variable| variable.shape.is_empty()) {
        if name == TIME || name == "time" {
            let message =
                format!("`{name}` is the time of a moving constraint, and stands last, as in `|x, y, t|`");
            problems.note_at(name, message);
        }
    }
}

/// A velocity among the coordinates of a force of so many components: the first variable of all, or, where what is
/// called a velocity is half of the variables, one among the first half. (In `|u, v, du, dv|` it is not: v is a
/// coordinate.)
fn early_velocity(variables: &[Variable], all: usize, components: usize) -> Option<&Variable> {
    let size = |variable: &Variable| variable.shape.iter().product::<usize>();
    let velocities =
        variables.iter().filter(|variable| is_velocity(&variable.name.to_string())).map(size).sum();
    let coordinates = if all == 2 * components && components == velocities { components } else { 0 };
    let mut before = 0;
    variables.iter().enumerate().find_map(|(place, variable)| {
        let early = place == 0 || before < coordinates;
        before += size(variable);
        (early && is_velocity(&variable.name.to_string())).then_some(variable)
    })
}

/// The variables as they should stand: coordinates, then what is no coordinate, then the time. None where there are not
/// both.
fn in_order(variables: &[Variable], is_other: fn(&str) -> bool) -> Option<String> {
    let names = variables.iter().map(|variable| variable.name.to_string());
    let (times, names): (Vec<_>, Vec<_>) = names.partition(|name| name == TIME);
    let (others, coordinates): (Vec<_>, Vec<_>) = names.into_iter().partition(|name| is_other(name));
    let both = !others.is_empty() && !coordinates.is_empty();
    both.then(|| format!("|{}|", [coordinates, others, times].concat().join(", ")))
}

/// Whether a velocity is called so: `v`, `vx`, `v0`, `v_left`, `vel`, `velocity`.
fn is_velocity(name: &str) -> bool {
    is_called(name, "v", &["vel", "velocity", "velocities"])
}

/// Whether what belongs to coordinates on phase space is called so, and not a coordinate: `p`, `px`, `momentum`, `v`.
fn is_momentum(name: &str) -> bool {
    has_p(name) || is_velocity(name)
}

/// Whether a momentum is called so: `p`, `px`, `p_left`, `momentum`.
fn has_p(name: &str) -> bool {
    is_called(name, "p", &["momentum", "momenta"])
}

/// Whether a coordinate is called so: `q`, `q0`, `x`, `x_left`, `position`.
fn is_coordinate(name: &str) -> bool {
    ["q", "x"].iter().any(|letter| is_called(name, letter, &["position", "positions"]))
}

/// Whether a name is this letter, alone or with one letter or digit more, or with more behind a `_`, or one of these
/// words.
fn is_called(name: &str, letter: &str, words: &[&str]) -> bool {
    let name = name.trim_start_matches('_');
    let short = |rest: &str| rest.chars().count() < 2 || rest.starts_with('_');
    name.strip_prefix(letter).is_some_and(short) || words.contains(&name)
}

/// How many variables there are, whether the last one is the time, and how many equations or components.
pub(crate) struct Sizes {
    pub(crate) variables: usize,
    pub(crate) time: bool,
    pub(crate) roots: usize,
}

impl Sizes {
    /// The variables but for the time, whose type may be none that is known.
    pub(crate) fn coordinates(&self) -> usize {
        self.variables.saturating_sub(usize::from(self.time))
    }
}

impl Macro {
    /// The sizes of an item with so many equations or components.
    pub(crate) fn sizes(self, item: &Item, roots: usize) -> Sizes {
        let size = |shape: &[usize]| shape.iter().product::<usize>();
        let variables = item.variables.iter().map(|variable| size(&variable.shape)).sum();
        let knows_time = matches!(self, Macro::DrivenPotential | Macro::Force);
        let time = knows_time && item.variables.last().is_some_and(|variable| variable.name == TIME);
        Sizes { variables, time, roots }
    }
}
