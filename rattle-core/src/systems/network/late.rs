//! Late equations: equations that are solved after all others, as a border of the factorisation.
//!
//! Where bodies are unknowns beside the multipliers ([`super::hubs`]), an equation that holds well may have no pivot
//! among the equations before it: a rod from a hub to a body, and one in the same line from there to a pin. Such an
//! equation is left out of the factor, and its multiplier found from the others:
//!
//! ```text
//! A′ x + c x_late = g      z = A′⁻¹c       (a − r z) x_late = g_late − r A′⁻¹g
//! r x  + a x_late = g_late                  x = A′⁻¹g − z x_late
//! ```
//!
//! A hub of D coordinates makes at most D equations late, where others do not depend on each other. Room for all would
//! be too much where hubs are many and late equations few: there is room for [`FEWEST`], and at the start of a run,
//! where more are found to be late, for twice as many as are.

use crate::systems::network::factor::Factor;
use crate::systems::network::pattern::Pattern;

/// Late equations of one factor that there is room for at least, if hubs have as many coordinates.
const FEWEST: usize = 8;

#[derive(Debug, Clone, Default)]
pub(super) struct Late {
    /// Unknowns of the factor, those among them that are coordinates of hubs, and late equations that there is room
    /// for.
    unknowns: usize,
    coordinates: usize,
    most: usize,
    /// Late equations for which there was no room, and those for which there was.
    refused: usize,
    taken: usize,
    /// The latter first.
    rows: Vec<usize>,
    /// z and r, one after the other.
    responses: Vec<f64>,
    lines: Vec<f64>,
    /// a − r z, factored, row by row.
    corner: Vec<f64>,
    right: Vec<f64>,
    room: Vec<f64>,
    last: Vec<f64>,
}

impl Late {
    /// For so many unknowns, of which so many are coordinates of hubs.
    pub(super) fn new(unknowns: usize, coordinates: usize) -> Self {
        Self::with_room(unknowns, coordinates, coordinates.min(FEWEST))
    }

    /// One with more room, if late equations were refused for want of it, and as many may be late.
    pub(super) fn grown(&self) -> Option<Self> {
        let most = self.coordinates.min(2 * (self.taken + self.refused));
        (self.refused > 0 && most > self.most).then(|| Self::with_room(self.unknowns, self.coordinates, most))
    }

    fn with_room(unknowns: usize, coordinates: usize, most: usize) -> Self {
        Self {
            unknowns,
            coordinates,
            most,
            refused: 0,
            taken: 0,
            rows: vec![0; most],
            responses: vec![0.0; most * unknowns],
            lines: vec![0.0; most * unknowns],
            corner: vec![0.0; most * most],
            right: vec![0.0; unknowns],
            room: vec![0.0; unknowns],
            last: vec![0.0; most],
        }
    }

    pub(super) fn clear(&mut self) {
        (self.taken, self.refused) = (0, 0);
    }

    /// Takes an equation. False if there is no room for it.
    pub(super) fn take(&mut self, row: usize) -> bool {
        let room = self.taken < self.most;
        if room {
            self.rows[self.taken] = row;
            self.taken += 1;
        } else {
            self.refused += 1;
        }
        room
    }

    pub(super) fn rows(&self) -> &[usize] {
        &self.rows[..self.taken]
    }

    /// Factors the border; `line` and `column` write the entries of a row and a column of the matrix, by unknown. Calls
    /// `see` with each late equation and its pivot.
    #[cold]
    #[inline(never)]
    pub(super) fn factor(
        &mut self,
        pattern: &Pattern,
        factor: &Factor,
        mut line: impl FnMut(usize, &mut [f64]),
        mut column: impl FnMut(usize, &mut [f64]),
        mut see: impl FnMut(usize, f64),
    ) {
        let (n, late) = (self.unknowns, self.taken);
        for (a, &row) in self.rows[..late].iter().enumerate() {
            self.right.fill(0.0);
            column(row, &mut self.right);
            for (b, &other) in self.rows[..late].iter().enumerate() {
                self.corner[b * self.most + a] = std::mem::take(&mut self.right[other]);
            }
            factor.solve(pattern, 1.0, &self.right, &mut self.responses[a * n..(a + 1) * n], &mut self.room);
            let entries = &mut self.lines[a * n..(a + 1) * n];
            entries.fill(0.0);
            line(row, entries);
            self.rows[..late].iter().for_each(|&other| entries[other] = 0.0);
        }
        for a in 0..late {
            for b in 0..late {
                self.corner[a * self.most + b] -= dot(self.line(a), self.response(b));
            }
        }
        for k in 0..late {
            let pivot = self.corner[k * self.most + k];
            see(self.rows[k], pivot);
            for a in k + 1..late {
                self.corner[a * self.most + k] /= pivot;
                for b in k + 1..late {
                    let known = self.corner[a * self.most + k] * self.corner[k * self.most + b];
                    self.corner[a * self.most + b] -= known;
                }
            }
        }
    }

    /// The pivots of the border.
    pub(super) fn pivots(&self) -> impl Iterator<Item = f64> {
        (0..self.taken).map(|k| self.corner[k * self.most + k])
    }

    fn line(&self, a: usize) -> &[f64] {
        &self.lines[a * self.unknowns..(a + 1) * self.unknowns]
    }

    fn response(&self, a: usize) -> &[f64] {
        &self.responses[a * self.unknowns..(a + 1) * self.unknowns]
    }

    /// The first unknowns for a right side of the equations; the others have the right side 0.
    pub(super) fn solve(
        &mut self,
        pattern: &Pattern,
        factor: &Factor,
        right: &[f64],
        x: &mut [f64],
        solved: &mut [f64],
    ) {
        self.right[..right.len()].copy_from_slice(right);
        self.right[right.len()..].fill(0.0);
        let late = self.taken;
        self.rows[..late].iter().for_each(|&row| self.right[row] = 0.0);
        factor.solve(pattern, 1.0, &self.right, solved, &mut self.room);
        for a in 0..late {
            let mut rest = right[self.rows[a]] - dot(self.line(a), solved);
            for b in 0..a {
                rest -= self.corner[a * self.most + b] * self.last[b];
            }
            self.last[a] = rest;
        }
        for a in (0..late).rev() {
            for b in a + 1..late {
                self.last[a] -= self.corner[a * self.most + b] * self.last[b];
            }
            self.last[a] /= self.corner[a * self.most + a];
        }
        for a in 0..late {
            let last = self.last[a];
            solved.iter_mut().zip(self.response(a)).for_each(|(x, z)| *x -= z * last);
        }
        x.copy_from_slice(&solved[..x.len()]);
        self.rows[..late].iter().zip(&self.last).for_each(|(&row, &last)| x[row] = last);
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
