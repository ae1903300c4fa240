//! What branches hold: factors that may be infinite, times slopes that are 0 in some arms of a branch.
//!
//! ```text
//! ∞ · (if a < b { 0 } else { s })           0 where a < b
//! ∞ · (c · (if …) + d · (if …)) · e         the same of each branch: all else is multiplied into its arms
//! ```
//!
//! An arm of no slope, as that of `max(x, 1)` below 1, has none in `acosh(max(x, 1))` either, although acosh′(1) is
//! infinite.

use crate::algebra::Scaled;
use crate::graph::{Graph, found_from};
use crate::node::{Comparison, Id, Node};
use std::collections::BTreeMap;

/// Slopes with more parts are multiplied as they are: products of sums would grow without end.
const MOST: usize = 64;

impl Graph {
    /// factor · slope, a part of the slope of `value`. Where a branch makes the slope 0 the product is 0, also where
    /// the factor is infinite, and no number where the value is none.
    pub(crate) fn product_with_branch(&mut self, value: Id, factor: Scaled, slope: Scaled) -> Scaled {
        if let (Some(by), Some(of)) = (factor.node, slope.node)
            && self.holds_zero(of)
            && self.may_be_infinite(by)
        {
            // Where a value is held the factor may be 0 · ∞, if it has parts; else it is cheaper to ask than the value.
            let number = if self.is_held(of) && self.has_parts(by) { value } else { by };
            let mut held = Held { graph: self, factor, number, known: BTreeMap::new() };
            if let Some(product) = held.times(Scaled::number(slope.factor), of) {
                return product;
            }
        }
        self.product(&[factor, slope])
    }

    /// Whether the node, or an arm of it, is a product or a sum.
    fn has_parts(&self, node: Id) -> bool {
        let arms = found_from([node], |id| match *self.node(id) {
            Node::Select(_, _, _, then, other) => vec![then, other],
            Node::Sum(ref terms) if terms.len() == 1 => vec![terms[0].1],
            _ => vec![],
        });
        arms.into_iter().any(|id| match *self.node(id) {
            Node::Sum(ref terms) => terms.len() > 1,
            Node::Product(_) | Node::Mul(..) | Node::Div(..) | Node::Add(..) | Node::Sub(..) => true,
            _ => false,
        })
    }

    /// 0, and no number where x is none.
    fn zero_or_none(&mut self, x: Id) -> Id {
        let (zero, none) = (self.constant(0.0), self.constant(f64::NAN));
        self.select(Comparison::LessOrEqual, x, x, zero, none)
    }
    fn is_zero_or_none(&self, id: Id) -> bool {
        match *self.node(id) {
            Node::Select(Comparison::LessOrEqual, a, b, then, _) => {
                a == b && self.as_constant(then) == Some(0.0)
            }
            _ => self.as_constant(id) == Some(0.0),
        }
    }
}

/// A factor times the parts of a slope.
struct Held<'a> {
    graph: &'a mut Graph,
    factor: Scaled,
    /// No number where the products are none.
    number: Id,
    /// Each product once: a chain of conditions names what follows more than once.
    known: BTreeMap<(u64, Option<Id>, Id), Scaled>,
}

impl Held<'_> {
    /// factor · rest · slope, if it has not too many parts.
    fn times(&mut self, rest: Scaled, slope: Id) -> Option<Scaled> {
        let key = (rest.factor.to_bits(), rest.node, slope);
        if let Some(&known) = self.known.get(&key) {
            return Some(known);
        }
        if self.known.len() == MOST {
            return None;
        }
        let product = self.new_product(rest, slope)?;
        self.known.insert(key, product);
        Some(product)
    }

    fn new_product(&mut self, rest: Scaled, slope: Id) -> Option<Scaled> {
        if self.graph.is_zero_or_none(slope) {
            return Some(self.graph.zero_or_none(self.number).into());
        }
        if !self.graph.holds_zero(slope) {
            return self.times_plain(rest, slope.into());
        }
        match self.graph.node(slope).clone() {
            Node::Select(comparison, a, b, then, other) => {
                let arms = [self.times(rest, then)?, self.times(rest, other)?];
                let [then, other] = arms.map(|arm| self.graph.node_of(arm));
                Some(self.graph.select(comparison, a, b, then, other).into())
            }
            Node::Sum(terms) => {
                let terms = terms.iter().map(|&(bits, term)| (Scaled::number(f64::from_bits(bits)), term));
                let (held, plain): (Vec<_>, Vec<_>) = terms.partition(|&(_, term)| self.graph.is_held(term));
                let plain: Vec<Scaled> =
                    plain.into_iter().map(|(c, term)| Scaled::from(term).times(c.factor)).collect();
                let plain = self.graph.sum(&plain);
                let mut sum = vec![self.times_plain(rest, plain)?];
                for (c, term) in held {
                    let rest = self.graph.product(&[rest, c]);
                    sum.push(self.times(rest, term)?);
                }
                Some(self.graph.sum(&sum))
            }
            node => {
                let (sign, factors) = match node {
                    Node::Mul(a, b) => (1.0, vec![(a, 1), (b, 1)]),
                    _ => self.graph.factors(slope),
                };
                let held = factors.iter().position(|&(factor, _)| self.graph.is_held(factor))?;
                let mut others = vec![rest.times(sign)];
                for (i, &(factor, times)) in factors.iter().enumerate() {
                    let times = times - u32::from(i == held);
                    others.push(self.graph.power(factor, 2 * times as i32).into());
                }
                let rest = self.graph.product(&others);
                self.times(rest, factors[held].0)
            }
        }
    }

    /// The same of a slope that no branch holds; but one may hold the rest.
    fn times_plain(&mut self, rest: Scaled, slope: Scaled) -> Option<Scaled> {
        let slope = self.graph.product(&[rest, slope]);
        match slope.node.filter(|&node| self.graph.is_held(node)) {
            Some(node) => self.times(Scaled::number(slope.factor), node),
            None => Some(self.graph.product(&[self.factor, slope])),
        }
    }
}
