//! Whether equations depend on each other, where elimination does not tell.
//!
//! A pivot of A = G M⁻¹Gᵀ that should be zero is what rounding leaves of it: in a long structure more than the square
//! of a sine that still carries digits. What tells is the combination of normals that should be zero. Its first guess
//! is what the factors make of the row with the weakest pivot, and each repetition leaves of everything else in z what
//! the factors are off by:
//!
//! ```text
//! LU z = eₖ        z ← z − (LU)⁻¹ A z        |M^(−½) Gᵀz| < ε m Σ |zᵢ| |M^(−½) ∇gᵢ|
//! ```
//!
//! No combination of independent normals is as short, whatever z is, so that none is refused by chance.

use crate::number::vector::{add_scaled, dot};
use crate::systems::network::mass::Root;
use crate::systems::network::rows::Rows;
use crate::systems::network::solver::Solver;

/// Combinations that are tried: from 1e-7 of the normals the second or third is rounding.
const TRIES: usize = 6;

/// The row that has most part in a combination of these normals, last taken over, that is zero but for rounding, and
/// the sine of its angle to the others; none where none is found. Row `k` has the weakest pivot. Allocates.
#[cold]
pub(crate) fn dependence<const D: usize>(
    solver: &mut Solver<D>,
    rows: &Rows,
    blocks: &[[f64; D]],
    roots: &[Root<D>],
    k: usize,
) -> Option<(f64, usize)> {
    let m = rows.equations();
    let halve = |body: usize, u: &[f64; D]| roots[rows.bodies[body]].halve(u);
    let square = |u: [f64; D]| dot(&u, &u);
    let length = |row: usize| {
        rows.blocks_of(row).map(|(block, body)| square(halve(body, &blocks[block]))).sum::<f64>().sqrt()
    };
    let lengths: Vec<f64> = (0..m).map(length).collect();
    let (mut z, mut rates, mut change) = (vec![0.0; m], vec![0.0; m], vec![0.0; m]);
    rates[k] = lengths[k];
    solver.solve(&rates, &mut z);
    for _ in 0..TRIES {
        let mut sums = vec![[0.0; D]; rows.bodies.len()];
        for (row, z) in z.iter().enumerate() {
            for (block, body) in rows.blocks_of(row) {
                sums[body] = add_scaled(&sums[body], *z, &blocks[block]);
            }
        }
        let left = sums.iter().enumerate().map(|(body, sum)| square(halve(body, sum))).sum::<f64>().sqrt();
        let parts = || z.iter().zip(&lengths).map(|(z, length)| z.abs() * length);
        if left < f64::EPSILON * m as f64 * parts().sum::<f64>() {
            let (row, most) = parts().enumerate().fold((k, 0.0), |a, b| if b.1 > a.1 { b } else { a });
            return Some((left / most, row));
        }
        for (row, rate) in rates.iter_mut().enumerate() {
            let along = |(block, body): (usize, usize)| {
                dot(&blocks[block], &roots[rows.bodies[body]].velocity(&sums[body]))
            };
            *rate = rows.blocks_of(row).map(along).sum();
        }
        solver.solve(&rates, &mut change);
        z.iter_mut().zip(&change).for_each(|(z, change)| *z -= change);
    }
    None
}
