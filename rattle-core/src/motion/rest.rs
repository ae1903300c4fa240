//! The tangent part of momenta, and the part that moving constraints impose.

use crate::motion::failure::Failure;
use crate::motion::parts::BodiesOf;
use crate::motion::system::System;
use crate::number::real::Scalar;
use crate::number::vector::add_scaled;

/// Makes momenta those of motion along the constraints. The bodies stay; `aside` is room for two vectors of each.
///
/// # Errors
/// As [`settle`](System::settle).
fn settled<T: Scalar, Y: System<T, D>, const D: usize>(
    system: &Y,
    bodies: &mut BodiesOf<Y, T, D>,
    momenta: &mut [[T; D]],
    aside: &mut [[T; D]],
) -> Result<(), Failure> {
    let (p, low) = aside.split_at_mut(momenta.len());
    let work = bodies.work;
    p.copy_from_slice(bodies.p.as_ref());
    low.copy_from_slice(bodies.p_low.as_ref());
    bodies.p.as_mut().copy_from_slice(momenta);
    bodies.p_low.as_mut().fill([T::from_f64(0.0); D]);
    let done = system.settle(0.0, 1.0, bodies, &mut ());
    momenta.copy_from_slice(bodies.p.as_ref());
    bodies.p.as_mut().copy_from_slice(p);
    bodies.p_low.as_mut().copy_from_slice(low);
    bodies.work = work;
    done
}

/// Writes the momenta of least kinetic energy that constraints which move allow; zeros where they stand still. `aside`
/// is room as above.
///
/// # Errors
/// As [`settle`](System::settle).
pub(crate) fn imposed<T: Scalar, Y: System<T, D>, const D: usize>(
    system: &Y,
    bodies: &mut BodiesOf<Y, T, D>,
    momenta: &mut [[T; D]],
    aside: &mut [[T; D]],
) -> Result<(), Failure> {
    momenta.fill([T::from_f64(0.0); D]);
    if system.constraints_move() { settled(system, bodies, momenta, aside) } else { Ok(()) }
}

/// Takes from impulses what is not along the constraints, and what would move pinned bodies. `imposed` are the momenta
/// [above](imposed), `aside` is room as there.
///
/// # Errors
/// As [`settle`](System::settle).
pub(crate) fn along<T: Scalar, Y: System<T, D>, const D: usize>(
    system: &Y,
    bodies: &mut BodiesOf<Y, T, D>,
    impulses: &mut [[T; D]],
    imposed: &[[T; D]],
    aside: &mut [[T; D]],
) -> Result<(), Failure> {
    for (body, impulse) in impulses.iter_mut().enumerate() {
        if system.inertia().is_pinned(body) {
            *impulse = [T::from_f64(0.0); D];
        }
    }
    settled(system, bodies, impulses, aside)?;
    let back =
        |(along, imposed): (&mut [T; D], &[T; D])| *along = add_scaled(along, T::from_f64(-1.0), imposed);
    impulses.iter_mut().zip(imposed).for_each(back);
    Ok(())
}
