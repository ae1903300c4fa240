//! Derivatives: one table of partial derivatives, swept backwards or forwards.
//!
//! ```text
//! reverse   x̄ = Σ f̄ ∂f/∂x      over all f computed from x:   the gradient of one root in one sweep
//! tangent   ḟ = Σ ∂f/∂x ẋ      over all x that f is made of: one direction, of any graph
//! ```
//!
//! The tangent of a gradient is the product Hessian · v, the tangent of a tangent is v · Hessian · v.
//! A branch is differentiated by selecting between the derivatives of its arms. It is never
//! multiplied with 0 or 1, so an arm that is not taken cannot leak its NaN: in the reverse sweep
//! the adjoint stops at a branch, and the arms are swept forwards, to one derivative per variable.
//! What may be infinite is multiplied with the arms of such a derivative, not with all of it (see `held`).

use crate::algebra::Scaled;
use crate::functions::{Binary, Function};
use crate::graph::{Graph, found_from};
use crate::node::{Comparison, Id, Input, Node};
use crate::rules::{derivative, derivatives};
use std::collections::BTreeMap;
use std::ops::Range;

/// One entry of the derivative table, for tests that plant a wrong one.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(missing_docs, reason = "the name says it")]
pub enum Rule {
    Negation,
    Sum,
    MinuendOf,
    SubtrahendOf,
    Product,
    Numerator,
    Denominator,
    Power,
    Call(Function),
    /// By the first argument, or by the second.
    Call2(Binary, usize),
    Branch,
}

/// A fault planted in the derivative table; tests must notice every one.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Fault {
    /// Which entry is wrong.
    pub rule: Rule,
    /// What it is multiplied by.
    pub factor: f64,
}

/// Differentiates the nodes of one graph.
pub struct Calculus<'a> {
    /// The graph, to which derivatives are added.
    pub graph: &'a mut Graph,
    fault: Option<Fault>,
    /// Derivatives by each variable, for the arms of branches.
    slopes: BTreeMap<u32, BTreeMap<Id, Scaled>>,
    /// The variables on which each node depends, as far as they were asked for.
    made_of: Vec<Vec<u64>>,
}

impl<'a> Calculus<'a> {
    /// For derivatives in this graph.
    pub fn new(graph: &'a mut Graph) -> Self {
        graph.begin_derivatives();
        Calculus { graph, fault: None, slopes: BTreeMap::new(), made_of: Vec::new() }
    }
    /// The same with a wrong entry in the table: for tests of tests.
    pub fn with_fault(graph: &'a mut Graph, fault: Fault) -> Self {
        Calculus { fault: Some(fault), ..Calculus::new(graph) }
    }

    /// The derivatives of Σ wᵢ rootᵢ by each of the variables.
    pub fn gradient(&mut self, roots: &[(Scaled, Id)], variables: u32) -> Vec<Scaled> {
        let mut gradient: Vec<Vec<Scaled>> = vec![Vec::new(); variables as usize];
        let mut adjoints: BTreeMap<Id, Vec<Scaled>> = BTreeMap::new();
        for &(weight, root) in roots {
            adjoints.entry(root).or_default().push(weight);
        }
        while let Some((id, contributions)) = adjoints.pop_last() {
            if !self.graph.moving(id) {
                continue;
            }
            let adjoint = self.graph.sum(&contributions);
            match *self.graph.node(id) {
                Node::Input(Input::Variable(k)) => {
                    if let Some(entry) = gradient.get_mut(k as usize) {
                        entry.push(adjoint);
                    }
                }
                Node::Select(..) => {
                    for k in self.variables_of(id) {
                        let Some(entry) = gradient.get_mut(k as usize) else { continue };
                        let slope = self.slope(id, k);
                        let value = sum_of(self.graph, roots);
                        entry.push(self.graph.product_with_branch(value, adjoint, slope));
                    }
                }
                _ => {
                    for (child, partial) in self.partials(id) {
                        let contribution = self.graph.product(&[adjoint, partial]);
                        adjoints.entry(child).or_default().push(contribution);
                    }
                }
            }
        }
        gradient.into_iter().map(|contributions| self.graph.sum(&contributions)).collect()
    }

