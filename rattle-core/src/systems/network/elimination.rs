//! Elimination for many equations: G M⁻¹Gᵀ is factored by rows on a sparsity pattern that is found once.
//!
//! The pattern is symmetric; the matrix need not be, since the position equation has normals at two positions. Pivots
//! are taken on the diagonal, which is safe as long as normals turn by less than a right angle; a pivot that is not
//! positive shows that they turned further. The order is one of minimum degree: chains and trees have no fill-in, so
//! the cost of a step is proportional to the number of equations. Displacements of bodies with many equations are
//! unknowns too ([`super::hubs`]).

use crate::number::vector::{add_scaled, dot};
use crate::systems::network::algebra::LinearAlgebra;
use crate::systems::network::chain::{Chain, Factored};
use crate::systems::network::factor::{Factor, TOGETHER};
use crate::systems::network::hubs::Hubs;
use crate::systems::network::late::Late;
use crate::systems::network::mass::Root;
use crate::systems::network::pattern::Pattern;
use crate::systems::network::rows::{Blocks, Rows};
#[cfg(feature = "faer")]
use crate::systems::network::supernodal::Supernodal;
use std::array::from_fn;
use std::mem::take;

/// With hubs: an equation whose square of the sine to those before is smaller, without what hubs can do for it, is
/// solved for after all others. By more digits than that a pivot must not be smaller than what it was formed of.
const LATE: f64 = 1e-4;

/// Where the square of a sine is smaller, elimination loses more than twelve bits of Λ, and six of displacements. Who
/// asks for Λ then finds these by further rounds.
pub(crate) const LOSSY: f64 = 1.0 / 4096.0;

#[derive(Debug, Clone)]
pub(crate) struct Elimination<const D: usize> {
    pattern: Pattern,
    /// In place of the factors.
    chain: Option<Chain>,
    chain_at_start: Factored,
    chain_at_trial: Factored,
    equations: usize,
    hubs: Hubs,
    /// Rows that touch a body, with the block.
    touching: Vec<(usize, usize)>,
    touching_start: Vec<usize>,
    /// The same where no body touches more than two, with a block of zeros past all others for a second one that is
    /// not.
    pairs: Option<Vec<[(usize, usize); 2]>>,
    /// For each block 1/m along each coordinate, 0 where pinned; none where a mass is a matrix.
    over_masses: Option<Vec<[f64; D]>>,
    /// Normals where the step starts, and M⁻¹ times them.
    normals: Vec<[f64; D]>,
    lifted: Vec<[f64; D]>,
    at_start: Factor,
    at_trial: Factor,
    /// Whether the matrix that Λ was last asked of is [so near to a singular one](LOSSY) that Λ loses digits.
    lossy: bool,
    /// The least square of a sine of equations of hubs, as found before a run.
    of_hubs: f64,
    late_at_start: Late,
    late_at_trial: Late,
    /// In place of the factor at the start.
    #[cfg(feature = "faer")]
    supernodal: Option<Box<Supernodal>>,
    permuted: Vec<f64>,
}

impl<const D: usize> Elimination<D> {
    pub(crate) fn new(rows: &Rows, roots: &[Root<D>]) -> Self {
        let m = rows.equations();
        let mut of_body: Vec<Vec<(usize, usize)>> = vec![Vec::new(); rows.bodies.len()];
        for row in 0..m {
            for (block, body) in rows.blocks_of(row) {
                of_body[body].push((row, block));
            }
        }
        let rows_of_body: Vec<Vec<usize>> =
            of_body.iter().map(|touching| touching.iter().map(|&(row, _)| row).collect()).collect();
        let split = Hubs::split(&rows_of_body, m, D);
        let (hubs, pattern) = split.unwrap_or_else(|| (Hubs::default(), Pattern::new(&rows_of_body, m)));
        let unknowns = pattern.order.len();
        let late = if unknowns > m { Late::new(unknowns, unknowns - m) } else { Late::default() };
        let mut touching_start = vec![0];
        let mut touching = Vec::new();
        for list in of_body {
            touching.extend(list);
            touching_start.push(touching.len());
        }
        let of = |body: usize| &touching[touching_start[body]..touching_start[body + 1]];
        let chain = if hubs.bodies.is_empty() { Chain::new(&pattern, rows, of) } else { None };
        let factor = if chain.is_some() { Factor::default() } else { Factor::new(&pattern) };
        let factored = chain.as_ref().map_or_else(Factored::default, |_| Factored::new(m));
        let blocks = vec![[0.0; D]; rows.blocks() + 1];
        let over_masses = rows.touched().iter().map(|&body| roots[body].over_masses()).collect();
        let pair = |body: usize| match *of(body) {
            [one] => Some([one, (one.0, rows.blocks())]),
            [one, two] => Some([one, two]),
            _ => None,
        };
        let pairs = (0..rows.bodies.len()).map(pair).collect();
        Self {
            pattern,
            chain,
            chain_at_start: factored.clone(),
            chain_at_trial: factored,
            equations: m,
            hubs,
            touching,
            touching_start,
            pairs,
            over_masses,
            normals: blocks.clone(),
            lifted: blocks,
            at_start: factor.clone(),
            at_trial: factor,
            lossy: false,
            of_hubs: f64::INFINITY,
            late_at_start: late.clone(),
            late_at_trial: late,
            #[cfg(feature = "faer")]
            supernodal: None,
            permuted: vec![0.0; unknowns],
        }
    }

