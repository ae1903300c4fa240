//! The conservative method: upwinded control volumes on linear triangles, with a slope vector in each triangle that is
//! eliminated.
//!
//! ```text
//! Mᵢ (hᵢ′ − hᵢ)/Δt + Σ fluxes out of i = sources        Mᵢ the area that belongs to a vertex; law.rs has the fluxes
//! ```
//!
//! **Volume**: fluxes cancel in pairs and the storage term is linear, so every full Newton step conserves the volume to
//! rounding. **Sign**: where hᵢ′ < 0 nothing would flow out, so Mᵢ(hᵢ′ − hᵢ)/Δt = inflow ≥ 0, a contradiction. Negative
//! depths that the finished iteration leaves are rounding errors, and are covered by the nearby vertex with the most
//! water. **Rest**: a dry shore above the level of a lake has no water to give and gets none, and a level lake has
//! p = 0, so lakes stay at rest.
//!
//! Infiltration is the smaller of the infiltration capacity and of what comes: an active set of vertices that are dry,
//! h′ = 0, where all that comes seeps away.

use crate::blocks::{Block, L, Wide, block, flux_in, gather, root, slope_of, sloping, unknowns};
use crate::budget::Budget;
use crate::error::FlowError;
use crate::flow::{Flow, Resistance, number, squares};
use crate::krylov::Iterative;
use crate::law::{DarcyWeisbach, Element, Law, Manning};
use crate::method::{Method, StepInfo, Trouble};
use crate::pieces::{PIECE, dot, on_threads};
use crate::sparse::Sparse;
use rattle::real::Real;
use rayon::prelude::*;
use std::array::from_fn;

/// The method of upwinded control volumes: conserves volume to rounding, without negative depths.
pub struct Conservative {
    blocks: Vec<Block>,
    /// p of each block, and as it was before the step.
    slopes: Vec<[Wide; 2]>,
    before: Vec<[Wide; 2]>,
    /// Whether p is that of a depth; from p = 0 a first step would draw water up the shore.
    started: bool,
    matrix: Sparse,
    /// In the place of LU, for large meshes.
    iterative: Option<Iterative>,
    diagonal: Vec<u32>,
    residual: Vec<f64>,
    /// Volume per time that leaves over the boundary, per vertex.
    leaving: Vec<f64>,
    /// By how much more of it leaves with more depth.
    widening: Vec<f64>,
    change: Vec<f64>,
    /// Where all seeps away that comes: now, and when the factors were made, with what stood in these rows.
    dry_now: Vec<usize>,
    dry: Vec<usize>,
    /// The residual as if nothing seeped away.
    unseeped: Vec<f64>,
    dry_entries: Vec<Vec<(usize, f64)>>,
    settings: Settings,
}

/// Factors are used again while each change is at most this part of the one before: an iteration with them costs a
/// fifth. With 0.1 the dam break takes 1.3 factorisations a step, 2.7 without.
const REUSED: f64 = 0.1;

/// Up to here LU factors, used again, take about as long as iterations.
const DIRECT: usize = 500;

/// In the second half of the iterations that are allowed, changes may be so much larger: fluxes go with the root of the
/// slope, so where steps are long lakes at rest are rounded to no more digits.
const LATE: f64 = 1e3;

/// |p| is at most so many times √|∇(b + h)|.
const FARTHEST: f64 = 4.0;

/// Sums are rounded to this many parts of 2⁻⁵². Where this part of the water is lacking, a step has failed.
const ROUNDED: f64 = 64.0;
const ASTRAY: f64 = 1e-6;
/// Depths are changed by less than this part of them.
const MOST_MENDED: f64 = 1e-3;

/// What may be left of linear equations that are solved by iteration: at least this, and at most that where the change
/// is about to be smaller than asked for. With 1e-8 the dam break on 17 000 vertices took 1.7 times as long, and 1e-2
/// took more of Newton's iterations on 500 000.
const INEXACT: [f64; 2] = [1e-3, 1e-1];