    /// The derivatives of the roots for the derivatives of the inputs given by `seed`.
    pub fn tangents(&mut self, roots: &[Scaled], seed: impl Fn(&mut Graph, Input) -> Scaled) -> Vec<Scaled> {
        let mut known = BTreeMap::new();
        let nodes: Vec<Id> = roots.iter().filter_map(|root| root.node).collect();
        self.sweep(&nodes, seed, &mut known);
        roots
            .iter()
            .map(|root| {
                let tangent = root.node.and_then(|node| known.get(&node)).copied().unwrap_or(Scaled::ZERO);
                self.graph.product(&[Scaled::number(root.factor), tangent])
            })
            .collect()
    }

    fn sweep(
        &mut self,
        roots: &[Id],
        seed: impl Fn(&mut Graph, Input) -> Scaled,
        known: &mut BTreeMap<Id, Scaled>,
    ) {
        let graph = &*self.graph;
        let open = |id: &Id| graph.moving(*id) && !known.contains_key(id);
        let children = |id: Id| graph.node(id).children().into_iter().filter(open).collect();
        for id in found_from(roots.iter().copied().filter(open), children) {
            let of = |child: &Id| known.get(child).copied().unwrap_or(Scaled::ZERO);
            let tangent = match *self.graph.node(id) {
                Node::Input(input) => seed(self.graph, input),
                Node::Select(comparison, a, b, then, other) => {
                    let (none, other) = (self.graph.as_constant(then).is_some_and(f64::is_nan), of(&other));
                    // What is no number has no slope.
                    let then = if none && !other.is_zero() { then.into() } else { of(&then) };
                    let slope = self.branch(comparison, a, b, then, other);
                    if let (true, Some(slope)) = (self.graph.is_tip(id), slope.node) {
                        self.graph.tip(slope);
                    }
                    slope
                }
                _ => {
                    let moved: Vec<Scaled> = self
                        .partials(id)
                        .into_iter()
                        .map(|(child, partial)| {
                            let child = of(&child);
                            self.graph.product_with_branch(id, partial, child)
                        })
                        .collect();
                    self.graph.sum(&moved)
                }
            };
            known.insert(id, tangent);
        }
    }

    fn branch(&mut self, comparison: Comparison, a: Id, b: Id, then: Scaled, other: Scaled) -> Scaled {
        if then == other {
            return then;
        }
        let (then, other) = (self.graph.node_of(then), self.graph.node_of(other));
        let selected = self.graph.select(comparison, a, b, then, other);
        self.ruled(Rule::Branch, selected.into())
    }

    /// Whether the roots choose between numbers by some of the variables: by conditions, signs or whole parts, of which
    /// no slope tells.
    pub(crate) fn choose_by(&mut self, roots: &[Id], variables: Range<u32>) -> bool {
        let mut asked = Vec::new();
        for id in self.graph.reachable(roots) {
            match *self.graph.node(id) {
                Node::Select(_, a, b, ..) => asked.extend([a, b]),
                Node::Call(Function::Sign | Function::Floor, a) => asked.push(a),
                _ => {}
            }
        }
        asked.into_iter().any(|id| self.variables_of(id).iter().any(|k| variables.contains(k)))
    }

    /// The variables that a node is made of, ascending.
    fn variables_of(&mut self, id: Id) -> Vec<u32> {
        for node in self.made_of.len()..=id.index() {
            let mut set: Vec<u64> = Vec::new(); // a bit for each
            let node = self.graph.node(Id(node as u32));
            if let Node::Input(Input::Variable(k)) = *node {
                set.resize(k as usize / 64 + 1, 0);
                set[k as usize / 64] = 1 << (k % 64);
            }
            for child in node.children() {
                let other = &self.made_of[child.index()];
                set.resize(set.len().max(other.len()), 0);
                set.iter_mut().zip(other).for_each(|(own, other)| *own |= other);
            }
            self.made_of.push(set);
        }
        let set = &self.made_of[id.index()];
        (0..64 * set.len() as u32).filter(|k| set[*k as usize / 64] >> (k % 64) & 1 == 1).collect()
    }

