//! Ensembles: many independent trajectories of one scene, several at a time in SIMD lanes, on all cores.
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
//! **What is computed in lanes.** On a processor with fused multiply-add, a SIMD instruction computes the same step for
//! several trajectories, one in each lane of a register. This is done for
//!
//! * one body of up to 16 coordinates on a surface with one equation, moved by RATTLE, position Verlet, Geodesic
//!   RATTLE, a composition of one of them, [`Baoab`](crate::methods::baoab::Baoab), symplectic Euler, a Lobatto
//!   method, [`Dop853`](crate::methods::dop853::Dop853) or [`Taylor`](crate::methods::taylor::Taylor); except for the
//!   last four also with [flows](crate::effect::Flow) of momenta, such as heat, drag and magnetic fields, unless they
//!   [feel forces](crate::effect::Flow::FEELS_FORCES) or have a memory;
//! * linked bodies, up to 16 384 numbers of one trajectory (chains of some 400 links in space), moved by the same
//!   methods, always in double precision; also with flows of momenta, of the same kinds. Exceptions are links that
//!   move, have kinks or act on chosen coordinates; masses that are matrices;
//!   [`LinearAlgebra::Orthogonal`](crate::systems::network::LinearAlgebra::Orthogonal); and sweeps over networks of
//!   different topologies, or with other bodies pinned;
//! * any number of [rigid bodies](crate::systems::rigid::Rigid), moved by the methods of linked bodies except
//!   Lobatto's, always in double precision; also with flows of momenta, of the same kinds;
//! * any number of bodies in [phase space](crate::systems::phase) of up to 16 coordinates under up to four equations;
//!   more equations allow fewer coordinates (15 under five, 10 under eight); moved by RATTLE or a composition of it,
//!   always in double precision with compensated sums.
//!
//! The first three also by [`Brownian`](crate::methods::brownian::Brownian), without flows.
//!
//! All other scenes and methods run as one simulation per trajectory (see
//! [`Simulation`](crate::run::simulation::Simulation)), spread over all cores. [`Ensemble::plan`] says which, and why.
//!
//! **The same numbers everywhere.** A trajectory depends on its start alone. It is the same, bit for bit, whatever the
//! other trajectories, the number of threads, the division of a run into calls, and the instruction set, if that has
//! fused multiply-add (see [`InstructionSet::fuses`]). One exception: near other sheets of a surface, where a
//! long step of `Dop853`, `Taylor` or a Lobatto method or a strong force in Brownian motion looks as if they were near,
//! and where a flow ends a trajectory, some steps are made by the trajectory alone. Which these are depends on the
//! division into calls and on the steps after which the ensemble is shown, and with it last bits do; where inner steps
//! follow from a tolerance, digits below that.
//!
//! **Lanes and simulations agree to rounding,** not bit for bit. In lanes the position equation is solved by Newton's
//! method from multipliers extrapolated from the last steps, whatever [`guess`](crate::methods::rattle::Rattle::guess)
//! and [`solved_by`](crate::methods::rattle::Rattle::solved_by) say; Lobatto methods begin with the stages of the step
//! before, rigid bodies with a rotation extrapolated likewise; in phase space guesses are those of a simulation. For
//! the same reason an ensemble that starts from the states of another one agrees with it only to rounding: it does not
//! know the earlier steps. In a [`Single`] ensemble a tolerance counts as four roundings of places at least. States of
//! a [`Single`] ensemble satisfy the constraint to seven digits; `scene.project` turns them into starts.
//!
//! **Functions.** Every function of the macros is available in lanes, as [straight-line code](crate::number::lanes) of
//! 20 to 90 operations. Values differ from those of the system's mathematical library by rounding. sin, cos and tan of
//! an angle beyond 2⁴⁰ are NaN in lanes, so such a trajectory fails.
//!
//! **A trajectory that fails** stays at the state before the failed step, and its [error](Ensemble::failure) says why;
//! the others continue. With [`Ensemble::retry`] the failed step is repeated in parts.