    /// The same with a supernodal factor where the step starts, if it pays.
    #[cfg(feature = "faer")]
    pub(crate) fn supernodal(rows: &Rows, roots: &[Root<D>]) -> Self {
        let mut elimination = Self::new(rows, roots);
        if !elimination.hubs.bodies.is_empty() {
            return elimination; // its matrix is not symmetric
        }
        let Self { pattern, touching, touching_start, .. } = &elimination;
        let columns = |k: usize| {
            let bodies = rows.blocks_of(pattern.order[k]).map(|(_, body)| body);
            let rows = bodies.flat_map(|body| &touching[touching_start[body]..touching_start[body + 1]]);
            let mut columns: Vec<_> =
                rows.map(|&(row, _)| pattern.rank_of[row]).filter(|&rank| rank <= k).collect();
            columns.sort_unstable();
            columns.dedup();
            columns
        };
        elimination.supernodal = Supernodal::new(pattern, columns).map(Box::new);
        if elimination.supernodal.is_some() {
            elimination.at_start = Factor::default();
        }
        elimination
    }

    /// How the momentum equation is solved.
    pub(crate) fn by(&self) -> LinearAlgebra {
        #[cfg(feature = "faer")]
        if self.supernodal.is_some() {
            return LinearAlgebra::Supernodal;
        }
        LinearAlgebra::Elimination
    }

    /// Entries of the factor below the diagonal that were not in the matrix.
    pub(crate) fn fill(&self) -> usize {
        self.pattern.lower.len() - self.pattern.entries
    }

    /// Takes the normals over. Returns the sine of the angle of the least independent one to those before, and its row.
    pub(crate) fn normals(&mut self, rows: &Rows, blocks: &[[f64; D]], roots: &[Root<D>]) -> (f64, usize) {
        let (square, row) = self.take_over(rows, blocks, roots);
        self.note_least(square);
        (square.max(0.0).sqrt(), row)
    }

    /// Notes the least square of a sine of the matrix that Λ is asked of from now on.
    pub(crate) fn note_least(&mut self, square: f64) {
        self.lossy = square.min(self.of_hubs) < LOSSY;
    }

    pub(crate) fn is_lossy(&self) -> bool {
        self.lossy
    }

    /// The same of the normals just taken over for the equations of hubs, whose pivots are formed of less than their
    /// entries. Allocates.
    pub(crate) fn judge_hubs(&mut self, rows: &Rows, roots: &[Root<D>]) -> (f64, usize) {
        self.of_hubs = f64::INFINITY;
        let mut weakest = (f64::INFINITY, 0);
        if !self.hubs.bodies.is_empty() {
            let matrix = WithHubs::<'_, D, false> { elimination: self, rows, blocks: &self.normals, roots };
            weakest = matrix.weakest_of_hubs();
            self.of_hubs = weakest.0;
            self.lossy |= self.of_hubs < LOSSY;
        }
        (weakest.0.max(0.0).sqrt(), weakest.1)
    }

