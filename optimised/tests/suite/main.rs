//! Hard cases as a table: a row says why naive code breaks there and what holds instead, and measures that.
//!
//! ```text
//! cargo long --test cases suite:: -- --nocapture        prints the table; `cargo test` those that take no seconds
//! cargo long --test cases suite::page -- --ignored     writes docs/hard-cases.md
//! ```
//!
//! To add a row: a `case` in the file of its area, then the page anew. Rows share few types of scenes, by parameters,
//! as each pair of a scene and a method takes a second of compiling.

#![allow(unreachable_pub, reason = "a test of several files")]

mod algebra;
mod case;
mod effects;
mod ensembles;
mod geometry;
mod input;
mod numbers;
mod phase;
mod rigid;
mod scenes;
mod time;

use case::{Area, Case, Kind, Row};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::path::PathBuf;

fn areas() -> Vec<Area> {
    vec![
        Area { name: "Geometry", cases: geometry::cases() },
        Area { name: "Time", cases: time::cases() },
        Area { name: "Algebra", cases: algebra::cases() },
        Area { name: "Numbers", cases: numbers::cases() },
        Area { name: "Phase space", cases: phase::cases() },
        Area { name: "Ensembles", cases: ensembles::cases() },
        Area { name: "Rigid bodies", cases: rigid::cases() },
        Area { name: "Effects", cases: effects::cases() },
        Area { name: "Input", cases: input::cases() },
    ]
}

fn measured() -> Vec<(&'static str, Vec<Row>)> {
    let now = |case: &Case| cfg!(long) || !case.long;
    let rows = |area: Area| (area.name, area.cases.into_par_iter().filter(now).map(Row::of).collect());
    areas().into_iter().map(rows).collect()
}

fn page_on_disk() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../docs/hard-cases.md")
}

#[test]
fn every_case_is_within_its_bound() {
    let mut beyond = Vec::new();
    for (area, rows) in measured() {
        println!("{area}");
        for row in rows {
            println!("{}", row.line());
            if !row.holds() {
                beyond.push(format!("{area}: {}\n    expected: {}", row.line(), row.case.expect));
            }
        }
    }
    assert!(beyond.is_empty(), "{} cases are beyond their bounds:\n{}", beyond.len(), beyond.join("\n"));
}

/// The table can fail: a number beyond its bound, no number, and an error.
#[test]
fn what_is_beyond_its_bound_is_told() {
    let kind = Kind { why: "", expect: "", reason: "" };
    let held = |measure: fn() -> case::Measured| Row::of(kind.case("", 1.0, measure)).holds();
    assert!(held(|| Ok(1.0)));
    assert!(
        !held(|| Ok(1.0_f64.next_up())) && !held(|| Ok(f64::NAN)) && !held(|| Err(rattle::Error::Order(0)))
    );
}

#[test]
fn the_page_lists_the_rows_of_the_table() {
    let row = |area: &'static str| move |case: Case| (area.to_string(), case.name);
    let table: Vec<_> =
        areas().into_iter().flat_map(|area| area.cases.into_iter().map(row(area.name))).collect();
    let page = std::fs::read_to_string(page_on_disk()).unwrap();
    let hint = "`cargo long --test cases suite::page -- --ignored` writes the page anew";
    assert_eq!(case::listed(&page), table, "{hint}");
    assert_eq!(table.iter().collect::<BTreeSet<_>>().len(), table.len(), "names are different");
}

#[test]
#[ignore = "writes docs/hard-cases.md: cargo long"]
fn page() {
    let rows = measured();
    let number: usize = rows.iter().map(|(_, rows)| rows.len()).sum();
    let all: usize = areas().iter().map(|area| area.cases.len()).sum();
    assert_eq!(number, all, "some rows take long: `cargo long --test cases suite::page -- --ignored`");
    let beyond: Vec<_> =
        rows.iter().flat_map(|(_, rows)| rows).filter(|row| !row.holds()).map(Row::line).collect();
    assert!(beyond.is_empty(), "no page of a table that does not hold:\n{}", beyond.join("\n"));
    std::fs::write(page_on_disk(), case::page(&rows)).unwrap();
}
