//! Random motions near other sheets, counted by how they ended.

use rattle::prelude::*;
use rattle::system::System;
use rattle::{Error, Simulation};
use std::fmt::Display;

/// How motions ended: on their own sheet, refused with an error of a step, on another sheet.
#[derive(Debug, Default, Clone, Copy, PartialEq)]
pub struct Outcome {
    pub right: u32,
    pub refused: u32,
    pub wrong: u32,
}

impl Outcome {
    /// One that ended so far off its sheet, which may be as far as the tolerance.
    pub fn note(&mut self, off: f64, failure: Option<&Error>, tolerance: f64) {
        match failure {
            None if off <= tolerance => self.right += 1,
            Some(Error::Step { .. }) if off <= tolerance => self.refused += 1,
            None | Some(Error::Step { .. }) => self.wrong += 1,
            Some(other) => panic!("{other}"),
        }
    }

    /// One that takes so many steps, or is refused, or is told by its name where a step leaves it off its sheet.
    pub fn watch<Y: System<f64, D>, S: Method, const D: usize>(
        &mut self,
        name: impl Display,
        mut simulation: Simulation<Y, S, D>,
        steps: u64,
        off: impl Fn(&Simulation<Y, S, D>) -> f64,
        tolerance: f64,
    ) {
        while simulation.steps() < steps {
            if let Err(error) = simulation.step() {
                return self.note(0.0, Some(&error), tolerance);
            }
            let off = off(&simulation);
            if off.is_nan() || off > tolerance {
                println!("{name}: {off:e} off after {} steps", simulation.steps());
                return self.note(off, None, tolerance);
            }
        }
        self.note(0.0, None, tolerance);
    }

    /// None is wrong, and so many are not refused.
    pub fn check(&self, right: u32) {
        println!("{self:?}");
        assert!(self.wrong == 0 && self.right >= right, "{self:?}");
    }
}
