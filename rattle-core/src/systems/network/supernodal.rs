//! The momentum equation by faer's supernodal Cholesky factorisation.
//!
//! G M⁻¹Gᵀ at one place is symmetric and positive definite: half the entries and half the operations of L and U, in
//! dense blocks on registers as wide as the processor has. The position equation, whose normals are those of two
//! places, stays with [`Factor`](super::factor::Factor).

use crate::systems::network::pattern::Pattern;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltError;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::supernodal::SupernodalLltRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};
use std::fmt;
use std::sync::Arc;

/// Dense blocks pay from so many operations for each entry of L on: a chain has 1, a net of 60 × 60 squares 36, one of
/// 160 × 160 has 88, a lattice of 14 × 14 × 14 bodies 180.
const OPERATIONS: usize = 40;

pub(super) struct Supernodal {
    symbolic: Arc<SymbolicCholesky<usize>>,
    /// The matrix up to its diagonal: columns of each row, ascending, and where they begin; by symmetry these are the
    /// rows of the columns of its upper triangle.
    pub(super) columns: Vec<usize>,
    pub(super) start: Vec<usize>,
    pub(super) entries: Vec<f64>,
    /// L, block by block.
    factor: Vec<f64>,
    room: Room,
}

impl Supernodal {
    /// For a matrix with these columns in each row, up to the diagonal. None where it does not pay, or memory is short.
    pub(super) fn new(pattern: &Pattern, columns_of: impl Fn(usize) -> Vec<usize>) -> Option<Self> {
        let m = pattern.order.len();
        let operations: usize = pattern.upper_start.windows(2).map(|at| (at[1] - at[0]).pow(2)).sum();
        if operations <= OPERATIONS * pattern.lower.len() {
            return None;
        }
        let (mut columns, mut start) = (Vec::new(), vec![0]);
        for k in 0..m {
            columns.extend(columns_of(k));
            start.push(columns.len());
        }
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let matrix = SymbolicSparseColMatRef::new_checked(m, m, &start, None, &columns);
        let order = SymmetricOrdering::Identity; // the pattern's
        let symbolic = factorize_symbolic_cholesky(matrix, Side::Upper, order, params).ok()?;
        let (entries, factor) = (vec![0.0; columns.len()], vec![0.0; symbolic.len_val()]);
        let room = Room::of(&symbolic);
        Some(Self { symbolic: Arc::new(symbolic), columns, start, entries, factor, room })
    }

    /// Factors the entries. Returns the smallest ratio of a pivot to its diagonal entry, and where; 0 where there is no
    /// factor.
    pub(super) fn factor(&mut self) -> (f64, usize) {
        let m = self.start.len() - 1;
        let pattern = SymbolicSparseColMatRef::new_checked(m, m, &self.start, None, &self.columns);
        let outcome = self.symbolic.factorize_numeric_llt(
            &mut self.factor,
            SparseColMatRef::new(pattern, &self.entries[..]),
            Side::Upper,
            Default::default(),
            Par::Seq,
            MemStack::new(&mut self.room.factor),
            Default::default(),
        );
        if let Err(LltError::NonPositivePivot { index }) = outcome {
            return (0.0, index.min(m - 1));
        }
        let SymbolicCholeskyRaw::Supernodal(symbolic) = self.symbolic.raw() else {
            return (0.0, 0);
        };
        let factor = SupernodalLltRef::new(symbolic, &self.factor);
        let mut weakest = (f64::INFINITY, 0);
        for block in (0..symbolic.n_supernodes()).map(|s| factor.supernode(s)) {
            for i in 0..block.val().ncols() {
                let k = block.start() + i;
                let ratio = block.val()[(i, i)].powi(2) / self.entries[self.start[k + 1] - 1];
                if ratio < weakest.0 || ratio.is_nan() {
                    weakest = (ratio, k);
                }
            }
        }
        weakest
    }

    /// x for a right side; `y` is room.
    pub(super) fn solve(&mut self, pattern: &Pattern, right: &[f64], x: &mut [f64], y: &mut [f64]) {
        let m = right.len();
        y.iter_mut().zip(&pattern.order).for_each(|(y, &row)| *y = right[row]);
        LltRef::<usize, f64>::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(y, m, 1),
            Par::Seq,
            MemStack::new(&mut self.room.solve),
        );
        y.iter().zip(&pattern.order).for_each(|(y, &row)| x[row] = *y);
    }
}

impl Clone for Supernodal {
    fn clone(&self) -> Self {
        Self {
            symbolic: self.symbolic.clone(),
            columns: self.columns.clone(),
            start: self.start.clone(),
            entries: self.entries.clone(),
            factor: self.factor.clone(),
            room: Room::of(&self.symbolic),
        }
    }
}

impl fmt::Debug for Supernodal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "L with {} entries in blocks", self.factor.len())
    }
}

/// Memory that faer works in, made before the first step.
struct Room {
    factor: MemBuffer,
    solve: MemBuffer,
}

impl Room {
    fn of(symbolic: &SymbolicCholesky<usize>) -> Self {
        Self {
            factor: MemBuffer::new(
                symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default()),
            ),
            solve: MemBuffer::new(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq)),
        }
    }
}
