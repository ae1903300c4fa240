//! Algebraic multigrid by aggregation, its cycles sped up by a Krylov method (Notay 2010, 2012: AGMG).
//!
//! ```text
//! smooth      (D + L) z = r                    Gauss and Seidel, first vertex first
//! coarse      A′ e = Pᵀ(r − A z),  A′ = Pᵀ A P        P: one for the vertices of an aggregate; two steps of GCR
//! smooth      (D + U) z′ = r − L (z + P e)     last vertex first
//! ```
//!
//! The Krylov method is our own: a cycle has steps of GCR inside and so is no linear map, which faer's BiCGStab asks of
//! a preconditioner; GCR asks for none, and takes one cycle a step, not two. On the matrices of the dam break BiCGStab
//! with a cycle took 1.5 times as long (1 100 vertices), 1.7 (4 200) and 13 (17 000, where it failed at times), and
//! with the diagonal, which never failed, 2.0, 2.5 and 3.8 times as long, growing with the mesh.
//!
//! Pairs are of vertices coupled most, and an aggregate is a pair of pairs of pairs. Aggregates are kept while they
//! serve, and dry land has some too: left out, as Notay does with rows that the diagonal rules, it would ask for new
//! aggregates wherever it gets wet.

use crate::pieces::{PIECE, dot, dot_of_piece, each, subtract, sums};
use crate::rows::Rows;

/// A matrix, the way to the next smaller one, and room for the iteration.
pub(crate) struct Level {
    pub(crate) matrix: Rows,
    /// The coarse vertex of each vertex, and the place of each entry there.
    aggregates: Vec<u32>,
    places: Vec<u32>,
    /// The right side, made what is left of it; and the solution.
    pub(crate) left: Vec<f64>,
    pub(crate) solution: Vec<f64>,
    /// Directions d, and A d made orthonormal.
    directions: Vec<[Vec<f64>; 2]>,
    /// A d by these, one row for each direction, and what is taken of each.
    parts: Vec<Vec<f64>>,
    weights: Vec<f64>,
}

const NONE: u32 = u32::MAX;
/// Vertices are paired if they are coupled by so much of what couples the one or the other with any.
const STRONG: f64 = 0.25;
/// Aggregates are pairs of pairs of pairs: a tenth less time than with pairs of pairs.
const PAIRINGS: usize = 3;
/// Steps of GCR on coarse levels, and where what is left ends them sooner. With 0.5 a step of the dam break on 67 000
/// vertices took 22 iterations in the place of 18, and an eighth longer.
const STEPS: usize = 2;
const ENOUGH: f64 = 0.25;
/// So few vertices are solved by as many steps.
const FEW: usize = 8;
/// So many directions are kept at most.
pub(crate) const KEPT: usize = 12;
/// So many numbers of a vector at a time.
const SLICE: usize = 1024;

impl Level {
    pub(crate) fn of(matrix: Rows, directions: usize) -> Self {
        let room = || vec![0.0; matrix.size()];
        Level {
            aggregates: Vec::new(),
            places: Vec::new(),
            left: room(),
            solution: room(),
            directions: (0..directions).map(|_| [room(), room()]).collect(),
            parts: vec![vec![0.0; directions]; directions],
            weights: vec![0.0; directions],
            matrix,
        }
    }
}

/// Makes the coarse levels of the first one anew.
pub(crate) fn coarsen(levels: &mut Vec<Level>) {
    levels.truncate(1);
    while let Some(fine) = levels.last_mut() {
        let size = fine.matrix.size();
        if size <= FEW {
            return;
        }
        let across = fine.matrix.across();
        let largest =
            |i| couplings(&fine.matrix, &across, i).map(|(_, coupling)| coupling).fold(0.0, f64::max);
        let heaviest: Vec<f64> = (0..size).map(largest).collect();
        let (mut aggregates, mut heaviest) = paired(&fine.matrix, &heaviest);
        for _ in 1..PAIRINGS {
            let (pairs, _) = collapsed(&fine.matrix, &aggregates, heaviest.len());
            let (of_pairs, of_their_members) = paired(&pairs, &heaviest);
            aggregates.iter_mut().for_each(|i| *i = of_pairs[*i as usize]);
            heaviest = of_their_members;
        }
        let count = heaviest.len();
        if 4 * count > 3 * size {
            return;
        }
        let (coarse, places) = collapsed(&fine.matrix, &aggregates, count);
        (fine.aggregates, fine.places) = (aggregates, places);
        levels.push(Level::of(coarse, if count <= FEW { FEW } else { STEPS }));
    }
}

