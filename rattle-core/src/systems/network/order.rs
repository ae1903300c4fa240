//! An order of elimination with little fill: rows of approximate minimum degree, on the quotient graph.
//!
//! Two rows are neighbours where they share an **element**. At first the elements are the bodies; eliminating a row
//! makes one new element of all its neighbours, in place of the elements that the row was in. No edge is ever stored,
//! and what a row takes is what its new element holds.
//!
//! ```text
//! degree of i  ≈  |new ∖ i| + Σ |e ∖ new|        over the other elements e of i
//! ```
//!
//! Sources: P. Amestoy, T. Davis, I. Duff, SIAM J. Matrix Anal. Appl. 17 (1996) 886, for the degree, for elements that
//! vanish in the new one and for rows that are alike. Rows in one element alone come first, whatever their degree: they
//! fill in nothing, so that trees fill in nothing.

use std::mem::{replace, take};

const NONE: usize = usize::MAX;

/// The rows 0 … m − 1 in an order of elimination, given the rows of each body.
pub(super) fn minimum_degree(rows_of_body: &[Vec<usize>], m: usize) -> Vec<usize> {
    let mut graph = Quotient::new(rows_of_body, m);
    while let Some(pivot) = graph.queue.pop() {
        graph.eliminate(pivot);
    }
    graph.order
}

struct Quotient {
    /// Rows of each element, some of which may have been merged or eliminated since; empty once the element is
    /// absorbed.
    rows_of: Vec<Vec<usize>>,
    /// How many rows an element has, counted with those that are merged.
    size: Vec<usize>,
    /// Elements of each row, ascending.
    elements_of: Vec<Vec<usize>>,
    /// Rows that a row stands for; 0 once it is merged or eliminated.
    weight: Vec<usize>,
    /// The rows that a row stands for, as a list: the one after each, and the last.
    after: Vec<usize>,
    last: Vec<usize>,
    /// The pivot for which a row or an element was last looked at.
    row_seen: Vec<usize>,
    element_seen: Vec<usize>,
    /// Rows of an element outside the new one.
    outside: Vec<usize>,
    queue: Queue,
    order: Vec<usize>,
}

impl Quotient {
    fn new(rows_of_body: &[Vec<usize>], m: usize) -> Self {
        let mut elements_of = vec![Vec::new(); m];
        for (body, rows) in rows_of_body.iter().enumerate().filter(|(_, rows)| rows.len() > 1) {
            rows.iter().for_each(|&row| elements_of[row].push(body));
        }
        let mut size: Vec<usize> = rows_of_body.iter().map(Vec::len).collect();
        let elements = size.len() + m; // of a pivot: that of the bodies' number plus the pivot
        size.resize(elements, 0);
        let mut rows_of = rows_of_body.to_vec();
        rows_of.resize(elements, Vec::new());
        let mut queue = Queue::new(m);
        for row in (0..m).rev() {
            let degree = elements_of[row].iter().map(|&e| size[e] - 1).sum();
            queue.insert(row, key(&elements_of[row], degree));
        }
        Self {
            rows_of,
            size,
            elements_of,
            weight: vec![1; m],
            after: vec![NONE; m],
            last: (0..m).collect(),
            row_seen: vec![NONE; m],
            element_seen: vec![NONE; elements],
            outside: vec![0; elements],
            queue,
            order: Vec::with_capacity(m),
        }
    }

    fn eliminate(&mut self, pivot: usize) {
        let new = self.rows_of.len() - self.weight.len() + pivot;
        let mut rows = self.absorb(pivot);
        self.write(pivot);
        self.measure(pivot, &rows);
        // What is left in no other element fills in nothing: it is eliminated with the pivot.
        for &row in &rows {
            let (elements_of, outside) = (&mut self.elements_of[row], &self.outside);
            elements_of.retain(|&e| outside[e] > 0);
            if elements_of.is_empty() {
                self.write(row);
            }
        }
        rows.retain(|&row| self.weight[row] > 0);
        self.merge_alike(&mut rows);
        let size: usize = rows.iter().map(|&row| self.weight[row]).sum();
        let left = self.weight.len() - self.order.len();
        for &row in rows.iter().rev() {
            let others = size - self.weight[row];
            let outside: usize = self.elements_of[row].iter().map(|&e| self.outside[e]).sum();
            let degree = (others + outside).min(left - self.weight[row]);
            if others > 0 {
                self.elements_of[row].push(new);
            }
            self.queue.insert(row, key(&self.elements_of[row], degree));
        }
        (self.size[new], self.rows_of[new]) = (size, rows);
    }

