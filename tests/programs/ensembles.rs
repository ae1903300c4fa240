//! Ensembles and what watches runs.

#![cfg_attr(not(long), allow(dead_code, unused_imports))] // what tests of `cargo long` use

#[path = "../common/mod.rs"]
mod common;
#[path = "../ensemble.rs"]
mod ensemble;
#[path = "../ensemble_retry.rs"]
mod ensemble_retry;
#[path = "../observers.rs"]
mod observers;
#[path = "../shown_sheets.rs"]
mod shown_sheets;
#[path = "../single_precision.rs"]
mod single_precision;
#[path = "../sweeps.rs"]
mod sweeps;
#[path = "../watching.rs"]
mod watching;