    /// The derivative of a branch by one variable.
    fn slope(&mut self, id: Id, variable: u32) -> Scaled {
        let mut known = self.slopes.remove(&variable).unwrap_or_default();
        let seed = move |_: &mut Graph, input| match input {
            Input::Variable(k) if k == variable => Scaled::ONE,
            _ => Scaled::ZERO,
        };
        self.sweep(&[id], seed, &mut known);
        let slope = known.get(&id).copied().unwrap_or(Scaled::ZERO);
        self.slopes.insert(variable, known);
        slope
    }

    /// ∂f/∂x for every x that the node f is directly made of and that moves.
    fn partials(&mut self, f: Id) -> Vec<(Id, Scaled)> {
        let g = &mut *self.graph;
        let one = Scaled::ONE;
        let rules: Vec<(Rule, Id, Scaled)> = match g.node(f).clone() {
            Node::Constant(_) | Node::Input(_) | Node::Select(..) => vec![],
            Node::Neg(a) => vec![(Rule::Negation, a, one.times(-1.0))],
            Node::Add(a, b) => vec![(Rule::Sum, a, one), (Rule::Sum, b, one)],
            Node::Sub(a, b) => vec![(Rule::MinuendOf, a, one), (Rule::SubtrahendOf, b, one.times(-1.0))],
            Node::Mul(a, b) => vec![(Rule::Product, a, b.into()), (Rule::Product, b, a.into())],
            Node::Div(a, b) => {
                if let Some((b, exponent)) = g.power_of(f) {
                    let lower = g.div(f, b);
                    return vec![(b, self.ruled(Rule::Denominator, Scaled::from(lower).times(exponent)))];
                }
                let above = g.reciprocal(b);
                let sine = above.node.and_then(|reciprocal| slopes_of_sine(g, a, reciprocal, b));
                match sine {
                    Some(slopes) => {
                        let rules = [Rule::Numerator, Rule::Denominator].into_iter().zip(slopes);
                        rules.map(|(rule, (by, times))| (rule, by, g.product(&times))).collect()
                    }
                    None => {
                        let (b, below) = g.slope_of_reciprocal(b, f, 1.0);
                        vec![(Rule::Numerator, a, above), (Rule::Denominator, b, below)]
                    }
                }
            }
            Node::Power(a, halves) if halves < 0 => {
                let (a, power) = g.slope_of_reciprocal(a, f, f64::from(-halves) / 2.0);
                vec![(Rule::Power, a, power)]
            }
            Node::Power(a, halves) => {
                // What is smooth at 0 though a is not, and the slope of a is set to 0 there: even powers of √u are
                // those of u, third powers of ∛u too, and the slopes of dⁿ, d = hypot(u, v), are n dⁿ⁻² u and n dⁿ⁻² v.
                // Where √u is no number these slopes are none either.
                let (mut a, mut halves, mut rooted) = (a, halves, false);
                loop {
                    (a, halves, rooted) = match *g.node(a) {
                        // Not of √u to the first: it would be a root again.
                        Node::Call(Function::Sqrt, inside) if halves > 2 && halves % 2 == 0 => {
                            (inside, halves / 2, true)
                        }
                        Node::Call(Function::Cbrt, inside) if halves % 6 == 0 => (inside, halves / 3, rooted),
                        _ => break,
                    };
                }
                let exponent = Scaled::number(f64::from(halves) / 2.0);
                match (halves >= 4).then(|| sides(g, a)).flatten() {
                    Some(sides) => {
                        let lower = g.power(a, halves - 4);
                        let slope = |(u, times): (Id, f64)| {
                            let times = Scaled::number(times);
                            (Rule::Power, u, g.product(&[exponent, times, lower.into(), u.into()]))
                        };
                        sides.into_iter().map(slope).collect()
                    }
                    None => {
                        let lower = g.power(a, halves - 2);
                        let slope = g.product(&[exponent, lower.into()]);
                        vec![(Rule::Power, a, if rooted { g.unless_negative(a, slope) } else { slope })]
                    }
                }
            }
            Node::Call(function, a) => vec![(Rule::Call(function), a, derivative(function, g, a, f))],
            Node::Call2(function, a, b) => {
                let [first, second] = derivatives(function, g, a, b, f);
                vec![(Rule::Call2(function, 0), a, first), (Rule::Call2(function, 1), b, second)]
            }
            Node::Sum(terms) => {
                terms.iter().map(|&(bits, a)| (Rule::Sum, a, Scaled::number(f64::from_bits(bits)))).collect()
            }
            Node::Product(factors) => of_product(g, &factors),
        };
        let moving: Vec<_> = rules.into_iter().filter(|&(_, x, _)| self.graph.moving(x)).collect();
        moving.into_iter().map(|(rule, x, partial)| (x, self.ruled(rule, partial))).collect()
    }

