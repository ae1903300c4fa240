//! Effects, alone and between bodies.

#![cfg_attr(not(long), allow(dead_code, unused_imports))] // what tests of `cargo long` use

#[path = "../active.rs"]
mod active;
#[path = "../common/mod.rs"]
mod common;
#[path = "../drag.rs"]
mod drag;
#[path = "../effects_room.rs"]
mod effects_room;
#[path = "../effects_time.rs"]
mod effects_time;
#[path = "../fields.rs"]
mod fields;
#[path = "../flows.rs"]
mod flows;
#[path = "../flows_felt.rs"]
mod flows_felt;
#[path = "../gas.rs"]
mod gas;
#[path = "../geodesics.rs"]
mod geodesics;
#[path = "../geodesics_conjugate.rs"]
mod geodesics_conjugate;
#[path = "../geodesics_far.rs"]
mod geodesics_far;
#[path = "../heat.rs"]
mod heat;
#[path = "../heat_divided.rs"]
mod heat_divided;
#[path = "../heat_places.rs"]
mod heat_places;
#[path = "../impacts.rs"]
mod impacts;
#[path = "../impacts_found.rs"]
mod impacts_found;
#[path = "../impacts_held.rs"]
mod impacts_held;
#[path = "../named.rs"]
mod named;
#[path = "../common/names.rs"]
mod names;
#[path = "../pair_potentials.rs"]
mod pair_potentials;
#[path = "../particles.rs"]
mod particles;
#[path = "../points.rs"]
mod points;
#[path = "../sharp_edges.rs"]
mod sharp_edges;
#[path = "../thermostat_rates.rs"]
mod thermostat_rates;
