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
use crate::number::vector::{add_scaled, dot, extent, larger_or_nan, largest, scaled, sum};
use nalgebra::SMatrix;
use std::array::from_fn;

/// Divisions of a stretch, of which the motion is extrapolated.
const DIVISIONS: [u32; 9] = [2, 4, 6, 8, 10, 12, 14, 16, 18];
/// What one division more may change, as part of the way: what is left then is far smaller.
const CLOSE: f64 = 1e-13;
/// What rounding may do to a velocity in a stretch, in units of its last digit: below it divisions do not agree.
const ROUNDING: f64 = 32.0;
/// What the rounding of places may do to it, in units of the angle by which it turns the normal, times that by which
/// the stretch does.
const OF_PLACES: f64 = 16.0;
/// Where it turns the normal by more, nothing is known of the motion.
const MOST_TURNED: f64 = 1e-3;
/// What goes beside a motion grows exponentially in saddles, up to where its rounding alone is more than `CLOSE`. It is
/// linear: where a pair comes to more than this, as part of the speed, the pair is multiplied by a power of two.
const GROWN: f64 = 1e-3;
const SHRUNK: f64 = 1.0 / 1024.0;
/// Stretches of a motion. Those that are halved don't count: where curvature jumps it takes some 45 halvings to pass.
const MOST_STRETCHES: usize = 400;
/// Halvings of one stretch: where there is no normal no number of them will do.
const MOST_HALVINGS: usize = 60;
/// A stretch that is the third or later of those that came close at once is followed by one of so many times its length
/// at most: behind a jump of curvature, stretches are 10¹³ times too short.
const GROWTH: f64 = 16.0;
/// Tries of v.
const MOST_TRIES: usize = 60;
/// Tries of a v that leads nearly there.
const FEW_TRIES: usize = 12;
/// No v is longer than this times the first one.
const LONGER: f64 = 20.0;
/// Normals are opposite where their cosine and 1 add up to this.
const OPPOSITE: f64 = 1e-6;
/// Where the end answers to v by less than one over this, in some direction, v is not changed much in that direction.
const MUCH: f64 = 1e3;
/// A correction is halved so often where it does not lead nearer.
const SHORTER: usize = 8;
/// What may be missed in the end, as part of the coordinates and the way, where nothing leads nearer.
pub(crate) const MISSED: f64 = 1e-12;

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
    let straight = length(chord);
    if straight == 0.0 {
        return Ok(Shot { distance: 0.0, from: [0.0; D], to: [0.0; D] });
    }
    let aim = Aim::new(kernel, a, chord);
    let along = add_scaled(chord, -dot(chord, &aim.here), &aim.here);
    let first =
        (straight * straight - dot(&aim.here, chord) * dot(&aim.there, chord) / 3.0).max(straight * straight);
    let v = scaled(first.sqrt() / length(&along), &along);
    let now = aim.look(&v).ok_or(Missed { by: f64::INFINITY, length: length(&v), tries: 1 })?;
    aim.hit(MOST_TRIES, v, now, from_fn(|i| from_fn(|k| f64::from(u8::from(i == k)))))
}

/// The same from a velocity that leads nearly there, by Newton's method at first: for long ways, whose ends answer in
/// other directions and by other lengths than those of short ones.
pub(crate) fn shoot_along<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    kernel: &K,
    a: &[f64; D],
    chord: &[f64; D],
    v: [f64; D],
) -> Result<Shot<D>, Missed> {
    let aim = Aim::new(kernel, a, chord);
    let lost = Missed { by: f64::INFINITY, length: length(&v), tries: 1 };
    let now = aim.look(&v).ok_or(lost)?;
    let answer = aim.answer(&v, &now.1).ok_or(lost)?;
    aim.hit(FEW_TRIES, v, now, answer)
}

/// A place to start from, and one to hit.
pub(crate) struct Aim<'a, K, const D: usize> {
    kernel: &'a K,
    a: &'a [f64; D],
    chord: &'a [f64; D],
    /// Unit normals at both.
    pub(crate) here: [f64; D],
    pub(crate) there: [f64; D],
    /// The larger of both, in its largest coordinate.
    size: f64,
}

/// What a try misses through space, and along the surface, turned back to the start; and its velocity at the end.
pub(crate) type Try<const D: usize> = ([f64; D], [f64; D], [f64; D]);

