//! The language of the macros, what they derive, and what is refused.

#![cfg_attr(not(long), allow(dead_code, unused_imports))] // what tests of `cargo long` use

#[path = "../common/catalogue.rs"]
#[macro_use]
mod list;

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/complex.rs"]
mod complex;

#[path = "../absent.rs"]
mod absent;
#[path = "../architecture.rs"]
mod architecture;
#[path = "../bad_input.rs"]
mod bad_input;
#[path = "../derivative_edges.rs"]
mod derivative_edges;
#[path = "../derivative_references.rs"]
mod derivative_references;
#[path = "../derivatives.rs"]
mod derivatives;
#[path = "../functions.rs"]
mod functions;
#[path = "../macro_exact.rs"]
mod macro_exact;
#[path = "../macro_language.rs"]
mod macro_language;
#[path = "../macro_messages.rs"]
mod macro_messages;
#[path = "../mesh.rs"]
mod mesh;
#[path = "../ready_made.rs"]
mod ready_made;
#[path = "../scalars.rs"]
mod scalars;
#[path = "../series.rs"]
mod series;
#[path = "../surfaces.rs"]
mod surfaces;
