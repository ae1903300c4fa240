//! [`Taylor`] in rows of numbers, a few lanes at a time: sums of series, their last terms, and how long inner steps
//! are. What is moved, and where its coefficients come from, is another.
//!
//! A few, whatever the width of the row: the coefficients of all orders stay in the nearer cache.

use crate::methods::taylor::{INSIDE, SMALLEST_PART, Taylor};
use crate::motion::method::Method;
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::run::ensemble::pace::Pace;
use crate::systems::network::in_lanes::{FEW, Number, Numbers, zeros};
use std::ops::Range;

/// Where inner steps of W lanes lead, by the series of a few lanes at a time.
pub(super) struct Expansion<F, const W: usize> {
    pub(super) method: Taylor,
    pub(super) few: F,
    /// At the end of inner steps, and with a tolerance at times [inside](INSIDE) of them.
    pub(super) end: Summed<W>,
    pub(super) inside: Vec<Summed<W>>,
}

/// The series after a part of an inner step.
pub(super) struct Summed<const W: usize> {
    pub(super) part: Number,
    /// By how much places and velocities are changed, or attitudes and momenta.
    pub(super) changes: [Vec<Numbers<W>>; 2],
    /// Accelerations, or rates of momenta; and their last two terms, of each or of each body, which tell what the
    /// series leaves out.
    pub(super) bends: Vec<Numbers<W>>,
    pub(super) left_out: Vec<Numbers<W>>,
}

impl<F, const W: usize> Expansion<F, W> {
    /// Of so many numbers of each kind: of both that change, and of what the series leaves out.
    pub(super) fn new(method: Taylor, few: F, [places, ways, left_out]: [usize; 3]) -> Self {
        let rows = |number: usize| vec![zeros(); number];
        let summed = |part: f64| Summed {
            part: Fused(part),
            changes: [rows(places), rows(ways)],
            bends: rows(ways),
            left_out: rows(left_out),
        };
        let inside = method.tolerance().map(|_| INSIDE.map(summed).into_iter().collect());
        Self { method, few, end: summed(1.0), inside: inside.unwrap_or_default() }
    }
}

/// A few lanes of these, from this one on.
#[inline(always)]
pub(super) fn few_of<const W: usize>(from: &Numbers<W>, first: usize, to: &mut Numbers<FEW>) {
    to.0.copy_from_slice(&from.0[first..first + FEW]);
}

/// Says how long the inner steps of a few lanes are, from this one on, and whether they are taken: the longest ones are
/// those of series of so many numbers, whose unit of time is this one.
#[inline(always)]
pub(super) fn measure<const W: usize>(
    method: &Taylor,
    (series, n, unit): (&[Numbers<FEW>], usize, f64),
    pace: &mut Pace<W>,
    first: usize,
) -> Numbers<FEW> {
    let (mut inner, [mut left, mut next]) = (zeros(), [zeros(); 2]);
    few_of(&pace.left, first, &mut left);
    let mut taken = [true; FEW];
    match method.tolerance() {
        None => (inner, next) = (left, left),
        Some(tolerance) => {
            let longest = longest(method, tolerance, series, n, unit);
            let shortest = Fused(SMALLEST_PART * method.step_size().abs());
            for l in 0..FEW {
                let (longest, left) = (longest.0[l], left.0[l]);
                taken[l] = shortest.0 <= longest.0;
                inner.0[l] = Real::select(longest.0 < left.abs().0, longest * left.sign(), left);
                next.0[l] = Real::select(taken[l], left, Fused(0.0));
            }
        }
    }
    let own = first..first + FEW;
    pace.inner.0[own.clone()].copy_from_slice(&inner.0);
    pace.next.0[own.clone()].copy_from_slice(&next.0);
    pace.taken[own].copy_from_slice(&taken);
    inner
}

/// The longest inner steps whose last two terms keep the tolerance; 0 where a term is no number.
#[inline(always)]
fn longest(method: &Taylor, tolerance: f64, series: &[Numbers<FEW>], n: usize, unit: f64) -> Numbers<FEW> {
    let mut longest: Numbers<FEW> = zeros();
    longest.0 = [Fused(f64::INFINITY); FEW];
    for order in [method.order() as usize - 1, method.order() as usize] {
        let (mut most, mut none): (Numbers<FEW>, Numbers<FEW>) = (zeros(), zeros());
        let scale = Fused((order + 1) as f64 * (method.step_size() / unit).abs());
        for c in 0..n {
            let [q, v] = [order, order + 1].map(|order| &series[order * n + c]);
            for l in 0..FEW {
                most.0[l] = most.0[l].max(q.0[l].abs()).max(scale * v.0[l].abs());
                none.0[l] = Fused(0.0).multiply_add(q.0[l] + v.0[l], none.0[l]);
            }
        }
        let inverse = Fused(1.0 / order as f64);
        for l in 0..FEW {
            let fits = Fused(unit) * (Fused(tolerance) / most.0[l]).powf(inverse);
            let fits = Real::select(none.0[l].0 == 0.0, fits, Fused(0.0));
            longest.0[l] = Real::select(fits.0 < longest.0[l].0, fits, longest.0[l]);
        }
    }
    longest
}

/// Sums up the series of a number by Horner's rule: what it and its rate change by in these times, and the rate of its
/// rate then.
#[inline(always)]
pub(super) fn sum_up(
    series: &[Numbers<FEW>],
    n: usize,
    time: &Numbers<FEW>,
    way: &mut Numbers<FEW>,
    change: &mut Numbers<FEW>,
    bend: &mut Numbers<FEW>,
) {
    for k in (1..series.len().div_ceil(n)).rev() {
        let (coefficient, [number, both]) = (&series[k * n], [k, k * (k - 1)].map(|k| Fused(k as f64)));
        for l in 0..FEW {
            let (a, time) = (coefficient.0[l], time.0[l]);
            way.0[l] = time * (a + way.0[l]);
            if k > 1 {
                change.0[l] = time * number.multiply_add(a, change.0[l]);
                bend.0[l] = time.multiply_add(bend.0[l], both * a);
            }
        }
    }
}

/// The last two terms of the rates of the rates of some numbers after these times; the largest of each.
#[inline(always)]
pub(super) fn last_terms(
    series: &[Numbers<FEW>],
    n: usize,
    own: Range<usize>,
    time: &Numbers<FEW>,
    to: &mut Numbers<FEW>,
) {
    let last = series.len() / n - 1;
    let [before, number] = [(last - 1) * (last - 2), last * (last - 1)].map(|k| Fused(k as f64));
    for c in own {
        let [a, b] = [last - 1, last].map(|k| &series[k * n + c]);
        for l in 0..FEW {
            let both = before * a.0[l].abs() + number * (b.0[l] * time.0[l]).abs();
            to.0[l] = to.0[l].max(both);
        }
    }
    for _ in 0..last - 3 {
        for l in 0..FEW {
            to.0[l] = to.0[l] * time.0[l].abs();
        }
    }
}
