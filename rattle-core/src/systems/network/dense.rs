//! Elimination for few equations between few bodies: sizes known when this is compiled, and no loops and lists left.
//!
//! What [`super::elimination`] does on a pattern, without one: G M⁻¹Gᵀ is formed in full and inverted. The equations
//! are evaluated at places of the component's own bodies, side by side, and past them those that are pinned.

use crate::number::vector::{add_scaled, dot, scaled};
use crate::systems::network::group::LinkGroup;
use crate::systems::network::mass::Root;
use crate::systems::network::places::{Evaluated, PLACES, Places};
use crate::systems::network::rows::Rows;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::sync::Arc;

/// So many equations and bodies at most.
pub(crate) const MOST: usize = 3;

/// A number of each equation.
pub(crate) type Column<const M: usize> = [f64; M];
/// A matrix in the corner of this one.
pub(crate) type Square = [[f64; MOST]; MOST];
/// A vector of each equation and body.
pub(crate) type Grid<const M: usize, const N: usize, const D: usize> = [[[f64; D]; N]; M];

/// Does work for the sizes of a component, if they are among those that are compiled.
macro_rules! sized {
    ($sizes:expr, $m:ident, $n:ident, $work:expr, $otherwise:expr) => {
        match $sizes {
            (1, 1) => $crate::systems::network::dense::of_sizes!(1, 1, $m, $n, $work),
            (1, 2) => $crate::systems::network::dense::of_sizes!(1, 2, $m, $n, $work),
            (2, 2) => $crate::systems::network::dense::of_sizes!(2, 2, $m, $n, $work),
            (3, 3) => $crate::systems::network::dense::of_sizes!(3, 3, $m, $n, $work),
            _ => $otherwise,
        }
    };
}
macro_rules! of_sizes {
    ($equations:expr, $bodies:expr, $m:ident, $n:ident, $work:expr) => {{
        const $m: usize = $equations;
        const $n: usize = $bodies;
        const _: [usize; 2] = [$m, $n]; // not all work needs both
        $work
    }};
}
pub(crate) use {of_sizes, sized};

/// Whether they are.
pub(crate) fn sizes_are_compiled(equations: usize, bodies: usize) -> bool {
    sized!((equations, bodies), M, N, M + N > 0, false)
}

/// Members of a group, and their first row.
#[derive(Debug, Clone)]
struct Run<const D: usize> {
    group: Arc<dyn LinkGroup<D>>,
    row: usize,
}

#[derive(Debug, Clone)]
pub(crate) struct Dense<const D: usize> {
    equations: usize,
    bodies: usize,
    runs: Vec<Run<D>>,
    /// Places in use.
    used: usize,
    /// The row of each block, and the place of its body.
    blocks: Vec<(usize, usize)>,
    /// 1/m along each coordinate of each body.
    pub(crate) over_masses: [[f64; D]; MOST],
    /// 1 where an equation has a block of a body, or 0.
    pub(crate) touches: [[f64; MOST]; MOST],
    /// The largest coordinate of what is pinned, by row.
    pub(crate) pinned: Column<MOST>,
    /// Where equations are evaluated, along which velocities, and what they are there.
    pub(crate) places: Places<D>,
    pub(crate) velocities: Places<D>,
    pub(crate) trial: [Evaluated<D>; MOST],
    /// Where the step starts, of which the gradients are the normals.
    pub(crate) start: [Evaluated<D>; MOST],
    /// (G M⁻¹Gᵀ)⁻¹ there, and with G at the trial.
    pub(crate) at_start: Square,
    at_trial: Square,
}

