//! The runtime of `rattle`: scenes of constrained bodies, the methods that move them, and observers of runs. It has no
//! dependency for files, plots or progress bars.
//!
//! Folders are layers: a file imports only from its own folder and from folders above it in this list.
//!
//! ```text
//! number  error           scalars, lanes, instruction sets; errors
//! kernel                  the functions that macros write, and their derivatives
//! effect  geometry        forces; curvature
//! motion                  the interface of systems and methods: bodies, state, system, method
//! solve                   solving position equations: when to stop, which root
//! systems │ methods       the systems, and the methods that move them; neither knows the other
//! scene                   constraints, bodies and effects
//! run                     simulations, ensembles, observers
//! instances               what is compiled here for all users
//! ```

pub mod effect;
pub mod error;
pub mod geometry;
mod instances;
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
