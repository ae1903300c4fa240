//! Linked bodies: a [network](crate::systems::network) of any number of constraints, with any masses.

mod aim;
mod chords;
mod collocation;
mod diagnosis;
mod few;
mod flight;
mod hold;
pub(crate) mod kept;
mod rates;
mod room;
mod series;
mod sheets;
mod start;
mod strip;
mod system;

pub use kept::{Counts, Kept, Linked};
