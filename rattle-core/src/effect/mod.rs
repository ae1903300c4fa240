//! Effects: what acts on the bodies besides the constraint. What a scene does not name costs nothing. An effect knows no system.

pub mod among;
pub mod between_pairs;
pub mod force;
pub mod list;
pub mod on_each;
pub mod one;
pub mod swept;
mod tiles;

pub use crate::kernel::over::Over;
pub use among::Among;
pub use between_pairs::BetweenPairs;
pub use force::{Absent, Force};
pub use list::{Effects, Field, Superposed, With};
pub use on_each::{OnEach, OnEachLane};
pub use one::{Acting, Effect};
pub use swept::Swept;
