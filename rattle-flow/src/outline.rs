//! The outline of a polygon: its sides, divided, and where they meet though they should not.

use crate::error::MeshError;
use crate::plane::{signed_area, squared};
use std::collections::HashMap;

/// The sides of a polygon, divided evenly. From each point a part of a side leads to the next.
pub(crate) struct Outline {
    pub(crate) points: Vec<[f64; 2]>,
    /// The side on which the part from each point is, by the number of the corner where it begins.
    sides: Vec<usize>,
}

impl Outline {
    /// Of corners that have these numbers, and coordinates rounded by so much.
    pub(crate) fn of(corners: &[[f64; 2]], named: &[usize], spacing: f64, rounded: f64) -> Self {
        let (mut points, mut sides) = (Vec::new(), Vec::new());
        for (i, &a) in corners.iter().enumerate() {
            let b = corners[(i + 1) % corners.len()];
            let slack = 1e-9 + 4.0 * rounded / spacing;
            let parts = (squared(a, b).sqrt() / spacing - slack).ceil().max(1.0) as usize;
            for k in 0..parts {
                let s = k as f64 / parts as f64;
                points.push([a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])]);
                sides.push(named[i]);
            }
        }
        Outline { points, sides }
    }

    pub(crate) fn next(&self, point: usize) -> usize {
        (point + 1) % self.points.len()
    }

    /// The part between two points, whichever is first.
    pub(crate) fn part(&self, [one, other]: [usize; 2]) -> usize {
        if self.next(one) == other { one } else { other }
    }

    /// An error where two points are one.
    pub(crate) fn distinct(&self) -> Result<(), MeshError> {
        let mut at = HashMap::with_capacity(self.points.len());
        for (point, &[x, y]) in self.points.iter().enumerate() {
            let bits = [x + 0.0, y + 0.0].map(f64::to_bits); // −0 is 0
            if let Some(first) = at.insert(bits, point) {
                let [first, second] = [first, point].map(|point| self.sides[point]);
                return Err(MeshError::SidesMeet { first, second, x, y });
            }
        }
        Ok(())
    }

    /// The error that tells which other part this one meets: the nearest.
    pub(crate) fn meeting(&self, part: usize) -> MeshError {
        self.nearest_to(part).1
    }

    /// The same for the parts at the corners of a flat triangle, if it has such corners.
    pub(crate) fn nearest(&self, corners: [u32; 3]) -> Option<MeshError> {
        let points = corners.into_iter().map(|corner| corner as usize).filter(|&p| p < self.points.len());
        let parts = points.flat_map(|point| [point, (point + self.points.len() - 1) % self.points.len()]);
        let meetings = parts.map(|part| self.nearest_to(part));
        meetings.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, error)| error)
    }

    fn nearest_to(&self, part: usize) -> (f64, MeshError) {
        let (mut nearest, mut other, mut place) = (f64::INFINITY, part, self.points[part]);
        for own in (0..self.points.len()).filter(|&own| own != part) {
            let (away, at) = self.apart(part, own);
            if away < nearest {
                (nearest, other, place) = (away, own, at);
            }
        }
        let (first, second) = (self.sides[part.min(other)], self.sides[part.max(other)]);
        (nearest, MeshError::SidesMeet { first, second, x: place[0], y: place[1] })
    }

    /// How far two parts are apart, and where. Of a point that both have nothing is said.
    fn apart(&self, part: usize, other: usize) -> (f64, [f64; 2]) {
        let numbers = [part, other].map(|part| [part, self.next(part)]);
        let [one, two] = numbers.map(|ends| ends.map(|point| self.points[point]));
        let side = |line: [[f64; 2]; 2], point| signed_area([line[0], line[1], point]);
        let (a, b) = (side(one, two[0]), side(one, two[1]));
        if a * b < 0.0 && side(two, one[0]) * side(two, one[1]) < 0.0 {
            let s = a / (a - b);
            return (0.0, [0, 1].map(|x| two[0][x] + s * (two[1][x] - two[0][x])));
        }
        let mut nearest = (f64::INFINITY, one[0]);
        for (line, [ends, others]) in [(one, [numbers[1], numbers[0]]), (two, numbers)] {
            for end in ends.into_iter().filter(|end| !others.contains(end)) {
                let found = to_segment(self.points[end], line);
                nearest = if found.0 < nearest.0 { found } else { nearest };
            }
        }
        nearest
    }
}

/// How far a point is from a segment of a line, and the nearest point there.
pub(crate) fn to_segment(point: [f64; 2], [a, b]: [[f64; 2]; 2]) -> (f64, [f64; 2]) {
    let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    let s = (((point[0] - a[0]) * dx + (point[1] - a[1]) * dy) / squared(a, b)).clamp(0.0, 1.0);
    let nearest = [a[0] + s * dx, a[1] + s * dy];
    (squared(point, nearest).sqrt(), nearest)
}
