//! Inner steps of rigid bodies in lanes by the power series of [`Taylor`]: as in
//! [a simulation](crate::systems::rigid) order by order.
//!
//! ```text
//! (k + 1) Qₖ₊₁ = u (Q Ω̂)ₖ,   (k + 1) mₖ₊₁ = u (m × Ω + τ)ₖ      Ω = J⁻¹m,   τ = −Σ rows of Q × rows of F
//! ```
//!
//! u is the unit of time. A few lanes at a time, so that the series of all orders stay in the nearest cache; lanes that
//! have arrived are left out where all of a few have. Products are sums over the series themselves: each of their
//! numbers is a factor of several.

use crate::kernel::series::unit_near;
use crate::methods::taylor::{ROUNDINGS_OF_SERIES, Taylor};
use crate::motion::method::Method;
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::run::ensemble::pace::MOVES;
use crate::run::ensemble::rigid_row::{Inertia, Three};
use crate::run::ensemble::rigid_stand::{Departs, Pulls, ROW, Stand};
use crate::run::ensemble::series_in_lanes::{PullingInSeries, PullsInSeries};
use crate::run::ensemble::taylor_row::{Expansion, Summed, few_of, measure};
use crate::systems::network::in_lanes::{FEW, Number, Numbers, zeros};
use crate::systems::rigid::rotation::Moments;

/// The series of a few lanes: coefficients 0 of all bodies in turn, coefficients 1 of all, ….
pub(super) struct Few<'a> {
    bodies: usize,
    unit: f64,
    pulling: Option<Box<dyn PullingInSeries + 'a>>,
    inertia: Inertia<FEW>,
    /// Q, F, m and Ω.
    attitudes: Vec<Numbers<FEW>>,
    forces: Vec<Numbers<FEW>>,
    momenta: Vec<Numbers<FEW>>,
    spins: Vec<Numbers<FEW>>,
}

impl<'a> Few<'a> {
    /// Of so many bodies under these effects.
    pub(super) fn new(method: &Taylor, pulls: Option<&'a dyn PullsInSeries>, bodies: usize) -> Self {
        let orders = method.coefficients();
        let coefficients = |of_body: usize| vec![zeros(); orders * of_body * bodies];
        Self {
            bodies,
            unit: unit_near(method.step_size()),
            pulling: pulls.map(|pulls| pulls.begin(orders)),
            inertia: Moments { over: [zeros(); 3], bend: [[zeros(); 3]; 2], push: [[zeros(); 3]; 2] },
            attitudes: coefficients(9),
            forces: coefficients(9),
            momenta: coefficients(3),
            spins: coefficients(3),
        }
    }
}

impl Departs for Expansion<Few<'_>, ROW> {
    fn depart(&mut self, stand: &mut Stand<'_>, pulling: &mut Pulls<'_, '_>) {
        stand.set.run(Depart { expansion: self, stand, pulling });
    }

    fn compare(&mut self, stand: &mut Stand<'_>) {
        if let Some(tolerance) = self.method.tolerance() {
            stand.set.run(Compare { summed: &self.end, stand, tolerance });
        }
    }
}

struct Depart<'a, 'b, 'c, 'd, 'e> {
    expansion: &'a mut Expansion<Few<'b>, ROW>,
    stand: &'a mut Stand<'c>,
    pulling: &'a mut Pulls<'d, 'e>,
}

