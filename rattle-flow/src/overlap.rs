//! Triangles that lie over each other, though they have no edge in common: by the boundary of the mesh.
//!
//! Where edges of the boundary cross, triangles do. Where none cross, all along a chain of edges equally many triangles
//! lie on its outer side: none, or it runs over others.

use crate::plane::{signed_area, squared};
use std::cell::LazyCell;
use std::collections::HashMap;

/// There are at most so many rows for each edge.
const ROWS: f64 = 4.0;

/// Two triangles, and where both are.
pub(crate) struct Over {
    pub(crate) triangles: [u32; 2],
    pub(crate) place: [f64; 2],
}

/// An edge of the boundary, with its number.
#[derive(Clone, Copy)]
struct Edge {
    number: usize,
    ends: [[f64; 2]; 2],
}

impl Edge {
    /// The same to the right by a quarter of a circle, which is exact.
    fn turned(&self) -> Self {
        Edge { number: self.number, ends: self.ends.map(|[x, y]| [y, -x]) }
    }

    fn middle(&self) -> [f64; 2] {
        let [a, b] = self.ends;
        [0, 1].map(|x| 0.5 * (a[x] + b[x]))
    }

    fn length(&self) -> f64 {
        squared(self.ends[0], self.ends[1]).sqrt()
    }

    /// Whether it goes up or down more than to a side.
    fn is_steep(&self) -> bool {
        let [a, b] = self.ends;
        (b[1] - a[1]).abs() >= (b[0] - a[0]).abs()
    }

    /// The least and the largest of a coordinate.
    fn range(&self, axis: usize) -> [f64; 2] {
        let [a, b] = self.ends.map(|end| end[axis]);
        [a.min(b), a.max(b)]
    }

    /// Where two edges cross, each from one side of the other to its other side.
    fn crossing(&self, other: &Edge) -> Option<[f64; 2]> {
        let sides = |[a, b]: [[f64; 2]; 2], of: [[f64; 2]; 2]| of.map(|end| signed_area([a, b, end]));
        let [a, b] = sides(self.ends, other.ends);
        let [c, d] = sides(other.ends, self.ends);
        let crosses = |a: f64, b: f64| a < 0.0 && b > 0.0 || a > 0.0 && b < 0.0;
        let s = a / (a - b);
        let [from, to] = other.ends;
        (crosses(a, b) && crosses(c, d)).then(|| [0, 1].map(|x| from[x] + s * (to[x] - from[x])))
    }
}

/// Edges by the rows that they are in, in each from the left. A row is as high as edges are long in the mean.
struct Rows {
    low: f64,
    height: f64,
    last: usize,
    rows: Vec<Vec<Edge>>,
}

impl Rows {
    fn of(edges: &[Edge]) -> Self {
        let mean = edges.iter().map(Edge::length).sum::<f64>() / edges.len() as f64;
        let ranges = edges.iter().map(|edge| edge.range(1));
        let [low, high] =
            ranges.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], [c, d]| [a.min(c), b.max(d)]);
        let most = ROWS * edges.len() as f64;
        let height = mean.max((high - low) / most);
        let mut rows = Rows { low, height, last: most as usize, rows: Vec::new() };
        rows.last = rows.row(high);
        rows.rows.resize_with(rows.last + 1, Vec::new);
        for edge in edges {
            let [first, last] = edge.range(1).map(|y| rows.row(y));
            rows.rows[first..=last].iter_mut().for_each(|row| row.push(*edge));
        }
        rows.rows.iter_mut().for_each(|row| row.sort_by(|a, b| a.range(0)[0].total_cmp(&b.range(0)[0])));
        rows
    }

    fn row(&self, y: f64) -> usize {
        (((y - self.low) / self.height) as usize).min(self.last)
    }

    /// Two edges that cross, and where.
    fn crossing(&self) -> Option<([usize; 2], [f64; 2])> {
        for row in &self.rows {
            for (i, edge) in row.iter().enumerate() {
                let ([_, right], [low, high]) = (edge.range(0), edge.range(1));
                for other in row[i + 1..].iter().take_while(|other| other.range(0)[0] <= right) {
                    let [bottom, top] = other.range(1);
                    if bottom <= high
                        && top >= low
                        && let Some(place) = edge.crossing(other)
                    {
                        return Some(([edge.number, other.number], place));
                    }
                }
            }
        }
        None
    }

    /// How many triangles lie on the outer side of a steep edge, beside its middle: what a ray to the right goes
    /// through.
    fn beyond(&self, edge: &Edge) -> i64 {
        let [[_, from], [_, to]] = edge.ends;
        let middle = edge.middle();
        let mut count = 0;
        for other in self.rows[self.row(middle[1])].iter().filter(|other| other.number != edge.number) {
            let [a, b] = other.ends;
            if (a[1] > middle[1]) != (b[1] > middle[1]) {
                let up = b[1] > a[1];
                // The mesh is on the left of its edges.
                if (signed_area([a, b, middle]) > 0.0) == up {
                    count += if up { 1 } else { -1 };
                }
            }
        }
        // The ray begins on the right of the edge: outside of a mesh whose edge goes up, inside where it goes down.
        if to > from { count } else { count - 1 }
    }
}

