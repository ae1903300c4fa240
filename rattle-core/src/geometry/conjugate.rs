//! Geodesics that end near a point conjugate to their start, such as the antipode of a sphere.
//!
//! Turned by φ, a geodesic of length l ends elsewhere by y φ, in a direction that is turned by y′ φ. Near a conjugate
//! point y is nearly 0, and what is missed at b does not say well how to turn; but y′ is not 0.
//!
//! ```text
//! d(φ) = the length at whose end nothing is missed along the way        d′ = y′ m,   d″ = −y′ y
//! ```
//!
//! where m is what is missed across the way, to first order in it (the first variation). d has a minimum where m = 0
//! and y y′ < 0, that is where b lies before the conjugate point; beyond it the same equation finds a way that is
//! not the shortest. So ways are turned by m/y before that point, by −m/y beyond it, and never by much. Near a
//! conjugate point of several directions, d is that of a sphere and a quadratic form: it has no more than two minima,
//! on opposite sides.

use crate::kernel::functions::ConstraintKernel;
use crate::kernel::geodesic::{Aim, MISSED, Shot, Try, length, normal, shot};
use crate::kernel::jacobi::passes_conjugate;
use crate::number::vector::{add_scaled, dot, scaled};
use nalgebra::{DMatrix, DVector};

/// A conjugate point is near where y is less than this part of the length.
const NEAR: f64 = 0.1;
/// Many ways meet at b if the opposite one ends so near to it, as part of its length.
const MEET: f64 = 0.2;
/// A way is not turned by more at once.
const TURN: f64 = 0.5;
/// By how much a way is turned to find out where it ends then: as by the last turn, between these. Less would lose y
/// to rounding, more is another landscape.
const SPREAD: [f64; 2] = [1e-3, 0.1];
/// Turns that are tried.
const TURNS: usize = 60;
/// How often a turn is halved that leads neither nearer nor to a shorter way.
const HALVINGS: usize = 10;
/// Less of the length is rounding.
const SHORTER: f64 = 1e-14;

/// The shortest geodesic near one that is found: that one, unless a conjugate point is near its end.
pub(super) fn settled<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    kernel: &K,
    a: &[f64; D],
    chord: &[f64; D],
    found: Shot<D>,
) -> Shot<D> {
    let aim = Aim::new(kernel, a, chord);
    let way = Way { unit: found.from, length: found.distance };
    let fan = way.end(&aim).and_then(|end| Fan::new(&aim, &way, &end, SPREAD[0]));
    if fan.is_none_or(|fan| !fan.is_near_conjugate(&way)) {
        return found;
    }
    let back = Way { unit: scaled(-1.0, &way.unit), ..way };
    let meets = back.end(&aim).is_some_and(|end| length(&end.tried.0) < MEET * way.length);
    let ways = [Some(way), meets.then_some(back)].into_iter().flatten();
    let all = ways.filter_map(|way| descend(&aim, way));
    // Those may miss b by more than what was found.
    let shorter = |least: &Shot<D>, other: &Shot<D>| other.distance < (1.0 - MISSED) * least.distance;
    all.fold(found, |least, other| if shorter(&least, &other) { other } else { least })
}

/// Whether a geodesic has passed a point conjugate to its start: it is not the shortest then. It may have, where that
/// is not known.
pub(super) fn passes<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    kernel: &K,
    a: &[f64; D],
    found: &Shot<D>,
) -> bool {
    let (v, axes) = (scaled(found.distance, &found.from), across([&normal(kernel, a), &found.from]));
    let passed = match axes.len() {
        number if number == 0 || found.distance == 0.0 => Some(false), // a curve, or no way
        1 => passes_conjugate::<K, D, 2>(kernel, a, &v, &axes),
        _ => passes_conjugate::<K, D, D>(kernel, a, &v, &axes),
    };
    passed.unwrap_or(true)
}

/// The geodesic to which a way leads that ends near b, and near a conjugate point.
pub(super) fn from_near<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    kernel: &K,
    a: &[f64; D],
    chord: &[f64; D],
    v: &[f64; D],
) -> Option<Shot<D>> {
    let length = length(v);
    descend(&Aim::new(kernel, a, chord), Way { unit: scaled(1.0 / length, v), length })
}

