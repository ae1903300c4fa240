//! Syntax to graph, checking everything on the way.
//!
//! Names, indices and loops live only here: they are worked out, and what reaches the graph are numbers.

use crate::arithmetic::{Arithmetic, Condition};
use crate::call::{Callee, Exponent};
use crate::graph::Graph;
use crate::limits::{MOST, STEPS, TooLarge};
use crate::macros::Expectation;
use crate::names::{CONSTANTS, Role, Scope};
use crate::node::{Comparison, Id, Input};
use crate::problems::{Extent, Problems, rounded};
use crate::ratio::Ratio;
use crate::syntax::{Binder, Expr, Item, Kind, Let, Operator, UNKNOWN};
use crate::value::{Value, described};
use proc_macro2::Ident;
use std::rc::Rc;

/// Numbers from here on are no indices.
const LARGE: f64 = (1_u64 << 62) as f64;

struct Lowering<'a> {
    graph: &'a mut Graph,
    problems: &'a mut Problems,
    scope: Scope,
    /// What the `let`s around the equations are, outside of loops.
    named: Vec<(Id, String)>,
    /// How many roots there are up to each element of the outermost list.
    parts: Vec<usize>,
    in_list: bool,
    /// Loops that are open.
    loops: usize,
    /// Expressions read so far, in every round of a loop.
    steps: usize,
    /// Whether something could not be read, so that what seems unused may have been meant.
    unreadable: bool,
    exhausted: bool,
    /// What to say to who writes the time.
    of_time: &'static str,
}

