//! Starts: always checked, projected onto the constraint only on request.

use crate::error::{Error, History, StartFailure};
use crate::kernel::functions::ConstraintKernel;
use crate::motion::bodies::Body;
use crate::motion::start::DIRECTION;
use crate::motion::start::MAX_PROJECTION_STEPS;
use crate::motion::start::START_TOLERANCE;
use crate::motion::start::{finite, has_square, length_of};
use crate::motion::state::State;
use crate::number::vector::{add_scaled, dot, largest, scaled};
use crate::solve::aim::NOISY;
use crate::solve::nearing::Nearing;
use crate::solve::root::straight;
use crate::systems::surface::equation::rounding_of;
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
    let rounding = f64::EPSILON * largest(&body.q);

    let [bend] = constraint.hessian_vector(&body.q, &scaled(1.0 / length, &gradient));
    let singular = length / length_of(&bend); // to the next point where ∇g = 0; ∞ for a plane
    if length == 0.0 || singular < rounding / DIRECTION {
        let distance = if length == 0.0 { 0.0 } else { singular };
        return Err(StartFailure::SingularPoint { gradient: length, distance });
    }
    if !has_square(length) {
        return Err(StartFailure::OutOfScale { equation: None, gradient: length });
    }
    let distance = value.abs() / length;
    // Where q is near zero the terms of g, and their rounding, are of the size of the surface.
    let size = largest(&body.q).min(singular);
    let noise = rounding.max(if singular.is_finite() { f64::EPSILON * singular } else { 0.0 });
    // Near the origin of a plane places have the rounding of where they came from, which may be some hundred steps
    // away.
    let of_path = 1e-12 * path.min(singular);
    let tolerance = (START_TOLERANCE * size).max(16.0 * noise).max(of_path);
    let of_g = || NOISY * length * rounding_of(constraint, &body.q, &gradient, largest(&body.q));
    if distance > tolerance && distance > of_g() {
        return Err(StartFailure::OffSurface { distance, tolerance, value });
    }
    let scale = largest(&body.p).max(f64::MIN_POSITIVE); // squares of momenta may leave the floats
    let direction = scaled(1.0 / scale, &body.p);
    let along_normal = dot(&gradient, &direction).abs() / length;
    let speed = dot(&direction, &direction).sqrt();
    // A way that is shorter than positions are rounded has no direction: that of who rests after rounding.
    if tangent && path > rounding && along_normal > START_TOLERANCE * speed {
        return Err(StartFailure::NotTangent { sine: along_normal / speed, tolerance: START_TOLERANCE });
    }
    Ok(())
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

/// Newton's iteration q ← q − ∇g g/|∇g|², to the rounding floor.
fn project_body<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    constraint: &K,
    body: &Body<f64, D>,
) -> Result<Body<f64, D>, StartFailure> {
    finite("position", &body.q)?;
    finite("momentum", &body.p)?;
    let mut q = body.q;
    let mut distances: Vec<f64> = Vec::new();
    let (mut nearing, mut last_square) = (Nearing::leaving(f64::INFINITY), 0.0);
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
        let near = (square - last_square).abs() <= straight::<f64>() * square;
        last_square = square;
        if nearing.look(distance, distance <= f64::EPSILON * largest(&q), near).0 {
            let normal = Normal::new(gradient);
            let mut p = body.p;
            for _ in 0..2 {
                p = add_scaled(&p, 1.0, &normal.projection(&p).1); // the second time takes what rounding left
            }
            return Ok(Body { q, q_low: [0.0; D], p, p_low: [0.0; D] });
        }
        distances.push(distance);
        q = add_scaled(&q, -value / square, &gradient);
    }
    Err(StartFailure::NoProjection { distances: distances.into_iter().collect::<History>() })
}
