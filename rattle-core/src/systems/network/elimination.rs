//! Elimination for many equations: G M⁻¹Gᵀ factored by rows on a pattern that is found once.
//!
//! The pattern is symmetric, the matrix need not be: in the position equation the normals are those of two places.
//! Pivots stay on the diagonal, which is safe as long as the normals turn by less than a right angle; a pivot that is
//! not positive says that they did. The order is one of minimum degree (P. Amestoy, T. Davis, I. Duff 1996, by faer):
//! chains and trees fill in nothing, so that a step costs as many operations as there are equations.

use crate::number::vector::{add_scaled, dot};
use crate::systems::network::mass::Root;
use crate::systems::network::rows::Rows;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;

/// L and U with ones on their diagonals, on one pattern: column k of L mirrors row k of U.
#[derive(Debug, Clone)]
struct Factor {
    lower: Vec<f64>,
    upper: Vec<f64>,
    /// 1/pivot.
    inverse: Vec<f64>,
}

#[derive(Debug, Clone)]
pub(crate) struct Elimination<const D: usize> {
    /// The row that is eliminated k-th, and its inverse.
    order: Vec<usize>,
    rank_of: Vec<usize>,
    /// Columns of L in row k, ascending, and where they begin.
    lower: Vec<usize>,
    lower_start: Vec<usize>,
    /// Columns of U in row k, ascending.
    upper: Vec<usize>,
    upper_start: Vec<usize>,
    /// Rows that touch a body, with the block.
    touching: Vec<(usize, usize)>,
    touching_start: Vec<usize>,
    /// Normals where the step starts, and M⁻¹ times them.
    normals: Vec<[f64; D]>,
    lifted: Vec<[f64; D]>,
    at_start: Factor,
    at_trial: Factor,
    line: Vec<f64>,
    permuted: Vec<f64>,
    /// Entries of the lower triangle before elimination.
    entries: usize,
}

impl<const D: usize> Elimination<D> {
    pub(crate) fn new(rows: &Rows) -> Self {
        let m = rows.equations();
        let mut of_body: Vec<Vec<(usize, usize)>> = vec![Vec::new(); rows.bodies.len()];
        for row in 0..m {
            for (block, body) in rows.blocks_of(row) {
                of_body[body].push((row, block));
            }
        }
        let mut neighbours: Vec<Vec<usize>> = vec![Vec::new(); m];
        for touching in &of_body {
            for &(i, _) in touching {
                neighbours[i].extend(touching.iter().map(|&(j, _)| j).filter(|&j| j != i));
            }
        }
        for list in &mut neighbours {
            list.sort_unstable();
            list.dedup();
        }
        // As named, if that fills in no more than an order of minimum degree: memory is then read in turn.
        let as_named = Pattern::new(&neighbours, (0..m).collect());
        let pattern = if let Some(order) = from_both_ends(&neighbours) {
            Pattern::new(&neighbours, order)
        } else if as_named.lower.len() > as_named.entries {
            let reordered = Pattern::new(&neighbours, minimum_degree(&neighbours));
            if reordered.lower.len() < as_named.lower.len() { reordered } else { as_named }
        } else {
            as_named
        };
        let Pattern { order, rank_of, lower, lower_start, entries } = pattern;
        let mut upper_start = vec![0; m + 1];
        lower.iter().for_each(|&k| upper_start[k + 1] += 1);
        (0..m).for_each(|k| upper_start[k + 1] += upper_start[k]);
        let (mut next, mut upper) = (upper_start.clone(), vec![0; lower.len()]);
        for row in 0..m {
            for &k in &lower[lower_start[row]..lower_start[row + 1]] {
                upper[next[k]] = row;
                next[k] += 1;
            }
        }
        let mut touching_start = vec![0];
        let mut touching = Vec::new();
        for list in of_body {
            touching.extend(list);
            touching_start.push(touching.len());
        }
        let factor =
            Factor { lower: vec![0.0; lower.len()], upper: vec![0.0; upper.len()], inverse: vec![0.0; m] };
        let blocks = vec![[0.0; D]; rows.blocks()];
        Self {
            order,
            rank_of,
            lower,
            lower_start,
            upper,
            upper_start,
            touching,
            touching_start,
            normals: blocks.clone(),
            lifted: blocks,
            at_start: factor.clone(),
            at_trial: factor,
            line: vec![0.0; m],
            permuted: vec![0.0; m],
            entries,
        }
    }

