//! Sparse matrices by rows, of a symmetric pattern, as a smoother needs them.

use crate::pieces::{PIECE, each, each_of_two};
use std::ops::Range;

/// A square matrix of a fixed pattern. In each row columns ascend, and the diagonal is there.
pub(crate) struct Rows {
    pub(crate) starts: Vec<u32>,
    pub(crate) columns: Vec<u32>,
    pub(crate) values: Vec<f64>,
    /// Where the entries of the diagonal are, and one over each.
    pub(crate) diagonals: Vec<u32>,
    pub(crate) inverse: Vec<f64>,
    /// Rows are smoothed in pieces of so many.
    piece: usize,
    /// The entries of each row that are in its piece: the first place, and the one behind the last.
    inner: Vec<[u32; 2]>,
    /// The rows that have others.
    edge: Vec<u32>,
}

/// A change of a depth that is smaller is 0, where the largest number on the right side is about 1. Numbers that fade
/// away from vertex to vertex would get subnormal, where processors are slow: the dam break on 17 000 vertices took
/// twice as long.
const NOTHING: f64 = 1e-60;
/// Where more than this part of the entries couples rows of different pieces, as on a mesh whose vertices come in no
/// order, all rows are smoothed as one.
const ACROSS: f64 = 0.1;

impl Rows {
    pub(crate) fn of(starts: Vec<u32>, columns: Vec<u32>) -> Self {
        let size = starts.len() - 1;
        let mut diagonals = vec![0; size];
        for row in 0..size {
            for place in starts[row]..starts[row + 1] {
                if columns[place as usize] == row as u32 {
                    diagonals[row] = place;
                }
            }
        }
        let inner = |piece: usize| -> Vec<[u32; 2]> {
            let of_row = |row: usize| {
                let (start, end) = (starts[row] as usize, starts[row + 1] as usize);
                let first = row - row % piece;
                let place =
                    |from| (start + columns[start..end].partition_point(|&j| (j as usize) < from)) as u32;
                [place(first), place(first.saturating_add(piece))]
            };
            (0..size).map(of_row).collect()
        };
        let (mut piece, mut of_rows) = (PIECE, inner(PIECE));
        let within: usize = of_rows.iter().map(|[first, last]| (last - first) as usize).sum();
        if ((columns.len() - within) as f64) > ACROSS * columns.len() as f64 {
            (piece, of_rows) = (usize::MAX, inner(usize::MAX));
        }
        let (values, inverse) = (vec![0.0; columns.len()], vec![0.0; size]);
        let is_whole = |row: usize| of_rows[row] == [starts[row], starts[row + 1]];
        let edge = (0..size).filter(|&row| !is_whole(row)).map(|row| row as u32).collect();
        Rows { values, inverse, starts, columns, diagonals, piece, inner: of_rows, edge }
    }

    pub(crate) fn size(&self) -> usize {
        self.diagonals.len()
    }

    pub(crate) fn row(&self, i: usize) -> Range<usize> {
        self.starts[i] as usize..self.starts[i + 1] as usize
    }

    /// For each entry the place of the one across the diagonal.
    pub(crate) fn across(&self) -> Vec<u32> {
        // Rows come in order, so that the next entry across a column is the next one of that row.
        let mut next = self.starts.clone();
        let mut across = vec![0; self.columns.len()];
        for (place, &column) in self.columns.iter().enumerate() {
            across[place] = next[column as usize];
            next[column as usize] += 1;
        }
        across
    }

    /// One over the diagonal; false where it is not positive.
    pub(crate) fn invert(&mut self) -> bool {
        for (inverse, &place) in self.inverse.iter_mut().zip(&self.diagonals) {
            *inverse = 1.0 / self.values[place as usize];
        }
        self.inverse.iter().all(|x| *x > 0.0 && x.is_finite())
    }

    fn sum(&self, places: Range<usize>, x: &[f64]) -> f64 {
        self.sum_of_piece(places, 0, x)
    }

    /// The same with the numbers from one on.
    fn sum_of_piece(&self, places: Range<usize>, from: usize, x: &[f64]) -> f64 {
        let entries = self.values[places.clone()].iter().zip(&self.columns[places]);
        entries.map(|(value, &column)| value * x[column as usize - from]).sum()
    }

    pub(crate) fn multiply(&self, x: &[f64], y: &mut [f64]) {
        each(PIECE, y, |from, y| y.iter_mut().zip(from..).for_each(|(y, i)| *y = self.sum(self.row(i), x)));
    }

    fn diagonal(&self, i: usize) -> usize {
        self.diagonals[i] as usize
    }

    /// The places of a row that are in its piece.
    fn inner(&self, i: usize) -> Range<usize> {
        let [first, last] = self.inner[i];
        first as usize..last as usize
    }

    /// Gauss and Seidel from 0 in each piece, first row first: (D + L) x = b, L without what is coupled across pieces.
    pub(crate) fn forward(&self, b: &[f64], x: &mut [f64]) {
        each(self.piece, x, |from, x| self.forward_piece(from, &b[from..], x));
    }

    fn forward_piece(&self, from: usize, b: &[f64], x: &mut [f64]) {
        for k in 0..x.len() {
            let i = from + k;
            let left = b[k] - self.sum_of_piece(self.inner(i).start..self.diagonal(i), from, x);
            x[k] = flushed(left * self.inverse[i]);
        }
    }

    /// What is left after this: b − A x.
    pub(crate) fn left_forward(&self, x: &[f64], left: &mut [f64]) {
        each(PIECE, left, |from, left| {
            for (left, i) in left.iter_mut().zip(from..) {
                *left = -self.sum(self.diagonal(i) + 1..self.row(i).end, x);
            }
        });
        for &i in &self.edge {
            left[i as usize] -= self.sum(self.row(i as usize).start..self.inner(i as usize).start, x);
        }
    }

    /// Gauss and Seidel in each piece, last row first: (D + U) x′ = b − (A − D − U) x; and A x′.
    pub(crate) fn backward(&self, b: &[f64], x: &mut [f64], image: &mut [f64]) {
        each(PIECE, image, |from, image| image.copy_from_slice(&b[from..from + image.len()]));
        for &i in &self.edge {
            image[i as usize] -= self.across_pieces(i as usize, x);
        }
        each_of_two(self.piece, x, image, |from, x, image| self.backward_piece(from, x, image));
        let x: &[f64] = x;
        each(PIECE, image, |from, image| {
            for (image, i) in image.iter_mut().zip(from..) {
                *image += self.sum(self.row(i).start..self.diagonal(i), x);
            }
        });
        for &i in &self.edge {
            image[i as usize] += self.sum(self.inner(i as usize).end..self.row(i as usize).end, x);
        }
    }

    /// Makes `left`, b at first, b − L x on the way.
    fn backward_piece(&self, from: usize, x: &mut [f64], left: &mut [f64]) {
        for k in (0..x.len()).rev() {
            let i = from + k;
            let (inner, diagonal) = (self.inner(i), self.diagonal(i));
            left[k] -= self.sum_of_piece(inner.start..diagonal, from, x);
            x[k] = flushed((left[k] - self.sum_of_piece(diagonal + 1..inner.end, from, x)) * self.inverse[i]);
        }
    }

    /// What a row has of other pieces.
    fn across_pieces(&self, i: usize, x: &[f64]) -> f64 {
        let (row, inner) = (self.row(i), self.inner(i));
        self.sum(row.start..inner.start, x) + self.sum(inner.end..row.end, x)
    }
}

pub(crate) fn flushed(x: f64) -> f64 {
    if x.abs() < NOTHING { 0.0 } else { x }
}
