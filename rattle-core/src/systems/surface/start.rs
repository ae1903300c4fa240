//! Starts: always checked, projected onto the constraint only on request.

use crate::error::{Error, History, StartFailure};
use crate::kernel::functions::ConstraintKernel;
use crate::kernel::kinks::{first_kink, sign_changes};
use crate::kernel::rounding::{noise_of_g, size_along};
use crate::motion::bodies::Body;
use crate::motion::start::{DIRECTION, MAX_HALVINGS, MAX_PROJECTION_STEPS, RUNS_AWAY, START_TOLERANCE};
use crate::motion::start::{allowed, finite, has_square, length_of};
use crate::motion::state::State;
use crate::number::vector::{add_scaled, dot, largest, scaled};
use crate::solve::nearing::Nearing;
use crate::solve::root::straight;
use crate::systems::surface::normal::Normal;

/// Whether a body may start: finite, on the surface, momentum tangent, no singular point.
///
/// `path` is the length of the first step; it matters as a length scale where q is near zero. Staggered momenta need
/// not be tangent.
pub(crate) fn check<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    constraint: &K,
    body: &Body<f64, D>,
    path: f64,
    tangent: bool,
) -> Result<(), StartFailure> {
    finite("position", &body.q)?;
    finite("momentum", &body.p)?;
    let ([value], [gradient]) = constraint.value_and_jacobian(&body.q);
    if !(value.is_finite() && gradient.iter().all(|n| n.is_finite())) {
        return Err(not_finite(value, &gradient, &body.q));
    }
    let length = length_of(&gradient);
    let (coordinates, along) = (largest(&body.q), size_along(&gradient, length, &body.q));

    let change = |way: &[f64; D]| {
        let [change] = constraint.hessian_vector(&body.q, way);
        length_of(&change) / length
    };
    let singular = 1.0 / change(&scaled(1.0 / length, &gradient)); // to the next point where ∇g = 0; ∞ for a plane
    // A coordinate may be as large as it likes where normals do not depend on it.
    let turned = |i| {
        let mut rounding = [0.0; D];
        rounding[i] = f64::EPSILON * body.q[i];
        change(&rounding)
    };
    let is_near = |singular: f64| singular < f64::EPSILON * coordinates / DIRECTION;
    if length == 0.0 || is_near(singular) && (0..D).map(turned).sum::<f64>() > DIRECTION {
        let distance = if length == 0.0 { 0.0 } else { singular };
        return Err(StartFailure::SingularPoint { gradient: length, distance });
    }
    if !has_square(length) {
        return Err(StartFailure::OutOfScale { equation: None, gradient: length });
    }
    let distance = value.abs() / length;
    let tolerance = allowed([coordinates, along], path, singular);
    let is_rounding = || distance <= noise_of_g(constraint, &body.q, (value, &gradient, length), singular);
    if distance > tolerance && !is_rounding() {
        return Err(StartFailure::OffSurface { distance, tolerance, value });
    }
    let scale = largest(&body.p).max(f64::MIN_POSITIVE); // squares of momenta may leave the floats
    let direction = scaled(1.0 / scale, &body.p);
    let along_normal = dot(&gradient, &direction).abs() / length;
    let speed = dot(&direction, &direction).sqrt();
    // A way that is shorter than positions are rounded has no direction: that of who rests after rounding.
    if tangent && path > f64::EPSILON * coordinates && along_normal > START_TOLERANCE * speed {
        let edge = beyond(constraint, &body.q, &body.p).map(|(argument, _)| argument);
        return Err(StartFailure::NotTangent {
            sine: along_normal / speed,
            tolerance: START_TOLERANCE,
            edge,
        });
    }
    Ok(())
}

/// How often a way over an edge is made longer, from a rounding on, and by how much.
const LONGER: (u32, f64) = (6, 4.0);

/// For a body on an edge over which its momentum leads: what changes its sign there, and how long to go straight on
/// until that has happened.
fn beyond<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    constraint: &K,
    q: &[f64; D],
    p: &[f64; D],
) -> Option<(&'static str, f64)> {
    let speed = largest(p);
    if const { K::KINKS.is_empty() } || speed == 0.0 {
        return None;
    }
    let (times, factor) = LONGER;
    let least = (f64::EPSILON * largest(q)).max(f64::EPSILON * f64::EPSILON) / speed; // in the origin any will do
    (0..times).map(|k| least * factor.powi(k.cast_signed())).find_map(|time| {
        let kink = first_kink::<f64, _, D, 1, 1>(constraint, &[*q], &[add_scaled(q, time, p)])?;
        Some((kink.argument, time))
    })
}