/// Brings the numbers of the first level to the others; false where a diagonal is not positive.
pub(crate) fn refresh(levels: &mut [Level]) -> bool {
    for i in 1..levels.len() {
        let (fine, coarse) = levels.split_at_mut(i);
        let (fine, coarse) = (&fine[i - 1], &mut coarse[0].matrix);
        coarse.values.fill(0.0);
        add_up(&fine.matrix.values, &fine.places, &mut coarse.values);
    }
    levels.iter_mut().all(|level| level.matrix.invert())
}

fn add_up(fine: &[f64], places: &[u32], coarse: &mut [f64]) {
    fine.iter().zip(places).for_each(|(value, &place)| coarse[place as usize] += value);
}

/// The pair of each vertex, and the largest coupling of each pair's members, given the largest one of each vertex. A
/// vertex that finds no other joins a pair, or stays alone.
///
/// A coupling is strong or weak in comparison with the smaller of the two vertices' largest ones. So two lakes that a
/// thin film joins do not become a pair, though coarse levels have no other neighbours left: neither the smoother nor a
/// coarser level could tell the one from the other.
fn paired(matrix: &Rows, heaviest: &[f64]) -> (Vec<u32>, Vec<f64>) {
    let across = matrix.across();
    let mut pairs = vec![NONE; matrix.size()];
    let mut of_pairs: Vec<f64> = Vec::new();
    let mut single = Vec::new();
    for i in 0..matrix.size() {
        if pairs[i] != NONE {
            continue;
        }
        let free = |j: usize| (pairs[j] == NONE).then_some(heaviest[j]);
        match nearest(matrix, &across, i, heaviest[i], free) {
            Some(j) => {
                (pairs[i], pairs[j]) = (of_pairs.len() as u32, of_pairs.len() as u32);
                of_pairs.push(heaviest[i].max(heaviest[j]));
            }
            None => single.push(i),
        }
    }
    for i in single {
        let joined = |j: usize| of_pairs.get(pairs[j] as usize).copied();
        match nearest(matrix, &across, i, heaviest[i], joined) {
            Some(j) => {
                pairs[i] = pairs[j];
                let heaviest_there = &mut of_pairs[pairs[j] as usize];
                *heaviest_there = heaviest_there.max(heaviest[i]);
            }
            None => {
                pairs[i] = of_pairs.len() as u32;
                of_pairs.push(heaviest[i]);
            }
        }
    }
    (pairs, of_pairs)
}

/// Who, of those that `heaviest` tells the largest coupling of, is coupled most and enough with a vertex whose own is
/// `own`.
fn nearest(
    matrix: &Rows,
    across: &[u32],
    i: usize,
    own: f64,
    heaviest: impl Fn(usize) -> Option<f64>,
) -> Option<usize> {
    let enough =
        |&(j, coupling): &(usize, f64)| heaviest(j).is_some_and(|other| coupling >= STRONG * own.min(other));
    let most = couplings(matrix, across, i).filter(enough).max_by(|a, b| a.1.total_cmp(&b.1));
    most.map(|(j, _)| j)
}

/// The neighbours of a vertex, and how much it is coupled with each: −aᵢⱼ − aⱼᵢ.
fn couplings<'a>(matrix: &'a Rows, across: &'a [u32], i: usize) -> impl Iterator<Item = (usize, f64)> + 'a {
    let beside = matrix.row(i).filter(move |&place| place != matrix.diagonals[i] as usize);
    beside.map(|place| {
        (matrix.columns[place] as usize, -matrix.values[place] - matrix.values[across[place] as usize])
    })
}

/// Pᵀ A P, and where each entry goes.
fn collapsed(fine: &Rows, aggregates: &[u32], count: usize) -> (Rows, Vec<u32>) {
    let mut ends = vec![0; count + 1];
    aggregates.iter().for_each(|&i| ends[i as usize + 1] += 1);
    (0..count).for_each(|i| ends[i + 1] += ends[i]);
    let mut members = vec![0; aggregates.len()];
    let mut next = ends.clone();
    for (i, &aggregate) in aggregates.iter().enumerate() {
        members[next[aggregate as usize]] = i;
        next[aggregate as usize] += 1;
    }
    let (mut starts, mut columns) = (vec![0], Vec::new());
    let mut places = vec![0; fine.columns.len()];
    let mut seen = vec![NONE; count];
    for aggregate in 0..count {
        let start = columns.len();
        let members = &members[ends[aggregate]..ends[aggregate + 1]];
        let entries = || members.iter().flat_map(|&i| fine.row(i));
        for place in entries() {
            let column = aggregates[fine.columns[place] as usize];
            if seen[column as usize] != aggregate as u32 {
                seen[column as usize] = aggregate as u32;
                columns.push(column);
            }
        }
        columns[start..].sort_unstable();
        for place in entries() {
            let column = aggregates[fine.columns[place] as usize];
            places[place] = (start + columns[start..].partition_point(|&other| other < column)) as u32;
        }
        starts.push(columns.len() as u32);
    }
    let mut coarse = Rows::of(starts, columns);
    add_up(&fine.values, &places, &mut coarse.values);
    (coarse, places)
}

