//! Sparse linear equations by iteration, for Newton's method on a flow.
//!
//! The answer is inexact, and would move the volume: what is left, r = b − A x, has to have the sum 0. So each number
//! of x is changed by one part of itself, see `solve`. Spread over all vertices instead, as r / 1ᵀA, what is left would
//! roughen lakes at rest, where the flux goes with the root of the slope: Newton's method then needed 1e-8 of |b|, and
//! not 1e-3.

use crate::multigrid::{KEPT, Level, coarsen, refresh, solve};
use crate::pieces::{PIECE, each};
use crate::rows::{Rows, flushed};

/// A matrix, its coarse levels, and room for the iteration.
pub(crate) struct Iterative {
    levels: Vec<Level>,
    /// For each entry by rows, where it is among the entries by columns.
    by_column: Vec<u32>,
    /// 1ᵀA.
    sums: Vec<f64>,
    age: Age,
    /// Whether there are numbers that it can be solved with.
    ready: bool,
}

/// How well coarse levels serve that were made for another matrix.
enum Age {
    /// They are to be made.
    Stale,
    /// Nothing has been solved with them.
    Fresh,
    /// Steps per digit in the beginning, and how many steps more were made since than at this pace.
    Used { pace: f64, lost: f64 },
}

/// So many steps at most; then it is LU's turn.
const MOST: usize = 100;
/// Making coarse levels takes as long as so many steps.
const MAKING: f64 = 5.0;

impl Iterative {
    /// Of a symmetric pattern, by columns.
    pub(crate) fn of(columns: &[u32], rows: &[u32]) -> Self {
        let matrix = Rows::of(columns.to_vec(), rows.to_vec());
        let (by_column, sums) = (matrix.across(), vec![0.0; matrix.size()]);
        let levels = vec![Level::of(matrix, KEPT)];
        Iterative { levels, by_column, sums, age: Age::Stale, ready: false }
    }

    /// Takes the numbers, column by column. False where one on the diagonal, or a sum of a column, is not positive.
    pub(crate) fn take(&mut self, values: &[f64]) -> bool {
        let matrix = &mut self.levels[0].matrix;
        let from = &self.by_column;
        each(PIECE, &mut matrix.values, |first, entries| {
            entries.iter_mut().zip(&from[first..]).for_each(|(entry, &from)| *entry = values[from as usize]);
        });
        let column = |j: usize| &values[matrix.row(j)]; // the pattern is symmetric
        each(PIECE, &mut self.sums, |first, sums| {
            sums.iter_mut().zip(first..).for_each(|(sum, j)| *sum = column(j).iter().sum());
        });
        if matches!(self.age, Age::Stale) {
            coarsen(&mut self.levels);
            self.age = Age::Fresh;
        }
        self.ready = refresh(&mut self.levels) && self.sums.iter().all(|&sum| sum > 0.0);
        self.ready
    }

    /// Solves in place until |b − A x| ≤ `tolerance` |b|, then adds a part of |x| to x, such that 1ᵀ(b − A x) = 0 to
    /// rounding, however much is left. Returns which part of the answer is not to be relied on. None, the vector as it
    /// was, where that takes too many steps or breaks down.
    ///
    /// The rows `alone` have a diagonal and nothing else: these are solved exactly, so that the sum over the others is
    /// 0.
    pub(crate) fn solve(&mut self, vector: &mut [f64], tolerance: f64, alone: &[usize]) -> Option<f64> {
        let scale = scale(vector);
        vector.iter_mut().for_each(|b| *b /= scale);
        let unsure = self.solve_scaled(vector, tolerance, alone);
        vector.iter_mut().for_each(|x| *x *= scale);
        unsure
    }

