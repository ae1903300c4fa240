//! From sums and products of many operands to a sequence of binary operations.
//!
//! The order in which operands are combined decides how much is shared. The pair that occurs most often in all products
//! (then in all sums) is computed once and replaced everywhere, again and again, until no pair occurs twice; pairs that
//! the value computes anyway are free. Operands that depend on parameters alone are combined first, so that they are
//! computed once per parameter set and not per call. The rest is combined shallowest first, for short chains of
//! dependent operations.

use crate::algebra::Scaled;
use crate::functions::Function;
use crate::graph::Graph;
use crate::node::{Id, Node};
use crate::operation::chain;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

/// An operand of a bag: an entry, and whether it is subtracted (in sums only).
type Operand = (usize, bool);

/// What an operand of a bag stands for.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
enum Entry {
    /// A node of the source graph.
    Node(Id),
    /// A coefficient, by its bits.
    Number(u64),
    /// The product or sum of the operands.
    Bag(Kind, Vec<Operand>),
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
enum Kind {
    Product,
    Sum,
}

/// Writes the roots into `target` with binary operations only. Returns them in the same order.
pub fn schedule(source: &Graph, roots: &[Scaled], target: &mut Graph) -> Vec<Id> {
    let mut scheduler = Scheduler::new(source);
    scheduler.collect(roots);
    for kind in [Kind::Product, Kind::Sum] {
        scheduler.share(kind, roots);
    }
    scheduler.write(roots, target)
}

struct Scheduler<'a> {
    source: &'a Graph,
    entries: Vec<Entry>,
    places: BTreeMap<Entry, usize>,
    /// The bag of each sum and product of the source.
    bags: BTreeMap<Id, usize>,
    /// The bag of each multiple c·x, by the bits of |c|.
    multiples: BTreeMap<(u64, Id), usize>,
}

impl<'a> Scheduler<'a> {
    fn new(source: &'a Graph) -> Self {
        Scheduler {
            source,
            entries: Vec::new(),
            places: BTreeMap::new(),
            bags: BTreeMap::new(),
            multiples: BTreeMap::new(),
        }
    }

    fn entry(&mut self, entry: Entry) -> usize {
        let next = self.entries.len();
        let place = *self.places.entry(entry.clone()).or_insert(next);
        if place == next {
            self.entries.push(entry);
        }
        place
    }

    fn collect(&mut self, roots: &[Scaled]) {
        let nodes: Vec<Id> = roots.iter().filter_map(|root| root.node).collect();
        for id in self.source.reachable(&nodes) {
            match self.source.node(id) {
                Node::Product(factors) => {
                    let factors = factors.to_vec();
                    let place = self.product(1.0, &factors);
                    self.bags.insert(id, place);
                }
                Node::Sum(terms) => {
                    let terms = terms.to_vec();
                    let place = self.sum(&terms);
                    self.bags.insert(id, place);
                }
                _ => {
                    self.place(id);
                }
            }
        }
        for root in roots {
            if let Some(node) = root.node {
                self.multiple(root.factor, node);
            }
        }
    }

    fn product(&mut self, coefficient: f64, factors: &[(Id, u32)]) -> usize {
        let mut still = Vec::new();
        let mut moving = Vec::new();
        for &(id, exponent) in factors {
            let place = self.place(id);
            let side = if self.source.moving(id) { &mut moving } else { &mut still };
            side.extend((0..exponent).map(|_| (place, false)));
        }
        if coefficient != 1.0 {
            still.push((self.entry(Entry::Number(coefficient.to_bits())), false));
        }
        self.gathered(Kind::Product, still, moving)
    }

    fn sum(&mut self, terms: &[(u64, Id)]) -> usize {
        let mut still = Vec::new();
        let mut moving = Vec::new();
        for &(bits, id) in terms {
            let coefficient = f64::from_bits(bits);
            let place = self.multiple(coefficient, id);
            let side = if self.source.moving(id) { &mut moving } else { &mut still };
            side.push((place, coefficient < 0.0));
        }
        self.gathered(Kind::Sum, still, moving)
    }

