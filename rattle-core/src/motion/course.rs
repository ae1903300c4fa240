//! Checks after each step: kinks; where a method does not follow its root, sheets and the energy; and without geometric
//! structure, normals. A method that divides its steps has each inner one checked: on the curve through the ends of a
//! long one nothing can be told.
//!
//! RATTLE and related methods follow the root of their position equation and notice where it ends. A power series or an
//! explicit method does not see the constraint inside its step, and stages see it in a few places: near a singular
//! point or an edge, where normals turn abruptly, the step may end anywhere, and is projected from there. Then the
//! energy jumps, up or down.

use crate::error::{MethodFailure, StepFailure};
use crate::motion::bodies::Saved;
use crate::motion::capability::Rates;
use crate::motion::failure::Failure;
use crate::motion::method::Method;
use crate::motion::parts::BodiesOf;
use crate::motion::system::System;
use crate::number::real::Scalar;
use crate::number::vector::{add_scaled, dot, largest};

/// An energy that changes by more than this part of what took part in the change has jumped: accurate steps stay far
/// below, and coarse ones of `Bdf2`, which damps, below.
pub(crate) const JUMP: f64 = 0.2;

/// A step that changes the kinetic energy by no more than this factor is not asked for potentials, which take time:
/// without forces it has not jumped.
pub(crate) const STEADY: f64 = (1.0 + JUMP) / (1.0 - JUMP);

/// A jump by less than so many roundings of the potential energy comes from there; and a way of less than so many of
/// places is none.
const ROUNDINGS: f64 = 64.0;

/// An inner step that is [moved](moved) onto the constraints by so many times the tolerance is too long: of the right
/// ones that were looked at none was by more than a few times it.
pub(crate) const ASTRAY: f64 = 64.0;

/// By so many roundings of places and ways it may be moved.
pub(crate) const ROUNDINGS_OF_WAYS: f64 = 256.0;

/// Looks at a step of this length by a method, unless the method has done it.
#[inline(always)]
pub(crate) fn check<S: Method, T: Scalar, Y: System<T, D>, const D: usize>(
    h: f64,
    system: &Y,
    before: &Saved<Y::Count, T, D>,
    now: &mut BodiesOf<Y, T, D>,
) -> Result<(), Failure> {
    if const { S::CHECKS } { Ok(()) } else { look::<S, T, Y, D>(h, system, before, now) }
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
    }
    if const { !S::FOLLOWS_ROOTS } {
        check_energy(h, system, before, now)?;
        system.check_sheets(h, before, now)?;
    }
    Ok(())
}

/// The kink that lies ahead of bodies which have coasted from where they were saved: straight on, or where the
/// constraints would take them from there.
#[cold]
pub(crate) fn kink_ahead<T: Scalar, Y: System<T, D>, const D: usize>(
    system: &Y,
    before: &Saved<Y::Count, T, D>,
    bodies: &mut BodiesOf<Y, T, D>,
) -> Option<Failure> {
    let straight = system.check_kinks(before, bodies).err();
    straight.or_else(|| {
        system.lean(before, bodies);
        let mut led = system.check_kinks(before, bodies).err()?;
        if let StepFailure::Kink { along, .. } = &mut led.cause {
            *along = true;
        }
        Some(led)
    })
}

/// Looks at the energy after a step of this length.
#[inline(always)]
pub(crate) fn check_energy<T: Scalar, Y: System<T, D>, const D: usize>(
    h: f64,
    system: &Y,
    before: &Saved<Y::Count, T, D>,
    now: &BodiesOf<Y, T, D>,
) -> Result<(), Failure> {
    let (was, is) = (system.kinetic_energy(before).to_f64(), system.kinetic_energy(now).to_f64());
    let changes = is > STEADY * was || was > STEADY * is;
    if changes && system.keeps_energy() { account(h, system, before, now, [was, is]) } else { Ok(()) }
}

/// Takes bodies onto the constraints from where an inner step of this length led regardless of them. The inner failure
/// is a kink before that place: from beyond a sharp edge Newton's iteration goes to and fro, and ends on the edge
/// itself, which by rounding may be this side of it, so that the place where it ends tells nothing.
#[inline(always)]
pub(crate) fn land<T: Scalar, Y: System<T, D>, const D: usize>(
    h: f64,
    (system, rates): (&Y, &Y::Rates),
    before: &Saved<Y::Count, T, D>,
    bodies: &mut BodiesOf<Y, T, D>,
) -> Result<Result<(), Failure>, Failure> {
    let ahead = system.check_kinks(before, bodies);
    let landed = rates.project(h, bodies).and_then(|()| system.settle(0.0, h, bodies, &mut ()));
    if ahead.is_ok() { landed.map(|()| ahead) } else { Ok(ahead) }
}

/// The velocity that a body would have with this momentum where it is: of a rate of momenta, what velocities change by.
#[inline(always)]
pub(crate) fn velocity_of<T: Scalar, Y: System<T, D>, const D: usize>(
    system: &Y,
    bodies: &mut BodiesOf<Y, T, D>,
    body: usize,
    momentum: [T; D],
) -> [T; D] {
    let own = std::mem::replace(&mut bodies.p.as_mut()[body], momentum);
    let velocity = system.velocity(bodies, body);
    bodies.p.as_mut()[body] = own;
    velocity
}