impl<'a, K: ConstraintKernel<f64, D, 1>, const D: usize> Aim<'a, K, D> {
    pub(crate) fn new(kernel: &'a K, a: &'a [f64; D], chord: &'a [f64; D]) -> Self {
        let b = sum(a, chord);
        let (here, there) = (normal(kernel, a), normal(kernel, &b));
        Self { kernel, a, chord, here, there, size: largest(a).max(largest(&b)) }
    }

    /// What is added where a way of this length ends.
    pub(crate) fn extent(&self, way: f64) -> f64 {
        self.size + way.max(length(self.chord))
    }

    /// What may be missed, by rounding.
    pub(crate) fn floor(&self, way: f64) -> f64 {
        4.0 * f64::EPSILON * self.extent(way)
    }

    /// Where a velocity leads; none where the motion is not found.
    pub(crate) fn look(&self, v: &[f64; D]) -> Option<Try<D>> {
        let Self { here, there, .. } = self;
        let (way, speed) = fly(self.kernel, self.a, v)?;
        let miss = add_scaled(self.chord, -1.0, &way);
        // What of it is along the surface at b, back to a.
        let along = add_scaled(&miss, -dot(there, &miss), there);
        // Where normals are opposite, tangents are the same, and no rotation is the smallest.
        let alike = 1.0 + dot(here, there);
        let share = if alike > OPPOSITE { dot(here, &along) / alike } else { 0.0 };
        let back = add_scaled(&along, -share, &sum(here, there));
        let tangent = add_scaled(&back, -dot(here, &back), here);
        Some((miss, tangent, speed))
    }

    /// What v changes by for what is missed, by differences; a velocity along the normal stands for itself.
    fn answer(&self, v: &[f64; D], missed: &[f64; D]) -> Option<[[f64; D]; D]> {
        let step = 1e-6 * length(v);
        let mut columns = SMatrix::<f64, D, D>::zeros();
        for d in 0..D {
            let axis: [f64; D] = from_fn(|i| f64::from(u8::from(i == d)));
            let normal = self.here[d];
            let along = add_scaled(&axis, -normal, &self.here);
            let (_, there, _) = self.look(&add_scaled(v, step, &along))?;
            let change = scaled(-1.0 / step, &add_scaled(&there, -1.0, missed));
            columns.column_mut(d).copy_from_slice(&add_scaled(&change, normal, &self.here));
        }
        // Where many ways meet, as in the antipode of a sphere, the end answers to no turn of the way.
        let answer = columns.try_inverse().filter(|answer| answer.amax() < MUCH).or_else(|| {
            let damped = columns + SMatrix::<f64, D, D>::identity() / MUCH;
            damped.try_inverse()
        })?;
        Some(from_fn(|i| from_fn(|k| answer[(i, k)])))
    }

    /// Corrects a velocity until it hits, by Broyden's method.
    fn hit(
        &self,
        most: usize,
        mut v: [f64; D],
        mut now: Try<D>,
        mut answer: [[f64; D]; D],
    ) -> Result<Shot<D>, Missed> {
        let straight = length(self.chord);
        let lost = |by: f64, length: f64, tries| Missed { by, length, tries };
        let longest = LONGER * length(&v);
        for tries in 1..most {
            let size = self.extent(length(&v));
            let floor = self.floor(length(&v));
            // What is missed across the surface is of second order in what is missed along it, unless b is elsewhere.
            let there = length(&now.0) <= 1e-6 * straight + floor;
            if there && length(&now.1) <= floor {
                return Ok(shot(&v, &now));
            }
            let mut step: [f64; D] = from_fn(|i| dot(&answer[i], &now.1));
            let mut next = None;
            for _ in 0..SHORTER {
                let tried = sum(&v, &step);
                if length(&tried) <= longest
                    && let Some(found) = self.look(&tried)
                {
                    // vᵢ answers to what is missed as by the last step.
                    let change = add_scaled(&found.1, -1.0, &now.1);
                    let told: [f64; D] = from_fn(|i| dot(&answer[i], &change));
                    let against: [f64; D] = from_fn(|k| (0..D).map(|i| step[i] * answer[i][k]).sum::<f64>());
                    let product = dot(&step, &told);
                    if product.abs() > 1e-8 * dot(&step, &step) {
                        for i in 0..D {
                            answer[i] = add_scaled(&answer[i], -(step[i] + told[i]) / product, &against);
                        }
                    }
                    let nearer = if there {
                        length(&found.1) < length(&now.1)
                    } else {
                        length(&found.0) < length(&now.0)
                    };
                    if nearer {
                        next = Some((tried, found));
                        break;
                    }
                }
                step = scaled(0.5, &step);
            }
            match next {
                Some((better, found)) => (v, now) = (better, found),
                None if there && length(&now.1) <= MISSED * size => return Ok(shot(&v, &now)),
                None => return Err(lost(length(&now.0), length(&v), tries + 1)),
            }
        }
        Err(lost(length(&now.0), length(&v), most))
    }
}