    /// The bag of both, where what stands still is one operand.
    fn gathered(&mut self, kind: Kind, mut still: Vec<Operand>, mut moving: Vec<Operand>) -> usize {
        if !moving.is_empty() {
            match still.len() {
                0 => {}
                1 => moving.append(&mut still),
                _ => {
                    // Signs of a subtracted constant stay outside, where a subtraction is free.
                    let flip = still.iter().all(|&(_, negative)| negative);
                    let inner =
                        still.into_iter().map(|(place, negative)| (place, negative != flip)).collect();
                    let place = self.bag(kind, inner);
                    moving.push((place, flip));
                }
            }
            still = moving;
        }
        self.bag(kind, still)
    }

    fn bag(&mut self, kind: Kind, mut operands: Vec<Operand>) -> usize {
        if let [(place, false)] = operands[..] {
            return place;
        }
        operands.sort_unstable();
        self.entry(Entry::Bag(kind, operands))
    }

    /// The entry of |c|·x.
    fn multiple(&mut self, coefficient: f64, id: Id) -> usize {
        let size = coefficient.abs();
        if size == 1.0 {
            return self.place(id);
        }
        if let Some(&place) = self.multiples.get(&(size.to_bits(), id)) {
            return place;
        }
        let factors = match self.source.node(id) {
            Node::Product(factors) => factors.to_vec(),
            _ => vec![(id, 1)],
        };
        let place = self.product(size, &factors);
        self.multiples.insert((size.to_bits(), id), place);
        place
    }

    fn place(&mut self, id: Id) -> usize {
        match self.bags.get(&id) {
            Some(&place) => place,
            None => self.entry(Entry::Node(id)),
        }
    }

    /// The places that the roots need, by place.
    fn live(&self, roots: &[Scaled]) -> Vec<bool> {
        let mut live = vec![false; self.entries.len()];
        let mut stack: Vec<usize> = roots.iter().filter_map(|root| self.root_place(root)).collect();
        while let Some(place) = stack.pop() {
            if std::mem::replace(&mut live[place], true) {
                continue;
            }
            match &self.entries[place] {
                Entry::Number(_) => {}
                Entry::Node(id) => {
                    let children = self.source.node(*id).children();
                    stack.extend(children.iter().filter_map(|child| self.known_place(*child)));
                }
                Entry::Bag(_, operands) => stack.extend(operands.iter().map(|&(place, _)| place)),
            }
        }
        live
    }

    fn root_place(&self, root: &Scaled) -> Option<usize> {
        let node = root.node?;
        match self.multiples.get(&(root.factor.abs().to_bits(), node)) {
            Some(&place) => Some(place),
            None => self.known_place(node),
        }
    }

    fn known_place(&self, id: Id) -> Option<usize> {
        self.bags.get(&id).or_else(|| self.places.get(&Entry::Node(id))).copied()
    }

    /// Computes pairs that occur in several bags of the kind once.
    fn share(&mut self, kind: Kind, roots: &[Scaled]) {
        let live = self.live(roots);
        let mut pairs = Pairs::default();
        for (place, entry) in self.entries.iter().enumerate() {
            match entry {
                Entry::Node(id) if live[place] => {
                    let operands = match (kind, self.source.node(*id)) {
                        (Kind::Product, Node::Mul(a, b)) => [(a, false), (b, false)],
                        (Kind::Product, Node::Power(a, 4..)) => [(a, false), (a, false)],
                        (Kind::Sum, Node::Add(a, b)) => [(a, false), (b, false)],
                        (Kind::Sum, Node::Sub(a, b)) => [(a, false), (b, true)],
                        _ => continue,
                    };
                    if let [(Some(a), _), (Some(b), minus)] =
                        operands.map(|(id, negative)| (self.known_place(*id), negative))
                    {
                        pairs.free.insert(pair((a, false), (b, minus)).0);
                    }
                }
                _ => {}
            }
        }
        // Only now, since what is free decides the order.
        for (place, entry) in self.entries.iter().enumerate() {
            match entry {
                Entry::Bag(own, operands) if live[place] && *own == kind => pairs.add(place, operands),
                _ => {}
            }
        }
        while let Some(((a, b, minus), bags)) = pairs.best() {
            let operands = vec![(a, false), (b, minus)];
            let known = self.places.get(&Entry::Bag(kind, operands.clone())).copied();
            let place = self.entry(Entry::Bag(kind, operands));
            for bag in bags.into_iter().filter(|&bag| Some(bag) != known) {
                let Entry::Bag(_, operands) = &self.entries[bag] else { continue };
                let mut operands = operands.clone();
                pairs.remove(bag, &operands);
                replace(&mut operands, (a, b, minus), place);
                pairs.add(bag, &operands);
                self.entries[bag] = Entry::Bag(kind, operands);
            }
            pairs.retire((a, b, minus));
        }
    }

