//! Linked and rigid bodies.

#[path = "../common/mod.rs"]
mod common;
#[path = "../driven.rs"]
mod driven;
#[path = "../linked.rs"]
mod linked;
#[path = "../linked_acting.rs"]
mod linked_acting;
#[path = "../linked_edges.rs"]
mod linked_edges;
#[path = "../linked_ends.rs"]
mod linked_ends;
#[path = "../linked_errors.rs"]
mod linked_errors;
#[path = "../linked_metric.rs"]
mod linked_metric;
#[path = "../linked_projections.rs"]
mod linked_projections;
#[path = "../linked_redundant.rs"]
mod linked_redundant;
#[path = "../linked_sizes.rs"]
mod linked_sizes;
#[path = "../linked_starts.rs"]
mod linked_starts;
#[path = "../linked_toggles.rs"]
mod linked_toggles;
#[path = "../linked_ways.rs"]
mod linked_ways;
#[path = "../memory.rs"]
mod memory;
#[path = "../molecules.rs"]
mod molecules;
#[path = "../near_dependence.rs"]
mod near_dependence;
#[path = "../rigid.rs"]
mod rigid;
#[path = "../scaling.rs"]
mod scaling;
