//! A way along a surface between two places where none is known: the shortest one through a graph of points of the
//! surface, drawn tight.
//!
//! Points are those of an even sequence in a box (M. Roberts 2018, after R. Kronecker), brought onto the surface along
//! its gradient. Neighbours are joined where a straight line between them stays near the surface, or where lines from
//! both to the point of the surface near its middle do; short lines also over edges. The shortest way is E. Dijkstra's
//! (1959). It is drawn tight by moving each of its points to the middle of its neighbours, and back onto the surface,
//! first with few points and then with more: the discrete form of curve shortening.

use crate::kernel::functions::ConstraintKernel;
use crate::kernel::geodesic::{length, normal};
use crate::kernel::kinks::sign_changes;
use crate::number::vector::{add_scaled, dot, scaled, sum};
use std::array::from_fn;
use std::iter::successors;

/// Points in a box, for each dimension of the surface.
const POINTS: usize = 300;
/// Neighbours of a point that are tried.
const NEIGHBOURS: usize = 16;
/// Half the sides of the boxes that are tried, as multiples of the straight distance.
const BOXES: [f64; 4] = [0.8, 1.6, 4.0, 12.0];
/// Ways that are drawn tight, and how much longer than the shortest one they may be, since lines are crooked; what part
/// of a way is its plateau.
const ROUGH: usize = 16;
const LONGER: f64 = 1.3;
const PLATEAU: f64 = 0.15;
/// Ways that are given. Those whose lengths differ by no more than this part are the same.
const WAYS: usize = 3;
const SAME: f64 = 1e-3;
/// A line of length c between points stays near the surface if its normals have no less than this cosine …
const ALIKE: f64 = 0.7;
/// … and it is no steeper than this against the surface, and in its middle no farther off than this times c.
const STEEP: f64 = 0.4;
/// A line is divided no more often. What is left then may lead over an edge …
const DIVISIONS: u32 = 6;
/// … if the normals on both sides have no less than this cosine: two sides of a thin plate are not near.
const FOLDED: f64 = -0.5;
/// Pieces of a way when it is drawn tight, at first and in the end.
const PIECES: [usize; 3] = [24, 48, 96];
/// How often each of its points is moved, for each number of pieces.
const SWEEPS: usize = 120;
/// By how much farther than to the middle.
const BEYOND: f64 = 1.6;

/// A point of the surface, and its unit normal.
#[derive(Clone, Copy)]
struct Point<const D: usize> {
    q: [f64; D],
    normal: [f64; D],
}

/// Ways on the surface from a to b, each near a short geodesic, and of points about evenly apart: those that may lead
/// to the shortest one, as far as the points of the graph tell. None where none is found.
pub(super) fn detours<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    kernel: &K,
    a: &[f64; D],
    b: &[f64; D],
) -> Vec<Vec<[f64; D]>> {
    let straight = apart(a, b);
    let middle = scaled(0.5, &sum(a, b));
    let ends = [*a, *b].map(|q| Point::at(kernel, q));
    let ways = |half: f64| Graph::new(kernel, ends, &middle, half).ways();
    for half in BOXES.map(|share| share * straight) {
        let (mut found, shortest) = ways(half);
        if found.is_empty() {
            continue;
        }
        // No way of this length leaves the box of its half.
        if 0.5 * shortest > half {
            (found, _) = ways(0.5 * shortest);
        }
        let mut drawn: Vec<_> = found.iter().filter_map(|way| tight(kernel, way, PIECES[0])).collect();
        drawn.sort_by(|a, b| a.1.total_cmp(&b.1));
        drawn.dedup_by(|a, b| a.1 <= b.1 * (1.0 + SAME));
        drawn.truncate(WAYS);
        // Over an edge finer ones may not be found.
        let finer = |(way, _): (Vec<[f64; D]>, f64)| {
            PIECES[1..].iter().fold(way, |way, &n| tight(kernel, &way, n).map_or(way, |finer| finer.0))
        };
        let ways: Vec<_> = drawn.into_iter().map(finer).collect();
        if !ways.is_empty() {
            return ways;
        }
    }
    Vec::new()
}

impl<const D: usize> Point<D> {
    fn at<K: ConstraintKernel<f64, D, 1>>(kernel: &K, q: [f64; D]) -> Self {
        Self { q, normal: normal(kernel, &q) }
    }

