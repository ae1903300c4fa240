//! Bodies of a lane that goes by itself, as a simulation; and its steps.

use crate::motion::bodies::Body;
use crate::motion::course::check;
use crate::motion::failure::Failure;
use crate::motion::method::{Method, View};
use crate::motion::parts::BodiesOf;
use crate::motion::system::System;
use crate::run::ensemble::engine::{Moved, OwnSteps};
use crate::run::ensemble::renewed_lanes;
use crate::run::ensemble::rhythm::Rhythm;
use crate::run::ensemble::splits::Splits;
use crate::run::ensemble::splitting_lanes::{StirredAlone, by_itself, compare_lane};
use crate::run::trouble::Trouble;

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

/// The same, ready for steps of this method, which remembers nothing.
pub(super) fn prepared<'a, S: Method, Y: System<f64, D>, const D: usize>(
    method: &S,
    (system, view): (&Y, View<'_, S, f64, Y, D>),
    places: &[Body<f64, D>],
    room: &'a mut Option<BodiesOf<Y, f64, D>>,
) -> &'a mut BodiesOf<Y, f64, D> {
    let new = room.is_none();
    let bodies = placed(system, places, room);
    if new {
        method.prepare::<f64, Y, D>(view, bodies);
    }
    bodies
}

/// Takes bodies a step on, and looks at it as a simulation does.
///
/// # Errors
/// Those of the method.
pub(super) fn step<S: Method, Y: System<f64, D>, const D: usize>(
    method: &S,
    (system, view): (&Y, View<'_, S, f64, Y, D>),
    bodies: &mut BodiesOf<Y, f64, D>,
) -> Result<(), Failure> {
    if const { S::CHECKS } {
        return method.step::<f64, Y, _, D>(view, bodies, &mut [], &mut ());
    }
    let before = bodies.saved();
    method.step::<f64, Y, _, D>(view, bodies, &mut [], &mut ())?;
    check::<S, f64, Y, D>(method.step_size(), system, &before, bodies)
}

/// Where bodies are after these steps of a method that remembers nothing.
///
/// # Errors
/// Those of the method, or that a step cannot be taken back.
pub(super) fn steps<S: Method, Y: System<f64, D>, const D: usize>(
    method: &S,
    (system, view): (&Y, View<'_, S, f64, Y, D>),
    bodies: &[Body<f64, D>],
    OwnSteps { number, parts, checked, .. }: OwnSteps,
) -> Result<Moved<D>, Trouble> {
    let part = method.with_step(method.step_size() / f64::from(parts));
    let mut bodies = system.bodies(bodies, 0.0);
    part.prepare::<f64, Y, D>(view, &mut bodies);
    for _ in 0..number {
        let start = checked.map(|tolerance| (bodies.saved(), tolerance));
        (0..parts).try_for_each(|_| step(&part, (system, view), &mut bodies))?;
        if let Some((start, tolerance)) = start {
            let (end, back) = (bodies.saved(), part.with_step(-part.step_size()));
            system.put_back(&mut bodies, &end); // the way back begins anew
            let mut step = |_| back.step::<f64, Y, _, D>(view, &mut bodies, &mut [], &mut ());
            let led = (0..parts).try_for_each(&mut step).is_ok();
            compare_lane(&start, &bodies, led, tolerance)?;
            system.put_back(&mut bodies, &end);
        }
    }
    Ok((bodies.all(), 0.0))
}

/// Where bodies are after these steps of a splitting; in this rhythm, if flows act or momenta are drawn anew, with the
/// numbers of this lane and the work on it since the start.
///
/// # Errors
/// Those of a step, or that it cannot be taken back.
pub(super) fn split<Y: System<f64, D>, const D: usize, const W: usize>(
    system: &Y,
    Splits { stages, h, renewal, .. }: &Splits,
    rhythm: Option<&Rhythm<W>>,
    (lane, work): (usize, Option<f64>),
    bodies: &[Body<f64, D>],
    steps: OwnSteps,
    place: &mut u64,
) -> Result<Moved<D>, Trouble> {
    if let (&Some(renewal), Some(rhythm)) = (renewal, rhythm) {
        let noise = |step| rhythm.noise(lane, steps.from + step);
        return Ok(renewed_lanes::by_itself(system, renewal, *h, &noise, steps.number, bodies)?);
    }
    if const { Y::FLOWS > 0 }
        && let Some(rhythm) = rhythm
    {
        let at = |step| (rhythm.noise(lane, steps.from + step), rhythm.now(lane, steps.from + step));
        let stirred = StirredAlone { after: rhythm.after, at: &at, place, work: work.unwrap_or_default() };
        return by_itself(system, stages, Some(stirred), steps, bodies);
    }
    by_itself(system, stages, None, steps, bodies)
}