/// Turns a way, and changes its length, until it ends at b and no small turn makes it shorter.
fn descend<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    aim: &Aim<'_, K, D>,
    way: Way<D>,
) -> Option<Shot<D>> {
    let (mut way, mut now) = (way, way.end(aim)?);
    let (mut most, mut last, mut kicks, mut before) = (TURN, SPREAD[1], 0, f64::INFINITY);
    for _ in 0..TURNS {
        let fan = Fan::new(aim, &way, &now, last.clamp(SPREAD[0], SPREAD[1]))?;
        let missed = now.missed();
        let settles = missed <= MISSED * aim.extent(way.length) && 2.0 * missed > before;
        let hits = settles || missed <= aim.floor(way.length);
        let beyond = fan.beyond(&way);
        let mut turn = match beyond {
            Some(aside) if hits && kicks < D => {
                (most, kicks) = (TURN, kicks + 1);
                aside * TURN // a way that is longest: either side leads down
            }
            _ if hits => return Some(shot(&way.velocity(), &now.tried)),
            _ => fan.turn(&way, &now, most),
        };
        let mut next = None;
        for _ in 0..HALVINGS {
            let tried = way.turned(aim, &fan, &turn, now.along);
            let nearer = |end: &End<D>| {
                hits || end.missed() < missed
                    || tried.length + end.along < way.length + now.along - SHORTER * way.length
            };
            if let Some(end) = tried.end(aim).filter(nearer) {
                next = Some((tried, end));
                break;
            }
            turn *= 0.5;
            most *= 0.5;
        }
        let Some((better, end)) = next else { break };
        (way, now, last, before) = (better, end, turn.norm(), if hits { f64::INFINITY } else { missed });
        most = (2.0 * most).min(TURN);
    }
    (now.missed() <= MISSED * aim.extent(way.length)).then(|| shot(&way.velocity(), &now.tried))
}

/// A geodesic from a, by its direction and length.
#[derive(Clone, Copy)]
struct Way<const D: usize> {
    unit: [f64; D],
    length: f64,
}

/// Where it ends, against b.
struct End<const D: usize> {
    /// What is missed along it, across it in the tangent space of b, and its direction there.
    along: f64,
    across: [f64; D],
    to: [f64; D],
    tried: Try<D>,
}

impl<const D: usize> Way<D> {
    fn velocity(&self) -> [f64; D] {
        scaled(self.length, &self.unit)
    }

    fn end<K: ConstraintKernel<f64, D, 1>>(&self, aim: &Aim<'_, K, D>) -> Option<End<D>> {
        let tried = aim.look(&self.velocity())?;
        let there = &aim.there;
        let tangent = |w: &[f64; D]| add_scaled(w, -dot(there, w), there);
        let (missed, speed) = (tangent(&tried.0), tangent(&tried.2));
        let to = scaled(1.0 / length(&speed), &speed);
        let along = dot(&to, &missed);
        Some(End { along, across: add_scaled(&missed, -along, &to), to, tried })
    }

    /// Turned, by parts of the axes of a fan, and longer.
    fn turned<K: ConstraintKernel<f64, D, 1>>(
        &self,
        aim: &Aim<'_, K, D>,
        fan: &Fan<D>,
        turn: &DVector<f64>,
        longer: f64,
    ) -> Self {
        let angle = turn.norm();
        let mut unit = scaled(angle.cos(), &self.unit);
        for (axis, part) in fan.axes.iter().zip(turn.iter()) {
            let share = if angle > 0.0 { part / angle * angle.sin() } else { 0.0 };
            unit = add_scaled(&unit, share, axis);
        }
        unit = add_scaled(&unit, -dot(&aim.here, &unit), &aim.here);
        let length = (self.length + longer).max(0.5 * self.length);
        Self { unit: scaled(1.0 / dot(&unit, &unit).sqrt(), &unit), length }
    }
}

impl<const D: usize> End<D> {
    fn missed(&self) -> f64 {
        length(&self.tried.0)
    }
}

