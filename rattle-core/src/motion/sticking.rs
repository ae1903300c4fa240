//! Bodies that flows hold, as dry friction does: they stay where they are.
//!
//! Such a flow gives a body at rest, before the step, what the forces of half a step will take. A method that begins
//! with a kick takes it before the body moves. Others let it go forth and back within the step; where the force changes
//! on the way, not quite back, and the body would creep. So a body that rests before the step and after it is put back.

use crate::motion::failure::Failure;
use crate::motion::parts::{BodiesOf, Given};
use crate::motion::system::System;
use crate::number::real::Scalar;
use crate::number::vector::{add_scaled, dot, largest};

/// Vectors that are [lent](crate::motion::bodies::Bodies::lend), for each body.
pub(crate) const ROOM: usize = 4;

/// What rounding may leave of the momentum that a flow gives a body at rest.
const STILL: f64 = 64.0 * f64::EPSILON;

/// Makes a step: flows before it, the step itself, and flows after it. Bodies that are at rest before the first and
/// after the last are put back; what flows did to them is no work.
#[inline(never)]
pub(super) fn step<T: Scalar, Y: System<T, D>, const D: usize>(
    system: &Y,
    bodies: &mut BodiesOf<Y, T, D>,
    first: impl FnOnce(&mut BodiesOf<Y, T, D>) -> Result<(), Failure>,
    middle: impl FnOnce(&mut BodiesOf<Y, T, D>) -> Result<(), Failure>,
    last: impl FnOnce(&mut BodiesOf<Y, T, D>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let n = bodies.q.as_ref().len();
    let mut lent = bodies.lend(ROOM * n);
    let (q, others) = lent.split_at_mut(n);
    let (q_low, others) = others.split_at_mut(n);
    let (given, left) = others.split_at_mut(n);
    q.copy_from_slice(bodies.q.as_ref());
    q_low.copy_from_slice(bodies.q_low.as_ref());
    given.copy_from_slice(bodies.p.as_ref());
    let mut done = first(bodies);
    for (given, p) in given.iter_mut().zip(bodies.p.as_ref()) {
        let rests = is_still(given, p);
        *given = if rests { *p } else { [T::from_f64(f64::NAN); D] };
    }
    done = done.and_then(|()| middle(bodies));
    left.copy_from_slice(bodies.p.as_ref());
    done = done.and_then(|()| last(bodies));
    if done.is_ok() {
        put_back(system, bodies, [q, q_low], [given, left]);
    }
    bodies.take_back(lent);
    done
}

/// Whether a momentum is none, beside one that a flow gave; not if that is NaN.
fn is_still<T: Scalar, const D: usize>(p: &[T; D], given: &[T; D]) -> bool {
    largest(p).le(T::from_f64(STILL) * largest(given))
}

/// Puts those back that rest again; where bodies are linked, only if all do.
fn put_back<T: Scalar, Y: System<T, D>, const D: usize>(
    system: &Y,
    bodies: &mut BodiesOf<Y, T, D>,
    [q, q_low]: [&[[T; D]]; 2],
    [given, left]: [&[[T; D]]; 2],
) {
    let stays = |bodies: &BodiesOf<Y, T, D>, body: usize| is_still(&bodies.p.as_ref()[body], &given[body]);
    let moved = |bodies: &BodiesOf<Y, T, D>, body: usize| {
        let [high, low] = [(bodies.q.as_ref(), q), (bodies.q_low.as_ref(), q_low)]
            .map(|(now, before)| largest(&add_scaled(&now[body], T::from_f64(-1.0), &before[body])));
        !high.max(low).le(T::from_f64(0.0))
    };
    if !(0..q.len()).any(|body| stays(bodies, body) && moved(bodies, body)) {
        return;
    }
    let nothing = Given::of(0.0, true, bodies.noise);
    let tied = system.show(nothing, bodies, |_, during, _| during.tied);
    if tied && !(0..q.len()).all(|body| stays(bodies, body)) {
        return;
    }
    let energy = |body: usize, p: &[T; D]| T::from_f64(0.5) * dot(p, &system.inertia().velocity(body, p));
    for body in 0..q.len() {
        if stays(bodies, body) {
            (bodies.q.as_mut()[body], bodies.q_low.as_mut()[body]) = (q[body], q_low[body]);
            bodies.work = bodies.work + (energy(body, &left[body]) - energy(body, &given[body]));
        }
    }
    system.refresh(bodies);
    system.evaluate_forces(bodies);
}
