//! Rows of trajectories of linked bodies whose steps are [projected](crate::run::ensemble::linked_projected): what is
//! kept from step to step, and the loops over lanes of a step. Arguments of a function are known not to overlap, so
//! that its loop becomes one over vectors.

use crate::kernel::rounding::size_of_terms;
use crate::motion::course::JUMP;
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::number::vector::two_sum;
use crate::run::ensemble::inside::quintic;
use crate::run::ensemble::track::State;
use crate::solve::aim::{BOLD, OFF_INSIDE, ROUNDINGS};
use crate::systems::network::in_lanes::{Number, Numbers, Which, zeros};
use std::array::from_fn;

/// Where bodies are and how fast, and what rounding took from both: what is kept of a row from step to step; and how
/// far steps may lead astray, as far as other sheets were looked for, and as far as it has been since.
#[derive(Clone)]
pub(super) struct Kept<const W: usize> {
    /// q, v, and what rounding took from them, coordinate by coordinate.
    pub(super) state: State<W>,
    /// What the method remembers.
    pub(super) past: Vec<Numbers<W>>,
    pub(super) asked: Numbers<W>,
    pub(super) astray: Numbers<W>,
}

impl<const W: usize> Kept<W> {
    /// Of bodies of so many coordinates, and a method that remembers so many numbers.
    pub(super) fn new(coordinates: usize, remembered: usize) -> Self {
        let [asked, astray] = [zeros(); 2];
        let state = from_fn(|_| vec![zeros(); coordinates]);
        Self { state, past: vec![zeros(); remembered], asked, astray }
    }

    /// Each number, of all lanes.
    pub(super) fn all(&mut self) -> impl Iterator<Item = &mut Numbers<W>> {
        let Self { state, past, asked, astray } = self;
        state.iter_mut().flatten().chain(past).chain([asked, astray])
    }
}

/// Has the method remember nothing of a lane.
pub(super) fn forget<const W: usize>(past: &mut [Numbers<W>], lane: usize) {
    if let Some(first) = past.first_mut() {
        first.0[lane] = Fused(0.0);
    }
}

/// Where a step leads a lane by itself.
pub(super) struct Landed {
    /// As the [`State`] of all lanes.
    pub(super) state: [Vec<f64>; 4],
    /// How far the step may have led astray, and how far it led.
    pub(super) strays: f64,
    pub(super) path: f64,
}

/// The radius that a path is bent in, as on a circle, on which a step leads so far astray.
#[inline(always)]
pub(super) fn bent(path: Number, astray: Number) -> Number {
    path * (path / (Fused(12.0) * astray)).sqrt()
}

/// What is summed up over the coordinates of an inner step.
pub(super) struct Sums<const W: usize> {
    /// The largest way, and the largest by which it is off the mean of the velocities at both ends.
    pub(super) path: Numbers<W>,
    pub(super) astray: Numbers<W>,
    /// The largest coordinate.
    pub(super) size: Numbers<W>,
    /// The squares of what is off, and of ways.
    off: Numbers<W>,
    ways: Numbers<W>,
    /// Twice the kinetic energies at both ends, and twice what accelerations change them by.
    was: Numbers<W>,
    is: Numbers<W>,
    given: Numbers<W>,
    /// The squares of velocities and accelerations.
    numbers: Numbers<W>,
}

impl<const W: usize> Default for Sums<W> {
    fn default() -> Self {
        let [path, astray, size, off, ways, was, is, given, numbers] = [zeros(); 9];
        Self { path, astray, size, off, ways, was, is, given, numbers }
    }
}

impl<const W: usize> Sums<W> {
    /// Adds a coordinate, and writes how far it is off.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        inner: &Numbers<W>,
        [from, v, a]: [&Numbers<W>; 3],
        [to, v_end, a_end]: [&Numbers<W>; 3],
        masses: &Numbers<W>,
        off: &mut Numbers<W>,
    ) {
        for l in 0..W {
            let (v, w, a, b, mass) = (v.0[l], v_end.0[l], a.0[l], a_end.0[l], masses.0[l]);
            let way = to.0[l] - from.0[l];
            let path = Fused(0.5) * inner.0[l] * (v + w);
            let astray = way - path;
            off.0[l] = astray;
            self.path.0[l] = self.path.0[l].max(way.abs());
            self.astray.0[l] = self.astray.0[l].max(astray.abs());
            self.size.0[l] = self.size.0[l].max(from.0[l].abs()).max(to.0[l].abs());
            self.off.0[l] = astray.multiply_add(astray, self.off.0[l]);
            self.ways.0[l] = path.multiply_add(path, self.ways.0[l]);
            self.was.0[l] = (mass * v).multiply_add(v, self.was.0[l]);
            self.is.0[l] = (mass * w).multiply_add(w, self.is.0[l]);
            self.given.0[l] = (mass * inner.0[l]).multiply_add(a.multiply_add(v, b * w), self.given.0[l]);
            self.numbers.0[l] = w.multiply_add(w, b.multiply_add(b, self.numbers.0[l]));
        }
    }

    /// Whether the step of a lane leads where velocities do, kinetic energy changes by what forces give, and all are
    /// numbers.
    #[inline(always)]
    pub(super) fn is_plain(&self, l: usize, rounding: Number) -> bool {
        let [off, ways, was, is, given] =
            [&self.off, &self.ways, &self.was, &self.is, &self.given].map(|of| of.0[l].0);
        let short = (off <= BOLD * BOLD * ways) | (self.astray.0[l].0 <= rounding.0);
        let steady = (is - was - given).abs() <= JUMP * (was + is + given.abs());
        short & steady & (self.numbers.0[l].0 <= f64::MAX)
    }
}

