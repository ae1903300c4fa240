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

    /// Factorises the numbers. Where they have no factors, the column is told that has a number that is not finite,
    /// else the one whose numbers are the smallest.
    pub(crate) fn factorise(&mut self) -> Result<(), usize> {
        if !self.values.iter().all(|x| x.is_finite()) {
            return Err(self.weakest());
        }
        let n = self.columns.len() - 1;
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &self.columns, None, &self.rows);
        let matrix = SparseColMatRef::new(pattern, &self.values[..]);
        if self.symbolic.is_none() {
            self.symbolic = SymbolicLu::try_new(pattern).ok();
        }
        let symbolic = self.symbolic.clone();
        self.factors = symbolic.and_then(|symbolic| Lu::try_new_with_symbolic(symbolic, matrix).ok());
        if self.factors.is_some() { Ok(()) } else { Err(self.weakest()) }
    }

    fn weakest(&self) -> usize {
        let size = |column: usize| {
            let finite = |x: &f64| if x.is_finite() { x.abs() } else { f64::NEG_INFINITY };
            let places = self.columns[column] as usize..self.columns[column + 1] as usize;
            let sizes = self.values[places].iter().map(finite);
            if sizes.clone().any(|size| size < 0.0) { -1.0 } else { sizes.fold(0.0, f64::max) }
        };
        (0..self.columns.len() - 1).min_by(|&i, &j| size(i).total_cmp(&size(j))).unwrap_or(0)
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

#[cfg(test)]
mod tests {
    use super::Sparse;

    #[test]
    fn where_there_are_no_factors_a_column_is_named() {
        let mut matrix = Sparse::of_groups(4, [[0_u32, 1], [1, 2], [2, 3]].into_iter());
        for column in 0..4 {
            let places: Vec<(usize, usize)> = matrix.column(column).collect();
            places
                .iter()
                .for_each(|&(row, place)| matrix.values[place] = if row == column { 2.0 } else { -1.0 });
        }
        assert_eq!(matrix.factorise(), Ok(()));
        let mut x = [1.0, 0.0, 0.0, 0.0];
        matrix.solve(&mut x);
        (0..4).for_each(|i| assert!((x[i] - 0.2 * (4 - i) as f64).abs() < 1e-15, "{x:?}"));
        let diagonal = matrix.place(2, 2) as usize;
        matrix.values[diagonal] = f64::NAN;
        assert_eq!(matrix.factorise(), Err(2));
        matrix.values[diagonal] = f64::INFINITY;
        assert_eq!(matrix.factorise(), Err(2));
        let column: Vec<(usize, usize)> = matrix.column(3).collect();
        matrix.values[diagonal] = 2.0;
        column.iter().for_each(|&(_, place)| matrix.values[place] = 0.0);
        let mut x = [0.0, 0.0, 0.0, 1.0];
        match matrix.factorise() {
            Ok(()) => {
                matrix.solve(&mut x);
                assert!(!x[3].is_finite());
            }
            Err(column) => assert_eq!(column, 3),
        }
    }
}
