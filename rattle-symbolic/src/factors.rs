//! Where roots touch zero: what divides the expression under them, and how often.
//!
//! ```text
//! k a⁴ / b        a four times: of an even number of times √ makes an edge, and a changes its sign there
//! k a² + c        a twice, where c is smaller than k a²
//! a² b + a² d     a twice; a sum has what all of its terms have, and its own zeros
//! ```
//!
//! Numbers and parameters before these change no sign, and are left out.

use crate::functions::{Binary, Function};
use crate::graph::{Graph, found_from};
use crate::node::{Id, Node};
use std::collections::BTreeMap;

/// What has more factors is taken as one: the lists of long products would be as long as these.
const MOST: usize = 16;

/// A factor of an expression, where it has one.
#[derive(Clone, PartialEq)]
pub(crate) struct Factor {
    /// What changes its sign.
    pub(crate) base: Id,
    /// How often the expression has it; none where a parameter or a variable says so.
    exponent: Option<f64>,
    /// Whether the expression changes its sign with that of the base.
    odd: bool,
    /// Where it is one.
    pub(crate) limits: Vec<Limit>,
}

/// A factor of a + c is one of a where c ≤ a.
#[derive(Clone, PartialEq)]
pub(crate) struct Limit {
    /// c
    pub(crate) rest: Id,
    /// a
    pub(crate) core: Id,
    /// a + c
    whole: Id,
}

impl Factor {
    /// Whether a surface has an edge where the base changes its sign: |a|, √|a| and 1/|a|, not |a|³.
    pub(crate) fn bends(&self) -> bool {
        !self.odd && self.exponent.is_none_or(|exponent| exponent.abs() <= 1.0)
    }
    /// The same in a power of the expression, which is a number on one side alone where `root` is.
    fn raised(&self, exponent: Option<f64>, even: bool, root: bool) -> Option<Factor> {
        let exponent = self.exponent.zip(exponent).map(|(own, by)| own * by);
        let factor = Factor { exponent, odd: self.odd && !even, ..self.clone() };
        (!(self.odd && root)).then_some(factor)
    }
}

/// The factors of expressions that were asked for, and of what these are made of.
#[derive(Default)]
pub(crate) struct Factors {
    known: BTreeMap<Id, Vec<Factor>>,
}

impl Factors {
    /// Those of one expression.
    pub(crate) fn of(&mut self, graph: &mut Graph, id: Id) -> &[Factor] {
        let known = &self.known;
        let next = |id: Id| {
            let open = |part: &Id| graph.moving(*part) && !known.contains_key(part);
            parts(graph, id).into_iter().filter(open).collect()
        };
        for id in found_from([id], next) {
            if !self.known.contains_key(&id) {
                let found = self.found(graph, id);
                self.known.insert(id, if found.len() > MOST { itself(graph, id) } else { found });
            }
        }
        self.read(id)
    }

    fn read(&self, id: Id) -> &[Factor] {
        self.known.get(&id).map_or(&[], Vec::as_slice)
    }

