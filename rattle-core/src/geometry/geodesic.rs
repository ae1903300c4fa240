//! The distance between two points along a surface.

use crate::geometry::conjugate::{from_near, passes, settled};
use crate::geometry::detour::detours;
use crate::kernel::functions::{Constraint, ConstraintKernel};
use crate::kernel::geodesic::{Missed, Shot, length, normal, shoot, shoot_along};
use crate::kernel::rounding::{allowed, noise_of_g, sizes};
use crate::number::vector::{add_scaled, dot, largest, scaled};
use nalgebra::SVector;

/// A geodesic between two points a and b.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geodesic<const D: usize> {
    /// Its length d, in the unit of the coordinates.
    pub distance: f64,
    /// Its direction at a, a unit tangent vector: −∂d/∂a. Zero where a = b.
    pub from: SVector<f64, D>,
    /// Its direction at b, a unit tangent vector: ∂d/∂b. Zero where a = b.
    pub to: SVector<f64, D>,
}

/// The shortest geodesic from a to b on the surface g = 0 that is found, to rounding.
///
/// ```text
/// d = min ∫ |dq| over paths on g = 0 from a to b        ∂d/∂a = −from, ∂d/∂b = to (the first variation)
/// ```
///
/// It is found by [shooting](crate::kernel::geodesic) from the chord: some hundred evaluations of ∇g and ∇²g. Where
/// that fails, leads farther than 1.02 chords, or past a point conjugate to a, ways through a graph of some hundred
/// points of the surface are drawn tight, and shot along too: some hundred thousand evaluations, or 10 to 50 ms.
/// Nothing proves that there is no shorter one: of 552 pairs of random points on a surface of genus two, six were
/// nearer by way of a third point, by up to 8 %; of 276 on a torus, none. Near a
/// point conjugate to a, where many geodesics meet, as in the antipode of a sphere, the distance is as exact as
/// elsewhere; a rounding of b turns the direction by more, the nearer it is. What is narrower than the points of the
/// graph, such as the rim of a plate, can be missed: an error then. So can what leads over a sharp edge, which no
/// geodesic is shot over: where a way drawn tight is shorter by 1 % than the shortest geodesic, and cannot be shot
/// along, that is an error, too. The distance from b to a is the same number.
///
/// ```
/// use rattle::curvature::geodesic_distance;
/// use rattle::nalgebra::Vector3;
/// use rattle::surfaces::Sphere;
///
/// let (a, b) = (2.0 * Vector3::x(), 2.0 * Vector3::z());
/// let way = geodesic_distance(&Sphere { r: 2.0 }, &a, &b)?;
/// assert!((way.distance - std::f64::consts::PI).abs() < 1e-13);
/// assert!((way.from - Vector3::z()).norm() < 1e-13);
/// assert!((way.to + Vector3::x()).norm() < 1e-13);
/// # Ok::<(), rattle::curvature::GeodesicError>(())
/// ```
///
/// # Errors
/// [`GeodesicError::NotOnSurface`] for a point off g = 0, [`GeodesicError::NotFound`] where no try ends at b, or a
/// shorter way was not followed to b: b may be on another part of the surface, or beyond an edge.
#[doc(alias = "shortest path")]
#[doc(alias = "arc length")]
pub fn geodesic_distance<C: Constraint<D, 1>, const D: usize>(
    surface: &C,
    a: &SVector<f64, D>,
    b: &SVector<f64, D>,
) -> Result<Geodesic<D>, GeodesicError> {
    let kernel = surface.kernel::<f64>();
    let (a, b): ([f64; D], [f64; D]) = ((*a).into(), (*b).into());
    let size = largest(&a).max(largest(&b)).max(f64::MIN_POSITIVE); // one of them may be the origin
    for (place, q) in [("a", &a), ("b", &b)] {
        if let Some(off) = off(&kernel, q, size) {
            return Err(GeodesicError::NotOnSurface { place, position: q.to_vec(), off });
        }
    }
    // The same either way.
    let turned = a > b;
    let (first, last) = if turned { (&b, &a) } else { (&a, &b) };
    let Shot { distance, from, to } = between(&kernel, first, last)?;
    let [from, to] = [from, to].map(SVector::from);
    Ok(if turned { Geodesic { distance, from: -to, to: -from } } else { Geodesic { distance, from, to } })
}

/// The shortest geodesic that is found.
fn between<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    kernel: &K,
    a: &[f64; D],
    b: &[f64; D],
) -> Result<Shot<D>, GeodesicError> {
    let chord = add_scaled(b, -1.0, a);
    let straight = shoot(kernel, a, &chord);
    if let Ok(shot) = straight
        && shot.distance <= NOT_FAR * length(&chord)
        && !passes(kernel, a, &shot)
    {
        return Ok(shot);
    }
    let (mut shortest, mut lost) = (straight, f64::INFINITY);
    for way in detours(kernel, a, b) {
        // By more than rounding, which would choose among several tries at one geodesic.
        let found = shortest.map_or(f64::INFINITY, |shot| shot.distance);
        match along(kernel, &way) {
            Ok(shot) if shot.distance < (1.0 - SHORTER) * found => shortest = Ok(shot),
            Ok(_) => {}
            Err(length) => lost = lost.min(length),
        }
    }
    let shortest = shortest.map_err(|missed| not_found(&chord, missed))?;
    if lost < (1.0 - CROOKED) * shortest.distance {
        return Err(not_found(&chord, Missed { by: f64::INFINITY, length: lost, tries: 1 }));
    }
    Ok(settled(kernel, a, &chord, shortest))
}

