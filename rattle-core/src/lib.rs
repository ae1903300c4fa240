//! The runtime of `rattle`: scenes of constrained bodies, the methods that move them, and what is kept
//! of a run. Draws in nothing for files, plots or progress.

pub mod bodies;
pub mod composition;
pub mod counted;
pub mod curvature;
pub mod effect;
pub mod error;
pub mod geodesic;
pub mod guess;
pub mod kernel;
pub mod leapfrog;
pub mod linked;
pub mod lobatto;
pub mod network;
pub mod position_verlet;
pub mod rattle;
pub mod real;
pub mod recorder;
pub mod rigid;
pub mod scene;
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
mod vector;

pub use nalgebra;
pub use solver::START_TOLERANCE;