    fn found(&self, graph: &mut Graph, id: Id) -> Vec<Factor> {
        let raised = |a: Id, exponent: Option<f64>, even: bool, root: bool| {
            self.read(a).iter().filter_map(|factor| factor.raised(exponent, even, root)).collect()
        };
        match *graph.node(id) {
            Node::Neg(a) => self.read(a).to_vec(),
            Node::Mul(a, b) => multiplied(self.read(a), self.read(b), 1.0),
            Node::Div(a, b) => multiplied(self.read(a), self.read(b), -1.0),
            Node::Power(a, halves) => {
                raised(a, Some(f64::from(halves) / 2.0), halves % 4 == 0, halves % 2 != 0)
            }
            Node::Call(Function::Sqrt, a) => raised(a, Some(0.5), false, true),
            Node::Call(Function::Cbrt, a) => raised(a, Some(1.0 / 3.0), false, false),
            Node::Call2(Binary::Powf, a, exponent) => raised(a, graph.number(exponent), false, true),
            Node::Call2(Binary::Hypot, a, b) => match (graph.moving(a), graph.moving(b)) {
                (true, true) => {
                    common(&raised(a, Some(1.0), true, false), &raised(b, Some(1.0), true, false))
                }
                (moves, _) => {
                    let (moving, still) = if moves { (a, b) } else { (b, a) };
                    let [core, rest] = [moving, still].map(|side| graph.mul(side, side));
                    limited(raised(moving, Some(1.0), true, false), Limit { rest, core, whole: id })
                }
            },
            Node::Add(a, b) | Node::Sub(a, b) if graph.moving(a) && graph.moving(b) => {
                [common(self.read(a), self.read(b)), itself(graph, id)].concat()
            }
            Node::Add(a, b) => {
                let (moving, still) = if graph.moving(a) { (a, b) } else { (b, a) };
                self.beside(graph, id, moving, still)
            }
            Node::Sub(a, b) if graph.moving(a) => {
                let still = graph.neg(b);
                self.beside(graph, id, a, still)
            }
            _ => itself(graph, id),
        }
    }

    /// Those of a sum of what moves and what does not, and the sum.
    fn beside(&self, graph: &mut Graph, whole: Id, moving: Id, still: Id) -> Vec<Factor> {
        let even = self.read(moving).iter().filter(|factor| !factor.odd);
        let mut list = Vec::new();
        for mut factor in even.cloned() {
            match factor.limits.last_mut() {
                // A sum of several numbers.
                Some(last) if last.whole == moving => {
                    last.rest = graph.add(last.rest, still);
                    last.whole = whole;
                }
                _ => factor.limits.push(Limit { rest: still, core: moving, whole }),
            }
            list.push(factor);
        }
        list.extend(itself(graph, whole));
        list
    }
}

/// What the factors of an expression are found from.
fn parts(graph: &Graph, id: Id) -> Vec<Id> {
    match *graph.node(id) {
        Node::Call(Function::Sqrt | Function::Cbrt, a) | Node::Call2(Binary::Powf, a, _) => vec![a],
        Node::Call(..) | Node::Call2(Binary::Atan2, ..) | Node::Select(..) => vec![],
        ref node => node.children(),
    }
}

/// The expression as its own factor, if it may change its sign.
fn itself(graph: &Graph, id: Id) -> Vec<Factor> {
    let own = Factor { base: id, exponent: Some(1.0), odd: true, limits: vec![] };
    if graph.never_negative(id) { vec![] } else { vec![own] }
}

/// Those of a product, or with the power −1 of a quotient.
fn multiplied(a: &[Factor], b: &[Factor], power: f64) -> Vec<Factor> {
    let mut list = a.to_vec();
    for factor in b.iter().filter_map(|factor| factor.raised(Some(power), false, false)) {
        match list.iter_mut().find(|own| own.base == factor.base && own.limits == factor.limits) {
            Some(own) => {
                own.exponent = own.exponent.zip(factor.exponent).map(|(own, other)| own + other);
                own.odd ^= factor.odd;
            }
            None => list.push(factor),
        }
    }
    list.retain(|factor| factor.exponent != Some(0.0));
    list
}

/// Those that a sum has since both of its terms have them.
fn common(a: &[Factor], b: &[Factor]) -> Vec<Factor> {
    let everywhere = |factor: &&Factor| factor.limits.is_empty();
    let both = a.iter().filter(everywhere).filter_map(|factor| {
        let other = b.iter().filter(everywhere).find(|other| other.base == factor.base)?;
        match factor.exponent.zip(other.exponent) {
            _ if factor == other => Some(factor.clone()),
            Some((own, by)) if own < by => Some(factor.clone()),
            Some((own, by)) if own > by => Some(other.clone()),
            _ => None,
        }
    });
    both.collect()
}

fn limited(mut list: Vec<Factor>, limit: Limit) -> Vec<Factor> {
    list.iter_mut().for_each(|factor| factor.limits.push(limit.clone()));
    list
}