/// Settings of the iteration. A flow is not [started](Flow::simulate_by) with `epsilon`, `tolerance` or `most` that are
/// not positive: [`FlowError::Number`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The ε of √(p² + ε²), which replaces |p| in the derivative: 10⁻⁴ to 10⁻⁸ work equally well, 10⁻² does not
    /// converge.
    pub epsilon: f64,
    /// The iteration ends where the remaining error, estimated from the ratio of the last two changes of depth, is
    /// below this fraction of the largest depth, before or after the step; in the second half of the iterations that
    /// are allowed, below 1000 times as much.
    pub tolerance: f64,
    /// The largest number of iterations.
    pub most: usize,
    /// Linear equations of meshes with more vertices than this are solved by iteration instead of LU factors.
    pub direct: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Settings { epsilon: 1e-6, tolerance: 1e-10, most: 30, direct: DIRECT }
    }
}

impl Conservative {
    /// The method for this flow, with default settings.
    pub fn of(flow: &Flow) -> Self {
        Self::with(flow, Settings::default())
    }

    /// The method for this flow with these settings.
    pub fn with(flow: &Flow, settings: Settings) -> Self {
        let mesh = &flow.mesh;
        let n = mesh.points().len();
        let matrix = Sparse::of_groups(n, mesh.triangles().iter().copied());
        let blocks: Vec<Block> =
            (0..mesh.triangles().len()).step_by(L).map(|first| block(flow, &matrix, first)).collect();
        let rest = [Wide::from_f64(0.0); 2];
        Conservative {
            slopes: vec![rest; blocks.len()],
            before: vec![rest; blocks.len()],
            started: false,
            blocks,
            diagonal: (0..n as u32).map(|i| matrix.place(i, i)).collect(),
            iterative: (n > settings.direct).then(|| matrix.iterative()),
            matrix,
            residual: vec![0.0; n],
            leaving: vec![0.0; n],
            widening: vec![0.0; n],
            change: vec![0.0; n],
            dry_now: Vec::new(),
            dry: Vec::new(),
            unseeped: vec![0.0; n],
            dry_entries: Vec::new(),
            settings,
        }
    }

    /// The fluxes out of each vertex and their derivatives, condensed.
    fn assemble<K: Element<Wide>>(&mut self, kernel: &K, depth: &[f64]) {
        self.residual.fill(0.0);
        self.matrix.values.fill(0.0);
        for (block, slope) in self.blocks.iter().zip(&self.slopes) {
            let (out, derivatives) = kernel.condensed(&unknowns(block, depth, slope), &block.given);
            for i in 0..3 {
                for lane in 0..block.count {
                    self.residual[block.vertices[i][lane] as usize] += out[i].0[lane];
                }
                for j in 0..3 {
                    for lane in 0..block.count {
                        self.matrix.values[block.places[i][j][lane] as usize] += derivatives[i][j].0[lane];
                    }
                }
            }
        }
    }

    /// The steps of p that belong to those of depth, taken in part.
    fn recover<K: Element<Wide> + Sync>(&mut self, kernel: &K, depth: &[f64], part: f64) {
        let change = &self.change;
        let recover = |(block, slope): (&Block, &mut [Wide; 2])| {
            let of_block = gather(block, change);
            let step = kernel.recovered(&unknowns(block, depth, slope), &block.given, &of_block);
            let part = Wide::from_f64(part);
            let (now, before) = (from_fn(|i| gather(block, depth)[i] + part * of_block[i]), *slope);
            let next: [Wide; 2] = from_fn(|k| before[k] + part * step[k]);
            // From p near 0 Newton's method leads far too far, to 1/ε, and then halves p in each iteration.
            let most = Wide::from_f64(FARTHEST) * root(sloping(block, &now));
            let size = (next[0] * next[0] + next[1] * next[1]).sqrt();
            let far = most.lt(size);
            *slope = next.map(|p| Wide::select(far, p * (most / size), p));
        };
        if on_threads(depth.len(), PIECE) {
            self.blocks.par_iter().zip(&mut self.slopes).for_each(recover);
        } else {
            self.blocks.iter().zip(&mut self.slopes).for_each(recover);
        }
    }

