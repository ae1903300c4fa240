//! Which change is on: that of the number in `MUTANT`. With `reach` there, `REACHED` is a file that takes the numbers
//! of all that are asked for.

#![allow(missing_docs)]

use std::io::Write;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};

const UNKNOWN: u32 = u32::MAX;
const REACH: u32 = u32::MAX - 1;
static WHICH: AtomicU32 = AtomicU32::new(UNKNOWN);
static REACHED: [AtomicBool; 16_384] = [const { AtomicBool::new(false) }; 16_384];

#[inline(always)]
pub fn on(n: u32) -> bool {
    let which = WHICH.load(Relaxed);
    if which < REACH { which == n } else { slow(n) }
}

#[cold]
#[inline(never)]
fn slow(n: u32) -> bool {
    if WHICH.load(Relaxed) == UNKNOWN {
        let which = std::env::var("MUTANT").unwrap_or_default();
        let which = if which == "reach" { REACH } else { which.parse().unwrap_or(0) };
        WHICH.store(which, Relaxed);
        if which != REACH {
            return which == n;
        }
    }
    if !REACHED[n as usize].swap(true, Relaxed) {
        let path = std::env::var("REACHED").expect("a file");
        let mut file = std::fs::OpenOptions::new().append(true).create(true).open(path).expect("to open");
        writeln!(file, "{n}").expect("to write");
    }
    false
}
