//! The choice of linear algebra for a component.

use crate::number::vector::sum;
use crate::systems::network::algebra::LinearAlgebra;
use crate::systems::network::dense::Dense;
use crate::systems::network::elimination::Elimination;
use crate::systems::network::group::LinkGroup;
use crate::systems::network::mass::Root;
use crate::systems::network::orthogonal::Basis;
use crate::systems::network::rows::Rows;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

#[derive(Debug, Clone)]
pub(crate) enum Solver<const D: usize> {
    Orthogonal(Box<Basis<D>>),
    Elimination(Box<Elimination<D>>),
    /// Of a few equations: elimination where these normals are [clearly](CLEARLY) independent, else the basis.
    Few(Box<Few<D>>),
}

#[derive(Debug, Clone)]
pub(crate) struct Few<const D: usize> {
    basis: Basis<D>,
    elimination: Way<D>,
    /// Whether the last normals are clearly independent.
    clear: bool,
}

/// Normals with a larger sine to those before lose four bits by elimination at most, as that takes the sine squared.
pub(crate) const CLEARLY: f64 = 0.25;

/// Elimination in full where that is possible, else on a pattern.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant, reason = "behind a box")]
enum Way<const D: usize> {
    Dense(Dense<D>),
    Sparse(Elimination<D>),
}

/// What does the work.
enum By<B, E, F> {
    Basis(B),
    Elimination(E),
    Dense(F),
}

impl<const D: usize> Solver<D> {
    pub(crate) fn orthogonal(rows: &Rows) -> Self {
        Self::Orthogonal(Box::new(Basis::new(rows.equations(), rows.bodies.len(), rows.acting)))
    }

    pub(crate) fn elimination(rows: &Rows, roots: &[Root<D>]) -> Self {
        Self::Elimination(Box::new(Elimination::new(rows, roots)))
    }

    pub(crate) fn few(
        rows: &Rows,
        roots: &[Root<D>],
        groups: &[Arc<dyn LinkGroup<D>>],
        pins: &BTreeMap<usize, [f64; D]>,
    ) -> Self {
        let basis = Basis::new(rows.equations(), rows.bodies.len(), rows.acting);
        let sparse = || Way::Sparse(Elimination::new(rows, roots));
        let elimination = Dense::new(rows, roots, groups, pins).map_or_else(sparse, Way::Dense);
        Self::Few(Box::new(Few { basis, elimination, clear: false }))
    }

    #[cfg(feature = "faer")]
    pub(crate) fn supernodal(rows: &Rows, roots: &[Root<D>]) -> Self {
        Self::Elimination(Box::new(Elimination::supernodal(rows, roots)))
    }

    #[inline(always)]
    fn by(&self) -> By<&Basis<D>, &Elimination<D>, &Dense<D>> {
        match self {
            Self::Orthogonal(basis) => By::Basis(basis),
            Self::Elimination(elimination) => By::Elimination(elimination),
            Self::Few(few) => match &few.elimination {
                _ if !few.clear => By::Basis(&few.basis),
                Way::Dense(dense) => By::Dense(dense),
                Way::Sparse(elimination) => By::Elimination(elimination),
            },
        }
    }

    #[inline(always)]
    fn by_mut(&mut self) -> By<&mut Basis<D>, &mut Elimination<D>, &mut Dense<D>> {
        match self {
            Self::Orthogonal(basis) => By::Basis(basis),
            Self::Elimination(elimination) => By::Elimination(elimination),
            Self::Few(few) => match &mut few.elimination {
                _ if !few.clear => By::Basis(&mut few.basis),
                Way::Dense(dense) => By::Dense(dense),
                Way::Sparse(elimination) => By::Elimination(elimination),
            },
        }
    }

    /// Whether an orthonormal basis of the normals does the work, which bears small angles.
    pub(crate) fn is_orthogonal(&self) -> bool {
        matches!(self.by(), By::Basis(_))
    }

    /// Elimination in full, if that is what does the work.
    #[inline(always)]
    pub(crate) fn dense(&mut self) -> Option<&mut Dense<D>> {
        match self.by_mut() {
            By::Dense(dense) => Some(dense),
            _ => None,
        }
    }

