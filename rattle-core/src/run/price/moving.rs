//! Scenes and simulations with erased types, so that the code that measures them is compiled once.

use crate::error::Error;
use crate::run::price::candidate::Candidate;

/// A step of a method, or a step and a tolerance.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rung {
    pub(super) candidate: Candidate,
    pub(super) h: f64,
    pub(super) tolerance: f64,
}

/// A scene and its start, with what is observed.
pub(super) trait Movable {
    /// A simulation from the start.
    fn begin(&self, rung: Rung) -> Result<Box<dyn Moving + '_>, Error>;
    /// The same from a start whose momenta are off by about this much.
    fn begin_beside(&self, rung: Rung, off: f64) -> Result<Box<dyn Moving + '_>, Error>;
    /// Names of what is observed.
    fn names(&self) -> Vec<String>;
    /// Coordinates of a body.
    fn dimension(&self) -> usize;
    /// Whether flows act on momenta.
    fn flows(&self) -> bool;
    /// Whether something does work: [flows that do](crate::effect::Flow::WORKS), or what moves or acts with time. The
    /// energy beside the work done then says nothing of the energy, since errors of the two cancel.
    fn works(&self) -> bool;
    /// How many trajectories go side by side; 0 where none are priced.
    fn trajectories(&self) -> usize;
}

/// A simulation, or trajectories side by side of which the first is looked at.
pub(super) trait Moving {
    fn again(&self) -> Result<Box<dyn Moving + '_>, Error>;
    fn run(&mut self, steps: u64) -> Result<(), Error>;
    /// Coordinates of all bodies in turn.
    fn positions(&self) -> Vec<f64>;
    /// The largest component of a momentum.
    fn largest_momentum(&self) -> f64;
    fn energy(&self) -> f64;
    fn energy_error(&self) -> f64;
    /// The kinetic energy, by which errors of the energy are measured. Without masses it is ½ Σ |pᵢ q̇ᵢ|: nobody says
    /// what of H is kinetic, and H has any zero. 0 where it is not asked for.
    fn kinetic_energy(&self) -> f64 {
        0.0
    }
    fn iterations(&self) -> Option<u64> {
        None
    }
    /// Values of what is observed.
    fn observed(&self) -> Vec<f64> {
        Vec::new()
    }
}