    /// The same without derivatives.
    fn assemble_residual<K: Element<Wide>>(&mut self, kernel: &K, depth: &[f64]) {
        self.residual.fill(0.0);
        for (block, slope) in self.blocks.iter().zip(&self.slopes) {
            let out = kernel.condensed_residual(&unknowns(block, depth, slope), &block.given);
            for i in 0..3 {
                for lane in 0..block.count {
                    self.residual[block.vertices[i][lane] as usize] += out[i].0[lane];
                }
            }
        }
    }

    /// Sources, sinks and storage in the residual.
    fn add_sources(
        &mut self,
        flow: &Flow,
        depth: &[f64],
        guess: &[f64],
        step: f64,
        (rain, inflow): (&[f64], &[f64]),
    ) {
        let (shares, power) = (flow.mesh.shares(), flow.resistance.power());
        for i in 0..depth.len() {
            let supply = shares[i] * depth[i] / step + rain[i] + inflow[i];
            let leaving =
                if flow.outlet[i] > 0.0 { flow.outlet[i] * guess[i].max(0.0).powf(power) } else { 0.0 };
            let stored = shares[i] * guess[i] / step;
            self.leaving[i] = leaving;
            self.unseeped[i] = self.residual[i] + (stored - supply + leaving);
            self.residual[i] = self.unseeped[i] + flow.infiltration[i];
        }
    }

    /// The derivatives of these, and the factors of all; false where there are none.
    fn factorise(&mut self, flow: &Flow, guess: &[f64], step: f64) -> Result<(), Trouble> {
        let (shares, power) = (flow.mesh.shares(), flow.resistance.power());
        for i in 0..guess.len() {
            let open = flow.outlet[i] > 0.0;
            self.widening[i] =
                if open { power * flow.outlet[i] * guess[i].max(0.0).powf(power - 1.0) } else { 0.0 };
            self.matrix.values[self.diagonal[i] as usize] += shares[i] / step + self.widening[i];
        }
        self.dry.clone_from(&self.dry_now);
        self.dry_rows(shares, step);
        let taken = self.iterative.as_mut().is_some_and(|iterative| iterative.take(&self.matrix.values));
        if taken { Ok(()) } else { self.factors() }
    }

    fn factors(&mut self) -> Result<(), Trouble> {
        self.matrix.factorise().map_err(|vertex| Trouble::Singular { vertex })
    }

    /// Solves for the change: by iteration if so chosen, by LU where that does not end. Returns which part of the
    /// change is not to be relied on.
    fn solve(&mut self, inexact: f64) -> Result<f64, Trouble> {
        if let Some(iterative) = &mut self.iterative {
            if let Some(unsure) = iterative.solve(&mut self.change, inexact, &self.dry) {
                return Ok(unsure);
            }
            self.factors()?;
        }
        self.matrix.solve(&mut self.change);
        Ok(0.0)
    }