    /// How often each place is an operand.
    fn uses(&self, live: &[bool]) -> Vec<u32> {
        let mut uses = vec![0; self.entries.len()];
        for (place, entry) in self.entries.iter().enumerate().filter(|&(place, _)| live[place]) {
            let operands: Vec<usize> = match entry {
                Entry::Number(_) => vec![],
                Entry::Node(id) => {
                    let children = self.source.node(*id).children();
                    children.iter().filter_map(|child| self.known_place(*child)).collect()
                }
                Entry::Bag(_, operands) => operands.iter().map(|&(place, _)| place).collect(),
            };
            debug_assert!(!operands.contains(&place), "no entry is its own operand");
            for operand in operands {
                uses[operand] += 1;
            }
        }
        uses
    }

    fn write(&self, roots: &[Scaled], target: &mut Graph) -> Vec<Id> {
        let live = self.live(roots);
        let mut uses = self.uses(&live);
        for root in roots.iter().filter_map(|root| self.root_place(root)) {
            uses[root] += 1;
        }
        let mut writer = Writer { scheduler: self, uses, target, written: vec![None; self.entries.len()] };
        let nodes: Vec<Id> = roots.iter().filter_map(|root| root.node).collect();
        for id in self.source.reachable(&nodes) {
            if let Some(place) = self.known_place(id).filter(|&place| live[place]) {
                writer.place(place);
            }
        }
        roots.iter().map(|root| writer.root(root)).collect()
    }
}

/// A pair of operands up to a common sign: the two places, and whether the signs differ.
type Pair = (usize, usize, bool);

/// The pair, and whether the first of the two was subtracted.
fn pair(a: Operand, b: Operand) -> (Pair, bool) {
    let (a, b) = if a <= b { (a, b) } else { (b, a) };
    ((a.0, b.0, a.1 != b.1), a.1)
}

/// Longer bags take no part: their pairs would be too many.
const LONGEST: usize = 24;

/// In which bags the pairs of operands occur, ordered by how much sharing them saves.
#[derive(Default)]
struct Pairs {
    free: BTreeSet<Pair>,
    places: BTreeMap<Pair, Occurrences>,
    queue: BTreeSet<(usize, Reverse<Pair>)>,
}

/// How often a pair can be taken out of each bag, and out of all of them.
#[derive(Default)]
struct Occurrences {
    bags: BTreeMap<usize, usize>,
    total: usize,
}

impl Pairs {
    fn add(&mut self, bag: usize, operands: &[Operand]) {
        for (pair, count) in pairs_of(operands) {
            self.change(pair, |own| {
                own.total += count;
                own.bags.insert(bag, count);
            });
        }
    }
    fn remove(&mut self, bag: usize, operands: &[Operand]) {
        for (pair, _) in pairs_of(operands) {
            self.change(pair, |own| own.total -= own.bags.remove(&bag).unwrap_or(0));
        }
    }
    fn retire(&mut self, pair: Pair) {
        self.change(pair, |own| *own = Occurrences::default());
    }
    fn change(&mut self, pair: Pair, change: impl FnOnce(&mut Occurrences)) {
        let bonus = usize::from(self.free.contains(&pair));
        let own = self.places.entry(pair).or_default();
        self.queue.remove(&(own.total + bonus, Reverse(pair)));
        change(own);
        if !own.bags.is_empty() && own.total + bonus >= 2 {
            self.queue.insert((own.total + bonus, Reverse(pair)));
        }
    }
    fn best(&self) -> Option<(Pair, Vec<usize>)> {
        let (_, Reverse(pair)) = *self.queue.last()?;
        Some((pair, self.places.get(&pair)?.bags.keys().copied().collect()))
    }
}

