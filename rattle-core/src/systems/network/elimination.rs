//! Elimination for many equations: G M⁻¹Gᵀ factored by rows on a pattern that is found once.
//!
//! The pattern is symmetric, the matrix need not be: in the position equation the normals are those of two places.
//! Pivots stay on the diagonal, which is safe as long as the normals turn by less than a right angle; a pivot that is
//! not positive says that they did. The order is one of minimum degree: chains and trees fill in nothing, so that a step
//! costs as many operations as there are equations.

use crate::number::vector::{add_scaled, dot};
use crate::systems::network::algebra::LinearAlgebra;
use crate::systems::network::factor::{Factor, TOGETHER};
use crate::systems::network::mass::Root;
use crate::systems::network::pattern::Pattern;
use crate::systems::network::rows::Rows;
#[cfg(feature = "faer")]
use crate::systems::network::supernodal::Supernodal;
use std::mem::take;

#[derive(Debug, Clone)]
pub(crate) struct Elimination<const D: usize> {
    pattern: Pattern,
    /// Rows that touch a body, with the block.
    touching: Vec<(usize, usize)>,
    touching_start: Vec<usize>,
    /// Normals where the step starts, and M⁻¹ times them.
    normals: Vec<[f64; D]>,
    lifted: Vec<[f64; D]>,
    at_start: Factor,
    at_trial: Factor,
    /// In place of the factor at the start.
    #[cfg(feature = "faer")]
    supernodal: Option<Box<Supernodal>>,
    permuted: Vec<f64>,
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
        let rows_of_body: Vec<Vec<usize>> =
            of_body.iter().map(|touching| touching.iter().map(|&(row, _)| row).collect()).collect();
        let pattern = Pattern::new(&rows_of_body, m);
        let mut touching_start = vec![0];
        let mut touching = Vec::new();
        for list in of_body {
            touching.extend(list);
            touching_start.push(touching.len());
        }
        let factor = Factor::new(&pattern);
        let blocks = vec![[0.0; D]; rows.blocks()];
        Self {
            pattern,
            touching,
            touching_start,
            normals: blocks.clone(),
            lifted: blocks,
            at_start: factor.clone(),
            at_trial: factor,
            #[cfg(feature = "faer")]
            supernodal: None,
            permuted: vec![0.0; m],
        }
    }

    /// The same with a supernodal factor where the step starts, if it pays.
    #[cfg(feature = "faer")]
    pub(crate) fn supernodal(rows: &Rows) -> Self {
        let mut elimination = Self::new(rows);
        let Self { pattern, touching, touching_start, .. } = &elimination;
        let columns = |k: usize| {
            let bodies = rows.blocks_of(pattern.order[k]).map(|(_, body)| body);
            let rows = bodies.flat_map(|body| &touching[touching_start[body]..touching_start[body + 1]]);
            let mut columns: Vec<_> =
                rows.map(|&(row, _)| pattern.rank_of[row]).filter(|&rank| rank <= k).collect();
            columns.sort_unstable();
            columns.dedup();
            columns
        };
        elimination.supernodal = Supernodal::new(pattern, columns).map(Box::new);
        if elimination.supernodal.is_some() {
            elimination.at_start = Factor::default();
        }
        elimination
    }

    /// How the momentum equation is solved.
    pub(crate) fn by(&self) -> LinearAlgebra {
        #[cfg(feature = "faer")]
        if self.supernodal.is_some() {
            return LinearAlgebra::Supernodal;
        }
        LinearAlgebra::Elimination
    }

    /// Entries of the factor below the diagonal that were not in the matrix.
    pub(crate) fn fill(&self) -> usize {
        self.pattern.lower.len() - self.pattern.entries
    }

    /// Takes the normals over. Returns the sine of the angle of the least independent one to those before, and its row.
    pub(crate) fn normals(&mut self, rows: &Rows, blocks: &[[f64; D]], roots: &[Root<D>]) -> (f64, usize) {
        for row in 0..rows.equations() {
            for (block, body) in rows.blocks_of(row) {
                self.lifted[block] = roots[rows.bodies[body]].velocity(&blocks[block]);
            }
        }
        self.normals.copy_from_slice(blocks);
        #[cfg(feature = "faer")]
        if let Some(mut supernodal) = self.supernodal.take() {
            let (square, k) = self.factor_supernodal(rows, &mut supernodal);
            self.supernodal = Some(supernodal);
            return (square.max(0.0).sqrt(), self.pattern.order[k]);
        }
        let mut factor = take(&mut self.at_start);
        let (square, k) = self.factor::<false>(rows, blocks, &mut factor, true);
        self.at_start = factor;
        (square.max(0.0).sqrt(), self.pattern.order[k])
    }

    /// Factors (normals)(lifted)ᵀ, of which it forms the entries up to the diagonal.
    #[cfg(feature = "faer")]
    fn factor_supernodal(&mut self, rows: &Rows, supernodal: &mut Supernodal) -> (f64, usize) {
        let Self { pattern, touching, touching_start, normals, lifted, permuted: line, .. } = self;
        line.fill(0.0);
        for k in 0..pattern.order.len() {
            for (block, body) in rows.blocks_of(pattern.order[k]) {
                for &(row, other) in &touching[touching_start[body]..touching_start[body + 1]] {
                    if pattern.rank_of[row] <= k {
                        line[pattern.rank_of[row]] += dot(&normals[block], &lifted[other]);
                    }
                }
            }
            for at in supernodal.start[k]..supernodal.start[k + 1] {
                supernodal.entries[at] = take(&mut line[supernodal.columns[at]]);
            }
        }
        supernodal.factor()
    }

    /// Takes the derivative of g along the start's normals at a trial position, or its symmetric part; the smallest pivot,
    /// relative to its entry.
    pub(crate) fn chord<const SYMMETRIC: bool>(&mut self, rows: &Rows, blocks: &[[f64; D]]) -> f64 {
        let mut factor = take(&mut self.at_trial);
        let (smallest, _) = self.factor::<SYMMETRIC>(rows, blocks, &mut factor, false);
        self.at_trial = factor;
        smallest
    }

    /// Factors (blocks)(lifted)ᵀ, or its symmetric part. Returns the smallest ratio of a pivot to its diagonal entry, and where.
    fn factor<const SYMMETRIC: bool>(
        &self,
        rows: &Rows,
        blocks: &[[f64; D]],
        factor: &mut Factor,
        at_start: bool,
    ) -> (f64, usize) {
        if self.pattern.widest < TOGETHER {
            self.factor_rows::<SYMMETRIC, false>(rows, blocks, factor, at_start)
        } else {
            self.factor_rows::<SYMMETRIC, true>(rows, blocks, factor, at_start)
        }
    }

    fn factor_rows<const SYMMETRIC: bool, const WIDE: bool>(
        &self,
        rows: &Rows,
        blocks: &[[f64; D]],
        factor: &mut Factor,
        at_start: bool,
    ) -> (f64, usize) {
        let Self { pattern, touching, touching_start, lifted, .. } = self;
        let mut weakest = (f64::INFINITY, 0);
        for k in 0..pattern.order.len() {
            for (block, body) in rows.blocks_of(pattern.order[k]) {
                for &(row, other) in &touching[touching_start[body]..touching_start[body + 1]] {
                    let entry = dot(&blocks[block], &lifted[other]);
                    let mirrored = if SYMMETRIC { dot(&blocks[other], &lifted[block]) } else { entry };
                    let entry = if SYMMETRIC { 0.5 * (entry + mirrored) } else { entry };
                    factor.line[pattern.rank_of[row]] += entry;
                }
            }
            let entry = factor.line[k];
            let ratio = factor.eliminate::<WIDE>(pattern, k) / entry;
            let ratio = if at_start { ratio } else { ratio * entry.signum() };
            if ratio < weakest.0 || ratio.is_nan() {
                weakest = (ratio, k);
            }
        }
        weakest
    }

    /// Λ such that G moves at these rates when the bodies move by M⁻¹GᵀΛ.
    pub(crate) fn solve(&mut self, rates: &[f64], x: &mut [f64]) {
        #[cfg(feature = "faer")]
        if let Some(supernodal) = &mut self.supernodal {
            return supernodal.solve(&self.pattern, rates, x, &mut self.permuted);
        }
        self.at_start.solve(&self.pattern, rates, x, &mut self.permuted);
    }

    /// Newton's correction for residuals g, with the derivative of [`Self::chord`].
    pub(crate) fn correct(&mut self, g: &[f64], dx: &mut [f64]) {
        self.at_trial.solve(&self.pattern, g, dx, &mut self.permuted);
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
