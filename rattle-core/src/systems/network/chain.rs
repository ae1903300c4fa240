//! L and U of a chain of equations, eliminated [from both ends at once](super::pattern): those of a single equation, of
//! two, of a pendulum of many links.
//!
//! In that order row k has one neighbour after it, row k + 2, or the last one. Nothing is searched for and nothing
//! filled in. What row k takes from row k + 2 is kept in registers, and two recurrences do not wait for each other.

use crate::number::vector::dot;
use crate::systems::network::pattern::Pattern;
use crate::systems::network::rows::Rows;

/// What is the same for all matrices: the rows in the order of elimination.
#[derive(Debug, Clone)]
pub(super) struct Chain {
    links: Vec<Link>,
}

#[derive(Debug, Clone, Copy)]
struct Link {
    row: usize,
    /// Blocks of the row, and of its neighbour after it, on the body that they share; of the last row any.
    own: usize,
    other: usize,
}

/// A matrix, factored.
#[derive(Debug, Clone, Default)]
pub(super) struct Factored {
    rows: Vec<Row>,
    diagonal: Vec<f64>,
}

/// Entries of a row's column of L and of its row of U, and 1/pivot.
#[derive(Debug, Clone, Copy, Default)]
struct Row {
    left: f64,
    up: f64,
    over: f64,
}

impl Factored {
    pub(super) fn new(rows: usize) -> Self {
        Self { rows: vec![Row::default(); rows], diagonal: vec![0.0; rows] }
    }
}

impl Chain {
    /// None where the rows are no chain, or two of them share two bodies. `touching` are the rows and blocks of a body.
    pub(super) fn new<'a>(
        pattern: &Pattern,
        rows: &Rows,
        touching: impl Fn(usize) -> &'a [(usize, usize)],
    ) -> Option<Self> {
        let m = pattern.order.len();
        let mut links = Vec::with_capacity(m);
        for (k, &row) in pattern.order.iter().enumerate() {
            let neighbours = rows.blocks_of(row).flat_map(|(own, body)| {
                touching(body).iter().map(move |&(other, block)| (pattern.rank_of[other], own, block))
            });
            let mut after = neighbours.filter(|&(rank, ..)| rank > k);
            let (first, second) = (after.next(), after.next());
            let (own, other) = match (first, second) {
                (None, None) if k + 1 == m => (0, 0),
                (Some((rank, own, other)), None) if rank == (k + 2).min(m - 1) => (own, other),
                _ => return None,
            };
            links.push(Link { row, own, other });
        }
        Some(Self { links })
    }

    /// Factors (blocks)(lifted)ᵀ, or its symmetric part. Returns the smallest ratio of a pivot to its diagonal entry,
    /// or to the size of that, and its row. `A` is how many blocks a row has, or 0.
    #[inline(always)]
    pub(super) fn factor<const SYMMETRIC: bool, const A: usize, const D: usize>(
        &self,
        rows: &Rows,
        factored: &mut Factored,
        blocks: &[[f64; D]],
        lifted: &[[f64; D]],
        at_start: bool,
    ) -> (f64, usize) {
        let links = &self.links[..];
        let (last, Factored { rows: out, diagonal }) = (links.len() - 1, factored);
        let (out, diagonal) = (&mut out[..links.len()], &mut diagonal[..links.len()]);
        for (row, diagonal) in diagonal.iter_mut().enumerate() {
            let range = rows.range::<A>(row);
            let products = blocks[range.clone()].iter().zip(&lifted[range]).map(|(a, b)| dot(a, b));
            *diagonal = products.fold(0.0, |sum, product| sum + product);
        }
        let mut weakest = (f64::INFINITY, 0);
        let (mut from_other_end, mut from_before) = (0.0, 0.0);
        for (k, (link, out)) in links.iter().zip(out).enumerate() {
            let mut low = dot(&blocks[link.other], &lifted[link.own]);
            let mut up = dot(&blocks[link.own], &lifted[link.other]);
            if SYMMETRIC {
                let mean = 0.5 * (low + up);
                (low, up) = (mean, mean);
            }
            let entry = diagonal[link.row];
            let pivot = if k == last { entry - from_before - from_other_end } else { entry - from_before };
            let over = 1.0 / pivot;
            let right = up * over;
            (from_before, from_other_end) = (from_other_end, low * right);
            *out = Row { left: low * over, up: right, over };
            let ratio = pivot / if at_start { entry } else { entry.abs() };
            if ratio < weakest.0 || ratio.is_nan() {
                weakest = (ratio, link.row);
            }
        }
        weakest
    }

    /// x for a right side times `sign`; `y` is room.
    pub(super) fn solve(&self, factored: &Factored, sign: f64, right: &[f64], x: &mut [f64], y: &mut [f64]) {
        let links = &self.links[..];
        let (rows, y) = (&factored.rows[..links.len()], &mut y[..links.len()]);
        let (mut from_other_end, mut from_before) = (0.0, 0.0);
        for ((link, row), y) in links.iter().zip(rows).zip(&mut *y) {
            let rest = sign * right[link.row] - from_before;
            *y = rest * row.over;
            (from_before, from_other_end) = (from_other_end, row.left * rest);
        }
        let last = links.len() - 1;
        let found = y[last] - from_before * rows[last].over;
        x[links[last].row] = found;
        let (mut after, mut at_other_end) = (found, found);
        for ((link, row), y) in links[..last].iter().zip(rows).zip(y).rev() {
            let found = *y - row.up * after;
            (after, at_other_end) = (at_other_end, found);
            x[link.row] = found;
        }
    }
}
