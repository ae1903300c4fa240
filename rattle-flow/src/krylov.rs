//! Sparse linear equations by iteration: BiCGStab (van der Vorst 1992), preconditioned by ILU(0), factors without fill.
//!
//! A mesh of N triangles has LU factors of some N log N numbers, made in N^1.5 operations; an iteration takes N. The
//! answer is inexact, and would move the volume: what is left, r = b − A x, is spread so that its sum is 0: see
//! `solve`.

/// A matrix in rows of a symmetric pattern, its incomplete factors, and room for the iteration.
pub(crate) struct Iterative {
    /// Where rows start, and the places of their diagonals.
    starts: Vec<u32>,
    diagonals: Vec<u32>,
    columns: Vec<u32>,
    /// For each entry by rows, where it is among the entries by columns.
    by_column: Vec<u32>,
    values: Vec<f64>,
    factors: Vec<f64>,
    /// 1ᵀA.
    sums: Vec<f64>,
    /// Places in the row at hand; `NONE` elsewhere.
    places: Vec<u32>,
    room: [Vec<f64>; 9],
}

const NONE: u32 = u32::MAX;
/// So many iterations at most; then it is LU's turn.
const MOST: usize = 300;

impl Iterative {
    /// Of a symmetric pattern, by columns.
    pub(crate) fn of(columns: &[u32], rows: &[u32]) -> Self {
        let n = columns.len() - 1;
        let mut next = columns.to_vec();
        let mut by_column = vec![0; rows.len()];
        let mut diagonals = vec![0; n];
        for column in 0..n {
            for place in columns[column]..columns[column + 1] {
                let row = rows[place as usize] as usize;
                // Columns come in order, so that rows get sorted; the pattern is symmetric, so that starts are the
                // same.
                by_column[next[row] as usize] = place;
                if row == column {
                    diagonals[row] = next[row];
                }
                next[row] += 1;
            }
        }
        Iterative {
            starts: columns.to_vec(),
            diagonals,
            columns: rows.to_vec(),
            by_column,
            values: vec![0.0; rows.len()],
            factors: vec![0.0; rows.len()],
            sums: vec![0.0; n],
            places: vec![NONE; n],
            room: std::array::from_fn(|_| vec![0.0; n]),
        }
    }

    fn row(&self, i: usize) -> std::ops::Range<usize> {
        self.starts[i] as usize..self.starts[i + 1] as usize
    }

    /// Takes the numbers, column by column, and makes incomplete factors: L U = A where A has entries, L with diagonal
    /// 1. False where a pivot is not a number or 0.
    pub(crate) fn factorise(&mut self, values: &[f64]) -> bool {
        let n = self.sums.len();
        self.sums.fill(0.0);
        for (place, &from) in self.by_column.iter().enumerate() {
            self.values[place] = values[from as usize];
            self.sums[self.columns[place] as usize] += values[from as usize];
        }
        self.factors.copy_from_slice(&self.values);
        for i in 0..n {
            let row = self.row(i);
            for place in row.clone() {
                self.places[self.columns[place] as usize] = place as u32;
            }
            for place in row.start..self.diagonals[i] as usize {
                let k = self.columns[place] as usize;
                let diagonal = self.diagonals[k] as usize;
                let factor = self.factors[place] / self.factors[diagonal];
                self.factors[place] = factor;
                for other in diagonal + 1..self.row(k).end {
                    let here = self.places[self.columns[other] as usize];
                    if here != NONE {
                        self.factors[here as usize] -= factor * self.factors[other];
                    }
                }
            }
            for place in row {
                self.places[self.columns[place] as usize] = NONE;
            }
            let pivot = self.factors[self.diagonals[i] as usize];
            if !pivot.is_finite() || pivot == 0.0 {
                return false;
            }
        }
        true
    }

    fn multiply(&self, x: &[f64], y: &mut [f64]) {
        for (i, y) in y.iter_mut().enumerate() {
            *y = self.row(i).map(|place| self.values[place] * x[self.columns[place] as usize]).sum();
        }
    }

    fn precondition(&self, x: &[f64], y: &mut [f64]) {
        for i in 0..x.len() {
            let below = self.row(i).start..self.diagonals[i] as usize;
            let known: f64 = below.map(|place| self.factors[place] * y[self.columns[place] as usize]).sum();
            y[i] = x[i] - known;
        }
        for i in (0..x.len()).rev() {
            let diagonal = self.diagonals[i] as usize;
            let above = diagonal + 1..self.row(i).end;
            let known: f64 = above.map(|place| self.factors[place] * y[self.columns[place] as usize]).sum();
            y[i] = (y[i] - known) / self.factors[diagonal];
        }
    }