/// The geodesic of a try: what it missed along its way belongs to its length, by the first variation.
pub(crate) fn shot<const D: usize>(v: &[f64; D], (miss, _, speed): &Try<D>) -> Shot<D> {
    let unit = |v: &[f64; D]| scaled(1.0 / length(v), v);
    let (from, to) = (unit(v), unit(speed));
    Shot { distance: length(v) + dot(&to, miss), from, to }
}

/// A motion, as a way from a and its velocity, and what goes beside it, as pairs of vectors, linear each by itself.
pub(crate) type Motion<const D: usize, const N: usize> = [([f64; D], [f64; D]); N];

/// Where the motion from a with the velocity v has come to at time 1, as a way from a, and its velocity there; none
/// where it is not found.
fn fly<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    kernel: &K,
    a: &[f64; D],
    v: &[f64; D],
) -> Option<([f64; D], [f64; D])> {
    let rate = |&[(way, v)]: &Motion<D, 1>| {
        let q = sum(a, &way);
        let ([gradient], [bend]) = (kernel.jacobian(&q), kernel.jet(&q, &v).2);
        [(v, scaled(-bend / dot(&gradient, &gradient), &gradient))]
    };
    follow(kernel, a, [([0.0; D], *v)], rate, |_, _| false).map(|([end], _)| end)
}

/// Follows a motion from a, and what goes beside it, up to time 1, or to the end of a stretch in which something shows
/// between two neighbouring places; and whether it did. None where the motion is not found. Of what goes beside it, the
/// length alone may be another.
pub(crate) fn follow<K: ConstraintKernel<f64, D, 1>, const D: usize, const N: usize>(
    kernel: &K,
    a: &[f64; D],
    start: Motion<D, N>,
    rate: impl Fn(&Motion<D, N>) -> Motion<D, N>,
    shows: impl Fn(&Motion<D, N>, &Motion<D, N>) -> bool,
) -> Option<(Motion<D, N>, bool)> {
    let (mut time, mut h, mut now) = (0.0, 1.0, start);
    let (mut stretches, mut halvings, mut growth) = (0, 0, 2.0);
    let speed = length(&start[0].1);
    while stretches < MOST_STRETCHES && halvings < MOST_HALVINGS && time + h > time {
        match stretch(kernel, a, &now, h, CLOSE * speed, (&rate, &shows)) {
            Some((then, shown)) if shown || time + h == 1.0 => return Some((then, shown)),
            // Powers of 2, so that the end is met.
            Some((then, _)) => {
                (time, now, h) = (time + h, shrunk(then, speed), (growth * h).min(1.0 - time - h));
                (stretches, halvings, growth) = (stretches + 1, 0, GROWTH.min(2.0 * growth));
            }
            None => (h, halvings, growth) = (0.5 * h, halvings + 1, 2.0),
        }
    }
    None
}

/// A motion, and what goes beside it, shorter where it has grown.
fn shrunk<const D: usize, const N: usize>(mut now: Motion<D, N>, speed: f64) -> Motion<D, N> {
    for pair in now.iter_mut().skip(1) {
        if largest(&pair.0).max(largest(&pair.1)) > GROWN * speed {
            *pair = (scaled(SHRUNK, &pair.0), scaled(SHRUNK, &pair.1));
        }
    }
    now
}

