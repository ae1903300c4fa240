//! The systems that methods move. A system knows no method and no scene.

pub mod linked;
pub mod network;
pub mod phase;
pub mod rigid;
pub mod surface;