impl<const D: usize> Dense<D> {
    /// None for other sizes, or if a mass is a matrix, or constraints move or act on chosen coordinates.
    pub(crate) fn new(
        rows: &Rows,
        roots: &[Root<D>],
        groups: &[Arc<dyn LinkGroup<D>>],
        pins: &BTreeMap<usize, [f64; D]>,
    ) -> Option<Self> {
        let (equations, bodies) = (rows.equations(), rows.bodies.len());
        let mut of = rows.bodies.clone();
        for &body in rows.touched() {
            if !of.contains(&body) {
                of.push(body);
            }
        }
        let fits = sizes_are_compiled(equations, bodies) && of.len() <= PLACES;
        if !fits || rows.acting || rows.moving {
            return None;
        }
        let mut over_masses = [[0.0; D]; MOST];
        for (over, &body) in over_masses.iter_mut().zip(&rows.bodies) {
            *over = roots[body].over_masses()?;
        }
        let mut places = [[0.0; D]; PLACES];
        for (place, body) in places.iter_mut().zip(&of).skip(bodies) {
            *place = *pins.get(body)?;
        }
        let number = |body: usize| of.iter().position(|&other| other == body).unwrap_or(0);
        let (mut blocks, mut touches, mut pinned) = (Vec::new(), [[0.0; MOST]; MOST], [0.0; MOST]);
        for row in 0..equations {
            for (_, body) in rows.touched_by(row) {
                let place = number(body);
                blocks.push((row, place));
                if place < bodies {
                    touches[row][place] = 1.0;
                } else {
                    pinned[row] = places[place].iter().fold(pinned[row], |most, x| f64::max(most, x.abs()));
                }
            }
        }
        let among = |members, group: usize| groups[group].among(members, &number);
        let runs =
            rows.runs.iter().map(|run| Run { group: among(run.members.clone(), run.group), row: run.row });
        let (row, zero) =
            (Evaluated { value: 0.0, turn: 0.0, blocks: [[0.0; D]; PLACES] }, [[0.0; MOST]; MOST]);
        Some(Self {
            equations,
            bodies,
            used: of.len(),
            runs: runs.collect(),
            blocks,
            over_masses,
            touches,
            pinned,
            places,
            velocities: [[0.0; D]; PLACES],
            trial: [row; MOST],
            start: [row; MOST],
            at_start: zero,
            at_trial: zero,
        })
    }

    /// Equations and bodies.
    #[inline(always)]
    pub(crate) fn sizes(&self) -> (usize, usize) {
        (self.equations, self.bodies)
    }

    /// Writes d²g/dt² along the velocities, and |∇²g v|².
    #[inline(always)]
    pub(crate) fn bends(&mut self, time: f64) {
        for run in &self.runs {
            run.group.bends_of_rows(time, &self.places, &self.velocities, &mut self.trial[run.row..]);
        }
    }

    /// Writes g.
    #[inline(always)]
    pub(crate) fn values(&mut self, time: f64) {
        for run in &self.runs {
            run.group.values_of_rows(time, &self.places, &mut self.trial[run.row..]);
        }
    }

    /// Writes g and its gradients, of the trial or where the next step starts.
    #[inline(always)]
    pub(crate) fn gradients<const START: bool>(&mut self, time: f64) {
        let rows = if START { &mut self.start } else { &mut self.trial };
        for run in &self.runs {
            run.group.gradients_of_rows(time, &self.places, &mut rows[run.row..]);
        }
    }

    /// Hands the normals on, block by block.
    #[inline(always)]
    pub(crate) fn write_blocks(&self, blocks: &mut [[f64; D]]) {
        for (block, &(row, place)) in blocks.iter_mut().zip(&self.blocks) {
            *block = self.start[row].blocks[place];
        }
    }

    fn read_blocks<const START: bool>(&mut self, blocks: &[[f64; D]]) {
        let rows = if START { &mut self.start } else { &mut self.trial };
        for (block, &(row, place)) in blocks.iter().zip(&self.blocks) {
            rows[row].blocks[place] = *block;
        }
    }

    /// M⁻¹ times the normals.
    #[inline(always)]
    pub(crate) fn lifted<const M: usize, const N: usize>(&self) -> Grid<M, N, D> {
        let mut lifted = [[[0.0; D]; N]; M];
        for i in 0..M {
            for b in 0..N {
                for d in 0..D {
                    lifted[i][b][d] = self.over_masses[b][d] * self.start[i].blocks[b][d];
                }
            }
        }
        lifted
    }

    /// Σ xᵢ ∇gᵢ of a body, where the step starts.
    #[inline(always)]
    pub(crate) fn pull<const M: usize>(&self, x: &Column<M>, body: usize) -> [f64; D] {
        let mut sum = scaled(x[0], &self.start[0].blocks[body]);
        for i in 1..M {
            sum = add_scaled(&sum, x[i], &self.start[i].blocks[body]);
        }
        sum
    }

    /// |∇gᵢ|² at the trial.
    #[inline(always)]
    pub(crate) fn square<const N: usize>(&self, row: usize) -> f64 {
        let blocks = &self.trial[row].blocks;
        let mut sum = dot(&blocks[0], &blocks[0]);
        for block in &blocks[1..N] {
            sum += dot(block, block);
        }
        for block in &blocks[N..self.used] {
            sum += dot(block, block);
        }
        sum
    }

