//! The runtime of `rattle`: scenes of constrained bodies, the methods that move them, and what is kept
//! of a run. Draws in nothing for files, plots or progress.
//!
//! Folders are floors: a file imports from its own folder and from folders above it in this list.
//!
//! ```text
//! number  error           scalars, lanes, instructions; what can go wrong
//! kernel                  what a macro writes: functions of one place, and their derivatives
//! effect  geometry        forces; curvature
//! motion                  the contract: bodies, state, system, method
//! solve                   when a solve ends, which root, when constraints are reached: alike for all
//! systems │ methods       neither knows the other
//! scene                   what is simulated
//! run                     who goes on, and who watches
//! ```

pub mod effect;
pub mod error;
pub mod geometry;
pub mod kernel;
pub mod methods;
pub mod motion;
pub mod number;
pub mod run;
pub mod scene;
mod solve;
pub mod systems;

pub use motion::start::START_TOLERANCE;
pub use nalgebra;
