//! Steps that are taken seldom, compiled in one place.

use crate::methods::able::view;
use crate::motion::bodies::Saved;
use crate::motion::course::check;
use crate::motion::method::Method;
use crate::motion::parts::BodiesOf;
use crate::motion::stir::{Chosen, step};
use crate::motion::system::System;
use crate::motion::witness::{Hears, Whoever};
use crate::run::trouble::Trouble;

/// A step that is seldom taken, in one place; with these flows, where others act [around](crate::motion::stir::draws)
/// all of its parts.
#[cold]
#[inline(never)]
pub(in crate::run) fn seldom<Y: System<f64, D>, S: Method, const D: usize>(
    method: &S,
    system: &Y,
    bodies: &mut BodiesOf<Y, f64, D>,
    memory: &mut [f64],
    witness: &mut dyn Hears<f64>,
    flows: Chosen,
) -> Result<(), Trouble> {
    let (seen, mut witness) = (view(method, system)?, Whoever(witness));
    Ok(step(flows, method, seen, system, bodies, memory, &mut witness)?)
}

/// A part of a step, which is looked at as a step is; returns the [time that it took](Method::time_taken), if the
/// method tells it. Bodies where they were are put into `before`.
#[allow(clippy::too_many_arguments, reason = "a step in parts, of simulations and between events")]
pub(in crate::run) fn part<Y: System<f64, D>, S: Method, const D: usize>(
    method: &S,
    system: &Y,
    bodies: &mut BodiesOf<Y, f64, D>,
    memory: &mut [f64],
    witness: &mut dyn Hears<f64>,
    flows: Chosen,
    before: &mut Saved<Y::Count, f64, D>,
) -> Result<Option<f64>, Trouble> {
    system.put_aside(bodies, before);
    seldom(method, system, bodies, memory, witness, flows)?;
    let taken = method.time_taken(memory);
    check::<S, _, _, D>(taken.unwrap_or(method.step_size()), system, before, bodies)?;
    Ok(taken)
}
