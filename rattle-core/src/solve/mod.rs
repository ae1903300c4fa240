//! Solving position equations, shared by all systems and methods: when an iteration ends, which root is the right one,
//! and when constraints are reached.

pub(crate) mod aim;
pub(crate) mod crowd;
pub(crate) mod curve;
pub(crate) mod nearing;
pub(crate) mod root;
pub(crate) mod stop;

use crate::number::real::Scalar;

/// Functions that are compiled in this crate, see [`crate::instances`].
pub(crate) fn instances<T: Scalar>() -> impl Copy {
    [aim::Pace::record::<T> as *const (), aim::Pace::recall::<T> as *const ()]
}
