//! Linked bodies.

#![cfg_attr(not(long), allow(dead_code, unused_imports))] // what tests of `cargo long` use

#[path = "../../../tests/common/mod.rs"]
mod common;
#[path = "../hubs.rs"]
mod hubs;
#[path = "../linked_laws.rs"]
mod linked_laws;
#[cfg(long)]
#[path = "../linked_roots.rs"]
mod linked_roots;
#[path = "../linked_runs.rs"]
mod linked_runs;
#[path = "../sheets_linked.rs"]
mod sheets_linked;