    fn iterate<K: Element<Wide> + Sync>(
        &mut self,
        kernel: &K,
        flow: &Flow,
        depth: &[f64],
        guess: &mut [f64],
        step: f64,
        sources: (&[f64], &[f64]),
    ) -> Result<StepInfo, Trouble> {
        let shares = flow.mesh.shares();
        let (mut last, mut last_length) = (f64::INFINITY, f64::INFINITY);
        let mut fresh = true;
        let (deepest, tolerance) = (largest(depth).1, self.settings.tolerance);
        for iteration in 1..=self.settings.most {
            if !fresh {
                self.assemble_residual(kernel, guess);
                self.add_sources(flow, depth, guess, step, sources);
                fresh = self.dry != self.dry_now;
            }
            if fresh {
                self.assemble(kernel, guess);
                self.add_sources(flow, depth, guess, step, sources);
                if iteration == 1 {
                    self.first_dry(flow, guess);
                }
                self.factorise(flow, guess, step)?;
            }
            self.change.iter_mut().zip(&self.residual).for_each(|(change, residual)| *change = -residual);
            for &i in &self.dry {
                self.change[i] = -guess[i] * shares[i] / step;
            }
            // Changes get smaller as the right side does; the last one need not be exact.
            let length = dot(&self.change, &self.change).sqrt();
            let expected = last * (length / last_length);
            let enough = tolerance * deepest.max(largest(guess).1);
            let [least, most] = INEXACT;
            let inexact =
                if expected.is_finite() { (0.1 * enough / expected).clamp(least, most) } else { least };
            let unsure = self.solve(inexact)?;
            last_length = length;
            if let Some(vertex) = self.change.iter().position(|x| !x.is_finite()) {
                return Err(Trouble::Singular { vertex });
            }
            let (_, size) = largest(&self.change);
            // A step that is longer than the one before goes too far: half of it.
            let part = if iteration > 2 && size > last { 0.5 } else { 1.0 };
            self.recover(kernel, guess, part);
            guess.iter_mut().zip(&self.change).for_each(|(depth, change)| *depth += part * change);
            let enough = if 2 * iteration > self.settings.most { LATE } else { 1.0 }
                * tolerance
                * deepest.max(largest(guess).1);
            let rate = if iteration == 1 { 1.0 } else { f64::max(size / last, unsure) };
            self.next_dry(flow, guess);
            let small = size == 0.0 || part == 1.0 && size * rate.min(1.0) <= enough;
            if small && guess.iter().all(|&h| h >= -enough) && self.seeps(flow) {
                self.lend(shares, guess);
                let mut booked = self.book(flow, step, sources);
                if self.settle(shares, depth, guess, step, &mut booked) {
                    return Ok(StepInfo { iterations: iteration, booked });
                }
            }
            fresh = self.iterative.is_some() || iteration > 1 && rate > REUSED;
            last = size;
        }
        let (vertex, change) = largest(&self.change);
        Err(Trouble::NotConverged { iterations: self.settings.most, change, vertex })
    }

    /// What the end of the iteration leaves below zero is taken from the vertex with the most water: nearby if that has
    /// enough, else from the wettest of all, one after the other.
    fn lend(&self, shares: &[f64], depth: &mut [f64]) {
        for i in 0..depth.len() {
            if depth[i] < 0.0 {
                let mut lacking = -depth[i] * shares[i];
                depth[i] = 0.0;
                let volume = |depth: &[f64], j: usize| depth[j] * shares[j];
                let near = self.matrix.column(i).map(|(row, _)| row);
                let near = near.max_by(|&a, &b| volume(depth, a).total_cmp(&volume(depth, b)));
                let mut lender = near.filter(|&j| volume(depth, j) > lacking);
                while lacking > 0.0 {
                    let wettest =
                        || (0..depth.len()).max_by(|&a, &b| volume(depth, a).total_cmp(&volume(depth, b)));
                    let Some(j) = lender.take().or_else(wettest).filter(|&j| depth[j] > 0.0) else { break };
                    let all = volume(depth, j);
                    depth[j] = if all > lacking { (depth[j] - lacking / shares[j]).max(0.0) } else { 0.0 };
                    lacking -= all;
                }
            }
        }
    }

