//! What systems and methods solve alike: when a solve ends, and which root it may end at.

pub(crate) mod root;
pub(crate) mod stop;