    /// Elimination on a pattern, if that is what does the work.
    #[inline(always)]
    pub(crate) fn elimination_mut(&mut self) -> Option<&mut Elimination<D>> {
        match self.by_mut() {
            By::Elimination(elimination) => Some(elimination),
            _ => None,
        }
    }

    /// M⁻¹ times the normals in blocks, by elimination on a pattern.
    #[inline(always)]
    pub(crate) fn lifted(&self) -> Option<&[[f64; D]]> {
        match self.by() {
            By::Elimination(elimination) => Some(elimination.at_start()[1]),
            _ => None,
        }
    }

    /// Whether elimination does the work, and loses digits.
    #[inline(always)]
    pub(crate) fn is_lossy(&self) -> bool {
        matches!(self.by(), By::Elimination(elimination) if elimination.is_lossy())
    }

    /// Independent equations, as far as the last normals show.
    pub(crate) fn rank(&self, rows: &Rows) -> usize {
        match self.by() {
            By::Basis(basis) => basis.rank,
            By::Elimination(_) | By::Dense(_) => rows.equations(),
        }
    }

    /// The sine of each equation that counts to those before it, where a basis does the work.
    pub(crate) fn sines(&self) -> Vec<f64> {
        match self.by() {
            By::Basis(basis) => basis.sines().collect(),
            By::Elimination(_) | By::Dense(_) => Vec::new(),
        }
    }

    /// Of what normals those are made that count from the k-th on, by rows, where a basis does the work.
    pub(crate) fn made_of(&self, from: usize) -> Vec<Vec<(usize, f64)>> {
        match self.by() {
            By::Basis(basis) => (from..basis.rank).map(|k| basis.made_of(k)).collect(),
            By::Elimination(_) | By::Dense(_) => Vec::new(),
        }
    }

    /// Has a basis count no more equations than so many, but by a sine above this one.
    pub(crate) fn limit(&mut self, most: usize, beyond: f64) {
        match self {
            Self::Orthogonal(basis) => basis.limit(most, beyond),
            Self::Few(few) => few.basis.limit(most, beyond),
            Self::Elimination(_) => {}
        }
    }

    /// Takes the normals over. Returns the sine of the angle of the least independent one to others, and its row.
    pub(crate) fn normals(&mut self, rows: &Rows, blocks: &[[f64; D]], roots: &[Root<D>]) -> (f64, usize) {
        match self {
            Self::Orthogonal(basis) => basis.normals(rows, blocks, roots),
            Self::Elimination(elimination) => elimination.normals(rows, blocks, roots),
            Self::Few(few) => {
                let found = match &mut few.elimination {
                    Way::Dense(dense) => dense.normals(blocks),
                    Way::Sparse(elimination) => elimination.normals(rows, blocks, roots),
                };
                few.clear = found.0 > CLEARLY && found.0.is_finite();
                if few.clear { found } else { few.basis.normals(rows, blocks, roots) }
            }
        }
    }

    /// The same at a place that may be far off the constraints: those equations count that did at the place before.
    pub(crate) fn normals_off(
        &mut self,
        rows: &Rows,
        blocks: &[[f64; D]],
        roots: &[Root<D>],
    ) -> (f64, usize) {
        let some = self.rank(rows) < rows.equations();
        match self {
            Self::Orthogonal(basis) if some => basis.normals_off(rows, blocks, roots),
            Self::Few(few) if some => few.basis.normals_off(rows, blocks, roots),
            _ => self.normals(rows, blocks, roots),
        }
    }

    /// The same before a run, where room may be made.
    pub(crate) fn first_normals(
        &mut self,
        rows: &Rows,
        blocks: &[[f64; D]],
        roots: &[Root<D>],
    ) -> (f64, usize) {
        loop {
            let found = self.normals(rows, blocks, roots);
            let Self::Elimination(elimination) = self else { return found };
            if !elimination.make_room() {
                let of_hubs = elimination.judge_hubs(rows, roots);
                return if of_hubs.0 < found.0 { of_hubs } else { found };
            }
        }
    }

