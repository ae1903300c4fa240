//! Random points on a surface g(q) = 0, for starts: uniform in area, spread evenly, or kept apart.
//!
//! A random line, uniform in direction and position, meets a piece of surface with a probability proportional to its
//! area, whatever its orientation (M. Crofton 1868). So of the k points in which a random line meets the surface one is
//! taken, with the probability k/K, K being an upper bound of k: this point is uniform in area, exactly, in any
//! dimension. No mesh and no parametrisation is needed. K is 4, or where one of 1000 other lines meets more points,
//! twice as many as any of these. Where a line meets more than K all begins again with twice of that; it is so rare
//! that nobody sees the difference.
//!
//! The longest line is divided into `CELLS` cells; the points are found where g or its slope along the line changes
//! sign in a cell. Two sheets nearer to each other than a cell can be missed.

use crate::kernel::functions::{Constraint, ConstraintKernel};
use crate::number::philox::{normal, philox, unit};
use crate::number::vector::{add_scaled, dot, scaled};
use nalgebra::SVector;
use std::array::from_fn;
use std::cell::Cell;

/// Cells of the longest line.
const CELLS: usize = 256;
/// Bisection of a cell to the last bit takes 45 steps, of a number near 0 more.
const HALVINGS: usize = 80;
/// A line is thought to meet the surface in no more points, unless one of so many lines does.
const MEETINGS: usize = 4;
const PILOTS: u64 = 1000;
/// Where those begin: none of them is a line that points are taken from.
const FIRST_PILOT: u64 = 1 << 63;
/// So many lines without a further point, and the search is given up.
const LINES: usize = 10_000;
/// What |g| may be at a zero, as part of what it is at the ends of its cell.
const ZERO: f64 = 1e-6;
/// Candidates for each point that is to be far from others.
const CANDIDATES: usize = 10;

/// Points on the surface g = 0 in the box from `low` to `high`, independent and uniform in area, the same for the same
/// seed.
///
/// The time is proportional to `number` times (size of the box)ᴰ⁻¹ / (area of the surface), which is the number of
/// lines for a point; each of them takes up to 256 evaluations of g. So the box should fit the surface: one that is
/// twice as wide takes four times as long in space, and finds thin sheets less well, since its cells are wider. Each
/// call begins with 1000 lines that tell how often a line meets the surface.
///
/// ```
/// use rattle::prelude::*;
/// use rattle::{curvature::points, surfaces::Sphere};
///
/// let sphere = Sphere { r: 1.0 };
/// let starts = points::uniform(&sphere, [-1.0; 3], [1.0; 3], 1000, 7)?;
/// let mean = starts.iter().map(|q| q.z).sum::<f64>() / 1000.0;
/// assert!(mean.abs() < 0.08); // 4.5 deviations
/// let gas = Scene::on(sphere).bodies(1000).simulate(State::of(starts), Rattle::new(0.01))?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`PointsError::Box`] for a box without volume; [`PointsError::NotMet`] where too few lines meet the surface.
#[doc(alias = "seed")]
#[doc(alias = "initial condition")]
#[doc(alias = "sample")]
#[doc(alias = "random")]
pub fn uniform<C: Constraint<D, 1>, const D: usize>(
    surface: &C,
    low: [f64; D],
    high: [f64; D],
    number: usize,
    seed: u64,
) -> Result<Vec<SVector<f64, D>>, PointsError> {
    Lines::new(surface, low, high)?.points(number, |line, k| random(seed, line, k), |_, _| true)
}

/// As [`uniform`], but spread more evenly than independent points: each point is, of ten random ones, the farthest from
/// all before (best candidates, D. Mitchell 1991). The time is proportional to `number` squared: a second for 10 000.
///
/// Averages over a hundred such points and more on a closed surface have errors that are two to four times smaller. At
/// edges where the box cuts a surface such points are denser: averages over 100 points on a square are off by some 5 %,
/// and nothing is gained there. Few points, ten on a torus, are farther out on average than its surface is.
///
/// # Errors
/// As [`uniform`].
#[doc(alias = "sample")]
#[doc(alias = "uniform")]
pub fn even<C: Constraint<D, 1>, const D: usize>(
    surface: &C,
    low: [f64; D],
    high: [f64; D],
    number: usize,
    seed: u64,
) -> Result<Vec<SVector<f64, D>>, PointsError> {
    let candidates = uniform(surface, low, high, CANDIDATES.saturating_mul(number), seed)?;
    let mut points: Vec<SVector<f64, D>> = Vec::new();
    for candidates in candidates.chunks_exact(CANDIDATES) {
        let room = |q: &SVector<f64, D>| {
            points.iter().map(|other| (q - other).norm_squared()).fold(f64::INFINITY, f64::min)
        };
        let rooms = candidates.iter().map(|q| (room(q), q));
        let farthest = rooms
            .fold((-1.0, candidates[0]), |best, (room, q)| if room > best.0 { (room, *q) } else { best });
        points.push(farthest.1);
    }
    Ok(points)
}