fn not_finite<const D: usize>(value: f64, gradient: &[f64; D], q: &[f64; D]) -> StartFailure {
    StartFailure::ConstraintNotFinite { value, gradient: gradient.to_vec(), position: q.to_vec() }
}

/// Every body at a nearby point of the surface, its momentum without the normal part.
pub(crate) fn project<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    constraint: &K,
    state: &State<D>,
) -> Result<State<D>, Error> {
    let bodies = state.bodies.iter().enumerate();
    let project = |(i, body)| project_body(constraint, body).map_err(|cause| Error::Start { body: i, cause });
    let bodies = bodies.map(project).collect::<Result<_, _>>()?;
    Ok(State { bodies, remembered: None, ..*state })
}

/// The nearby point, and the momentum without the normal part. From an edge over which the momentum leads, the face
/// beyond is taken if the momentum is more nearly tangent to that one.
fn project_body<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    constraint: &K,
    body: &Body<f64, D>,
) -> Result<Body<f64, D>, StartFailure> {
    finite("position", &body.q)?;
    finite("momentum", &body.p)?;
    let (q, normal) = nearest(constraint, body.q)?;
    let (q, normal) = face_beyond(constraint, &q, &body.p, &normal).unwrap_or((q, normal));
    Ok(Body { q, q_low: [0.0; D], p: tangent(&normal, &body.p), p_low: [0.0; D] })
}

/// A momentum without its normal part.
fn tangent<const D: usize>(normal: &Normal<f64, D>, p: &[f64; D]) -> [f64; D] {
    let mut p = *p;
    for _ in 0..2 {
        p = add_scaled(&p, 1.0, &normal.projection(&p).1); // the second time takes what rounding left
    }
    p
}

/// A place right beyond an edge on which q lies, with its normal, if the momentum leads there and is more nearly
/// tangent to that face than to the one whose normal is that at q.
fn face_beyond<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    constraint: &K,
    q: &[f64; D],
    p: &[f64; D],
    normal: &Normal<f64, D>,
) -> Option<([f64; D], Normal<f64, D>)> {
    let scale = largest(p).max(f64::MIN_POSITIVE); // squares of momenta may leave the floats
    let (unit, speed) = (scaled(1.0 / scale, p), length_of(&scaled(1.0 / scale, p)));
    let across = |normal: &Normal<f64, D>| length_of(&normal.projection(&unit).1) / speed;
    if const { K::KINKS.is_empty() } || across(normal) <= START_TOLERANCE || across(normal).is_nan() {
        return None;
    }
    let (_, time) = beyond(constraint, q, &unit)?;
    let there = add_scaled(q, time, &unit);
    let [gradient] = constraint.jacobian(&there);
    let other = Normal::new(gradient);
    if across(&other) >= across(normal) {
        return None;
    }
    // Along that face, and not back over the edge.
    let along = tangent(&other, &unit);
    let (place, found) = nearest(constraint, add_scaled(q, time, &along)).ok()?;
    let stays = |to: &[f64; D]| !sign_changes::<f64, _, D, 1, 1>(constraint, &[there], &[*to]);
    (stays(&place) && stays(&add_scaled(&place, time, &along))).then_some((place, found))
}

