//! The geodesic between two points of a surface g = 0, by shooting.
//!
//! ```text
//! q̈ = −(vᵀ∇²g v) ∇g/|∇g|²,   q(0) = a,   q̇(0) = v along the surface        q(1) = b for the v sought, |v| the distance
//! ```
//!
//! The motion is computed by extrapolation of the modified midpoint rule (W. Gragg 1965; R. Bulirsch, J. Stoer 1966),
//! as a displacement from a, so that short geodesics have as many digits as long ones. The first v has the direction of
//! the chord and the length of the [expansion](crate::effect::along). The error at b, rotated back to a by the smallest
//! rotation between the normals, corrects v, with Broyden's secant method through all tries (C. G. Broyden 1965).

use crate::kernel::functions::ConstraintKernel;
use crate::number::vector::{add_scaled, dot, largest, scaled, sum};

/// Divisions of a stretch, of which the motion is extrapolated.
const DIVISIONS: [u32; 9] = [2, 4, 6, 8, 10, 12, 14, 16, 18];
/// What one division more may change, as part of the way: what is left then is far smaller.
const CLOSE: f64 = 1e-13;
/// A stretch is halved no more often.
const MOST_HALVINGS: u32 = 12;
/// Tries of v.
const MOST_TRIES: usize = 60;
/// A correction is halved so often where it does not lead nearer.
const SHORTER: usize = 8;
/// What may be missed in the end, as part of the coordinates and the way, where nothing leads nearer.
const MISSED: f64 = 1e-12;

/// A geodesic from a to b.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shot<const D: usize> {
    /// Its length.
    pub(crate) distance: f64,
    /// Its direction at a, a unit vector of the tangent space.
    pub(crate) from: [f64; D],
    /// Its direction at b.
    pub(crate) to: [f64; D],
}

/// Why there is no geodesic.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Missed {
    /// What was missed at b, by the best try.
    pub(crate) by: f64,
    /// Its length.
    pub(crate) length: f64,
    /// Tries.
    pub(crate) tries: usize,
}

/// The geodesic from `a` along the way `chord` to a + chord, both on the surface; zero vectors where they are one.
pub(crate) fn shoot<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    kernel: &K,
    a: &[f64; D],
    chord: &[f64; D],
) -> Result<Shot<D>, Missed> {
    let (straight, b) = (length(chord), sum(a, chord));
    if straight == 0.0 {
        return Ok(Shot { distance: 0.0, from: [0.0; D], to: [0.0; D] });
    }
    let (here, there) = (normal(kernel, a), normal(kernel, &b));
    let lost = |by: f64, length: f64, tries| Missed { by, length, tries };
    let along = add_scaled(chord, -dot(chord, &here), &here);
    let first = (straight * straight - dot(&here, chord) * dot(&there, chord) / 3.0).max(straight * straight);
    let mut v = scaled(first.sqrt() / length(&along), &along);
    let floor = 4.0 * f64::EPSILON * (largest(a).max(largest(&b)) + straight);

    // What v changes by for what is missed.
    let mut answer: [[f64; D]; D] =
        std::array::from_fn(|i| std::array::from_fn(|k| f64::from(u8::from(i == k))));
    let look = |v: &[f64; D]| {
        let (way, speed) = fly(kernel, a, v)?;
        let miss = add_scaled(chord, -1.0, &way);
        // What of it is along the surface at b, back to a.
        let along = add_scaled(&miss, -dot(&there, &miss), &there);
        let share = dot(&here, &along) / (1.0 + dot(&here, &there));
        let back = add_scaled(&along, -share, &sum(&here, &there));
        let tangent = add_scaled(&back, -dot(&here, &back), &here);
        Some((miss, tangent, speed))
    };
    let Some(mut now) = look(&v) else { return Err(lost(f64::INFINITY, length(&v), 1)) };
    for tries in 1..MOST_TRIES {
        let by = length(&now.0).min(length(&now.1));
        if length(&now.1) <= floor && length(&now.0) <= 1e-6 * straight + floor {
            return Ok(shot(&v, &now));
        }
        let mut step: [f64; D] = std::array::from_fn(|i| dot(&answer[i], &now.1));
        let mut next = None;
        for _ in 0..SHORTER {
            let tried = sum(&v, &step);
            let found = look(&tried);
            if let Some(found) = found {
                // vᵢ answers to what is missed as by the last step.
                let change = add_scaled(&found.1, -1.0, &now.1);
                let told: [f64; D] = std::array::from_fn(|i| dot(&answer[i], &change));
                let against: [f64; D] =
                    std::array::from_fn(|k| (0..D).map(|i| step[i] * answer[i][k]).sum::<f64>());
                let product = dot(&step, &told);
                if product.abs() > 1e-8 * dot(&step, &step) {
                    for i in 0..D {
                        answer[i] = add_scaled(&answer[i], -(step[i] + told[i]) / product, &against);
                    }
                }
                if length(&found.1) < length(&now.1) {
                    next = Some((tried, found));
                    break;
                }
            }
            step = scaled(0.5, &step);
        }
        match next {
            Some((better, found)) => (v, now) = (better, found),
            None if by <= MISSED * (largest(a).max(largest(&b)) + straight) => return Ok(shot(&v, &now)),
            None => return Err(lost(by, length(&v), tries + 1)),
        }
    }
    Err(lost(length(&now.1), length(&v), MOST_TRIES))
}