/// The boundary of a mesh, on which no vertex is on an edge that it does not belong to.
pub(crate) struct Boundary<'a> {
    pub(crate) points: &'a [[f64; 2]],
    pub(crate) triangles: &'a [[u32; 3]],
    pub(crate) edges: &'a [[u32; 2]],
    /// The triangle at each edge.
    pub(crate) at: &'a [u32],
}

impl Boundary<'_> {
    /// Where two triangles lie over each other.
    pub(crate) fn over(&self) -> Option<Over> {
        let ends = |edge: &[u32; 2]| edge.map(|vertex| self.points[vertex as usize]);
        let edges: Vec<Edge> =
            self.edges.iter().enumerate().map(|(number, edge)| Edge { number, ends: ends(edge) }).collect();
        if edges.is_empty() {
            return None;
        }
        let rows = Rows::of(&edges);
        if let Some((numbers, place)) = rows.crossing() {
            return Some(Over { triangles: numbers.map(|edge| self.at[edge]), place });
        }
        let turned = LazyCell::new(|| Rows::of(&edges.iter().map(Edge::turned).collect::<Vec<_>>()));
        for edge in longest(self.edges, &edges).into_iter().map(|number| &edges[number]) {
            let beyond = if edge.is_steep() { rows.beyond(edge) } else { turned.beyond(&edge.turned()) };
            if beyond == 0 {
                continue;
            }
            let (own, place) = (self.at[edge.number], edge.middle());
            let covers = |triangle: usize| {
                let [a, b, c] = self.triangles[triangle].map(|vertex| self.points[vertex as usize]);
                [[a, b], [b, c], [c, a]].into_iter().all(|[a, b]| signed_area([a, b, place]) >= 0.0)
            };
            let other = (0..self.triangles.len()).find(|&other| other != own as usize && covers(other));
            if let Some(other) = other {
                return Some(Over { triangles: [own, other as u32], place });
            }
        }
        None
    }
}

/// The longest edge of each chain of the boundary. Chains end where others go through a vertex too.
fn longest(boundary: &[[u32; 2]], edges: &[Edge]) -> Vec<usize> {
    let mut next: HashMap<u32, Option<usize>> = HashMap::with_capacity(boundary.len());
    for (number, [from, _]) in boundary.iter().enumerate() {
        next.entry(*from).and_modify(|next| *next = None).or_insert(Some(number));
    }
    let after = |vertex: u32| next.get(&vertex).copied().flatten();
    let mut seen = vec![false; boundary.len()];
    let mut chosen = Vec::new();
    let starts = (0..boundary.len()).filter(|&edge| after(boundary[edge][0]).is_none());
    for start in starts.chain(0..boundary.len()) {
        let (mut best, mut at) = (None, Some(start));
        while let Some(edge) = at.filter(|&edge| !std::mem::replace(&mut seen[edge], true)) {
            if best.is_none_or(|best: usize| edges[edge].length() > edges[best].length()) {
                best = Some(edge);
            }
            at = after(boundary[edge][1]);
        }
        chosen.extend(best);
    }
    chosen
}