    fn solve_scaled(&mut self, vector: &mut [f64], tolerance: f64, alone: &[usize]) -> Option<f64> {
        self.iterate(vector, tolerance)?;
        let Level { matrix, left: r, solution: x, .. } = &mut self.levels[0];
        alone.iter().for_each(|&i| x[i] = vector[i] * matrix.inverse[i]);
        matrix.multiply(x, r);
        let lacking: f64 = vector.iter().zip(&*r).map(|(b, product)| b - product).sum();
        vector.copy_from_slice(x);
        alone.iter().for_each(|&i| x[i] = 0.0);
        let moved: f64 = x.iter().zip(&self.sums).map(|(x, sum)| x.abs() * sum).sum();
        let part = if moved > 0.0 { lacking / moved } else { 0.0 };
        vector.iter_mut().zip(x).for_each(|(answer, x)| *answer = flushed(*answer + part * x.abs()));
        Some(tolerance.max(part.abs()))
    }

    /// Where levels that were made for another matrix do not serve, new ones are tried.
    fn iterate(&mut self, b: &[f64], tolerance: f64) -> Option<()> {
        if !self.ready {
            return None;
        }
        self.levels[0].left.copy_from_slice(b);
        let (steps, digits) = (solve(&mut self.levels, tolerance, MOST), -tolerance.log10());
        self.age = match (&self.age, steps) {
            (Age::Used { .. }, None) => {
                coarsen(&mut self.levels);
                self.age = Age::Fresh;
                self.ready = refresh(&mut self.levels);
                return self.iterate(b, tolerance);
            }
            (_, None) => Age::Stale,
            (Age::Used { pace, lost }, Some(steps)) => {
                let lost = lost + steps as f64 - pace * digits;
                if lost > MAKING { Age::Stale } else { Age::Used { pace: *pace, lost } }
            }
            (_, Some(steps)) => Age::Used { pace: steps as f64 / digits, lost: 0.0 },
        };
        steps.map(drop)
    }
}