    /// Σ|nᵢqᵢ| over the coordinates of what is pinned, at the trial.
    #[inline(always)]
    pub(crate) fn along_pins<const N: usize>(&self, row: usize) -> f64 {
        let mut along = 0.0;
        for (normal, place) in self.trial[row].blocks[N..self.used].iter().zip(&self.places[N..self.used]) {
            for d in 0..D {
                along += (normal[d] * place[d]).abs();
            }
        }
        along
    }

    /// Inverts G M⁻¹Gᵀ where the step starts. Returns its pivots, and its diagonal.
    #[inline(always)]
    pub(crate) fn take<const M: usize, const N: usize>(&mut self) -> [Column<M>; 2] {
        let matrix = products(&self.start, &self.lifted::<M, N>());
        let pivots = invert::<M>(&matrix, &mut self.at_start);
        let mut diagonal = [0.0; M];
        for i in 0..M {
            diagonal[i] = matrix[i][i];
        }
        [pivots, diagonal]
    }

    /// Takes the normals over. Returns the sine of the angle of the least independent one to those before, and its row.
    pub(crate) fn normals(&mut self, blocks: &[[f64; D]]) -> (f64, usize) {
        self.read_blocks::<true>(blocks);
        sized!(self.sizes(), M, N, sine(self.take::<M, N>()), (f64::NAN, 0))
    }

    /// Takes the derivative of g along the start's normals at a trial position, or its symmetric part; the smallest
    /// pivot.
    pub(crate) fn chord<const SYMMETRIC: bool>(&mut self, blocks: &[[f64; D]]) -> f64 {
        self.read_blocks::<false>(blocks);
        sized!(self.sizes(), M, N, self.chord_in::<SYMMETRIC, M, N>(), f64::NAN)
    }

    fn chord_in<const SYMMETRIC: bool, const M: usize, const N: usize>(&mut self) -> f64 {
        let mut matrix = products(&self.trial, &self.lifted::<M, N>());
        if SYMMETRIC {
            for i in 0..M {
                for j in 0..i {
                    let mean = 0.5 * (matrix[i][j] + matrix[j][i]);
                    (matrix[i][j], matrix[j][i]) = (mean, mean);
                }
            }
        }
        let pivots = invert::<M>(&matrix, &mut self.at_trial);
        pivots.iter().fold(f64::INFINITY, |least, &pivot| if pivot >= least { least } else { pivot })
    }

    /// Newton's correction for residuals g, with the derivative of [`Self::chord`].
    pub(crate) fn correct(&self, g: &[f64], dx: &mut [f64]) {
        sized!(self.sizes(), M, N, multiply::<M>(&self.at_trial, -1.0, g, dx), ());
    }

    /// Λ such that G moves at these rates when the bodies move by M⁻¹GᵀΛ.
    pub(crate) fn solve(&self, rates: &[f64], x: &mut [f64]) {
        sized!(self.sizes(), M, N, multiply::<M>(&self.at_start, 1.0, rates, x), ());
    }

    /// Calls `see` with M⁻¹GᵀΛ of each body, by its number in the scene.
    pub(crate) fn displacements(&self, rows: &Rows, x: &[f64], mut see: impl FnMut(usize, [f64; D])) {
        for (b, &body) in rows.bodies.iter().enumerate() {
            see(body, self.displacement(x, b));
        }
    }

    /// Calls `see` with `scale` GᵀΛ of each body, by its number in the scene.
    pub(crate) fn pushes(&self, rows: &Rows, scale: f64, x: &[f64], mut see: impl FnMut(usize, [f64; D])) {
        for (b, &body) in rows.bodies.iter().enumerate() {
            see(body, self.combine(scale, x, b));
        }
    }

    /// Calls `see` with M⁻¹GᵀΛ of each body, by its number in the scene, and GᵀΛ/h. `impulses` is room for as many
    /// numbers as x has.
    pub(crate) fn moves(
        &self,
        rows: &Rows,
        h: f64,
        x: &[f64],
        impulses: &mut [f64],
        mut see: impl FnMut(usize, &[f64; D], &[f64; D]),
    ) {
        impulses.iter_mut().zip(x).for_each(|(impulse, x)| *impulse = x / h);
        for (b, &body) in rows.bodies.iter().enumerate() {
            see(body, &self.displacement(x, b), &self.combine(1.0, impulses, b));
        }
    }

