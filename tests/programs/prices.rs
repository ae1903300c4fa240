//! What accuracy costs, and what is told of errors.

#[path = "../common/mod.rs"]
mod common;
#[path = "../estimates.rs"]
mod estimates;
#[path = "../price.rs"]
mod price;
#[path = "../price_starts.rs"]
mod price_starts;
#[path = "../common/priced.rs"]
#[allow(dead_code, reason = "each test uses its part")]
mod priced;
#[path = "../wishes.rs"]
mod wishes;
#[path = "../wishes_work.rs"]
mod wishes_work;
