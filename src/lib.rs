//! Mechanics with constraints.
pub use rattle_core::{kernel, real};
