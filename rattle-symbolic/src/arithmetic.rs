//! Arithmetic of values: of numbers, and of arrays of one shape component by component. Nothing here reads syntax.

use crate::graph::Graph;
use crate::node::{Comparison, Id};
use crate::problems::{Extent, Problems};
use crate::syntax::Operator;
use crate::value::{Value, described};

/// Writes operations into a graph, and notes what is wrong with their operands.
pub(crate) struct Arithmetic<'a> {
    pub(crate) graph: &'a mut Graph,
    pub(crate) problems: &'a mut Problems,
}

impl Arithmetic<'_> {
    pub(crate) fn wrong(&mut self, at: Extent, message: impl std::fmt::Display) -> Value {
        self.problems.note(at, message);
        Value::Unknown
    }

    /// A result, which is no number that is known to be infinite or none.
    pub(crate) fn finite(&mut self, result: Id, at: Extent) -> Value {
        match self.graph.number(result) {
            Some(number) if !number.is_finite() => {
                self.wrong(at, format!("this constant is {}", named(number)))
            }
            _ => Value::Number(result),
        }
    }

    /// A product, quotient or power, which is finite, and is 0 only where one of its parts is.
    pub(crate) fn sized(&mut self, result: Id, parts: &[Id], at: Extent) -> Value {
        let is_zero = |id: Id| self.graph.number(id) == Some(0.0);
        if is_zero(result) && !parts.iter().any(|&part| is_zero(part)) {
            return self.wrong(at, "this constant is too small for `f64`, and would be 0");
        }
        self.finite(result, at)
    }

    /// Applies an operation to every number in the value.
    pub(crate) fn map(&mut self, value: &Value, operation: &dyn Fn(&mut Graph, Id) -> Id) -> Value {
        match value {
            Value::Unknown => Value::Unknown,
            Value::Number(id) => Value::Number(operation(self.graph, *id)),
            Value::Array(list) => {
                Value::Array(list.iter().map(|element| self.map(element, operation)).collect())
            }
        }
    }

    /// Applies an operation to the numbers of two values of one shape.
    pub(crate) fn zip(
        &mut self,
        a: &Value,
        b: &Value,
        operation: &dyn Fn(&mut Graph, Id, Id) -> Id,
    ) -> Value {
        match (a, b) {
            (Value::Number(a), Value::Number(b)) => Value::Number(operation(self.graph, *a, *b)),
            (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
                Value::Array(a.iter().zip(b.iter()).map(|(a, b)| self.zip(a, b, operation)).collect())
            }
            _ => Value::Unknown,
        }
    }

    /// `then` where the condition holds, else `other`: number by number.
    pub(crate) fn choose(&mut self, condition: &Condition, then: &Value, other: &Value) -> Value {
        self.zip(then, other, &|graph, then, other| condition.select(graph, then, other))
    }

    /// Two values by `+`, `-`, `*` or `/`. A problem is noted at the right side (`operand`), at both sides (`extent`)
    /// or at the whole chain (`at`).
    pub(crate) fn combine(
        &mut self,
        operator: Operator,
        left: Value,
        right: Value,
        operand: Extent,
        extent: Extent,
        at: Extent,
    ) -> Value {
        use Operator::{Add, Div, Mul, Sub};
        if !matches!(operator, Add | Sub | Mul | Div) {
            let message = format!("`{}` belongs between `if` and `{{`, not into a number", operator.symbol());
            return self.wrong(at, message);
        }
        let (Some(a), Some(b)) = (left.shape(), right.shape()) else { return Value::Unknown };
        let operation = |graph: &mut Graph, a: Id, b: Id| match operator {
            Add => graph.add(a, b),
            Sub => graph.sub(a, b),
            Mul => graph.mul(a, b),
            _ => graph.div(a, b),
        };
        if operator == Div
            && let Value::Number(divisor) = right
            && self.graph.number(divisor) == Some(0.0)
        {
            return self.wrong(operand, "division by zero");
        }
        match (&left, &right) {
            (Value::Array(_), Value::Array(_)) if matches!(operator, Mul | Div) => {
                let advice = "use `dot(a, b)` or indices";
                self.wrong(
                    extent,
                    format!("`{}` of two arrays has no one meaning; {advice}", operator.symbol()),
                )
            }
            (Value::Array(_), Value::Number(number)) if matches!(operator, Mul | Div) => {
                self.map(&left, &|graph, element| operation(graph, element, *number))
            }
            (Value::Number(number), Value::Array(_)) if operator == Mul => {
                self.map(&right, &|graph, element| operation(graph, *number, element))
            }
            // A sum over nothing is 0, whatever its terms would be.
            (Value::Array(_), &Value::Number(zero)) if self.graph.number(zero) == Some(0.0) => left,
            (&Value::Number(zero), Value::Array(_))
                if operator != Div && self.graph.number(zero) == Some(0.0) =>
            {
                self.map(&right, &|graph, element| operation(graph, zero, element))
            }
            (&Value::Number(a), &Value::Number(b)) => {
                let result = operation(self.graph, a, b);
                let parts = if matches!(operator, Mul | Div) { [a, b] } else { [result; 2] };
                self.sized(result, &parts, extent)
            }
            _ if a == b => self.zip(&left, &right, &|graph, a, b| operation(graph, a, b)),
            _ => {
                let (a, b) = (described(&a), described(&b));
                self.wrong(extent, format!("`{}` of {a} and {b}; the shapes must agree", operator.symbol()))
            }
        }
    }
}

/// A condition on numbers that are known at run time only.
pub(crate) enum Condition {
    Compare(Comparison, Id, Id),
    All(Vec<Condition>),
    Any(Vec<Condition>),
}

impl Condition {
    /// One selection per comparison, nested: `a && b && c` chooses by c inside b inside a.
    fn select(&self, graph: &mut Graph, then: Id, other: Id) -> Id {
        match self {
            Condition::Compare(comparison, a, b) => graph.select(*comparison, *a, *b, then, other),
            Condition::All(parts) => {
                parts.iter().rev().fold(then, |then, part| part.select(graph, then, other))
            }
            Condition::Any(parts) => {
                parts.iter().rev().fold(other, |other, part| part.select(graph, then, other))
            }
        }
    }
}

/// What a result is, in words.
pub(crate) fn named(result: f64) -> &'static str {
    if result.is_nan() { "not a real number" } else { "infinite" }
}