/// As [`uniform`], but no two points nearer than `distance` in space: a point too near to an earlier one is drawn again
/// (random sequential addition).
///
/// # Errors
/// As [`uniform`]; [`PointsError::Full`] where there is no space for another point.
#[doc(alias = "sample")]
#[doc(alias = "uniform")]
pub fn apart<C: Constraint<D, 1>, const D: usize>(
    surface: &C,
    low: [f64; D],
    high: [f64; D],
    number: usize,
    distance: f64,
    seed: u64,
) -> Result<Vec<SVector<f64, D>>, PointsError> {
    if !(distance >= 0.0 && distance.is_finite()) {
        return Err(PointsError::Distance(distance));
    }
    let near = Cell::new(false); // since the last point that was far from all
    let far = |q: &SVector<f64, D>, others: &[SVector<f64, D>]| {
        let far = others.iter().all(|other| (q - other).norm_squared() >= distance * distance);
        near.set(!far);
        far
    };
    Lines::new(surface, low, high)?.points(number, |line, k| random(seed, line, k), far).map_err(|error| {
        match error {
            PointsError::NotMet { found, lines, .. } if near.get() => {
                PointsError::Full { found, number, distance, lines }
            }
            error => error,
        }
    })
}

/// Why points on a surface could not be found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PointsError {
    /// A box that is empty, reversed or not finite.
    #[error("the box from {low:?} to {high:?} has no volume; every side must be finite and longer than 0")]
    Box {
        /// Its least coordinates.
        low: Vec<f64>,
        /// Its greatest coordinates.
        high: Vec<f64>,
    },
    /// A distance that is negative or not finite.
    #[error("a least distance is 0 or positive, and finite; found {0}")]
    Distance(f64),
    /// Too few lines meet the surface.
    #[error(
        "{lines} lines through the box met the surface in {found} points of {number}; try a box that fits the surface"
    )]
    NotMet {
        /// Points found.
        found: usize,
        /// Points wanted.
        number: usize,
        /// Lines tried.
        lines: usize,
    },
    /// There is no space for another point.
    #[error(
        "{found} points of {number} are on the surface at a distance of {distance:e}, and {lines} lines found no room for more; try a smaller distance"
    )]
    Full {
        /// Points found.
        found: usize,
        /// Points wanted.
        number: usize,
        /// The least distance.
        distance: f64,
        /// Lines tried.
        lines: usize,
    },
}

/// Four words of a line.
fn random(seed: u64, line: u64, four: u64) -> [u64; 4] {
    philox([seed, 1], [line, four, 0, 0])
}

/// Random lines through the ball around a box.
struct Lines<K, const D: usize> {
    kernel: K,
    low: [f64; D],
    high: [f64; D],
    centre: [f64; D],
    radius: f64,
}

impl<K: ConstraintKernel<f64, D, 1>, const D: usize> Lines<K, D> {
    fn new<C: Constraint<D, 1, Kernel<f64> = K>>(
        surface: &C,
        low: [f64; D],
        high: [f64; D],
    ) -> Result<Self, PointsError> {
        let side: [f64; D] = from_fn(|d| high[d] - low[d]);
        if !side.iter().all(|&side| side > 0.0 && side.is_finite()) {
            return Err(PointsError::Box { low: low.to_vec(), high: high.to_vec() });
        }
        let centre = from_fn(|d| low[d] + 0.5 * side[d]);
        let radius = 0.5 * dot(&side, &side).sqrt() * (1.0 + 1e-9);
        Ok(Self { kernel: surface.kernel::<f64>(), low, high, centre, radius })
    }

