//! The pull GᵀΛ that makes equations change as they should, found in rounds.
//!
//! Elimination of G M⁻¹Gᵀ takes ε/sine² of Λ, where the sine is that of a normal to the others. Where that is more than
//! some bits, what is left is formed by the bodies, as G M⁻¹f, and solved for again: each round leaves ε/sine² of what
//! the one before left.

use crate::systems::linked::kept::along;
use crate::systems::network::mass::Root;
use crate::systems::network::rows::Rows;
use crate::systems::network::solver::Solver;

/// Rounds where elimination loses digits; of a sine of 1e-7, below which a step is refused, each one takes 1/45.
pub(super) const ROUNDS: usize = 12;

/// What equations of a component are asked for: that ∇gᵢ·M⁻¹f be these changes.
pub(super) struct Pull<'a, const D: usize> {
    pub(super) rows: &'a Rows,
    pub(super) roots: &'a [Root<D>],
    pub(super) blocks: &'a [[f64; D]],
    pub(super) changes: &'a [f64],
}

impl<const D: usize> Pull<'_, D> {
    /// Adds the pull to f, and writes x. `accelerations` are M⁻¹f without it, and afterwards room, as `needed` and
    /// `more` are for a number of each row.
    #[inline(always)]
    pub(super) fn add(
        &self,
        solver: &mut Solver<D>,
        f: &mut [[f64; D]],
        accelerations: &mut [[f64; D]],
        [x, needed, more]: [&mut [f64]; 3],
    ) {
        let Self { rows, roots, blocks, .. } = *self;
        self.fall_short(accelerations, needed);
        solver.respond(rows, blocks, roots, needed, x);
        solver.push(rows, roots, 1.0, x, f);
        if solver.is_lossy() {
            self.refine(solver, f, accelerations, [x, needed, more]);
        }
    }

    /// By how much ∇gᵢ·M⁻¹f falls short of what it is to be.
    #[inline(always)]
    fn fall_short(&self, accelerations: &[[f64; D]], needed: &mut [f64]) {
        for (row, (needed, change)) in needed.iter_mut().zip(self.changes).enumerate() {
            *needed = change - along(self.rows, row, self.blocks, accelerations);
        }
    }

    #[cold]
    #[inline(never)]
    fn refine(
        &self,
        solver: &mut Solver<D>,
        f: &mut [[f64; D]],
        accelerations: &mut [[f64; D]],
        [x, needed, more]: [&mut [f64]; 3],
    ) {
        let Self { rows, roots, blocks, .. } = *self;
        let mut rounds = Rounds::after_one();
        while rounds.has_another(true) {
            for &body in &rows.bodies {
                accelerations[body] = roots[body].velocity(&f[body]);
            }
            self.fall_short(accelerations, needed);
            solver.respond(rows, blocks, roots, needed, more);
            if !rounds.takes(more, needed) {
                return;
            }
            solver.push(rows, roots, 1.0, more, f);
            x.iter_mut().zip(&*more).for_each(|(x, more)| *x += more);
        }
    }
}

/// Rounds of solving for the same.
pub(super) struct Rounds {
    /// Behind.
    number: usize,
    /// By a solver that loses digits.
    lossy: bool,
    /// The square of how far the last one moved bodies.
    last: f64,
}

impl Rounds {
    pub(super) fn begin() -> Self {
        Self { number: 0, lossy: false, last: f64::INFINITY }
    }

    /// After a first one, whose outcome is taken.
    pub(super) fn after_one() -> Self {
        Self { number: 1, ..Self::begin() }
    }

    #[inline(always)]
    pub(super) fn is_first(&self) -> bool {
        self.number == 0
    }

    /// Whether there may be one more round, by a solver that loses digits or does not.
    #[inline(always)]
    pub(super) fn has_another(&mut self, lossy: bool) -> bool {
        self.lossy = lossy;
        self.number < if lossy { ROUNDS } else { 2 }
    }

    /// Whether the x that a round found of these residuals is taken: from the third one on if it does at most half of
    /// what the one before did; else it is rounding.
    #[inline(always)]
    pub(super) fn takes(&mut self, x: &[f64], residuals: &[f64]) -> bool {
        self.number += 1;
        self.number < 2 || !self.lossy || self.shrinks(x, residuals)
    }

    #[cold]
    fn shrinks(&mut self, x: &[f64], residuals: &[f64]) -> bool {
        // Where each body has its mass; the same however equations are scaled.
        let now = x.iter().zip(residuals).map(|(x, residual)| (x * residual).abs()).sum();
        let last = std::mem::replace(&mut self.last, now);
        now < 0.25 * last
    }
}
