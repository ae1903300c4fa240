//! Inner steps of linked bodies in lanes by the power series of [`Taylor`]: as in
//! [a simulation](crate::systems::linked) order by order, with λ of each order from one solve by the factors at the
//! start.
//!
//! ```text
//! k M vₖ = u² fₖ₋₁ + Σⱼ λⱼ₋₁ nₖ₋ⱼ,   Σⱼ nⱼ·vₖ₋ⱼ = 0,   qₖ₊₁ = vₖ/(k + 1)
//! ```
//!
//! u is the unit of time. A few lanes at a time, whatever the width of the row: the products of all orders stay in the
//! nearer cache, and lanes that have arrived are left out where all of a few have.

use crate::kernel::series::{Products, blocks, unit_near};
use crate::methods::taylor::{ROUNDINGS_OF_SERIES, Taylor};
use crate::motion::method::Method;
use crate::number::instructions::Work;
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::run::ensemble::linked_plan::{LinkedPlan, Places, add_product};
use crate::run::ensemble::linked_row::{Course, add_times};
use crate::run::ensemble::linked_series_law::SeriesLaws;
use crate::run::ensemble::linked_stand::{Departs, Pulls, Stand};
use crate::run::ensemble::pace::MOVES;
use crate::run::ensemble::series_in_lanes::PullingInSeries;
use crate::run::ensemble::taylor_row::{Expansion, Summed, few_of, last_terms, measure, sum_up};
use crate::systems::network::in_lanes::{FEW, Number, Numbers, zeros};

/// The series of a few lanes.
pub(super) struct Few<'a> {
    laws: &'a SeriesLaws,
    unit: f64,
    pulling: Option<Box<dyn PullingInSeries + 'a>>,
    /// Products of each kind of links; and of −λ with n and of n with v, entry by entry.
    of_links: Vec<Products<Numbers<FEW>>>,
    own: Products<Numbers<FEW>>,
    /// Numbers of the plan, and 1 over the masses.
    numbers: Vec<Numbers<FEW>>,
    over: Vec<Numbers<FEW>>,
    /// q₀ of all coordinates in turn, q₁ of all, ….
    series: Vec<Numbers<FEW>>,
    /// Of the order under way: n, entry by entry, f, and k M vₖ as far as it is known.
    normals: Vec<Numbers<FEW>>,
    forces: Vec<Numbers<FEW>>,
    pull: Vec<Numbers<FEW>>,
}

impl<'a> Few<'a> {
    /// Of what obeys these laws.
    pub(super) fn new(method: &Taylor, laws: &'a SeriesLaws, plan: &LinkedPlan) -> Self {
        let (n, entries, orders) = (plan.coordinates, plan.of_entry.len(), method.coefficients());
        Self {
            laws,
            unit: unit_near(method.step_size()),
            pulling: laws.pulls.as_ref().map(|pulls| pulls.begin(orders)),
            of_links: laws.kinds.iter().map(|(_, blocks)| Products::new(*blocks, orders)).collect(),
            own: Products::new(blocks(2 * entries), orders),
            numbers: vec![zeros(); plan.places.end],
            over: vec![zeros(); n],
            series: vec![zeros(); n * orders],
            normals: vec![zeros(); entries],
            forces: vec![zeros(); n],
            pull: vec![zeros(); n],
        }
    }
}

impl<const W: usize> Departs<W> for Expansion<Few<'_>, W> {
    fn depart(&mut self, stand: &mut Stand<'_, W>, pulling: &mut Pulls<'_, '_, W>) {
        stand.course.set.run(Depart { expansion: self, stand, pulling });
    }

    fn compare(&mut self, stand: &mut Stand<'_, W>) {
        if let Some(tolerance) = self.method.tolerance() {
            stand.course.set.run(Compare { summed: &self.end, stand, tolerance });
        }
    }
}

struct Depart<'a, 'b, 'c, 'd, 'e, const W: usize> {
    expansion: &'a mut Expansion<Few<'b>, W>,
    stand: &'a mut Stand<'c, W>,
    pulling: &'a mut Pulls<'d, 'e, W>,
}

