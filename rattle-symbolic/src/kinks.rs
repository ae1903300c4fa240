//! Where equations are not smooth: what changes its sign there.
//!
//! ```text
//! abs(a), sign(a), cbrt(a), if a < 0 …      a
//! min(a, b), max(a, b), if a < b …          a − b, or b − a
//! floor(a), mod(a, w) = a − w floor(a/w)    the lowest binary digits of floor(a), as signs
//! atan2(a, b)                               a, where b is negative: the angle jumps by 2π
//! atan(a), exp(a), sin(a), atan2(a, b) …    what is divided by in them: they jump where it is zero
//! √(k a²), (k a⁴)^¼, (a²)ⁿ, hypot(a, k a)   a: they are multiples of |a|
//! √(k a² + c), hypot(a, c)                  a, where c is smaller than k a²: for c = 0 that is an edge
//! ```
//!
//! What is under another square root does not change its sign where g is a number. Edges where it touches zero, as that
//! of √(a² − 2a + 1), are not seen, nor are those of acos(cos(a)) and exp(ln(a²)/2).

use crate::factors::{Factor, Factors};
use crate::functions::{Binary, Function};
use crate::graph::{Graph, found_from};
use crate::node::{Comparison, Id, Node};
use std::collections::BTreeSet;

/// So many binary digits of a floor are compared: a step over fewer than 2³ jumps is seen.
const DIGITS: i32 = 3;

/// So deep a sum is looked through for what it goes to and fro about.
const TERMS: usize = 16;

/// What changes its sign where equations are not smooth.
pub(crate) struct Kink {
    pub(crate) changes: Id,
    /// What users are told of it.
    pub(crate) shown: Id,
}

impl From<Id> for Kink {
    fn from(changes: Id) -> Self {
        Self { changes, shown: changes }
    }
}

/// The kinks of these equations, each once.
pub(crate) fn kinks(graph: &mut Graph, roots: &[Id]) -> Vec<Kink> {
    let (mut list, mut listed, mut seen) = (Vec::new(), BTreeSet::new(), Seen::default());
    let all = graph.reachable(roots);
    let parts: BTreeSet<Id> = all.iter().flat_map(|&id| graph.node(id).children()).collect();
    for id in all {
        if matches!(graph.node(id), Node::Call2(Binary::Atan2, ..)) && !parts.contains(&id) {
            continue; // an angle that is to be 0 is not where it jumps
        }
        for kink in of_node(graph, id, &mut seen) {
            if graph.moving(kink.changes) && listed.insert(kink.changes) {
                list.push(kink);
            }
        }
    }
    // What is listed wherever it changes its sign is not listed once more for where it matters.
    list.retain(|kink| kink.changes == kink.shown || !listed.contains(&kink.shown));
    list
}

/// What was looked at before.
#[derive(Default)]
struct Seen {
    /// Nodes that were searched for what they are divided by.
    quotients: BTreeSet<Id>,
    factors: Factors,
}

/// Those of one operation.
fn of_node(graph: &mut Graph, id: Id, seen: &mut Seen) -> Vec<Kink> {
    use Function::{Abs, Asinh, Atan, Cbrt, Cos, Erf, Exp, Floor, Sign, Sin, Sinh, Sqrt, Tan, Tanh};
    let changes = match *graph.node(id) {
        Node::Call(Abs | Sign, a) => vec![a],
        Node::Call(Floor, a) => (0..DIGITS).map(|digit| binary_digit(graph, a, digit)).collect(),
        Node::Call(Cbrt, a) => {
            let mut list = divisors(graph, &[a], seen);
            if !graph.never_negative(a) {
                list.push(a);
            }
            return list.into_iter().map(Kink::from).chain(edges(graph, id, seen)).collect();
        }
        Node::Call(Sqrt, _) | Node::Call2(Binary::Hypot, ..) => return edges(graph, id, seen),
        Node::Power(_, halves) if halves % 2 != 0 => return edges(graph, id, seen),
        Node::Call(Asinh | Atan | Cos | Erf | Exp | Sin | Sinh | Tan | Tanh, a) => {
            divisors(graph, &[a], seen)
        }
        Node::Call2(Binary::Powf, _, exponent) => {
            let list = divisors(graph, &[exponent], seen).into_iter().map(Kink::from);
            return list.chain(edges(graph, id, seen)).collect();
        }
        Node::Call2(Binary::Atan2, a, b) => {
            let mut list: Vec<Kink> = divisors(graph, &[a, b], seen).into_iter().map(Kink::from).collect();
            if !graph.never_negative(a) && !graph.never_negative(b) {
                list.push(cut(graph, a, b));
            }
            return list;
        }
        Node::Select(_, a, b, ..) if graph.as_constant(b) == Some(0.0) => vec![a],
        Node::Select(_, a, b, ..) if graph.as_constant(a) == Some(0.0) => vec![b],
        Node::Select(_, a, b, ..) => vec![graph.sub(a, b)],
        _ => vec![],
    };
    changes.into_iter().map(Kink::from).collect()
}

