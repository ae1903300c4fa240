//! A row of components that are alike: what [`few`](crate::systems::linked::few) keeps of one of them, number by number
//! for each lane.
//!
//! [`crate::systems::linked::drift_abreast`] moves it, [`crate::systems::linked::settle_abreast`] makes its momenta
//! tangent. Nothing here knows how many coordinates a body has, so that loops are compiled once.

use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::number::vector::two_sum;
use crate::systems::network::alike::AlikeLinks;
use crate::systems::network::dense::MOST;
use crate::systems::network::few_in_lanes::{Normals, by_coordinate, factor, grid, lifted, of_few, sized};
use crate::systems::network::in_lanes::{Numbers, ROW, Which, at, put, zeros};
use crate::systems::network::solver::CLEARLY;

/// Coordinates of the bodies of a component at most.
const COORDINATES: usize = 3 * MOST;

/// Whether there are rows of so many coordinates for each body: all sizes of `dense` are then compiled in lanes.
pub(super) const fn are_rows(dimension: usize) -> bool {
    dimension == 2 || dimension == 3
}

/// Rows of coordinates.
pub(super) type Coordinates = [Numbers<ROW>; COORDINATES];

/// What is kept of a row from step to step.
#[derive(Clone)]
pub(super) struct KeptRow {
    /// 1 over the masses along all coordinates.
    pub(super) over: Vec<Numbers<ROW>>,
    /// Entries of the gradients.
    pub(super) normals: Vec<Numbers<ROW>>,
    /// G M⁻¹Gᵀ, [factored](factor), row by row.
    pub(super) matrix: Vec<Numbers<ROW>>,
}

/// Numbers of the row under way.
#[derive(Clone)]
#[repr(C, align(64))]
pub(super) struct Lanes {
    pub(super) q: Coordinates,
    pub(super) q_low: Coordinates,
    pub(super) p: Coordinates,
    pub(super) p_low: Coordinates,
    pub(super) force: Coordinates,
    pub(super) velocity: Coordinates,
    pub(super) push: Coordinates,
    pub(super) free: Coordinates,
    pub(super) sizes: Coordinates,
    pub(super) lift: Coordinates,
    pub(super) trial: Coordinates,
    /// How far the bodies of a lane go without the constraints; or the sum of the squares of settled momenta.
    pub(super) path: Numbers<ROW>,
    pub(super) g: [Numbers<ROW>; MOST],
    pub(super) bends: [Numbers<ROW>; MOST],
    pub(super) turns: [Numbers<ROW>; MOST],
    pub(super) scale: [Numbers<ROW>; MOST],
    pub(super) matrix: [[Numbers<ROW>; MOST]; MOST],
    pub(super) gradients: [Numbers<ROW>; MOST * COORDINATES],
    /// The multipliers, times what [`few`](crate::systems::linked::few) multiplies them by.
    pub(super) x: [Numbers<ROW>; MOST],
    /// The residuals of the guess, as lengths; and in roundings.
    pub(super) off: [Numbers<ROW>; MOST],
    pub(super) roundings: [Numbers<ROW>; MOST],
    pub(super) going: Which<ROW>,
    /// Whether nothing speaks against a lane's root.
    pub(super) plain: Which<ROW>,
    /// Whether its new normals are clearly independent.
    pub(super) clear: Which<ROW>,
    pub(super) corrections: Which<ROW>,
}

impl Lanes {
    /// Zeros.
    pub(super) fn new() -> Box<Self> {
        let (all, some, none) = ([zeros(); COORDINATES], [zeros(); MOST], [0; ROW]);
        Box::new(Self {
            q: all,
            q_low: all,
            p: all,
            p_low: all,
            force: all,
            velocity: all,
            push: all,
            free: all,
            sizes: all,
            lift: all,
            trial: all,
            path: zeros(),
            g: some,
            bends: some,
            turns: some,
            scale: some,
            matrix: [some; MOST],
            gradients: [zeros(); MOST * COORDINATES],
            x: some,
            off: some,
            roundings: some,
            going: none,
            plain: none,
            clear: none,
            corrections: none,
        })
    }
}

