//! The expression graph: every distinct subexpression once, children before parents.
//!
//! Nodes are appended and never changed, and equal nodes are the same node (hash-consing), so a
//! pass over a graph is a loop over a vector. There are two ways to build:
//!
//! * The methods here follow the *value policy*: what they build computes, bit for bit, what the
//!   user wrote. They only do what IEEE 754 guarantees: equal operations share a node, operands of
//!   `+` and `×` may swap, `1·x`, `x/1`, `x − 0` and `−(−x)` vanish, and constants fold where the
//!   result is exact. The one exception is the root of an even power, |x| to half of it: the same
//!   bits where the power has all its digits, and the better number where it has not.
//! * The methods in [`algebra`](crate::algebra) follow the *derivative policy*: any algebraic form
//!   will do, as long as it is always the same one. They use the n-ary `Sum` and `Product`.

use crate::functions::{Binary, Function};
use crate::node::{Comparison, Id, Input, Node};
use crate::operation::{Number, never_negative, operation};
use std::cell::Cell;
use std::collections::{BTreeSet, HashMap};

/// A set of expressions that share their common parts.
#[derive(Clone, Default, Debug)]
pub struct Graph {
    nodes: Vec<Node>,
    moving: Vec<bool>,
    depth: Vec<u32>,
    number: Vec<Option<f64>>,
    never_negative: Vec<bool>,
    may_be_infinite: Vec<bool>,
    holds_zero: Vec<bool>,
    tips: BTreeSet<Id>,
    steps: Cell<usize>,
    /// How many nodes there were before the first derivative.
    written: Option<usize>,
    index: HashMap<Node, Id>, // looked up, never iterated: its order cannot reach the output
}