/// Moves a coordinate of some lanes.
#[inline(always)]
pub(super) fn move_by<const W: usize>(
    lanes: &Which<W>,
    by: &Numbers<W>,
    place: &mut Numbers<W>,
    low: &mut Numbers<W>,
) {
    for l in 0..W {
        let ([high], [rest]) = two_sum(&[place.0[l]], &[low.0[l] + by.0[l]]);
        place.0[l] = Real::select(lanes[l] != 0, high, place.0[l]);
        low.0[l] = Real::select(lanes[l] != 0, rest, low.0[l]);
    }
}

/// Adds an entry of a normal to what g is made of.
#[inline(always)]
pub(super) fn terms<const W: usize>(
    normal: &Numbers<W>,
    q: &Numbers<W>,
    square: &mut Numbers<W>,
    along: &mut Numbers<W>,
    most: &mut Numbers<W>,
) {
    for l in 0..W {
        let (n, size) = (normal.0[l], q.0[l].abs());
        square.0[l] = n.multiply_add(n, square.0[l]);
        along.0[l] = n.abs().multiply_add(size, along.0[l]);
        most.0[l] = most.0[l].max(size);
    }
}

/// Notes that something is rounded as so many times these numbers at least.
#[inline(always)]
pub(super) fn at_least<const W: usize>(times: Number, of: &Numbers<W>, most: &mut Numbers<W>) {
    for l in 0..W {
        most.0[l] = most.0[l].max((times * of.0[l]).abs());
    }
}

/// How far from its constraint an equation is, and how many roundings of places that is, if no other is farther.
#[inline(always)]
pub(super) fn furthest<const W: usize>(
    g: &Numbers<W>,
    square: &Numbers<W>,
    along: &Numbers<W>,
    most: &Numbers<W>,
    far: &mut Numbers<W>,
    roundings: &mut Numbers<W>,
) {
    for l in 0..W {
        let (g, length) = (g.0[l].abs(), square.0[l].sqrt());
        let size = size_of_terms(along.0[l], Fused(0.0), most.0[l] * length);
        let off = Real::select(g.0 == 0.0, g, g / (Fused(f64::EPSILON) * size));
        // Where one of them is no number it remains so, and the lane goes by itself.
        let (last, nearer) = (roundings.0[l], (off.0 <= roundings.0[l].0) | roundings.0[l].0.is_nan());
        roundings.0[l] = Real::select(nearer, last, off);
        far.0[l] = Real::select(nearer, far.0[l], g / length);
    }
}

/// Notes how far an equation is from its constraint, and how large the coordinates are whose rounding moves it.
#[inline(always)]
pub(super) fn farther<const W: usize>(
    g: &Numbers<W>,
    [square, along, most]: [&Numbers<W>; 3],
    far: &mut Numbers<W>,
    size: &mut Numbers<W>,
) {
    for l in 0..W {
        let (g, length) = (g.0[l].abs(), square.0[l].sqrt());
        let own = size_of_terms(along.0[l], Fused(0.0), most.0[l] * length) / length;
        let off = Real::select(g.0 == 0.0, g, g / length);
        // Where one of them is no number it remains so.
        let (last, nearer) = (far.0[l], (off.0 <= far.0[l].0) | far.0[l].0.is_nan());
        far.0[l] = Real::select(nearer, last, off);
        size.0[l] = size.0[l].max(own);
    }
}

/// Adds an entry of a normal to what g may be inside of a step.
#[inline(always)]
pub(super) fn may_be<const W: usize>(
    normal: &Numbers<W>,
    off: &Numbers<W>,
    q: &Numbers<W>,
    square: &mut Numbers<W>,
    most: &mut Numbers<W>,
) {
    for l in 0..W {
        let (n, off, size) = (normal.0[l], off.0[l].abs(), q.0[l].abs());
        square.0[l] = n.multiply_add(n, square.0[l]);
        let here = Fused(OFF_INSIDE).multiply_add(off, Fused(ROUNDINGS * f64::EPSILON) * size);
        most.0[l] = most.0[l].max(here);
    }
}

/// A coordinate at the share s of an inner step, on the quintic of places, velocities and accelerations at both ends.
#[inline(always)]
pub(super) fn between<const W: usize>(
    s: f64,
    inner: &Numbers<W>,
    [from, v, a]: [&Numbers<W>; 3],
    [to, v_end, a_end]: [&Numbers<W>; 3],
    beside: &mut Numbers<W>,
) {
    let [two, three, half] = [2.0, 3.0, 0.5].map(Fused);
    let [of_way, of_first, of_last, of_bend, of_end] = quintic(s).map(Fused);
    for l in 0..W {
        let h = inner.0[l];
        let (way, first, last) = (to.0[l] - from.0[l], h * v.0[l], h * v_end.0[l]);
        let square = half * h * h;
        // Half of what the accelerations at both ends are beyond those of the cubic.
        let bend = square.multiply_add(a.0[l], two.multiply_add(first, last) - three * way);
        let end = square.multiply_add(a_end.0[l], three * way - two.multiply_add(last, first));
        let cubic = of_way.multiply_add(way, of_first.multiply_add(first, of_last * last));
        beside.0[l] = from.0[l] + of_bend.multiply_add(bend, of_end.multiply_add(end, cubic));
    }
}

/// Moves a coordinate along a normal, so many times that.
#[inline(always)]
pub(super) fn shift<const W: usize>(
    share: Number,
    times: &Numbers<W>,
    normal: &Numbers<W>,
    to: &mut Numbers<W>,
) {
    for l in 0..W {
        to.0[l] = (share * times.0[l]).multiply_add(normal.0[l], to.0[l]);
    }
}
