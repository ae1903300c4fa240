//! Sums and products of derivatives: flattened, factored, in one canonical form.
//!
//! A value of the derivative graph is a [`Scaled`] node c·x with an exact coefficient, so that signs and powers of two
//! cost nothing on the way. Sums collect like terms and pull out common factors, `f·m + 2·f·x² → f·(m + 2x²)`; products
//! merge powers of one base. Nothing is ever multiplied out, since expansion makes derivatives long and inaccurate.

use crate::graph::{Graph, exact_product, exact_quotient, exact_sum};
use crate::node::{Comparison, Id, Node};
use std::collections::BTreeMap;

/// Longer products and sums are nested, not flattened: keeps every pass near linear.
const WIDTH: usize = 8;
/// Longer sums are left as they are, without a search for common factors.
const SEARCH: usize = 64;

/// c·x, or the number c alone.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Scaled {
    /// The coefficient.
    pub factor: f64,
    /// The node x; `None` for 1.
    pub node: Option<Id>,
}

impl Scaled {
    /// Zero: the derivative of a constant.
    pub const ZERO: Scaled = Scaled::number(0.0);
    /// The number one.
    pub const ONE: Scaled = Scaled::number(1.0);

    /// A plain number.
    pub const fn number(factor: f64) -> Scaled {
        Scaled { factor, node: None }
    }
    /// Whether this is the number zero.
    pub fn is_zero(self) -> bool {
        self.factor == 0.0
    }
    /// Multiplied by a number of few bits; see [`Graph::product`] for the general case.
    pub(crate) fn times(self, factor: f64) -> Scaled {
        Scaled { factor: self.factor * factor, ..self }
    }
}

impl From<Id> for Scaled {
    fn from(node: Id) -> Scaled {
        Scaled { factor: 1.0, node: Some(node) }
    }
}

/// A product of powers of nodes, sorted.
type Factors = BTreeMap<Id, u32>;

impl Graph {
    /// Π aᵢ
    pub fn product(&mut self, operands: &[Scaled]) -> Scaled {
        if operands.iter().any(|operand| operand.is_zero()) {
            return Scaled::ZERO;
        }
        let mut factor = 1.0;
        let mut factors = Factors::new();
        let mut opaque = Factors::new();
        for operand in operands {
            match exact_product(factor, operand.factor) {
                Some(exact) => factor = exact,
                None => {
                    let number = self.constant(operand.factor);
                    *factors.entry(number).or_default() += 1;
                    *opaque.entry(number).or_default() += 1;
                }
            }
            let Some(node) = operand.node else { continue };
            let (sign, parts) = self.factors(node);
            factor *= sign;
            // Its sign is taken out of a node that is kept whole, too.
            let whole = if let Node::Neg(inner) = *self.node(node) { inner } else { node };
            for (part, exponent) in parts {
                *factors.entry(part).or_default() += exponent;
            }
            *opaque.entry(whole).or_default() += 1;
        }
        self.cancel(&mut factors);
        let chosen = if factors.values().sum::<u32>() as usize > WIDTH { opaque } else { factors };
        match self.product_node(chosen) {
            Some(node) => Scaled { factor, node: Some(node) },
            None => Scaled::number(factor),
        }
    }

    /// Σ aᵢ
    pub fn sum(&mut self, operands: &[Scaled]) -> Scaled {
        let mut terms: Vec<(f64, Factors)> = Vec::new();
        let mut place = BTreeMap::new();
        let flatten = operands.len() <= WIDTH;
        for &operand in operands {
            for (factor, factors) in self.terms(operand, flatten) {
                let slot = *place.entry(factors.clone()).or_insert(terms.len());
                match terms.get(slot).and_then(|term: &(f64, Factors)| exact_sum(term.0, factor)) {
                    Some(sum) => terms[slot].0 = sum,
                    None => terms.push((factor, factors)),
                }
            }
        }
        terms.retain(|term| term.0 != 0.0);
        if terms.len() <= SEARCH {
            terms = self.factored(terms);
        }
        self.sum_of(terms)
    }

    /// 1/x
    pub(crate) fn reciprocal(&mut self, x: Id) -> Scaled {
        self.power(x, -2).into()
    }