    fn displacement(&self, x: &[f64], body: usize) -> [f64; D] {
        let (mut way, over) = (self.combine(1.0, x, body), &self.over_masses[body]);
        way.iter_mut().zip(over).for_each(|(way, over)| *way *= over);
        way
    }

    fn combine(&self, scale: f64, x: &[f64], body: usize) -> [f64; D] {
        let rows = x.iter().zip(&self.start);
        rows.fold([0.0; D], |sum, (x, row)| add_scaled(&sum, scale * x, &row.blocks[body]))
    }
}

/// The sine of the least independent normal, from the pivots and the diagonal, and its row.
fn sine<const M: usize>([pivots, diagonal]: [Column<M>; 2]) -> (f64, usize) {
    let mut weakest = (f64::INFINITY, 0);
    for i in 0..M {
        let ratio = pivots[i] / diagonal[i];
        let ratio = if ratio.is_finite() { ratio } else { f64::NAN };
        if ratio < weakest.0 || ratio.is_nan() {
            weakest = (ratio, i);
        }
    }
    (weakest.0.max(0.0).sqrt(), weakest.1)
}

fn multiply<const M: usize>(matrix: &Square, sign: f64, column: &[f64], to: &mut [f64]) {
    if let Ok(column) = column.try_into() {
        to.copy_from_slice(&times::<M>(matrix, column).map(|number| sign * number));
    }
}

/// Products of two entries, fourth powers of gradients, that lose no digits and do not overflow, nor do differences of
/// them.
const PRODUCTS: RangeInclusive<f64> = 1e-290..=1e290;

/// Writes the inverse of a matrix by columns, by elimination in the order of its rows. Returns its pivots.
#[inline(always)]
pub(crate) fn invert<const M: usize>(matrix: &[[f64; M]; M], inverse: &mut Square) -> Column<M> {
    let (mut a, mut pivots) = (*matrix, [0.0; M]);
    let product = if M == 2 { a[0][0] * a[1][1] } else { 0.0 };
    if M == 2 && PRODUCTS.contains(&product) {
        // One division in place of two, one of which waits for the other.
        let minor = product - a[0][1] * a[1][0];
        let over = 1.0 / minor;
        (inverse[0][0], inverse[1][1]) = (a[1][1] * over, a[0][0] * over);
        (inverse[1][0], inverse[0][1]) = (-(a[0][1] * over), -(a[1][0] * over));
        (pivots[0], pivots[1]) = (a[0][0], minor / a[0][0]);
        return pivots;
    }
    for k in 0..M {
        pivots[k] = a[k][k];
        let over = 1.0 / a[k][k];
        a[k][k] = 1.0;
        for j in 0..M {
            a[k][j] *= over;
        }
        for i in 0..M {
            if i != k {
                let factor = a[i][k];
                a[i][k] = 0.0;
                for j in 0..M {
                    a[i][j] -= factor * a[k][j];
                }
            }
        }
    }
    for i in 0..M {
        for j in 0..M {
            inverse[j][i] = a[i][j];
        }
    }
    pivots
}

/// An inverse times a column.
#[inline(always)]
pub(crate) fn times<const M: usize>(inverse: &Square, column: &Column<M>) -> Column<M> {
    let mut product = [0.0; M];
    for i in 0..M {
        product[i] = inverse[0][i] * column[0];
    }
    for j in 1..M {
        for i in 0..M {
            product[i] += inverse[j][i] * column[j];
        }
    }
    product
}

/// The gradients of these rows times a grid.
#[inline(always)]
pub(crate) fn products<const M: usize, const N: usize, const D: usize>(
    rows: &[Evaluated<D>; MOST],
    grid: &Grid<M, N, D>,
) -> [[f64; M]; M] {
    let mut matrix = [[0.0; M]; M];
    for i in 0..M {
        for j in 0..M {
            matrix[i][j] = dot(&rows[i].blocks[0], &grid[j][0]);
            for b in 1..N {
                matrix[i][j] += dot(&rows[i].blocks[b], &grid[j][b]);
            }
        }
    }
    matrix
}

/// Σ xᵢ times what a grid has of equation i and a body.
#[inline(always)]
pub(crate) fn combined<const M: usize, const N: usize, const D: usize>(
    grid: &Grid<M, N, D>,
    x: &Column<M>,
    body: usize,
) -> [f64; D] {
    let mut sum = scaled(x[0], &grid[0][body]);
    for i in 1..M {
        sum = add_scaled(&sum, x[i], &grid[i][body]);
    }
    sum
}
