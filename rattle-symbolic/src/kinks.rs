//! Where equations are not smooth: what changes its sign there.
//!
//! ```text
//! abs(a), sign(a), cbrt(a), if a < 0 …      a
//! min(a, b), max(a, b), if a < b …          a − b, or b − a
//! floor(a), mod(a, w) = a − w floor(a/w)    the lowest binary digits of floor(a), as signs
//! atan2(a, b)                               a, where b is negative: the angle jumps by 2π
//! atan(a), tanh(a), erf(a), atan2(a, b)     what is divided by in them: they jump where it is zero
//! sqrt(a² + c), hypot(a, c)                 a, where c is smaller than a²: for c = 0 that is an edge
//! ```
//!
//! What is under another square root does not change its sign where g is a number. Edges where it touches zero, as that
//! of √(a² − 2a + 1), are not seen, nor are those of acos(cos(a)).

use crate::functions::{Binary, Function};
use crate::graph::{Graph, found_from};
use crate::node::{Comparison, Id, Node};
use std::collections::BTreeSet;

/// So many binary digits of a floor are compared: a step over fewer than 2³ jumps is seen.
const DIGITS: i32 = 3;

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
    let (mut list, mut listed, mut quotients) = (Vec::new(), BTreeSet::new(), BTreeSet::new());
    let all = graph.reachable(roots);
    let parts: BTreeSet<Id> = all.iter().flat_map(|&id| graph.node(id).children()).collect();
    for id in all {
        if matches!(graph.node(id), Node::Call2(Binary::Atan2, ..)) && !parts.contains(&id) {
            continue; // an angle that is to be 0 is not where it jumps
        }
        for kink in of_node(graph, id, &mut quotients) {
            if graph.moving(kink.changes) && listed.insert(kink.changes) {
                list.push(kink);
            }
        }
    }
    list
}

/// Those of one operation; `quotients` are the nodes that were searched for what they are divided by.
fn of_node(graph: &mut Graph, id: Id, quotients: &mut BTreeSet<Id>) -> Vec<Kink> {
    use Function::{Abs, Atan, Cbrt, Erf, Floor, Sign, Sqrt, Tanh};
    let changes = match *graph.node(id) {
        Node::Call(Sqrt, a) => return edge_of_root(graph, a).into_iter().collect(),
        Node::Call2(Binary::Hypot, a, b) if graph.moving(a) != graph.moving(b) => {
            let (moving, still) = if graph.moving(a) { (a, b) } else { (b, a) };
            let [square, rest] = [moving, still].map(|side| graph.mul(side, side));
            return vec![edge(graph, moving, square, rest)];
        }
        Node::Call(Abs | Cbrt | Sign, a) => vec![a],
        Node::Call(Floor, a) => (0..DIGITS).map(|digit| binary_digit(graph, a, digit)).collect(),
        Node::Call(Atan | Tanh | Erf, a) => divisors(graph, &[a], quotients),
        Node::Call2(Binary::Atan2, a, b) => {
            let mut list: Vec<Kink> =
                divisors(graph, &[a, b], quotients).into_iter().map(Kink::from).collect();
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

/// What these are divided by, as sums, products and quotients. Where it is zero they are infinite, and of another sign
/// on each side.
fn divisors(graph: &mut Graph, of: &[Id], quotients: &mut BTreeSet<Id>) -> Vec<Id> {
    let found = found_from(of.iter().copied(), |id| match *graph.node(id) {
        _ if quotients.contains(&id) => vec![],
        Node::Neg(a) => vec![a],
        Node::Add(a, b) | Node::Sub(a, b) | Node::Mul(a, b) | Node::Div(a, b) => vec![a, b],
        _ => vec![],
    });
    let new: Vec<Id> = found.into_iter().filter(|&id| quotients.insert(id)).collect();
    let divisor = |id: Id| match *graph.node(id) {
        Node::Div(_, b) => Some(b),
        Node::Power(b, halves) if halves < 0 && halves % 4 != 0 && halves % 2 == 0 => Some(b),
        Node::Call(Function::Tan, a) => Some(graph.call(Function::Cos, a)),
        _ => None,
    };
    let divisors: Vec<Id> = new.into_iter().filter_map(divisor).collect();
    divisors.into_iter().filter(|&b| !graph.never_negative(b)).collect()
}

/// The edge of √u for u = a² + c, where c does not move.
fn edge_of_root(graph: &mut Graph, u: Id) -> Option<Kink> {
    let (mut inside, mut rest) = (u, None);
    loop {
        let (moving, still) = match *graph.node(inside) {
            Node::Add(a, b) if !graph.moving(a) => (b, a),
            Node::Add(a, b) if !graph.moving(b) => (a, b),
            Node::Sub(a, b) if !graph.moving(b) => (a, graph.neg(b)),
            Node::Power(a, 4) => return rest.map(|rest| edge(graph, a, inside, rest)),
            _ => return None,
        };
        inside = moving;
        rest = Some(rest.map_or(still, |rest| graph.add(rest, still)));
    }
}

/// a where b is negative, else 1: there atan2(a, b) does not jump.
fn cut(graph: &mut Graph, a: Id, b: Id) -> Kink {
    let [zero, one] = [0.0, 1.0].map(|number| graph.constant(number));
    let changes = graph.select(Comparison::Less, b, zero, a, one);
    Kink { changes, shown: a }
}

/// a where c is no more than a², else 1: √(a² + c) is smooth as seen from so far.
fn edge(graph: &mut Graph, a: Id, square: Id, c: Id) -> Kink {
    let one = graph.constant(1.0);
    let changes = graph.select(Comparison::LessOrEqual, c, square, a, one);
    Kink { changes, shown: a }
}