    /// Takes the normals over. Returns the square of the sine.
    fn take_over(&mut self, rows: &Rows, blocks: &[[f64; D]], roots: &[Root<D>]) -> (f64, usize) {
        if let Some(over_masses) = &self.over_masses {
            for ((lifted, block), over) in self.lifted.iter_mut().zip(blocks).zip(over_masses) {
                *lifted = from_fn(|i| over[i] * block[i]);
            }
        } else {
            for ((lifted, block), &body) in self.lifted.iter_mut().zip(blocks).zip(rows.touched()) {
                *lifted = roots[body].velocity(block); // 0 where pinned
            }
        }
        self.normals[..blocks.len()].copy_from_slice(blocks);
        #[cfg(feature = "faer")]
        if let Some(mut supernodal) = self.supernodal.take() {
            let (square, k) = self.factor_supernodal(rows, &mut supernodal);
            self.supernodal = Some(supernodal);
            return (square, self.pattern.order[k]);
        }
        if let Some(chain) = &self.chain {
            let Self { normals, lifted, chain_at_start: factored, .. } = self;
            return if rows.width() == 2 {
                chain.factor::<false, 2, D>(rows, factored, normals, lifted, true)
            } else {
                chain.factor::<false, 0, D>(rows, factored, normals, lifted, true)
            };
        }
        let (mut factor, mut late) = (take(&mut self.at_start), take(&mut self.late_at_start));
        let found = self.factor::<false>(rows, blocks, roots, (&mut factor, &mut late), true);
        (self.at_start, self.late_at_start) = (factor, late);
        found
    }

    /// Factors (normals)(lifted)ᵀ, of which it forms the entries up to the diagonal.
    #[cfg(feature = "faer")]
    fn factor_supernodal(&mut self, rows: &Rows, supernodal: &mut Supernodal) -> (f64, usize) {
        let Self { pattern, touching, touching_start, normals, lifted, permuted: line, .. } = self;
        line.fill(0.0);
        for k in 0..pattern.order.len() {
            for (block, body) in rows.blocks_of(pattern.order[k]) {
                for &(row, other) in &touching[touching_start[body]..touching_start[body + 1]] {
                    if pattern.rank_of[row] <= k {
                        line[pattern.rank_of[row]] += dot(&normals[block], &lifted[other]);
                    }
                }
            }
            for at in supernodal.start[k]..supernodal.start[k + 1] {
                supernodal.entries[at] = take(&mut line[supernodal.columns[at]]);
            }
        }
        supernodal.factor()
    }

    /// Makes room for as many late equations as the last normals had; whether there was too little. Allocates.
    pub(crate) fn make_room(&mut self) -> bool {
        let Some(late) = self.late_at_start.grown() else { return false };
        (self.late_at_start, self.late_at_trial) = (late.clone(), late);
        true
    }

    /// Takes the derivative of g along the start's normals at a trial position, or its symmetric part; the smallest
    /// pivot, relative to its entry.
    pub(crate) fn chord<const SYMMETRIC: bool>(
        &mut self,
        rows: &Rows,
        blocks: &[[f64; D]],
        roots: &[Root<D>],
    ) -> f64 {
        if let Some(chain) = &self.chain {
            let Self { lifted, chain_at_trial: factored, .. } = self;
            return if rows.width() == 2 {
                chain.factor::<SYMMETRIC, 2, D>(rows, factored, blocks, lifted, false).0
            } else {
                chain.factor::<SYMMETRIC, 0, D>(rows, factored, blocks, lifted, false).0
            };
        }
        let (mut factor, mut late) = (take(&mut self.at_trial), take(&mut self.late_at_trial));
        let (smallest, _) = self.factor::<SYMMETRIC>(rows, blocks, roots, (&mut factor, &mut late), false);
        (self.at_trial, self.late_at_trial) = (factor, late);
        smallest
    }

    /// Factors (blocks)(lifted)ᵀ, or its symmetric part. Returns the smallest ratio of a pivot to its diagonal entry,
    /// and the row.
    fn factor<const SYMMETRIC: bool>(
        &self,
        rows: &Rows,
        blocks: &[[f64; D]],
        roots: &[Root<D>],
        (factor, late): (&mut Factor, &mut Late),
        at_start: bool,
    ) -> (f64, usize) {
        let wide = self.pattern.widest >= TOGETHER;
        if !self.hubs.bodies.is_empty() {
            let matrix = WithHubs::<'_, D, SYMMETRIC> { elimination: self, rows, blocks, roots };
            return if wide {
                matrix.factor::<true>(factor, late, at_start)
            } else {
                matrix.factor::<false>(factor, late, at_start)
            };
        }
        let (square, k) = if wide {
            self.factor_rows::<SYMMETRIC, true>(rows, blocks, factor, at_start)
        } else {
            self.factor_rows::<SYMMETRIC, false>(rows, blocks, factor, at_start)
        };
        (square, self.pattern.order[k])
    }

