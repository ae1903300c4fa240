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
    /// Whether rows lie [in a line](super::line), so that no link is looked up.
    in_line: bool,
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
    rows: Vec<FactoredRow>,
    diagonal: Vec<f64>,
    /// Of a row with the next one, and of that with the row.
    beside: Vec<[f64; 2]>,
}

/// Entries of a row's column of L and of its row of U, and 1/pivot.
#[derive(Debug, Clone, Copy, Default)]
struct FactoredRow {
    left: f64,
    up: f64,
    over: f64,
}

impl Factored {
    pub(super) fn new(rows: usize) -> Self {
        let (diagonal, beside) = (vec![0.0; rows], vec![[0.0; 2]; rows]);
        Self { rows: vec![FactoredRow::default(); rows], diagonal, beside }
    }

    /// 1/pivot of each row.
    pub(super) fn overs(&self) -> impl Iterator<Item = f64> {
        self.rows.iter().map(|row| row.over)
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
        Some(Self { links, in_line: rows.line.is_some() })
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
        if self.in_line {
            factored.form::<SYMMETRIC, D>(blocks, lifted);
            return factored.factor_line(at_start);
        }
        let links = &self.links[..];
        let (last, Factored { rows: out, diagonal, .. }) = (links.len() - 1, factored);
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
            *out = FactoredRow { left: low * over, up: right, over };
            let ratio = pivot / if at_start { entry } else { entry.abs() };
            if ratio < weakest.0 || ratio.is_nan() {
                weakest = (ratio, link.row);
            }
        }
        weakest
    }

    /// x for a right side times `sign`; `y` is room.
    pub(super) fn solve(&self, factored: &Factored, sign: f64, right: &[f64], x: &mut [f64], y: &mut [f64]) {
        if self.in_line {
            return factored.solve_line(sign, right, x, y);
        }
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

impl Factored {
    /// Forms the entries of (blocks)(lifted)ᵀ, or of its symmetric part.
    #[inline(always)]
    fn form<const SYMMETRIC: bool, const D: usize>(&mut self, blocks: &[[f64; D]], lifted: &[[f64; D]]) {
        let (blocks, lifted) = (blocks.as_chunks::<2>().0, lifted.as_chunks::<2>().0);
        for ((entry, a), b) in self.diagonal.iter_mut().zip(blocks).zip(lifted) {
            *entry = dot(&a[0], &b[0]) + dot(&a[1], &b[1]);
        }
        let next = blocks.iter().zip(lifted).skip(1);
        for ((entries, (a, b)), (c, d)) in self.beside.iter_mut().zip(blocks.iter().zip(lifted)).zip(next) {
            *entries = [dot(&a[1], &d[0]), dot(&c[0], &b[1])];
            if SYMMETRIC {
                *entries = [0.5 * (entries[0] + entries[1]); 2];
            }
        }
    }

    /// Factors what is formed, from both ends at once. Returns the smallest ratio as [`Chain::factor`] does.
    fn factor_line(&mut self, at_start: bool) -> (f64, usize) {
        let m = self.diagonal.len();
        let pairs = (m - 1) / 2;
        let (diagonal, beside) = (&self.diagonal[..], &self.beside[..m]);
        let (ahead, behind) = (&diagonal[..pairs], &diagonal[m - pairs..]);
        let (up, down) = (&beside[..pairs], &beside[m - 1 - pairs..m - 1]);
        let (mut from_left, mut from_right) = (0.0, 0.0);
        let mut weakest = (f64::INFINITY, 0);
        let mut note = |pivot: f64, entry: f64, row: usize| {
            let ratio = pivot / if at_start { entry } else { entry.abs() };
            if ratio < weakest.0 || ratio.is_nan() {
                weakest = (ratio, row);
            }
        };
        let out = self.rows.as_chunks_mut::<2>().0;
        let entries = ahead.iter().zip(up).zip(behind.iter().rev().zip(down.iter().rev()));
        for (t, (((&left, &[up, low]), (&right, &[above, below])), out)) in entries.zip(out).enumerate() {
            let pivots = [left - from_left, right - from_right];
            let over = pivots.map(|pivot| 1.0 / pivot);
            note(pivots[0], left, t);
            note(pivots[1], right, m - 1 - t);
            let rights = [up * over[0], below * over[1]];
            (from_left, from_right) = (low * rights[0], above * rights[1]);
            out[0] = FactoredRow { left: low * over[0], up: rights[0], over: over[0] };
            out[1] = FactoredRow { left: above * over[1], up: rights[1], over: over[1] };
        }
        if m.is_multiple_of(2) {
            let (entry, [up, low]) = (diagonal[pairs], beside[pairs]);
            let pivot = entry - from_left;
            let over = 1.0 / pivot;
            note(pivot, entry, pairs);
            from_left = low * (up * over);
            self.rows[m - 2] = FactoredRow { left: low * over, up: up * over, over };
        }
        let entry = diagonal[m / 2];
        let pivot = entry - from_left - from_right;
        note(pivot, entry, m / 2);
        self.rows[m - 1] = FactoredRow { left: 0.0, up: 0.0, over: 1.0 / pivot };
        weakest
    }

    /// x for a right side times `sign`; `y` is room.
    fn solve_line(&self, sign: f64, right: &[f64], x: &mut [f64], y: &mut [f64]) {
        let m = self.rows.len();
        let pairs = (m - 1) / 2;
        let (rows, right, x, y) = (&self.rows[..m], &right[..m], &mut x[..m], &mut y[..m]);
        let (mut from_left, mut from_right) = (0.0, 0.0);
        let (in_pairs, kept) = (&rows.as_chunks::<2>().0[..pairs], &mut y.as_chunks_mut::<2>().0[..pairs]);
        let ends = right[..pairs].iter().zip(right[m - pairs..].iter().rev());
        for (((left, right), [a, b]), kept) in ends.zip(in_pairs).zip(&mut *kept) {
            let rest = [sign * left - from_left, sign * right - from_right];
            *kept = [rest[0] * a.over, rest[1] * b.over];
            (from_left, from_right) = (a.left * rest[0], b.left * rest[1]);
        }
        let mut extra = 0.0;
        if m.is_multiple_of(2) {
            let (row, rest) = (&rows[m - 2], sign * right[pairs] - from_left);
            (extra, from_left) = (rest * row.over, row.left * rest);
        }
        let middle = (sign * right[m / 2] - from_left - from_right) * rows[m - 1].over;
        x[m / 2] = middle;
        let (mut after_left, mut after_right) = (middle, middle);
        if m.is_multiple_of(2) {
            after_left = extra - rows[m - 2].up * middle;
            x[pairs] = after_left;
        }
        let (ahead, behind) = x.split_at_mut(m - pairs);
        let ends = ahead[..pairs].iter_mut().rev().zip(behind);
        for (((left, right), [a, b]), kept) in ends.zip(in_pairs.iter().rev()).zip(kept.iter().rev()) {
            after_left = kept[0] - a.up * after_left;
            after_right = kept[1] - b.up * after_right;
            (*left, *right) = (after_left, after_right);
        }
    }
}
