//! Long runs, orders and laws of every method.

#![cfg_attr(not(long), allow(dead_code, unused_imports))] // what tests of `cargo long` use

#[cfg(long)]
#[path = "../cells.rs"]
mod cells;
#[path = "../../../tests/common/mod.rs"]
mod common;
#[cfg(long)]
#[path = "../drifts.rs"]
mod drifts;
#[path = "../events.rs"]
mod events;
#[path = "../every_method.rs"]
mod every_method;
#[cfg(long)]
#[path = "../fekete.rs"]
mod fekete;
#[path = "../long_runs.rs"]
mod long_runs;
#[path = "../methods.rs"]
mod methods;
#[path = "../near_pairs.rs"]
mod near_pairs;
#[cfg(long)]
#[path = "../random_input.rs"]
mod random_input;
#[cfg(long)]
#[path = "../random_motion.rs"]
mod random_motion;
