//! The start: checked always, moved onto the constraint only when asked.

use crate::bodies::{Body, Normal};
use crate::error::{Error, History, StartFailure};
use crate::kernel::ConstraintKernel;
use crate::solver::START_TOLERANCE;
use crate::state::State;
use crate::vector::{add_scaled, dot, largest, scaled};

/// Nearer than this to a singular point, relative to the coordinates, rounding leaves the normal fewer
/// than six digits.
const SINGULAR_DISTANCE: f64 = 1e-10;

/// Newton steps after which a projection is given up.
const MAX_PROJECTION_STEPS: usize = 60;

/// Whether a body may start: finite, on the surface, momentum tangent, no singular point.
///
/// `path` is the length of the first step; it matters as a length scale where q is near zero.
pub(crate) fn check<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    constraint: &K,
    body: &Body<f64, D>,
    path: f64,
) -> Result<(), StartFailure> {
    finite("position", &body.q)?;
    finite("momentum", &body.p)?;
    let ([value], [gradient]) = constraint.value_and_jacobian(&body.q);
    let square = dot(&gradient, &gradient);
    if !(value.is_finite() && square.is_finite()) {
        return Err(StartFailure::ConstraintNotFinite { value, position: body.q.to_vec() });
    }
    let length = square.sqrt();
    let scale = largest(&body.q).max(path);

    let [bend] = constraint.hessian_vector(&body.q, &scaled(1.0 / length, &gradient));
    let distance = length / dot(&bend, &bend).sqrt(); // NaN where both are zero
    if length == 0.0 || distance < SINGULAR_DISTANCE * scale {
        return Err(StartFailure::SingularPoint {
            gradient: length,
            distance: if length == 0.0 { 0.0 } else { distance },
        });
    }
    let distance = value.abs() / length;
    let tolerance = START_TOLERANCE * scale;
    if distance > tolerance {
        return Err(StartFailure::OffSurface { distance, tolerance, value });
    }
    let along_normal = dot(&gradient, &body.p).abs() / length;
    let speed = dot(&body.p, &body.p).sqrt();
    if along_normal > START_TOLERANCE * speed {
        return Err(StartFailure::NotTangent { sine: along_normal / speed, tolerance: START_TOLERANCE });
    }
    Ok(())
}

fn finite<const D: usize>(quantity: &'static str, x: &[f64; D]) -> Result<(), StartFailure> {
    match x.iter().position(|x| !x.is_finite()) {
        Some(component) => Err(StartFailure::NotFinite { quantity, component, value: x[component] }),
        None => Ok(()),
    }
}

/// Every body at a nearby point of the surface, its momentum without the normal part.
pub(crate) fn project<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    constraint: &K,
    state: &State<D>,
) -> Result<State<D>, Error> {
    let bodies = state.bodies.iter().enumerate();
    let project = |(i, body)| project_body(constraint, body).map_err(|cause| Error::Start { body: i, cause });
    Ok(State { bodies: bodies.map(project).collect::<Result<_, _>>()? })
}

/// Newton's iteration q ← q − ∇g g/|∇g|², to the rounding floor.
fn project_body<K: ConstraintKernel<f64, D, 1>, const D: usize>(
    constraint: &K,
    body: &Body<f64, D>,
) -> Result<Body<f64, D>, StartFailure> {
    finite("position", &body.q)?;
    finite("momentum", &body.p)?;
    let mut q = body.q;
    let mut distances = Vec::new();
    for _ in 0..MAX_PROJECTION_STEPS {
        let ([value], [gradient]) = constraint.value_and_jacobian(&q);
        let square = dot(&gradient, &gradient);
        if !(value.is_finite() && square.is_finite()) {
            return Err(StartFailure::ConstraintNotFinite { value, position: q.to_vec() });
        }
        if square == 0.0 {
            return Err(StartFailure::SingularPoint { gradient: 0.0, distance: 0.0 });
        }
        let distance = value.abs() / square.sqrt();
        let stalled = distances.last().is_some_and(|&last: &f64| distance >= 0.5 * last);
        let floor = f64::EPSILON * largest(&q);
        if distance <= floor || (stalled && distance <= 1e4 * floor) {
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
