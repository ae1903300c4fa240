//! Syntax to graph, checking everything on the way.
//!
//! Arrays live only here: indices, loops and `sum` are worked out, and what reaches the graph are
//! numbers. A problem is noted and the value becomes [`Value::Unknown`], which is silent wherever it
//! goes, so that one mistake makes one message and the rest is still checked.

use crate::graph::{Comparison, Graph, Id, Input};
use crate::names::{CONSTANTS, Role, Scope};
use crate::parse::UNKNOWN;
use crate::problems::{Extent, Problems};
use crate::ratio::Ratio;
use crate::syntax::{Binder, Expr, Item, Kind, Operator, Shape};
use proc_macro2::Ident;
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
                let mut shape = list.first()?.shape()?;
                if list.iter().any(|element| element.shape().as_ref() != Some(&shape)) {
                    return None;
                }
                shape.insert(0, list.len());
                Some(shape)
            }
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

/// What the macro at hand expects.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Expectation {
    /// Whether there may be several equations.
    pub(crate) several: bool,
    /// Whether a variable that is not used is a mistake.
    pub(crate) every_variable: bool,
    /// What the expression is, for messages.
    pub(crate) noun: &'static str,
}

/// The size where an expression is no longer one: half a million operations.
const LARGEST: usize = 1 << 19;

pub(crate) struct Lowering<'a> {
    pub(crate) graph: &'a mut Graph,
    pub(crate) problems: &'a mut Problems,
    scope: Scope,
    /// What the `let`s around the equations are, outside of loops.
    named: Vec<(Id, String)>,
    rounds: usize,
    pub(crate) unreadable: bool,
    exhausted: bool,
}

/// What an item comes to.
pub(crate) struct Lowered {
    /// One per equation.
    pub(crate) roots: Vec<Id>,
    /// The numbers that have names, for the documentation.
    pub(crate) named: Vec<(Id, String)>,
}

/// The equations of an item. Problems are noted; the roots are then incomplete.
pub(crate) fn lower(
    item: &Item,
    expected: Expectation,
    graph: &mut Graph,
    problems: &mut Problems,
) -> Lowered {
    let mut lowering = Lowering {
        graph,
        problems,
        scope: Scope::default(),
        named: Vec::new(),
        rounds: 0,
        unreadable: false,
        exhausted: false,
    };
    let roots = lowering.item(item, expected);
    Lowered { roots, named: lowering.named }
}

