//! Formulas for the generated documentation: as written, and the gradient as found.

use crate::algebra::Scaled;
use crate::functions::Binary;
use crate::graph::Graph;
use crate::node::{Comparison, Id, Input, Node};
use crate::syntax::{Binder, Expr, Item, Kind, Operator};
use std::collections::HashMap;

/// Longer formulas are not shown: nobody reads them.
const LONGEST: usize = 240;

/// How tightly the outermost operation of a text binds.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Tightness {
    Choice,
    Or,
    And,
    Comparison,
    Sum,
    Product,
    Sign,
    Power,
    Atom,
}

/// The lines of the expression as written: one per `let`, the last is the value.
pub(crate) fn written(item: &Item, name: &str) -> Vec<String> {
    let mut lines = Vec::new();
    let mut body = item.body.as_ref();
    while let Some(Expr { kind: Kind::Block(lets, result), .. }) = body {
        lines.extend(lets.iter().map(|binding| format!("{} = {}", binding.name, text(&binding.value).0)));
        body = Some(result);
    }
    if let Some(body) = body {
        lines.push(format!("{name} = {}", text(body).0));
    }
    lines.into_iter().map(shortened).collect()
}

fn shortened(line: String) -> String {
    match line.char_indices().nth(4 * LONGEST) {
        Some((end, _)) => format!("{} …", &line[..end]),
        None => line,
    }
}

fn text(expr: &Expr) -> (String, Tightness) {
    match &expr.kind {
        Kind::Wrong => ("…".to_owned(), Tightness::Atom),
        Kind::Number(_, digits) => (digits.clone(), Tightness::Atom),
        Kind::Name(name) => (name.to_string(), Tightness::Atom),
        Kind::Negative(inner) => (format!("-{}", inside(inner, Tightness::Sign)), Tightness::Sign),
        Kind::Power(base, exponent) => {
            let exponent = inside(exponent, Tightness::Sign);
            (format!("{}^{exponent}", inside(base, Tightness::Atom)), Tightness::Power)
        }
        Kind::Chain(first, rest) => chain(first, rest),
        Kind::Call(name, arguments) => (format!("{name}({})", list(arguments)), Tightness::Atom),
        Kind::Fold(operator, binders, body) => {
            let name = if *operator == Operator::Mul { "product" } else { "sum" };
            (format!("{name}({}, {})", ranges(binders), text(body).0), Tightness::Atom)
        }
        Kind::Index(array, index) => {
            (format!("{}[{}]", inside(array, Tightness::Atom), text(index).0), Tightness::Atom)
        }
        Kind::Block(lets, result) if lets.is_empty() => text(result),
        Kind::Block(lets, result) => {
            let lets: String =
                lets.iter().map(|b| format!("let {} = {}; ", b.name, text(&b.value).0)).collect();
            (format!("{{ {lets}{} }}", text(result).0), Tightness::Atom)
        }
        Kind::If(condition, then, other) => {
            let parts = [condition, then, other].map(|part| text(part).0);
            (format!("if {} {{ {} }} else {{ {} }}", parts[0], parts[1], parts[2]), Tightness::Choice)
        }
        Kind::Family(binders, body) => {
            (format!("{} for {}", text(body).0, ranges(binders)), Tightness::Choice)
        }
        Kind::Array(elements) => (format!("[{}]", list(elements)), Tightness::Atom),
    }
}

fn chain(first: &Expr, rest: &[(Operator, Expr)]) -> (String, Tightness) {
    let own = match rest.first() {
        Some((Operator::Add | Operator::Sub, _)) => Tightness::Sum,
        Some((Operator::Mul | Operator::Div, _)) => Tightness::Product,
        Some((Operator::Or, _)) => Tightness::Or,
        Some((Operator::And, _)) => Tightness::And,
        _ => Tightness::Comparison,
    };
    let (mut result, tightness) = text(first);
    if tightness < own {
        result = format!("({result})");
    }
    for (operator, operand) in rest {
        let (operand, tightness) = text(operand);
        let operand = if tightness <= own { format!("({operand})") } else { operand };
        result.extend([" ", operator.symbol(), " ", &operand]);
    }
    (result, own)
}

fn inside(expr: &Expr, least: Tightness) -> String {
    let (text, tightness) = text(expr);
    if tightness < least { format!("({text})") } else { text }
}

fn list(elements: &[Expr]) -> String {
    elements.iter().map(|element| text(element).0).collect::<Vec<_>>().join(", ")
}

fn ranges(binders: &[Binder]) -> String {
    let range = |b: &Binder| {
        let dots = if b.inclusive { "..=" } else { ".." };
        format!("{} in {}{dots}{}", b.index, text(&b.from).0, text(&b.to).0)
    };
    binders.iter().map(range).collect::<Vec<_>>().join(", ")
}

/// The names of the inputs, by their numbers.
pub(crate) struct Names {
    parameters: Vec<String>,
    variables: Vec<String>,
    /// What a `let` names, the first of several.
    named: HashMap<Id, String>,
}

impl Names {
    pub(crate) fn of(item: &Item, lets: Vec<(Id, String)>) -> Names {
        let mut names = Names { parameters: vec![], variables: vec![], named: HashMap::new() };
        for (id, name) in lets {
            names.named.entry(id).or_insert(name);
        }
        for parameter in &item.parameters {
            components(parameter.name.to_string(), &parameter.shape, &mut names.parameters);
        }
        for variable in &item.variables {
            components(variable.name.to_string(), &variable.shape, &mut names.variables);
        }
        names
    }

    /// The variable's component of that number.
    pub(crate) fn variable(&self, k: usize) -> &str {
        self.variables.get(k).map_or("", String::as_str)
    }

