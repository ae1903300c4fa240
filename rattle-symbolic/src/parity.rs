//! Functions of a distance r, rewritten as functions of s = r².
//!
//! ```text
//! even   U(r) = E(s)           odd   U(r) = r E(s)
//! ```
//!
//! Parity goes through sums, products, quotients and powers, so a potential that is even in r, such
//! as Lennard-Jones or a Gaussian, needs no square root, and its slope has no 0/0 at contact. Other
//! functions of r are evaluated at r = √s; there dU/ds = U′(r)/(2r), which at r = 0 is the limit
//! U″(0)/2 that it has when U is smooth.

use crate::algebra::Scaled;
use crate::differentiate::Calculus;
use crate::functions::Function;
use crate::graph::Graph;
use crate::node::{Comparison, Id, Input, Node};

/// Value and slope as functions of s, the only variable of the graph that holds them.
pub(crate) struct OfSquare {
    /// The graph.
    pub(crate) graph: Graph,
    /// U
    pub(crate) value: Id,
    /// dU/ds
    pub(crate) slope: Scaled,
}

/// Rewrites a function of r, the only variable of `source`.
pub(crate) fn of_square(source: &mut Graph, root: Id) -> OfSquare {
    let mut graph = Graph::new();
    let s = graph.input(Input::Variable(0));
    if let Some(Half { odd: false, rest: value }) = halves(source, root, &mut graph, s) {
        let slope = Calculus::new(&mut graph).gradient(&[(Scaled::ONE, value)], 1)[0];
        return OfSquare { graph, value, slope };
    }
    let mut calculus = Calculus::new(source);
    let by_r = |_: &mut Graph, input| match input {
        Input::Variable(_) => Scaled::ONE,
        _ => Scaled::ZERO,
    };
    let slope = calculus.gradient(&[(Scaled::ONE, root)], 1);
    let bend = calculus.tangents(&slope, by_r);
    let [slope, bend] = [slope[0], bend[0]].map(|scaled| source.node_of(scaled));
    let r = graph.call(Function::Sqrt, s);
    let zero = graph.constant(0.0);
    let value = substitute(source, root, &mut graph, r);
    let slope = substitute(source, slope, &mut graph, r);
    let bend = substitute(source, bend, &mut graph, zero);
    let reciprocal = graph.reciprocal(r);
    let apart = graph.product(&[slope.into(), reciprocal]);
    let apart = graph.node_of(apart);
    let slope = graph.select(Comparison::LessOrEqual, s, zero, bend, apart);
    OfSquare { graph, value, slope: Scaled { factor: 0.5, node: Some(slope) } }
}

/// E, or r·E.
#[derive(Clone, Copy)]
struct Half {
    odd: bool,
    rest: Id,
}

fn halves(source: &Graph, root: Id, g: &mut Graph, s: Id) -> Option<Half> {
    let mut known: Vec<Option<Half>> = vec![None; source.len()];
    for id in source.reachable(&[root]) {
        known[id.index()] = half(source.node(id), |id| known[id.index()], g, s);
    }
    known[root.index()]
}

