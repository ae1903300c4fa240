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
//! **What goes in lanes,** on a processor with fused multiply-add.
//!
//! * One body of up to 16 coordinates on a surface with one equation, moved by RATTLE, position Verlet, symplectic
//!   Euler, Geodesic RATTLE, a composition of one of them, or a Lobatto method.
//! * Any number of linked bodies, moved by the same methods but Lobatto's; always in double precision. Not where links
//!   move, have kinks, or act on chosen coordinates, where a mass is a matrix, for
//!   [`LinearAlgebra::Orthogonal`](crate::systems::network::LinearAlgebra::Orthogonal), and not in sweeps.
//!
//! Trajectories of all other scenes and methods are simulations each (see
//! [`Simulation`](crate::run::simulation::Simulation)), spread over all cores.
//!
//! **The same numbers everywhere.** A trajectory depends on its start alone. It is bit for bit the same for any
//! trajectories beside it, any number of threads, any division of a run, and any instruction set with fused
//! multiply-add (see [`InstructionSet::fuses`]).
//!
//! **Lanes and simulations agree to rounding,** and not bit for bit: in lanes the iteration begins with multipliers
//! extrapolated from the last steps, and is Newton's method, whatever [`guess`](crate::methods::rattle::Rattle::guess)
//! and [`solved_by`](crate::methods::rattle::Rattle::solved_by) of the method say. Lobatto methods begin with the
//! stages of the step before. For the same reason an ensemble that
//! starts from the states of another agrees with that to rounding: it does not know the steps before. States of a
//! [`Single`] ensemble are on the surface to seven digits; `scene.project` makes starts of them.
//!
//! **Functions.** Every function of the macros goes in lanes, as [straight-line code](crate::number::lanes) of 20 to 90
//! operations. Values differ from those of the system's library by rounding. sin, cos and tan of an angle beyond 2⁴⁰
//! are NaN in lanes, so such a trajectory fails.
//!
//! **A trajectory that fails** stays at the state before the failed step, and its [error](Ensemble::failure) says why;
//! the others go on. With [`Ensemble::retry`] the failed step is made again in parts.

mod alone;
mod around;
mod asked;
mod block;
mod collocation_lanes;
mod crossing;
mod engine;
pub mod group;
mod grouping;
mod laws;
mod linked_going;
mod linked_lanes;
mod linked_look;
mod linked_row;
pub mod look;
mod loops;
mod plan;
pub mod precision;
mod row;
mod side_by_side;
mod splitting_lanes;
mod stages;
pub mod stream;
pub mod trajectories;

pub use crate::number::instructions::InstructionSet;
pub use precision::{Compensated, Double, Precision, Single};
pub(in crate::run) use side_by_side::STRETCH;
pub use stream::Snapshot;
pub use trajectories::Ensemble;