    /// So many points that `fits` takes, from lines whose words are `source(line, four)`.
    fn points(
        &self,
        number: usize,
        source: impl Fn(u64, u64) -> [u64; 4],
        fits: impl Fn(&SVector<f64, D>, &[SVector<f64, D>]) -> bool,
    ) -> Result<Vec<SVector<f64, D>>, PointsError> {
        let mut meetings = Vec::new();
        let mut most = MEETINGS;
        for pilot in FIRST_PILOT..FIRST_PILOT + PILOTS {
            self.meet(|four| source(pilot, four), &mut meetings);
            if meetings.len() > MEETINGS {
                most = most.max(2 * meetings.len());
            }
        }
        'anew: loop {
            let (mut points, mut since) = (Vec::new(), 0);
            let mut line = 0;
            while points.len() < number {
                if since >= LINES {
                    let (found, lines) = (points.len(), usize::try_from(line).unwrap_or(usize::MAX));
                    return Err(PointsError::NotMet { found, number, lines });
                }
                let chosen = self.meet(|four| source(line, four), &mut meetings);
                line += 1;
                since += 1;
                if meetings.len() > most {
                    // All again with more in mind, so that chances stay those of the area.
                    most = 2 * meetings.len();
                    continue 'anew;
                }
                let place = (chosen * most as f64) as usize;
                if let Some(q) = meetings.get(place).map(|&q| SVector::from(q))
                    && fits(&q, &points)
                {
                    points.push(q);
                    since = 0;
                }
            }
            return Ok(points);
        }
    }

    /// Writes the points in the box where a line meets the surface; returns a number in [0, 1) to choose by.
    fn meet(&self, words: impl Fn(u64) -> [u64; 4], meetings: &mut Vec<[f64; D]>) -> f64 {
        let vector = |first: u64| -> [f64; D] {
            let fours = (first..).flat_map(|four| normal(words(four)));
            let mut numbers = fours.take(D);
            from_fn(|_| numbers.next().unwrap_or(0.0))
        };
        let fours = D.div_ceil(4) as u64;
        let direction = vector(1);
        let along = scaled(1.0 / dot(&direction, &direction).sqrt(), &direction);
        let across = vector(1 + fours);
        let across = add_scaled(&across, -dot(&across, &along), &along);
        let [chosen, far, ..] = words(0).map(unit);
        // Uniform in the ball of D − 1 dimensions across the line.
        let distance = self.radius * far.powf(1.0 / (D as f64 - 1.0).max(1.0));
        let length = dot(&across, &across).sqrt();
        let foot = if D > 1 { add_scaled(&self.centre, distance / length, &across) } else { self.centre };
        let half = (self.radius * self.radius - distance * distance).max(0.0).sqrt();
        let half = if D > 1 { half } else { self.radius };

        meetings.clear();
        let at = |s: f64| add_scaled(&foot, s, &along);
        let value = |s: f64| self.kernel.value(&at(s))[0];
        let both = |s: f64| {
            let ([value], [gradient]) = self.kernel.value_and_jacobian(&at(s));
            [value, dot(&gradient, &along)]
        };
        let cells = ((CELLS as f64 * half / self.radius).ceil() as usize).max(4);
        let mut take = |from: f64, to: f64| {
            let place = root(value, from, to);
            let q = at(place);
            // A pole, a jump, or the edge of where g is a number, is no zero.
            let zero = value(place).abs() <= ZERO * value(from).abs().max(value(to).abs());
            if !zero {
                return;
            }
            if (0..D).all(|d| self.low[d] <= q[d] && q[d] <= self.high[d]) {
                meetings.push(q);
            }
        };
        let place = |cell: usize| -half + 2.0 * half * (cell as f64 / cells as f64);
        let [first, last] = self.inside(&foot, &along).map(|s| (s + half) / (2.0 * half) * cells as f64);
        // One cell more at either end, for rounding; a number that is NaN or negative is 0.
        let (first, last) = (((first - 1.0) as usize).min(cells), ((last + 2.0) as usize).min(cells));
        let mut before = (place(first), both(place(first)));
        for cell in first + 1..=last {
            let now = (place(cell), both(place(cell)));
            let ((from, [g, slope]), (to, [g2, slope2])) = (before, now);
            if (g < 0.0) != (g2 < 0.0) {
                take(from, to);
            } else if g * slope < 0.0 && g2 * slope2 > 0.0 {
                // Towards zero and away again: perhaps through it twice.
                let turn = root(|s| both(s)[1], from, to);
                if (value(turn) < 0.0) != (g < 0.0) {
                    take(from, turn);
                    take(turn, to);
                }
            }
            before = now;
        }
        1.0 - chosen
    }

    /// From where to where a line is in the box; the first is the larger one where it is not.
    fn inside(&self, foot: &[f64; D], along: &[f64; D]) -> [f64; 2] {
        (0..D).fold([f64::NEG_INFINITY, f64::INFINITY], |[first, last], d| {
            let ends = [self.low[d], self.high[d]].map(|end| (end - foot[d]) / along[d]);
            // Of a line along this side both are infinite: of one sign where it is beyond the box.
            [first.max(ends[0].min(ends[1])), last.min(ends[0].max(ends[1]))]
        })
    }
}

/// Where f changes sign between two places, to the last bit.
fn root(f: impl Fn(f64) -> f64, mut from: f64, mut to: f64) -> f64 {
    let negative = f(from) < 0.0;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (from + to);
        if middle == from || middle == to {
            break;
        }
        *(if (f(middle) < 0.0) == negative { &mut from } else { &mut to }) = middle;
    }
    if f(from).abs() <= f(to).abs() { from } else { to }
}
