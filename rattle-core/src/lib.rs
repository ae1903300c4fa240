//! The runtime of `rattle`: scenes of constrained bodies, the methods that move them, and what is kept
//! of a run. Draws in nothing for files, plots or progress.

pub mod bdf2;
pub mod bodies;
pub mod composition;
pub mod counted;
pub mod curvature;
pub mod dop853;
pub mod effect;
pub mod ensemble;
pub mod error;
pub mod geodesic;
pub mod guess;
pub mod iteration;
pub mod kernel;
pub mod lanes;
pub mod leapfrog;
pub mod linked;
pub mod lobatto;
pub mod network;
mod pairs;
pub mod phase;
pub mod position_verlet;
pub mod rattle;
pub mod real;
pub mod recorder;
pub mod rigid;
pub mod scene;
pub mod series;
pub mod shadow;
pub mod shake;
pub mod simulation;
mod solver;
mod start;
pub mod state;
pub mod stepper;
pub mod surface;
pub mod symplectic_euler;
pub mod system;
pub mod taylor;
pub mod variable;
mod vector;

pub use nalgebra;
pub use solver::START_TOLERANCE;