/// What an item comes to.
pub(crate) struct Lowered {
    /// One per equation.
    pub(crate) roots: Vec<Id>,
    /// The numbers that have names, for the documentation.
    pub(crate) named: Vec<(Id, String)>,
    /// How many roots there are up to each element of the outermost list.
    pub(crate) parts: Vec<usize>,
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
        parts: Vec::new(),
        in_list: false,
        loops: 0,
        steps: 0,
        unreadable: false,
        exhausted: false,
        of_time: expected.of_time,
    };
    let roots = lowering.item(item, expected);
    Lowered { roots, named: lowering.named, parts: lowering.parts }
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
        if roots.is_empty() && !self.problems.any() {
            self.wrong(body.extent, "there is no equation: the ranges of its loops are empty");
            self.unreadable = true; // then what it is made of is used, as far as one knows
        }
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

    fn arithmetic(&mut self) -> Arithmetic<'_> {
        Arithmetic { graph: self.graph, problems: self.problems }
    }

    fn wrong(&mut self, at: Extent, message: impl std::fmt::Display) -> Value {
        self.arithmetic().wrong(at, message)
    }

    /// Where equations may stand: the body, the end of its blocks, families and lists.
    fn equations(&mut self, expr: &Expr, expected: Expectation, roots: &mut Vec<Id>) {
        match &expr.kind {
            Kind::Family(binders, body) if expected.several => {
                self.each(binders, &mut |lowering| lowering.equations(body, expected, roots));
            }
            Kind::Array(list) if expected.several => {
                let outermost = !std::mem::replace(&mut self.in_list, true);
                for equation in list {
                    self.equations(equation, expected, roots);
                    if outermost {
                        self.parts.push(roots.len());
                    }
                }
                if list.is_empty() {
                    self.wrong(expr.extent, "there is no equation in this list");
                }
            }
            Kind::Block(lets, result) => {
                let start = self.lets(lets);
                if self.loops == 0 {
                    self.named.extend(self.scope.numbers_from(start));
                }
                self.equations(result, expected, roots);
                self.scope.close(start);
            }
            Kind::Family(..) => {
                self.wrong(expr.extent, format!("found several expressions, expected {}", expected.noun));
                self.unreadable = true;
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
                if let Some(still) = numbers.iter().find(|&&id| !self.graph.moving(id) && !expected.constant)
                {
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

    fn lets(&mut self, lets: &[Let]) -> usize {
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
        let (Some(from), Some(to)) = (self.whole(&binder.from), self.whole(&binder.to)) else {
            self.unreadable = true;
            return;
        };
        if let (Kind::Number(_, first), Kind::Number(_, last), true) =
            (&binder.from.kind, &binder.to.kind, from > to)
        {
            let message = format!("the range from {first} to {last} is empty; ranges run upwards");
            self.wrong(binder.from.extent.to(binder.to.extent), message);
            self.unreadable = true;
            return;
        }
        let last = if binder.inclusive { Some(to) } else { to.checked_sub(1) };
        let start = self.scope.len();
        for index in last.into_iter().flat_map(|last| from..=last) {
            if self.exhausted(binder.from.extent.to(binder.to.extent)) {
                break;
            }
            let value = Value::Number(self.graph.constant(index as f64));
            self.define(&binder.index, Role::Index, value, Some(Ratio::from(index)));
            self.loops += 1;
            self.each(rest, body);
            self.loops -= 1;
            self.scope.close(start);
        }
    }

    /// A whole number known when the macro runs.
    fn whole(&mut self, expr: &Expr) -> Option<i64> {
        if let Kind::Number(_, digits) = &expr.kind
            && digits.contains('.')
        {
            self.wrong(expr.extent, format!("expected a whole number, found {digits}"));
            return None;
        }
        match self.ratio(expr) {
            Some(ratio) => match ratio.whole() {
                Some(whole) => Some(whole),
                None => {
                    self.wrong(expr.extent, format!("expected a whole number, found {ratio}"));
                    None
                }
            },
            None => {
                let message = match self.expression(expr) {
                    Value::Unknown => return None,
                    Value::Number(id)
                        if self.graph.number(id).is_some_and(|number| number.abs() >= LARGE) =>
                    {
                        let found = rounded(self.graph.number(id).unwrap_or(LARGE));
                        format!("expected a whole number below {}, found {found}", rounded(LARGE))
                    }
                    _ => "expected a constant index: a whole number or the index of a `sum` or `for`"
                        .to_owned(),
                };
                self.wrong(expr.extent, message);
                None
            }
        }
    }

    /// An exact constant of numbers and indices alone.
    fn ratio(&mut self, expr: &Expr) -> Option<Ratio> {
        self.steps += 1;
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

    /// Whether this has become too much; noted once, where it did.
    fn exhausted(&mut self, at: Extent) -> bool {
        if self.exhausted {
            return true;
        }
        let operations = self.graph.len();
        self.exhausted = operations > MOST || self.steps.saturating_add(self.graph.steps()) > STEPS;
        if operations > MOST {
            self.wrong(at, TooLarge { written: None, found: operations });
        } else if self.exhausted {
            let message = format!(
                "reading the expression takes more than {STEPS} steps; write it with shorter loops and smaller arrays"
            );
            self.wrong(at, message);
        }
        self.exhausted
    }

    /// Counts the numbers of an array; whether they have become too many.
    fn takes(&mut self, numbers: usize, at: Extent) -> bool {
        self.steps = self.steps.saturating_add(numbers);
        self.exhausted(at)
    }

    fn expression(&mut self, expr: &Expr) -> Value {
        self.steps += 1;
        if self.exhausted(expr.extent) {
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
                self.arithmetic().map(&inner, &|graph, id| graph.neg(id))
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
                if list.is_empty() {
                    return self.wrong(expr.extent, "there is nothing in this array");
                }
                let list: Rc<[Value]> = list.iter().map(|element| self.expression(element)).collect();
                let value = Value::Array(list);
                if self.takes(value.size(), expr.extent) {
                    return Value::Unknown;
                }
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
        self.unreadable = true;
        let about = match &text[..] {
            _ if Callee::named(&text).is_some() => {
                format!("; the function `{text}` needs its argument in parentheses")
            }
            "t" | "time" => format!("; {}", self.of_time),
            _ => String::new(),
        };
        self.scope.unknown(self.problems, at, &text, &about);
        Value::Unknown
    }

    fn call(&mut self, name: &Ident, arguments: &[Expr], at: Extent) -> Value {
        let text = name.to_string();
        let callee = Callee::named(&text);
        match (callee, arguments) {
            (Some(Callee::Pow), [base, exponent]) => return self.power(base, exponent),
            (Some(Callee::Delta), [i, j]) => return self.delta(i, j),
            _ => {}
        }
        let values: Vec<(Value, Extent)> =
            arguments.iter().map(|argument| (self.expression(argument), argument.extent)).collect();
        match callee {
            Some(callee) => self.arithmetic().call(callee, name, &values, at),
            None => self.unknown_function(name, &text),
        }
    }

    fn unknown_function(&mut self, name: &Ident, text: &str) -> Value {
        let at = self.problems.extent_of(name);
        if text == "sum" || text == "product" {
            return self
                .wrong(at, format!("`{text}` is written with an index, as in `{text}(i in 0..3, q[i])`"));
        }
        if let Some(instead) = Callee::instead_of(text) {
            return self.wrong(at, format!("unknown function `{text}`; write {instead}"));
        }
        if self.scope.find(text).is_some() {
            let message = format!("`{text}` is no function; a product is written `{text} * (…)`");
            return self.wrong(at, message);
        }
        self.unreadable = true;
        self.wrong(at, Callee::unknown(text))
    }

    fn delta(&mut self, i: &Expr, j: &Expr) -> Value {
        let (i, j) = (self.whole(i), self.whole(j));
        match (i, j) {
            (Some(i), Some(j)) => Value::Number(self.graph.constant(if i == j { 1.0 } else { 0.0 })),
            _ => Value::Unknown,
        }
    }

    fn power(&mut self, base: &Expr, exponent: &Expr) -> Value {
        let value = self.expression(base);
        let power = match self.ratio(exponent) {
            Some(ratio) => Exponent::Exact(ratio),
            None => Exponent::Value(self.expression(exponent)),
        };
        self.arithmetic().power((value, base.extent), (power, exponent.extent))
    }

    fn chain(&mut self, first: &Expr, rest: &[(Operator, Expr)], at: Extent) -> Value {
        let mut left = self.expression(first);
        for (operator, operand) in rest {
            let right = self.expression(operand);
            let extent = first.extent.to(operand.extent);
            left = self.arithmetic().combine(*operator, left, right, operand.extent, extent, at);
        }
        left
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
                Some(sum) => lowering.arithmetic().combine(operator, sum, next, extent, extent, extent),
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
        if self.takes(then.size(), at) {
            return Value::Unknown;
        }
        let (Some(a), Some(b)) = (then.shape(), other.shape()) else { return Value::Unknown };
        if a != b {
            let (a, b) = (described(&a), described(&b));
            return self.wrong(at, format!("one branch is {a}, the other {b}; the shapes must agree"));
        }
        match condition {
            None => Value::Unknown,
            Some(condition) => self.arithmetic().choose(&condition, &then, &other),
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
            Operator::NotEqual => Some(order.is_ne()),
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
                Operator::Equal | Operator::NotEqual => {
                    let (symbol, rarely) =
                        (operator.symbol(), if *operator == Operator::Equal { "true" } else { "false" });
                    let message =
                        format!("`{symbol}` of real numbers is rarely {rarely}; compare with `<` or `<=`");
                    self.wrong(expr.extent, message);
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
}

/// The operands of a chain.
fn parts<'a>(first: &'a Expr, rest: &'a [(Operator, Expr)]) -> impl Iterator<Item = &'a Expr> {
    std::iter::once(first).chain(rest.iter().map(|(_, part)| part))
}
