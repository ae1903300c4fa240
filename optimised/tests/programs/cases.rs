//! Hard cases, and the generators that find the next ones.

#[path = "../../../tests/common/mod.rs"]
mod common;
#[path = "../hard_cases.rs"]
mod hard_cases;
#[path = "../random_surfaces.rs"]
mod random_surfaces;
#[path = "../sheets.rs"]
mod sheets;
#[path = "../sheets_lanes.rs"]
mod sheets_lanes;
#[path = "../stopping.rs"]
mod stopping;
#[path = "../suite/main.rs"]
mod suite;
