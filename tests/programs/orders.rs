//! Methods of every order.

#[path = "../adaptive_steps.rs"]
mod adaptive_steps;
#[path = "../bdf2.rs"]
mod bdf2;
#[path = "../common/mod.rs"]
mod common;
#[path = "../compositions.rs"]
mod compositions;
#[path = "../dop853.rs"]
mod dop853;
#[path = "../hamiltonians.rs"]
mod hamiltonians;
#[path = "../lobatto.rs"]
mod lobatto;
#[path = "../lobatto_ends.rs"]
mod lobatto_ends;
#[path = "../lobatto_linked.rs"]
mod lobatto_linked;
#[path = "../planted_faults.rs"]
mod planted_faults;
#[path = "../sources.rs"]
mod sources;
#[path = "../staggered.rs"]
mod staggered;
#[path = "../systems.rs"]
mod systems;
#[path = "../taylor.rs"]
mod taylor;
#[path = "../taylor_linked.rs"]
mod taylor_linked;
