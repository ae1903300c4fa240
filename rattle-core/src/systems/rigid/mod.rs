//! Rigid bodies that turn about their centres of mass, reduced to three unknowns each.

mod body;
mod hold;
mod kept;
mod room;
pub(crate) mod rotation;
mod series;
mod system;

pub use body::Rigid;
pub use kept::{Kept, Turning};