impl Work for Depart<'_, '_, '_, '_, '_> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { expansion: Expansion { method, few, end, inside }, stand, pulling } = self;
        for first in (0..ROW).step_by(FEW) {
            if !stand.pace.going[first..first + FEW].contains(&MOVES) {
                continue;
            }
            few.gather(stand, first);
            few.expand(stand.set, first / FEW);
            let series = (&few.attitudes[..], 9 * few.bodies, few.unit);
            let inner = measure(method, series, &mut stand.pace, first);
            few.sum(&inner, first, end);
            for summed in &mut *inside {
                few.sum(&inner, first, summed);
            }
        }
        // A force that the series knows nothing of may be met on the way.
        for (summed, tolerance) in inside.iter().zip(method.tolerance().into_iter().cycle()) {
            for ((track, changes), trial) in stand.tracks.iter().zip(&summed.changes).zip(&mut stand.trial) {
                for ((trial, now), change) in trial.iter_mut().zip(&track.now).zip(changes) {
                    *trial = *now + *change;
                }
            }
            stand.respond(pulling);
            compare(summed, stand, tolerance);
        }
        let [q, m, q_low, m_low] = &mut stand.trial;
        for ((track, changes), (high, low)) in
            stand.tracks.iter().zip(&end.changes).zip([(q, q_low), (m, m_low)])
        {
            for (c, change) in changes.iter().enumerate() {
                track.arrive(c, change, &mut high[c], &mut low[c]);
            }
        }
    }
}

impl Few<'_> {
    /// Takes over where these lanes are, from this one on.
    #[inline(always)]
    fn gather(&mut self, stand: &Stand<'_>, first: usize) {
        let Self { inertia, attitudes, momenta, .. } = self;
        let [places, moments] = &stand.tracks;
        for (to, from) in attitudes.iter_mut().zip(&places.now).chain(momenta.iter_mut().zip(&moments.now)) {
            few_of(from, first, to);
        }
        for i in 0..3 {
            few_of(&stand.inertia.over[i], first, &mut inertia.over[i]);
            few_of(&stand.inertia.push[0][i], first, &mut inertia.push[0][i]);
        }
    }

    /// Writes Q₁, Q₂, … and m₁, m₂, … of the few lanes of this number.
    #[inline(always)]
    fn expand(&mut self, set: Fusing, few: usize) {
        let Self { bodies, unit, pulling, inertia, attitudes, forces, momenta, spins } = self;
        let (of_matrices, of_vectors) = (9 * *bodies, 3 * *bodies);
        let last = (momenta.len() / of_vectors.max(1)).saturating_sub(1); // 0 without bodies
        for k in 0..last {
            let now = k * of_matrices..(k + 1) * of_matrices;
            if let Some(pulling) = pulling {
                pulling.pull(set, few, k, &attitudes[now.clone()], &mut forces[now]);
            }
            let share = Fused(*unit / (k + 1) as f64);
            for body in 0..*bodies {
                let (matrix, vector) = (9 * body, 3 * body);
                let at = k * of_vectors + vector;
                rate_of(inertia, &momenta[at..at + 3], &mut spins[at..at + 3]);
                let spin = Coefficients { of: &*spins, first: vector, stride: of_vectors };
                let [mut torque, mut others] = [[zeros(); 3]; 2];
                let next = (k + 1) * of_matrices + matrix;
                for row in [0, 3, 6] {
                    let (known, to) = attitudes.split_at_mut(next + row);
                    let q = Coefficients { of: known, first: matrix + row, stride: of_matrices };
                    let mut turned = [zeros(); 3];
                    add_cross(k, &q, &spin, &mut turned);
                    share_out(share, &turned, &mut to[..3]);
                    if pulling.is_some() {
                        let f = Coefficients { of: &*forces, first: matrix + row, stride: of_matrices };
                        add_cross(k, &f, &q, &mut torque);
                    }
                }
                add_others(k, &spin, &mut others);
                let next = (k + 1) * of_vectors + vector;
                push(inertia, share, &torque, &others, &mut momenta[next..next + 3]);
            }
        }
    }

    /// Sums the series of these lanes, from this one on, up to a part of inner steps of these lengths.
    #[inline(always)]
    fn sum(&self, inner: &Numbers<FEW>, first: usize, to: &mut Summed<ROW>) {
        let Summed { part, changes: [ways, changes], bends, left_out } = to;
        let (n, over_unit, mut time) = (self.bodies, Fused(1.0 / self.unit), *inner);
        for l in 0..FEW {
            time.0[l] = time.0[l] * *part * over_unit;
        }
        for (c, row) in ways.iter_mut().enumerate() {
            let mut way = zeros();
            sum_up(&self.attitudes[c..], 9 * n, &time, &mut way);
            row.0[first..first + FEW].copy_from_slice(&way.0);
        }
        for c in 0..3 * n {
            let (series, [mut way, mut bend, mut last]) = (&self.momenta[c..], [zeros(); 3]);
            sum_up(series, 3 * n, &time, &mut way);
            slope(series, 3 * n, &time, over_unit, &mut bend, &mut last);
            for (row, few) in [(&mut changes[c], &way), (&mut bends[c], &bend), (&mut left_out[c], &last)] {
                row.0[first..first + FEW].copy_from_slice(&few.0);
            }
        }
    }
}