    /// Solves in place until |b − A x| ≤ `tolerance` |b|, then adds r / 1ᵀA to x: 1ᵀ(b − A x) = 0 to rounding, however
    /// much of r is left. False, the vector as it was, where that takes too many iterations or breaks down.
    ///
    /// The rows `alone` have a diagonal and nothing else: these are solved exactly, so that the sum over the others is
    /// 0.
    pub(crate) fn solve(&mut self, vector: &mut [f64], tolerance: f64, alone: &[usize]) -> bool {
        let mut room = std::mem::take(&mut self.room);
        let solved = self.iterate(vector, tolerance, &mut room);
        if solved {
            let [x, r, ..] = &mut room;
            for &i in alone {
                x[i] = vector[i] / self.values[self.diagonals[i] as usize];
            }
            self.multiply(x, r);
            for i in 0..x.len() {
                vector[i] = x[i] + (vector[i] - r[i]) / self.sums[i];
            }
        }
        self.room = room;
        solved
    }

    fn iterate(&self, b: &[f64], tolerance: f64, room: &mut [Vec<f64>; 9]) -> bool {
        let [x, r, shadow, p, v, s, t, y, z] = room;
        x.fill(0.0);
        p.fill(0.0);
        v.fill(0.0);
        r.copy_from_slice(b);
        shadow.copy_from_slice(b);
        let enough = tolerance * dot(b, b).sqrt();
        let (mut rho, mut alpha, mut omega) = (1.0, 1.0, 1.0);
        for _ in 0..MOST {
            if dot(r, r).sqrt() <= enough {
                return self.sums.iter().all(|&sum| sum > 0.0);
            }
            let next = dot(shadow, r);
            let beta = next / rho * (alpha / omega);
            rho = next;
            for i in 0..p.len() {
                p[i] = r[i] + beta * (p[i] - omega * v[i]);
            }
            self.precondition(p, y);
            self.multiply(y, v);
            alpha = rho / dot(shadow, v);
            if !alpha.is_finite() {
                return false;
            }
            for i in 0..s.len() {
                s[i] = r[i] - alpha * v[i];
            }
            self.precondition(s, z);
            self.multiply(z, t);
            let square = dot(t, t);
            omega = if square > 0.0 { dot(t, s) / square } else { 0.0 };
            for i in 0..x.len() {
                x[i] += alpha * y[i] + omega * z[i];
                r[i] = s[i] - omega * t[i];
            }
        }
        false
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::Iterative;

    /// A line of points, diffusion with a drift: a tridiagonal matrix, of which ILU(0) is the whole LU.
    fn line(n: usize) -> (Vec<u32>, Vec<u32>, Vec<f64>) {
        let (mut columns, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
        for j in 0..n {
            for i in j.saturating_sub(1)..(j + 2).min(n) {
                rows.push(i as u32);
                values.push(if i == j {
                    3.0 + j as f64 / n as f64
                } else if i < j {
                    -1.3
                } else {
                    -0.7
                });
            }
            columns.push(rows.len() as u32);
        }
        (columns, rows, values)
    }

    #[test]
    fn the_sum_of_what_is_left_is_rounding_however_much_is_left() {
        let n = 40;
        let (columns, rows, mut values) = line(n);
        let mut solver = Iterative::of(&columns, &rows);
        let b: Vec<f64> = (0..n).map(|i| (i as f64).sin() + 0.3).collect();
        // The factors are those of another matrix, so that the iteration has something to do.
        assert!(solver.factorise(&values));
        let factors = solver.factors.clone();
        values.iter_mut().zip(&rows).for_each(|(x, row)| *x *= 1.0 + 0.1 * f64::from(row % 3));
        assert!(solver.factorise(&values));
        solver.factors = factors;
        for (tolerance, least) in [(1e-1, 1e-3), (1e-12, 0.0)] {
            let mut x = b.clone();
            assert!(solver.solve(&mut x, tolerance, &[]));
            let mut y = vec![0.0; n];
            solver.multiply(&x, &mut y);
            let left: Vec<f64> = b.iter().zip(&y).map(|(b, y)| b - y).collect();
            let largest = left.iter().fold(0.0_f64, |most, r| most.max(r.abs()));
            assert!(largest >= least && largest <= 10.0 * tolerance, "{largest:e} at {tolerance:e}");
            assert!(left.iter().sum::<f64>().abs() < 1e-13, "{:e}", left.iter().sum::<f64>());
        }
    }

    #[test]
    fn without_fill_the_factors_are_exact_and_no_pivot_is_zero() {
        let (columns, rows, mut values) = line(20);
        let mut solver = Iterative::of(&columns, &rows);
        assert!(solver.factorise(&values));
        let exact: Vec<f64> = (0..20).map(|i| (0.7 * f64::from(i)).cos()).collect();
        let (mut b, mut x) = (vec![0.0; 20], vec![0.0; 20]);
        solver.multiply(&exact, &mut b);
        solver.precondition(&b, &mut x);
        assert!(x.iter().zip(&exact).all(|(x, exact)| (x - exact).abs() < 1e-14));
        values[0] = 0.0;
        assert!(!solver.factorise(&values));
    }
}
