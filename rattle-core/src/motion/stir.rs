//! A step of a method between two halves of the flows of momenta.
//!
//! ```text
//! A_{h/2} B_{h/2} … step … B_{h/2} A_{h/2}        A, B, … the flows in the order in which a scene names them
//! ```
//!
//! Source: G. Strang, SIAM J. Numer. Anal. 5 (1968) 506.

use crate::motion::bodies::Bodies;
use crate::motion::failure::Failure;
use crate::motion::method::Method;
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::real::Real;

/// A system with flows, as messages name it.
pub(crate) const FLOW: &str = "bodies under drag or another flow of momenta";

/// One step of the method, of a system with flows between two halves of them.
#[inline(always)]
pub(crate) fn step<S: Method, T: Real, Y: System<T, D>, W: Witness<T>, const D: usize>(
    method: &S,
    system: &Y,
    bodies: &mut Bodies<Y::Count, T, Y::Kept, D>,
    memory: &mut [T],
    witness: &mut W,
) -> Result<(), Failure> {
    let half = 0.5 * method.step_size();
    for flow in 0..system.flows() {
        system.stir(flow, half, bodies)?;
    }
    method.step(system, bodies, memory, witness)?;
    for flow in (0..system.flows()).rev() {
        system.stir(flow, half, bodies)?;
    }
    Ok(())
}
