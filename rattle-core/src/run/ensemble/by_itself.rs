//! Bodies of a lane that goes by itself, as a simulation; and its steps by [`Dop853`].

use crate::methods::dop853::Dop853;
use crate::motion::bodies::Body;
use crate::motion::failure::Failure;
use crate::motion::method::{Method, View};
use crate::motion::parts::BodiesOf;
use crate::motion::system::System;
use crate::run::ensemble::engine::Moved;

/// These bodies of a system in this room, which is made where there is none.
pub(super) fn placed<'a, Y: System<f64, D>, const D: usize>(
    system: &Y,
    places: &[Body<f64, D>],
    room: &'a mut Option<BodiesOf<Y, f64, D>>,
) -> &'a mut BodiesOf<Y, f64, D> {
    let Some(bodies) = room else { return room.insert(system.bodies(places, 0.0)) };
    for (i, &Body { q, q_low, p, p_low }) in places.iter().enumerate() {
        (bodies.q.as_mut()[i], bodies.q_low.as_mut()[i]) = (q, q_low);
        (bodies.p.as_mut()[i], bodies.p_low.as_mut()[i]) = (p, p_low);
    }
    system.refresh(bodies);
    bodies
}

/// Takes bodies a step on.
///
/// # Errors
/// Those of the method.
pub(super) fn step<Y: System<f64, D>, const D: usize>(
    method: &Dop853,
    view: View<'_, Dop853, f64, Y, D>,
    bodies: &mut BodiesOf<Y, f64, D>,
) -> Result<(), Failure> {
    method.prepare::<f64, Y, D>(view, bodies);
    method.step::<f64, Y, _, D>(view, bodies, &mut [], &mut ())
}

/// Where bodies are after so many steps, each in so many equal parts.
///
/// # Errors
/// Those of the method.
pub(super) fn steps<Y: System<f64, D>, const D: usize>(
    method: &Dop853,
    view: View<'_, Dop853, f64, Y, D>,
    bodies: &[Body<f64, D>],
    steps: u64,
    parts: u32,
) -> Result<Moved<D>, Failure> {
    let part = method.with_step(method.step_size() / f64::from(parts));
    let mut bodies = view.0.bodies(bodies, 0.0);
    (0..steps * u64::from(parts)).try_for_each(|_| step(&part, view, &mut bodies))?;
    Ok((bodies.all(), 0.0))
}
