//! The number of products in a block.

/// The number of products in a block: the doubles in a cache line.
pub const WIDTH: usize = 8;

/// One coefficient of a factor of eight products.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct Block<T>(pub(crate) [T; WIDTH]);