/// A vector of a body as a series: where its coefficient 0 is, and how far apart its coefficients are.
struct Coefficients<'a> {
    of: &'a [Numbers<FEW>],
    first: usize,
    stride: usize,
}

impl Coefficients<'_> {
    #[inline(always)]
    fn number(&self, k: usize) -> &Three<FEW> {
        let at = k * self.stride + self.first;
        self.of[at..].first_chunk().unwrap_or(const { &[zeros(); 3] }) // never: all are there
    }
}

/// Adds coefficient k of a × b.
#[inline(always)]
fn add_cross(k: usize, a: &Coefficients<'_>, b: &Coefficients<'_>, to: &mut Three<FEW>) {
    let mut sums = *to;
    for j in 0..=k {
        add_product(a.number(j), b.number(k - j), &mut sums);
    }
    *to = sums;
}

#[inline(always)]
fn add_product(a: &Three<FEW>, b: &Three<FEW>, to: &mut Three<FEW>) {
    for [i, j, l] in [[0, 1, 2], [1, 2, 0], [2, 0, 1]] {
        for lane in 0..FEW {
            let sum = a[j].0[lane].multiply_add(b[l].0[lane], to[i].0[lane]);
            to[i].0[lane] = (-a[l].0[lane]).multiply_add(b[j].0[lane], sum);
        }
    }
}

/// Adds coefficient k of the products of the [others](Moments::others).
#[inline(always)]
fn add_others(k: usize, a: &Coefficients<'_>, to: &mut Three<FEW>) {
    let mut sums = *to;
    for j in 0..=k {
        let (a, b) = (a.number(j), a.number(k - j));
        for [i, j, l] in [[0, 1, 2], [1, 2, 0], [2, 0, 1]] {
            for lane in 0..FEW {
                sums[i].0[lane] = a[j].0[lane].multiply_add(b[l].0[lane], sums[i].0[lane]);
            }
        }
    }
    *to = sums;
}

/// Ω.
#[inline(always)]
fn rate_of(inertia: &Inertia<FEW>, m: &[Numbers<FEW>], to: &mut [Numbers<FEW>]) {
    for (over, (m, to)) in inertia.over.iter().zip(m.iter().zip(to)) {
        for l in 0..FEW {
            to.0[l] = Fused(2.0) * over.0[l] * m.0[l];
        }
    }
}

/// These times a number.
#[inline(always)]
fn share_out(share: Number, of: &Three<FEW>, to: &mut [Numbers<FEW>]) {
    for (of, to) in of.iter().zip(to) {
        for l in 0..FEW {
            to.0[l] = share * of.0[l];
        }
    }
}

/// Torque and gyration times a number.
#[inline(always)]
fn push(
    inertia: &Inertia<FEW>,
    share: Number,
    torque: &Three<FEW>,
    others: &Three<FEW>,
    to: &mut [Numbers<FEW>],
) {
    for i in 0..3 {
        for l in 0..FEW {
            let push = Fused(-0.5) * inertia.push[0][i].0[l];
            to[i].0[l] = share * push.multiply_add(others[i].0[l], torque[i].0[l]);
        }
    }
}

