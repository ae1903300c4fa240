//! The macros, and what each asks of its input.

use crate::problems::Problems;
use crate::syntax::Item;

/// Which macro it is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Macro {
    /// `constraint!`
    Constraint,
    /// `potential!`
    Potential,
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
    /// What the expression is, for messages.
    pub(crate) noun: &'static str,
    /// What to say to who writes the time into it.
    pub(crate) of_time: &'static str,
}

impl Macro {
    /// What lowering must know of the macro.
    pub(crate) fn expectation(self) -> Expectation {
        let equations =
            |of_time| Expectation { several: true, every_variable: true, noun: "this equation", of_time };
        let energy = |noun, of_time| Expectation { several: false, every_variable: false, noun, of_time };
        let forces = "potentials know no time; a force that does implements `Effect`";
        match self {
            Macro::Constraint => {
                equations("a moving constraint, for `link_moving`, has the time as its last variable")
            }
            Macro::PhaseConstraint => equations("constraints on phase space know no time"),
            Macro::Potential => energy("the potential", forces),
            Macro::Hamiltonian => energy("the Hamiltonian", "Hamiltonians know no time"),
            Macro::PairPotential => Expectation { every_variable: true, ..energy("the potential", forces) },
        }
    }

    /// What holds for this macro beyond its expression.
    pub(crate) fn check(self, item: &Item, problems: &mut Problems) {
        match (self, &item.variables[..]) {
            (Macro::PairPotential, [first, rest @ ..]) => {
                let message = "a pair potential has one variable, the distance, as in `|r| depth / r`";
                if let Some(second) = rest.first() {
                    problems.note_at(&second.name, message);
                } else if !first.shape.is_empty() {
                    problems.note_at(&first.name, message);
                }
            }
            (Macro::Hamiltonian | Macro::PhaseConstraint, variables @ [first, ..]) => {
                let message =
                    "expected coordinates and momenta of one shape, as in `|q: [f64; 2], p: [f64; 2]|`";
                match variables {
                    [q, p] if q.shape == p.shape => {}
                    [_, p] => problems.note_at(&p.name, message),
                    [_, _, third, ..] => problems.note_at(&third.name, message),
                    _ => problems.note_at(&first.name, message),
                }
            }
            _ => {}
        }
    }

    /// What documentation calls the function.
    pub(crate) fn letter(self) -> &'static str {
        match self {
            Macro::Constraint | Macro::PhaseConstraint => "g",
            Macro::Potential | Macro::PairPotential => "U",
            Macro::Hamiltonian => "H",
        }
    }
}

/// How many coordinates and equations there are.
pub(crate) struct Sizes {
    pub(crate) variables: usize,
    pub(crate) roots: usize,
}

impl Sizes {
    /// Those of an item with so many equations.
    pub(crate) fn of(item: &Item, roots: usize) -> Self {
        let size = |shape: &[usize]| shape.iter().product::<usize>();
        Sizes { variables: item.variables.iter().map(|variable| size(&variable.shape)).sum(), roots }
    }
}