    /// The point to which the gradient leads, if it is no farther away than `reach`.
    fn near<K: ConstraintKernel<f64, D, 1>>(kernel: &K, from: &[f64; D], reach: f64) -> Option<Self> {
        let mut q = *from;
        for _ in 0..30 {
            let ([g], [gradient]) = kernel.value_and_jacobian(&q);
            let square = dot(&gradient, &gradient);
            let off = g / square * square.sqrt();
            let share = (reach / off.abs()).min(1.0); // not all at once where the gradient is small
            q = add_scaled(&q, -share * g / square, &gradient);
            let away = apart(&q, from);
            if away > 2.0 * reach || away.is_nan() {
                return None;
            }
            if off.abs() <= 1e-9 * reach {
                return (away <= reach).then(|| Self::at(kernel, q));
            }
        }
        None
    }
}

/// Points of the surface, those of the ends before the others, and which are joined by lines of which lengths.
struct Graph<'a, K, const D: usize> {
    kernel: &'a K,
    points: Vec<Point<D>>,
    joined: Vec<Vec<(usize, f64)>>,
}

impl<'a, K: ConstraintKernel<f64, D, 1>, const D: usize> Graph<'a, K, D> {
    fn new(kernel: &'a K, ends: [Point<D>; 2], middle: &[f64; D], half: f64) -> Self {
        let mut points = ends.to_vec();
        // The root of φᴰ⁺¹ = φ + 1: the golden ratio in one dimension.
        let phi = (0..40).fold(1.5_f64, |phi, _| (1.0 + phi).powf(1.0 / (D as f64 + 1.0)));
        for n in 1..=POINTS * D.saturating_sub(1).clamp(1, 4) {
            let place = |d: usize| {
                let share = (0.5 + n as f64 / phi.powi(d as i32 + 1)).fract();
                middle[d] + half * (2.0 * share - 1.0)
            };
            points.extend(Point::near(kernel, &from_fn(place), half));
        }
        let mut graph = Self { kernel, joined: vec![Vec::new(); points.len()], points };
        let mut near = Vec::new();
        for i in 0..graph.points.len() {
            near.clear();
            let away = |j: usize| (apart(&graph.points[i].q, &graph.points[j].q), j);
            near.extend((0..graph.points.len()).filter(|&j| j != i).map(away));
            if near.len() > NEIGHBOURS {
                near.select_nth_unstable_by(NEIGHBOURS, |a, b| a.0.total_cmp(&b.0));
                near.truncate(NEIGHBOURS);
            }
            for &(_, j) in &near {
                if !graph.joined[i].iter().any(|&(other, _)| other == j)
                    && let Some(length) = graph.join(i, j, &mut |_| {})
                {
                    graph.joined[i].push((j, length));
                    graph.joined[j].push((i, length));
                }
            }
        }
        graph
    }

    /// Ways from the first point to the second, and the length of the shortest one: that one, and others of which a
    /// good part is on shortest ways from both ends, its plateau (Cambridge Vehicle Information Technology, 2005).
    fn ways(&self) -> (Vec<Vec<[f64; D]>>, f64) {
        let [(ahead, before), (back, after)] = [0, 1].map(|end| self.lengths(end));
        let shortest = ahead[1];
        if shortest == f64::INFINITY {
            return (Vec::new(), shortest);
        }
        let goes_on = |i: usize| i != 1 && before[after[i]] == i;
        let mut plateaus = Vec::new();
        for first in 0..self.points.len() {
            let whole = ahead[first] + back[first];
            let goes_through = first != 0 && after[before[first]] == first;
            if goes_through || whole > LONGER * shortest {
                continue;
            }
            let mut last = first;
            while goes_on(last) {
                last = after[last];
            }
            if ahead[last] - ahead[first] >= PLATEAU * shortest {
                plateaus.push((whole, first));
            }
        }
        plateaus.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let way_through = |middle: usize| {
            let mut way: Vec<usize> =
                successors(Some(middle), |&i| (i != 0).then(|| before[i])).skip(1).collect();
            way.reverse();
            way.extend(successors(Some(middle), |&i| (i != 1).then(|| after[i])));
            self.places(&way)
        };
        (plateaus.into_iter().take(ROUGH).filter_map(|(_, first)| way_through(first)).collect(), shortest)
    }