    fn factor_rows<const SYMMETRIC: bool, const WIDE: bool>(
        &self,
        rows: &Rows,
        blocks: &[[f64; D]],
        factor: &mut Factor,
        at_start: bool,
    ) -> (f64, usize) {
        let Self { pattern, touching, touching_start, lifted, .. } = self;
        let mut weakest = (f64::INFINITY, 0);
        for k in 0..pattern.order.len() {
            for (block, body) in rows.blocks_of(pattern.order[k]) {
                for &(row, other) in &touching[touching_start[body]..touching_start[body + 1]] {
                    let entry = dot(&blocks[block], &lifted[other]);
                    let mirrored = if SYMMETRIC { dot(&blocks[other], &lifted[block]) } else { entry };
                    let entry = if SYMMETRIC { 0.5 * (entry + mirrored) } else { entry };
                    factor.line[pattern.rank_of[row]] += entry;
                }
            }
            let entry = factor.line[k];
            let ratio = factor.eliminate::<WIDE>(pattern, k) / entry;
            let ratio = if at_start { ratio } else { ratio * entry.signum() };
            if ratio < weakest.0 || ratio.is_nan() {
                weakest = (ratio, k);
            }
        }
        weakest
    }

    /// Λ such that G moves at these rates when the bodies move by M⁻¹GᵀΛ.
    pub(crate) fn solve(&mut self, rates: &[f64], x: &mut [f64]) {
        #[cfg(feature = "faer")]
        if let Some(supernodal) = &mut self.supernodal {
            return supernodal.solve(&self.pattern, rates, x, &mut self.permuted);
        }
        let Self { pattern, at_start, late_at_start, permuted, .. } = self;
        if let Some(chain) = &self.chain {
            return chain.solve(&self.chain_at_start, 1.0, rates, x, permuted);
        }
        if self.hubs.bodies.is_empty() {
            at_start.solve(pattern, 1.0, rates, x, permuted);
        } else {
            late_at_start.solve(pattern, at_start, rates, x, permuted);
        }
    }

    /// The sign of the determinant of that derivative; no number where a pivot is none.
    pub(crate) fn orientation(&self) -> f64 {
        let sign = |pivot: f64| if pivot.is_finite() { pivot.signum() } else { f64::NAN };
        if self.chain.is_some() {
            return self.chain_at_trial.overs().map(sign).product();
        }
        self.at_trial.inverse.iter().copied().chain(self.late_at_trial.pivots()).map(sign).product()
    }

    /// Newton's correction for residuals g, with the derivative of [`Self::chord`].
    pub(crate) fn correct(&mut self, g: &[f64], dx: &mut [f64]) {
        let Self { pattern, at_trial, late_at_trial, permuted, .. } = self;
        if let Some(chain) = &self.chain {
            return chain.solve(&self.chain_at_trial, -1.0, g, dx, permuted);
        }
        if self.hubs.bodies.is_empty() {
            at_trial.solve(pattern, -1.0, g, dx, permuted);
        } else {
            late_at_trial.solve(pattern, at_trial, g, dx, permuted);
            dx.iter_mut().for_each(|x| *x = -*x);
        }
    }