/// By how much bodies were moved onto the constraints at the end of an inner step, with velocities times the whole
/// step, beyond what may be rounding; the most of all bodies, and of which body. `led` are places and momenta before.
/// It is a part of the error, whatever the estimate of the method: where a constraint bends between two stages, as a
/// rounded edge does, none of them knows of it.
#[inline(always)]
pub(crate) fn moved<T: Scalar, Y: System<T, D>, const D: usize>(
    whole: f64,
    system: &Y,
    bodies: &mut BodiesOf<Y, T, D>,
    [places, momenta]: [&[[T; D]]; 2],
) -> (f64, usize) {
    let [h, minus, rounding] = [whole.abs(), -1.0, ROUNDINGS_OF_WAYS * T::EPSILON].map(T::from_f64);
    let mut worst = (0.0, 0);
    for body in 0..bodies.q.as_ref().len() {
        let (q, p) = (bodies.q.as_ref()[body], bodies.p.as_ref()[body]);
        let size = largest(&q) + h * largest(&system.velocity(bodies, body));
        let way = add_scaled(&q, minus, &places[body]);
        let change = velocity_of(system, bodies, body, add_scaled(&p, minus, &momenta[body]));
        let moved = dot(&way, &way).sqrt() + h * dot(&change, &change).sqrt() - rounding * size;
        if moved.to_f64() > worst.0 {
            worst = (moved.to_f64(), body);
        }
    }
    worst
}

/// Looks at an inner step of this length, of a step of which so much was left when it began, that has
/// [landed](land) so.
#[inline(always)]
pub(crate) fn look_inside<S: Method, T: Scalar, Y: System<T, D>, const D: usize>(
    method: &S,
    [left, inner]: [f64; 2],
    system: &Y,
    before: &Saved<Y::Count, T, D>,
    now: &mut BodiesOf<Y, T, D>,
    landed: Result<(), Failure>,
) -> Result<(), Failure> {
    let looked = landed.and_then(|()| look::<S, T, Y, D>(inner, system, before, now));
    looked.map_err(|failure| {
        let whole = method.step_size();
        failure.of_part(1.0 - left / whole, inner / whole)
    })
}

/// Whether no body goes farther in such a step than places are rounded, some times.
fn rests<T: Scalar, Y: System<T, D>, const D: usize>(
    h: f64,
    system: &Y,
    before: &Saved<Y::Count, T, D>,
    now: &BodiesOf<Y, T, D>,
) -> bool {
    let (mut speed, mut size) = (0.0_f64, 0.0_f64);
    for body in 0..now.q.as_ref().len() {
        let velocities = [system.velocity(before, body), system.velocity(now, body)];
        velocities.iter().for_each(|v| speed = speed.max(largest(v).to_f64()));
        size = size.max(largest(&now.q.as_ref()[body]).to_f64());
    }
    h.abs() * speed <= ROUNDINGS * T::EPSILON * size
}

/// Whether forces at both ends of a step give what the kinetic energy changes by. Potentials whose terms cancel, at a
/// minimum say, are rounded to more than they and a slow motion have.
fn forces_gave<T: Scalar, Y: System<T, D>, const D: usize>(
    h: f64,
    system: &Y,
    before: &Saved<Y::Count, T, D>,
    now: &BodiesOf<Y, T, D>,
    change: f64,
    taking_part: f64,
) -> bool {
    let mut pushes = vec![[T::from_f64(0.0); D]; now.q.as_ref().len()];
    // Along the constraints: what forces and constraints have in common across them is large, and cancels.
    let mut power = |bodies: &mut BodiesOf<Y, T, D>| {
        system.settle(0.0, h, bodies, &mut ()).ok()?;
        system.pushes(bodies, &mut pushes).ok()?;
        let each = bodies.p.as_ref().iter().zip(&pushes).enumerate();
        // p·M⁻¹ṗ: of a rigid body q̈ is no rate of its momentum.
        let powers = each.map(|(body, (p, push))| dot(p, &system.inertia().velocity(body, push)).to_f64());
        Some(powers.sum::<f64>())
    };
    let mut there = now.clone();
    let last = power(&mut there);
    system.put_back(&mut there, before);
    let (Some(first), Some(last)) = (power(&mut there), last) else { return false };
    let given = 0.5 * h * (first + last);
    (change - given).abs() <= JUMP * (taking_part + given.abs())
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
    let (fallen, worked) = (potentials[0] - potentials[1], works[1] - works[0]);
    // Near rest the change of energies is the rounding of each.
    let rounding = ROUNDINGS * T::EPSILON * (potentials[0].abs() + potentials[1].abs() + works[1].abs());
    let (given, taking_part) = (fallen + worked, was + is + fallen.abs() + worked.abs());
    let jumped = (is - was - given).abs() > JUMP * taking_part + rounding;
    if !jumped || rests(h, system, before, now) || forces_gave(h, system, before, now, is - was, was + is) {
        return Ok(());
    }
    let energy = |body: usize| {
        let p = &now.p.as_ref()[body];
        dot(p, &system.inertia().velocity(body, p)).to_f64()
    };
    let bodies = 0..now.p.as_ref().len();
    let body = bodies.fold(0, |most, body| if energy(body) > energy(most) { body } else { most });
    Err(Failure { body, cause: MethodFailure::EnergyJump { h, before: was, after: is, given }.into() })
}
