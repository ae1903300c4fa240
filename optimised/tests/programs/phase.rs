//! Constraints in phase space.

#[path = "../../../tests/common/mod.rs"]
mod common;
#[path = "../phase_lanes.rs"]
mod phase_lanes;
#[path = "../phase_sheets.rs"]
mod phase_sheets;
#[path = "../phase_space.rs"]
mod phase_space;