/// A row, and what moves it.
pub(super) struct RowUnderWay<'a> {
    pub(super) sizes: (usize, usize),
    pub(super) links: &'a AlikeLinks,
    pub(super) set: Fusing,
    pub(super) kept: &'a mut KeptRow,
    pub(super) lanes: &'a mut Lanes,
}

impl KeptRow {
    /// Of so many equations and coordinates, and these masses.
    pub(super) fn new((equations, coordinates): (usize, usize), entries: usize) -> Self {
        Self {
            over: vec![zeros(); coordinates],
            normals: vec![zeros(); entries],
            matrix: vec![zeros(); equations * equations],
        }
    }
}

impl RowUnderWay<'_> {
    /// Evaluates the normals where bodies are.
    pub(super) fn evaluate(&mut self) {
        macro_rules! run {
            ($m:expr, $k:expr) => {
                self.set.run(Evaluate::<$m, $k> { row: self })
            };
        }
        sized!(self.sizes, run, ());
    }
}

/// Where the entries of gradients are, by equation and coordinate.
#[inline(always)]
pub(super) fn places<const M: usize, const K: usize>(links: &AlikeLinks) -> [[Option<usize>; K]; M] {
    let mut places = [[None; K]; M];
    for (number, &[row, coordinate]) in links.entries.iter().enumerate() {
        places[row][coordinate] = Some(number);
    }
    places
}

#[inline(always)]
pub(super) fn square<const M: usize>(rows: &[Numbers<ROW>]) -> &[[Numbers<ROW>; M]; M] {
    rows.as_chunks().0.first_chunk().expect("as many as there are")
}

#[inline(always)]
pub(super) fn square_mut<const M: usize>(rows: &mut [Numbers<ROW>]) -> &mut [[Numbers<ROW>; M]; M] {
    rows.as_chunks_mut().0.first_chunk_mut().expect("as many as there are")
}

struct Evaluate<'a, 'b, const M: usize, const K: usize> {
    row: &'a mut RowUnderWay<'b>,
}

impl<const M: usize, const K: usize> Work for Evaluate<'_, '_, M, K> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let RowUnderWay { links, set, kept, lanes, .. } = self.row;
        let (places, zero) = (places::<M, K>(links), zeros());
        let KeptRow { over, normals, matrix } = &mut **kept;
        links.gradients(*set, &lanes.q[..K], &mut lanes.g, normals);
        let normals = by_coordinate(&places, normals, &zero);
        let over = of_few::<K, ROW>(over);
        factor_rows::<true, M, K>(&normals, &normals, over, square_mut::<M>(matrix), &mut lanes.clear);
    }
}

/// Factors G′M⁻¹Gᵀ. Lanes in which its pivots are positive; or, with `CLEAR`, normals clearly independent.
#[inline(always)]
pub(super) fn factor_rows<const CLEAR: bool, const M: usize, const K: usize>(
    normals: &Normals<M, K, ROW>,
    of: &Normals<M, K, ROW>,
    over: &[Numbers<ROW>; K],
    matrix: &mut [[Numbers<ROW>; M]; M],
    clear: &mut Which<ROW>,
) {
    const LEAST: f64 = CLEARLY * CLEARLY;
    for l in 0..ROW {
        let (factored, slopes) = factor(&grid(normals, l), &lifted(of, &at(over, l), l));
        let mut is_clear = true;
        for i in 0..M {
            is_clear &= Fused(0.0).lt(factored[i][i]);
            if CLEAR {
                is_clear &= (Fused(LEAST) * slopes[i] * factored[i][i]).lt(Fused(1.0));
            }
            put(&mut matrix[i], l, factored[i]);
        }
        clear[l] = if is_clear { 1 } else { 0 };
    }
}

/// Adds to numbers of these lanes what they change by, their low digits with it.
#[inline(always)]
pub(super) fn add_up<const K: usize>(
    which: &Which<ROW>,
    change: &[Numbers<ROW>; K],
    high: &mut [Numbers<ROW>; K],
    low: &mut [Numbers<ROW>; K],
) {
    for k in 0..K {
        for l in 0..ROW {
            let ([sum], [rest]) = two_sum(&[high[k].0[l]], &[change[k].0[l]]);
            high[k].0[l] = Real::select(which[l] != 0, sum, high[k].0[l]);
            low[k].0[l] = Real::select(which[l] != 0, rest, low[k].0[l]);
        }
    }
}
