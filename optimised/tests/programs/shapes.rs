//! Shapes: their curvature, random ones, and motion among sheets that are close.

#![cfg_attr(not(long), allow(dead_code, unused_imports))] // what tests of `cargo long` use

#[path = "../../../tests/common/mod.rs"]
mod common;
#[path = "../curvature.rs"]
mod curvature;
#[path = "../random_surfaces.rs"]
mod random_surfaces;
#[path = "../sheets.rs"]
mod sheets;
#[path = "../sheets_lanes.rs"]
mod sheets_lanes;
#[cfg(long)]
#[path = "../stopping.rs"]
mod stopping;
