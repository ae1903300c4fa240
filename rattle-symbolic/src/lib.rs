//! Expressions of `rattle`: what its macros do, as an ordinary library.
//!
//! ```text
//! tokens ─parse─▶ syntax ─lower─▶ graph ─differentiate─▶ more roots ─schedule─▶ binary operations ─emit─▶ Rust
//!                (all mistakes at once, each at its token)     (algebra: sums and products in one form)
//!                                                                        └─recurrence─▶ Rust for power series
//! ```
//!
//! Parsing and lowering may find mistakes; every later stage is a total function. The same input
//! always gives the same tokens.

pub mod expand;

mod parse;
mod parse_expression;
mod syntax;

mod call;
mod lower;
mod names;
mod problems;
mod ratio;

pub mod graph;

pub mod functions;

pub mod differentiate;

pub mod algebra;

pub mod parity;

pub mod routine;

pub mod schedule;

mod emit;

mod recurrence;

mod interface;

mod formula;

pub mod interpret;