    /// Whether the balance of a step closes. Where much more water flows through than is there, the rounding of fluxes
    /// is more than that of the volume: what is lacking is added, in proportion, to the depths, or to what has left
    /// where hardly any water stays. What rounding does not explain stays, and shows in the budget; where it is much,
    /// the iteration has gone astray.
    fn settle(
        &self,
        shares: &[f64],
        before: &[f64],
        depth: &mut [f64],
        step: f64,
        booked: &mut Budget,
    ) -> bool {
        let came = dot(before, shares) + booked.rain + booked.inflow;
        let (left, now) = (booked.infiltration + booked.outflow, dot(depth, shares));
        let (lacking, rounding) = (came - left - now, ROUNDED * f64::EPSILON);
        if lacking.abs() > rounding * came {
            // About what flows out of vertices: a flux is less than its derivative times the depth.
            let flows = self.diagonal.iter().zip(&*depth).zip(&self.change);
            let flows =
                flows.map(|((&place, h), change)| self.matrix.values[place as usize] * (h + change.abs()));
            let flows = flows.sum::<f64>() + (0..self.dry.len()).map(|k| self.seeping(k)).sum::<f64>();
            let explained = lacking.abs() <= (rounding * step * flows).min(ASTRAY * came);
            if explained && lacking.abs() < MOST_MENDED * now {
                depth.iter_mut().for_each(|h| *h *= 1.0 + lacking / now);
            } else if explained && left > 0.0 {
                let factor = 1.0 + lacking / left;
                booked.unmet += booked.infiltration * (1.0 - factor);
                booked.infiltration *= factor;
                booked.outflow *= factor;
            }
        }
        lacking.abs() <= ASTRAY * came
    }

    /// Where there is no water, and less comes than can seep away.
    fn first_dry(&mut self, flow: &Flow, guess: &[f64]) {
        let dry = |&i: &usize| flow.infiltration[i] > 0.0 && guess[i] <= 0.0 && self.residual[i] > 0.0;
        self.dry_now.clear();
        self.dry_now.extend((0..guess.len()).filter(dry));
    }

    /// The active set: a dry vertex stays dry where less comes than can seep away, and one is dry whose depth is
    /// negative else. (That fluxes take more than there is says nothing: they will be smaller with less depth.)
    fn next_dry(&mut self, flow: &Flow, guess: &[f64]) {
        let mut before = self.dry.iter().enumerate().peekable();
        self.dry_now.clear();
        for (i, capacity) in flow.infiltration.iter().enumerate().filter(|(_, capacity)| **capacity > 0.0) {
            let dry = match before.next_if(|(_, vertex)| **vertex == i) {
                Some((k, _)) => self.seeped(k) < *capacity,
                None => guess[i] < 0.0,
            };
            if dry {
                self.dry_now.push(i);
            }
        }
    }

    /// What seeps away, volume per time, at one of the vertices that are dry: all that comes there.
    fn seeped(&self, k: usize) -> f64 {
        let moved = self.dry_entries[k].iter().map(|&(j, entry)| entry * self.change[j]);
        -self.unseeped[self.dry[k]] - moved.sum::<f64>()
    }

    /// What it is the sum of.
    fn seeping(&self, k: usize) -> f64 {
        let moved = self.dry_entries[k].iter().map(|&(j, entry)| (entry * self.change[j]).abs());
        self.unseeped[self.dry[k]].abs() + moved.sum::<f64>()
    }

    /// Whether at dry vertices no more seeps away than can, and not less than nothing, but for what is asked of changes
    /// and rounding.
    fn seeps(&self, flow: &Flow) -> bool {
        self.dry.iter().enumerate().all(|(k, &i)| {
            let (seeped, capacity) = (self.seeped(k), flow.infiltration[i]);
            let near = self.settings.tolerance * capacity + ROUNDED * f64::EPSILON * self.seeping(k);
            (-near..=capacity + near).contains(&seeped)
        })
    }

    /// What the last change did to the volume. The linear equations moved the water, so the books follow them.
    fn book(&self, flow: &Flow, step: f64, (rain, inflow): (&[f64], &[f64])) -> Budget {
        let mut booked = Budget { rain: sum(rain) * step, inflow: sum(inflow) * step, ..Budget::default() };
        // What seeps away at dry vertices is what comes there; as capacity less what is unmet it would be rounded to a
        // part of the capacity, however little came.
        let (mut seeped, mut dry) = (0.0, self.dry.iter().enumerate().peekable());
        for (i, capacity) in flow.infiltration.iter().enumerate() {
            seeped += dry.next_if(|(_, vertex)| **vertex == i).map_or(*capacity, |(k, _)| self.seeped(k));
        }
        booked.infiltration = step * seeped;
        booked.unmet = step * (sum(&flow.infiltration) - seeped);
        let widened = self.leaving.iter().zip(&self.widening).zip(&self.change);
        booked.outflow =
            step * widened.map(|((leaving, widening), change)| leaving + widening * change).sum::<f64>();
        booked
    }