/// About the largest of the numbers, as a power of two.
fn scale(vector: &[f64]) -> f64 {
    let largest = vector.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
    if largest > 0.0 { 2.0_f64.powi(largest.log2().clamp(-1000.0, 1000.0) as i32) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::{Age, Iterative};

    /// Diffusion of varying strength on a square of n by n cells, with a drift where the strength is at most 1, by
    /// columns: the sum of each is `mass`.
    struct Square {
        columns: Vec<u32>,
        rows: Vec<u32>,
        values: Vec<f64>,
    }

    fn square(n: usize, mass: f64, strength: impl Fn(usize) -> f64) -> Square {
        let (mut columns, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
        for j in 0..n * n {
            let drift = if strength(j) > 1.0 { 0.0 } else { 1.0 / n as f64 };
            let beside = [
                (j >= n, j.wrapping_sub(n), 1.0 + drift),
                (j % n > 0, j.wrapping_sub(1), 1.0),
                (j % n < n - 1, j + 1, 1.0),
                (j < n * (n - 1), j + n, 1.0 - drift),
            ];
            let out = |&(there, i, drift): &(bool, usize, f64)| {
                there.then(|| (i, drift * strength(i).min(strength(j))))
            };
            let mut column: Vec<(usize, f64)> = beside.iter().filter_map(out).collect();
            let sum: f64 = column.iter().map(|(_, value)| value).sum();
            column.iter_mut().for_each(|(_, value)| *value = -*value);
            column.push((j, mass + sum));
            column.sort_by_key(|&(i, _)| i);
            rows.extend(column.iter().map(|&(i, _)| i as u32));
            values.extend(column.iter().map(|&(_, value)| value));
            columns.push(rows.len() as u32);
        }
        Square { columns, rows, values }
    }

    impl Square {
        /// b − A x.
        fn left(&self, x: &[f64], b: &[f64]) -> Vec<f64> {
            let mut left = b.to_vec();
            for (j, x) in x.iter().enumerate() {
                for place in self.columns[j] as usize..self.columns[j + 1] as usize {
                    left[self.rows[place] as usize] -= self.values[place] * x;
                }
            }
            left
        }
    }

    fn length(x: &[f64]) -> f64 {
        x.iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    /// Something on the right, with a sum of 0 as Newton's method has it.
    fn right(n: usize) -> Vec<f64> {
        let wave = |i: usize| ((i + 1) as f64 * 0.7).sin() - (i as f64 * 0.7).sin();
        (0..n * n).map(wave).collect()
    }

    #[test]
    fn the_sum_of_what_is_left_is_rounding_however_much_is_left() {
        let n = 40;
        let matrix = square(n, 1e-3, |_| 1.0);
        let b = right(n);
        let mut solver = Iterative::of(&matrix.columns, &matrix.rows);
        assert!(solver.take(&matrix.values));
        for (tolerance, least) in [(0.3, 1e-3), (1e-12, 0.0)] {
            let mut x = b.clone();
            let unsure = solver.solve(&mut x, tolerance, &[]).unwrap();
            let left = matrix.left(&x, &b);
            let size = length(&left) / length(&b);
            assert!(size >= least && size <= 3.0 * unsure, "{size:e} at {tolerance:e}, {unsure:e}");
            // 8000 products of at most 10.
            assert!(left.iter().sum::<f64>().abs() < 1e-12, "{:e}", left.iter().sum::<f64>());
        }
    }

    /// Lakes that thin films join: strength varies by 10⁶ from patch to patch, and patches end within aggregates. Ten
    /// digits take 28 steps at most, on sixteen times as many cells too.
    #[test]
    fn steps_do_not_grow_with_the_mesh() {
        for contrast in [1.0, 1e2, 1e6] {
            for n in [34, 61, 136] {
                let patch = |i: usize| {
                    if (4 * (i % n) / n + 4 * (i / n) / n).is_multiple_of(2) { 1.0 } else { contrast }
                };
                let matrix = square(n, 1.0 / n as f64, patch);
                let mut solver = Iterative::of(&matrix.columns, &matrix.rows);
                let mut x = right(n);
                assert!(solver.take(&matrix.values) && solver.solve(&mut x, 1e-10, &[]).is_some());
                let Age::Used { pace, .. } = solver.age else { panic!("used") };
                assert!(10.0 * pace < 28.5, "{} steps for {n}, {contrast:e}", 10.0 * pace);
            }
        }
    }

    /// The same numbers of vertices in an order that knows nothing of the mesh: pieces of it are no smoother.
    #[test]
    fn the_order_of_vertices_hardly_matters() {
        let n = 136;
        let matrix = square(n, 1.0 / n as f64, |_| 1.0);
        let place = |i: usize| (i * 7919 + 13) % (n * n); // 7919 is prime
        let mut columns: Vec<Vec<(u32, f64)>> = vec![Vec::new(); n * n];
        for j in 0..n * n {
            let entries = matrix.columns[j] as usize..matrix.columns[j + 1] as usize;
            let moved =
                entries.map(|entry| (place(matrix.rows[entry] as usize) as u32, matrix.values[entry]));
            columns[place(j)].extend(moved);
            columns[place(j)].sort_by_key(|&(i, _)| i);
        }
        let ends = columns.iter().scan(0, |end, column| {
            *end += column.len() as u32;
            Some(*end)
        });
        let starts: Vec<u32> = std::iter::once(0).chain(ends).collect();
        let rows: Vec<u32> = columns.iter().flatten().map(|&(i, _)| i).collect();
        let values: Vec<f64> = columns.iter().flatten().map(|&(_, value)| value).collect();
        let mut solver = Iterative::of(&starts, &rows);
        let mut x = right(n);
        assert!(solver.take(&values) && solver.solve(&mut x, 1e-10, &[]).is_some());
        let Age::Used { pace, .. } = solver.age else { panic!("used") };
        assert!(10.0 * pace < 28.5, "{} steps", 10.0 * pace);
    }

    #[test]
    fn any_number_of_threads_gives_the_same_bits() {
        let n = 136; // three pieces
        let matrix = square(n, 1.0 / n as f64, |i| 1.0 + (i % 7) as f64);
        let solved = || {
            let (mut x, mut solver) = (right(n), Iterative::of(&matrix.columns, &matrix.rows));
            assert!(solver.take(&matrix.values) && solver.solve(&mut x, 1e-10, &[]).is_some());
            x
        };
        let alone = solved();
        for threads in [1, 2, 3, 8] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert!(pool.install(solved) == alone, "on {threads} threads");
        }
    }

    /// Levels of a matrix whose strong couplings are elsewhere: the answer is the same, with levels made anew once they
    /// have cost too many steps, or at once where they lead nowhere.
    #[test]
    fn levels_that_do_not_serve_are_made_anew() {
        let n = 60;
        for (contrast, anew) in [(1.0, [false, false]), (30.0, [false, true]), (1e6, [true, true])] {
            let stripes = |turned: bool| {
                move |i: usize| if (if turned { i % n } else { i / n }) / 2 % 2 == 0 { 1.0 } else { contrast }
            };
            let (before, after) = (square(n, 1e-2, stripes(false)), square(n, 1e-2, stripes(true)));
            let mut solver = Iterative::of(&before.columns, &before.rows);
            assert!(solver.take(&before.values) && solver.solve(&mut right(n), 1e-8, &[]).is_some());
            let first = solver.levels[1].matrix.columns.clone();
            for anew in [anew[0], anew[1], anew[1]] {
                let mut x = right(n);
                assert!(solver.take(&after.values) && solver.solve(&mut x, 1e-8, &[]).is_some());
                assert!(length(&after.left(&x, &right(n))) < 1e-6 * length(&right(n)));
                assert_eq!(solver.levels[1].matrix.columns != first, anew, "{contrast:e}");
            }
        }
    }

    /// Of rows with a diagonal alone the answer is that of a division.
    #[test]
    fn rows_alone_are_exact() {
        let n = 20;
        let mut matrix = square(n, 1e-2, |_| 1.0);
        let alone: Vec<usize> = (0..n * n).step_by(7).collect();
        for j in 0..n * n {
            for place in matrix.columns[j] as usize..matrix.columns[j + 1] as usize {
                let row = matrix.rows[place] as usize;
                if row.is_multiple_of(7) {
                    matrix.values[place] = if row == j { 3.0 } else { 0.0 };
                }
            }
        }
        // Columns of such rows have given what they had, so that sums stay positive.
        for j in 0..n * n {
            let places = matrix.columns[j] as usize..matrix.columns[j + 1] as usize;
            let sum: f64 = matrix.values[places.clone()].iter().sum();
            let diagonal = places.clone().find(|&place| matrix.rows[place] as usize == j).unwrap();
            matrix.values[diagonal] += (0.01 - sum).max(0.0);
        }
        let b = right(n);
        let (mut x, mut solver) = (b.clone(), Iterative::of(&matrix.columns, &matrix.rows));
        assert!(solver.take(&matrix.values) && solver.solve(&mut x, 0.1, &alone).is_some());
        let left = matrix.left(&x, &b);
        assert!(alone.iter().all(|&i| left[i].abs() < 1e-15) && length(&left) > 1e-3);
        assert!(left.iter().sum::<f64>().abs() < 1e-13);
    }

    /// However small or large all numbers are, and to the bit where they differ by a power of two.
    #[test]
    fn size_does_not_matter() {
        let n = 30;
        let matrix = square(n, 1e-3, |i| 1.0 + (i % 7) as f64);
        let mut solver = Iterative::of(&matrix.columns, &matrix.rows);
        let mut solved = |factor: f64| {
            let mut x: Vec<f64> = right(n).iter().map(|b| factor * b).collect();
            assert!(solver.take(&matrix.values) && solver.solve(&mut x, 1e-8, &[]).is_some());
            x.iter().map(|x| x / factor).collect::<Vec<f64>>()
        };
        let one = solved(1.0);
        assert!([-900, -200, 200, 900].iter().all(|&power| solved(2.0_f64.powi(power)) == one));
    }

    #[test]
    fn what_cannot_be_solved_is_left_as_it_is() {
        let mut matrix = square(10, 1e-3, |_| 1.0);
        let mut solver = Iterative::of(&matrix.columns, &matrix.rows);
        matrix.values[0] = -1.0;
        assert!(!solver.take(&matrix.values));
        let mut x = right(10);
        assert!(solver.solve(&mut x, 1e-3, &[]).is_none() && x == right(10));
        matrix.values[0] = f64::NAN;
        assert!(!solver.take(&matrix.values) && solver.solve(&mut x, 1e-3, &[]).is_none());
    }
}
