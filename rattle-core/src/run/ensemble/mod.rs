//! Ensembles: many independent trajectories of one scene, side by side in SIMD lanes, and on all cores.
//!
//! ```
//! # use rattle::{Scene, State, Rattle};
//! let free = Scene::points::<1>(1);
//! let starts = (0..100).map(|i| State::at([0.0]).moving([f64::from(i)]));
//! let mut ensemble = free.ensemble(starts, Rattle::new(0.5))?;
//! ensemble.run(2);
//! assert_eq!(ensemble.state(7).positions().next().unwrap().x, 7.0);
//! # Ok::<(), rattle::Error>(())
//! ```
//!
//! One body of up to 16 coordinates on a surface, moved by a splitting of kicks and drifts (RATTLE, position Verlet, symplectic Euler, Geodesic RATTLE) or a
//! composition of one, goes in lanes where the processor has fused multiply-add. All else goes trajectory by trajectory, as a [`Simulation`](crate::run::simulation::Simulation) each, on all cores.
//!
//! **The same numbers everywhere.** What a trajectory does depends on its start alone: not on the trajectories beside it,
//! on the number of threads, or on how a run is divided; nor on the instruction set, as long as it has fused multiply-add
//! (see [`InstructionSet::fuses`]). In lanes the position multiplier is first guessed from the last steps, so that
//! results agree with those of a simulation to rounding, not to the bit; and so does an ensemble started from the states of
//! another, which does not know the steps before. (Those of [`Single`] are on the surface to seven digits: `scene.project` them first.)
//! There Newton's method and that guess are used, whatever the method says of guesses and ways to solve.
//!
//! **Functions.** All that the macros know go in lanes: they are [straight-line code](crate::number::lanes) of 20 to 90 operations
//! each, and differ from those of the system's library by rounding. sin, cos and tan of angles beyond 2⁴⁰ are not a number
//! there: a trajectory ends.
//!
//! **A trajectory that fails** rests where it was before the step, and its [error](Ensemble::failure) says why; the others
//! go on. [`Ensemble::retry`] has it take that step in parts.

mod alone;
mod block;
mod engine;
pub mod group;
mod laws;
pub mod look;
mod loops;
pub mod precision;
mod side_by_side;
mod splitting_lanes;
pub mod stream;
pub mod trajectories;

pub use crate::number::instructions::InstructionSet;
pub use precision::{Compensated, Double, Precision, Single};
pub(in crate::run) use side_by_side::STRETCH;
pub use stream::Snapshot;
pub use trajectories::Ensemble;