/// Sums up the series of a number by Horner's rule: what it changes by in these times.
#[inline(always)]
fn sum_up(series: &[Numbers<FEW>], n: usize, time: &Numbers<FEW>, way: &mut Numbers<FEW>) {
    for k in (1..series.len().div_ceil(n)).rev() {
        for l in 0..FEW {
            way.0[l] = time.0[l] * (series[k * n].0[l] + way.0[l]);
        }
    }
}

/// The rate of the number then, and its last two terms.
#[inline(always)]
fn slope(
    series: &[Numbers<FEW>],
    n: usize,
    time: &Numbers<FEW>,
    over_unit: Number,
    rate: &mut Numbers<FEW>,
    left_out: &mut Numbers<FEW>,
) {
    let orders = series.len().div_ceil(n);
    for k in (1..orders).rev() {
        let (coefficient, number) = (&series[k * n], Fused(k as f64) * over_unit);
        for l in 0..FEW {
            let (term, last) = (number * coefficient.0[l], k + 2 >= orders);
            rate.0[l] = time.0[l].multiply_add(rate.0[l], term);
            let further = if last { term.abs() } else { Fused(0.0) };
            left_out.0[l] = time.0[l].abs().multiply_add(left_out.0[l], further);
        }
    }
}

/// See [`Departs::compare`]: inner steps may end in another branch of a potential.
struct Compare<'a, 'b> {
    summed: &'a Summed<ROW>,
    stand: &'a mut Stand<'b>,
    tolerance: f64,
}

impl Work for Compare<'_, '_> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        compare(self.summed, self.stand, self.tolerance);
    }
}

/// Has lanes go by themselves in which the series is not that of the motion after this part of an inner step, of which
/// the rates on trial are.
#[inline(always)]
fn compare(summed: &Summed<ROW>, stand: &mut Stand<'_>, tolerance: f64) {
    let Summed { part, bends, left_out, .. } = summed;
    let Stand { inertia, pace, trial: [_, m, ..], rates_there: [_, pushed], .. } = stand;
    let (tolerance, roundings) = (Fused(tolerance), Fused(ROUNDINGS_OF_SERIES * f64::EPSILON));
    let h = pace.h();
    for body in (0..m.len()).step_by(3) {
        let [mut off, mut most]: [Numbers<ROW>; 2] = [zeros(); 2];
        for (c, over) in (body..body + 3).zip(&inertia.over) {
            widest(over, [&m[c], &pushed[c], &bends[c], &left_out[c]], &mut off, &mut most);
        }
        for l in 0..ROW {
            let time = pace.inner.0[l] * *part;
            // Attitudes are of the size of 1; in the time of both steps.
            let size = Fused(1.0) + most.0[l] * time * time;
            let within = tolerance + roundings * size * (h / time).abs();
            pace.doubt(l, (off.0[l] * (time * h).abs()).0 <= within.0);
        }
    }
}

/// By how much Ω̇ is off that of the series at most, beyond what the series leaves out; and the largest acceleration.
#[inline(always)]
fn widest(
    over: &Numbers<ROW>,
    [m, pushed, rate, left_out]: [&Numbers<ROW>; 4],
    off: &mut Numbers<ROW>,
    most: &mut Numbers<ROW>,
) {
    for l in 0..ROW {
        let over = Fused(2.0) * over.0[l];
        let apart = over * ((pushed.0[l] - rate.0[l]).abs() - left_out.0[l]);
        let last = off.0[l];
        off.0[l] = Real::select((apart.0 <= last.0) | last.0.is_nan(), last, apart);
        let (spin, change) = (over * m.0[l], over * pushed.0[l]);
        most.0[l] = most.0[l].max(spin * spin).max(change.abs());
    }
}
