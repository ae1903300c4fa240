//! Long runs, orders and laws of every method.

#[path = "../../../tests/common/mod.rs"]
mod common;
#[path = "../drifts.rs"]
mod drifts;
#[path = "../events.rs"]
mod events;
#[path = "../every_method.rs"]
mod every_method;
#[path = "../fekete.rs"]
mod fekete;
#[path = "../long_runs.rs"]
mod long_runs;
#[path = "../methods.rs"]
mod methods;
#[path = "../near_pairs.rs"]
mod near_pairs;
