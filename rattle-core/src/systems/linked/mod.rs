//! Linked bodies: a [network](crate::systems::network) of any number of constraints, with any masses.

mod abreast;
mod aim;
mod chords;
mod collocation;
mod diagnosis;
mod drift_abreast;
mod few;
mod flight;
mod hold;
mod in_rows;
pub(crate) mod kept;
mod rates;
mod room;
mod series;
mod settle_abreast;
mod sheets;
mod start;
mod strip;
mod system;

pub use kept::{Counts, Kept, Linked};
