//! Long curves with few points, and curves that lie on each other.
//!
//! ```text
//! many points in one column of pixels   ─▶  the first, the lowest, the highest and the last (Jugel & al. 2014): the same picture
//! a curve that runs along an earlier one ─▶  dashes, through which the other shows
//! ```

type Place = (f64, f64);

/// Columns for each pixel: half a pixel is the width of the finest line.
const COLUMNS: f64 = 2.0;
/// Nearer, in pixels, lines hide each other.
const NEAR: f64 = 1.0;

/// The same picture with at most four points in a column; curves that do not run from left to right stay as they are.
pub(super) fn thinned(points: Vec<Place>) -> Vec<Place> {
    let to_the_right = points.windows(2).all(|pair| pair[0].0 <= pair[1].0);
    let column = |place: &Place| (COLUMNS * place.0).floor();
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return points };
    if !to_the_right || (points.len() as f64) < 8.0 * (column(last) - column(first) + 1.0) {
        return points;
    }
    let mut thin = Vec::new();
    for column in points.chunk_by(|a, b| column(a) == column(b)) {
        let by_height = |a: &&Place, b: &&Place| a.1.total_cmp(&b.1);
        let ends =
            [column.first(), column.last(), column.iter().min_by(by_height), column.iter().max_by(by_height)];
        let mut ends: Vec<&Place> = ends.into_iter().flatten().collect();
        ends.sort_by_key(|place| std::ptr::from_ref(*place)); // in the order of the curve
        ends.dedup();
        thin.extend(ends);
    }
    thin
}

/// Whether most of the curve lies on the other one.
pub(super) fn hidden(curve: &[Place], below: &[Place]) -> bool {
    let rising = below.is_sorted_by(|a, b| a.0 <= b.0);
    let alike = curve.len() == below.len();
    let near = |(i, &place): (usize, &Place)| {
        let under = if rising { at(place.0, below) } else { below.get(i).copied().filter(|_| alike) };
        under.is_some_and(|(x, y)| (x - place.0).abs() < NEAR && (y - place.1).abs() < NEAR)
    };
    2 * curve.iter().enumerate().filter(|&point| near(point)).count() > curve.len()
}

/// The point of a line that runs from left to right, so far to the right.
fn at(x: f64, line: &[Place]) -> Option<Place> {
    let after = line.partition_point(|place| place.0 < x);
    let b = *line.get(after)?;
    let a = *line.get(after.checked_sub(1).unwrap_or(after))?;
    let part = if a.0 < b.0 { (x - a.0) / (b.0 - a.0) } else { 1.0 };
    Some((a.0 + part * (b.0 - a.0), a.1 + part * (b.1 - a.1)))
}
