//! Products side by side.

/// Products side by side: a cache line of doubles.
pub const WIDTH: usize = 8;

/// One coefficient of a factor of eight products.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct Block<T>(pub(crate) [T; WIDTH]);
