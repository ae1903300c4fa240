//! Hard cases, one by one and as a suite.

#[path = "../../../tests/common/mod.rs"]
mod common;
#[path = "../hard_cases.rs"]
mod hard_cases;
#[path = "../suite/main.rs"]
mod suite;
