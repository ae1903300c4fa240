//! An orthonormal basis of the normals of a few equations, which may be nearly or exactly dependent.
//!
//! ```text
//! L⁻¹Gᵀ S⁻¹ Π = Q R        M = L Lᵀ,  S the lengths of the columns,  Π puts the most independent first
//! ```
//!
//! Column-pivoted Gram–Schmidt, each column made orthogonal twice (L. Giraud, J. Langou, M. Rozložník 2005: that is
//! enough). The condition of G enters once, not squared as in G M⁻¹Gᵀ. A column that is left with less than
//! [`DEPENDENT`] of its length adds nothing; multipliers are then those of least norm, with every equation scaled to
//! a normal of length 1 in the metric of M⁻¹, so that how it is written does not matter, but masses do.
//!
//! Equations may depend on each other only where all hold. At a place that is off by δ, be it by rounding, such a
//! normal has a sine of some δ, and what its equation asks for is divided by that. So the number of independent
//! equations is that of the start, where it is judged by what places are off. More count only where normals are clearly
//! apart, by more than the start was off, as after a start from where a mechanism branches; and at stages, which may be
//! far off, none.

use crate::number::vector::{add_scaled, dot, scaled};
use crate::systems::network::mass::Root;
use crate::systems::network::rows::Rows;

/// A normal whose part orthogonal to the others is shorter than this is one of their combinations: well above the
/// rounding of a sum, well below any angle that carries digits.
const DEPENDENT: f64 = 1e-12;

/// Below this sine a normal may be independent by what a place is off alone: where a mechanism branches, places are
/// known to √ε.
pub(crate) const BRANCHING: f64 = 1e-6;

/// Where not all act along normals, rows are exchanged if a pivot is less than this part of what it could be: that
/// takes a digit.
const SMALL_PIVOT: f64 = 0.1;

/// A component of more equations gets no basis: its cost is their cube, and of 800 equations of a net a step takes 1 s.
pub(crate) const MOST_EQUATIONS: usize = 1000;

#[derive(Debug, Clone)]
pub(crate) struct Basis<const D: usize> {
    equations: usize,
    bodies: usize,
    pub(crate) rank: usize,
    /// So many were independent where that was judged: others count by a sine above [`Self::beyond`].
    most: usize,
    beyond: f64,
    /// Columns of Q, a block for each body.
    q: Vec<[f64; D]>,
    /// R by rows, as wide as there are equations.
    r: Vec<f64>,
    order: Vec<usize>,
    lengths: Vec<f64>,
    /// For dependent equations R = T V with T triangular and the rows of V orthonormal, both by rows.
    v: Vec<f64>,
    t: Vec<f64>,
    /// (G at the trial) L⁻ᵀQ, reduced to `rank` equations and factored.
    chord: Vec<f64>,
    /// Which row takes the place of each, where rows are exchanged.
    exchanged: Option<Vec<usize>>,
    column: Vec<f64>,
}

impl<const D: usize> Basis<D> {
    /// For so many equations, some of which may be acted on along other directions than their normals.
    pub(crate) fn new(equations: usize, bodies: usize, acting: bool) -> Self {
        let square = vec![0.0; equations * equations];
        Self {
            equations,
            bodies,
            rank: 0,
            most: equations,
            beyond: BRANCHING,
            q: vec![[0.0; D]; equations * bodies],
            r: square.clone(),
            order: (0..equations).collect(),
            lengths: vec![0.0; equations],
            v: square.clone(),
            t: square.clone(),
            chord: square,
            exchanged: acting.then(|| (0..equations).collect()),
            column: vec![0.0; equations],
        }
    }

    /// Has no more than so many equations count by a sine below this one.
    pub(crate) fn limit(&mut self, most: usize, beyond: f64) {
        (self.most, self.beyond) = (most, beyond);
    }

