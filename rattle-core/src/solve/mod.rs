//! What systems and methods solve alike: when a solve ends, which root it may end at, and when constraints are reached.

pub(crate) mod aim;
pub(crate) mod crowd;
pub(crate) mod nearing;
pub(crate) mod root;
pub(crate) mod stop;