    pub(crate) fn chord<const SYMMETRIC: bool>(
        &mut self,
        rows: &Rows,
        blocks: &[[f64; D]],
        roots: &[Root<D>],
    ) -> f64 {
        match self.by_mut() {
            By::Basis(basis) => basis.chord::<SYMMETRIC>(rows, blocks, roots),
            By::Elimination(elimination) => elimination.chord::<SYMMETRIC>(rows, blocks, roots),
            By::Dense(dense) => dense.chord::<SYMMETRIC>(blocks),
        }
    }

    /// The sign of the determinant of the last derivative, where multipliers act on chosen coordinates: pivots may then
    /// have any sign. 0 or no number where there is no factor.
    pub(crate) fn orientation(&self) -> f64 {
        match self.by() {
            By::Basis(basis) => basis.orientation(),
            By::Elimination(elimination) => elimination.orientation(),
            By::Dense(_) => f64::NAN, // has no such multipliers
        }
    }

    pub(crate) fn correct(&mut self, g: &[f64], dx: &mut [f64]) {
        match self.by_mut() {
            By::Basis(basis) => basis.correct(g, dx),
            By::Elimination(elimination) => elimination.correct(g, dx),
            By::Dense(dense) => dense.correct(g, dx),
        }
    }

    /// x such that the equations change at these rates, by the last normals.
    pub(crate) fn solve(&mut self, rates: &[f64], x: &mut [f64]) {
        match self.by_mut() {
            By::Basis(basis) => basis.solve(rates, x),
            By::Elimination(elimination) => elimination.solve(rates, x),
            By::Dense(dense) => dense.solve(rates, x),
        }
    }

    /// The same where multipliers act on chosen coordinates only: the matrix is then not symmetric, as between two
    /// places. `rates` are used up.
    #[inline(never)]
    pub(crate) fn respond(
        &mut self,
        rows: &Rows,
        blocks: &[[f64; D]],
        roots: &[Root<D>],
        rates: &mut [f64],
        x: &mut [f64],
    ) {
        if rows.acting {
            let least = self.chord::<false>(rows, blocks, roots);
            if let Some(elimination) = self.elimination_mut() {
                elimination.note_least(least);
            }
            rates.iter_mut().for_each(|rate| *rate = -*rate);
            self.correct(rates, x);
        } else {
            self.solve(rates, x);
        }
    }

    pub(crate) fn multipliers(&mut self, x: &[f64], multipliers: &mut [f64]) {
        match self.by_mut() {
            By::Basis(basis) => basis.multipliers(x, multipliers),
            By::Elimination(_) | By::Dense(_) => multipliers.copy_from_slice(x),
        }
    }

    /// The x that has these multipliers.
    pub(crate) fn coefficients(&self, multipliers: &[f64], x: &mut [f64]) {
        match self.by() {
            By::Basis(basis) => basis.coefficients(multipliers, x),
            By::Elimination(_) | By::Dense(_) => x.copy_from_slice(multipliers),
        }
    }

    /// A scalar product of two x, the same however equations are scaled, given the lengths of their gradients.
    pub(crate) fn product(&self, lengths: &[f64], a: &[f64], b: &[f64]) -> f64 {
        match self.by() {
            By::Basis(basis) => a[..basis.rank].iter().zip(b).map(|(a, b)| a * b).sum(),
            By::Elimination(_) | By::Dense(_) => {
                a.iter().zip(b).zip(lengths).map(|((a, b), length)| (a * length) * (b * length)).sum()
            }
        }
    }

    /// Calls `see` with the displacement M⁻¹GᵀΛ of each body, by its number in the scene.
    #[inline(always)]
    pub(crate) fn displacements(
        &self,
        rows: &Rows,
        roots: &[Root<D>],
        x: &[f64],
        see: impl FnMut(usize, [f64; D]),
    ) {
        match self.by() {
            By::Basis(basis) => basis.displacements(rows, roots, x, see),
            By::Elimination(elimination) => elimination.displacements(rows, x, see),
            By::Dense(dense) => dense.displacements(rows, x, see),
        }
    }

