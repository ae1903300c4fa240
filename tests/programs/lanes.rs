//! What goes side by side in lanes.

#![cfg_attr(not(long), allow(dead_code, unused_imports))] // what tests of `cargo long` use

#[path = "../common/mod.rs"]
mod common;
#[path = "../lanes_brownian.rs"]
mod lanes_brownian;
#[path = "../lanes_brownian_linked.rs"]
mod lanes_brownian_linked;
#[path = "../lanes_drift.rs"]
mod lanes_drift;
#[path = "../lanes_flows.rs"]
mod lanes_flows;
#[path = "../lanes_flows_linked.rs"]
mod lanes_flows_linked;
#[path = "../lanes_flows_rigid.rs"]
mod lanes_flows_rigid;
#[path = "../lanes_heat.rs"]
mod lanes_heat;
#[path = "../lanes_linked.rs"]
mod lanes_linked;
#[path = "../lanes_lobatto_linked.rs"]
mod lanes_lobatto_linked;
#[path = "../lanes_narrow.rs"]
mod lanes_narrow;
#[path = "../lanes_neighbours.rs"]
mod lanes_neighbours;
#[path = "../lanes_phase.rs"]
mod lanes_phase;
#[path = "../lanes_projected.rs"]
mod lanes_projected;
#[path = "../lanes_projected_linked.rs"]
mod lanes_projected_linked;
#[path = "../lanes_projected_rigid.rs"]
mod lanes_projected_rigid;
#[path = "../lanes_reversal.rs"]
mod lanes_reversal;
#[path = "../lanes_rigid.rs"]
mod lanes_rigid;
#[path = "../lanes_splittings.rs"]
mod lanes_splittings;
#[path = "../lanes_starts.rs"]
mod lanes_starts;
#[path = "../lanes_taylor_linked.rs"]
mod lanes_taylor_linked;
#[path = "../lanes_taylor_rigid.rs"]
mod lanes_taylor_rigid;
#[path = "../sights_in_lanes.rs"]
mod sights_in_lanes;
#[path = "../sweeps_linked.rs"]
mod sweeps_linked;
#[path = "../sweeps_rigid.rs"]
mod sweeps_rigid;
#[path = "../units.rs"]
mod units;