    fn ruled(&self, rule: Rule, partial: Scaled) -> Scaled {
        match self.fault {
            Some(fault) if fault.rule == rule => partial.times(fault.factor),
            _ => partial,
        }
    }
}

/// The root, or the sum of several: no number where one of them is none.
fn sum_of(graph: &mut Graph, roots: &[(Scaled, Id)]) -> Id {
    if let [(_, root)] = *roots {
        return root;
    }
    let roots: Vec<Scaled> = roots.iter().map(|&(_, root)| root.into()).collect();
    let sum = graph.sum(&roots);
    graph.node_of(sum)
}

/// The slopes of a product by its factors. Two of them whose slopes would cancel have one together.
fn of_product(g: &mut Graph, factors: &[(Id, u32)]) -> Vec<(Rule, Id, Scaled)> {
    let pair = (0..factors.len()).find_map(|i| (0..factors.len()).find_map(|j| Pair::of(g, factors, [i, j])));
    let left = |i: usize, gone: &[usize]| factors[i].1 - u32::from(gone.contains(&i));
    let mut slopes = Vec::new();
    let mut slope = |g: &mut Graph, by: Id, gone: &[usize], times: Vec<Scaled>| {
        let rest = (0..factors.len()).filter(|&j| left(j, gone) > 0);
        let rest: Vec<Scaled> =
            rest.map(|j| g.power(factors[j].0, 2 * left(j, gone) as i32).into()).collect();
        slopes.push((Rule::Product, by, g.product(&[times, rest].concat())));
    };
    let Pair { places: taken, slopes: together } = pair.unwrap_or_default();
    for (by, times) in together {
        slope(g, by, &taken, times);
    }
    for i in (0..factors.len()).filter(|i| !taken.contains(i)) {
        slope(g, factors[i].0, &[i], vec![Scaled::number(f64::from(factors[i].1))]);
    }
    slopes
}

/// Two factors of a product whose slopes nearly cancel somewhere, and the slopes of both together. Only of products
/// that derivatives make: what a user writes is differentiated as it is written, but for x / f.
///
/// ```text
/// (x − 1)(x + 1)            2x                        not (x − 1) + (x + 1), which loses it near 0
/// x / f, f = √(x² + c)      c / f³                    not 1/f − x²/f³, which loses it far out
/// x / f, f = √(x² + y²)     y² / f³ and −x y / f³
/// ```
#[derive(Default)]
struct Pair {
    places: Vec<usize>,
    slopes: Vec<(Id, Vec<Scaled>)>,
}

impl Pair {
    fn of(g: &Graph, factors: &[(Id, u32)], [i, j]: [usize; 2]) -> Option<Pair> {
        let [(a, times), (b, others)] = [i, j].map(|place| factors[place]);
        if i == j || times != 1 || others != 1 {
            return None;
        }
        let places = vec![i, j];
        if let (Some((x, less)), Some((y, more))) = (beside_number(g, a), beside_number(g, b))
            && (x, less) == (y, -more)
            && less < 0.0
        {
            return Some(Pair { places, slopes: vec![(x, vec![Scaled { factor: 2.0, node: Some(x) }])] });
        }
        let slopes = slopes_of_sine(g, a, b, divisor(g, b)?)?;
        Some(Pair { places, slopes })
    }
}

