//! Names in scope, and what they stand for.

use crate::node::Id;
use crate::problems::{Extent, Problems, nearest};
use crate::ratio::Ratio;
use crate::value::Value;
use proc_macro2::Ident;
use std::collections::{HashMap, HashSet};

/// What a name was introduced as.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Role {
    Parameter,
    Variable,
    Let,
    Index,
}

impl Role {
    fn described(self) -> &'static str {
        match self {
            Role::Parameter => "a parameter",
            Role::Variable => "a variable",
            Role::Let => "defined by a `let`",
            Role::Index => "an index",
        }
    }
}

pub(crate) struct Binding {
    name: String,
    role: Role,
    pub(crate) value: Value,
    /// The exact constant it is, if it is one: an index, `let n = 3/2;`.
    pub(crate) exact: Option<Ratio>,
    /// Where its definition stands in `Scope::definitions`.
    definition: usize,
}

/// A place in the source where a name is introduced; in a loop it is passed several times.
struct Definition {
    name: Ident,
    role: Role,
    used: bool,
}

/// The names, innermost last.
#[derive(Default)]
pub(crate) struct Scope {
    bindings: Vec<Binding>,
    /// Where each name is bound, innermost last: looked up, never iterated.
    index: HashMap<String, Vec<usize>>,
    definitions: Vec<Definition>,
    /// The definition of an identifier by its address: looked up, never iterated.
    places: HashMap<usize, usize>,
}

/// Constants that are always in scope.
pub(crate) const CONSTANTS: [(&str, f64, &str); 2] =
    [("pi", std::f64::consts::PI, "the circle number"), ("e", std::f64::consts::E, "Euler's number")];

/// So many names are listed where one is unknown.
const LISTED: usize = 24;

impl Scope {
    pub(crate) fn len(&self) -> usize {
        self.bindings.len()
    }

    /// Brings a name into scope; one that is taken is reported, and hidden.
    pub(crate) fn define(
        &mut self,
        problems: &mut Problems,
        name: &Ident,
        role: Role,
        value: Value,
        exact: Option<Ratio>,
    ) {
        let next = self.definitions.len();
        let definition = *self.places.entry(std::ptr::from_ref(name) as usize).or_insert(next);
        if definition == next {
            self.definitions.push(Definition { name: name.clone(), role, used: false });
            self.check(problems, name);
        }
        let name = name.to_string();
        self.index.entry(name.clone()).or_default().push(self.bindings.len());
        self.bindings.push(Binding { name, role, value, exact, definition });
    }

    fn check(&mut self, problems: &mut Problems, name: &Ident) {
        let text = name.to_string();
        let earlier = self.index.get(&text).and_then(|places| places.first());
        if let Some((_, _, meaning)) = CONSTANTS.iter().find(|(constant, ..)| *constant == text) {
            problems.note_at(name, format!("`{text}` is {meaning} here; choose another name"));
        } else if let Some(earlier) = earlier.map(|&place| &self.bindings[place]) {
            self.definitions[earlier.definition].used = true; // one message is enough
            let role = earlier.role.described();
            problems.note_at(name, format!("`{text}` is {role} already; choose another name"));
        }
    }

    /// The plain numbers among the names from `start` on.
    pub(crate) fn numbers_from(&self, start: usize) -> impl Iterator<Item = (Id, String)> {
        self.bindings[start..].iter().filter_map(|binding| match binding.value {
            Value::Number(id) => Some((id, binding.name.clone())),
            _ => None,
        })
    }

    /// Ends a scope: the names from `start` on.
    pub(crate) fn close(&mut self, start: usize) {
        for binding in self.bindings.drain(start..).rev() {
            if let Some(places) = self.index.get_mut(&binding.name) {
                places.pop();
            }
        }
    }

    /// Reports the names that nobody used.
    pub(crate) fn report_unused(&self, problems: &mut Problems, every_variable: bool) {
        for definition in &self.definitions {
            let name = definition.name.to_string();
            if definition.used
                || name.starts_with('_')
                || (definition.role == Role::Variable && !every_variable)
            {
                continue;
            }
            let message = match definition.role {
                Role::Parameter => {
                    format!("the parameter `{name}` is not used; remove it or write `_{name}`")
                }
                Role::Variable => {
                    format!("the variable `{name}` is not used; write `_{name}` if nothing depends on it")
                }
                Role::Let => format!("`{name}` is not used; remove this `let` or write `_{name}`"),
                Role::Index => {
                    format!("the index `{name}` is not used; write `_{name}` to repeat without it")
                }
            };
            problems.note_at(&definition.name, message);
        }
    }

    pub(crate) fn find(&mut self, name: &str) -> Option<&Binding> {
        let binding = &self.bindings[*self.index.get(name)?.last()?];
        self.definitions[binding.definition].used = true;
        Some(binding)
    }

    /// Reports a name that is not in scope, with what is known about it.
    pub(crate) fn unknown(&mut self, problems: &mut Problems, at: Extent, name: &str, about: &str) {
        if problems.full() {
            return;
        }
        let known: Vec<String> = self.bindings.iter().map(|binding| binding.name.to_string()).collect();
        let mut listed = HashSet::new(); // a name that is taken twice is one
        let known: Vec<&str> = known
            .iter()
            .map(String::as_str)
            .chain(CONSTANTS.map(|(name, ..)| name))
            .filter(|name| listed.insert(*name))
            .collect();
        let near = if name == "π" { Some("pi") } else { nearest(name, known.iter().copied()) };
        let advice = match near {
            _ if !about.is_empty() => about.to_owned(),
            Some(near) => {
                self.find(near);
                format!("; did you mean `{near}`?")
            }
            None => String::new(),
        };
        let listed = match known.len() > LISTED {
            true => format!("{}, …", known[..LISTED].join(", ")),
            false => known.join(", "),
        };
        problems.note(at, format!("unknown name `{name}`, expected one of {listed}{advice}"));
    }
}
