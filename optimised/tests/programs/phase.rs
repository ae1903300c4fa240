//! Constraints in phase space.

#![cfg_attr(not(long), allow(dead_code, unused_imports))] // what tests of `cargo long` use

#[path = "../../../tests/common/mod.rs"]
mod common;
#[path = "../phase_lanes.rs"]
mod phase_lanes;
#[path = "../phase_sheets.rs"]
mod phase_sheets;
#[path = "../phase_space.rs"]
mod phase_space;
