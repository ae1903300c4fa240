//! Steps that are taken seldom, compiled in one place.

use crate::methods::able::view;
use crate::motion::method::Method;
use crate::motion::parts::BodiesOf;
use crate::motion::stir::step;
use crate::motion::system::System;
use crate::motion::witness::{Hears, Whoever};
use crate::run::trouble::Trouble;

/// A step that is seldom taken, in one place.
#[cold]
#[inline(never)]
pub(in crate::run) fn seldom<Y: System<f64, D>, S: Method, const D: usize>(
    method: &S,
    system: &Y,
    bodies: &mut BodiesOf<Y, f64, D>,
    memory: &mut [f64],
    witness: &mut dyn Hears<f64>,
) -> Result<(), Trouble> {
    Ok(step(method, view(method, system)?, system, bodies, memory, &mut Whoever(witness))?)
}
