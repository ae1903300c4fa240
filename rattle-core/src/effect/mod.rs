//! Effects: what acts on the bodies besides the constraint. What a scene does not name costs nothing. An effect knows no system.
//!
//! | | of a scene | one of them |
//! |---|---|---|
//! | as users name them | [`Effects`]: `()`, [`With`] | [`Effect`], of a kind: [`OnEach`], [`BetweenPairs`], [`BetweenNear`], [`BetweenNearKinds`], [`BetweenKinds`], [`AlongSurface`], [`Among`], [`Flowing`] |
//! | over a scalar | [`Forces`]: `()`, [`Superposed`] | [`Acting`]: [`ActsOnEach`], [`ActsBetweenPairs`], [`ActsBetweenNear`], [`ActsBetweenKinds`], [`ActsAlong`], [`ActsAmong`], [`ActsByFlow`] |
//! | in lanes of a sweep | [`Swept`] | [`Swept`] |
//!
//! The vector on one body is its [`Force`]. What momenta decide is a [`Flow`].

pub mod along;
pub mod among;
pub mod between_kinds;
pub mod between_near;
pub mod between_pairs;
mod cells;
pub mod flow;
pub mod force;
pub mod laws;
pub mod list;
pub mod moment;
mod near;
pub mod neighbours;
pub mod on_each;
pub mod one;
pub mod swept;
mod tiles;

pub use crate::kernel::kinds::Kinds;
pub use crate::kernel::over::Over;
pub use crate::kernel::within::{Along, Within};
pub use along::{ActsAlong, AlongSurface};
pub use among::{ActsAmong, Among};
pub use between_kinds::{ActsBetweenKinds, BetweenKinds};
pub use between_near::{ActsBetweenNear, BetweenNear, BetweenNearKinds};
pub use between_pairs::{ActsBetweenPairs, BetweenPairs};
pub use flow::{ActsByFlow, Flow, Flowing};
pub use force::{Absent, Force};
pub use list::{Effects, Forces, Superposed, With};
pub use moment::Moment;
pub use on_each::{ActsOnEach, OnEach, SweptOnEach};
pub use one::{Acting, Effect};
pub use swept::Swept;
