//! Sparse matrices by rows, of a symmetric pattern, as a smoother needs them.

/// A square matrix of a fixed pattern. In each row columns ascend, and the diagonal is there.
pub(crate) struct Rows {
    pub(crate) starts: Vec<u32>,
    pub(crate) columns: Vec<u32>,
    pub(crate) values: Vec<f64>,
    /// Where the entries of the diagonal are, and one over each.
    pub(crate) diagonals: Vec<u32>,
    pub(crate) inverse: Vec<f64>,
}

/// A change of a depth that is smaller is 0, where the largest number on the right side is about 1. Numbers that fade
/// away from vertex to vertex would get subnormal, where processors are slow: the dam break on 17 000 vertices took
/// twice as long.
const NOTHING: f64 = 1e-60;

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
        Rows { values: vec![0.0; columns.len()], inverse: vec![0.0; size], starts, columns, diagonals }
    }

    pub(crate) fn size(&self) -> usize {
        self.diagonals.len()
    }

    pub(crate) fn row(&self, i: usize) -> std::ops::Range<usize> {
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

    fn sum(&self, places: std::ops::Range<usize>, x: &[f64]) -> f64 {
        let entries = self.values[places.clone()].iter().zip(&self.columns[places]);
        entries.map(|(value, &column)| value * x[column as usize]).sum()
    }

    pub(crate) fn multiply(&self, x: &[f64], y: &mut [f64]) {
        y.iter_mut().enumerate().for_each(|(i, y)| *y = self.sum(self.row(i), x));
    }

    /// Gauss and Seidel from 0, first row first: (D + L) x = b.
    pub(crate) fn forward(&self, b: &[f64], x: &mut [f64]) {
        for i in 0..b.len() {
            let left = b[i] - self.sum(self.row(i).start..self.diagonals[i] as usize, x);
            x[i] = flushed(left * self.inverse[i]);
        }
    }

    /// What is left after this at a row: −U x.
    pub(crate) fn left(&self, i: usize, x: &[f64]) -> f64 {
        -self.sum(self.diagonals[i] as usize + 1..self.row(i).end, x)
    }

    /// Gauss and Seidel, last row first: (D + U) x′ = b − L x; and A x′ = (D + U) x′ + L x′.
    pub(crate) fn backward(&self, b: &[f64], x: &mut [f64], image: &mut [f64]) {
        for i in (0..b.len()).rev() {
            let (row, diagonal) = (self.row(i), self.diagonals[i] as usize);
            image[i] = b[i] - self.sum(row.start..diagonal, x);
            x[i] = flushed((image[i] - self.sum(diagonal + 1..row.end, x)) * self.inverse[i]);
        }
        for (i, image) in image.iter_mut().enumerate() {
            *image += self.sum(self.row(i).start..self.diagonals[i] as usize, x);
        }
    }
}

pub(crate) fn flushed(x: f64) -> f64 {
    if x.abs() < NOTHING { 0.0 } else { x }
}
