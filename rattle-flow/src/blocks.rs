//! Triangles side by side: what the law is given of them, slopes, and the flux in each.

use crate::flow::Flow;
use crate::law::GIVEN;
use crate::mesh::signed_area;
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
    let corner = |i: usize| of_lane.map(|triangle| triangles[triangle][i]);
    let vertices: [[u32; L]; 3] = from_fn(corner);
    Block {
        vertices,
        given: from_fn(|k| Lanes(from_fn(|lane| given[lane][k]))),
        places: from_fn(|i| from_fn(|j| from_fn(|lane| matrix.place(vertices[i][lane], vertices[j][lane])))),
        count,
    }
}

/// What the law is given of a triangle.
fn given(flow: &Flow, triangle: usize) -> [f64; GIVEN] {
    let place = flow.mesh.corners(triangle);
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
    let bed = flow.mesh.triangles()[triangle].map(|vertex| flow.terrain[vertex as usize]);
    let rise = [bed[1] - bed[0], bed[2] - bed[0]];
    let numbers = grad.into_iter().chain(arm).flatten().chain(rise).chain([flow.mobility(triangle)]);
    let mut result = [0.0; GIVEN];
    result.iter_mut().zip(numbers).for_each(|(slot, number)| *slot = number);
    result
}

/// q in a triangle, by what flows along its edges: |T| q = Σ dₑ mₑ (xⱼ − xᵢ), as in law.rs but with the mean mₑ of hᵅ
/// in place of hᵅ upstream. With one m for all edges that is −c m p. Where hᵅ upstream is less than half the mean, or
/// nothing flows since the ground ahead is dry and higher, mₑ is twice what is carried.
pub(crate) fn flux_in(
    flow: &Flow,
    triangle: usize,
    given: &[f64; GIVEN],
    depth: &[f64],
    p: [f64; 2],
) -> [f64; 2] {
    let (place, area) = (flow.mesh.corners(triangle), signed_area(flow.mesh.corners(triangle)));
    let h = flow.mesh.triangles()[triangle].map(|vertex| depth[vertex as usize].max(0.0));
    let level = [h[0], given[12] + h[1], given[13] + h[2]];
    let carried = h.map(|h| h.powf(flow.resistance.power()));
    let mean = carried.iter().sum::<f64>() / 3.0;
    let mut q = [0.0; 2];
    for i in 0..3 {
        let j = (i + 1) % 3;
        let drive = -given[14] * (p[0] * given[6 + 2 * i] + p[1] * given[7 + 2 * i]);
        let (up, down) = if drive >= 0.0 { (i, j) } else { (j, i) };
        let closed = h[down] <= 0.0 && level[down] >= level[up];
        let flows = if closed { 0.0 } else { drive * mean.min(2.0 * carried[up]) };
        q = from_fn(|x| q[x] + flows * (place[j][x] - place[i][x]) / area);
    }
    q
}