    /// The length of the shortest way to each point from one of them, and the point before it on that way.
    fn lengths(&self, from: usize) -> (Vec<f64>, Vec<usize>) {
        let number = self.points.len();
        let (mut length, mut before) = (vec![f64::INFINITY; number], vec![from; number]);
        let mut open: Vec<usize> = (0..number).collect();
        length[from] = 0.0;
        let nearest = |open: &[usize], length: &[f64]| {
            (0..open.len()).min_by(|&i, &j| length[open[i]].total_cmp(&length[open[j]]))
        };
        while let Some(place) = nearest(&open, &length) {
            let now = open.swap_remove(place);
            for &(other, way) in &self.joined[now] {
                if length[now] + way < length[other] {
                    (length[other], before[other]) = (length[now] + way, now);
                }
            }
        }
        (length, before)
    }

    /// The places of a way through these points.
    fn places(&self, way: &[usize]) -> Option<Vec<[f64; D]>> {
        let mut places = vec![self.points[way[0]].q];
        for pair in way.windows(2) {
            self.join(pair[0], pair[1], &mut |q| places.push(*q))?;
        }
        Some(places)
    }

    /// The length of a way between two neighbours along the surface; `then` is told its places after the first.
    fn join(&self, from: usize, to: usize, then: &mut impl FnMut(&[f64; D])) -> Option<f64> {
        line(self.kernel, &self.points[from], &self.points[to], DIVISIONS, then)
    }
}

/// A line from one point to another, divided where it would leave the surface.
fn line<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    kernel: &K,
    from: &Point<D>,
    to: &Point<D>,
    divisions: u32,
    then: &mut impl FnMut(&[f64; D]),
) -> Option<f64> {
    let chord = add_scaled(&to.q, -1.0, &from.q);
    let length = dot(&chord, &chord).sqrt();
    let half = scaled(0.5, &sum(&from.q, &to.q));
    let middle = Point::near(kernel, &half, 1.5 * length)?;
    let flat = |n: &[f64; D]| dot(n, &chord).abs() <= STEEP * length;
    let alike = |a: &Point<D>, b: &Point<D>| dot(&a.normal, &b.normal) >= ALIKE;
    let close = apart(&middle.q, &half) <= STEEP * length;
    if close && flat(&from.normal) && flat(&to.normal) && alike(from, &middle) && alike(&middle, to) {
        then(&to.q);
        return Some(length);
    }
    if divisions == 0 {
        let folded = dot(&from.normal, &to.normal) < FOLDED;
        if folded || !close || !sign_changes(kernel, &[from.q], &[to.q]) {
            return None;
        }
        then(&middle.q);
        then(&to.q);
        return Some(apart(&from.q, &middle.q) + apart(&middle.q, &to.q));
    }
    let first = line(kernel, from, &middle, divisions - 1, then)?;
    Some(first + line(kernel, &middle, to, divisions - 1, then)?)
}

/// A way drawn tight, in so many pieces or more, and its length.
fn tight<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    kernel: &K,
    way: &[[f64; D]],
    pieces: usize,
) -> Option<(Vec<[f64; D]>, f64)> {
    let mut way = divided(kernel, way, pieces.max(way.len()))?;
    for _ in 0..SWEEPS {
        for i in 1..way.len() - 1 {
            let [before, now, after] = [way[i - 1], way[i], way[i + 1]];
            let middle = scaled(0.5, &sum(&before, &after));
            let towards = add_scaled(&now, BEYOND, &add_scaled(&middle, -1.0, &now));
            let reach = apart(&before, &now) + apart(&now, &after);
            way[i] = Point::near(kernel, &towards, reach)?.q;
        }
    }
    let length = way.windows(2).map(|pair| apart(&pair[0], &pair[1])).sum();
    Some((way, length))
}

/// The same way in pieces that are about equally long.
fn divided<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    kernel: &K,
    way: &[[f64; D]],
    pieces: usize,
) -> Option<Vec<[f64; D]>> {
    let whole: f64 = way.windows(2).map(|pair| apart(&pair[0], &pair[1])).sum();
    let piece = whole / pieces as f64;
    let (mut places, mut gone) = (vec![way[0]], 0.0);
    for pair in way.windows(2) {
        let long = apart(&pair[0], &pair[1]);
        while places.len() < pieces && piece * places.len() as f64 <= gone + long {
            let share = (piece * places.len() as f64 - gone) / long;
            let place = add_scaled(&pair[0], share, &add_scaled(&pair[1], -1.0, &pair[0]));
            places.push(Point::near(kernel, &place, long)?.q);
        }
        gone += long;
    }
    places.push(*way.last()?);
    Some(places)
}

/// |a − b|.
fn apart<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    length(&add_scaled(a, -1.0, b))
}