mod alone;
mod apart;
mod around;
mod asked;
mod block;
mod by_itself;
mod collocation_lanes;
mod crossing;
mod dop853_lanes;
mod dop853_row;
mod engine;
mod forces_in_lanes;
mod group;
mod grouping;
mod grouping_kinds;
mod grouping_rows;
mod inside;
mod lane_record;
mod laws;
mod linked_collocation;
mod linked_few;
mod linked_going;
mod linked_lanes;
mod linked_law;
mod linked_look;
mod linked_plan;
mod linked_projected;
mod linked_projected_lanes;
mod linked_projected_row;
mod linked_row;
mod linked_series;
mod linked_series_law;
mod linked_stages;
mod linked_stand;
mod linked_stirred;
mod linked_stirring;
mod look;
mod loops;
mod pace;
mod phase_energy;
mod phase_fibre;
mod phase_hidden;
mod phase_lanes;
mod phase_numbers;
mod phase_row;
mod phase_step;
pub mod precision;
mod projected;
mod projected_lanes;
mod projected_row;
mod renewed_lanes;
mod rest;
mod rhythm;
mod rigid_going;
mod rigid_lanes;
mod rigid_law;
mod rigid_projected;
mod rigid_projected_lanes;
mod rigid_row;
mod rigid_series;
mod rigid_stages;
mod rigid_stand;
mod rigid_stirring;
mod row;
mod series_in_lanes;
mod side_by_side;
mod side_by_side_record;
mod splits;
mod splitting_lanes;
mod stages;
mod stirred;
mod stirring;
pub mod stream;
mod taylor_lanes;
mod taylor_row;
mod track;
pub mod trajectories;
mod until;
mod watching;

use crate::number::lanes::Fused;
use crate::number::vectors::LANES;
use crate::systems::network::in_lanes::{FEW, ROW};

pub use crate::number::instructions::InstructionSet;
pub use apart::{NotInLanes, Plan};
pub use precision::{Compensated, Double, Precision, Single};
pub(in crate::run) use side_by_side::STRETCH;
pub use stream::Snapshot;
pub use trajectories::Ensemble;

/// Functions that are compiled in this crate, see [`crate::instances`].
pub(crate) fn instances<const D: usize>() -> impl Copy {
    [
        side_by_side::side_by_side::<D> as *const (),
        splitting_lanes::in_lanes::<Fused<f64>, D> as *const (),
        splitting_lanes::out_of_lanes::<Fused<f64>, D> as *const (),
        splitting_lanes::in_lanes::<f64, D> as *const (),
        splitting_lanes::out_of_lanes::<f64, D> as *const (),
        asked::numbers::<Fused<f64>> as *const (),
        asked::square::<D> as *const (),
        lane_record::read::<Fused<f64>> as *const (),
        lane_record::write::<Fused<f64>> as *const (),
        block::Block::<Fused<f64>, 1, D, 0, false>::rows as *const (),
        block::Block::<Fused<f64>, 1, D, 0, true>::rows as *const (),
        block::Block::<Fused<f64>, LANES, D, 0, false>::rows as *const (),
        block::Block::<Fused<f64>, LANES, D, 0, true>::rows as *const (),
        stirring::Stirring::<Fused<f64>, 1, D>::act as *const (),
        stirring::Stirring::<Fused<f64>, 1, D>::clone as *const (),
        stirring::Stirring::<Fused<f64>, LANES, D>::clone as *const (),
        stirring::Stirring::<Fused<f64>, LANES, D>::act as *const (),
        block::Part::of::<false> as *const (),
        block::Part::of::<true> as *const (),
        linked_plan::LinkedPlan::of::<D> as *const (),
        linked_plan::masses::<D> as *const (),
        grouping::in_rows::<D> as *const (),
        linked_lanes::bodies_of::<D, FEW> as *const (),
        linked_lanes::bodies_of::<D, ROW> as *const (),
        trajectories::beyond::<D> as *const (),
        Ensemble::<D>::push as *const (),
        Ensemble::<D>::run as *const (),
        Ensemble::<D>::run_until as *const (),
        Ensemble::<D>::run_watched as *const (),
        Ensemble::<D>::state as *const (),
        Ensemble::<D>::bill as *const (),
    ]
}