/// a/2ⁿ − 2 floor(a/2ⁿ⁺¹) − 1, negative where this binary digit of floor(a) is 0, to the last bit: the first changes
/// its sign at every integer.
fn binary_digit(graph: &mut Graph, a: Id, digit: i32) -> Id {
    let [one, two, scale] = [1.0, 2.0, 2.0_f64.powi(digit)].map(|number| graph.constant(number));
    let a = graph.div(a, scale);
    let half = graph.div(a, two);
    let floor = graph.call(Function::Floor, half);
    let even = graph.mul(two, floor);
    let rest = graph.sub(a, even);
    graph.sub(rest, one)
}

/// What these are divided by, as sums, products, quotients and odd powers. Where it is zero they are infinite, and of
/// another sign on each side. Fractions of fractions go on smoothly there; functions of them jump.
fn divisors(graph: &mut Graph, of: &[Id], seen: &mut Seen) -> Vec<Id> {
    let found = found_from(of.iter().copied(), |id| match *graph.node(id) {
        _ if !graph.moving(id) || seen.quotients.contains(&id) => vec![],
        Node::Neg(a) => vec![a],
        Node::Power(a, halves) if halves % 4 != 0 && halves % 2 == 0 => vec![a],
        Node::Call2(Binary::Powf, a, exponent) if !graph.moving(exponent) => vec![a],
        Node::Add(a, b) | Node::Sub(a, b) | Node::Mul(a, b) | Node::Div(a, b) => vec![a, b],
        _ => vec![],
    });
    let new: Vec<Id> = found.into_iter().filter(|&id| seen.quotients.insert(id)).collect();
    let divisor = |id: Id| match *graph.node(id) {
        Node::Div(_, b) => Some(b),
        Node::Power(b, halves) if halves < 0 && halves % 4 != 0 && halves % 2 == 0 => Some(b),
        Node::Call(Function::Tan, a) => Some(graph.call(Function::Cos, a)),
        _ => None,
    };
    let divisors: Vec<Id> = new.into_iter().filter_map(divisor).collect();
    divisors.into_iter().filter(|&b| !graph.never_negative(b) && !is_never_zero(graph, b)).collect()
}

/// Whether a sum of a number and of what goes to and fro, as 2 + cos(a) does, keeps its sign.
fn is_never_zero(graph: &Graph, id: Id) -> bool {
    range(graph, id, TERMS).is_some_and(|[middle, most]| middle.abs() > most)
}

/// What such a sum goes to and fro about, and how far at most; none where it is another one, or of more operations.
fn range(graph: &Graph, id: Id, operations: usize) -> Option<[f64; 2]> {
    if let Some(number) = graph.number(id) {
        return Some([number, 0.0]);
    }
    let part = |part| range(graph, part, operations.checked_sub(1)?);
    match *graph.node(id) {
        Node::Call(Function::Sin | Function::Cos | Function::Tanh | Function::Erf, _) => Some([0.0, 1.0]),
        Node::Neg(a) => part(a).map(|[middle, most]| [-middle, most]),
        Node::Add(a, b) => part(a).zip(part(b)).map(|(a, b)| [a[0] + b[0], a[1] + b[1]]),
        Node::Sub(a, b) => part(a).zip(part(b)).map(|(a, b)| [a[0] - b[0], a[1] + b[1]]),
        Node::Mul(a, b) => {
            let (factor, [middle, most]) = match (graph.number(a), graph.number(b)) {
                (Some(factor), _) => (factor, part(b)?),
                (_, Some(factor)) => (factor, part(a)?),
                _ => return None,
            };
            Some([factor * middle, factor.abs() * most])
        }
        _ => None,
    }
}

/// The edges of a root, a power or a length.
fn edges(graph: &mut Graph, root: Id, seen: &mut Seen) -> Vec<Kink> {
    let factors: Vec<Factor> =
        seen.factors.of(graph, root).iter().filter(|factor| factor.bends()).cloned().collect();
    factors.iter().map(|factor| edge(graph, factor)).collect()
}

/// a where b is negative, else 1: there atan2(a, b) does not jump.
fn cut(graph: &mut Graph, a: Id, b: Id) -> Kink {
    let [zero, one] = [0.0, 1.0].map(|number| graph.constant(number));
    let changes = graph.select(Comparison::Less, b, zero, a, one);
    Kink { changes, shown: a }
}

/// a where |c| is no more than k a², else 1: √(k a² + c) is smooth as seen from so far.
fn edge(graph: &mut Graph, factor: &Factor) -> Kink {
    let one = graph.constant(1.0);
    let mut changes = factor.base;
    for limit in &factor.limits {
        let rest = graph.call(Function::Abs, limit.rest);
        changes = graph.select(Comparison::LessOrEqual, rest, limit.core, changes, one);
    }
    Kink { changes, shown: factor.base }
}
