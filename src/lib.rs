//! Mechanics with constraints: write the constraint as mathematics, and simulate it by methods that keep the structure
//! of the equations of motion.
//!
//! ```
//! use rattle::prelude::*;
//!
//! constraint! {
//!     /// The Bernoulli lemniscate, inflated into a surface of genus two (for r < a⁴/4).
//!     pub struct Lemniscate { a, r }
//!
//!     |x, y, z| {
//!         let f = (x^2 + y^2)^2 - a^2 * (x^2 - y^2);
//!         f^2 + z^2 - r^2
//!     }
//! }
//!
//! potential! {
//!     /// Uniform gravity along −z.
//!     pub struct Gravity { g }
//!     |x, y, z| g * z
//! }
//!
//! fn main() -> Result<(), rattle::Error> {
//!     let scene = Scene::on(Lemniscate { a: 1.0, r: 1.0 / 6.0 }).with(Gravity { g: 1.0 });
//!     let start = State::at([0.0, 0.0, 1.0 / 6.0]).moving([1.0, 0.0, 0.0]);
//!     let mut simulation = scene.simulate(start, Rattle::new(0.01))?;
//!     simulation.run(2000)?;
//!     println!("q = {:?}, energy error = {:e}", simulation.position(), simulation.energy_error());
//!     # assert!(simulation.energy_error().abs() < 2e-2);
//!     Ok(())
//! }
//! ```
//!
//! A macro differentiates the expression when it compiles and writes native functions for the value, the gradient and
//! second derivatives. [`Scene`] says what is simulated, a [`Method`] how: [`Rattle`], a [`Composition`] of RATTLE
//! steps, or another. Effects that a scene does not name cost nothing.
//!
//! Ready-made are [`surfaces`], [`potentials`], and [`links`] between bodies. With the feature `serde` they can be
//! serialised; so can a type of your own with `#[derive(serde::Serialize, serde::Deserialize)]` inside its macro.
//!
//! An [`Ensemble`] computes many trajectories of one scene, several at a time in SIMD lanes, on all cores.
//!
//! All signs and scales: [`conventions`].

extern crate self as rattle; // the macros write `::rattle`, also in here

/// A program that ends with an error prints it by `Debug`: these say there what they say to a person.
#[allow(unused_macros, reason = "each feature has its errors")]
macro_rules! debug_as_display {
    ($($error:ty),*) => {$(
        impl std::fmt::Debug for $error {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                std::fmt::Display::fmt(self, f)
            }
        }
    )*};
}

mod base64;
pub mod checkpoint;
#[cfg(any(feature = "plot", feature = "view"))]
mod constant;
pub mod conventions;
#[cfg(feature = "data")]
pub mod data;
mod files;
pub mod links;
#[cfg(feature = "plot")]
pub mod plot;
pub mod potentials;
#[cfg(feature = "progress")]
pub mod progress;
mod ready_made;
#[cfg(feature = "data")]
pub mod record;
pub mod surfaces;
#[cfg(feature = "view")]
pub mod view;
pub mod vtu;
mod xml;

/// Methods: maps that take all bodies one step on. The traits to write one.
pub mod method {
    pub use rattle_core::methods::fixed::{Fixed, Map};
    pub use rattle_core::motion::failure::Failure;
    pub use rattle_core::motion::identity::Identity;
    pub use rattle_core::motion::method::{Method, Projecting, Renewal, Splitting, Stage, View};
    pub use rattle_core::motion::witness::Witness;
}

/// Systems: bodies, constraints and forces, as a method sees them. The traits to write one, and what a method gets.
pub mod system {
    pub use rattle_core::motion::affected::Affected;
    pub use rattle_core::motion::guarded::Guarded;
    pub use rattle_core::motion::measured::Measured;
    pub use rattle_core::motion::parts::{BodiesOf, ForceOf, Given, Parts, RoomOf};
    pub use rattle_core::motion::system::System;
}

pub use rattle_core::kernel::{counted, series};
pub use rattle_core::methods::{self, composition};
pub use rattle_core::motion::{bodies, capability, guess, iteration, need, state, table};
pub use rattle_core::number::{instructions, lanes, real};
pub use rattle_core::run::{bill, boxed, ensemble, price, simulation, watch};
pub use rattle_core::systems::{linked, network, phase, rigid, surface};
pub use rattle_core::{effect, error, geometry as curvature, kernel, scene};

pub use rattle_core::error::Error;
pub use rattle_core::kernel::counted::Counted;
pub use rattle_core::methods::baoab::Baoab;
pub use rattle_core::methods::bdf2::Bdf2;
pub use rattle_core::methods::brownian::Brownian;
pub use rattle_core::methods::composition::Composition;
pub use rattle_core::methods::dop853::Dop853;
pub use rattle_core::methods::geodesic::Geodesic;
pub use rattle_core::methods::leapfrog::Leapfrog;
pub use rattle_core::methods::lobatto::Lobatto;
pub use rattle_core::methods::nose_hoover::NoseHoover;
pub use rattle_core::methods::position_verlet::PositionVerlet;
pub use rattle_core::methods::rattle::Rattle;
pub use rattle_core::methods::shake::Shake;
pub use rattle_core::methods::symplectic_euler::SymplecticEuler;
pub use rattle_core::methods::taylor::Taylor;
pub use rattle_core::methods::variable::Variable;
pub use rattle_core::motion::method::Method;
pub use rattle_core::motion::state::State;
pub use rattle_core::run::boxed::BoxedSimulation;
pub use rattle_core::run::ensemble::Ensemble;
pub use rattle_core::run::simulation::Simulation;
pub use rattle_core::run::watch::{Observer, Trajectory};
pub use rattle_core::scene::Scene;
pub use rattle_core::systems::network::{LinearAlgebra, Mass};
pub use rattle_core::systems::rigid::Rigid;
pub use rattle_core::{START_TOLERANCE, nalgebra};
pub use rattle_macros::{constraint, force, hamiltonian, pair_potential, phase_constraint, potential};

/// The names that most programs use. It does not hold [`Error`], since programs often have an `Error` of their own, nor
/// the ready-made [`surfaces`], [`potentials`] and [`links`], nor the traits for writing [methods](crate::method),
/// [systems](crate::system) or [effects](crate::effect).
pub mod prelude {
    pub use crate::composition::{Coefficients, Composition, SUZUKI_1990_ORDER_4};
    pub use crate::curvature::Curvature;
    pub use crate::effect::{Kinds, Over};
    pub use crate::ensemble::{Compensated, Double, Precision, Single};
    pub use crate::guess::{Extrapolated, FromState, LastMultiplier};
    pub use crate::iteration::{Broyden, Newton, Simplified, Symmetric};
    pub use crate::kernel::{
        Constraint, DrivenPotential, ForceLaw, Hamiltonian, PairPotential, PhaseConstraint, Potential,
    };
    pub use crate::watch::{
        Each, Histogram, Mean, Observer, Progress, Section, ShadowEnergy, Sight, Trajectory,
    };
    pub use crate::{
        Baoab, Bdf2, Brownian, Dop853, Geodesic, Leapfrog, Lobatto, NoseHoover, PositionVerlet, Rattle,
        Shake, SymplecticEuler, Taylor, Variable,
    };
    pub use crate::{
        BoxedSimulation, Counted, Ensemble, LinearAlgebra, Mass, Method, Rigid, Scene, Simulation, State,
    };
    pub use crate::{constraint, force, hamiltonian, pair_potential, phase_constraint, potential};
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
