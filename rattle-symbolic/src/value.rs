//! What an expression stands for while it is lowered: a number, or an array of them.
//!
//! A problem is noted and the value becomes [`Value::Unknown`], which is silent wherever it goes, so that one mistake
//! makes one message and the rest is still checked.

use crate::node::Id;
use crate::syntax::Shape;
use std::rc::Rc;

/// What an expression stands for.
#[derive(Clone, Debug)]
pub(crate) enum Value {
    /// Wrong, and reported already.
    Unknown,
    Number(Id),
    Array(Rc<[Value]>),
}

impl Value {
    /// The lengths of the nested arrays; none if they differ or are not known.
    pub(crate) fn shape(&self) -> Option<Shape> {
        match self {
            Value::Unknown => None,
            Value::Number(_) => Some(vec![]),
            Value::Array(list) => {
                let (first, rest) = list.split_first()?;
                let mut shape = first.shape()?;
                if rest.iter().any(|element| element.shape().as_ref() != Some(&shape)) {
                    return None;
                }
                shape.insert(0, list.len());
                Some(shape)
            }
        }
    }
    /// How many numbers there are, if the elements of each array are alike.
    pub(crate) fn size(&self) -> usize {
        match self {
            Value::Unknown | Value::Number(_) => 1,
            Value::Array(list) => list.first().map_or(1, Value::size).saturating_mul(list.len()),
        }
    }
    /// The numbers in it, row by row.
    pub(crate) fn numbers(&self, into: &mut Vec<Id>) -> bool {
        match self {
            Value::Unknown => false,
            Value::Number(id) => {
                into.push(*id);
                true
            }
            Value::Array(list) => list.iter().all(|element| element.numbers(into)),
        }
    }
}

/// A shape in words.
pub(crate) fn described(shape: &[usize]) -> String {
    match shape {
        [] => "a number".to_owned(),
        [n] => format!("an array of {n}"),
        [m, n] => format!("a matrix of {m} × {n}"),
        _ => format!("an array of {}", shape.iter().map(|n| n.to_string()).collect::<Vec<_>>().join(" × ")),
    }
}