/// A stretch of the motion, and whether something shows on it; none where the extrapolation does not come close.
fn stretch<K: ConstraintKernel<f64, D, 1>, const D: usize, const N: usize>(
    kernel: &K,
    a: &[f64; D],
    start: &Motion<D, N>,
    h: f64,
    close: f64,
    (rate, shows): (&impl Fn(&Motion<D, N>) -> Motion<D, N>, &impl Fn(&Motion<D, N>, &Motion<D, N>) -> bool),
) -> Option<(Motion<D, N>, bool)> {
    let plus = |y: &Motion<D, N>, c: f64, f: &Motion<D, N>| -> Motion<D, N> {
        from_fn(|n| (add_scaled(&y[n].0, c, &f[n].0), add_scaled(&y[n].1, c, &f[n].1)))
    };
    let half = |y: &Motion<D, N>| y.map(|(way, v)| (scaled(0.5, &way), scaled(0.5, &v)));
    let at_start = rate(start);
    let floor = ROUNDING * f64::EPSILON * length(&start[0].1);
    let (mut row, mut last) = ([[([0.0; D], [0.0; D]); N]; DIVISIONS.len()], None);
    let mut tried = [(f64::INFINITY, (*start, false)); DIVISIONS.len()]; // off that before, and found
    for (k, &division) in DIVISIONS.iter().enumerate() {
        let part = h / f64::from(division);
        let (mut before, mut now, mut shown) = (*start, plus(start, part, &at_start), false);
        for _ in 1..division {
            let next = plus(&before, 2.0 * part, &rate(&now));
            shown |= shows(&before, &now);
            (before, now) = (now, next);
        }
        let mean = plus(&before, part, &rate(&now));
        let mut found = plus(&half(&now), 0.5, &mean);
        for j in 0..k {
            let ratio = f64::from(division) / f64::from(DIVISIONS[k - 1 - j]);
            let off = plus(&found, -1.0, &row[j]);
            row[j] = found;
            found = plus(&found, 1.0 / (ratio * ratio - 1.0), &off);
        }
        shown |= shows(&before, &found);
        // Against the best of the divisions before; neighbours in a row agree by chance.
        let off = last.map_or(f64::INFINITY, |last| distance(&found, &last));
        row[k] = found;
        if off <= (close * h).max(floor) {
            return Some((found, shown));
        }
        last = Some(found);
        tried[k] = (off, (found, shown));
    }
    // Far from the origin places are rounded by more than velocities are, and no number of divisions comes nearer.
    let (way, v) = &start[0];
    let [gradient] = kernel.jacobian(&sum(a, way));
    let (turned, bent) = turns(kernel, &sum(a, way), &gradient);
    let rounded = OF_PLACES * turned * bent * dot(v, v) * h;
    let is_rounding = |off: f64| off <= rounded && turned <= MOST_TURNED;
    tried.into_iter().find(|&(off, _)| is_rounding(off)).map(|(_, found)| found)
}

/// By what angle the rounding of a place turns the normal there, and by how much a unit of length does, along that axis
/// along which it is the most.
fn turns<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    kernel: &K,
    q: &[f64; D],
    gradient: &[f64; D],
) -> (f64, f64) {
    let steep = length(gradient);
    let unit = scaled(1.0 / steep, gradient);
    (0..D).fold((0.0, 0.0), |(turned, most), i| {
        let [change] = kernel.hessian_vector(q, &from_fn(|k| f64::from(u8::from(i == k))));
        let turn = length(&add_scaled(&change, -dot(&change, &unit), &unit)) / steep;
        (turned + f64::EPSILON * q[i].abs() * turn, turn.max(most))
    })
}

/// By how much two motions differ in a coordinate, at most; NaN where one of them is no number.
fn distance<const D: usize, const N: usize>(a: &Motion<D, N>, b: &Motion<D, N>) -> f64 {
    let off = |a: &[f64; D], b: &[f64; D]| extent(&add_scaled(a, -1.0, b));
    let pairs = a.iter().zip(b).map(|(a, b)| larger_or_nan(off(&a.0, &b.0), off(&a.1, &b.1)));
    pairs.fold(0.0, larger_or_nan)
}

/// |v|.
pub(crate) fn length<const D: usize>(v: &[f64; D]) -> f64 {
    dot(v, v).sqrt()
}

/// ∇g/|∇g|.
pub(crate) fn normal<K: ConstraintKernel<f64, D, 1>, const D: usize>(kernel: &K, q: &[f64; D]) -> [f64; D] {
    let [gradient] = kernel.jacobian(q);
    scaled(1.0 / length(&gradient), &gradient)
}
