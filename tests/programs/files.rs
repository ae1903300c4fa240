//! Files, pages, charts and whatever is read.

#![cfg_attr(not(long), allow(dead_code, unused_imports))] // what tests of `cargo long` use

#[path = "../bars.rs"]
mod bars;
#[path = "../checkpoint_links.rs"]
mod checkpoint_links;
#[path = "../checkpoints.rs"]
mod checkpoints;
#[path = "../common/mod.rs"]
mod common;
#[path = "../data.rs"]
mod data;
#[path = "../other_runs.rs"]
mod other_runs;
#[path = "../other_sweeps.rs"]
mod other_sweeps;
#[path = "../page.rs"]
mod page;
#[path = "../page_data.rs"]
mod page_data;
#[path = "../page_edges.rs"]
mod page_edges;
#[path = "../plot.rs"]
mod plot;
#[path = "../plot_ticks.rs"]
mod plot_ticks;
#[path = "../price_page.rs"]
mod price_page;
#[path = "../recorded.rs"]
mod recorded;
#[path = "../recorders.rs"]
mod recorders;
#[path = "../saving_by_time.rs"]
mod saving_by_time;
#[path = "../written.rs"]
mod written;