    /// Calls `add` with each body's number in the scene, and its blocks.
    #[inline(always)]
    fn combine(
        &self,
        rows: &Rows,
        blocks: &[[f64; D]],
        x: &[f64],
        mut add: impl FnMut(usize, Blocks<'_, D>),
    ) {
        if let Some(pairs) = &self.pairs {
            for (&body, own) in rows.bodies.iter().zip(pairs) {
                add(body, Blocks { own, blocks, x });
            }
            return;
        }
        for (&body, range) in rows.bodies.iter().zip(self.touching_start.windows(2)) {
            add(body, Blocks { own: &self.touching[range[0]..range[1]], blocks, x });
        }
    }

    /// Adds M⁻¹GᵀΛ to each body's place.
    pub(crate) fn displace(&self, rows: &Rows, x: &[f64], out: &mut [[f64; D]]) {
        self.combine(rows, &self.lifted, x, |body, blocks| out[body] = blocks.add_to(out[body], 1.0));
    }

    /// Calls `see` with M⁻¹GᵀΛ of each body, by its number in the scene.
    #[inline(always)]
    pub(crate) fn displacements(&self, rows: &Rows, x: &[f64], mut see: impl FnMut(usize, [f64; D])) {
        if let Some(line) = &rows.line {
            let mut bodies = line.bodies(x.len());
            return line
                .combine(&self.lifted, x, |way| bodies.next().into_iter().for_each(|body| see(body, way)));
        }
        self.combine(rows, &self.lifted, x, |body, blocks| see(body, blocks.add_to([0.0; D], 1.0)));
    }

    /// Calls `see` with M⁻¹GᵀΛ of each body, by its number in the scene, and GᵀΛ/h. `impulses` is room for as many
    /// numbers as x has.
    #[inline(always)]
    pub(crate) fn moves(
        &self,
        rows: &Rows,
        h: f64,
        x: &[f64],
        impulses: &mut [f64],
        mut see: impl FnMut(usize, &[f64; D], &[f64; D]),
    ) {
        impulses.iter_mut().zip(x).for_each(|(impulse, x)| *impulse = x / h);
        self.combine(rows, &self.lifted, x, |body, lifted| {
            let normals = Blocks { blocks: &self.normals, x: impulses, ..lifted };
            see(body, &lifted.add_to([0.0; D], 1.0), &normals.add_to([0.0; D], 1.0));
        });
    }

    /// The normals where the step starts, and M⁻¹ times them.
    pub(crate) fn at_start(&self) -> [&[[f64; D]]; 2] {
        [&self.normals, &self.lifted]
    }

    /// Calls `see` with `scale` GᵀΛ of each body, by its number in the scene.
    #[inline(always)]
    pub(crate) fn pushes(&self, rows: &Rows, scale: f64, x: &[f64], mut see: impl FnMut(usize, [f64; D])) {
        self.combine(rows, &self.normals, x, |body, blocks| see(body, blocks.add_to([0.0; D], scale)));
    }

    /// Adds `scale` GᵀΛ to each body's momentum.
    pub(crate) fn push(&self, rows: &Rows, scale: f64, x: &[f64], out: &mut [[f64; D]]) {
        self.combine(rows, &self.normals, x, |body, blocks| out[body] = blocks.add_to(out[body], scale));
    }
}

/// (blocks)(lifted)ᵀ, or its symmetric part, with displacements of hubs as unknowns.
struct WithHubs<'a, const D: usize, const SYMMETRIC: bool> {
    elimination: &'a Elimination<D>,
    rows: &'a Rows,
    blocks: &'a [[f64; D]],
    roots: &'a [Root<D>],
}