/// The pairs in a bag, and how often each can be taken out of it.
fn pairs_of(operands: &[Operand]) -> BTreeMap<Pair, usize> {
    let mut counts: BTreeMap<Operand, usize> = BTreeMap::new();
    for &operand in operands {
        *counts.entry(operand).or_default() += 1;
    }
    let distinct: Vec<(Operand, usize)> = counts.into_iter().collect();
    let mut pairs = BTreeMap::new();
    if operands.len() > LONGEST {
        return pairs;
    }
    for (i, &(a, of_a)) in distinct.iter().enumerate() {
        if of_a >= 2 {
            pairs.insert(pair(a, a).0, of_a / 2);
        }
        for &(b, of_b) in &distinct[i + 1..] {
            pairs.insert(pair(a, b).0, of_a.min(of_b));
        }
    }
    pairs
}

/// Takes the pair out of the bag as often as it is there.
fn replace(operands: &mut Vec<Operand>, (a, b, minus): Pair, by: usize) {
    for negative in [false, true] {
        let wanted = [(a, negative), (b, negative != minus)];
        while let Some(first) = operands.iter().position(|&operand| operand == wanted[0]) {
            let second = operands.iter().enumerate().position(|(i, &o)| i != first && o == wanted[1]);
            let Some(second) = second else { break };
            operands.remove(first.max(second));
            operands.remove(first.min(second));
            operands.push((by, negative));
        }
    }
    operands.sort_unstable();
}

/// The last stage: writes entries into the target graph.
struct Writer<'a> {
    scheduler: &'a Scheduler<'a>,
    uses: Vec<u32>,
    target: &'a mut Graph,
    written: Vec<Option<Id>>,
}

