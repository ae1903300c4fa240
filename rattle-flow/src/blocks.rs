//! Triangles side by side: what the law is given of them, slopes, and the flux in each.

use crate::flow::Flow;
use crate::law::GIVEN;
use crate::plane::{signed_area, squared};
use crate::sparse::Sparse;
use rattle::lanes::Lanes;
use rattle::real::Real;
use std::array::from_fn;

/// So many triangles go side by side.
pub(crate) const L: usize = 8;
pub(crate) type Wide = Lanes<f64, L>;

/// Triangles side by side; the last ones of the last block are that triangle again, and not added.
pub(crate) struct Block {
    pub(crate) vertices: [[u32; L]; 3],
    pub(crate) given: [Wide; GIVEN],
    /// Places among the values of the matrix: row, column, lane.
    pub(crate) places: [[[u32; L]; 3]; 3],
    pub(crate) count: usize,
}

pub(crate) fn gather(block: &Block, depth: &[f64]) -> [Wide; 3] {
    block.vertices.map(|lanes| Lanes(lanes.map(|vertex| depth[vertex as usize])))
}

pub(crate) fn unknowns(block: &Block, depth: &[f64], slope: &[Wide; 2]) -> [Wide; 5] {
    let [a, b, c] = gather(block, depth);
    [a, b, c, slope[0], slope[1]]
}

/// ∇(b + h).
pub(crate) fn sloping(block: &Block, h: &[Wide; 3]) -> [Wide; 2] {
    let level = [h[0], h[1] + block.given[12], h[2] + block.given[13]];
    from_fn(|x| (0..3).fold(Wide::from_f64(0.0), |sum, i| sum + level[i] * block.given[2 * i + x]))
}

/// The root of the length.
pub(crate) fn root(slope: [Wide; 2]) -> Wide {
    (slope[0] * slope[0] + slope[1] * slope[1]).sqrt().sqrt()
}

/// p with |p| p = ∇(b + h).
pub(crate) fn slope_of(block: &Block, depth: &[f64]) -> [Wide; 2] {
    let slope = sloping(block, &gather(block, depth));
    let root = root(slope);
    let still = root.le(Wide::from_f64(0.0));
    slope.map(|x| Wide::select(still, Wide::from_f64(0.0), x / root))
}

pub(crate) fn block(flow: &Flow, matrix: &Sparse, first: usize) -> Block {
    let triangles = flow.mesh.triangles();
    let count = L.min(triangles.len() - first);
    let of_lane: [usize; L] = from_fn(|lane| (first + lane).min(triangles.len() - 1));
    let given = of_lane.map(|triangle| given(flow, triangle));
    let corner = |i: usize| of_lane.map(|triangle| triangles[triangle][corners(flow, triangle)[i]]);
    let vertices: [[u32; L]; 3] = from_fn(corner);
    Block {
        vertices,
        given: from_fn(|k| Lanes(from_fn(|lane| given[lane][k]))),
        places: from_fn(|i| from_fn(|j| from_fn(|lane| matrix.place(vertices[i][lane], vertices[j][lane])))),
        count,
    }
}

/// The corners of a triangle as the law has them: opposite to the longest side, where an angle may be obtuse, is the
/// last one.
fn corners(flow: &Flow, triangle: usize) -> [usize; 3] {
    let place = flow.mesh.corners(triangle);
    let side = |i: usize| squared(place[(i + 1) % 3], place[(i + 2) % 3]);
    let last = (0..3).fold(2, |last, i| if side(i) > side(last) { i } else { last });
    [(last + 1) % 3, (last + 2) % 3, last]
}

/// What the law is given of a triangle.
fn given(flow: &Flow, triangle: usize) -> [f64; GIVEN] {
    let corners = corners(flow, triangle);
    let place = corners.map(|i| flow.mesh.corners(triangle)[i]);
    let area = signed_area(place);
    let side = |i: usize, j: usize| [place[j][0] - place[i][0], place[j][1] - place[i][1]];
    // ∇φᵢ is the opposite side, turned by a quarter, over twice the area.
    let grad: [[f64; 2]; 3] = from_fn(|i| {
        let [x, y] = side((i + 1) % 3, (i + 2) % 3);
        [-y / (2.0 * area), x / (2.0 * area)]
    });
    let arm: [[f64; 2]; 3] = from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let (a, b) = (side(k, i), side(k, j));
        let weight = (a[0] * b[0] + a[1] * b[1]) / (4.0 * area); // ½ cot at k
        side(i, j).map(|x| weight * x)
    });
    let bed = corners.map(|i| flow.terrain[flow.mesh.triangles()[triangle][i] as usize]);
    let rise = [bed[1] - bed[0], bed[2] - bed[0]];
    let numbers = grad.into_iter().chain(arm).flatten().chain(rise).chain([flow.mobility(triangle)]);
    let mut result = [0.0; GIVEN];
    result.iter_mut().zip(numbers).for_each(|(slot, number)| *slot = number);
    result
}

/// q in a triangle, by what flows along its edges: |T| q = Σ dₑ mₑ (xⱼ − xᵢ), as in law.rs but with the mean mₑ of hᵅ
/// in place of what is carried. With one m for all edges that is −c m p. Where what is carried is less than half the
/// mean, mₑ is twice what is carried.
pub(crate) fn flux_in(
    flow: &Flow,
    triangle: usize,
    given: &[f64; GIVEN],
    depth: &[f64],
    p: [f64; 2],
) -> [f64; 2] {
    let (corners, area) = (corners(flow, triangle), signed_area(flow.mesh.corners(triangle)));
    let place = corners.map(|i| flow.mesh.corners(triangle)[i]);
    let h = corners.map(|i| depth[flow.mesh.triangles()[triangle][i] as usize].max(0.0));
    let of_depth = h.map(|h| h.powf(flow.resistance.power()));
    let mean = of_depth.iter().sum::<f64>() / 3.0;
    let obtuse = given[0] * given[2] + given[1] * given[3] > 0.0;
    let mut q = [0.0; 2];
    for i in 0..3 {
        let j = (i + 1) % 3;
        let drive = -given[14] * (p[0] * given[6 + 2 * i] + p[1] * given[7 + 2 * i]);
        let upstream = of_depth[if drive >= 0.0 { i } else { j }];
        let carried = if i == 0 && obtuse { of_depth.into_iter().fold(upstream, f64::min) } else { upstream };
        let flows = drive * mean.min(2.0 * carried);
        q = from_fn(|x| q[x] + flows * (place[j][x] - place[i][x]) / area);
    }
    q
}