/// Newton's iteration q ← q − ∇g g/|∇g|², to the rounding floor, and the normal there.
fn nearest<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    constraint: &K,
    mut q: [f64; D],
) -> Result<([f64; D], Normal<f64, D>), StartFailure> {
    let mut distances: Vec<f64> = Vec::new();
    let (mut nearing, mut last) = (Nearing::leaving(f64::INFINITY), [0.0; D]);
    for _ in 0..MAX_PROJECTION_STEPS {
        let ([value], [gradient]) = constraint.value_and_jacobian(&q);
        if !(value.is_finite() && gradient.iter().all(|n| n.is_finite())) {
            return Err(not_finite(value, &gradient, &q));
        }
        let length = length_of(&gradient);
        if length == 0.0 {
            return Err(StartFailure::SingularPoint { gradient: 0.0, distance: 0.0 });
        }
        if !has_square(length) {
            return Err(StartFailure::OutOfScale { equation: None, gradient: length });
        }
        let square = dot(&gradient, &gradient);
        let distance = value.abs() / square.sqrt();
        // Where ∇g stays, distances that do not shrink are the rounding of g, however large.
        let turned = length_of(&add_scaled(&gradient, -1.0, &last));
        let near = turned <= straight::<f64>() * length;
        last = gradient;
        if nearing.look(distance, distance <= f64::EPSILON * size_along(&gradient, length, &q), near).0 {
            return Ok((q, Normal::new(gradient)));
        }
        distances.push(distance);
        let from = q;
        let after = |share: f64| add_scaled(&from, -share * value / square, &gradient);
        let stays = |to: &[f64; D], most: f64| constraint.value(to)[0].abs() <= most * value.abs(); // not if NaN
        q = after(1.0);
        if !stays(&q, RUNS_AWAY) {
            let mut parts = (1..=MAX_HALVINGS).map(|halvings| after(0.5_f64.powi(halvings)));
            q = parts.find(|to| stays(to, 1.0)).unwrap_or(q);
        }
    }
    Err(StartFailure::NoProjection { distances: distances.into_iter().collect::<History>() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::real::Real;

    /// A circle of this radius, whose centre is so far along x; without a radius a straight line through it. Either
    /// times a number.
    #[derive(Clone)]
    struct Circle {
        centre: f64,
        radius: f64,
        times: f64,
    }

    impl<T: Real> ConstraintKernel<T, 2, 1> for Circle {
        fn value(&self, q: &[T; 2]) -> [T; 1] {
            self.value_and_jacobian(q).0
        }

        fn value_and_jacobian(&self, &[x, y]: &[T; 2]) -> ([T; 1], [[T; 2]; 1]) {
            let [centre, radius, times, two] = [self.centre, self.radius, self.times, 2.0].map(T::from_f64);
            let (x, zero) = (x - centre, T::from_f64(0.0));
            if self.radius == 0.0 {
                return ([times * x], [[times, zero]]);
            }
            ([times * (x * x + y * y - radius * radius)], [[times * two * x, times * two * y]])
        }

        fn hessian_vector(&self, _: &[T; 2], v: &[T; 2]) -> [[T; 2]; 1] {
            let two = T::from_f64(if self.radius == 0.0 { 0.0 } else { 2.0 * self.times });
            [[two * v[0], two * v[1]]]
        }

        fn jet(&self, q: &[T; 2], v: &[T; 2]) -> ([T; 1], [T; 1], [T; 1]) {
            let product = |[x, y]: [T; 2]| x * v[0] + y * v[1];
            let (g, [gradient]) = self.value_and_jacobian(q);
            let [curved] = self.hessian_vector(q, v);
            (g, [product(gradient)], [product(curved)])
        }
    }

    fn start(circle: &Circle, q: [f64; 2], p: [f64; 2], path: f64) -> Result<(), StartFailure> {
        let zero = [0.0; 2];
        check(circle, &Body { q, q_low: zero, p, p_low: zero }, path, true)
    }

    /// Where a body is so far off, in this tolerance, it starts to 0.99 of it, and not from 1.01.
    fn allows(circle: &Circle, on: [f64; 2], path: f64, tolerance: f64) {
        let off = |share: f64| start(circle, [on[0] + share * tolerance, on[1]], [0.0, 1e-3], path);
        assert_eq!(off(0.99), Ok(()), "tolerance {tolerance:e}");
        match off(1.01) {
            Err(StartFailure::OffSurface { tolerance: told, .. }) => {
                assert!((told / tolerance - 1.0).abs() < 1e-3, "{told:e}, not {tolerance:e}");
            }
            other => panic!("tolerance {tolerance:e}: {other:?}"),
        }
    }

    #[test]
    fn tolerances_are_parts_of_the_size_of_the_rounding_and_of_the_way() {
        for (radius, times) in [(1.0, 1.0), (1e-3, 1e8), (1e5, 1e-8)] {
            let circle = Circle { centre: 0.0, radius, times };
            allows(&circle, [radius, 0.0], 0.01 * radius, START_TOLERANCE * radius);
            allows(&circle, [radius, 0.0], 1e9 * radius, START_TOLERANCE * radius); // a way is no longer than the radius
        }
        // Far from the origin the rounding of places, 16 times.
        let far = Circle { centre: 1e6, radius: 1.0, times: 1.0 };
        allows(&far, [1e6 + 1.0, 0.0], 0.01, 16.0 * f64::EPSILON * 1e6);
        // The circle bends by more than that on the way of shifts that find the rounding.
        let beside = start(&Circle { centre: 1e9, ..far }, [1e9, 1.0005], [1e-3, 0.0], 0.01);
        assert!(matches!(beside, Err(StartFailure::OffSurface { .. })), "{beside:?}");
        // Near it a part of the way, and of the size of the circle: a line has none.
        let near = Circle { centre: -1.0, radius: 1.0, times: 1.0 };
        allows(&near, [0.0, 1e-14], 10.0, 1e-12);
        let line = Circle { centre: 0.0, radius: 0.0, times: 3.0 };
        allows(&line, [0.0, 1.0], 1e4, 1e-8);
        allows(&line, [0.0, 1.0], 1.0, START_TOLERANCE);
    }

    /// Near the origin terms of g are larger than the coordinates, by as much as the circle is.
    #[test]
    fn projected_starts_are_taken() {
        for (radius, k) in [1.0, 0.3e3, 7e7].into_iter().flat_map(|radius| (0..40).map(move |k| (radius, k)))
        {
            let circle = Circle { centre: -radius, radius, times: 3.0 };
            let (size, share) = (0.1 * 0.37_f64.powi(k), f64::from(k).sin());
            let state = State::at([size * share, size]).moving([1.0, 0.0]);
            let Body { q, p, .. } = project(&circle, &state).unwrap().bodies[0];
            assert_eq!(start(&circle, q, p, 1e-3 * size), Ok(()), "size {size:e} of radius {radius:e}");
            let off = 1e-9 * size + 100.0 * f64::EPSILON * radius;
            let beside = start(&circle, [q[0] + off, q[1]], p, 1e-3 * size);
            assert!(
                matches!(beside, Err(StartFailure::OffSurface { .. })),
                "size {size:e} of radius {radius:e}"
            );
        }
    }

    #[test]
    fn normals_are_known_to_some_digits() {
        let to_apex = |distance: f64| {
            let circle = Circle { centre: 1.0, radius: distance, times: 1.0 };
            start(&circle, [1.0 + distance, 0.0], [0.0, 1e-3], 1e-14)
        };
        let least = f64::EPSILON / DIRECTION;
        assert_eq!(to_apex(1.1 * least), Ok(()));
        assert!(matches!(to_apex(0.9 * least), Err(StartFailure::SingularPoint { .. })));
        let at_it = start(&Circle { centre: 1.0, radius: 1e-20, times: 1.0 }, [1.0, 0.0], [0.0; 2], 0.1);
        assert!(matches!(at_it, Err(StartFailure::SingularPoint { distance: 0.0, .. })), "{at_it:?}");
    }

    #[test]
    fn constraints_are_numbers_and_so_are_their_gradients() {
        let value = start(&Circle { centre: 0.0, radius: 1e200, times: 1.0 }, [1e200, 0.0], [0.0; 2], 1.0);
        assert!(matches!(value, Err(StartFailure::ConstraintNotFinite { .. })), "{value:?}");
        let gradient = start(&Circle { centre: 0.0, radius: 1.0, times: 1e308 }, [1.0, 0.0], [0.0; 2], 1.0);
        assert!(matches!(gradient, Err(StartFailure::ConstraintNotFinite { .. })), "{gradient:?}");
    }

    #[test]
    fn momenta_are_along_the_surface() {
        let circle = Circle { centre: 0.0, radius: 1.0, times: 1.0 };
        for size in [1e-300, 1.0, 1e300] {
            let tilted = |sine: f64| start(&circle, [1.0, 0.0], [sine * size, size], 0.1);
            assert_eq!(tilted(0.99 * START_TOLERANCE), Ok(()));
            assert!(matches!(tilted(1.01 * START_TOLERANCE), Err(StartFailure::NotTangent { .. })));
        }
        assert_eq!(start(&circle, [1.0, 0.0], [1.0, 0.0], 1e-16), Ok(())); // shorter than the rounding of places
    }
}
