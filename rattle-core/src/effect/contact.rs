//! Contacts: what bodies meet in an instant, hard particles and walls. A contact is no force: it changes momenta at
//! once, at the instant at which its gap closes, see
//! [`Simulation::collide`](crate::run::simulation::Simulation::collide).
//!
//! ```text
//! gap(q) ≥ 0                                positive while apart
//! p⁺ = p + J w,   w = P ∇gap                P makes momenta those of motion along the constraints
//! J  = −(1 + e) (w·M⁻¹p) / (w·M⁻¹w)         the rate of the gap turns round, times the restitution e
//! ```
//!
//! With e = 1 this is a reflection in the metric M⁻¹, so that kinetic energy is kept; with e = 0 the gap no longer
//! closes. Source: B. Brogliato, *Nonsmooth Mechanics*, 2016, chapter 4.

use crate::error::{Error, NetworkMistake};
use std::fmt::Debug;

/// The parts of ∇gap: a body, and ∂gap/∂q of that body.
pub type Gradient<const D: usize> = Vec<(usize, [f64; D])>;

/// Contacts of one kind among bodies with D coordinates: ready-made are [`HardSpheres`](crate::effect::HardSpheres) and
/// [`Stop`](crate::effect::Stop).
///
/// Contacts are numbered. A gap is a smooth function of positions, in any unit; where bodies go straight on, it
/// should bend upwards (|qᵢ − qⱼ|² − d², not |qᵢ − qⱼ| − d), because a step in which the gap falls first and rises
/// then is searched only where the tangents at its two ends meet below zero: what bends upwards lies above its
/// tangents, and is never missed.
pub trait Contacts<const D: usize>: Debug + Send + Sync + 'static {
    /// The name of the contacts in messages.
    fn name(&self) -> &'static str;
    /// The restitution e: the speed of parting over that of meeting, 0 to 1.
    fn restitution(&self) -> f64;
    /// Whether the contacts make sense among so many bodies.
    ///
    /// # Errors
    /// A body that there is not, a restitution that is none.
    fn check(&self, bodies: usize) -> Result<(), Error>;
    /// Writes the numbers of all contacts that can have been closed on the way to these positions, if no body went
    /// farther than `way`; more may be written. `room` is kept from call to call. Neither panics nor, but for the
    /// growth of the lists, allocates.
    fn near(&self, positions: &[[f64; D]], way: f64, room: &mut Vec<usize>, found: &mut Vec<usize>);
    /// The gap of this contact, and ∇gap, which is written into an empty list.
    fn gap(&self, contact: usize, positions: &[[f64; D]], gradient: &mut Gradient<D>) -> f64;
}

/// Refuses a restitution that is not between 0 and 1.
pub(crate) fn check_restitution(e: f64) -> Result<(), Error> {
    if (0.0..=1.0).contains(&e) { Ok(()) } else { Err(Error::Restitution(e)) }
}

/// Refuses the first member that names a body beyond the last one, or a body twice.
pub(crate) fn check_members<const A: usize>(
    what: &'static str,
    members: &[[usize; A]],
    bodies: usize,
) -> Result<(), Error> {
    for (member, of) in members.iter().enumerate() {
        for (end, &body) in of.iter().enumerate() {
            if body >= bodies {
                return Err(Error::Network(NetworkMistake::NoSuchBody { what, member, body, bodies }));
            }
            if of[..end].contains(&body) {
                return Err(Error::Network(NetworkMistake::Repeated { what, member, body }));
            }
        }
    }
    Ok(())
}