impl<const D: usize, const SYMMETRIC: bool> WithHubs<'_, D, SYMMETRIC> {
    fn touching(&self, body: usize) -> &[(usize, usize)] {
        let Elimination { touching, touching_start, .. } = self.elimination;
        &touching[touching_start[body]..touching_start[body + 1]]
    }

    fn halve(&self, body: usize, block: &[f64; D]) -> [f64; D] {
        self.roots[self.rows.bodies[body]].halve(block)
    }

    /// The entries of an equation's row along a hub's coordinates, or without the sign of the hub's rows along the
    /// equation.
    fn along_hub<const COLUMN: bool>(&self, block: usize, body: usize) -> [f64; D] {
        let (there, here) = (&self.blocks[block], &self.elimination.normals[block]);
        if SYMMETRIC {
            self.halve(body, &from_fn(|i| 0.5 * (there[i] + here[i])))
        } else {
            self.halve(body, if COLUMN { here } else { there })
        }
    }

    /// Calls `add` with the unknown and the entry of each place in an equation's row, or column.
    #[inline(always)]
    fn entries<const COLUMN: bool>(&self, row: usize, mut add: impl FnMut(usize, f64)) {
        let Elimination { hubs, equations, lifted, .. } = self.elimination;
        for (block, body) in self.rows.blocks_of(row) {
            if let Some(hub) = hubs.of(body) {
                let sign = if COLUMN { -1.0 } else { 1.0 };
                for (d, entry) in self.along_hub::<COLUMN>(block, body).into_iter().enumerate() {
                    add(equations + hub * D + d, sign * entry);
                }
                continue;
            }
            for &(other_row, other) in self.touching(body) {
                let (mut entry, mirrored) =
                    (dot(&self.blocks[block], &lifted[other]), dot(&self.blocks[other], &lifted[block]));
                if SYMMETRIC {
                    entry = 0.5 * (entry + mirrored);
                } else if COLUMN {
                    entry = mirrored;
                }
                add(other_row, entry);
            }
        }
    }

    /// The same for the row of one of a hub's coordinates. Returns an equation of the hub.
    #[inline(always)]
    fn entries_of_hub(&self, unknown: usize, mut add: impl FnMut(usize, f64)) -> usize {
        let Elimination { hubs, equations, .. } = self.elimination;
        let (hub, d) = ((unknown - equations) / D, (unknown - equations) % D);
        add(unknown, 1.0);
        let touching = self.touching(hubs.bodies[hub]);
        for &(row, block) in touching {
            add(row, -self.along_hub::<true>(block, hubs.bodies[hub])[d]);
        }
        touching[0].0
    }

    /// The diagonal entry that an equation would have if no body were a hub.
    #[inline(always)]
    fn diagonal(&self, row: usize) -> f64 {
        let lifted = &self.elimination.lifted;
        self.rows.blocks_of(row).map(|(block, _)| dot(&self.blocks[block], &lifted[block])).sum()
    }

    /// The least square of the sine of an equation to those before, and its row: what is left of its diagonal entry,
    /// its pivot and what its hubs can still do for it, of the whole.
    #[cold]
    #[inline(never)]
    fn weakest_of_hubs(&self) -> (f64, usize) {
        let Elimination { hubs, pattern, equations, at_start, late_at_start, .. } = self.elimination;
        let identity: [[f64; D]; D] = from_fn(|i| from_fn(|j| if i == j { 1.0 } else { 0.0 }));
        let mut free = vec![identity; hubs.bodies.len()]; // what hubs can do, the equations before held
        let mut of_hubs: Vec<(usize, [f64; D])> = Vec::new();
        let mut weakest = (f64::INFINITY, 0);
        for (k, &row) in pattern.order.iter().enumerate() {
            if row >= *equations || late_at_start.rows().contains(&row) {
                continue;
            }
            let (pivot, entries) = at_start.row(pattern, k);
            of_hubs.clear();
            for (column, entry) in entries {
                let Some(coordinate) = pattern.order[column].checked_sub(*equations) else { continue };
                let (hub, d) = (coordinate / D, coordinate % D);
                if of_hubs.iter().all(|&(other, _)| other != hub) {
                    of_hubs.push((hub, [0.0; D]));
                }
                of_hubs.iter_mut().filter(|of| of.0 == hub).for_each(|(_, along)| along[d] = entry);
            }
            let way = |free: &[[f64; D]; D], along| free.map(|line| dot(&line, along));
            let by_hubs = of_hubs.iter().map(|(hub, along)| dot(along, &way(&free[*hub], along)).max(0.0));
            let left = pivot + by_hubs.sum::<f64>();
            for (hub, along) in &of_hubs {
                let way = way(&free[*hub], along);
                free[*hub] = from_fn(|i| add_scaled(&free[*hub][i], -way[i] / left, &way));
            }
            let square = left / self.diagonal(row);
            if square < weakest.0 || square.is_nan() {
                weakest = (square, row);
            }
        }
        weakest
    }

    /// Returns the smallest ratio of a pivot to its diagonal entry, and its row.
    fn factor<const WIDE: bool>(&self, factor: &mut Factor, late: &mut Late, at_start: bool) -> (f64, usize) {
        let Elimination { pattern, equations, .. } = self.elimination;
        let mut weakest = (f64::INFINITY, 0);
        let mut note = |row: usize, pivot: f64, entry: f64| {
            let ratio = if at_start { pivot / entry } else { pivot / entry.abs() };
            if ratio < weakest.0 || ratio.is_nan() {
                weakest = (ratio, row);
            }
        };
        late.clear();
        for k in 0..pattern.order.len() {
            let unknown = pattern.order[k];
            let mut add = |other: usize, entry: f64| factor.line[pattern.rank_of[other]] += entry;
            if unknown >= *equations {
                let row = self.entries_of_hub(unknown, add);
                note(row, factor.eliminate::<WIDE>(pattern, k), 1.0);
                continue;
            }
            self.entries::<false>(unknown, &mut add);
            // Between hubs alone there is nothing but what hubs are worth that were eliminated before.
            let entry = if factor.line[k] == 0.0 { self.diagonal(unknown) } else { factor.line[k] };
            let pivot = factor.eliminate::<WIDE>(pattern, k);
            if pivot.abs() < LATE * entry.abs() && late.take(unknown) {
                factor.leave_out(pattern, k);
            } else {
                note(unknown, pivot, entry);
            }
        }
        if !late.rows().is_empty() {
            let line = |row: usize, out: &mut [f64]| self.entries::<false>(row, |at, entry| out[at] += entry);
            let column =
                |row: usize, out: &mut [f64]| self.entries::<true>(row, |at, entry| out[at] += entry);
            late.factor(pattern, factor, line, column, |row, pivot| note(row, pivot, self.diagonal(row)));
        }
        weakest
    }
}
