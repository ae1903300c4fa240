//! L and U where no row has more than one neighbour among those after it: chains, and pairs of equations.
//!
//! Every row k then has one entry of U, in the column of its parent, which is mirrored in L. Nothing is searched for and
//! nothing filled in: a row takes its product from its parent's pivot, and a solve goes up the tree once and down once.
//! A chain is eliminated [from both ends](super::pattern), so that two recurrences do not wait for each other.

use crate::number::vector::dot;
use crate::systems::network::pattern::Pattern;
use crate::systems::network::rows::Rows;

/// What is the same for all matrices: a row of each, in the order of elimination.
#[derive(Debug, Clone)]
pub(super) struct Forest {
    rows: Vec<Row>,
}

#[derive(Debug, Clone, Copy)]
struct Row {
    /// Its number, and the place of its parent in the order of elimination, past all rows if it has none.
    row: usize,
    parent: usize,
    /// Blocks on the body that it shares with its parent. Without one: the first block, whose products no one takes.
    own: usize,
    parents: usize,
}

/// A matrix factored: of each row its entries of L and U, and 1/pivot.
#[derive(Debug, Clone, Default)]
pub(super) struct Tree {
    entries: Vec<[f64; 3]>,
    /// The diagonal of the matrix, and what is left of it.
    diagonal: Vec<[f64; 2]>,
}

impl Tree {
    pub(super) fn new(rows: usize) -> Self {
        Self { entries: vec![[0.0; 3]; rows], diagonal: vec![[0.0; 2]; rows + 1] }
    }
}

impl Forest {
    /// None where a row has more neighbours after it, or shares two bodies with one. `touching` are the rows and blocks
    /// of a body.
    pub(super) fn new<'a>(
        pattern: &Pattern,
        rows: &Rows,
        touching: impl Fn(usize) -> &'a [(usize, usize)],
    ) -> Option<Self> {
        let m = pattern.order.len();
        let mut forest = Vec::with_capacity(m);
        for (k, &row) in pattern.order.iter().enumerate() {
            let columns = &pattern.upper[pattern.upper_start[k]..pattern.upper_start[k + 1]];
            let after = rows.blocks_of(row).flat_map(|(own, body)| {
                touching(body).iter().map(move |&(other, block)| (pattern.rank_of[other], own, block))
            });
            let mut after = after.filter(|&(rank, ..)| rank > k);
            let (first, second) = (after.next(), after.next());
            if second.is_some() || columns.len() != usize::from(first.is_some()) {
                return None;
            }
            let (parent, own, parents) = first.unwrap_or((m, 0, 0));
            forest.push(Row { row, parent, own, parents });
        }
        Some(Self { rows: forest })
    }

    /// Factors (blocks)(lifted)ᵀ, or its symmetric part. Returns the smallest ratio of a pivot to its diagonal
    /// entry, or to the size of that, and its row.
    #[inline(always)]
    pub(super) fn factor<const SYMMETRIC: bool, const A: usize, const D: usize>(
        &self,
        rows: &Rows,
        tree: &mut Tree,
        blocks: &[[f64; D]],
        lifted: &[[f64; D]],
        at_start: bool,
    ) -> (f64, usize) {
        let m = self.rows.len();
        let (entries, diagonal) = (&mut tree.entries[..m], &mut tree.diagonal[..m + 1]);
        for (row, diagonal) in self.rows.iter().zip(&mut *diagonal) {
            let range = rows.range::<A>(row.row);
            let products = blocks[range.clone()].iter().zip(&lifted[range]).map(|(a, b)| dot(a, b));
            *diagonal = [products.fold(0.0, |sum, product| sum + product); 2];
        }
        let mut weakest = (f64::INFINITY, 0);
        for (k, (row, entry)) in self.rows.iter().zip(entries).enumerate() {
            let mut low = dot(&blocks[row.parents], &lifted[row.own]);
            let mut up = dot(&blocks[row.own], &lifted[row.parents]);
            if SYMMETRIC {
                let mean = 0.5 * (low + up);
                (low, up) = (mean, mean);
            }
            let [formed, pivot] = diagonal[k];
            let over = 1.0 / pivot;
            let right = up * over;
            diagonal[row.parent][1] -= low * right;
            *entry = [low * over, right, over];
            let ratio = pivot / if at_start { formed } else { formed.abs() };
            if ratio < weakest.0 || ratio.is_nan() {
                weakest = (ratio, row.row);
            }
        }
        weakest
    }

    /// x for a right side times `sign`; `y` is room for one more.
    pub(super) fn solve(&self, tree: &Tree, sign: f64, right: &[f64], x: &mut [f64], y: &mut [f64]) {
        let m = self.rows.len();
        let (entries, y) = (&tree.entries[..m], &mut y[..m + 1]);
        for (row, y) in self.rows.iter().zip(&mut *y) {
            *y = sign * right[row.row];
        }
        for (k, (row, [left, ..])) in self.rows.iter().zip(entries).enumerate() {
            y[row.parent] -= left * y[k];
        }
        y[m] = 0.0;
        for (k, (row, [_, up, over])) in self.rows.iter().zip(entries).enumerate().rev() {
            let found = y[k] * over - up * y[row.parent];
            (y[k], x[row.row]) = (found, found);
        }
    }
}