/// Solves A x = b, b in `left`, until |b − A x| ≤ `tolerance` |b|, by the method of generalised conjugate residuals
/// (Eisenstat, Elman, Schultz 1983), preconditioned by a cycle. Returns how many steps it took; none if `most` were not
/// enough, with what they have reached.
pub(crate) fn solve(levels: &mut [Level], tolerance: f64, most: usize) -> Option<usize> {
    let (own, coarse) = levels.split_first_mut()?;
    own.solution.fill(0.0);
    let mut left = dot(&own.left, &own.left);
    let enough = tolerance * tolerance * left;
    let mut steps = 0;
    while left > enough && steps < most {
        let kept = own.directions.len().min(most - steps);
        let mut used = 0;
        while left > enough && used < kept {
            let (before, rest) = own.directions.split_at_mut(used);
            let [direction, image] = &mut rest[0];
            cycle(&own.matrix, &own.aggregates, &own.left, coarse, direction, image);
            let parts = &mut own.parts[used];
            orthogonalise(before, image, parts);
            let size = dot(image, image).sqrt();
            if !(size > 0.0 && size.is_finite()) {
                return None;
            }
            each(PIECE, image, |_, x| x.iter_mut().for_each(|x| *x /= size));
            parts[used] = size;
            own.weights[used] = dot(image, &own.left);
            subtract(own.weights[used], image, &mut own.left);
            left = dot(&own.left, &own.left);
            used += 1;
        }
        for k in (0..used).rev() {
            let weight = own.weights[k] / own.parts[k][k];
            for j in 0..k {
                own.weights[j] -= own.parts[k][j] * weight;
            }
            subtract(-weight, &own.directions[k][0], &mut own.solution);
        }
        steps += used;
    }
    (left <= enough).then_some(steps)
}

/// Takes from a vector its parts along others, which are orthonormal. Pieces of vectors stay in cache between.
fn orthogonalise(others: &[[Vec<f64>; 2]], image: &mut [f64], parts: &mut [f64]) {
    let x: &[f64] = image;
    let along: [f64; KEPT] = sums(x.len(), |piece| {
        let mut along = [0.0; KEPT];
        for from in piece.clone().step_by(SLICE) {
            let slice = from..piece.end.min(from + SLICE);
            for (along, other) in along.iter_mut().zip(others) {
                *along += dot_of_piece(&x[slice.clone()], &other[1][slice.clone()]);
            }
        }
        along
    });
    parts.copy_from_slice(&along[..parts.len()]);
    each(PIECE, image, |from, x| {
        for (slice, x) in x.chunks_mut(SLICE).enumerate() {
            let from = from + SLICE * slice;
            for (part, other) in along.iter().zip(others) {
                x.iter_mut().zip(&other[1][from..]).for_each(|(x, y)| *x -= part * y);
            }
        }
    });
}

/// z ≈ A⁻¹ r.
fn cycle(
    matrix: &Rows,
    aggregates: &[u32],
    r: &[f64],
    coarse: &mut [Level],
    z: &mut [f64],
    image: &mut [f64],
) {
    matrix.forward(r, z);
    if let Some(next) = coarse.first_mut() {
        matrix.left_forward(z, image);
        next.left.fill(0.0);
        for (left, &aggregate) in image.iter().zip(aggregates) {
            next.left[aggregate as usize] += left;
        }
        let most = next.directions.len();
        solve(coarse, ENOUGH, most);
        let solution = &coarse[0].solution;
        each(PIECE, z, |from, z| {
            z.iter_mut()
                .zip(&aggregates[from..])
                .for_each(|(z, &aggregate)| *z += solution[aggregate as usize]);
        });
    }
    matrix.backward(r, z, image);
}