    pub(crate) fn displace(&self, rows: &Rows, roots: &[Root<D>], x: &[f64], out: &mut [[f64; D]]) {
        match self.by() {
            By::Basis(basis) => basis.displace(rows, roots, x, out),
            By::Elimination(elimination) => elimination.displace(rows, x, out),
            By::Dense(dense) => {
                dense.displacements(rows, x, |body, way| out[body] = sum(&out[body], &way));
            }
        }
    }

    /// Calls `see` with the impulse `scale` GᵀΛ on each body, by its number in the scene.
    #[inline(always)]
    pub(crate) fn pushes(
        &self,
        rows: &Rows,
        roots: &[Root<D>],
        scale: f64,
        x: &[f64],
        see: impl FnMut(usize, [f64; D]),
    ) {
        match self.by() {
            By::Basis(basis) => basis.pushes(rows, roots, scale, x, see),
            By::Elimination(elimination) => elimination.pushes(rows, scale, x, see),
            By::Dense(dense) => dense.pushes(rows, scale, x, see),
        }
    }

    /// Calls `see` with the displacement M⁻¹GᵀΛ of each body, by its number in the scene, and the impulse GᵀΛ/h.
    /// `impulses` is room for as many numbers as x has.
    #[inline(always)]
    pub(crate) fn moves(
        &self,
        rows: &Rows,
        roots: &[Root<D>],
        h: f64,
        x: &[f64],
        impulses: &mut [f64],
        see: impl FnMut(usize, &[f64; D], &[f64; D]),
    ) {
        match self.by() {
            By::Basis(basis) => basis.moves(rows, roots, h, x, see),
            By::Elimination(elimination) => elimination.moves(rows, h, x, impulses, see),
            By::Dense(dense) => dense.moves(rows, h, x, impulses, see),
        }
    }

    pub(crate) fn push(&self, rows: &Rows, roots: &[Root<D>], scale: f64, x: &[f64], out: &mut [[f64; D]]) {
        match self.by() {
            By::Basis(basis) => basis.push(rows, roots, scale, x, out),
            By::Elimination(elimination) => elimination.push(rows, scale, x, out),
            By::Dense(dense) => {
                dense.pushes(rows, scale, x, |body, impulse| out[body] = sum(&out[body], &impulse));
            }
        }
    }
}

/// The size of a component of linked bodies, and how its multipliers are found.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// Bodies that can move.
    pub bodies: usize,
    /// The number of equations.
    pub equations: usize,
    /// The number of independent equations.
    pub rank: usize,
    /// The linear algebra in use at the start; never [`LinearAlgebra::Automatic`].
    pub by: LinearAlgebra,
    /// Fill-in: entries of the factor below the diagonal that are not in the pattern of the links; 0 for chains and
    /// trees.
    pub fill: usize,
}

impl Report {
    pub(crate) fn of<const D: usize>(rows: &Rows, solver: &Solver<D>) -> Self {
        let (by, fill) = match solver.by() {
            By::Basis(_) => (LinearAlgebra::Orthogonal, 0),
            By::Elimination(elimination) => (elimination.by(), elimination.fill()),
            By::Dense(_) => (LinearAlgebra::Elimination, 0),
        };
        Self { bodies: rows.bodies.len(), equations: rows.equations(), rank: solver.rank(rows), by, fill }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bodies = if self.bodies == 1 { "body" } else { "bodies" };
        write!(f, "{} {bodies}, {} equations", self.bodies, self.equations)?;
        if self.rank < self.equations {
            write!(f, " of which {} independent", self.rank)?;
        }
        match self.by {
            LinearAlgebra::Automatic | LinearAlgebra::Orthogonal => write!(f, ": orthonormal basis"),
            LinearAlgebra::Elimination => write!(f, ": elimination, {} entries filled in", self.fill),
            #[cfg(feature = "faer")]
            LinearAlgebra::Supernodal => {
                write!(f, ": elimination, supernodal, {} entries filled in", self.fill)
            }
        }
    }
}
