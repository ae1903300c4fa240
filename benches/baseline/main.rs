//! Ours against others: hand-written C and Rust, Numba and JAX, each in its best form, in one run.
//!
//! ```text
//! cargo bench --bench baseline                      C needs a compiler `cc`, Python the network once
//! cargo bench --bench baseline -- --rounds 3        quicker; 9 is usual
//! cargo bench --bench baseline -- --only chain      tasks of this name alone
//! cargo bench --bench baseline -- --callgrind       instructions per step instead, with valgrind
//! ```
//!
//! The task: trajectories from one point of the lemniscate surface in all directions under gravity, RATTLE with h =
//! 0.01, |g| ≤ 1e-14; the same by Lobatto of five stages, h = 0.025; the gas of 21 and of 1000 particles; a double
//! pendulum, alone and 10 000 side by side; a chain of 1000 links and a heavy top, each alone; 10 000 tops side by
//! side. Every opponent is a program that waits for requests;
//! they take turns in rounds, so that a change of the clock meets all. Times are CPU times; `ratio NAME VALUE` is the
//! median over rounds of their time by ours: above 1, ours is faster. Where an opponent has many variants, all are
//! timed once and the fastest go on. Before that, positions, energies and constraints are compared.

mod by_hand;
#[path = "../common/clock.rs"]
mod clock;
mod conversation;
mod linked;
mod ours;
mod programs;
mod tops;

use by_hand::{ByHand, Kind};
use conversation::{Run, serve};
use programs::Task;
use std::path::Path;

const HANDS: [&str; 2] = ["by_hand_previous", "by_hand_quadratic_chord"];

/// Names, trajectories or particles or links, steps.
const TASKS: [(&str, usize, u64); 10] = [
    ("one after the other", 500, 2000),
    ("side by side", 10_000, 2000),
    ("lobatto", 1000, 1000),
    ("gas of 21", 21, 5000),
    ("gas of 1000", 1000, 20),
    ("double pendulum", 1, 200_000),
    ("pendulums side by side", 10_000, 1000),
    ("chain of 1000", 1000, 150),
    ("heavy top", 1, 200_000),
    ("tops side by side", 10_000, 500),
];

const LEGEND: &str = "\
ns        CPU nanoseconds per trajectory (or particle) and step; by the clock for two threads
× ours    its time over ours, median over rounds
g, ∇g     evaluations of the constraint and of its gradient per step
max |g|   how far off the surface; opponents stop at 1e-14 (or as their name says), ours at the rounding floor
ΔE/K      largest deviation of the energy, by the mean kinetic energy: the method's own, the same for all
apart     largest difference of positions to the first row's, after few steps and after many
ratio     their time over ours, median over rounds: above 1, ours is faster (of two threads: our time on one over that on two)";

fn main() -> Result<(), String> {
    let arguments: Vec<String> = std::env::args().collect();
    let after = |flag: &str| arguments.iter().skip_while(move |word| *word != flag).nth(1);
    if let Some(what) = after("--serve") {
        if what == "trajectories" {
            serve(&[&ours::ROWS[..], &HANDS[..]].concat(), trajectories);
        } else if what == linked::PENDULUMS {
            let rows = [linked::PENDULUMS, linked::SUMS, linked::APART];
            serve(&rows, |row, n, _| linked::pendulums(row, n));
        } else if what == tops::TOPS {
            let rows = [tops::TOPS, tops::SUMS, tops::APART];
            serve(&rows, |row, n, _| tops::tops(row, n));
        } else if programs::LINKED.contains(&what.as_str()) {
            serve(&["linked"], |_, n, _| linked::linked(what, n));
        } else {
            let (h, positions) = ours::read_gas(Path::new(what));
            serve(&["gas"], |_, _, _| Some(ours::gas(h, &positions)));
        }
        return Ok(());
    }
    let programs = programs::Programs::make()?;
    if arguments.iter().any(|word| word == "--callgrind") {
        return programs.callgrind();
    }
    let rounds = after("--rounds")
        .map_or(Ok(9), |number| number.parse())
        .map_err(|why: std::num::ParseIntError| why.to_string())?;

    let only = after("--only");
    let mut tasks = Vec::new();
    for (name, n, steps) in TASKS {
        if only.is_none_or(|only| name.contains(only.as_str())) {
            tasks.push(Task { name, n, steps, entrants: programs.entrants(name)? });
        }
    }
    println!("{LEGEND}");
    for task in &mut tasks {
        task.compare()?;
        task.race(rounds)?;
    }
    for task in &tasks {
        task.ratios();
    }
    Ok(())
}

fn trajectories(row: &str, n: usize, counted: bool) -> Option<Box<dyn Run>> {
    match row {
        "by_hand_previous" => Some(Box::new(ByHand::new(Kind::Previous, n))),
        "by_hand_quadratic_chord" => Some(Box::new(ByHand::new(Kind::QuadraticChord, n))),
        _ => ours::ours(row, n, counted),
    }
}
