//! A step of a method between two halves of the flows of momenta.
//!
//! ```text
//! A_{h/2} B_{h/2} … step … B_{h/2} A_{h/2}        A, B, … the flows in the order in which a scene names them
//! ```
//!
//! Source: G. Strang, SIAM J. Numer. Anal. 5 (1968) 506.

use crate::motion::capability::Rates;
use crate::motion::failure::Failure;
use crate::motion::method::{Method, View};
use crate::motion::system::{BodiesOf, System};
use crate::motion::witness::Witness;
use crate::number::real::{Mask, Real};
use crate::number::vector::{sum, two_sum};

/// A system with flows, as messages name it.
pub(crate) const FLOW: &str = "bodies under drag or another flow of momenta";

/// Vectors of room for each body: velocities, and changes of momenta.
pub(crate) const ROOM: usize = 2;

/// One step of the method; of a system with flows between two halves of them.
#[inline(always)]
pub(crate) fn step<S: Method, T: Real, Y: System<T, D>, W: Witness<T>, const D: usize>(
    method: &S,
    seen: View<'_, S, T, Y, D>,
    system: &Y,
    bodies: &mut BodiesOf<Y, T, D>,
    memory: &mut [T],
    witness: &mut W,
) -> Result<(), Failure> {
    if const { Y::FLOWS == 0 } {
        return method.step(seen, bodies, memory, witness);
    }
    let half = 0.5 * method.step_size();
    for flow in 0..Y::FLOWS {
        stir(flow, half, system, bodies)?;
    }
    method.step(seen, bodies, memory, witness)?;
    for flow in (0..Y::FLOWS).rev() {
        stir(flow, half, system, bodies)?;
    }
    Ok(())
}

/// Has a flow change the momenta for a time h, and makes them those of motion along the constraints again. Positions, and
/// what is kept there, stay. The change of kinetic energy counts as work.
fn stir<T: Real, Y: System<T, D>, const D: usize>(
    flow: usize,
    h: f64,
    system: &Y,
    bodies: &mut BodiesOf<Y, T, D>,
) -> Result<(), Failure> {
    let (before, work) = (system.kinetic_energy(bodies), bodies.work);
    bodies.with_room(ROOM, |bodies, _, room| {
        let (velocities, changes) = room.split_at_mut(bodies.q.as_ref().len());
        for (body, velocity) in velocities.iter_mut().enumerate() {
            *velocity = system.velocity(bodies, body);
        }
        system.flow(flow, h, bodies, velocities, changes);
        let ones = [T::from_f64(1.0); D];
        for (body, change) in changes.iter().enumerate() {
            let mass = system.rates().map(|rates| rates.mass_product(body, &ones, &ones));
            let pinned = mass.is_ok_and(|mass| mass.le(T::from_f64(0.0)).all());
            if !pinned {
                let (p, p_low) = (&mut bodies.p.as_mut()[body], &mut bodies.p_low.as_mut()[body]);
                (*p, *p_low) = two_sum(p, &sum(p_low, change));
            }
        }
    });
    system.settle(0.0, h, bodies, &mut ())?;
    // Links that move book what they do to make momenta fit; that is in the change of energy too.
    bodies.work = work + (system.kinetic_energy(bodies) - before);
    Ok(())
}