    /// Makes Mᵢ/Δt δᵢ the left side of the rows that are dry, and keeps what was there.
    fn dry_rows(&mut self, shares: &[f64], step: f64) {
        self.dry_entries.clear();
        for &row in &self.dry {
            // The pattern is symmetric: the columns of a row are the rows of its column.
            let columns: Vec<usize> = self.matrix.column(row).map(|(column, _)| column).collect();
            let mut entries = Vec::with_capacity(columns.len());
            for column in columns {
                let place = self.matrix.place(row as u32, column as u32) as usize;
                entries.push((column, self.matrix.values[place]));
                self.matrix.values[place] = if column == row { shares[row] / step } else { 0.0 };
            }
            self.dry_entries.push(entries);
        }
    }
}

impl Settings {
    /// An error for numbers that no iteration ends with.
    fn check(&self) -> Result<(), FlowError> {
        let expected = "a number from 1e-150 to 1e150; 1e-6 is the default";
        squares("the setting epsilon", self.epsilon, expected)?;
        let positive = self.tolerance > 0.0;
        number("the setting tolerance", self.tolerance, positive, "a positive number; 1e-10 is the default")?;
        number("the setting most", self.most as f64, self.most > 0, "an iteration or more; 30 is the default")
    }
}

fn sum(numbers: &[f64]) -> f64 {
    numbers.iter().sum()
}

fn largest(change: &[f64]) -> (usize, f64) {
    let sizes = change.iter().map(|x| x.abs()).enumerate();
    sizes.fold((0, 0.0), |best, own| if own.1 > best.1 { own } else { best })
}

impl Method for Conservative {
    fn serves(&self, _: &Flow) -> Result<(), FlowError> {
        self.settings.check()
    }

    fn step(
        &mut self,
        flow: &Flow,
        depth: &[f64],
        guess: &mut [f64],
        step: f64,
        sources: (&[f64], &[f64]),
    ) -> Result<StepInfo, Trouble> {
        if !self.started {
            self.slopes = self.blocks.iter().map(|block| slope_of(block, depth)).collect();
            self.started = true;
        }
        self.before.copy_from_slice(&self.slopes);
        let epsilon = self.settings.epsilon;
        let result = match flow.resistance {
            Resistance::DarcyWeisbach { .. } => {
                self.iterate(&DarcyWeisbach::of::<Wide>(epsilon), flow, depth, guess, step, sources)
            }
            Resistance::Manning => {
                self.iterate(&Manning::of::<Wide>(epsilon), flow, depth, guess, step, sources)
            }
        };
        if result.is_err() {
            self.slopes.copy_from_slice(&self.before);
        }
        result
    }

    fn undo(&mut self) {
        self.slopes.copy_from_slice(&self.before);
    }

    fn mean_flux(&self, flow: &Flow, depth: &[f64]) -> f64 {
        let fluxes = self.flux(flow, depth);
        let areas = (0..fluxes.len()).map(|triangle| crate::plane::signed_area(flow.mesh.corners(triangle)));
        let sum: f64 = fluxes.iter().zip(areas).map(|(q, area)| area * q[0].hypot(q[1])).sum();
        sum / flow.mesh.area()
    }

    fn flux(&self, flow: &Flow, depth: &[f64]) -> Vec<[f64; 2]> {
        let triangles = (0..flow.mesh.triangles().len()).map(|triangle| {
            let (block, lane) = (&self.blocks[triangle / L], triangle % L);
            let slope = if self.started { self.slopes[triangle / L] } else { slope_of(block, depth) };
            let given = block.given.map(|number| number.0[lane]);
            flux_in(flow, triangle, &given, depth, slope.map(|p| p.0[lane]))
        });
        triangles.collect()
    }
}