    /// The rows that share an element with the pivot, taken out of the queue; these elements are no more.
    fn absorb(&mut self, pivot: usize) -> Vec<usize> {
        let mut rows = Vec::new();
        self.row_seen[pivot] = pivot;
        for element in take(&mut self.elements_of[pivot]) {
            self.size[element] = 0;
            for row in take(&mut self.rows_of[element]) {
                if self.weight[row] > 0 && replace(&mut self.row_seen[row], pivot) != pivot {
                    self.queue.remove(row);
                    rows.push(row);
                }
            }
        }
        rows
    }

    /// Counts what the elements of these rows hold beside them; of what is absorbed, nothing.
    fn measure(&mut self, pivot: usize, rows: &[usize]) {
        for &row in rows {
            for &element in &self.elements_of[row] {
                if replace(&mut self.element_seen[element], pivot) != pivot {
                    self.outside[element] = self.size[element];
                }
                self.outside[element] = self.outside[element].saturating_sub(self.weight[row]);
            }
        }
    }

    /// Rows with the same elements stay neighbours of the same rows for good: one stands for all.
    fn merge_alike(&mut self, rows: &mut Vec<usize>) {
        let sum = |elements: &[usize]| elements.iter().fold(0_usize, |sum, &e| sum.wrapping_add(e));
        let mut by_sum: Vec<_> = rows.iter().map(|&row| (sum(&self.elements_of[row]), row)).collect();
        by_sum.sort_unstable();
        for same in by_sum.chunk_by(|a, b| a.0 == b.0) {
            for (at, &(_, row)) in same.iter().enumerate().filter(|_| same.len() > 1) {
                for &(_, other) in &same[at + 1..] {
                    let both = self.weight[row] > 0 && self.weight[other] > 0;
                    if both && self.elements_of[row] == self.elements_of[other] {
                        self.weight[row] += take(&mut self.weight[other]);
                        self.after[self.last[row]] = other;
                        self.last[row] = self.last[other];
                    }
                }
            }
        }
        rows.retain(|&row| self.weight[row] > 0);
    }

    /// Writes a row, and those that it stands for, into the order.
    fn write(&mut self, row: usize) {
        self.weight[row] = 0;
        let mut next = row;
        while next != NONE {
            self.order.push(next);
            next = self.after[next];
        }
    }
}

/// Where a row stands in the queue: at its degree, or at the front if it is in one element alone.
fn key(elements: &[usize], degree: usize) -> usize {
    if elements.len() <= 1 { 0 } else { degree }
}

/// Rows by key, the last that came first among equals.
struct Queue {
    head: Vec<usize>,
    next: Vec<usize>,
    before: Vec<usize>,
    key: Vec<usize>,
    /// No key is below.
    least: usize,
}

impl Queue {
    fn new(m: usize) -> Self {
        let none = vec![NONE; m];
        Self { head: none.clone(), next: none.clone(), before: none, key: vec![0; m], least: 0 }
    }

    fn insert(&mut self, row: usize, key: usize) {
        let key = key.min(self.head.len() - 1);
        let next = replace(&mut self.head[key], row);
        if next != NONE {
            self.before[next] = row;
        }
        (self.next[row], self.before[row], self.key[row]) = (next, NONE, key);
        self.least = self.least.min(key);
    }

    fn remove(&mut self, row: usize) {
        let (next, before) = (self.next[row], self.before[row]);
        match before {
            NONE => self.head[self.key[row]] = next,
            before => self.next[before] = next,
        }
        if next != NONE {
            self.before[next] = before;
        }
    }

    /// Takes out a row of the least key.
    fn pop(&mut self) -> Option<usize> {
        self.least += self.head[self.least..].iter().position(|&row| row != NONE)?;
        let row = self.head[self.least];
        self.remove(row);
        Some(row)
    }
}