fn half(node: &Node, of: impl Fn(Id) -> Option<Half>, g: &mut Graph, s: Id) -> Option<Half> {
    let even = |rest| Some(Half { odd: false, rest });
    match *node {
        Node::Constant(bits) => even(g.constant(f64::from_bits(bits))),
        Node::Input(Input::Variable(_)) => Some(Half { odd: true, rest: g.constant(1.0) }),
        Node::Input(input) => even(g.input(input)),
        Node::Neg(a) => {
            let a = of(a)?;
            Some(Half { rest: g.neg(a.rest), ..a })
        }
        Node::Add(a, b) | Node::Sub(a, b) => {
            let (a, b) = (of(a)?, of(b)?);
            let rest =
                if matches!(node, Node::Add(..)) { g.add(a.rest, b.rest) } else { g.sub(a.rest, b.rest) };
            (a.odd == b.odd).then_some(Half { odd: a.odd, rest })
        }
        Node::Mul(a, b) => {
            let (a, b) = (of(a)?, of(b)?);
            let product = g.mul(a.rest, b.rest);
            let rest = if a.odd && b.odd { g.mul(product, s) } else { product };
            Some(Half { odd: a.odd != b.odd, rest })
        }
        Node::Div(a, b) => {
            let (a, b) = (of(a)?, of(b)?);
            let divisor = if b.odd && !a.odd { g.mul(s, b.rest) } else { b.rest }; // 1/(r E) = r/(s E)
            Some(Half { odd: a.odd != b.odd, rest: g.div(a.rest, divisor) })
        }
        Node::Power(a, n) => {
            let a = of(a)?;
            match (a.odd, n % 2 == 0) {
                (false, _) => even(g.power(a.rest, n)),
                (true, true) => {
                    // (r E)ᵐ = (s E²)^⌊m/2⌋ · (r E)^(m mod 2): sᵐᐟ² and Eᵐ alone may be no numbers where this is one.
                    let (m, square) = (n / 2, square(a.rest, g, s));
                    let rest = g.power(square, 2 * m.div_euclid(2));
                    let odd = m.rem_euclid(2) == 1;
                    Some(Half { odd, rest: if odd { g.mul(rest, a.rest) } else { rest } })
                }
                (true, false) => None,
            }
        }
        Node::Call(function, a) => {
            let a = of(a)?;
            (!a.odd || function == Function::Abs).then(|| Half { rest: g.call(function, a.rest), ..a })
        }
        Node::Call2(function, a, b) => {
            let (a, b) = (of(a)?, of(b)?);
            if a.odd || b.odd { None } else { even(g.call2(function, a.rest, b.rest)) }
        }
        Node::Select(comparison, a, b, then, other) => {
            let [a, b] = [of(a)?, of(b)?].map(|side| whole(side, g, s));
            let (then, other) = (of(then)?, of(other)?);
            let rest = g.select(comparison, a, b, then.rest, other.rest);
            (then.odd == other.odd).then_some(Half { odd: then.odd, rest })
        }
        Node::Sum(_) | Node::Product(_) => None, // not in value graphs
    }
}

/// s E², with a single division: σ²/s where E is σ/s.
fn square(e: Id, g: &mut Graph, s: Id) -> Id {
    match *g.node(e) {
        Node::Constant(one) if f64::from_bits(one) == 1.0 => s,
        Node::Neg(a) => square(a, g, s),
        Node::Power(a, halves) if a == s => g.power(s, 2 * halves + 2),
        Node::Div(above, below) if below == s => {
            let above = g.mul(above, above);
            g.div(above, s)
        }
        _ => {
            let squared = g.mul(e, e);
            g.mul(squared, s)
        }
    }
}

/// The number itself: only comparisons need it.
fn whole(half: Half, g: &mut Graph, s: Id) -> Id {
    if half.odd {
        let r = g.call(Function::Sqrt, s);
        g.mul(r, half.rest)
    } else {
        half.rest
    }
}

/// Copies an expression with another node in place of its variable.
fn substitute(source: &Graph, root: Id, g: &mut Graph, variable: Id) -> Id {
    let mut copies = vec![variable; source.len()];
    for id in source.reachable(&[root]) {
        let at = |id: &Id| copies[id.index()];
        copies[id.index()] = match source.node(id) {
            Node::Constant(bits) => g.constant(f64::from_bits(*bits)),
            Node::Input(Input::Variable(_)) => variable,
            Node::Input(input) => g.input(*input),
            Node::Neg(a) => g.neg(at(a)),
            Node::Add(a, b) => g.add(at(a), at(b)),
            Node::Sub(a, b) => g.sub(at(a), at(b)),
            Node::Mul(a, b) => g.mul(at(a), at(b)),
            Node::Div(a, b) => g.div(at(a), at(b)),
            Node::Power(a, halves) => g.power(at(a), *halves),
            Node::Call(function, a) => g.call(*function, at(a)),
            Node::Call2(function, a, b) => g.call2(*function, at(a), at(b)),
            Node::Select(comparison, a, b, then, other) => {
                g.select(*comparison, at(a), at(b), at(then), at(other))
            }
            Node::Sum(terms) => {
                let terms: Vec<Scaled> = terms
                    .iter()
                    .map(|(bits, a)| Scaled { factor: f64::from_bits(*bits), node: Some(at(a)) })
                    .collect();
                let sum = g.sum(&terms);
                g.node_of(sum)
            }
            Node::Product(factors) => {
                let factors: Vec<Scaled> =
                    factors.iter().flat_map(|(a, n)| (0..*n).map(|_| at(a).into())).collect();
                let product = g.product(&factors);
                g.node_of(product)
            }
        };
    }
    copies[root.index()]
}