    /// The sine of each equation that counts to those before it.
    pub(crate) fn sines(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.rank).map(|k| self.r[k * self.equations + k])
    }

    /// Of what normals the one is made that is the k-th most independent: those before it and itself, by their rows,
    /// each with how many times it is taken where all have the length 1 in the metric of M⁻¹.
    pub(crate) fn made_of(&self, k: usize) -> Vec<(usize, f64)> {
        let (m, mut times) = (self.equations, vec![1.0; k + 1]);
        for l in (0..k).rev() {
            let known: f64 = (l + 1..k).map(|j| self.r[l * m + j] * times[j]).sum();
            times[l] = (self.r[l * m + k] - known) / self.r[l * m + l];
        }
        self.order[..=k].iter().copied().zip(times).collect()
    }

    /// Takes the normals over. Returns the sine of the angle of the least independent one to the others, and its row.
    pub(crate) fn normals(&mut self, rows: &Rows, blocks: &[[f64; D]], roots: &[Root<D>]) -> (f64, usize) {
        (0..self.equations).for_each(|i| self.order[i] = i);
        self.take::<true>(rows, blocks, roots, (self.most, self.beyond))
    }

    /// The same at a place that may be far off the constraints: those equations count that did at the place before. As
    /// accelerations are then not those of all, the choice must be the same for all stages of a step.
    pub(crate) fn normals_off(
        &mut self,
        rows: &Rows,
        blocks: &[[f64; D]],
        roots: &[Root<D>],
    ) -> (f64, usize) {
        self.take::<false>(rows, blocks, roots, (self.rank, f64::INFINITY))
    }

    /// The same where so many equations count in any case, and others by a sine above this one. Either chooses the most
    /// independent ones first, or keeps the order of the last time.
    fn take<const CHOOSES: bool>(
        &mut self,
        rows: &Rows,
        blocks: &[[f64; D]],
        roots: &[Root<D>],
        (most, beyond): (usize, f64),
    ) -> (f64, usize) {
        let (m, n) = (self.equations, self.bodies);
        self.q.fill([0.0; D]);
        self.r.fill(0.0);
        for k in 0..m {
            let (i, column) = (self.order[k], &mut self.q[k * n..(k + 1) * n]);
            for (block, body) in rows.blocks_of(i) {
                column[body] = roots[rows.bodies[body]].halve(&blocks[block]);
            }
            let length = square(column).sqrt();
            self.lengths[i] = length;
            if length > 0.0 {
                column.iter_mut().for_each(|part| *part = scaled(1.0 / length, part));
            }
        }
        self.rank = 0;
        let mut weakest = (f64::INFINITY, 0);
        for k in 0..m {
            let (pivot, left) = (k..if CHOOSES { m } else { k + 1 })
                .map(|j| (j, square(&self.q[j * n..(j + 1) * n])))
                .fold((k, -1.0), |best, next| if next.1 > best.1 { next } else { best });
            self.swap(k, pivot);
            for l in 0..k {
                let again = self.along(l, k);
                self.subtract(l, k, again);
            }
            let left = square(&self.q[k * n..(k + 1) * n]).sqrt().min(left.sqrt());
            weakest = (left, self.order[k]);
            let least = if k < most { DEPENDENT } else { beyond };
            if left <= least || left.is_nan() {
                break;
            }
            self.rank = k + 1;
            self.r[k * m + k] = left;
            self.q[k * n..(k + 1) * n].iter_mut().for_each(|part| *part = scaled(1.0 / left, part));
            for j in k + 1..m {
                let part = self.along(k, j);
                self.subtract(k, j, part);
            }
        }
        if self.rank < m {
            self.complete();
        }
        weakest
    }

    /// For dependent equations: an orthonormal basis of the rows of R.
    fn complete(&mut self) {
        let (m, r) = (self.equations, self.rank);
        self.t.fill(0.0);
        for k in (0..r).rev() {
            self.v[k * m..(k + 1) * m].copy_from_slice(&self.r[k * m..(k + 1) * m]);
            for _ in 0..2 {
                for l in k + 1..r {
                    let part: f64 = (0..m).map(|j| self.v[l * m + j] * self.v[k * m + j]).sum();
                    self.t[k * m + l] += part;
                    (0..m).for_each(|j| self.v[k * m + j] -= part * self.v[l * m + j]);
                }
            }
            let length = (0..m).map(|j| self.v[k * m + j] * self.v[k * m + j]).sum::<f64>().sqrt();
            self.t[k * m + k] = length;
            (0..m).for_each(|j| self.v[k * m + j] /= length);
        }
    }

    fn swap(&mut self, a: usize, b: usize) {
        if a != b {
            let (m, n) = (self.equations, self.bodies);
            self.order.swap(a, b);
            (0..n).for_each(|i| self.q.swap(a * n + i, b * n + i));
            (0..a.min(b)).for_each(|row| self.r.swap(row * m + a, row * m + b));
        }
    }

    fn along(&self, l: usize, k: usize) -> f64 {
        let n = self.bodies;
        self.q[l * n..(l + 1) * n].iter().zip(&self.q[k * n..(k + 1) * n]).map(|(a, b)| dot(a, b)).sum()
    }

    /// Takes `part` of column l from column k.
    fn subtract(&mut self, l: usize, k: usize, part: f64) {
        let (m, n) = (self.equations, self.bodies);
        self.r[l * m + k] += part;
        for i in 0..n {
            self.q[k * n + i] = add_scaled(&self.q[k * n + i], -part, &self.q[l * n + i]);
        }
    }

    /// x such that G moves at these rates when the bodies move by [`Self::displace`]\(x\).
    pub(crate) fn solve(&self, rates: &[f64], x: &mut [f64]) {
        let (m, r) = (self.equations, self.rank);
        if r == m {
            for k in 0..r {
                let i = self.order[k];
                let known: f64 = (0..k).map(|l| self.r[l * m + k] * x[l]).sum();
                x[k] = (rates[i] / self.lengths[i] - known) / self.r[k * m + k];
            }
        } else {
            // Rᵀx = Πᵀ rates, so Tᵀx = V Πᵀ rates
            for k in 0..r {
                let scaled_rate = |j: usize| {
                    let i = self.order[j];
                    if self.lengths[i] > 0.0 { rates[i] / self.lengths[i] } else { 0.0 }
                };
                let projected: f64 = (0..m).map(|j| self.v[k * m + j] * scaled_rate(j)).sum();
                let known: f64 = (0..k).map(|l| self.t[l * m + k] * x[l]).sum();
                x[k] = (projected - known) / self.t[k * m + k];
            }
        }
    }

    /// The multipliers Λ with L⁻¹GᵀΛ = Q x, of least norm.
    pub(crate) fn multipliers(&mut self, x: &[f64], multipliers: &mut [f64]) {
        let (m, r) = (self.equations, self.rank);
        let triangle = if r == m { &self.r } else { &self.t };
        let y = &mut self.column;
        for k in (0..r).rev() {
            let known: f64 = (k + 1..r).map(|l| triangle[k * m + l] * y[l]).sum();
            y[k] = (x[k] - known) / triangle[k * m + k];
        }
        for k in 0..m {
            let i = self.order[k];
            let value = if r == m { y[k] } else { (0..r).map(|l| self.v[l * m + k] * y[l]).sum() };
            multipliers[i] = if self.lengths[i] > 0.0 { value / self.lengths[i] } else { 0.0 };
        }
    }

    /// x with Q x = L⁻¹GᵀΛ for these multipliers.
    pub(crate) fn coefficients(&self, multipliers: &[f64], x: &mut [f64]) {
        let m = self.equations;
        for k in 0..self.rank {
            let scaled = |j: usize| self.lengths[self.order[j]] * multipliers[self.order[j]];
            x[k] = (k..m).map(|j| self.r[k * m + j] * scaled(j)).sum();
        }
    }

    /// Calls `add` with the part L⁻¹δ of each body's displacement δ, for coefficients x.
    #[inline]
    fn combine(&self, x: &[f64], mut add: impl FnMut(usize, [f64; D])) {
        for body in 0..self.bodies {
            let mut part = [0.0; D];
            for (k, x) in x[..self.rank].iter().enumerate() {
                part = add_scaled(&part, *x, &self.q[k * self.bodies + body]);
            }
            add(body, part);
        }
    }

    /// Adds M⁻¹GᵀΛ to each body's place.
    pub(crate) fn displace(&self, rows: &Rows, roots: &[Root<D>], x: &[f64], out: &mut [[f64; D]]) {
        self.combine(x, |body, part| {
            let place = rows.bodies[body];
            out[place] = add_scaled(&out[place], 1.0, &roots[place].halve_transposed(&part));
        });
    }

    /// Calls `see` with M⁻¹GᵀΛ of each body, by its number in the scene.
    #[inline(always)]
    pub(crate) fn displacements(
        &self,
        rows: &Rows,
        roots: &[Root<D>],
        x: &[f64],
        mut see: impl FnMut(usize, [f64; D]),
    ) {
        self.combine(x, |body, part| {
            let place = rows.bodies[body];
            see(place, roots[place].halve_transposed(&part));
        });
    }

    /// Calls `see` with M⁻¹GᵀΛ of each body, by its number in the scene, and GᵀΛ/h.
    #[inline(always)]
    pub(crate) fn moves(
        &self,
        rows: &Rows,
        roots: &[Root<D>],
        h: f64,
        x: &[f64],
        mut see: impl FnMut(usize, &[f64; D], &[f64; D]),
    ) {
        self.combine(x, |body, part| {
            let place = rows.bodies[body];
            let root = &roots[place];
            let impulse = root.restore(&part);
            see(place, &root.velocity(&impulse), &impulse.map(|impulse| impulse / h));
        });
    }

    /// Calls `see` with `scale` GᵀΛ of each body, by its number in the scene.
    #[inline(always)]
    pub(crate) fn pushes(
        &self,
        rows: &Rows,
        roots: &[Root<D>],
        scale: f64,
        x: &[f64],
        mut see: impl FnMut(usize, [f64; D]),
    ) {
        self.combine(x, |body, part| {
            let place = rows.bodies[body];
            see(place, scaled(scale, &roots[place].restore(&part)));
        });
    }

    /// Adds `scale` GᵀΛ to each body's momentum.
    pub(crate) fn push(&self, rows: &Rows, roots: &[Root<D>], scale: f64, x: &[f64], out: &mut [[f64; D]]) {
        self.combine(x, |body, part| {
            let place = rows.bodies[body];
            out[place] = add_scaled(&out[place], scale, &roots[place].restore(&part));
        });
    }

    /// Takes the derivative of g along the basis at a trial position. The smallest pivot, relative to 1: not positive
    /// where the normals there are turned over. Or the symmetric part of that derivative.
    pub(crate) fn chord<const SYMMETRIC: bool>(
        &mut self,
        rows: &Rows,
        blocks: &[[f64; D]],
        roots: &[Root<D>],
    ) -> f64 {
        let (m, r, n) = (self.equations, self.rank, self.bodies);
        let mut along = std::mem::take(&mut self.column);
        for k in 0..r {
            for (i, rate) in along.iter_mut().enumerate() {
                *rate = 0.0;
                for (block, body) in rows.blocks_of(i) {
                    let place = rows.bodies[body];
                    *rate += dot(&roots[place].halve(&blocks[block]), &self.q[k * n + body]);
                }
            }
            let mut x = std::mem::take(&mut self.chord);
            self.solve(&along, &mut x[k * m..k * m + r]); // column k of a matrix near 1
            self.chord = x;
        }
        self.column = along;
        if SYMMETRIC {
            for k in 0..r {
                for i in 0..k {
                    let mean = 0.5 * (self.chord[k * m + i] + self.chord[i * m + k]);
                    (self.chord[k * m + i], self.chord[i * m + k]) = (mean, mean);
                }
            }
        }
        // Elimination without exchanges: the matrix is the identity where the step starts, if all act along normals.
        let a = &mut self.chord; // by columns
        let mut smallest = f64::INFINITY;
        for k in 0..r {
            if let Some(exchanged) = &mut self.exchanged {
                exchanged[k] = pivot_row(&a[k * m..k * m + r], k);
                (0..r).for_each(|j| a.swap(j * m + k, j * m + exchanged[k]));
            }
            let pivot = a[k * m + k];
            if pivot < smallest || pivot.is_nan() {
                smallest = pivot;
            }
            for i in k + 1..r {
                let factor = a[k * m + i] / pivot;
                a[k * m + i] = factor;
                for j in k + 1..r {
                    a[j * m + i] -= factor * a[j * m + k];
                }
            }
        }
        smallest
    }

    /// The sign of the determinant of that derivative along the basis; 0 where it is none but for rounding.
    pub(crate) fn orientation(&self) -> f64 {
        let m = self.equations;
        (0..self.rank).fold(1.0, |sign, k| {
            let pivot = self.chord[k * m + k];
            let stays = self.exchanged.as_ref().is_none_or(|exchanged| exchanged[k] == k);
            let sign = if stays { sign } else { -sign };
            if pivot.abs() <= DEPENDENT { 0.0 } else { sign * pivot.signum() }
        })
    }

    /// Newton's correction for residuals g, with the derivative of [`Self::chord`].
    pub(crate) fn correct(&self, g: &[f64], dx: &mut [f64]) {
        let (m, r) = (self.equations, self.rank);
        self.solve(g, dx);
        let a = &self.chord;
        dx[..r].iter_mut().for_each(|x| *x = -*x);
        if let Some(exchanged) = &self.exchanged {
            (0..r).for_each(|k| dx.swap(k, exchanged[k]));
        }
        for i in 0..r {
            for k in 0..i {
                dx[i] -= a[k * m + i] * dx[k];
            }
        }
        for i in (0..r).rev() {
            for k in i + 1..r {
                dx[i] -= a[k * m + i] * dx[k];
            }
            dx[i] /= a[i * m + i];
        }
    }
}

/// The row of this column, from row k on, whose entry is to be the pivot: k itself unless that is far smaller than
/// others.
fn pivot_row(column: &[f64], k: usize) -> usize {
    let best =
        (k..column.len()).fold(k, |best, i| if column[i].abs() > column[best].abs() { i } else { best });
    if column[k].abs() >= SMALL_PIVOT * column[best].abs() { k } else { best }
}

fn square<const D: usize>(column: &[[f64; D]]) -> f64 {
    column.iter().map(|part| dot(part, part)).sum()
}