    /// Entries of the factor below the diagonal, and how many of them were not in the matrix.
    pub(crate) fn fill(&self) -> (usize, usize) {
        (self.lower.len(), self.lower.len() - self.entries)
    }

    /// Takes the normals over. Returns the sine of the angle of the least independent one to those before, and its row.
    pub(crate) fn normals(&mut self, rows: &Rows, blocks: &[[f64; D]], roots: &[Root<D>]) -> (f64, usize) {
        for row in 0..rows.equations() {
            for (block, body) in rows.blocks_of(row) {
                self.lifted[block] = roots[rows.bodies[body]].velocity(&blocks[block]);
            }
        }
        self.normals.copy_from_slice(blocks);
        let mut factor = std::mem::replace(&mut self.at_start, Factor::none());
        let (square, k) = self.factor::<false>(rows, blocks, &mut factor, true);
        self.at_start = factor;
        (square.max(0.0).sqrt(), self.order[k])
    }

    /// Takes the derivative of g along the start's normals at a trial position, or its symmetric part; the smallest pivot,
    /// relative to its entry.
    pub(crate) fn chord<const SYMMETRIC: bool>(&mut self, rows: &Rows, blocks: &[[f64; D]]) -> f64 {
        let mut factor = std::mem::replace(&mut self.at_trial, Factor::none());
        let (smallest, _) = self.factor::<SYMMETRIC>(rows, blocks, &mut factor, false);
        self.at_trial = factor;
        smallest
    }

    /// Factors (blocks)(lifted)ᵀ, or its symmetric part. Returns the smallest ratio of a pivot to its diagonal entry, and where.
    fn factor<const SYMMETRIC: bool>(
        &mut self,
        rows: &Rows,
        blocks: &[[f64; D]],
        factor: &mut Factor,
        at_start: bool,
    ) -> (f64, usize) {
        let mut weakest = (f64::INFINITY, 0);
        let line = &mut self.line;
        for k in 0..self.order.len() {
            for (block, body) in rows.blocks_of(self.order[k]) {
                for &(row, other) in &self.touching[self.touching_start[body]..self.touching_start[body + 1]]
                {
                    let entry = dot(&blocks[block], &self.lifted[other]);
                    let mirrored = if SYMMETRIC { dot(&blocks[other], &self.lifted[block]) } else { entry };
                    line[self.rank_of[row]] += if SYMMETRIC { 0.5 * (entry + mirrored) } else { entry };
                }
            }
            let entry = line[k];
            for at in self.lower_start[k]..self.lower_start[k + 1] {
                let j = self.lower[at];
                let left = std::mem::take(&mut line[j]);
                factor.lower[at] = left * factor.inverse[j];
                let upper = self.upper_start[j]..self.upper_start[j + 1];
                for (&column, u) in self.upper[upper.clone()].iter().zip(&factor.upper[upper]) {
                    line[column] -= left * u;
                }
            }
            let pivot = line[k];
            line[k] = 0.0;
            let inverse = 1.0 / pivot;
            factor.inverse[k] = inverse;
            for at in self.upper_start[k]..self.upper_start[k + 1] {
                factor.upper[at] = std::mem::take(&mut line[self.upper[at]]) * inverse;
            }
            let ratio = pivot / entry;
            let ratio = if at_start { ratio } else { ratio * entry.signum() };
            if ratio < weakest.0 || ratio.is_nan() {
                weakest = (ratio, k);
            }
        }
        weakest
    }

    fn substitute(&self, factor: &Factor, right: &[f64], x: &mut [f64], y: &mut [f64]) {
        let m = self.order.len();
        for k in 0..m {
            let lower = self.lower_start[k]..self.lower_start[k + 1];
            let mut rest = right[self.order[k]];
            for (&j, l) in self.lower[lower.clone()].iter().zip(&factor.lower[lower]) {
                rest -= l * y[j];
            }
            y[k] = rest;
        }
        for k in (0..m).rev() {
            let upper = self.upper_start[k]..self.upper_start[k + 1];
            let mut rest = y[k] * factor.inverse[k];
            for (&j, u) in self.upper[upper.clone()].iter().zip(&factor.upper[upper]) {
                rest -= u * y[j];
            }
            y[k] = rest;
            x[self.order[k]] = rest;
        }
    }

    /// Λ such that G moves at these rates when the bodies move by M⁻¹GᵀΛ.
    pub(crate) fn solve(&mut self, rates: &[f64], x: &mut [f64]) {
        let mut y = std::mem::take(&mut self.permuted);
        self.substitute(&self.at_start, rates, x, &mut y);
        self.permuted = y;
    }