/// Where the ways beside one way end: y and y′, as matrices from turns at the start to ways across the end.
struct Fan<const D: usize> {
    /// The axes at the start, and those at b.
    axes: Vec<[f64; D]>,
    across: Vec<[f64; D]>,
    /// y = U diag(σ) Vᵀ, σ ≥ 0, and the diagonal of Uᵀ y′ V.
    ends: DMatrix<f64>,
    sizes: DVector<f64>,
    turns: DMatrix<f64>,
    rates: DVector<f64>,
}

impl<const D: usize> Fan<D> {
    /// By differences; none on a curve, which knows no turn.
    fn new<K: ConstraintKernel<f64, D, 1>>(
        aim: &Aim<'_, K, D>,
        way: &Way<D>,
        end: &End<D>,
        spread: f64,
    ) -> Option<Self> {
        let axes = across([&aim.here, &way.unit]);
        let across = across([&aim.there, &end.to]);
        let number = axes.len();
        if number == 0 {
            return None;
        }
        let (mut y, mut rate) = (DMatrix::zeros(number, number), DMatrix::zeros(number, number));
        for (i, axis) in axes.iter().enumerate() {
            let beside = |sign: f64| {
                let unit = add_scaled(&scaled(spread.cos(), &way.unit), sign * spread.sin(), axis);
                Way { unit, ..*way }.end(aim)
            };
            let (one, other) = (beside(1.0)?, beside(-1.0)?);
            let per_turn = 0.5 / spread.sin();
            let ends = add_scaled(&other.tried.0, -1.0, &one.tried.0);
            let turned = add_scaled(&one.to, -1.0, &other.to);
            for (j, aside) in across.iter().enumerate() {
                y[(j, i)] = per_turn * dot(aside, &ends);
                rate[(j, i)] = per_turn * dot(aside, &turned);
            }
        }
        let svd = y.try_svd(true, true, f64::EPSILON, 1000)?;
        let (ends, turns) = (svd.u?, svd.v_t?.transpose());
        let rates = (ends.transpose() * rate * &turns).diagonal();
        Some(Self { axes, across, ends, sizes: svd.singular_values, turns, rates })
    }

    fn is_near_conjugate(&self, way: &Way<D>) -> bool {
        self.sizes.min() < NEAR * way.length
    }

    /// Whether a way has passed a conjugate point that is near, in this direction.
    fn has_passed(&self, way: &Way<D>, i: usize) -> bool {
        self.sizes[i] < NEAR * way.length && self.rates[i] > 0.0
    }

    /// The direction in which a way has passed a conjugate point that is near.
    fn beyond(&self, way: &Way<D>) -> Option<DVector<f64>> {
        let passed = (0..self.sizes.len()).find(|&i| self.has_passed(way, i))?;
        Some(self.turns.column(passed).into_owned())
    }

    /// By how much to turn for what is missed.
    fn turn(&self, way: &Way<D>, end: &End<D>, most: f64) -> DVector<f64> {
        let missed =
            DVector::from_iterator(self.across.len(), self.across.iter().map(|u| dot(u, &end.across)));
        let missed = self.ends.transpose() * missed;
        let parts = DVector::from_fn(missed.len(), |i, _| {
            let sign = if self.has_passed(way, i) { -1.0 } else { 1.0 };
            sign * (missed[i] / self.sizes[i].max(f64::MIN_POSITIVE)).clamp(-most, most)
        });
        let turn = &self.turns * parts;
        let angle = turn.norm();
        if angle > most { turn * (most / angle) } else { turn }
    }
}

/// Unit vectors that are perpendicular to these two and to each other.
fn across<const D: usize>(to: [&[f64; D]; 2]) -> Vec<[f64; D]> {
    let mut found: Vec<[f64; D]> = Vec::new();
    for _ in 2..D {
        let clear = |mut axis: [f64; D]| {
            for _ in 0..2 {
                for known in to.into_iter().chain(&found) {
                    axis = add_scaled(&axis, -dot(known, &axis), known);
                }
            }
            axis
        };
        let axes = (0..D).map(|d| clear(std::array::from_fn(|i| f64::from(u8::from(i == d)))));
        let Some(best) = axes.max_by(|a, b| length(a).total_cmp(&length(b))) else { break };
        found.push(scaled(1.0 / length(&best), &best));
    }
    found
}