impl Writer<'_> {
    fn root(&mut self, root: &Scaled) -> Id {
        match self.scheduler.root_place(root) {
            None => self.target.constant(root.factor),
            Some(place) => {
                let id = self.place(place);
                if root.factor < 0.0 { self.target.neg(id) } else { id }
            }
        }
    }

    fn place(&mut self, place: usize) -> Id {
        if let Some(id) = self.written[place] {
            return id;
        }
        let id = match &self.scheduler.entries[place] {
            Entry::Number(bits) => self.target.constant(f64::from_bits(*bits)),
            Entry::Node(id) => self.node(*id),
            Entry::Bag(Kind::Product, operands) => self.product(operands),
            Entry::Bag(Kind::Sum, operands) => self.sum(operands),
        };
        self.written[place] = Some(id);
        id
    }

    fn of(&mut self, id: Id) -> Id {
        match self.scheduler.known_place(id) {
            Some(place) => self.place(place),
            None => self.node(id),
        }
    }

    fn node(&mut self, id: Id) -> Id {
        match *self.scheduler.source.node(id) {
            Node::Constant(bits) => self.target.constant(f64::from_bits(bits)),
            Node::Input(input) => self.target.input(input),
            Node::Neg(a) => {
                let a = self.of(a);
                self.target.neg(a)
            }
            Node::Add(a, b) => {
                let (a, b) = (self.of(a), self.of(b));
                self.target.add(a, b)
            }
            Node::Sub(a, b) => {
                let (a, b) = (self.of(a), self.of(b));
                self.target.sub(a, b)
            }
            Node::Mul(a, b) => {
                let (a, b) = (self.of(a), self.of(b));
                self.target.mul(a, b)
            }
            Node::Div(a, b) => {
                let (a, b) = (self.of(a), self.of(b));
                self.target.div(a, b)
            }
            Node::Power(a, halves) => {
                let a = self.of(a);
                expand(self.target, a, halves)
            }
            Node::Call(function, a) => {
                let a = self.of(a);
                self.target.call(function, a)
            }
            Node::Call2(function, a, b) => {
                let (a, b) = (self.of(a), self.of(b));
                self.target.call2(function, a, b)
            }
            Node::Select(comparison, a, b, then, other) => {
                let (a, b, then, other) = (self.of(a), self.of(b), self.of(then), self.of(other));
                self.target.select(comparison, a, b, then, other)
            }
            Node::Sum(_) | Node::Product(_) => {
                let place = self.scheduler.bags[&id];
                self.place(place)
            }
        }
    }

    fn product(&mut self, operands: &[Operand]) -> Id {
        let mut divisors = Vec::new();
        let mut factors = Vec::new();
        for &(place, _) in operands {
            match self.lonely_reciprocal(place) {
                Some(divisor) => divisors.push(self.of(divisor)),
                None => factors.push((self.place(place), false)),
            }
        }
        let product = match self.combined(factors, |target, (a, _), (b, _)| {
            let two = |id| target.as_constant(id) == Some(2.0);
            let product = match (two(a), two(b)) {
                (true, _) => target.add(b, b),
                (_, true) => target.add(a, a),
                _ => target.mul(a, b),
            };
            (product, false)
        }) {
            Some((product, _)) => product,
            None => self.target.constant(1.0),
        };
        divisors.into_iter().fold(product, |product, divisor| self.target.div(product, divisor))
    }

    fn sum(&mut self, operands: &[Operand]) -> Id {
        let terms = operands.iter().map(|&(place, negative)| (self.place(place), negative)).collect();
        let sum = self.combined(terms, |target, (a, minus_a), (b, minus_b)| match (minus_a, minus_b) {
            (false, false) => (target.add(a, b), false),
            (false, true) => (target.sub(a, b), false),
            (true, false) => (target.sub(b, a), false),
            (true, true) => (target.add(a, b), true),
        });
        match sum {
            Some((sum, true)) => self.target.neg(sum),
            Some((sum, false)) => sum,
            None => self.target.constant(0.0),
        }
    }

    /// A reciprocal that nobody else needs is a division.
    fn lonely_reciprocal(&self, place: usize) -> Option<Id> {
        let Entry::Node(id) = self.scheduler.entries[place] else { return None };
        match *self.scheduler.source.node(id) {
            Node::Power(base, -2) if self.uses[place] == 1 && self.scheduler.source.moving(id) => Some(base),
            _ => None,
        }
    }

    /// Combines the two shallowest operands until one is left.
    fn combined(
        &mut self,
        operands: Vec<(Id, bool)>,
        combine: impl Fn(&mut Graph, (Id, bool), (Id, bool)) -> (Id, bool),
    ) -> Option<(Id, bool)> {
        let order = |target: &Graph, (id, negative): (Id, bool)| {
            Reverse((if target.moving(id) { target.depth(id) } else { 0 }, id, negative))
        };
        let mut heap: BinaryHeap<_> = operands.into_iter().map(|own| order(self.target, own)).collect();
        loop {
            let Reverse((_, a, minus_a)) = heap.pop()?;
            let Some(Reverse((_, b, minus_b))) = heap.pop() else { return Some((a, minus_a)) };
            let both = combine(self.target, (a, minus_a), (b, minus_b));
            heap.push(order(self.target, both));
        }
    }
}

/// a^(halves/2) as multiplications.
pub(crate) fn expand(target: &mut Graph, a: Id, halves: i32) -> Id {
    chain(
        halves,
        target,
        a,
        &mut |target, a, b| target.mul(a, b),
        &mut |target, a| target.call(Function::Sqrt, a),
        &mut |target, a| target.power(a, -2),
    )
}
