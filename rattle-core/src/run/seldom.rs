//! Steps that are taken seldom, compiled in one place.

use crate::effect::interval::Half;
use crate::methods::able::view;
use crate::motion::method::Method;
use crate::motion::parts::BodiesOf;
use crate::motion::stir::stir;
use crate::motion::system::System;
use crate::motion::witness::{Hears, Whoever};
use crate::run::trouble::Trouble;

/// A step that is seldom taken, in one place; with flows, unless these act [around](crate::motion::stir::draws) all of
/// its parts.
#[cold]
#[inline(never)]
pub(in crate::run) fn seldom<Y: System<f64, D>, S: Method, const D: usize>(
    method: &S,
    system: &Y,
    bodies: &mut BodiesOf<Y, f64, D>,
    memory: &mut [f64],
    witness: &mut dyn Hears<f64>,
    flows: bool,
) -> Result<(), Trouble> {
    let flows = const { Y::FLOWS > 0 && !S::STIRS } && flows;
    let (seen, half) = (view(method, system)?, 0.5 * method.step_size());
    if flows {
        stir(Half::Before, half, system, bodies)?;
    }
    method.step(seen, bodies, memory, &mut Whoever(witness))?;
    if flows {
        stir(Half::After, half, system, bodies)?;
    }
    Ok(())
}
