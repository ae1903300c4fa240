//! Hard cases, one by one and as a suite.

#![cfg_attr(not(long), allow(dead_code, unused_imports))] // what tests of `cargo long` use

#[path = "../../../tests/common/mod.rs"]
mod common;
#[path = "../hard_cases.rs"]
mod hard_cases;
#[path = "../suite/main.rs"]
mod suite;