/// The geodesic of a try: what it missed along its way belongs to its length, by the first variation.
fn shot<const D: usize>(v: &[f64; D], (miss, _, speed): &([f64; D], [f64; D], [f64; D])) -> Shot<D> {
    let unit = |v: &[f64; D]| scaled(1.0 / length(v), v);
    let (from, to) = (unit(v), unit(speed));
    Shot { distance: length(v) + dot(&to, miss), from, to }
}

/// Where the motion from a with the velocity v has come to at time 1, as a way from a, and its velocity there; none
/// where it is not found.
fn fly<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    kernel: &K,
    a: &[f64; D],
    v: &[f64; D],
) -> Option<([f64; D], [f64; D])> {
    let (mut time, mut h, mut now) = (0.0, 1.0, ([0.0; D], *v));
    let close = CLOSE * length(v);
    let mut halvings = 0;
    while time < 1.0 {
        if let Some(then) = stretch(kernel, a, &now, h, close) {
            (time, now) = (time + h, then);
        } else if halvings < MOST_HALVINGS {
            (h, halvings) = (0.5 * h, halvings + 1);
        } else {
            return None;
        }
    }
    Some(now)
}

/// A stretch of the motion; none where the extrapolation does not come close.
fn stretch<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    kernel: &K,
    a: &[f64; D],
    start: &([f64; D], [f64; D]),
    h: f64,
    close: f64,
) -> Option<([f64; D], [f64; D])> {
    let rate = |(way, v): &([f64; D], [f64; D])| {
        let q = sum(a, way);
        let ([gradient], [bend]) = (kernel.jacobian(&q), kernel.jet(&q, v).2);
        (*v, scaled(-bend / dot(&gradient, &gradient), &gradient))
    };
    let plus = |y: &([f64; D], [f64; D]), c: f64, f: &([f64; D], [f64; D])| {
        (add_scaled(&y.0, c, &f.0), add_scaled(&y.1, c, &f.1))
    };
    let at_start = rate(start);
    let (mut row, mut last) = ([([0.0; D], [0.0; D]); DIVISIONS.len()], None);
    for (k, &division) in DIVISIONS.iter().enumerate() {
        let part = h / f64::from(division);
        let (mut before, mut now) = (*start, plus(start, part, &at_start));
        for _ in 1..division {
            let next = plus(&before, 2.0 * part, &rate(&now));
            (before, now) = (now, next);
        }
        let mean = plus(&before, part, &rate(&now));
        let mut found = (scaled(0.5, &sum(&now.0, &mean.0)), scaled(0.5, &sum(&now.1, &mean.1)));
        for j in 0..k {
            let ratio = f64::from(division) / f64::from(DIVISIONS[k - 1 - j]);
            let off = plus(&found, -1.0, &row[j]);
            row[j] = found;
            found = plus(&found, 1.0 / (ratio * ratio - 1.0), &off);
        }
        // Against the best of the divisions before; neighbours in a row agree by chance.
        let off = last.map_or(f64::INFINITY, |last| distance(&found, &last));
        row[k] = found;
        if off <= close * h {
            return Some(found);
        }
        last = Some(found);
    }
    None
}

fn distance<const D: usize>(a: &([f64; D], [f64; D]), b: &([f64; D], [f64; D])) -> f64 {
    largest(&add_scaled(&a.0, -1.0, &b.0)).max(largest(&add_scaled(&a.1, -1.0, &b.1)))
}

/// |v|.
fn length<const D: usize>(v: &[f64; D]) -> f64 {
    dot(v, v).sqrt()
}

/// ∇g/|∇g|.
fn normal<K: ConstraintKernel<f64, D, 1>, const D: usize>(kernel: &K, q: &[f64; D]) -> [f64; D] {
    let [gradient] = kernel.jacobian(q);
    scaled(1.0 / length(&gradient), &gradient)
}
