//! Mechanics with constraints: write the constraint as mathematics, simulate it by methods that keep
//! its structure.
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
//! A macro differentiates the expression when it compiles and writes native functions for the value,
//! the gradient and second derivatives. [`Scene`] says what is simulated, a [`Stepper`] how: [`Rattle`],
//! a [`Composition`] of it, or another method. What a scene does not name costs nothing.
//!
//! What many need is ready-made: [`surfaces`], [`potentials`], and [`links`] between bodies. With the feature `serde` all of
//! them serialise; a type of your own does so by `#[derive(serde::Serialize, serde::Deserialize)]` inside its macro.
//!
//! Many trajectories of one scene go side by side in SIMD lanes and on all cores: [`Ensemble`].
//!
//! Signs and scales stand on one page: [`conventions`].

extern crate self as rattle; // the macros write `::rattle`, also in here

pub mod conventions;
#[cfg(feature = "data")]
pub mod data;
pub mod links;
#[cfg(feature = "plot")]
pub mod plot;
pub mod potentials;
mod ready_made;
pub mod surfaces;
#[cfg(feature = "view")]
pub mod view;

pub use rattle_core::{
    bdf2, bodies, composition, counted, curvature, dop853, effect, ensemble, error, guess, iteration, kernel,
    lanes, linked, lobatto, network, phase, real, recorder, scene, series, shadow, simulation, stepper,
    surface, system, taylor, variable,
};

pub use rattle_core::bdf2::Bdf2;
pub use rattle_core::composition::Composition;
pub use rattle_core::counted::Counted;
pub use rattle_core::dop853::Dop853;
pub use rattle_core::ensemble::Ensemble;
pub use rattle_core::error::Error;
pub use rattle_core::geodesic::Geodesic;
pub use rattle_core::leapfrog::Leapfrog;
pub use rattle_core::lobatto::Lobatto;
pub use rattle_core::network::{LinearAlgebra, Mass};
pub use rattle_core::position_verlet::PositionVerlet;
pub use rattle_core::rattle::Rattle;
pub use rattle_core::recorder::{Recorder, Trajectory};
pub use rattle_core::rigid::Rigid;
pub use rattle_core::scene::Scene;
pub use rattle_core::shake::Shake;
pub use rattle_core::simulation::Simulation;
pub use rattle_core::state::State;
pub use rattle_core::stepper::Stepper;
pub use rattle_core::symplectic_euler::SymplecticEuler;
pub use rattle_core::taylor::Taylor;
pub use rattle_core::variable::Variable;
pub use rattle_core::{START_TOLERANCE, nalgebra};
pub use rattle_macros::{constraint, hamiltonian, pair_potential, phase_constraint, potential};

/// What most programs use.
pub mod prelude {
    pub use crate::composition::{Composition, SUZUKI_1990_ORDER_4};
    pub use crate::effect::Over;
    pub use crate::ensemble::{Compensated, Double, Histogram, Mean, Section, Sight, Single};
    pub use crate::guess::{Extrapolated, LastMultiplier};
    pub use crate::iteration::{Broyden, Newton, Simplified, Symmetric};
    pub use crate::kernel::{Constraint, Hamiltonian, PairPotential, PhaseConstraint, Potential};
    pub use crate::recorder::{Recorder, Trajectory};
    pub use crate::{
        Bdf2, Dop853, Geodesic, Leapfrog, Lobatto, PositionVerlet, Rattle, Shake, SymplecticEuler, Taylor,
        Variable,
    };
    pub use crate::{Ensemble, LinearAlgebra, Rigid, Scene, Simulation, State, Stepper};
    pub use crate::{constraint, hamiltonian, pair_potential, phase_constraint, potential};
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