    /// The node that holds c·x.
    pub fn node_of(&mut self, scaled: Scaled) -> Id {
        match scaled {
            Scaled { factor, node: None } => self.constant(factor),
            Scaled { factor: 1.0, node: Some(node) } => node,
            Scaled { factor, node: Some(node) } => self.insert(Node::Sum([(factor.to_bits(), node)].into())),
        }
    }

    /// The factors of a node and the sign before them.
    pub(crate) fn factors(&self, node: Id) -> (f64, Vec<(Id, u32)>) {
        match *self.node(node) {
            Node::Product(ref factors) => (1.0, factors.to_vec()),
            Node::Power(base, halves) if halves > 0 && halves % 2 == 0 => {
                (1.0, vec![(base, halves.unsigned_abs() / 2)])
            }
            Node::Power(base, halves) if halves < -2 && halves % 2 == 0 => {
                match self.find(&Node::Power(base, -2)) {
                    Some(reciprocal) => (1.0, vec![(reciprocal, halves.unsigned_abs() / 2)]),
                    None => (1.0, vec![(node, 1)]),
                }
            }
            Node::Neg(inner) => (-1.0, vec![(inner, 1)]),
            _ => (1.0, vec![(node, 1)]),
        }
    }

    /// x · 1/x → 1, also where the reciprocal is guarded, as the slope of a logarithm is: no number below 0.
    fn cancel(&mut self, factors: &mut Factors) {
        let reciprocals: Vec<Id> = factors.keys().copied().collect();
        for reciprocal in reciprocals {
            let (base, one) = match *self.node(reciprocal) {
                Node::Power(base, -2) => (base, None),
                Node::Select(Comparison::Less, base, zero, none, other)
                    if *self.node(other) == Node::Power(base, -2)
                        && self.as_constant(zero) == Some(0.0)
                        && self.as_constant(none).is_some_and(f64::is_nan) =>
                {
                    (base, Some((zero, none)))
                }
                _ => continue,
            };
            let (Some(&above), Some(&below)) = (factors.get(&base), factors.get(&reciprocal)) else {
                continue;
            };
            let common = above.min(below);
            for id in [base, reciprocal] {
                if let Some(exponent) = factors.get_mut(&id) {
                    *exponent -= common;
                }
            }
            factors.retain(|_, exponent| *exponent > 0);
            if let Some((zero, none)) = one {
                let one = self.constant(1.0);
                let guarded = self.select(Comparison::Less, base, zero, none, one);
                *factors.entry(guarded).or_default() += common;
            }
        }
    }

    fn product_node(&mut self, factors: Factors) -> Option<Id> {
        let mut list = factors.into_iter();
        match (list.next(), list.len()) {
            (None, _) => None,
            (Some((base, exponent)), 0) => Some(self.power(base, 2 * exponent as i32)),
            (Some(first), _) => {
                let factors = std::iter::once(first).chain(list).collect();
                Some(self.insert(Node::Product(factors)))
            }
        }
    }

    /// The terms of a summand, one level deep.
    fn terms(&self, operand: Scaled, flatten: bool) -> Vec<(f64, Factors)> {
        let Some(node) = operand.node else {
            return vec![(operand.factor, Factors::new())];
        };
        if let (Node::Sum(terms), true) = (self.node(node), flatten) {
            let scaled: Option<Vec<_>> = terms
                .iter()
                .map(|&(bits, term)| {
                    let coefficient = exact_product(operand.factor, f64::from_bits(bits))?;
                    self.term(coefficient, term)
                })
                .collect();
            if let Some(scaled) = scaled.filter(|scaled| scaled.len() <= WIDTH) {
                return scaled;
            }
        }
        match self.term(operand.factor, node) {
            Some(term) => vec![term],
            None => vec![(operand.factor, Factors::from([(node, 1)]))],
        }
    }

    fn term(&self, factor: f64, node: Id) -> Option<(f64, Factors)> {
        if let Some(number) = self.as_constant(node) {
            return Some((exact_product(factor, number)?, Factors::new()));
        }
        let (sign, factors) = self.factors(node);
        Some((factor * sign, factors.into_iter().collect()))
    }