impl Graph {
    /// An empty graph.
    pub fn new() -> Self {
        Self::default()
    }
    /// The number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }
    /// Whether there is no node.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }
    /// The operation of a node.
    pub fn node(&self, id: Id) -> &Node {
        self.count(1);
        &self.nodes[id.index()]
    }
    /// Whether the node depends on inputs other than parameters.
    pub fn moving(&self, id: Id) -> bool {
        self.moving[id.index()]
    }
    /// Whether the form of the node makes it 0 or more, or no number, whatever its inputs are.
    pub(crate) fn never_negative(&self, id: Id) -> bool {
        self.never_negative[id.index()]
    }
    /// Whether there is a division by what moves in the node, or what may be one.
    pub(crate) fn may_be_infinite(&self, id: Id) -> bool {
        self.may_be_infinite[id.index()]
    }
    /// Notes that nothing in the node is divided by 0.
    pub(crate) fn finite(&mut self, id: Id) {
        self.may_be_infinite[id.index()] = false;
    }
    /// Whether the node is a branch with an arm 0, or has such a branch as a factor or a summand.
    pub(crate) fn holds_zero(&self, id: Id) -> bool {
        self.holds_zero[id.index()]
    }
    /// The same, but for the slopes at the tips of roots: nothing is infinite with these.
    pub(crate) fn is_held(&self, id: Id) -> bool {
        self.holds_zero(id) && !self.is_tip(id)
    }
    /// Whether the node is a slope that is set to 0 at the tip of a root, or the slope of one.
    pub(crate) fn is_tip(&self, id: Id) -> bool {
        self.tips.contains(&id)
    }
    /// Notes that it is.
    pub(crate) fn tip(&mut self, id: Id) -> Id {
        self.tips.insert(id);
        id
    }
    /// The longest chain of operations below the node.
    pub fn depth(&self, id: Id) -> u32 {
        self.depth[id.index()]
    }
    /// The number, if the node is a constant.
    pub fn as_constant(&self, id: Id) -> Option<f64> {
        match *self.node(id) {
            Node::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }
    /// The value of the node, computed as at run time, if it does not depend on inputs.
    pub fn number(&self, id: Id) -> Option<f64> {
        self.number[id.index()]
    }
    pub(crate) fn find(&self, node: &Node) -> Option<Id> {
        self.index.get(node).copied()
    }
    /// How often a node was made, found or read: a measure of the work so far.
    pub fn steps(&self) -> usize {
        self.steps.get()
    }
    fn count(&self, steps: usize) {
        self.steps.set(self.steps.get() + steps);
    }
    /// All nodes from which the roots are computed, and the roots, children first.
    pub fn reachable(&self, roots: &[Id]) -> Vec<Id> {
        self.count(self.len());
        let mut seen = vec![false; self.len()];
        for root in roots {
            seen[root.index()] = true;
        }
        for i in (0..self.len()).rev() {
            if seen[i] {
                for child in self.nodes[i].children() {
                    seen[child.index()] = true;
                }
            }
        }
        (0..self.len() as u32).map(Id).filter(|id| seen[id.index()]).collect()
    }

    /// The number of operations per evaluation of the roots: without those that depend on parameters alone.
    pub fn operations(&self, roots: &[Id]) -> usize {
        let counts = |id: &Id| self.moving(*id) && !matches!(self.node(*id), Node::Input(_));
        self.reachable(roots).iter().filter(|id| counts(id)).count()
    }

    /// The number of operations of parameters alone, wherever they are used.
    pub(crate) fn still_operations(&self) -> usize {
        let counts = |i: &usize| {
            !self.moving[*i] && self.number[*i].is_none() && !matches!(self.nodes[*i], Node::Input(_))
        };
        (0..self.len()).filter(counts).count()
    }

    /// The values of the roots: the reference for generated code.
    pub fn evaluate<N: Number>(&self, roots: &[Id], input: impl Fn(Input) -> N) -> Vec<N> {
        let mut values = vec![N::from_f64(0.0); self.len()];
        for id in self.reachable(roots) {
            values[id.index()] = operation(self.node(id), |id| values[id.index()], &input);
        }
        roots.iter().map(|root| values[root.index()]).collect()
    }

    /// From now on nodes are of derivatives, if they are not already.
    pub(crate) fn begin_derivatives(&mut self) {
        self.written.get_or_insert(self.nodes.len());
    }
    /// Whether the node is the user's, not one of a derivative.
    pub(crate) fn is_written(&self, id: Id) -> bool {
        self.written.is_none_or(|written| id.index() < written)
    }

    pub(crate) fn insert(&mut self, node: Node) -> Id {
        self.count(1);
        if let Some(&id) = self.index.get(&node) {
            return id;
        }
        let id = Id(u32::try_from(self.nodes.len()).expect("the size check in `lower` keeps graphs small"));
        let children = node.children();
        self.moving.push(match node {
            Node::Input(input) => !matches!(input, Input::Parameter(_)),
            _ => children.iter().any(|&child| self.moving(child)),
        });
        let known = children.iter().all(|&child| self.number(child).is_some());
        self.number.push(if known { self.compute(&node) } else { None });
        let of = |id| self.never_negative(id);
        self.never_negative.push(never_negative(&node, of, |id| self.number(id)));
        let infinite = children.iter().any(|&child| self.may_be_infinite(child)) || self.divides(&node);
        self.may_be_infinite.push(infinite);
        self.holds_zero.push(match node {
            Node::Select(_, _, _, then, other) => {
                [then, other].iter().any(|&arm| self.as_constant(arm) == Some(0.0) || self.holds_zero(arm))
            }
            Node::Neg(_) | Node::Mul(..) | Node::Sum(_) | Node::Product(_) => {
                children.iter().any(|&child| self.is_held(child))
            }
            Node::Power(a, halves) => halves > 0 && halves % 2 == 0 && self.is_held(a),
            _ => false,
        });
        self.depth.push(children.iter().map(|&child| self.depth(child) + 1).max().unwrap_or(0));
        self.nodes.push(node.clone());
        self.index.insert(node, id);
        id
    }

    /// A number.
    pub fn constant(&mut self, x: f64) -> Id {
        self.insert(Node::Constant(x.to_bits()))
    }
    /// An input.
    pub fn input(&mut self, input: Input) -> Id {
        self.insert(Node::Input(input))
    }
    /// −a
    pub fn neg(&mut self, a: Id) -> Id {
        match *self.node(a) {
            Node::Constant(bits) => self.constant(-f64::from_bits(bits)),
            Node::Neg(inner) => inner,
            _ => self.insert(Node::Neg(a)),
        }
    }
    /// a + b
    pub fn add(&mut self, a: Id, b: Id) -> Id {
        if let Some(sum) = self.fold(a, b, exact_sum) {
            return sum;
        }
        self.insert(Node::Add(a.min(b), a.max(b)))
    }
    /// a − b
    pub fn sub(&mut self, a: Id, b: Id) -> Id {
        if let Some(difference) = self.fold(a, b, |a, b| exact_sum(a, -b)) {
            return difference;
        }
        match *self.node(b) {
            Node::Constant(bits) if bits == 0.0_f64.to_bits() => a,
            Node::Neg(inner) => self.add(a, inner),
            _ => self.insert(Node::Sub(a, b)),
        }
    }
    /// a · b
    pub fn mul(&mut self, a: Id, b: Id) -> Id {
        if a == b && self.as_constant(a).is_none() {
            return self.power(a, 4);
        }
        if let Some(product) = self.fold(a, b, exact_product) {
            return product;
        }
        match (self.as_constant(a), self.as_constant(b)) {
            (Some(1.0), _) => b,
            (_, Some(1.0)) => a,
            _ => self.insert(Node::Mul(a.min(b), a.max(b))),
        }
    }
    /// a / b
    pub fn div(&mut self, a: Id, b: Id) -> Id {
        if let Some(quotient) = self.fold(a, b, exact_quotient) {
            return quotient;
        }
        match (self.as_constant(a), self.as_constant(b)) {
            (_, Some(1.0)) => a,
            (Some(1.0), _) => self.insert(Node::Power(b, -2)),
            _ => self.insert(Node::Div(a, b)),
        }
    }
    /// a^(halves/2)
    pub fn power(&mut self, a: Id, halves: i32) -> Id {
        match halves {
            0 => self.constant(1.0),
            1 => self.call(Function::Sqrt, a),
            2 => a,
            _ if self.as_constant(a) == Some(1.0) => a,
            _ => self.insert(Node::Power(a, halves)),
        }
    }
    /// f(a). The root of a square is an absolute value, whose edge is known as one.
    pub fn call(&mut self, function: Function, a: Id) -> Id {
        match *self.node(a) {
            Node::Power(u, halves) if function == Function::Sqrt && halves > 0 && halves % 4 == 0 => {
                let size = if halves % 8 == 0 { u } else { self.insert(Node::Call(Function::Abs, u)) };
                self.power(size, halves / 2)
            }
            _ => self.insert(Node::Call(function, a)),
        }
    }
    /// f(a, b)
    pub fn call2(&mut self, function: Binary, a: Id, b: Id) -> Id {
        self.insert(Node::Call2(function, a, b))
    }
    /// `then` where the comparison of a with b holds, else `other`.
    pub fn select(&mut self, comparison: Comparison, a: Id, b: Id, then: Id, other: Id) -> Id {
        if then == other { then } else { self.insert(Node::Select(comparison, a, b, then, other)) }
    }
    /// The smaller of a and b; a on a tie or where either is NaN.
    pub fn min(&mut self, a: Id, b: Id) -> Id {
        self.select(Comparison::Less, b, a, b, a)
    }
    /// The larger of a and b; a on a tie or where either is NaN.
    pub fn max(&mut self, a: Id, b: Id) -> Id {
        self.select(Comparison::Less, a, b, b, a)
    }

    /// Whether the operation is a division by what moves, or may be one.
    fn divides(&self, node: &Node) -> bool {
        match *node {
            Node::Div(_, by) => self.moving(by),
            Node::Power(by, halves) => halves < 0 && self.moving(by),
            Node::Call2(Binary::Powf, a, exponent) => {
                (self.moving(a) || self.moving(exponent)) && self.number(exponent).is_none_or(|y| y < 0.0)
            }
            _ => false,
        }
    }

    fn compute(&self, node: &Node) -> Option<f64> {
        match node {
            Node::Input(_) => None,
            _ => Some(operation(node, |id| self.number(id).unwrap_or(f64::NAN), |_| f64::NAN)),
        }
    }

    fn fold(&mut self, a: Id, b: Id, operation: fn(f64, f64) -> Option<f64>) -> Option<Id> {
        let folded = operation(self.as_constant(a)?, self.as_constant(b)?)?;
        Some(self.constant(folded))
    }
}

/// The nodes come upon from these by way of `next`, which gives smaller ones; ascending. It takes as long as they are
/// many, however large the graph is.
pub(crate) fn found_from(start: impl IntoIterator<Item = Id>, next: impl Fn(Id) -> Vec<Id>) -> Vec<Id> {
    let mut open: BTreeSet<Id> = start.into_iter().collect();
    let mut found = Vec::new();
    while let Some(id) = open.pop_last() {
        open.extend(next(id));
        found.push(id);
    }
    found.reverse();
    found
}

/// a + b where no rounding happens.
pub(crate) fn exact_sum(a: f64, b: f64) -> Option<f64> {
    let sum = a + b;
    let b_seen = sum - a;
    let error = (a - (sum - b_seen)) + (b - b_seen); // Knuth's TwoSum
    (sum.is_finite() && error == 0.0).then_some(sum)
}

/// a · b where no rounding happens.
pub(crate) fn exact_product(a: f64, b: f64) -> Option<f64> {
    let product = a * b;
    let sound = product.is_normal() || ((a == 0.0 || b == 0.0) && product == 0.0);
    (sound && a.mul_add(b, -product) == 0.0).then_some(product)
}

/// a / b where no rounding happens.
pub(crate) fn exact_quotient(a: f64, b: f64) -> Option<f64> {
    let quotient = a / b;
    let sound = b != 0.0 && (quotient.is_normal() || (a == 0.0 && quotient == 0.0));
    (sound && quotient.mul_add(b, -a) == 0.0).then_some(quotient)
}