impl Lowering<'_> {
    fn item(&mut self, item: &Item, expected: Expectation) -> Vec<Id> {
        let mut count = 0;
        for parameter in &item.parameters {
            let value = self.given(&parameter.shape, &mut count, Input::Parameter);
            self.define(&parameter.name, Role::Parameter, value, None);
        }
        count = 0;
        for variable in &item.variables {
            let value = self.given(&variable.shape, &mut count, Input::Variable);
            self.define(&variable.name, Role::Variable, value, None);
        }
        let Some(body) = &item.body else { return vec![] };
        let mut roots = Vec::new();
        self.equations(body, expected, &mut roots);
        self.scope.close(0);
        if !self.unreadable {
            self.scope.report_unused(self.problems, expected.every_variable);
        }
        roots
    }

    fn given(&mut self, shape: &[usize], count: &mut u32, input: fn(u32) -> Input) -> Value {
        if shape == UNKNOWN {
            return Value::Unknown;
        }
        match shape.split_first() {
            None => {
                *count += 1;
                Value::Number(self.graph.input(input(*count - 1)))
            }
            Some((&length, inner)) => {
                Value::Array((0..length).map(|_| self.given(inner, count, input)).collect())
            }
        }
    }

    fn define(&mut self, name: &Ident, role: Role, value: Value, exact: Option<Ratio>) {
        self.scope.define(self.problems, name, role, value, exact);
    }

    pub(crate) fn is_known(&mut self, name: &str) -> bool {
        self.scope.find(name).is_some()
    }

    pub(crate) fn wrong(&mut self, at: Extent, message: impl std::fmt::Display) -> Value {
        self.problems.note(at, message);
        Value::Unknown
    }

    /// Where equations may stand: the body, the end of its blocks, families and lists.
    fn equations(&mut self, expr: &Expr, expected: Expectation, roots: &mut Vec<Id>) {
        match &expr.kind {
            Kind::Family(binders, body) if expected.several => {
                self.each(binders, &mut |lowering| lowering.equations(body, expected, roots));
            }
            Kind::Array(list) if expected.several => {
                for equation in list {
                    self.equations(equation, expected, roots);
                }
                if list.is_empty() {
                    self.wrong(expr.extent, "there is no equation in this list");
                }
            }
            Kind::Block(lets, result) => {
                let start = self.lets(lets);
                if self.rounds == 0 {
                    self.named.extend(self.scope.numbers_from(start));
                }
                self.equations(result, expected, roots);
                self.scope.close(start);
            }
            Kind::Family(..) => {
                self.wrong(expr.extent, format!("found several expressions, expected {}", expected.noun));
            }
            _ => {
                let value = self.expression(expr);
                let mut numbers = Vec::new();
                if !value.numbers(&mut numbers) {
                    return;
                }
                if !expected.several && !matches!(value, Value::Number(_)) {
                    let advice = "use `dot`, `norm` or an index";
                    self.wrong(expr.extent, format!("found an array, expected {}; {advice}", expected.noun));
                    return;
                }
                if let Some(still) = numbers.iter().find(|&&id| !self.graph.moving(id)) {
                    let value = match self.graph.number(*still) {
                        Some(number) => format!("it is always {number}"),
                        None => "it holds parameters only".to_owned(),
                    };
                    self.wrong(expr.extent, format!("{} depends on no variable; {value}", expected.noun));
                    self.unreadable = true; // then nothing is used, and that is no news
                }
                roots.extend(numbers);
            }
        }
    }

    fn lets(&mut self, lets: &[crate::syntax::Let]) -> usize {
        let start = self.scope.len();
        for binding in lets {
            let value = self.expression(&binding.value);
            let exact = self.ratio(&binding.value);
            self.define(&binding.name, Role::Let, value, exact);
        }
        start
    }

    /// Runs the body for every value of the indices.
    fn each(&mut self, binders: &[Binder], body: &mut dyn FnMut(&mut Self)) {
        let Some((binder, rest)) = binders.split_first() else { return body(self) };
        let (Some(from), Some(to)) = (self.whole(&binder.from), self.whole(&binder.to)) else { return };
        let to = if binder.inclusive { to.saturating_add(1) } else { to };
        let start = self.scope.len();
        for index in from..to {
            self.rounds += 1;
            if self.exhausted || self.rounds > LARGEST {
                if !self.exhausted {
                    self.wrong(binder.from.extent.to(binder.to.extent), TOO_LARGE);
                }
                self.exhausted = true;
                break;
            }
            let value = Value::Number(self.graph.constant(index as f64));
            self.define(&binder.index, Role::Index, value, Some(Ratio::from(index)));
            self.each(rest, body);
            self.scope.close(start);
        }
    }

    /// A whole number known when the macro runs.
    pub(crate) fn whole(&mut self, expr: &Expr) -> Option<i64> {
        match self.ratio(expr) {
            Some(ratio) => match ratio.whole() {
                Some(whole) => Some(whole),
                None => {
                    self.wrong(expr.extent, format!("expected a whole number, found {ratio}"));
                    None
                }
            },
            None => {
                if !matches!(self.expression(expr), Value::Unknown) {
                    let message =
                        "expected a constant index: a whole number or the index of a `sum` or `for`";
                    self.wrong(expr.extent, message);
                }
                None
            }
        }
    }

    /// An exact constant of numbers and indices alone.
    pub(crate) fn ratio(&mut self, expr: &Expr) -> Option<Ratio> {
        match &expr.kind {
            Kind::Number(_, digits) => Ratio::parse(digits),
            Kind::Name(name) => {
                let name = name.to_string();
                self.scope.find(&name).and_then(|binding| binding.exact)
            }
            Kind::Negative(inner) => self.ratio(inner)?.negative(),
            Kind::Block(lets, inner) if lets.is_empty() => self.ratio(inner),
            Kind::Power(base, exponent) => {
                let (base, exponent) = (self.ratio(base)?, self.ratio(exponent)?.whole()?);
                base.power(exponent)
            }
            Kind::Chain(first, rest) => {
                let mut result = self.ratio(first)?;
                for (operator, operand) in rest {
                    let operand = self.ratio(operand)?;
                    result = match operator {
                        Operator::Add => result.plus(operand),
                        Operator::Sub => operand.negative().and_then(|operand| result.plus(operand)),
                        Operator::Mul => result.times(operand),
                        Operator::Div => operand.reciprocal().and_then(|operand| result.times(operand)),
                        _ => None,
                    }?;
                }
                Some(result)
            }
            _ => None,
        }
    }

    pub(crate) fn expression(&mut self, expr: &Expr) -> Value {
        if self.graph.len() > LARGEST {
            if !self.exhausted {
                self.wrong(expr.extent, TOO_LARGE);
            }
            self.exhausted = true;
            return Value::Unknown;
        }
        match &expr.kind {
            Kind::Wrong => {
                self.unreadable = true;
                Value::Unknown
            }
            Kind::Number(value, _) => Value::Number(self.graph.constant(*value)),
            Kind::Name(name) => self.name(name, expr.extent),
            Kind::Negative(inner) => {
                let inner = self.expression(inner);
                self.map(&inner, &mut |lowering, id| lowering.graph.neg(id))
            }
            Kind::Chain(first, rest) => self.chain(first, rest, expr.extent),
            Kind::Power(base, exponent) => self.power(base, exponent),
            Kind::Call(name, arguments) => self.call(name, arguments, expr.extent),
            Kind::Fold(operator, binders, body) => self.fold(*operator, binders, body),
            Kind::Index(array, index) => self.index(array, index),
            Kind::Block(lets, result) => {
                let start = self.lets(lets);
                let value = self.expression(result);
                self.scope.close(start);
                value
            }
            Kind::If(condition, then, other) => self.branch(condition, then, other, expr.extent),
            Kind::Array(list) => {
                let list: Rc<[Value]> = list.iter().map(|element| self.expression(element)).collect();
                let value = Value::Array(list);
                let mut numbers = Vec::new();
                if value.numbers(&mut numbers) && value.shape().is_none() {
                    return self.wrong(expr.extent, "the elements of this array differ in shape");
                }
                value
            }
            Kind::Family(..) => {
                self.wrong(expr.extent, "`for` makes equations, not a number; use `sum(i in 0..3, …)`")
            }
        }
    }

    fn name(&mut self, name: &Ident, at: Extent) -> Value {
        let text = name.to_string();
        if let Some(binding) = self.scope.find(&text) {
            return binding.value.clone();
        }
        if let Some((_, value, _)) = CONSTANTS.iter().find(|(constant, ..)| *constant == text) {
            return Value::Number(self.graph.constant(*value));
        }
        self.unreadable = true; // whatever seems unused may have been meant
        let is_function = self.is_function(&text);
        self.scope.unknown(self.problems, at, &text, is_function);
        Value::Unknown
    }

    /// Applies an operation to every number in the value.
    pub(crate) fn map(&mut self, value: &Value, operation: &mut dyn FnMut(&mut Self, Id) -> Id) -> Value {
        match value {
            Value::Unknown => Value::Unknown,
            Value::Number(id) => Value::Number(operation(self, *id)),
            Value::Array(list) => {
                Value::Array(list.iter().map(|element| self.map(element, operation)).collect())
            }
        }
    }

    /// Applies an operation to the numbers of two values of one shape.
    fn zip(&mut self, a: &Value, b: &Value, operation: &mut dyn FnMut(&mut Self, Id, Id) -> Id) -> Value {
        match (a, b) {
            (Value::Number(a), Value::Number(b)) => Value::Number(operation(self, *a, *b)),
            (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
                Value::Array(a.iter().zip(b.iter()).map(|(a, b)| self.zip(a, b, operation)).collect())
            }
            _ => Value::Unknown,
        }
    }

    fn chain(&mut self, first: &Expr, rest: &[(Operator, Expr)], at: Extent) -> Value {
        let mut left = self.expression(first);
        for (operator, operand) in rest {
            let right = self.expression(operand);
            let extent = first.extent.to(operand.extent);
            left = self.combine(*operator, left, right, operand.extent, extent, at);
        }
        left
    }

    fn combine(
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
        let operation = |lowering: &mut Self, a: Id, b: Id| match operator {
            Add => lowering.graph.add(a, b),
            Sub => lowering.graph.sub(a, b),
            Mul => lowering.graph.mul(a, b),
            _ => lowering.graph.div(a, b),
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
                self.map(&left, &mut |lowering, element| operation(lowering, element, *number))
            }
            (Value::Number(number), Value::Array(_)) if operator == Mul => {
                self.map(&right, &mut |lowering, element| operation(lowering, *number, element))
            }
            _ if a == b => self.zip(&left, &right, &mut |lowering, a, b| operation(lowering, a, b)),
            _ => {
                let (a, b) = (described(&a), described(&b));
                self.wrong(extent, format!("`{}` of {a} and {b}; the shapes must agree", operator.symbol()))
            }
        }
    }

    fn index(&mut self, array: &Expr, index: &Expr) -> Value {
        let place = self.whole(index);
        match self.expression(array) {
            Value::Unknown => Value::Unknown,
            Value::Number(_) => {
                self.wrong(array.extent, "this is a number, so it has no components; leave the index out")
            }
            Value::Array(list) => match place {
                None => Value::Unknown,
                Some(place) => match usize::try_from(place).ok().filter(|&place| place < list.len()) {
                    Some(place) => list[place].clone(),
                    None => {
                        let last = list.len() - 1;
                        self.wrong(index.extent, format!("the index is {place}, expected 0 to {last}"))
                    }
                },
            },
        }
    }

    fn fold(&mut self, operator: Operator, binders: &[Binder], body: &Expr) -> Value {
        let mut total: Option<Value> = None;
        self.each(binders, &mut |lowering| {
            let next = lowering.expression(body);
            let extent = body.extent;
            total = Some(match total.take() {
                None => next,
                Some(sum) => lowering.combine(operator, sum, next, extent, extent, extent),
            });
        });
        match total {
            Some(total) => total,
            None if self.problems.any() => Value::Unknown,
            None => Value::Number(self.graph.constant(if operator == Operator::Mul { 1.0 } else { 0.0 })),
        }
    }

    fn branch(&mut self, condition: &Expr, then: &Expr, other: &Expr, at: Extent) -> Value {
        if let Some(known) = self.decided(condition) {
            return self.expression(if known { then } else { other }); // the other may index out of bounds
        }
        let condition = self.condition(condition);
        let (then, other) = (self.expression(then), self.expression(other));
        let (Some(a), Some(b)) = (then.shape(), other.shape()) else { return Value::Unknown };
        if a != b {
            let (a, b) = (described(&a), described(&b));
            return self.wrong(at, format!("one branch is {a}, the other {b}; the shapes must agree"));
        }
        match condition {
            None => Value::Unknown,
            Some(condition) => {
                self.zip(&then, &other, &mut |lowering, then, other| lowering.select(&condition, then, other))
            }
        }
    }

    /// The outcome, where indices and numbers alone decide it: one part that is false decides `&&`.
    fn decided(&mut self, condition: &Expr) -> Option<bool> {
        let Kind::Chain(first, rest) = &condition.kind else { return None };
        let (operator, operand) = rest.first()?;
        if let Operator::And | Operator::Or = operator {
            let settles = *operator == Operator::Or;
            let outcomes: Vec<Option<bool>> = parts(first, rest).map(|part| self.decided(part)).collect();
            return match outcomes.contains(&Some(settles)) {
                true => Some(settles),
                false => outcomes.iter().all(Option::is_some).then_some(!settles),
            };
        }
        let order = self.ratio(first)?.compare(self.ratio(operand)?);
        match operator {
            Operator::Less => Some(order.is_lt()),
            Operator::LessOrEqual => Some(order.is_le()),
            Operator::Greater => Some(order.is_gt()),
            Operator::GreaterOrEqual => Some(order.is_ge()),
            Operator::Equal => Some(order.is_eq()),
            _ => None,
        }
    }

    /// What is left to compare at run time. Parts that are decided are dropped unseen: in
    /// `i > 0 && x[i - 1] > 0` the second part has no meaning where the first is false.
    fn condition(&mut self, expr: &Expr) -> Option<Condition> {
        if let Kind::Chain(first, rest) = &expr.kind
            && let Some((operator, operand)) = rest.first()
        {
            match operator {
                Operator::And | Operator::Or => {
                    let open: Vec<&Expr> =
                        parts(first, rest).filter(|part| self.decided(part).is_none()).collect();
                    // All of them, for their messages, before the first that is wrong ends it.
                    let open: Vec<Option<Condition>> =
                        open.into_iter().map(|part| self.condition(part)).collect();
                    let open = open.into_iter().collect::<Option<Vec<Condition>>>()?;
                    return Some(match operator {
                        Operator::And => Condition::All(open),
                        _ => Condition::Any(open),
                    });
                }
                Operator::Less | Operator::LessOrEqual | Operator::Greater | Operator::GreaterOrEqual => {
                    return match [self.expression(first), self.expression(operand)] {
                        [Value::Number(a), Value::Number(b)] => Some(match operator {
                            Operator::Less => Condition::Compare(Comparison::Less, a, b),
                            Operator::LessOrEqual => Condition::Compare(Comparison::LessOrEqual, a, b),
                            Operator::Greater => Condition::Compare(Comparison::Less, b, a),
                            _ => Condition::Compare(Comparison::LessOrEqual, b, a),
                        }),
                        [Value::Unknown, _] | [_, Value::Unknown] => None,
                        _ => {
                            self.wrong(
                                expr.extent,
                                "arrays have no order; compare their norms or components",
                            );
                            None
                        }
                    };
                }
                Operator::Equal => {
                    self.wrong(expr.extent, "`==` of real numbers is rarely true; compare with `<` or `<=`");
                    self.unreadable = true;
                    return None;
                }
                _ => {}
            }
        }
        if !matches!(expr.kind, Kind::Wrong) {
            self.wrong(expr.extent, "expected a comparison, as in `x < 1`");
        }
        self.unreadable = true;
        None
    }

    /// One selection per comparison, nested: `a && b && c` chooses by c inside b inside a.
    fn select(&mut self, condition: &Condition, then: Id, other: Id) -> Id {
        match condition {
            Condition::Compare(comparison, a, b) => self.graph.select(*comparison, *a, *b, then, other),
            Condition::All(parts) => {
                parts.iter().rev().fold(then, |then, part| self.select(part, then, other))
            }
            Condition::Any(parts) => {
                parts.iter().rev().fold(other, |other, part| self.select(part, then, other))
            }
        }
    }
}

/// A condition on numbers that are known at run time only.
enum Condition {
    Compare(Comparison, Id, Id),
    All(Vec<Condition>),
    Any(Vec<Condition>),
}

/// The operands of a chain.
fn parts<'a>(first: &'a Expr, rest: &'a [(Operator, Expr)]) -> impl Iterator<Item = &'a Expr> {
    std::iter::once(first).chain(rest.iter().map(|(_, part)| part))
}

pub(crate) fn described(shape: &[usize]) -> String {
    match shape {
        [] => "a number".to_owned(),
        [n] => format!("an array of {n}"),
        [m, n] => format!("a matrix of {m} × {n}"),
        _ => format!("an array of {}", shape.iter().map(|n| n.to_string()).collect::<Vec<_>>().join(" × ")),
    }
}

const TOO_LARGE: &str = "the expression has more than half a million operations; write it with fewer terms";
