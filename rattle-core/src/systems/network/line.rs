//! Rows in a line: each ties a body to the one that follows in the scene, as in a chain of rods.
//!
//! What belongs to a row, and to a body, lies then side by side in the order in which it is gone through: nothing is
//! looked up.

use crate::number::vector::{add_scaled, scaled};
use std::ops::Range;

/// Row i is between the bodies `first` + i and `first` + i + 1.
#[derive(Debug, Clone)]
pub(crate) struct Line {
    pub(crate) first: usize,
    /// Whether the first body, and the last one, can move; all others can.
    pub(crate) free: [bool; 2],
}

impl Line {
    /// None where rows do not lie like this. `touched` are the bodies of the rows' blocks, `free` is 0 where pinned.
    pub(crate) fn new(touched: &[usize], free: &[f64], width: usize) -> Option<Self> {
        let pairs = touched.as_chunks::<2>().0;
        let first = pairs.first()?[0];
        let in_turn = pairs.iter().enumerate().all(|(i, pair)| *pair == [first + i, first + i + 1]);
        let inside = free[1..free.len() - 1].iter().all(|&free| free > 0.0);
        let free = [free[0] > 0.0, free[free.len() - 1] > 0.0];
        (width == 2 && in_turn && inside).then_some(Self { first, free })
    }

    /// The bodies that can move, of so many rows.
    pub(crate) fn bodies(&self, rows: usize) -> Range<usize> {
        self.first + usize::from(!self.free[0])..self.first + rows + usize::from(self.free[1])
    }

    /// Calls `see` with Σ xᵢ times its blocks of each body in turn that can move.
    #[inline(always)]
    pub(crate) fn combine<const D: usize>(
        &self,
        blocks: &[[f64; D]],
        x: &[f64],
        mut see: impl FnMut([f64; D]),
    ) {
        let mut rows = x.iter().zip(blocks.as_chunks::<2>().0);
        let Some((&x, [own, next])) = rows.next() else { return };
        if self.free[0] {
            see(scaled(x, own));
        }
        let mut carried = scaled(x, next);
        for (&x, [own, next]) in rows {
            see(add_scaled(&carried, x, own));
            carried = scaled(x, next);
        }
        if self.free[1] {
            see(carried);
        }
    }

    /// The same for two kinds of blocks at once.
    #[inline(always)]
    pub(crate) fn combine_both<const D: usize>(
        &self,
        blocks: [&[[f64; D]]; 2],
        x: [&[f64]; 2],
        mut see: impl FnMut([f64; D], [f64; D]),
    ) {
        let [a, b] = blocks.map(|blocks| blocks.as_chunks::<2>().0);
        let mut rows = x[0].iter().zip(x[1]).zip(a.iter().zip(b));
        let Some(((&x, &y), ([own_x, next_x], [own_y, next_y]))) = rows.next() else { return };
        if self.free[0] {
            see(scaled(x, own_x), scaled(y, own_y));
        }
        let mut carried = (scaled(x, next_x), scaled(y, next_y));
        for ((&x, &y), ([own_x, next_x], [own_y, next_y])) in rows {
            see(add_scaled(&carried.0, x, own_x), add_scaled(&carried.1, y, own_y));
            carried = (scaled(x, next_x), scaled(y, next_y));
        }
        if self.free[1] {
            see(carried.0, carried.1);
        }
    }
}