/// The slopes of x / f, where f = √(x² + …), and the reciprocal of f is known.
fn slopes_of_sine(g: &Graph, x: Id, reciprocal: Id, f: Id) -> Option<Vec<(Id, Vec<Scaled>)>> {
    let cube = [reciprocal; 3].map(Scaled::from);
    let times = |factors: &[Scaled]| [factors, &cube].concat();
    match far_side(g, f, x)? {
        Side::Square(y) => {
            let (x, y) = (Scaled::from(x), Scaled::from(y));
            Some(vec![(x.node?, times(&[y, y])), (y.node?, times(&[x.times(-1.0), y]))])
        }
        Side::Number(c) => Some(vec![(x, times(&[c]))]),
    }
}

/// What is added to x² under the root.
enum Side {
    /// The square of this.
    Square(Id),
    /// What stays.
    Number(Scaled),
}

/// x and c of the sum x + c.
fn beside_number(graph: &Graph, sum: Id) -> Option<(Id, f64)> {
    let Node::Sum(ref terms) = *graph.node(sum) else { return None };
    let [(one, a), (other, b)] = **terms else { return None };
    let (x, number) = match (graph.as_constant(a), graph.as_constant(b)) {
        (Some(number), None) => (b, number),
        (None, Some(number)) => (a, number),
        _ => return None,
    };
    (one == 1.0_f64.to_bits() && other == one).then_some((x, number))
}

/// f of 1/f, perhaps guarded at 0.
fn divisor(g: &Graph, reciprocal: Id) -> Option<Id> {
    match *g.node(reciprocal) {
        Node::Power(f, -2) => Some(f),
        // Guards of other kinds are a user's.
        Node::Select(Comparison::LessOrEqual, f, least, then, other)
            if [least, then].iter().all(|&id| g.as_constant(id) == Some(0.0)) =>
        {
            (*g.node(other) == Node::Power(f, -2)).then_some(f)
        }
        _ => None,
    }
}

/// What f is made of beside x: hypot(x, y), √(x² + y²), or √(x² ± c).
fn far_side(g: &Graph, f: Id, x: Id) -> Option<Side> {
    let root = |id: Id| match *g.node(id) {
        Node::Power(y, 4) => Some(y),
        _ => None,
    };
    let other = |a: Id, b: Id, x: Id| if a == x { Some(b) } else { (b == x).then_some(a) };
    match *g.node(f) {
        Node::Call2(Binary::Hypot, a, b) => other(a, b, x).map(Side::Square),
        Node::Call(Function::Sqrt, sum) => {
            let square = g.find(&Node::Power(x, 4))?;
            match *g.node(sum) {
                Node::Add(a, b) => {
                    let rest = other(a, b, square)?;
                    match root(rest) {
                        Some(y) => Some(Side::Square(y)),
                        None => (!g.moving(rest)).then_some(Side::Number(rest.into())),
                    }
                }
                Node::Sub(a, c) if a == square && !g.moving(c) => {
                    Some(Side::Number(Scaled::from(c).times(-1.0)))
                }
                _ => None,
            }
        }
        _ => None,
    }
}

/// Powers of distances of more sides are differentiated as powers of any number: of a chain of them the work would grow
/// as the square of its length.
const MOST_SIDES: usize = 64;

/// What √(u² + v² + …) is made of, and how often it holds each, where it is a hypot, perhaps of others, of not too many
/// sides.
fn sides(graph: &Graph, distance: Id) -> Option<Vec<(Id, f64)>> {
    let (mut open, mut found) = (BTreeMap::from([(distance, 1.0)]), Vec::new());
    while let Some((side, times)) = open.pop_last() {
        match *graph.node(side) {
            Node::Call2(Binary::Hypot, u, v) => {
                for part in [u, v] {
                    *open.entry(part).or_default() += times;
                }
            }
            _ if side == distance || found.len() == MOST_SIDES => return None,
            _ => found.push((side, times)),
        }
    }
    Some(found)
}