    /// Newton's correction for residuals g, with the derivative of [`Self::chord`].
    pub(crate) fn correct(&mut self, g: &[f64], dx: &mut [f64]) {
        let mut y = std::mem::take(&mut self.permuted);
        self.substitute(&self.at_trial, g, dx, &mut y);
        self.permuted = y;
        dx.iter_mut().for_each(|x| *x = -*x);
    }

    /// Adds M⁻¹GᵀΛ to each body's place.
    pub(crate) fn displace(&self, rows: &Rows, x: &[f64], out: &mut [[f64; D]]) {
        for (row, &x) in x.iter().enumerate() {
            for (block, body) in rows.blocks_of(row) {
                let place = rows.bodies[body];
                out[place] = add_scaled(&out[place], x, &self.lifted[block]);
            }
        }
    }

    /// Adds `scale` GᵀΛ to each body's momentum.
    pub(crate) fn push(&self, rows: &Rows, scale: f64, x: &[f64], out: &mut [[f64; D]]) {
        for (row, &x) in x.iter().enumerate() {
            for (block, body) in rows.blocks_of(row) {
                let place = rows.bodies[body];
                out[place] = add_scaled(&out[place], scale * x, &self.normals[block]);
            }
        }
    }
}

/// Where L has entries, for an order of elimination.
struct Pattern {
    order: Vec<usize>,
    rank_of: Vec<usize>,
    lower: Vec<usize>,
    lower_start: Vec<usize>,
    entries: usize,
}

impl Pattern {
    fn new(neighbours: &[Vec<usize>], order: Vec<usize>) -> Self {
        let m = order.len();
        let mut rank_of = vec![0; m];
        order.iter().enumerate().for_each(|(k, &row)| rank_of[row] = k);
        // Row k of L: everything on the ways up the elimination tree from the neighbours before k (J. Liu 1990).
        let mut parent = vec![usize::MAX; m];
        let mut seen = vec![usize::MAX; m];
        let (mut lower, mut lower_start) = (Vec::new(), vec![0]);
        let mut entries = 0;
        for k in 0..m {
            seen[k] = k;
            let begin = lower.len();
            for &row in &neighbours[order[k]] {
                let mut j = rank_of[row];
                entries += usize::from(j < k);
                while j < k && seen[j] != k {
                    seen[j] = k;
                    lower.push(j);
                    if parent[j] == usize::MAX {
                        parent[j] = k;
                    }
                    j = parent[j];
                }
            }
            lower[begin..].sort_unstable();
            lower_start.push(lower.len());
        }
        Self { order, rank_of, lower, lower_start, entries }
    }
}

impl Factor {
    fn none() -> Self {
        Self { lower: Vec::new(), upper: Vec::new(), inverse: Vec::new() }
    }
}

/// The order of a chain from both its ends at once: the processor then works on two recurrences that do not wait for
/// each other. None if the rows are no chain.
fn from_both_ends(neighbours: &[Vec<usize>]) -> Option<Vec<usize>> {
    let m = neighbours.len();
    let end = neighbours.iter().position(|list| list.len() <= 1)?;
    if neighbours.iter().any(|list| list.len() > 2) {
        return None;
    }
    let mut chain = vec![end];
    let mut before = end;
    while let Some(&next) = neighbours[chain[chain.len() - 1]].iter().find(|&&row| row != before) {
        before = chain[chain.len() - 1];
        chain.push(next);
    }
    (chain.len() == m)
        .then(|| (0..m).map(|k| chain[if k % 2 == 0 { k / 2 } else { m - 1 - k / 2 }]).collect())
}

/// An order of elimination with little fill.
fn minimum_degree(neighbours: &[Vec<usize>]) -> Vec<usize> {
    let m = neighbours.len();
    let mut starts = vec![0];
    let mut entries = Vec::new();
    for (i, list) in neighbours.iter().enumerate() {
        entries.extend(list.iter().copied().filter(|&j| j < i)); // the upper triangle, by columns
        starts.push(entries.len());
    }
    let matrix = SymbolicSparseColMatRef::new_checked(m, m, &starts, None, &entries);
    let (mut order, mut inverse) = (vec![0_usize; m], vec![0_usize; m]);
    let mut memory = MemBuffer::new(amd::order_scratch::<usize>(m, entries.len()));
    let stack = MemStack::new(&mut memory);
    match amd::order(&mut order, &mut inverse, matrix, amd::Control::default(), stack) {
        Ok(_) => order,
        Err(_) => (0..m).collect(), // too large for its indices: any order is right
    }
}
