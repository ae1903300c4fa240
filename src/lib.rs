//! Mechanics with constraints.
pub use rattle_core::{kernel, real};

#[cfg(feature = "data")]
pub mod data;
#[cfg(feature = "plot")]
pub mod plot;
#[cfg(feature = "view")]
pub mod view;
