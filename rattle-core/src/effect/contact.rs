//! Contacts: collisions of hard particles with each other and with walls. A contact is not a force: it changes momenta
//! at the instant at which its gap closes, see [`Simulation::collide`](crate::run::simulation::Simulation::collide).
//!
//! ```text
//! gap(q) ≥ 0                                positive while apart
//! p⁺ = p + J w,   w = P ∇gap                P makes momenta those of motion along the constraints
//! J  = −(1 + e) (∇gap·M⁻¹p) / (∇gap·M⁻¹w)   the rate of the gap turns round, times the restitution e
//! ```
//!
//! With e = 1 this is a reflection in the metric M⁻¹, which conserves kinetic energy; with e = 0 the gap stops closing.
//! Constraints that move with time, like a piston, give or take energy meanwhile, and so do links that act along other
//! directions than their gradients.
//! Source: B. Brogliato, *Nonsmooth Mechanics*, 2016, chapter 4.

use crate::error::{Error, NetworkMistake};
use std::fmt::Debug;

/// ∇gap as a list of bodies, each with ∂gap/∂q of this body.
pub type Gradient<const D: usize> = Vec<(usize, [f64; D])>;

/// Contacts of one kind among bodies with D coordinates: ready-made are [`HardSpheres`](crate::effect::HardSpheres) and
/// [`Stop`](crate::effect::Stop).
///
/// Contacts are numbered. A gap is a smooth function of positions, in any unit. It should be convex along straight
/// lines (take |qᵢ − qⱼ|² − d², not |qᵢ − qⱼ| − d): a step in which the gap first falls and then rises is searched for
/// a contact only where the tangents at its two ends meet below zero. A convex gap lies above its tangents, so none of
/// its contacts is missed.
pub trait Contacts<const D: usize>: Debug + Send + Sync + 'static {
    /// The name of the contacts in error messages.
    fn name(&self) -> &'static str;
    /// The coefficient of restitution e: the speed of separation divided by the speed of approach, 0 to 1.
    fn restitution(&self) -> f64;
    /// What tells these contacts from others of the same name, besides the restitution, such as a diameter: a
    /// checkpoint is refused where these numbers differ.
    fn parameters(&self) -> Vec<f64> {
        Vec::new()
    }
    /// Checks that the contacts make sense for this number of bodies.
    ///
    /// # Errors
    /// For example a body that does not exist, or a restitution outside of 0 to 1.
    fn check(&self, bodies: usize) -> Result<(), Error>;
    /// Writes the numbers of all contacts that may have been closed on the way to these positions, if no body moved
    /// farther than `way`; further contacts may be written too. `room` is working memory, kept between calls. Does not
    /// panic, and allocates only where lists grow.
    fn near(&self, positions: &[[f64; D]], way: f64, room: &mut Vec<usize>, found: &mut Vec<usize>);
    /// Returns the gap of this contact, and writes ∇gap into an empty list.
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