impl<const W: usize> Work for Depart<'_, '_, '_, '_, '_, W> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { expansion: Expansion { method, few, end, inside }, stand, pulling } = self;
        let plan = stand.course.plan;
        let Places { q, way, .. } = plan.places;
        for first in (0..W).step_by(FEW) {
            if !stand.pace.going[first..first + FEW].contains(&MOVES) {
                continue;
            }
            few.gather(stand, first);
            few.expand(&stand.course, first / FEW);
            let series = (&few.series[..], few.forces.len(), few.unit);
            let inner = measure(method, series, &mut stand.pace, first);
            few.sum(&inner, first, end);
            for summed in &mut *inside {
                few.sum(&inner, first, summed);
            }
        }
        // A force that the series knows nothing of may be met on the way.
        for (summed, tolerance) in inside.iter().zip(method.tolerance().into_iter().cycle()) {
            for &c in &plan.moving {
                for (number, (track, changes)) in stand.tracks.iter().zip(&summed.changes).enumerate() {
                    stand.numbers[[q, way][number] + c] = track.now[c] + changes[c];
                }
            }
            stand.respond(true, pulling);
            compare(summed, stand, tolerance);
        }
        let [ways, changes] = &end.changes;
        for &c in &plan.moving {
            stand.arrive(c, [&ways[c], &changes[c]]);
        }
    }
}

impl Few<'_> {
    /// Takes over where these lanes are, from this one on.
    #[inline(always)]
    fn gather<const W: usize>(&mut self, stand: &Stand<'_, W>, first: usize) {
        let Course { plan, over, .. } = stand.course;
        let (Places { q, gradient, .. }, n) = (plan.places, plan.coordinates);
        for c in 0..n {
            few_of(&stand.tracks[0].now[c], first, &mut self.series[c]);
            few_of(&stand.tracks[1].now[c], first, &mut self.series[n + c]);
            scale(Fused(self.unit), &mut self.series[n + c]);
            self.numbers[q + c] = self.series[c];
            match over {
                Some(over) => few_of(&over[c], first, &mut self.over[c]),
                None => self.over[c].0 = [Fused(plan.masses[c][1]); FEW],
            }
        }
        for (entry, normal) in stand.normals.iter().enumerate() {
            few_of(normal, first, &mut self.numbers[gradient + entry]);
        }
    }

    /// Writes q₂, q₃, … of the few lanes of this number, from q₀ and q₁ and the normals there.
    #[inline(always)]
    fn expand<const W: usize>(&mut self, &Course { plan, set, .. }: &Course<'_, W>, few: usize) {
        let Self { laws, unit, pulling, of_links, own, numbers, over, series, normals, forces, pull } = self;
        let square = Fused(*unit * *unit);
        let Places { g, change, x, .. } = plan.places;
        let (n, entries) = (plan.coordinates, plan.of_entry.len());
        let last = (series.len() / n.max(1)).saturating_sub(1); // 0 without bodies
        plan.lift(Some(over), numbers);
        plan.factor.carry_out(numbers);
        for k in 0..last {
            let (now, number) = (k * n..(k + 1) * n, Fused(k as f64));
            for ((links, (runs, _)), products) in laws.links(few).iter().zip(&laws.kinds).zip(&mut *of_links)
            {
                links.gradients(set, runs, k, &series[now.clone()], normals, products);
            }
            if k == 0 {
                let mut own = own.first().take(blocks(2 * entries));
                for (entry, &[c, _]) in plan.of_entry.iter().enumerate() {
                    own.note(entry, zeros(), normals[entry]);
                    own.note(entries + entry, normals[entry], series[n + c]);
                }
            } else {
                let mut own = own.next_within(k).take(blocks(2 * entries));
                for (pull, force) in pull.iter_mut().zip(&*forces) {
                    *pull = *force;
                    scale(square, pull);
                }
                for (entry, &[c, _]) in plan.of_entry.iter().enumerate() {
                    let known = own.sum(entry);
                    add_times(Fused(-1.0), &known, &mut pull[c]); // of −λ
                }
                for c in 0..n {
                    let mut push = zeros();
                    respond(&pull[c], &over[c], &mut push);
                    numbers[change + c] = push;
                }
                plan.rates.carry_out(numbers);
                // Less the rate that keeps velocities along the constraints.
                for (entry, &[c, row]) in plan.of_entry.iter().enumerate() {
                    let mut turn = own.sum(entries + entry);
                    add_product(&mut turn, &normals[entry], &series[n + c]);
                    add_times(number, &turn, &mut numbers[g + row]);
                }
                plan.solve(numbers);
                plan.push.carry_out(numbers);
                let [share, next] = [1.0 / k as f64, 1.0 / (k + 1) as f64].map(Fused);
                for c in 0..n {
                    let mut velocity = numbers[change + c];
                    scale(share, &mut velocity);
                    numbers[change + c] = velocity;
                    scale(next, &mut velocity);
                    series[(k + 1) * n + c] = velocity;
                }
                for (entry, &[c, row]) in plan.of_entry.iter().enumerate() {
                    own.note(entry, numbers[x + row], normals[entry]);
                    own.note(entries + entry, normals[entry], numbers[change + c]);
                }
            }
            if let Some(pulling) = pulling
                && k + 1 < last
            {
                pulling.pull(set, few, k, &series[now], forces);
            }
        }
    }

    /// Sums the series of these lanes, from this one on, up to a part of inner steps of these lengths.
    #[inline(always)]
    fn sum<const W: usize>(&self, inner: &Numbers<FEW>, first: usize, to: &mut Summed<W>) {
        let Summed { part, changes: [ways, changes], bends, left_out } = to;
        let (n, over_unit, mut time) = (self.forces.len(), Fused(1.0 / self.unit), *inner);
        scale(*part * over_unit, &mut time);
        for c in 0..n {
            let [mut x, mut y, mut z] = [zeros(); 3];
            sum_up(&self.series[c..], n, &time, &mut x, &mut y, &mut z);
            scale(over_unit, &mut y);
            scale(over_unit * over_unit, &mut z);
            for (row, few) in [(&mut ways[c], &x), (&mut changes[c], &y), (&mut bends[c], &z)] {
                row.0[first..first + FEW].copy_from_slice(&few.0);
            }
        }
        let dimension = n / left_out.len().max(1);
        for (body, row) in left_out.iter_mut().enumerate() {
            let mut terms = zeros();
            last_terms(&self.series, n, body * dimension..(body + 1) * dimension, &time, &mut terms);
            scale(over_unit * over_unit, &mut terms);
            row.0[first..first + FEW].copy_from_slice(&terms.0);
        }
    }
}

