//! L and U of a sparse matrix, row by row on a fixed pattern.
//!
//! In nets most of the work is in the last rows, where many rows of U have the same columns. These rows are subtracted
//! together: their target is stored contiguously meanwhile, and is read once for four of them. Each entry goes through
//! the same operations in the same order as if rows were subtracted one by one.

use crate::systems::network::pattern::Pattern;
use std::array::from_fn;
use std::mem::take;

/// L and U with ones on their diagonals, on one pattern: column k of L mirrors row k of U.
#[derive(Debug, Clone, Default)]
pub(super) struct Factor {
    lower: Vec<f64>,
    upper: Vec<f64>,
    /// 1/pivot.
    pub(super) inverse: Vec<f64>,
    /// A row of the matrix while it is eliminated; zero in between.
    pub(super) line: Vec<f64>,
    gathered: Vec<f64>,
}

/// So many rows of U with the same columns are subtracted together: fewer cost as much to gather as they save.
pub(super) const TOGETHER: usize = 4;

impl Factor {
    pub(super) fn new(pattern: &Pattern) -> Self {
        let (m, entries) = (pattern.order.len(), vec![0.0; pattern.lower.len()]);
        let zero = vec![0.0; m];
        Self {
            lower: entries.clone(),
            upper: entries,
            inverse: zero.clone(),
            line: zero.clone(),
            gathered: zero,
        }
    }

    /// Eliminates row k, which is in `line`; its pivot. `WIDE` where [`TOGETHER`] rows are alike anywhere: a chain,
    /// where none are, does not wait for the question.
    #[inline(always)]
    pub(super) fn eliminate<const WIDE: bool>(&mut self, pattern: &Pattern, k: usize) -> f64 {
        let end = pattern.lower_start[k + 1];
        let mut at = pattern.lower_start[k];
        while at < end {
            let j = pattern.lower[at];
            let past = if WIDE { pattern.alike[j].min(k) } else { j };
            if !WIDE || past < j + TOGETHER {
                let Self { lower, upper, inverse, line, .. } = self;
                let left = take(&mut line[j]);
                lower[at] = left * inverse[j];
                let range = pattern.upper_start[j]..pattern.upper_start[j + 1];
                for (&column, u) in pattern.upper[range.clone()].iter().zip(&upper[range]) {
                    line[column] -= left * u;
                }
                at += 1;
            } else {
                self.subtract_together(pattern, at, j, past);
                at += past - j;
            }
        }
        let pivot = take(&mut self.line[k]);
        let inverse = 1.0 / pivot;
        self.inverse[k] = inverse;
        for at in pattern.upper_start[k]..pattern.upper_start[k + 1] {
            self.upper[at] = take(&mut self.line[pattern.upper[at]]) * inverse;
        }
        pivot
    }

    /// Takes row and column k, just eliminated, out of L and U: with 0 on the right side at k the others are solved
    /// for.
    pub(super) fn leave_out(&mut self, pattern: &Pattern, k: usize) {
        self.lower[pattern.lower_start[k]..pattern.lower_start[k + 1]].fill(0.0);
        self.upper[pattern.upper_start[k]..pattern.upper_start[k + 1]].fill(0.0);
        self.inverse[k] = 1.0;
    }

    /// The pivot of row k, and its entries beyond with their columns.
    pub(super) fn row<'a>(
        &'a self,
        pattern: &'a Pattern,
        k: usize,
    ) -> (f64, impl Iterator<Item = (usize, f64)> + 'a) {
        let (pivot, range) = (1.0 / self.inverse[k], pattern.upper_start[k]..pattern.upper_start[k + 1]);
        let entries = pattern.upper[range.clone()].iter().zip(&self.upper[range]);
        (pivot, entries.map(move |(&column, u)| (column, pivot * u)))
    }

    /// Subtracts rows j to `past` of U, which are alike; entry `at` of L is the first of theirs.
    fn subtract_together(&mut self, pattern: &Pattern, at: usize, j: usize, past: usize) {
        let Self { lower, upper, inverse, line, gathered } = self;
        let row = |k: usize| &upper[pattern.upper_start[k]..pattern.upper_start[k + 1]];
        for k in j..past {
            let left = line[k];
            lower[at + k - j] = left * inverse[k];
            for (entry, u) in line[k + 1..past].iter_mut().zip(row(k)) {
                *entry -= left * u;
            }
        }
        let columns = &pattern.upper[pattern.upper_start[past - 1]..pattern.upper_start[past]];
        let gathered = &mut gathered[..columns.len()];
        gathered.iter_mut().zip(columns).for_each(|(entry, &column)| *entry = line[column]);
        let beyond = |k: usize| &row(k)[past - 1 - k..];
        let mut k = j;
        while k + 4 <= past {
            let (left, rows): ([f64; 4], [&[f64]; 4]) =
                (from_fn(|i| line[k + i]), from_fn(|i| beyond(k + i)));
            let rows = rows.map(|row| &row[..gathered.len()]);
            for (i, entry) in gathered.iter_mut().enumerate() {
                *entry = *entry
                    - left[0] * rows[0][i]
                    - left[1] * rows[1][i]
                    - left[2] * rows[2][i]
                    - left[3] * rows[3][i];
            }
            k += 4;
        }
        for k in k..past {
            let left = line[k];
            gathered.iter_mut().zip(beyond(k)).for_each(|(entry, u)| *entry -= left * u);
        }
        gathered.iter().zip(columns).for_each(|(entry, &column)| line[column] = *entry);
        line[j..past].fill(0.0);
    }

    /// x for a right side times `sign`; `y` is room.
    pub(super) fn solve(&self, pattern: &Pattern, sign: f64, right: &[f64], x: &mut [f64], y: &mut [f64]) {
        let m = pattern.order.len();
        let (order, inverse, y) = (&pattern.order[..m], &self.inverse[..m], &mut y[..m]);
        let (mut columns, mut entries) = (&pattern.lower[..], &self.lower[..]);
        let mut begin = 0;
        for (k, (&row, &end)) in order.iter().zip(&pattern.lower_start[1..]).enumerate() {
            let mut rest = sign * right[row];
            let (own, own_columns);
            (own_columns, columns) = columns.split_at(end - begin);
            (own, entries) = entries.split_at(end - begin);
            for (&j, l) in own_columns.iter().zip(own) {
                rest -= l * y[j];
            }
            (y[k], begin) = (rest, end);
        }
        let (mut columns, mut entries) = (&pattern.upper[..], &self.upper[..]);
        for (k, (&row, &begin)) in order.iter().zip(&pattern.upper_start).enumerate().rev() {
            let mut rest = y[k] * inverse[k];
            let (own, own_columns);
            (columns, own_columns) = columns.split_at(begin);
            (entries, own) = entries.split_at(begin);
            for (&j, u) in own_columns.iter().zip(own) {
                rest -= u * y[j];
            }
            (y[k], x[row]) = (rest, rest);
        }
    }
}
