//! The work of the macros of `rattle`, as an ordinary library.
//!
//! ```text
//! tokens ─parse─▶ syntax ─lower─▶ graph ─differentiate─▶ more roots ─schedule─▶ binary operations ─emit─▶ Rust
//!                (all mistakes at once, each at its token)     (algebra: sums and products in one form)
//!                                                                        └─recurrence─▶ Rust for power series
//! ```
//!
//! Parsing and lowering may find mistakes; every later stage is a total function. The same input
//! always gives the same tokens.
//!
//! # Layers
//!
//! A module uses only modules of lower lines of this list, and none of its own line.
//!
//! ```text
//! residual
//! expand
//! kernel
//! recurrence
//! emit
//! routine
//! parity
//! lower  differentiate
//! call  rules  held  schedule  formula  kinks
//! arithmetic  algebra  factors
//! names  parse  graph  interface
//! value  parse_expression  macros  operation  headings
//! syntax  node
//! problems  tokens  ratio  functions  limits
//! ```
//!
//! Mistakes are found by `parse` and `lower`. A new function of the language is a row in `functions`. Neither tokens
//! nor Rust are known to the mathematics: `operation`, `graph`, `algebra`, `rules`, `held`, `differentiate`, `parity`,
//! `schedule`, `routine`.

pub use expand::expand;
pub use macros::Macro;
pub use residual::residual;

mod expand;
mod limits;

// Reading: tokens to a graph.
mod headings;
mod macros;
mod parse;
mod parse_expression;
mod parse_number;
mod problems;
mod syntax;
mod tokens;

mod arithmetic;
mod call;
mod lower;
mod names;
mod ratio;
mod value;

// Mathematics: a graph to the graphs of all functions of a kernel.
pub mod algebra;
pub mod differentiate;
mod factors;
pub mod functions;
pub mod graph;
mod held;
mod kinks;
pub mod node;
pub mod operation;
mod parity;
pub mod routine;
mod rules;
pub mod schedule;

// Writing: graphs to Rust.
mod emit;
mod formula;
mod interface;
mod kernel;
mod recurrence;
mod residual;
