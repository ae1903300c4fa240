//! Sparse linear equations of one pattern: analysed once, factorised for every new set of numbers, by faer.

use crate::krylov::Iterative;
use faer::MatMut;
use faer::prelude::Solve;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};

/// A square matrix of a fixed pattern, and its LU factors with partial pivoting.
pub(crate) struct Sparse {
    columns: Vec<u32>,
    rows: Vec<u32>,
    /// The numbers, column by column.
    pub(crate) values: Vec<f64>,
    /// Made when first needed: never, where iterations serve.
    symbolic: Option<SymbolicLu<u32>>,
    factors: Option<Lu<u32, f64>>,
}

impl Sparse {
    /// The matrix with an entry wherever two of the numbers of one group meet.
    pub(crate) fn of_groups(
        size: usize,
        groups: impl Iterator<Item = impl IntoIterator<Item = u32> + Clone> + Clone,
    ) -> Self {
        let mut below: Vec<Vec<u32>> = (0..size as u32).map(|i| vec![i]).collect();
        for group in groups {
            for column in group.clone() {
                below[column as usize].extend(group.clone());
            }
        }
        let mut columns = vec![0];
        let mut rows = Vec::new();
        for column in &mut below {
            column.sort_unstable();
            column.dedup();
            rows.extend_from_slice(column);
            columns.push(rows.len() as u32);
        }
        let values = vec![0.0; rows.len()];
        Sparse { columns, rows, values, symbolic: None, factors: None }
    }

    /// Where the entry of a row and a column is among the values.
    pub(crate) fn place(&self, row: u32, column: u32) -> u32 {
        let [start, end] = [0, 1].map(|i| self.columns[column as usize + i] as usize);
        let place = self.rows[start..end].binary_search(&row).expect("an entry of the pattern");
        (start + place) as u32
    }

    /// The entries of a column: rows and places among the values.
    pub(crate) fn column(&self, column: usize) -> impl Iterator<Item = (usize, usize)> {
        let [start, end] = [0, 1].map(|i| self.columns[column + i] as usize);
        (start..end).map(|place| (self.rows[place] as usize, place))
    }

    /// Factorises the numbers. False where one of them is not finite: then nothing was done.
    pub(crate) fn factorise(&mut self) -> bool {
        if !self.values.iter().all(|x| x.is_finite()) {
            return false;
        }
        let n = self.columns.len() - 1;
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &self.columns, None, &self.rows);
        let matrix = SparseColMatRef::new(pattern, &self.values[..]);
        if self.symbolic.is_none() {
            self.symbolic = SymbolicLu::try_new(pattern).ok();
        }
        let symbolic = self.symbolic.clone();
        self.factors = symbolic.and_then(|symbolic| Lu::try_new_with_symbolic(symbolic, matrix).ok());
        self.factors.is_some()
    }

    /// The same matrix, to be solved by iteration.
    pub(crate) fn iterative(&self) -> Iterative {
        Iterative::of(&self.columns, &self.rows)
    }

    /// Solves with the factors, in place.
    pub(crate) fn solve(&self, vector: &mut [f64]) {
        let n = vector.len();
        if let Some(factors) = &self.factors {
            factors.solve_in_place(MatMut::from_column_major_slice_mut(vector, n, 1));
        }
    }
}