    fn name(&self, input: Input) -> String {
        let found = match input {
            Input::Parameter(k) => self.parameters.get(k as usize),
            Input::Variable(k) => self.variables.get(k as usize),
            _ => None,
        };
        found.cloned().unwrap_or_default()
    }
}

/// The names of the numbers of an array.
pub(crate) fn components(name: String, shape: &[usize], into: &mut Vec<String>) {
    match shape.split_first() {
        None => into.push(name),
        Some((&length, inner)) => {
            for i in 0..length {
                components(format!("{name}[{i}]"), inner, into);
            }
        }
    }
}

/// What was found, in the language of the macros; none if it is long.
pub(crate) fn formula(graph: &Graph, scaled: Scaled, names: &Names) -> Option<String> {
    let Some(root) = scaled.node else { return Some(scaled.factor.to_string()) };
    let mut texts: Vec<Option<(String, Tightness)>> = vec![None; graph.len()];
    for id in graph.reachable(&[root]) {
        let name = match graph.node(id) {
            Node::Input(_) | Node::Constant(_) => None,
            _ => names.named.get(&id).map(|name| (name.clone(), Tightness::Atom)),
        };
        let found = name.or_else(|| node(graph, id, &|id| texts[id.index()].clone(), names));
        texts[id.index()] = found.filter(|(text, _)| text.len() <= LONGEST);
    }
    let (text, tightness) = texts[root.index()].take()?;
    Some(if scaled.factor == 1.0 { text } else { multiple(scaled.factor, &text, tightness) })
}

fn multiple(factor: f64, text: &str, tightness: Tightness) -> String {
    let text = if tightness < Tightness::Product { format!("({text})") } else { text.to_owned() };
    if factor == 1.0 {
        text
    } else if factor == -1.0 {
        format!("-{text}")
    } else {
        format!("{factor} * {text}")
    }
}

fn node(
    graph: &Graph,
    id: Id,
    of: &dyn Fn(Id) -> Option<(String, Tightness)>,
    names: &Names,
) -> Option<(String, Tightness)> {
    let at = |id: Id, least: Tightness| {
        let (text, tightness) = of(id)?;
        Some(if tightness < least { format!("({text})") } else { text })
    };
    let (sum, product) = (Tightness::Sum, Tightness::Product);
    Some(match *graph.node(id) {
        Node::Constant(bits) => {
            let number = f64::from_bits(bits);
            (number.to_string(), if number < 0.0 { Tightness::Sign } else { Tightness::Atom })
        }
        Node::Input(input) => (names.name(input), Tightness::Atom),
        Node::Neg(a) => (format!("-{}", at(a, Tightness::Power)?), Tightness::Sign),
        Node::Add(a, b) => (format!("{} + {}", at(a, sum)?, at(b, product)?), sum),
        Node::Sub(a, b) if graph.as_constant(b).is_some_and(|number| number < 0.0) => {
            (format!("{} + {}", at(a, sum)?, -graph.as_constant(b)?), sum)
        }
        Node::Sub(a, b) => (format!("{} - {}", at(a, sum)?, at(b, product)?), sum),
        Node::Mul(a, b) => (format!("{} * {}", at(a, product)?, at(b, Tightness::Sign)?), product),
        Node::Div(a, b) => (format!("{} / {}", at(a, product)?, at(b, Tightness::Power)?), product),
        Node::Power(a, -2) => (format!("1 / {}", at(a, Tightness::Power)?), product),
        Node::Power(a, n) => {
            let exponent = if n % 2 == 0 { (n / 2).to_string() } else { format!("({n}/2)") };
            (format!("{}^{exponent}", at(a, Tightness::Atom)?), Tightness::Power)
        }
        Node::Call(function, a) => (format!("{}({})", function.name(), of(a)?.0), Tightness::Atom),
        Node::Call2(Binary::Powf, a, b) => {
            (format!("{}^{}", at(a, Tightness::Atom)?, at(b, Tightness::Atom)?), Tightness::Power)
        }
        Node::Call2(function, a, b) => {
            (format!("{}({}, {})", function.name(), of(a)?.0, of(b)?.0), Tightness::Atom)
        }
        Node::Select(_, a, b, then, other) if (then, other) == (b, a) => {
            (format!("max({}, {})", of(a)?.0, of(b)?.0), Tightness::Atom)
        }
        Node::Select(_, a, b, then, other) if (then, other) == (a, b) => {
            (format!("min({}, {})", of(b)?.0, of(a)?.0), Tightness::Atom)
        }
        Node::Select(comparison, a, b, then, other) => {
            let symbol = if comparison == Comparison::Less { "<" } else { "<=" };
            let [a, b, then, other] = [of(a)?.0, of(b)?.0, of(then)?.0, of(other)?.0];
            (format!("if {a} {symbol} {b} {{ {then} }} else {{ {other} }}"), Tightness::Choice)
        }
        Node::Sum(ref terms) => {
            let mut text = String::new();
            for &(bits, term) in terms.iter().take(LONGEST) {
                let (inner, tightness) = of(term)?;
                let factor = f64::from_bits(bits);
                let sign = match (text.is_empty(), factor < 0.0) {
                    (true, true) => "-",
                    (true, false) => "",
                    (false, true) => " - ",
                    (false, false) => " + ",
                };
                text.extend([sign, &multiple(factor.abs(), &inner, tightness)]);
            }
            (text, sum)
        }
        Node::Product(ref factors) => {
            let mut parts = Vec::new();
            for &(factor, exponent) in factors {
                parts.push(match exponent {
                    1 => at(factor, product)?,
                    _ => format!("{}^{exponent}", at(factor, Tightness::Atom)?),
                });
            }
            (parts.join(" * "), product)
        }
    })
}
