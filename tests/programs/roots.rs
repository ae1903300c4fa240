//! Which root a step ends at, how it is found, and what happens where there is none.

#![cfg_attr(not(long), allow(dead_code, unused_imports))] // what tests of `cargo long` use

#[path = "../common/mod.rs"]
mod common;
#[path = "../far_along.rs"]
mod far_along;
#[path = "../golden.rs"]
mod golden;
#[path = "../guesses.rs"]
mod guesses;
#[path = "../iterations.rs"]
mod iterations;
#[path = "../iterations_lanes.rs"]
mod iterations_lanes;
#[path = "../kinks.rs"]
mod kinks;
#[path = "../kinks_hidden.rs"]
mod kinks_hidden;
#[path = "../kinks_phase.rs"]
mod kinks_phase;
#[path = "../kinks_projected.rs"]
mod kinks_projected;
#[path = "../kinks_smooth.rs"]
mod kinks_smooth;
#[path = "../kinks_starts.rs"]
mod kinks_starts;
#[path = "../laws.rs"]
mod laws;
#[path = "../near_the_origin.rs"]
mod near_the_origin;
#[path = "../phase_rounding.rs"]
mod phase_rounding;
#[path = "../phase_starts.rs"]
mod phase_starts;
#[path = "../phase_steps.rs"]
mod phase_steps;
#[path = "../phase_units.rs"]
mod phase_units;
#[path = "../references.rs"]
mod references;
#[path = "../retry.rs"]
mod retry;
#[path = "../reversal.rs"]
mod reversal;
#[path = "../shadow.rs"]
mod shadow;
#[path = "../singular_points.rs"]
mod singular_points;
#[path = "../variable.rs"]
mod variable;
#[path = "../wrapped.rs"]
mod wrapped;