#[cold]
fn not_found<const D: usize>(chord: &[f64; D], Missed { by, length: found, tries }: Missed) -> GeodesicError {
    GeodesicError::NotFound { chord: length(chord), length: found, by, tries }
}

/// The geodesic near a [way around](detours): its end is led along that way to b, as far each time as it can follow.
///
/// # Errors
/// The length of the way, where its end is not led to b.
fn along<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    kernel: &K,
    way: &[[f64; D]],
) -> Result<Shot<D>, f64> {
    let (a, last) = (&way[0], way.len() - 1);
    let long = |pair: &[[f64; D]]| length(&add_scaled(&pair[1], -1.0, &pair[0]));
    let mut gone = vec![0.0];
    gone.extend(way.windows(2).map(long).scan(0.0, |sum, part| {
        *sum += part;
        Some(*sum)
    }));
    let (first, normal) = (add_scaled(&way[1], -1.0, a), normal(kernel, a));
    let along = add_scaled(&first, -dot(&first, &normal), &normal);
    let (mut unit, mut at, mut ahead) = (scaled(1.0 / length(&along), &along), 0, last);
    // The next place, and so b, may be near a point conjugate to a.
    let end = |v: [f64; D]| {
        let found = from_near(kernel, a, &add_scaled(&way[last], -1.0, a), &v)?;
        (found.distance <= LONGER * gone[last]).then_some(found)
    };
    loop {
        let next = (at + ahead).min(last);
        let (chord, v) = (add_scaled(&way[next], -1.0, a), scaled(gone[next], &unit));
        let near = |shot: &Shot<D>| shot.distance <= LONGER * gone[next];
        match shoot_along(kernel, a, &chord, v).ok().filter(near) {
            Some(shot) if next == last => return Ok(shot),
            Some(shot) => (unit, at, ahead) = (shot.from, next, 2 * ahead),
            None if ahead > 1 => ahead /= 2,
            None => return end(scaled(gone[last], &unit)).ok_or(gone[last]),
        }
    }
}

/// A geodesic is no more than this times as long as the way that led to it: else it is another one.
const LONGER: f64 = 1.05;

/// A geodesic that is no longer than this, in straight distances, is taken for the shortest if no point on it is
/// conjugate to its start.
const NOT_FAR: f64 = 1.02;

/// Another geodesic is shorter if it is by this part.
const SHORTER: f64 = 1e-9;

/// A drawn way that no geodesic follows is shorter than a geodesic if it is by this part: it cuts corners, by up to 0.4
/// % of itself at each edge of 90°.
const CROOKED: f64 = 0.01;

/// How far a place may be off the surface, as part of the largest coordinate of both, or of the size of the surface if
/// that is smaller.
const NEAR: f64 = 1e-9;

/// |g|/|∇g|, about how far a place is off the surface, if that is more than it may be, and more than rounding.
fn off<K: ConstraintKernel<f64, D, 1>, const D: usize>(kernel: &K, q: &[f64; D], size: f64) -> Option<f64> {
    let ([value], [gradient]) = kernel.value_and_jacobian(q);
    let length = length(&gradient);
    let [bend] = kernel.hessian_vector(q, &gradient);
    let off = value.abs() / length;
    if !(off.is_finite() && length > 0.0 && length.is_finite()) {
        return Some(off);
    }
    let (along, singular) = sizes(q, &gradient, &bend);
    let rounding = || noise_of_g(kernel, q, (value, &gradient, length), singular);
    (!(off <= allowed(NEAR, [size, along], singular) || off <= rounding())).then_some(off)
}

/// Why no geodesic was found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GeodesicError {
    /// A point off the surface, or where the surface has no normal.
    #[error("{place} = {position:?} is off the surface by {off:.3e}")]
    NotOnSurface {
        /// `a` or `b`.
        place: &'static str,
        /// The point.
        position: Vec<f64>,
        /// |g|/|∇g| there.
        off: f64,
    },
    /// No try ends at b.
    #[error(
        "no geodesic found: {}; the places may be on parts of the surface that do not hang together, or one beyond an edge that is \
         too sharp to be followed, or b near a point conjugate to a, where many geodesics meet: move b a little",
        missed(*chord, *length, *by, *tries)
    )]
    NotFound {
        /// The straight distance.
        chord: f64,
        /// The length of the best try, or of a way that was not followed to its end.
        length: f64,
        /// Its distance from b at the end; infinite where it was not followed to its end.
        by: f64,
        /// The number of tries.
        tries: usize,
    },
}

/// What was missed, in words.
fn missed(chord: f64, length: f64, by: f64, tries: usize) -> String {
    if by.is_finite() {
        return format!(
            "the best of {tries} tries, of length {length:.3e}, misses the end of a chord of {chord:.3e} by {by:.3e}"
        );
    }
    format!(
        "a way of length {length:.3e} to the end of a chord of {chord:.3e} was not followed to its end, since the \
         surface has no normal on it, bends too much or too often, or is so far from the origin that places on it are \
         rounded by as much as it bends in"
    )
}
