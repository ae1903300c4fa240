//! Checks after each step: kinks; sheets, where a method does not follow its root; and for methods without geometric
//! structure, whether the step can belong to the motion. A method that divides its steps has each inner one checked: on
//! the curve through the ends of a long one nothing can be told.
//!
//! RATTLE and related methods follow the root of their position equation and notice where it ends. A power series or an
//! explicit method does not see the constraint inside its step: near a singular point, where normals turn abruptly, it
//! may end anywhere, and is projected from there. Then the energy jumps.

use crate::error::MethodFailure;
use crate::motion::bodies::Saved;
use crate::motion::failure::Failure;
use crate::motion::method::Method;
use crate::motion::system::{BodiesOf, System};
use crate::number::real::Scalar;
use crate::number::vector::dot;

/// Kinetic energy that grows to more than so many times of what was there, and of what forces gave, comes from nowhere:
/// accurate steps stay within a small part of 1.
pub(crate) const FROM_NOWHERE: f64 = 4.0;

/// Kinetic energy that grows by less than so many roundings of the potential energy comes from there.
const ROUNDINGS: f64 = 64.0;

/// Looks at a step of a method, unless the method has done it.
#[inline(always)]
pub(crate) fn check<S: Method, T: Scalar, Y: System<T, D>, const D: usize>(
    method: &S,
    system: &Y,
    before: &Saved<Y::Count, T, D>,
    now: &mut BodiesOf<Y, T, D>,
) -> Result<(), Failure> {
    if const { S::CHECKS } { Ok(()) } else { look::<S, T, Y, D>(method.step_size(), system, before, now) }
}

/// Looks at a step of this length by a method.
#[inline(always)]
pub(crate) fn look<S: Method, T: Scalar, Y: System<T, D>, const D: usize>(
    h: f64,
    system: &Y,
    before: &Saved<Y::Count, T, D>,
    now: &mut BodiesOf<Y, T, D>,
) -> Result<(), Failure> {
    system.check_kinks(before, now)?;
    if const { !S::HAS_STRUCTURE } {
        system.check_normals(h, before, now)?;
        let (was, is) = (system.kinetic_energy(before).to_f64(), system.kinetic_energy(now).to_f64());
        if is > FROM_NOWHERE * was && Y::FLOWS == 0 && !system.moves_with_time() {
            account(h, system, before, now, [was, is])?;
        }
    }
    if const { !S::FOLLOWS_ROOTS } {
        system.check_sheets(h, before, now)?;
    }
    Ok(())
}

/// Looks at an inner step of this length, of a step of which so much was left when it began.
#[inline(always)]
pub(crate) fn look_inside<S: Method, T: Scalar, Y: System<T, D>, const D: usize>(
    method: &S,
    left: f64,
    inner: f64,
    system: &Y,
    before: &Saved<Y::Count, T, D>,
    now: &mut BodiesOf<Y, T, D>,
) -> Result<(), Failure> {
    let looked = look::<S, T, Y, D>(inner, system, before, now);
    looked.map_err(|failure| {
        let whole = method.step_size();
        failure.of_part(1.0 - left / whole, inner / whole)
    })
}

/// Compares the kinetic energies with what forces and constraints gave. Evaluates potentials, which may allocate.
#[cold]
#[inline(never)]
fn account<T: Scalar, Y: System<T, D>, const D: usize>(
    h: f64,
    system: &Y,
    before: &Saved<Y::Count, T, D>,
    now: &BodiesOf<Y, T, D>,
    [was, is]: [f64; 2],
) -> Result<(), Failure> {
    let potentials = [system.potential_energy(before), system.potential_energy(now)].map(T::to_f64);
    let works = [before.work, now.work].map(T::to_f64);
    // Near rest the change of energies is the rounding of each.
    let rounding = ROUNDINGS * T::EPSILON * (potentials[0].abs() + potentials[1].abs() + works[1].abs());
    let given = (potentials[0] - potentials[1]).abs() + (works[1] - works[0]).abs() + rounding;
    let from_nowhere = is > FROM_NOWHERE * (was + given);
    if !from_nowhere {
        return Ok(());
    }
    let energy = |body: usize| dot(&now.p.as_ref()[body], &system.velocity(now, body)).to_f64();
    let bodies = 0..now.p.as_ref().len();
    let body = bodies.fold(0, |most, body| if energy(body) > energy(most) { body } else { most });
    Err(Failure { body, cause: MethodFailure::EnergyFromNowhere { h, before: was, after: is, given }.into() })
}