/// M⁻¹f; 0 where a coordinate is pinned, whatever the force.
#[inline(always)]
fn respond(force: &Numbers<FEW>, over: &Numbers<FEW>, to: &mut Numbers<FEW>) {
    for l in 0..FEW {
        let (over, zero) = (over.0[l], Fused(0.0));
        to.0[l] = Real::select(over.0 == 0.0, zero, force.0[l] * over);
    }
}

/// Multiplies these by a number.
#[inline(always)]
fn scale(times: Number, to: &mut Numbers<FEW>) {
    for l in 0..FEW {
        to.0[l] = times * to.0[l];
    }
}

/// See [`Departs::compare`]: inner steps may end in another branch of a potential.
struct Compare<'a, 'b, const W: usize> {
    summed: &'a Summed<W>,
    stand: &'a mut Stand<'b, W>,
    tolerance: f64,
}

impl<const W: usize> Work for Compare<'_, '_, W> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        compare(self.summed, self.stand, self.tolerance);
    }
}

/// Has lanes go by themselves in which the series is not that of the motion after this part of an inner step, of which
/// the numbers are.
#[inline(always)]
fn compare<const W: usize>(summed: &Summed<W>, stand: &mut Stand<'_, W>, tolerance: f64) {
    let Summed { part, bends, left_out, .. } = summed;
    let Stand { course: Course { plan, .. }, pace, numbers, tracks: [places, _], dimension, .. } = stand;
    let (Places { q, change, .. }, h) = (plan.places, pace.h());
    let (tolerance, roundings) = (Fused(tolerance), Fused(ROUNDINGS_OF_SERIES * f64::EPSILON));
    for own in plan.moving.chunk_by(|a, b| a / *dimension == b / *dimension) {
        let [mut off, mut size, mut most]: [Numbers<W>; 3] = [zeros(); 3];
        for &c in own {
            let to = [&places.now[c], &numbers[q + c], &numbers[change + c], &bends[c]];
            widest(to, &mut off, &mut size, &mut most);
        }
        let left_out = &left_out[own[0] / *dimension];
        for l in 0..W {
            let time = pace.inner.0[l] * *part;
            let off = off.0[l] - left_out.0[l];
            let size = size.0[l] + most.0[l] * time * time;
            // In the time of both steps; rounding is that of places in the square of the inner one.
            let within = tolerance + roundings * size * (h / time).abs();
            pace.doubt(l, (off * (time * h).abs()).0 <= within.0);
        }
    }
}

/// By how much accelerations are off those of the series at most, the largest place, and the largest acceleration.
#[inline(always)]
fn widest<const W: usize>(
    [from, to, pull, bend]: [&Numbers<W>; 4],
    off: &mut Numbers<W>,
    size: &mut Numbers<W>,
    most: &mut Numbers<W>,
) {
    for l in 0..W {
        let apart = (pull.0[l] - bend.0[l]).abs();
        let last = off.0[l];
        off.0[l] = Real::select((apart.0 <= last.0) | last.0.is_nan(), last, apart);
        size.0[l] = size.0[l].max(from.0[l].abs()).max(to.0[l].abs());
        most.0[l] = most.0[l].max(pull.0[l].abs());
    }
}