    /// Pulls out the factor that most terms share, until no two terms share one.
    fn factored(&mut self, mut terms: Vec<(f64, Factors)>) -> Vec<(f64, Factors)> {
        while let Some(best) = self.most_shared(&terms) {
            let (with, without): (Vec<_>, Vec<_>) =
                terms.into_iter().partition(|(_, factors)| factors.contains_key(&best));
            let common = common_factors(&with);
            let rest = with
                .into_iter()
                .map(|(factor, mut factors)| {
                    for (id, exponent) in &common {
                        if let Some(own) = factors.get_mut(id) {
                            *own -= exponent;
                        }
                    }
                    factors.retain(|_, exponent| *exponent > 0);
                    (factor, factors)
                })
                .collect();
            let inner = self.factored(rest);
            let inner = self.sum_of(inner);
            let mut factors = common;
            if let Some(node) = inner.node {
                *factors.entry(node).or_default() += 1;
            }
            terms = without;
            terms.push((inner.factor, factors));
        }
        terms
    }

    /// The factor in the most terms, at least two; among equals the deepest, so the dearest to repeat.
    fn most_shared(&self, terms: &[(f64, Factors)]) -> Option<Id> {
        let mut counts: BTreeMap<Id, usize> = BTreeMap::new();
        for id in terms.iter().flat_map(|(_, factors)| factors.keys()) {
            *counts.entry(*id).or_default() += 1;
        }
        let shared = counts.into_iter().filter(|&(_, count)| count >= 2);
        shared.max_by_key(|&(id, count)| (count, self.moving(id), self.depth(id), id)).map(|(id, _)| id)
    }

    /// The sum of terms that share nothing any more, scaled so that one coefficient is 1.
    fn sum_of(&mut self, terms: Vec<(f64, Factors)>) -> Scaled {
        let mut list: Vec<(f64, Id)> = Vec::with_capacity(terms.len());
        for (factor, factors) in terms {
            match self.product_node(factors) {
                Some(node) => list.push((factor, node)),
                None => {
                    let number = self.constant(factor);
                    list.push((1.0, number));
                }
            }
        }
        match list[..] {
            [] => return Scaled::ZERO,
            [(factor, node)] => {
                return match self.as_constant(node) {
                    Some(number) => Scaled::number(number * factor),
                    None => Scaled { factor, node: Some(node) },
                };
            }
            _ => {}
        }
        let scale = self.scale(&list);
        let mut scaled: Vec<(u64, Id)> = Vec::with_capacity(list.len());
        for (factor, node) in list {
            match self.as_constant(node) {
                Some(number) => {
                    let number = self.constant(number * factor / scale);
                    scaled.push((1.0_f64.to_bits(), number));
                }
                None => scaled.push(((factor / scale).to_bits(), node)),
            }
        }
        scaled.sort_by_key(|&(_, node)| node);
        Scaled { factor: scale, node: Some(self.insert(Node::Sum(scaled.into()))) }
    }

    /// The divisor that leaves the fewest multiplications, and divides every coefficient exactly.
    fn scale(&self, list: &[(f64, Id)]) -> f64 {
        let moving: Vec<f64> = list.iter().filter(|&&(_, id)| self.moving(id)).map(|&(c, _)| c).collect();
        let divides = |scale: f64| {
            list.iter().all(|&(factor, id)| {
                let number = self.as_constant(id).unwrap_or(1.0);
                exact_quotient(factor * number, scale).is_some()
            })
        };
        // By size: how often it occurs, and as what first.
        let mut sizes: BTreeMap<u64, (usize, f64)> = BTreeMap::new();
        for c in moving {
            sizes.entry(c.abs().to_bits()).or_insert((0, c)).0 += 1;
        }
        let mut sizes: Vec<(usize, f64)> = sizes.into_values().collect();
        sizes.sort_by_key(|&(count, _)| std::cmp::Reverse(count)); // stable: among equals the smallest
        let candidates = sizes.into_iter().take(SEARCH).map(|(_, c)| c);
        candidates.into_iter().find(|&c| divides(c)).unwrap_or(1.0)
    }
}

/// The powers that all of the terms have.
fn common_factors(terms: &[(f64, Factors)]) -> Factors {
    let Some(((_, first), rest)) = terms.split_first() else { return Factors::new() };
    let mut common = first.clone();
    for (_, factors) in rest {
        common.retain(|id, exponent| {
            *exponent = (*exponent).min(factors.get(id).copied().unwrap_or(0));
            *exponent > 0
        });
    }
    common
}
